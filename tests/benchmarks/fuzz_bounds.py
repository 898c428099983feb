"""Chord bounds of random chains, computed by the search's own code, against what is true.

Run from the repository root: python tests/benchmarks/fuzz_bounds.py [--chains N] [--seed S]
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from collision.chord_bounds import SLACK_MM, compare, random_chords

from gcodesim.collision.bounds.motion_bounds import common_frame


def main() -> int:
    """Count violations and tell how sharp the bound is; exit code 1 where it is violated."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--chains", type=int, default=100_000, help="pairs of links")
    parser.add_argument("--seed", type=int, default=0, help="of the first machine")
    parser.add_argument("--directions", type=int, default=4, help="tried on every chain")
    options = parser.parse_args()
    chains = chords = violations = 0
    worst, sharpness, seed = -np.inf, [], options.seed
    while chains < options.chains:
        rng = np.random.default_rng([9, seed])
        c = random_chords(rng)
        frames = [common_frame(c.machine.joints, *links) for links in c.scene.links]
        tried = [compare(c, rng, frames) for _ in range(options.directions)]
        excess = np.max([t.excess for t in tried], axis=0)
        if excess.max() > SLACK_MM:
            violations += int((excess > SLACK_MM).sum())
            print(f"machine {seed}: {excess.max():.3e} mm beyond the bound", flush=True)
        worst = max(worst, float(excess.max()))
        moving = c.leaves > 1e-6
        sharpness.append(np.max([t.sharpness for t in tried], axis=0)[moving])
        chains += len(frames)
        chords += excess.size
        seed += 1
    part = np.concatenate(sharpness)
    print(
        f"{chains} chains, {chords} chords, {violations} violations, largest excess {worst:.2e} mm"
    )
    quantiles = ", ".join(f"p{q} {np.quantile(part, q / 100):.3f}" for q in (50, 95, 99, 100))
    print(f"actual / bound: {quantiles}")
    return int(violations > 0)


if __name__ == "__main__":
    sys.exit(main())
