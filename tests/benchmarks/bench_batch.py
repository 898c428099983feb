"""How much of a batch is spent outside the checks: 1,000 small programs, as a user starts them.

    python tests/benchmarks/bench_batch.py --jobs 2 --json results.json

`outside_checks` is 1 - (time of all checks) / (workers * time of the whole command): starting
Python and the workers, finding and hashing the programs, passing jobs and records, writing results.
`outside_after_start` leaves out what the same command takes for one program per worker: it is the
share that stays when a batch grows. The package is compiled to bytecode first, as pip does when it
installs one: a checkout on which Python may write no bytecode compiles it anew in every process.
"""

from __future__ import annotations

import argparse
import datetime
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

STARTS = 3
SAMPLES = Path(__file__).parents[2] / "samples"


def write_programs(folder: Path, count: int) -> None:
    """Programs of a few dozen to a hundred blocks, each with a first line of its own."""
    texts = [(SAMPLES / f"{name}.nc").read_text() for name in ("part", "clear", "long_drill")]
    for number in range(count):
        text = f"(PROGRAM {number})\n{texts[number % len(texts)].lstrip('%').lstrip()}"
        (folder / f"{number}.nc").write_text(text)


def run(count: int, jobs: int, bytecode: str) -> tuple[float, float]:
    """Run one batch; time of the whole command, and of all its checks [s]."""
    env = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    env["PYTHONPYCACHEPREFIX"] = bytecode
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_programs(folder, count)
        options = ["--machine", "table_tilt", "--out", "r.jsonl"]
        command = [sys.executable, "-m", "gcodesim", "batch", ".", "--jobs", str(jobs), *options]
        begin = time.perf_counter()
        done = subprocess.run(
            command, cwd=folder, env=env, check=False, capture_output=True, text=True
        )
        wall = time.perf_counter() - begin
        lines = (folder / "r.jsonl").read_text().splitlines()
    seconds = [record["seconds"] for record in map(json.loads, lines[1:])]
    assert len(seconds) == count, done.stderr
    return wall, sum(seconds)


def measure(count: int, jobs: int) -> dict[str, Any]:
    """Run batches, and compare the time of the checks with that of the command."""
    with tempfile.TemporaryDirectory() as bytecode:
        run(jobs, jobs, bytecode)
        starts = [run(jobs, jobs, bytecode) for _ in range(STARTS)]
        wall, checks = run(count, jobs, bytecode)
    start = statistics.median(own - checked / jobs for own, checked in starts)
    return {
        "schema": "gcodesim.bench-batch/1",
        "date": str(datetime.datetime.now(datetime.UTC).date()),
        "machine": platform.machine(),
        "load": round(os.getloadavg()[0], 1),
        "programs": count,
        "jobs": jobs,
        "wall_s": round(wall, 2),
        "start_s": round(start, 2),
        "check_mean_ms": round(1e3 * checks / count, 1),
        "outside_checks": round(1.0 - checks / (jobs * wall), 4),
        "outside_after_start": round(1.0 - checks / (jobs * (wall - start)), 4),
    }


def main() -> None:
    """Print the figures, and write them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--programs", type=int, default=1000)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--json", help="write the figures to this file")
    given = parser.parse_args()
    figures = json.dumps(measure(given.programs, given.jobs), indent=1)
    print(figures)
    if given.json:
        Path(given.json).write_text(figures + "\n")


if __name__ == "__main__":
    main()
