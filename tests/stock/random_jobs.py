"""Random jobs: programs of cuts and rapids about a small stock, with three or five axes.

Run as a script for many: PYTHONPATH=.:tests python tests/stock/random_jobs.py [count] [first seed]
"""

from __future__ import annotations

import sys
from dataclasses import dataclass

import numpy as np
from stock import milling
from stock.twin import first_voxel, is_witnessed

from gcodesim.machine.model import Machine
from gcodesim.stock.workpiece import StockAnswer

BOX = np.array([[0.0, 0.0, -16.0], [32.0, 32.0, 0.0]])
BLANK = "box: {size: [32, 32, 16], center: [16, 16, -8]}"
MACHINE = milling.MILL.replace("point: [50, 50, 0]", "point: [16, 16, 0]")


@dataclass(frozen=True)
class Job:
    """A program on a machine."""

    machine: Machine
    program: milling.Program


def random_job(seed: int) -> Job:
    """A job; odd seeds turn table and head."""
    rng = np.random.default_rng(seed)
    radius = rng.uniform(2.0, 5.0)
    flute = rng.uniform(2.2 * radius, 16.0)
    make = [milling.end_mill, milling.ball_mill][rng.integers(2)]
    shank = radius * rng.choice([0.9, 1.0, 1.0, 1.02])
    tool = make(radius, flute, shank, flute + rng.uniform(2.0, 12.0), rng.uniform(8.0, 14.0))
    program, turns = milling.Program(), seed % 2
    program.move(16, 16, 20, 0, 0)
    for _ in range(rng.integers(6, 14)):
        x, y = rng.uniform(-4, 36, 2)
        z = rng.uniform(-15, 2)
        tilt = (rng.uniform(-40, 40), rng.uniform(-90, 90)) if turns else (0.0, 0.0)
        kind = rng.random()
        if kind < 0.15:
            program.move(program.at[0], program.at[1], 6.0, *program.at[3:])
            program.move(x, y, 6.0, *tilt)
        elif kind < 0.3:
            program.move(*program.at[:2], z, *program.at[3:], feed=400)
        elif kind < 0.45:
            program.move(x, y, z, *tilt)
        else:
            program.move(x, y, z, *tilt, feed=1500)
    program.move(program.at[0], program.at[1], 20.0, *program.at[3:])
    return Job(milling.mill(tool, blanks=BLANK, machine=MACHINE), program)


def verdict(job: Job, size: float = 1.0) -> tuple[str, StockAnswer]:
    """What the race says beside its twin: agrees, missed, false, later or undecided."""
    answer = milling.raced(job.program, job.machine)
    path, inset = milling.path_of(job.program, job.machine), job.machine.stock_inset
    seen = first_voxel(job.machine, path, "C", BOX, size, inset + 0.01)
    if not answer.events:
        word = "undecided" if answer.undecided else "missed" if seen else "agrees"
        return word, answer
    event = answer.events[0]
    if not is_witnessed(event, job.machine, path, "C", inset):
        return "false", answer
    if seen and event.time_ps > seen[0] + 3 * 10**8:
        return "later", answer
    return "agrees", answer


def main() -> None:
    """Print what became of many jobs."""
    count, first = (int(v) for v in (*sys.argv[1:], 500, 0)[:2])
    tally: dict[tuple[str, bool], int] = {}
    for seed in range(first, first + count):
        word, answer = verdict(random_job(seed))
        key = word, bool(answer.events)
        tally[key] = tally.get(key, 0) + 1
        if word != "agrees":
            print(seed, word, [(e.part.name, e.time_ps, e.point, e.depth) for e in answer.events])
    for (word, found), number in sorted(tally.items()):
        print(f"{word}, {'contact' if found else 'clear'}: {number}")


if __name__ == "__main__":
    main()
