"""The speed of planning, from canonical moves to pieces of joint motion, by motion and time law.

The goal is GOAL blocks per second, or ten times the speed of the search that is fed, if that is
slower: a move of the tip may become many pieces. Blocks are those of the program; times are
processor times of one core, the best of three. Run from the repository root:
python tests/benchmarks/bench_planning.py [--out FILE] [--scale S]
"""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).resolve().parent))

from goals import ROOT, Goals

from gcodesim.checking.flow import check_program
from gcodesim.checking.options import Options
from gcodesim.machine.control_data import control_for
from gcodesim.machine.loading import load_machine
from gcodesim.machine.model import Machine
from gcodesim.motion.planner import plan
from gcodesim.nc.interpret import interpret

Array = NDArray[np.float64]

ROUNDS, SEED, GOAL = 3, 1, 300_000
LAWS = ("constant", "acceleration", "jerk")

ACCELERATION, JERK = 4000.0, 5e4
"""Of every axis [mm/s^2, mm/s^3; deg alike]."""

CLEAR = 150.0
"""Height of the tip above the table that keeps the moves of the tip free of contact [mm]."""


def main() -> int:
    """Measure every motion under every law, and the tip motions under the constant one."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, help="JSON file to write")
    parser.add_argument("--scale", type=float, default=1.0, help="size of the programs")
    options = parser.parse_args()
    goals, count = Goals("bench_planning"), int(200_000 * options.scale)
    machine = load_machine(str(ROOT / "machines" / "table_tilt.yaml"))
    limited = tuple(
        replace(joint, max_acceleration=ACCELERATION, max_jerk=JERK) for joint in machine.joints
    )
    for name, motion in MOTIONS.items():
        points = motion(count, np.random.default_rng(SEED))
        for law in LAWS:
            measure(goals, name, replace(machine, joints=limited, time=law), points)
    for name, motion in TIP_MOTIONS.items():
        points = motion(count, np.random.default_rng(SEED))
        points[:, 2] += CLEAR
        measure(goals, name, machine, points, "G43.4 H1")
    goals.write(options.out)
    return 0


def measure(goals: Goals, name: str, machine: Machine, points: Array, code: str = "") -> None:
    """Plan a program through some points X Y Z A C a few times."""
    rows = points.round(4).tolist()
    moves = [f"G1 X{x} Y{y} Z{z} A{a} C{c} F6000." for x, y, z, a, c in rows]
    text = "\n".join(["G21 G90 G94 G64 P0.02", "T1 M6", "M3 S1000", code, *moves, "G49", "M30"])
    program = interpret(text, control_for(machine, None, None, False), name).program
    seconds = np.inf
    for _ in range(ROUNDS):
        start = time.process_time()
        path, findings = plan(program, machine)
        seconds = min(seconds, time.process_time() - start)
    lost = [finding.message for finding in findings if finding.effect == "inconclusive"]
    if lost:
        sys.exit(f"{name}: {lost}")
    speed, goal = len(points) / seconds, GOAL
    what, note = f"{name}, {code or machine.time}", f"{len(path)} pieces"
    if code:
        result = check_program(text, name, machine, Options(threads=1))
        assert result.first_contact is None
        searched = len(points) / result.timing_s["search"]
        goal, note = min(goal, int(10 * searched)), f"{note}, search {searched:.0f} blocks/s"
    goals.at_least(what, speed, goal, "blocks/s", note)


def corners(count: int, rng: np.random.Generator) -> Array:
    """A corner after every block of about 0.5 mm."""
    points = np.zeros((count, 5))
    points[:, :3] = np.clip(np.cumsum(rng.normal(size=(count, 3)) * 0.3, axis=0), -100, 100)
    points[:, 2] /= 5
    return points


def smooth(count: int, rng: np.random.Generator) -> Array:
    """A smooth curve in chords of 0.2 mm."""
    t, points = np.linspace(0.0, 400.0, count), np.zeros((count, 5))
    points[:, 0], points[:, 1] = 100 * np.sin(t), 100 * np.cos(1.3 * t)
    points[:, 2] = 20 * np.sin(t / 3)
    return points


def short(count: int, rng: np.random.Generator) -> Array:
    """A winding curve in chords of 0.01 mm."""
    heading = np.cumsum(rng.normal(size=count) * 0.05)
    points = np.zeros((count, 5))
    points[:, :2] = np.cumsum(np.stack([np.cos(heading), np.sin(heading)], axis=1) * 0.01, axis=0)
    return points


def straight(count: int, rng: np.random.Generator) -> Array:
    """Straight lines of some 100 mm."""
    points = np.zeros((count, 5))
    points[:, :3] = rng.uniform(-150, 150, (count, 3)) * [1, 1, 0.2]
    return points


def five_axes(count: int, rng: np.random.Generator) -> Array:
    """A surface finished with five axes."""
    t = np.linspace(0.0, count / 1000, count)
    wave = [40 * np.sin(t), 40 * np.cos(t), np.minimum(t / 10, 30), 20 * np.sin(t / 3)]
    return np.stack([*wave, 360 * np.sin(t / 9)], axis=1)


def roughing(count: int, rng: np.random.Generator) -> Array:
    """Moves of some 7 mm that turn the tool by some 5 degrees."""
    return five_axes(20 * count, rng)[::200]


MOTIONS = {f.__name__: f for f in (corners, smooth, short, straight, five_axes)}
TIP_MOTIONS = {f.__name__: f for f in (smooth, five_axes, roughing)}

if __name__ == "__main__":
    sys.exit(main())
