"""Which G codes move an axis by the axis words beside them, in every dialect."""

import pytest

from gcodesim.nc.control.readings import ROWS
from gcodesim.nc.interpret import interpret
from gcodesim.nc.iso.code_rows import Order
from gcodesim.nc.iso.words import codes_of
from gcodesim.nc.program import Kind

MOVES = (Kind.RAPID, Kind.FEED, Kind.ARC)

MOVED_BY = {"straight", "arc", "run_cycle", "probe", "return_to_reference"}
"""Actions of the table that move axes by axis words."""


def moved(text, supply):
    meaning = interpret(text, supply)
    return [kind for kind in meaning.program.kind if kind in MOVES], meaning


@pytest.mark.parametrize("dialect", ROWS)
def test_only_known_codes_move_by_axis_words(dialect, control):
    """A code nobody knows moves nothing, and one that claims the words moves nothing either."""
    rows, supply = codes_of(dialect), control(dialect)
    for number in range(10_000):
        row = rows.get(("G", number))
        if row is not None and not row.refused and not row.takes_axes:
            continue
        if row is not None and (row.order is Order.MOTION or row.action in MOVED_BY):
            continue
        kinds, meaning = moved(f"G1 F99 G{number / 10:g} X7 Y8 Z9", supply)
        allowed = row is not None and row.optional
        assert allowed or not kinds, (dialect, number, meaning.findings)
        if row is None or row.refused:
            assert meaning.stopped, (dialect, number)


@pytest.mark.parametrize("code", ["G5.1 Q2", "G10 L2 P1", "G50.1", "G52", "G92", "G22", "G92.1"])
def test_words_that_are_named_move_nothing_in_the_mode_in_force(code, control):
    kinds, meaning = moved(f"G1 F99\n{code} X7 Y8 Z9\nM30", control("fanuc"))
    assert not kinds
    assert not meaning.stopped, meaning.findings


def test_switching_off_what_was_never_on_changes_nothing(control):
    codes = "G9 G11 G13.1 G15 G23 G25 G26 G40.1 G49.1 G50 G50.1 G62 G63 G67 G69 G69.1 G80"
    for code in codes.split():
        kinds, meaning = moved(f"G0 {code} X5\nM30", control("fanuc"))
        assert (len(kinds), meaning.stopped) == (1, False), code


@pytest.mark.parametrize("dialect", ["fanuc", "haas"])
@pytest.mark.parametrize("code", ["G43.1 X1", "G43.2 H1", "G92.2", "G92.3", "G38.2 X1 F9"])
def test_no_meaning_of_linuxcnc_is_read_on_other_controls(dialect, code, control):
    meaning = interpret(f"{code}\nM30", control(dialect))
    assert [finding.code for finding in meaning.findings] == ["GC402"]


def test_codes_of_haas_move_nothing_or_are_refused_by_name(control):
    followed = "M31\nG103 P1\nM88\nG187 P1\nM89\nM33\nG0 X1\nM30"
    assert not interpret(followed, control("haas")).findings
    for code in ("G13 I3 D1 F9", "G70 I5 L4", "G150 X1", "G36", "G174 Z1", "G12.1"):
        (finding,) = interpret(f"{code}\nM30", control("haas")).findings
        assert (finding.code, code.split()[0] in finding.message) == ("GC402", True)
