"""Mutates programs and interprets them: no traceback, no hang, whatever the text.

Seeds are the samples and the programs of the language tests. Run from the repository root:
python tests/benchmarks/fuzz_language.py [--count N] [--seed S]; ends with 1 at the first failure,
and prints the program that caused it.
"""

from __future__ import annotations

import argparse
import json
import random
import sys
import time
import traceback
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from gcodesim.machine.control_data import control_for
from gcodesim.machine.loading import load_machine
from gcodesim.nc.canon import canon_rows
from gcodesim.nc.control.readings import ROWS
from gcodesim.nc.control.supply import Control, ToolEntry, WorkOffset
from gcodesim.nc.interpret import interpret
from gcodesim.nc.lines import decode

ROOT = Path(__file__).resolve().parents[2]
SEEDS = ("samples/*.nc", "tests/nc/golden/*.ngc", "tests/nc/good/*.nc", "tests/nc/bad/*.nc")
LINES = 40
"""Lines taken from a long seed: mutants are short, so that many are tried."""

SLOW_S = 5.0
"""A mutant that takes longer hangs for all we know [s]; usual is a millisecond."""

WORDS = (
    "G0 G1 G2 G3 G4 G10 G16 G28 G43 G51.1 G53 G54 G65 G68 G73 G76 G81 G83 G84 G87 G91 G93 G98 "
    "M98 M99 M97 M6 M3 M30 X1 Y-2.5 Z.5 A90 C-45 I1 J0 K3 R5 R-5 P1 P10002 Q.1 L2 L3 K9 F100 F0 "
    "S500 T1 H2 D1 N10 O100 #1 #1=5 #[2] #100=#1+1 X#1 [1+2] SIN[30] SQRT[-1] IF[1EQ1]GOTO10 "
    "WHILE[#1LT3]DO1 END1 DO2 END2 GOTO10 IF[#1GT0]THEN#2=1 o1sub o1endsub o1call[1] o1if[1] "
    "o1else o1endif o1while[#1] o1endwhile o1do o1repeat[3] o1endrepeat o1break o1continue "
    "o1return #<a>=1 #3000=1 #3006=1 #5161=3 % / ; ( ) [ ] # = . - + : 9 99999999999 1e9 "
    "G43.4H1 G43.5H2 G49 G234H1 M428 M429 G68.2 G68.2J30 G68.2X1Y2Z3I40J30K20 G68.3R5 G68.4J10 "
    "G69 G53.1 G53.1P2 G254 G255 G54.2P1 G54.2P0 I.5J.5K1 A-100 B30 C400 ,R1 ,C.5 ,R ,C#1 G28 "
    "G43.4H1G1X1A10F9 G92X5 G52Z1 G10L20P1X0 #1=#5021 X#5043 G51.1X0 "
    "(MSG,x) (DEBUG,#1) < > \xe4 \u20ac "
)
FIVE_AXIS = """G90 G17 G54 S900 M3 T1 M6
G0 A-20 B10 C30
G43.4 H1
G1 X10 Y5 Z300 A-30 B15 C60 F500
G2 X20 I5 A-25
G91 G28 Z0
G90 G43.5 H1
G1 X1 Y2 I.3 J.2 K1
G3 X5 R9 I0 J0 K1
G49
G53 G0 Z0
G68.2 X1 Y2 Z3 I30 J20 K10
G53.1
G43 H2
G0 X0 Y0 Z20
G1 X10 ,R1 F100
Y10 ,C2
X0
G81 X5 Y5 Z-5 R2
G80 G69
G254
G54.2 P1
G0 A5 C10
X0 Y0
G255
M428
G1 X9 A-10 F9
M429
M30"""
"""A seed that goes through the five-axis codes of all dialects; those it lacks end it early."""

PIECES = [*WORDS.split(), "\n", "\r", "\r\n", "\t", "\x00"]


def seeds() -> list[list[str]]:
    """Return the lines of every seed."""
    paths = [path for pattern in SEEDS for path in sorted(ROOT.glob(pattern))]
    programs = [decode(path.read_bytes()).splitlines()[: 3 * LINES] for path in paths]
    # Of many seeds this one stands for what most others do not hold.
    return programs + [FIVE_AXIS.splitlines()] * (len(programs) // 4)


def mutants(programs: list[list[str]], count: int, seed: int) -> Iterator[str]:
    """Yield mutated programs."""
    rng = random.Random(seed)
    for _ in range(count):
        lines = rng.choice(programs)
        start = rng.randrange(max(1, len(lines) - LINES))
        mutant = lines[start : start + LINES]
        for _ in range(rng.choice((1, 1, 2, 3, 8))):
            _mutate(mutant, programs, rng)
        yield rng.choice(("\n", "\n", "\r\n")).join(mutant)


def _mutate(lines: list[str], programs: list[list[str]], rng: random.Random) -> None:
    """Change one thing in place."""
    at = rng.randrange(len(lines) + 1)
    kind = rng.randrange(7)
    if kind == 0:
        lines.insert(at, rng.choice(rng.choice(programs) or [""]))
    elif kind == 1 and lines:
        lines.insert(at, rng.choice(lines))
    elif kind == 2:
        lines.insert(at, " ".join(rng.choices(PIECES, k=rng.randint(1, 4))))
    elif lines:
        at = min(at, len(lines) - 1)
        text = lines[at]
        place = rng.randrange(len(text) + 1)
        if kind == 3:
            lines[at] = text[:place] + rng.choice(PIECES) + text[place:]
        elif kind == 4:
            lines[at] = text[:place] + text[place + rng.randint(1, 3) :]
        elif kind == 5:
            lines[at] = text[:place] + chr(rng.randrange(32, 127)) + text[place + 1 :]
        else:
            del lines[at]


def controls() -> list[Control]:
    """Return controls of each dialect, without kinematics and with those of every machine shipped.

    Programs end after a few thousand blocks.
    """
    tools = {n: ToolEntry(n, (0.0, 0.0, 50.0 * n, 0.0, 0.0, 0.0), 10.0) for n in (1, 2, 3)}
    offsets = {n: WorkOffset((n, 0.0, 0.0, 0.0, 0.0, 0.0), rotation=30.0 * n) for n in range(9)}
    given = {"tools": tools, "offsets": offsets, "feed": 100.0, "max_blocks": 3000}
    plain = [
        Control(readings, wrap=wrap, **given)
        for readings, wrap in zip(
            ROWS.values(), ({"C": "shortest"}, {"A": "sign"}, {}, {}), strict=True
        )
    ]
    turning = [
        replace(
            control_for(
                load_machine(name).with_readings(tcp_frame=frame, orientation=orientation),
                *(dialect, None, False),
            ),
            **given,
        )
        for name in ("table_tilt", "head_tilt", "table_head")
        for dialect, frame, orientation in (
            ("fanuc", "table", "joints"),
            ("fanuc", "work", "great_circle"),
            ("haas", "table", "joints"),
            ("linuxcnc", "work", "joints"),
        )
    ]
    return [*plain, *turning]


def failure(text: str, control: Control, meanings: Counter[str]) -> str:
    """Interpret a program; return what went wrong, or nothing."""
    begin = time.monotonic()
    try:
        meaning = interpret(text, control, "mutant.nc")
        seconds = time.monotonic() - begin
        for row in canon_rows(meaning):
            json.dumps(row, allow_nan=False)
    except Exception:
        return traceback.format_exc()
    meanings.update(finding.meaning for finding in meaning.findings)
    if seconds > SLOW_S:
        return f"took {seconds:.1f} s"
    if not np.isfinite(meaning.program.to).all():
        return "a position that is no number"
    error = any(f.severity == "error" or f.meaning == "max_blocks" for f in meaning.findings)
    return "" if error == meaning.stopped else "stopped without an error, or the other way round"


def fuzz(count: int, seed: int) -> tuple[str, Counter[str]]:
    """Try mutants in all dialects; return the first failure, or nothing, and meanings met."""
    machines, meanings = controls(), Counter[str]()
    for number, text in enumerate(mutants(seeds(), count, seed)):
        control = machines[number % len(machines)]
        if wrong := failure(text, control, meanings):
            return f"mutant {number}, {control.readings.dialect}: {wrong}\n{text!r}", meanings
    return "", meanings


def main() -> int:
    """Run as told on the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    begin = time.monotonic()
    wrong, meanings = fuzz(given.count, given.seed)
    print(f"{given.count} mutants, seed {given.seed}, {time.monotonic() - begin:.0f} s")
    print(f"{len(meanings)} meanings met; rarest {meanings.most_common()[:-6:-1]}")
    print(wrong or "no traceback, no hang")
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
