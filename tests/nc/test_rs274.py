"""Where LinuxCNC is installed, its interpreter and ours move the machine alike."""

import shutil
from pathlib import Path

import pytest
from nc.rs274 import canonical_calls, random_program, refused_block
from needs import need

from gcodesim.nc.canon import canon_rows
from gcodesim.nc.control.supply import WorkOffset
from gcodesim.nc.interpret import interpret
from gcodesim.nc.lines import read_program

ROOT = Path(__file__).parents[2]
PROGRAMS = sorted(
    path
    for pattern in ("samples/*.nc", "tests/nc/golden/*.ngc", "tests/nc/good/*.nc")
    for path in ROOT.glob(pattern)
)
ZERO = {code: dict.fromkeys("XYZABC", 0.0) for code in ("G28", "G30")}
NEAR = 6e-3
"""Four decimals of an inch, in a point and two offsets [mm]."""

RUN_ON = {
    "samples/unknown_m": "an unknown M code makes it INCONCLUSIVE (GC420)",
    "golden/err_03_unknown_m": "an unknown M code makes it INCONCLUSIVE (GC420)",
    "golden/err_50_g54_in_comp": "cutter compensation is not applied (GC422)",
    "golden/err_70_long_line": "it takes 255 characters a line",
    "golden/err_82_g43.4": "G43.4 is read in every dialect",
    "good/home": "G4 X is read in every dialect",
    "good/offsets": "G44 is read in every dialect",
}
"""Programs with a block that LinuxCNC refuses and ours runs, and why."""

END_NAMED = {"golden/err_41_nosub", "golden/err_43_m98nosub"}
"""It looks for a subprogram down to the end of the file, and names that block."""


@pytest.fixture
def anchor(control):
    need(shutil.which("rs274"), "linuxcnc-uspace")
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
    text, name = read_program(path), f"{path.parent.name}/{path.stem}"
    theirs = canonical_calls(text, anchor.tools, tmp_path)
    meaning = interpret(text, anchor, path.name)
    if theirs is None:
        block = refused_block(text, anchor.tools, tmp_path)
        stop = meaning.lines[meaning.findings[-1].line - 1].strip() if meaning.stopped else None
        assert (stop == block) == (name not in {*RUN_ON, *END_NAMED}), (stop, block)
        assert meaning.stopped or name in RUN_ON
        return
    assert name not in RUN_ON
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
