"""How fast a stock is raced: roughing along its walls, five-axis finishing, pecks, and memory.

Run from the repository root: python tests/benchmarks/bench_stock.py [--out FILE] [--only NAME]
"""

from __future__ import annotations

import argparse
import resource
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from goals import Goals
from stock import milling
from stock.milling import Program, ball_mill, drill, end_mill, mill, path_of, roughing

from gcodesim.constants import DEFAULT_PERIOD_PS
from gcodesim.machine.model import Machine
from gcodesim.stock.workpiece import StockAnswer, StockTask, race_stock
from gcodesim.study.clock import time_runs

THREADS = 2
TURNS = 60
FAST = milling.MILL.replace("[50, 50, 0], rapid: 7200", "[40, 40, 0], rapid: 360000")


def main() -> int:
    """Measure every goal, or the one that --only names."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, help="JSON file to write")
    parser.add_argument("--only", choices=sorted(MEASUREMENTS), help="measure only this")
    options = parser.parse_args()
    goals = Goals("bench_stock")
    for name, measure in MEASUREMENTS.items():
        if options.only in (None, name):
            measure(goals)
    goals.write(options.out)
    return 0


def timed(program: Program, machine: Machine, runs: int = 3) -> tuple[float, float, StockAnswer]:
    """Median seconds of a race, of them on the CPU, and its answer."""
    path = path_of(program, machine)
    task = StockTask(machine, path, DEFAULT_PERIOD_PS, "cpu", THREADS)
    race_stock(machine.bodies["blank"], task)
    begin = time.process_time()
    timing, answer = time_runs(lambda: race_stock(machine.bodies["blank"], task), runs=runs)
    return timing.median, (time.process_time() - begin) / runs, answer


def told(answer: StockAnswer, cpu: float) -> str:
    """What goes beside a figure."""
    found = "contact" if answer.events else "clear"
    return (
        f"{found}, {answer.items} items, {answer.beams} beams, {answer.undecided} undecided, "
        f"{cpu:.2f} s of CPU"
    )


def measure_roughing(goals: Goals) -> None:
    """Twelve minutes of roughing with the shank along every wall."""
    for inset, most in ((0.05, 0.3), (0.01, 1.0)):
        seconds, cpu, answer = timed(roughing(), mill(end_mill(), inset=inset))
        goals.at_most(f"roughing, inset {inset:g}", seconds, most, "s", told(answer, cpu))
        assert not answer.events
        assert not answer.undecided


def half_ball(holder_at: float) -> tuple[Program, Machine]:
    """Rings about a half ball of radius 30, then a ball end mill square to its surface."""
    program, radius, low = Program(), 30.0, -38.0
    program.move(40, -20, 10, 0, 0)
    for z in np.arange(-2, -37, -2.0).tolist():
        inner = np.sqrt(radius**2 - (z - low) ** 2) + 0.3 if z - low < radius else -1.0
        ring = 60.0
        program.move(108, 40, 10).move(108, 40, z)
        while True:
            x = 48.0 + ring
            program.move(x, 40, z, feed=4000)
            program.say(f"G3 X{x:.4f} Y40 I{40.0 - x:.4f} J0 F4000", (x, 40, z))
            if ring <= inner + 1e-9:
                break
            ring = max(inner, ring - 10.0)
        program.move(*program.at[:2], 10)
    program.move(40, 40, 100, 0, 0).say("T2 M6").say("S8000 M3").say("G43.4 H2")
    program.move(40, 40, 50, 0, 0)
    for i in range(360 * TURNS):
        tilt, turn = np.radians(2 + 78 * i / (360 * TURNS)), 2 * np.pi * i / 360
        normal = np.array([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)])
        tip = np.array([40, 40, low]) + radius * normal
        if tip[2] < -36:
            break
        place = np.degrees(tilt), -np.degrees(turn)
        if not i:
            program.move(*(tip + 20 * normal), *place).move(*(tip + 3 * normal), *place)
        program.move(*tip, *place, feed=1500)
    program.move(*(tip + 30 * normal), *place)
    tools = end_mill(8, 30, 8, 60, 25), ball_mill(3, 12, 2.8, holder_at, 10, number=2)
    blank = "box: {size: [80, 80, 40], center: [40, 40, -20]}"
    return program, mill(*tools, blanks=blank, machine=FAST.replace("rapid: 7200", "rapid: 36000"))


def measure_five_axes(goals: Goals) -> None:
    """Five-axis finishing of a half ball, clear, and with a holder that is too low."""
    for holder, name in ((35.0, "clear"), (20.0, "holder too low")):
        seconds, cpu, answer = timed(*half_ball(holder), runs=1)
        goals.at_most(f"five axes, {name}", seconds, 2.4, "s", told(answer, cpu))


def measure_pecks(goals: Goals) -> None:
    """A peck is one item, and so is its way out and back."""
    program = Program().move(50, 50, 5).say("G83 Z-20 R2 Q1 F200").say("G80").move(50, 50, 50)
    seconds, cpu, answer = timed(program, mill(drill()))
    goals.at_most("20 pecks, items each", answer.items / 20.0, 3.1, "", told(answer, cpu))
    goals.fact("20 pecks", seconds, "s")


def measure_memory(goals: Goals) -> None:
    """Roughing for hours: what a million pieces take."""
    machine = mill(end_mill())
    path = path_of(roughing(), machine)
    times = 1 + 1_000_000 // len(path)
    length = path.duration_ps
    bounds = np.concatenate(
        [path.bounds_ps[:-1] + k * length for k in range(times)] + [[times * length]]
    )
    repeat = {
        n: np.concatenate([getattr(path, n)] * times)
        for n in ("q0", "q1", "law", "arc", "line", "cuts")
    }
    long = replace(path, bounds_ps=bounds, **repeat)
    task = StockTask(machine, long, DEFAULT_PERIOD_PS, "cpu", THREADS)
    begin = time.perf_counter()
    answer = race_stock(machine.bodies["blank"], task)
    goals.fact("a million pieces", time.perf_counter() - begin, "s", told(answer, 0.0))
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    goals.at_most("memory of the process then", most, 2.0, "GB")


MEASUREMENTS = {
    "roughing": measure_roughing,
    "five_axes": measure_five_axes,
    "pecks": measure_pecks,
    "memory": measure_memory,
}

if __name__ == "__main__":
    sys.exit(main())
