"""Misses, false alarms and speed of `gcodesim.triangles_intersect` on the adversarial families.

Run from the repository root: python tests/benchmarks/bench_triangles.py [--count N] [--device D]
"""

from __future__ import annotations

import argparse
import json
import math
import multiprocessing
import statistics
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from hard_pairs import EVERY_FAMILY, generate
from numpy.typing import NDArray

from gcodesim.study.exact import label, squared_clearance
from gcodesim.study.families import Array

SEED = 1
WORKERS = 2
REPEATS = 7
# Pairs labelled between two progress lines of one worker.
CHUNK = 2000

Verdicts = NDArray[np.bool_]


def main() -> int:
    """Measure every family, print a table, write JSON; exit code 1 where a contact was missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100_000, help="pairs per family")
    parser.add_argument("--device", default="cpu", help="auto, cpu, cuda or cuda:N")
    parser.add_argument("--out", type=Path, help="JSON file to write")
    options = parser.parse_args()

    from gcodesim import triangles_intersect

    def test(a: Array, b: Array) -> Verdicts:
        return np.asarray(triangles_intersect(a, b, device=options.device))

    print("family     pairs intersecting  missed   false  largest clearance    ns/pair")
    rows = []
    # Spawned, not forked: a forked child of a process with Warp's threads may hang.
    with multiprocessing.get_context("spawn").Pool(WORKERS) as pool:
        for family in EVERY_FAMILY:
            a, b = generate(family, options.count, SEED)
            row: dict[str, Any] = {"family": family}
            row |= _compare(a, b, _truth(pool, family, a, b), test)
            rows.append(row)
            print(
                "{family:6} {pairs:9} {intersecting:12} {missed:7} {false:7} "
                "{largest_false_clearance:18.2e} {ns_per_pair:10.1f}".format(**row),
                flush=True,
            )
    if options.out:
        report = {"device": options.device, "seed": SEED, "families": rows}
        options.out.write_text(json.dumps(report, indent=1) + "\n")
    return int(any(row["missed"] for row in rows))


def _truth(pool: Any, family: str, a: Array, b: Array) -> Verdicts:
    """Label the pairs exactly in the pool, with a progress line on stderr."""
    chunks = [(a[i : i + CHUNK], b[i : i + CHUNK]) for i in range(0, len(a), CHUNK)]
    labels: list[Verdicts] = []
    for part in pool.imap(_label_chunk, chunks):
        labels.append(part)
        if sys.stderr.isatty():
            print(
                f"{family}: {len(labels)} of {len(chunks)}", end="\r", file=sys.stderr, flush=True
            )
    return np.concatenate(labels)


def _label_chunk(pairs: tuple[Array, Array]) -> Verdicts:
    return label(*pairs)


def _compare(
    a: Array, b: Array, truth: Verdicts, test: Callable[[Array, Array], Verdicts]
) -> dict[str, int | float]:
    """Return counts, the exact largest clearance of a false alarm and the median time of a pair.

    The clearance is in the unit of the family: mm, for F11 metres. The first call, which compiles,
    is not timed; the time includes the copies to the device and back.
    """
    found = test(a, b)
    seconds = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        test(a, b)
        seconds.append(time.perf_counter() - start)
    false = np.flatnonzero(found & ~truth)
    clearances = [math.sqrt(squared_clearance(a[i], b[i])) for i in false]
    return {
        "pairs": len(a),
        "intersecting": int(truth.sum()),
        "missed": int((truth & ~found).sum()),
        "false": len(false),
        "largest_false_clearance": max(clearances, default=0.0),
        "ns_per_pair": statistics.median(seconds) / len(a) * 1e9,
    }


if __name__ == "__main__":
    sys.exit(main())
