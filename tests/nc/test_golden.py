"""Programs interpreted by LinuxCNC 2.9: ours must move the machine as it does."""

import csv
import json
from pathlib import Path

import pytest

from gcodesim.findings.codes import INCONCLUSIVE, NOTED
from gcodesim.nc.canon import canon_rows
from gcodesim.nc.control.supply import WorkOffset
from gcodesim.nc.interpret import interpret
from gcodesim.nc.lines import read_program

GOLDEN = Path(__file__).parent / "golden"
ROWS = list(csv.DictReader((GOLDEN / "expect.tsv").read_text().splitlines(), delimiter="\t"))
MACHINE_ZERO = {code: dict.fromkeys("XYZABC", 0.0) for code in ("G28", "G30")}
# The anchor drops a long first line; ours runs it (note in expect.tsv).
NOT_COMPARED = {"err_70_long_line"}


@pytest.fixture
def meaning_of(control):
    offsets = {index: WorkOffset() for index in range(1, 10)}
    anchor = control("linuxcnc", offsets=offsets, reference=MACHINE_ZERO)
    return lambda name: interpret(read_program(GOLDEN / f"{name}.ngc"), anchor, f"{name}.ngc")


def anchor_rows(name):
    lines = (GOLDEN / f"{name}.jsonl").read_text().splitlines()
    return [row for row in map(json.loads, lines) if row["line"] > 0]


def moves_only(rows, source):
    """Drop what the README allows to differ: reset at the end, moves of no length, errors.

    With every work offset the anchor repeats the G92 offset that is in force already.
    M61 is our own difference: the anchor changes the tool without an event, we record it.
    """
    kept, position, g92 = [], [0.0] * 6, [0.0] * 6
    for row in (row for row in rows if row["line"] > 0):
        words = source[row["line"] - 1].upper()
        reset = row["kind"] in ("g5x", "g92") and words.startswith(("M2", "M30"))
        still = row["kind"] in ("rapid", "feed") and row["to"] == pytest.approx(position, abs=1e-9)
        position = row.get("to", position)
        repeated = row["kind"] == "g92" and row["value"] == g92
        g92 = row["value"] if row["kind"] == "g92" else g92
        if not (reset or repeated or still or row["kind"] == "error" or "M61" in words):
            kept.append(row)
    return kept


@pytest.mark.parametrize("name", [row["program"] for row in ROWS if row["anchor"] == "ok"])
def test_moves_equal_the_anchor(name, meaning_of):
    meaning = meaning_of(name)
    ours = moves_only(canon_rows(meaning), meaning.lines)
    theirs = moves_only(anchor_rows(name), meaning.lines)
    if name in NOT_COMPARED:
        assert [row["to"][0] for row in ours] == [1.0]
        return
    assert len(ours) == len(theirs)
    for mine, golden in zip(ours, theirs, strict=True):
        assert mine.keys() == golden.keys()
        for key, value in golden.items():
            exact = isinstance(value, str)
            assert mine[key] == (value if exact else pytest.approx(value, abs=1e-6)), mine


NOTED_ONLY = {"spindle_off_feed", "length_not_of_tool"}


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row["program"])
def test_outcome_is_as_expected(row, meaning_of):
    meaning = meaning_of(row["program"])
    findings = [f for f in meaning.findings if f.meaning not in NOTED_ONLY]
    accepted = {row["meaning"], "exact_path_assumed"}
    accepted |= {"duplicate_word"} if "duplicate_word" in row["note"] else set()
    assert {f.meaning for f in findings} <= accepted
    match row["ours"]:
        case "ok":
            assert not findings
        case "error":
            assert meaning.stopped
            assert findings[-1].severity == "error"
            assert findings[-1].line == int(row["line"])
        case "inconclusive":
            assert not meaning.stopped
            assert findings[0].effect == INCONCLUSIVE
        case "warning":
            assert findings[0].effect == NOTED
            assert findings[0].line == int(row["line"])


def test_refused_blocks_stop_after_the_moves_before_them(meaning_of):
    ours = moves_only(canon_rows(meaning := meaning_of("misc")), meaning.lines)
    theirs = moves_only(anchor_rows("misc"), meaning.lines)
    assert [(r["line"], r["kind"]) for r in ours] == [(r["line"], r["kind"]) for r in theirs]
