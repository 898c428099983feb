"""Every program in good/ becomes its .canon; each one in bad/ earns its first line's meaning."""

import re
from pathlib import Path

import pytest
from nc.table_tilt import MEANINGS as FIVE_AXIS
from nc.table_tilt import RAISED

from gcodesim.findings.meanings import LANGUAGE_MEANINGS, MEANINGS
from gcodesim.nc.canon import canon_rows
from gcodesim.nc.interpret import interpret
from gcodesim.nc.lines import read_program

HERE = Path(__file__).parent
GOOD = sorted((HERE / "good").glob("*.nc"))
BAD = sorted((HERE / "bad").glob("*.nc"))
DIALECT = re.compile(r"fanuc|haas|linuxcnc")
NOTE = "spindle_off_feed"
EXPECTED = re.compile(r"; (\w+) (\d+)(?: (fanuc|haas|linuxcnc))?")


def as_text(row):
    """One canonical command in one readable line."""
    values = [row["line"], row["kind"]]
    values += [row[key] for key in ("plane", "index", "seconds") if key in row]
    values += row.get("to", row.get("value", []))
    values += ["center", *row["center"], "turns", row["turns"]] if "center" in row else []
    values += ["f", row["f"]] if "f" in row else []
    values += [row["text"].strip()] if "text" in row else []
    return " ".join(
        f"{round(value, 9) + 0.0:g}" if isinstance(value, float) else str(value) for value in values
    )


@pytest.mark.parametrize("path", GOOD, ids=lambda path: path.stem)
def test_good_program_becomes_its_canon(path, control):
    text = read_program(path)
    dialect = DIALECT.search(text)[0]
    meaning = interpret(text, control(dialect), path.name)
    rows = [as_text(row) for row in canon_rows(meaning) if row["line"] > 0]
    assert rows == path.with_suffix(".canon").read_text().splitlines()
    left = [f for f in meaning.findings if f.severity != "note"]
    assert [f for f in left if f.meaning != "length_not_of_tool"] == []
    assert not meaning.stopped


@pytest.mark.parametrize("path", BAD, ids=lambda path: path.stem)
def test_bad_program_earns_its_finding(path, control):
    text = read_program(path)
    expected, line, dialect = EXPECTED.match(text).groups()
    meaning = interpret(text, control(dialect or "fanuc"), path.name)
    (finding,) = (f for f in meaning.findings if f.meaning == expected or f.meaning != NOTE)
    assert (finding.meaning, finding.line) == (expected, int(line))
    assert finding.code == MEANINGS[expected][0]
    assert finding.file == path.name
    assert finding.block == meaning.lines[int(line) - 1]
    assert 1 <= finding.column <= max(1, len(finding.block))
    assert meaning.stopped == (finding.severity == "error")
    behind = int(line) if finding.severity == "error" else 10**9
    assert all(meaning.program.line < behind)


def test_every_meaning_has_a_bad_program_or_a_test_of_its_own():
    # No table, few blocks, few axes: test_interpreter.py; kinematics: test_five_axis.py; what no
    # ISO word asks for: test_control.py.
    elsewhere = {"tool_without_shape", "max_blocks", "rotary_axes_missing", "retract_unknown"}
    # Told by the text: test_detect.py. Points and units: test_lengths.py. Asked for by a key:
    # test_readings.py.
    elsewhere |= {"no_point_open", "unit_assumed", "unit_open", "cycle_return_unusable"}
    # Told by the text: test_detect.py; by the machine file: test_programs_in_control.py.
    elsewhere |= {"dialect_told", "program_of_probe", "clamped_axis", *FIVE_AXIS, *RAISED}
    # A file beside the program says it: tests/machine/test_offsets_and_words.py.
    elsewhere |= {"subprogram_other_number"}
    seen = {EXPECTED.match(read_program(path))[1] for path in BAD}
    assert seen | elsewhere == set(LANGUAGE_MEANINGS)
