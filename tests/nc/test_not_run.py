"""What of a program did not run, or may run in another way, is counted and has a first line."""

import pytest
from nc.controls import make_control

from gcodesim.nc.interpret import interpret


def not_run(text, **control):
    meaning = interpret(text, make_control(**control), "p.nc")
    return [(entry.what, entry.count, entry.line) for entry in meaning.not_run]


def test_a_program_that_runs_whole_has_nothing_to_say():
    assert not_run("%\nO1\nG0 X1\nM98 P2\nM30\nO2\nX2\nM99\n%\n") == []


def test_blocks_after_the_end_are_counted():
    text = "G0 X1\nM30\n\nX2\n(no block)\nG91\n"
    assert not_run(text) == [("blocks after the program's end", 2, 4)]


def test_blocks_that_a_jump_has_reached_are_not_among_them():
    text = "G0 X1\nGOTO5\nN1 M30\nN5 X2\nGOTO1\nX3\n"
    assert not_run(text) == [("blocks after the program's end", 2, 5)]


def test_blocks_called_after_the_end_are_not_among_them():
    text = "G0 X1\nM97 P8\nM30\nX4\nN8 X2\nM99\n"
    assert not_run(text, dialect="haas") == [("blocks after the program's end", 1, 4)]


def test_blocks_after_a_refused_one_are_counted():
    text = "G0 X1\nX\nX2\nX3\n"
    assert not_run(text) == [("blocks after the one at which the check stopped", 2, 3)]


def test_programs_that_nothing_called_are_counted():
    text = "O1\nG0 X1\nM98 P3\nM30\nO2\nX2\nM99\nO3\nX3\nM99\nO4\nM30\n"
    assert not_run(text) == [("programs of the file that were not called", 2, 5)]


@pytest.mark.parametrize(("left_out", "way"), [(True, "left out"), (False, "run")])
def test_marked_blocks_say_which_way_they_were_taken(left_out, way):
    found = not_run("G0 X1\n/X2\n/X3\nM30\n", block_delete=left_out)
    assert found == [(f"blocks marked /, {way}", 2, 2)]


def test_stops_are_counted_and_the_end_is_none():
    text = "G0 X1\nM0\nX2\nM1\nM30\n"
    assert not_run(text) == [("stops, at which an operator may do anything", 2, 2)]
