"""The speed of the exhaustive method, of the interpreter and of a warm start.

Run from the repository root: python tests/benchmarks/bench_exhaustive.py [--out FILE]
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

from goals import SAMPLES, Goals

from gcodesim.constants import DEFAULT_PERIOD_PS
from gcodesim.machine.control_data import control_for
from gcodesim.machine.loading import load_machine
from gcodesim.motion.planner import plan
from gcodesim.nc.interpret import interpret
from gcodesim.nc.lines import read_program
from gcodesim.study.clock import time_runs
from gcodesim.study.job import exhaustive_job, longest_job

FINISH, MACHINE = SAMPLES / "five_axis_finish.nc", "table_tilt"
EVERY = 25
"""Every 25th sample is looked at: cost per sample does not depend on the period."""

SHORT = (
    "G21 G90\nT1 M6\nS1000 M3\nG0 X20. Y10.\nG0 Z450.\nG1 Z400. F500.\nX30.\nY20.\nG0 Z450.\nM30\n"
)


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, help="JSON file to write")
    options = parser.parse_args()
    goals = Goals("bench_exhaustive")
    machine, text = load_machine(MACHINE), read_program(str(FINISH))
    control = control_for(machine, None, None, False)
    interpreted, meaning = time_runs(lambda: interpret(text, control, FINISH.name))
    job = longest_job(plan(meaning.program, machine)[0], machine, DEFAULT_PERIOD_PS)
    job = replace(job, period_ps=EVERY * DEFAULT_PERIOD_PS)
    searcher = job.searcher(job.scene("cpu"), threads=1, between=False)
    timing, answer = time_runs(lambda: exhaustive_job(searcher))
    per_sample = timing.median / (answer.end_ps // job.period_ps + 1) * 1e6
    note = f"best {timing.least / job.samples * 1e6:.1f}"
    goals.at_most("exhaustive per sample, 8 pairs", per_sample, 150.0, "us", note)
    goals.at_most("the same, goal beyond", per_sample, 50.0, "us")
    goals.at_least("interpreter", meaning.blocks / interpreted.median, 30_000, "blocks/s")
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "short.nc"
        program.write_text(SHORT)
        command = [sys.executable, "-m", "gcodesim", "check", str(program), "--machine", MACHINE]
        started, _ = time_runs(lambda: subprocess.run(command, check=True, capture_output=True))
    note = f"best {started.least:.3f}"
    goals.at_most("warm start: check of a 10-block program", started.median, 1.8, "s", note)
    goals.write(options.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
