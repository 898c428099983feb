"""Where LinuxCNC is installed, its interpreter and ours move the machine alike."""

import shutil
from pathlib import Path

import pytest
from nc.rs274 import canonical_calls, random_program

from gcodesim.nc.canon import canon_rows
from gcodesim.nc.control.supply import WorkOffset
from gcodesim.nc.interpret import interpret
from gcodesim.nc.lines import read_program

pytestmark = pytest.mark.skipif(shutil.which("rs274") is None, reason="LinuxCNC is not installed")

ROOT = Path(__file__).parents[2]
PROGRAMS = sorted(
    path
    for pattern in ("samples/*.nc", "tests/nc/golden/*.ngc", "tests/nc/good/*.nc")
    for path in ROOT.glob(pattern)
)
ZERO = {code: dict.fromkeys("XYZABC", 0.0) for code in ("G28", "G30")}
NEAR = 6e-3
"""Four decimals of an inch, in a point and two offsets [mm]."""


@pytest.fixture
def anchor(control):
    offsets = {index: WorkOffset() for index in range(1, 10)}
    return control("linuxcnc", offsets=offsets, reference=ZERO)


def compared(rows):
    """Moves, dwells and tools, without moves of no length."""
    kept, position = [], [0.0] * 6
    for row in rows:
        still = row["kind"] in ("rapid", "feed") and row["to"] == pytest.approx(position, abs=1e-4)
        position = row.get("to", position)
        if row["kind"] in ("rapid", "feed", "arc", "dwell", "tool") and not still:
            kept.append(row)
    return kept


def differences(ours, theirs):
    """Return the first difference, or nothing."""
    for number, (mine, other) in enumerate(zip(ours, theirs, strict=False)):
        for key, value in other.items():
            same = mine.get(key) == value
            if not same and not isinstance(value, str) and key in mine:
                relative = 1e-3 if key == "f" else 0.0
                same = mine[key] == pytest.approx(value, abs=NEAR, rel=relative)
            if not same:
                return f"row {number}: {key}: ours {mine}, theirs {other}"
    return "" if len(ours) == len(theirs) else f"{len(ours)} rows, theirs {len(theirs)}"


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.stem)
def test_programs_move_as_on_linuxcnc(path, anchor, tmp_path):
    text = read_program(path)
    theirs = canonical_calls(text, anchor.tools, tmp_path)
    if theirs is None:
        pytest.skip("LinuxCNC refuses it")
    meaning = interpret(text, anchor, path.name)
    assert not meaning.stopped, meaning.findings
    assert differences(compared(canon_rows(meaning)), compared(theirs)) == ""


@pytest.mark.parametrize("tens", range(0, 80, 10))
def test_random_programs_move_as_on_linuxcnc(tens, anchor, tmp_path):
    for seed in range(tens, tens + 10):
        text = random_program(seed)
        theirs = canonical_calls(text, anchor.tools, tmp_path)
        meaning = interpret(text, anchor, "random.ngc")
        assert meaning.stopped == (theirs is None), (seed, meaning.findings)
        if theirs is not None:
            wrong = differences(compared(canon_rows(meaning)), compared(theirs))
            assert wrong == "", (seed, text)
