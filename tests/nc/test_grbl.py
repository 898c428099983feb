"""Grbl: few codes, no macros, settings between the blocks, and G0 before the first block."""

import pytest

from gcodesim.nc.control.readings import ROWS
from gcodesim.nc.detect import dialect_of, neighbour_of
from gcodesim.nc.interpret import interpret
from gcodesim.nc.program import Kind


def moves(meaning):
    program = meaning.program
    straight = [i for i in range(len(program)) if program.kind[i] in (Kind.RAPID, Kind.FEED)]
    return [(Kind(program.kind[i]).name, *program.to[i, :3].tolist()) for i in straight]


def test_axis_words_before_any_motion_code_are_rapid(control):
    meaning = interpret("X1\nG1 X2 F100\nM30", control("grbl"))
    assert moves(meaning) == [("RAPID", 1, 0, 0), ("FEED", 2, 0, 0)]


def test_g53_under_g91_moves_to_its_words(control):
    meaning = interpret("G91 X1\nG53 G0 X5\nG0 X1\nM30", control("grbl"))
    assert [to for _, to, *_ in moves(meaning)] == [1, 5, 6]


def test_a_slash_leaves_nothing_out(control):
    meaning = interpret("/X1\nM30", control("grbl", block_delete=True))
    assert moves(meaning) == [("RAPID", 1, 0, 0)]


def test_settings_are_passed_by_and_orders_that_move_are_refused(control):
    assert moves(interpret("$110=500\n$X\nX1\nM30", control("grbl"))) == [("RAPID", 1, 0, 0)]
    for order in ("$H", "$J=X10 F100"):
        meaning = interpret(f"X1\n{order}\nM30", control("grbl"))
        assert [(f.code, f.line) for f in meaning.findings if f.severity == "error"] == [
            ("GC402", 2)
        ]


@pytest.mark.parametrize("block", ["G81 X1 Z-1 R1 F9", "G41 D1 X1", "G43 H1", "G68 R5"])
def test_codes_that_grbl_has_not_are_unknown(block, control):
    meaning = interpret(f"G1 X0 F100\n{block}\nM30", control("grbl"))
    assert meaning.findings[-1].code in ("GC402", "GC420")


def test_macro_text_is_refused(control):
    meaning = interpret("#1=5\nX#1\nM30", control("grbl"))
    assert (meaning.findings[-1].code, meaning.findings[-1].line) == ("GC402", 1)


def test_a_centre_word_along_the_normal_counts_for_nothing_beside_others(control):
    arc = "G1 X0 F100\nG2 X2 Y0 I1 J0 K5\nM30"
    meaning = interpret(arc, control("grbl"))
    assert not meaning.stopped
    assert Kind.ARC in meaning.program.kind
    alone = interpret("G1 X0 F100\nG2 X2 Y0 K5\nM30", control("grbl"))
    assert alone.findings[-1].code == "GC404"


def test_grbl_and_neighbours_are_recognised():
    assert dialect_of(["$110=500", "G0 X1"], ROWS)[0] == "grbl"
    assert dialect_of(["G0 X1"], ROWS)[0] == "fanuc"
    assert neighbour_of(["%", "O1 (POST FOR MAZAK SMOOTH)"]) == "MAZAK"
    assert neighbour_of(["MAZAK"]) == ""
