"""Random programs by the search against the exhaustive method, in every way it can be cut up.

Four in five trials are marginal: the tool just touches, or just does not. Run from the repository
root: python tests/benchmarks/fuzz_search.py [--count N] [--seed S]
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from collision.random_programs import Setup, Trial, answer, marginal_trial, random_trial, run

from gcodesim.constants import TOLERANCE_MM

SETUPS = (
    Setup(level=0),
    Setup(level=3, chunk=8, batch=8),
    Setup(level=6, chunk=64, batch=64),
    Setup(level=6, chunk=4096, batch=512, threads=2),
    Setup(level=3, chunk=16, batch=8, threads=2),
)


def main() -> int:
    """Compare, print disagreements with their seed and margin; exit code 1 where there are any."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=500, help="trials")
    parser.add_argument("--seed", type=int, default=0, help="first seed")
    parser.add_argument("--device", default="cpu", help="cpu, cuda or cuda:N")
    options = parser.parse_args()
    contacts = between = wrong = 0
    for seed in range(options.seed, options.seed + options.count):
        rng = np.random.default_rng(seed)
        margin = float(rng.choice([1, -1]) * 10 ** rng.uniform(-7, 0.5))
        marginal = rng.random() < 0.8
        trial = marginal_trial(seed, margin) if marginal else random_trial(seed)
        expected = answer(run(trial, "exhaustive", device=options.device))
        proved = answer(run(trial, between=True, device=options.device))
        contacts += expected is not None
        between += proved != expected
        for complaint in _complaints(trial, options.device):
            wrong += 1
            how = f"marginal_trial({seed}, {margin!r})" if marginal else f"random_trial({seed})"
            print(f"{how}: {complaint}", flush=True)
    print(
        f"{options.count} trials: {contacts} with a contact at a sample, {between} with another "
        f"answer between samples, {wrong} disagreements"
    )
    return int(wrong > 0)


def _complaints(trial: Trial, device: str) -> list[str]:
    expected = answer(run(trial, "exhaustive", device=device))
    found = run(trial, device=device)
    proof = run(trial, between=True, device=device)
    complaints = []
    if answer(found) != expected:
        complaints.append(f"exhaustive {expected}, search {answer(found)}")
    if answer(proof) != expected:
        c = proof.contact
        if c is None or not c.between or c.distance > TOLERANCE_MM + 1e-6:
            complaints.append(f"exhaustive {expected}, between samples {answer(proof)}")
        elif expected is not None and (c.sample, c.pair.name) >= expected[:2]:
            complaints.append(f"exhaustive {expected} comes before {answer(proof)}")
    for detection in (found, proof):
        if any(findings.overflows for findings in detection.findings):
            complaints.append("a stack was full")
    for setup in SETUPS:
        for usual, between in ((found, False), (proof, True)):
            other = answer(run(trial, between=between, setup=setup, device=device))
            if other != answer(usual):
                complaints.append(f"{setup}, between={between}: {other} instead of {answer(usual)}")
    return complaints


if __name__ == "__main__":
    sys.exit(main())
