"""Counts how far real programs are followed: verdicts of language, what stops them, readings met.

Every program of some folders is interpreted as the machine file stands, as if it listed what a
builder knows (axes, work offsets, M codes, open keys), and so without one key after the other. No
shape is looked at, so this takes seconds; `--check` checks the programs too, and counts the
readings on which a verdict hangs. Run from the repository root:
python tests/benchmarks/real_programs.py MACHINE FOLDER... [--dialect D] [--each] [--check]
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from gcodesim.api import check
from gcodesim.checking.options import Options
from gcodesim.findings.codes import FAIL, INCONCLUSIVE, Finding
from gcodesim.machine.control_data import control_for
from gcodesim.machine.loading import load_machine
from gcodesim.nc.control.interpreter import Interpretation
from gcodesim.nc.control.supply import Control, WorkOffset
from gcodesim.nc.interpret import interpret
from gcodesim.nc.lines import read_program

OPEN_KEYS: dict[str, Any] = {
    "same_group": "last",
    "g53_incremental": "ignored",
    "arc_normal_word": "ignored",
}
"""Key -> what a control may do where the row of its dialect says that it is not known."""

M_CODES = dict.fromkeys(map(float, range(1000)), "none")
REFERENCE = dict.fromkeys("XYZABC", 0.0)
OFFSETS = (*range(1, 10), *range(101, 401))


def main() -> int:
    """Count the programs of every folder."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("machine", help="machine file, or the name of a shipped machine")
    parser.add_argument("folders", nargs="+", type=Path, help="folders of programs")
    parser.add_argument("--dialect", help="instead of the one that file or text tells")
    parser.add_argument("--each", action="store_true", help="also tell what stops each program")
    parser.add_argument("--check", action="store_true", help="check the programs, as shipped")
    options = parser.parse_args()
    shipped = control_for(load_machine(options.machine), options.dialect, None, False)
    for folder in options.folders:
        show(f"{folder.name}, as shipped", list(meanings(folder, shipped)), each=False)
        all_listed = list(meanings(folder, listed(shipped, OPEN_KEYS)))
        show(f"{folder.name}, all listed", all_listed, each=options.each)
        show_keys(folder, shipped, all_listed)
        if options.check:
            show_checks(folder, options.machine, options.dialect)
    return 0


def meanings(folder: Path, control: Control) -> Iterator[tuple[Path, Interpretation]]:
    """Interpret the programs of a folder."""
    for path in programs_in(folder):
        yield path, interpret(read_program(path), control, str(path))


def programs_in(folder: Path) -> list[Path]:
    """Return the files of a folder."""
    return [path for path in sorted(folder.rglob("*")) if path.is_file()]


def listed(control: Control, keys: dict[str, Any]) -> Control:
    """Return a control that knows what its builder would list, and these keys."""
    given = {"m_codes": M_CODES, **keys}
    return replace(
        control,
        readings=replace(control.readings, **given),
        given=None if control.given is None else {**control.given, **given},
        axes="XYZABC",
        reference={code: REFERENCE | dict(axes) for code, axes in control.reference.items()},
        offsets={**dict.fromkeys(OFFSETS, WorkOffset()), **control.offsets},
    )


def show(title: str, found: list[tuple[Path, Interpretation]], *, each: bool) -> None:
    """Print what programs come to; with `each`, what stops every one of them."""
    stops: Counter[str] = Counter()
    left: Counter[str] = Counter()
    readings: Counter[str] = Counter()
    failed, all_ = 0, max(len(found), 1)
    for path, meaning in found:
        failed += any(finding.effect == FAIL for finding in meaning.findings)
        left.update({_what(f) for f in meaning.findings if f.effect == INCONCLUSIVE})
        readings.update(reading.key for reading in meaning.readings)
        if meaning.stopped:
            stop = meaning.findings[-1]
            stops[_what(stop)] += 1
            if each:
                print(f"    {path.name}:{stop.line}: {stop.message} | {stop.block.strip()}")
    ended = len(found) - stops.total()
    print(
        f"{title}: {len(found)} programs, FAIL {failed} ({100 * failed / all_:.0f} %), "
        f"followed to the end {ended} ({100 * ended / all_:.0f} %)"
    )
    print(f"  first stop: {_listing(stops)}")
    print(f"  left open: {_listing(left)}")
    print(f"  readings met: {_listing(readings)}")


def show_keys(
    folder: Path, shipped: Control, all_listed: list[tuple[Path, Interpretation]]
) -> None:
    """Print how many programs each key stops, or makes inconclusive, where it alone is left out."""
    clouded: Counter[str] = Counter()
    for left_out in OPEN_KEYS:
        keys = {key: value for key, value in OPEN_KEYS.items() if key != left_out}
        for (_, one), (_, other) in zip(
            meanings(folder, listed(shipped, keys)), all_listed, strict=True
        ):
            effects = {f.meaning for f in one.findings if f.effect != "noted"}
            clouded[left_out] += not effects <= {f.meaning for f in other.findings}
    print(f"  a key alone left out clouds: {_listing(+clouded)}")


def show_checks(folder: Path, machine: str, dialect: str | None) -> None:
    """Check the programs of a folder; print the verdicts, and the keys on which they hang."""
    verdicts: Counter[str] = Counter()
    keys: Counter[str] = Counter()
    begin = time.perf_counter()
    for path in programs_in(folder):
        result = check(path, machine, options=Options(dialect=dialect))
        verdicts[result.verdict] += 1
        keys.update(reading.key for reading in result.coverage.readings if not reading.agrees)
    seconds = time.perf_counter() - begin
    print(f"{folder.name}: checked in {seconds:.0f} s: {_listing(verdicts)}")
    print(f"  keys that make another verdict: {_listing(keys)}")


def _what(finding: Finding) -> str:
    return f"{finding.code} {finding.meaning}"


def _listing(counts: Counter[str]) -> str:
    return ", ".join(f"{what} {number}" for what, number in counts.most_common()) or "nothing"


if __name__ == "__main__":
    sys.exit(main())
