"""The speed of the interpreter, from a file to canonical columns, by family of programs.

Blocks are those that run: a loop body counts every time. Times are processor times of one core,
the best of three. Run from the repository root:
python tests/benchmarks/bench_language.py [--out FILE] [--only NAME] [--scale S]
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))

from goals import ROOT, Goals

from gcodesim.machine.control_data import control_for
from gcodesim.machine.loading import load_machine
from gcodesim.nc.control.interpreter import Interpretation
from gcodesim.nc.control.readings import ROWS
from gcodesim.nc.control.supply import Control, Kinematics
from gcodesim.nc.interpret import interpret
from gcodesim.nc.lines import read_program

ROUNDS, SEED = 3, 1
PLAIN_GOAL, ORDER_GOAL, GENERAL_GOAL, EXPRESSION_GOAL = 1_000_000, 500_000, 100_000, 60_000
"""Blocks per second."""

HEAD = ["%", "O1", "G90 G21 G17 G94 G54", "S5000 M3", "G0 X0 Y0 Z50"]
END = ["M30", "%"]
WRAP = {"C": "shortest"}


def main() -> int:
    """Measure every family, or the one that --only names."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, help="JSON file to write")
    parser.add_argument("--only", choices=sorted(FAMILIES), help="measure only this")
    parser.add_argument("--scale", type=float, default=1.0, help="size of the programs")
    options = parser.parse_args()
    goals = Goals("bench_language")
    for name, (write, goal, fields) in FAMILIES.items():
        if options.only in (None, name):
            count = int((200_000 if goal >= ORDER_GOAL else 40_000) * options.scale)
            measure(goals, name, write(count, np.random.default_rng(SEED)), goal, fields)
    goals.write(options.out)
    return 0


def measure(
    goals: Goals, name: str, lines: list[str], goal: float, fields: dict[str, object]
) -> None:
    """Write the program to a file and interpret it a few times."""
    fields = dict(fields)
    readings = ROWS[str(fields.pop("dialect", "fanuc"))]
    if machine := fields.pop("kinematics", ""):
        fields["kinematics"] = _kinematics(ROOT / str(machine))
    control = Control(readings, **{"axes": "XYZAC", **fields})  # type: ignore[arg-type]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "program.nc"
        path.write_text("\n".join(lines) + "\n", encoding="ascii")
        seconds, meaning = best_of(path, control)
    errors = [finding.message for finding in meaning.findings if finding.severity == "error"]
    if meaning.stopped or errors:
        sys.exit(f"{name}: {errors}")
    moves = len(meaning.program) / seconds / 1000
    size = sum(map(len, lines)) / len(lines) + 1
    note = f"{meaning.blocks} blocks, {size:.0f} bytes a line, {moves:.0f} k commands/s"
    goals.at_least(name, meaning.blocks / seconds, goal, "blocks/s", note)


def _kinematics(machine: Path) -> Kinematics | None:
    return control_for(load_machine(machine), None, None, False).kinematics


def best_of(path: Path, control: Control) -> tuple[float, Interpretation]:
    """Return the shortest processor time [s] of a few rounds, and the last result."""
    shortest = float("inf")
    for _ in range(ROUNDS):
        start = time.process_time()
        meaning = interpret(read_program(path), control, str(path))
        shortest = min(shortest, time.process_time() - start)
    return shortest, meaning


def plain(count: int, rng: np.random.Generator) -> list[str]:
    """A surface finished with five axes."""
    t = np.linspace(0, 200, count)
    columns = (40 * np.sin(t), 40 * np.cos(t), t / 10, 20 * np.sin(t / 3), 30_000 * t)
    rows = zip(*(column.tolist() for column in columns), strict=True)
    blocks = [
        f"N{i}G1X{x:.3f}Y{y:.3f}Z{z:.3f}A{a:.2f}C{c % 360:.2f}F{2000 + i % 7}"
        for i, (x, y, z, a, c) in enumerate(rows, start=1)
    ]
    return [*HEAD, *blocks, *END]


def speeds(count: int, rng: np.random.Generator) -> list[str]:
    """A speed in each block: a laser, or a spindle that follows the load."""
    rows = enumerate(rng.uniform(-200, 200, (count, 2)).round(3).tolist())
    return [*HEAD, "G1 F6000", *(f"X{x} Y{y} S{i % 999}" for i, (x, y) in rows), *END]


def orders(count: int, rng: np.random.Generator) -> list[str]:
    """In each block a tool to select, or coolant on or off."""
    words = ("T1", "M8", "T12", "M9", "M7")
    rows = enumerate(rng.uniform(-200, 200, (count, 2)).round(3).tolist())
    return [*HEAD, "G1 F6000", *(f"X{x} Y{y} {words[i % 5]}" for i, (x, y) in rows), *END]


def expressions(count: int, rng: np.random.Generator) -> list[str]:
    """An expression in every word of every block, and no two blocks alike."""
    rows = enumerate(rng.uniform(1, 9, (count, 3)).round(3).tolist())
    blocks = (f"N{i} G1 X[#1+{a}] Y[#2*{b}-#3] Z-[{c}/#2] F[#4+{i % 9}.]" for i, (a, b, c) in rows)
    return [*HEAD, "#1=5.", "#2=1.5", "#3=-0.25", "#4=600.", *blocks, *END]


def functions(count: int, rng: np.random.Generator) -> list[str]:
    """As a cutter path written with sine and cosine, each block with an assignment before it."""
    rows = enumerate(rng.uniform(1, 90, (count // 2, 2)).round(3).tolist())
    pairs = (
        (f"#5=[#4+{i % 7}.]", f"G1 X[#1*COS[{a}]] Y[#1*SIN[{b}]] Z#3 F#5") for i, (a, b) in rows
    )
    head = ["#1=5.", "#3=-0.25", "#4=600."]
    return [*HEAD, *head, *(line for pair in pairs for line in pair), *END]


def tips(count: int, rng: np.random.Generator) -> list[str]:
    """The same under tool centre point control."""
    lines = plain(count, rng)
    return [*HEAD, "G43.4 H1", *lines[len(HEAD) :]]


def arcs(count: int, rng: np.random.Generator) -> list[str]:
    """Quarter and half circles with centre words, every third one a helix."""
    blocks, x = ["G1 Z-1 F800"], 0.0
    for i in range(count // 2):
        r = round(float(rng.uniform(1, 20)), 3)
        z = f" Z{-(i % 50) / 10:.1f}" if i % 3 == 0 else ""
        blocks += [
            f"G2 X{x + 2 * r:.3f} Y0.{z} I{r:.3f} J0. F1200.",
            f"G3 X{x + r:.3f} Y{-r:.3f} I{-r:.3f}",
        ]
        blocks.append(f"G1 X{x:.3f} Y0.")
    return [*HEAD, *blocks, *END]


def radius_arcs(count: int, rng: np.random.Generator) -> list[str]:
    """Arcs with R, back and forth."""
    radii = rng.uniform(10.1, 30, count).round(3).tolist()
    blocks = [f"G{2 + i % 2} X{20.0 * (i % 2):.3f} Y0.000 R{r}" for i, r in enumerate(radii)]
    return [*HEAD, "G1 X20 Y0 F900", *blocks, *END]


def mixed(count: int, rng: np.random.Generator) -> list[str]:
    """What a CAM system writes for pockets: lines joined by tangent arcs."""
    blocks = []
    for i in range(count // 8):
        w, r, z = 20 + i % 30, 2.5, -(i % 10) / 2
        blocks += [
            f"G0 X{-w}. Y{-w + r}",
            f"G1 Z{z} F300.",
            f"Y{w - r} F1500.",
            f"G2 X{-w + r} Y{w}. I{r} J0.",
            f"G1 X{w - r}",
            f"G2 X{w}. Y{w - r} J{-r}",
            f"G1 Y{-w + r}",
            f"G3 X{w + 2 * r} Y{-w + r} R{r}",
        ]
    return [*HEAD, *blocks, *END]


def drilling(cycle: str) -> Callable[[int, np.random.Generator], list[str]]:
    """Holes of one cycle, one a line."""

    def write(count: int, rng: np.random.Generator) -> list[str]:
        x, y = rng.uniform(-200, 200, (2, count)).round(3).tolist()
        blocks = [f"X{a} Y{b}" for a, b in zip(x, y, strict=True)]
        return [*HEAD, f"{cycle} F200", *blocks, "G80", *END]

    return write


def full_cycles(count: int, rng: np.random.Generator) -> list[str]:
    """Holes whose blocks repeat the cycle with all its words."""
    x, y = rng.uniform(-200, 200, (2, count)).round(3).tolist()
    rows = zip(x, y, strict=True)
    return [*HEAD, *(f"G81 X{a} Y{b} Z-5. R2. F200." for a, b in rows), "G80", *END]


def depths(count: int, rng: np.random.Generator) -> list[str]:
    """Holes of which no two have the same depth."""
    rows = enumerate(rng.uniform(-200, 200, count).round(3).tolist())
    return [*HEAD, "G81 Z-5. R2. F200.", *(f"X{x} Z-{5 + i % 9}." for i, x in rows), "G80", *END]


def loops(count: int, rng: np.random.Generator) -> list[str]:
    """A WHILE loop that mills a spiral."""
    body = ["WHILE[#1LT#2]DO1", "X[#3*COS[#1]] Y[#3*SIN[#1]] Z-[#1/360]", "#1=#1+5.", "END1"]
    head = ["#1=0", f"#2={5 * (count // 4)}", "#3=25.4", "G1 F500"]
    return [*HEAD, *head, *body, *END]


def jumps(count: int, rng: np.random.Generator) -> list[str]:
    """A loop of IF and GOTO around lines without macro text."""
    body = ["N10 #100=#100+1", "G1 X#100 Y[#100*2.5+#101] F500", "Z-1.", "G0 Z5."]
    body.append(f"IF[#100LT{count // 5}]GOTO10")
    return [*HEAD, "#100=0", "#101=1.5", *body, *END]


def assignments(count: int, rng: np.random.Generator) -> list[str]:
    """Macro text that no two lines share: nothing can be read once for all."""
    rows = enumerate(rng.uniform(0, 9, (count // 2, 2)).round(3).tolist())
    pairs = ((f"#100=#101+{a}", f"G1 X[#100-{i % 50}.] Y{b} F500") for i, (a, b) in rows)
    return [*HEAD, "#101=1", *(line for pair in pairs for line in pair), *END]


def calls(count: int, rng: np.random.Generator) -> list[str]:
    """G65 from a loop: a macro that drills a bolt circle."""
    main = ["#1=0", f"WHILE[#1LT{count // 6}]DO1", "G65 P100 X[#1*0.01] Y5. Z-10. R2.", "#1=#1+1"]
    macro = ["O100", "G0 X#24 Y#25", "G1 Z#26 F200", "G0 Z#18", "M99"]
    return [*HEAD, *main, "END1", "M30", *macro, "%"]


def o_words(count: int, rng: np.random.Generator) -> list[str]:
    """LinuxCNC: a loop with a branch."""
    body = [
        "#<i>=0",
        f"o1 while [#<i> LT {count // 7}]",
        "#<i>=[#<i>+1]",
        "o2 if [[#<i> MOD 2] EQ 0]",
        "G1 X[#<i>/100] Y1. F500",
        "o2 else",
        "G0 X[#<i>/100] Y2.",
        "o2 endif",
        "G0 Z[2+COS[#<i>]]",
        "o1 endwhile",
    ]
    return [*HEAD[2:], *body, "M2"]


def varied(count: int, rng: np.random.Generator) -> list[str]:
    """Every line something else: comments, codes, speeds, dwells, tools, offsets."""
    blocks = [
        "N{0} G0 G90 G54 X{1} Y{2} S{3} M3 (a comment)",
        "N{0} G43 H1 Z25. M8",
        "N{0} G1 Z{1} F{3}. ; down",
        "N{0} G1 G91 X{1} Y{2}",
        "N{0} G90 G1 X{1} Y{2}",
        "N{0} G4 P100",
        "N{0} G0 Z50. M9",
        "N{0} M5",
    ]
    values = rng.uniform(-20, 20, (count, 2)).round(3).tolist()
    rows = (blocks[i % 8].format(i, a, b, 1000 + i) for i, (a, b) in enumerate(values))
    return [*HEAD, *rows, *END]


FAMILIES: dict[
    str, tuple[Callable[[int, np.random.Generator], list[str]], float, dict[str, object]]
] = {
    "plain": (plain, PLAIN_GOAL, {}),
    "plain, C shortest": (plain, PLAIN_GOAL, {"wrap": WRAP}),
    "plain, G43.4": (
        tips,
        PLAIN_GOAL,
        {"tool_for_all": True, "kinematics": "machines/table_tilt.yaml"},
    ),
    "speeds": (speeds, ORDER_GOAL, {}),
    "tools and coolant": (orders, ORDER_GOAL, {"tool_for_all": True}),
    "arcs I J": (arcs, GENERAL_GOAL, {}),
    "arcs R": (radius_arcs, GENERAL_GOAL, {}),
    "lines and arcs": (mixed, GENERAL_GOAL, {}),
    "cycle G81": (drilling("G81 X0 Y0 Z-5. R2."), GENERAL_GOAL, {}),
    "cycle G83": (drilling("G99 G83 X0 Y0 Z-10. R2. Q3."), GENERAL_GOAL, {}),
    "cycle G84": (drilling("G84 X0 Y0 Z-5. R2."), GENERAL_GOAL, {}),
    "cycle G81, all words": (full_cycles, GENERAL_GOAL, {}),
    "cycle G81, other depths": (depths, GENERAL_GOAL, {}),
    "WHILE": (loops, GENERAL_GOAL, {}),
    "IF GOTO": (jumps, GENERAL_GOAL, {}),
    "assignments": (assignments, GENERAL_GOAL, {}),
    "expressions": (expressions, EXPRESSION_GOAL, {}),
    "functions": (functions, EXPRESSION_GOAL, {}),
    "G65": (calls, GENERAL_GOAL, {}),
    "o-words": (o_words, GENERAL_GOAL, {"dialect": "linuxcnc"}),
    "varied": (varied, GENERAL_GOAL, {}),
}
"""Family -> its program, its goal, and the fields of its control."""


if __name__ == "__main__":
    sys.exit(main())
