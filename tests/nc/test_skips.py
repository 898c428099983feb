"""After a skip move nobody knows where the axes stand, until a word tells them where to go."""

import pytest
from nc.controls import make_control

from gcodesim.nc.interpret import interpret
from gcodesim.nc.program import Kind

SKIP = "G90 F100 G0 X1 Z50\nG31 Z10\n"


def run(text, dialect="fanuc", **given):
    return interpret(f"{text}\nM30", make_control(dialect, **given))


def unknown_in(meaning):
    return [f.line for f in meaning.findings if f.meaning == "position_unknown"]


def touching(meaning):
    """X and Z of the moves, and whether the flute may touch there."""
    program = meaning.program
    moves = [i for i in range(len(program)) if program.kind[i] <= Kind.ARC and program.line[i] > 1]
    marked = set(program.touching.tolist())
    return [(program.to[i, 0], program.to[i, 2], i in marked) for i in moves]


def test_the_way_back_may_touch_and_what_lies_beyond_it_may_not():
    meaning = run(SKIP + "G0 Z80\nX9")
    assert touching(meaning) == [
        (1, 10, True), (1, 50, True), (1, 80, False), (9, 80, False)
    ]  # fmt: skip
    assert unknown_in(meaning) == []


@pytest.mark.parametrize(
    "back",
    ["G0 Z50", "G0 Z30", "G1 Z30", "G91 G28 Z0", "G53 G0 Z90", "G28 Z50", "G91 G0 Z5\nG90 Z50"],
)
def test_going_back_is_no_question(back):
    meaning = run(f"{SKIP}{back}\nG90 G0 X9", reference={"G28": {"Z": 90.0}})
    assert unknown_in(meaning) == []
    assert not touching(meaning)[-1][2]


@pytest.mark.parametrize(
    "on", ["G0 X5", "G0 Z5", "G0 X5 Z50", "G0 Z10", "G91 G0 Z-3", "G91 G0 Z41", "G2 X3 Z10 R1 G18"]
)
def test_going_elsewhere_from_an_unknown_place_is_inconclusive(on):
    assert unknown_in(run(SKIP + on))[0] == 3


def test_a_word_of_its_own_makes_an_axis_known_again():
    meaning = run(SKIP + "G0 X5 Z60\nX9\nZ20")
    assert unknown_in(meaning) == [3]
    assert [may_touch for *_, may_touch in touching(meaning)] == [True, True, False, False]


def test_a_second_touch_along_the_first_is_no_question():
    assert unknown_in(run(SKIP + "G91 G0 Z2\nG31 Z-4\nG90 G0 Z50")) == []
    assert unknown_in(run(SKIP + "G31 X5")) == [3]


@pytest.mark.parametrize("text", ["G92 Z0", "G10 L10 P1 Z0"])
def test_a_table_is_not_set_from_where_a_probe_has_stopped(text):
    tools = {}
    meaning = run(SKIP + text, tools=tools)
    known = [f.meaning for f in run(SKIP + text.replace("Z", "X"), tools=tools).findings]
    assert "measured_by_probe" not in known
    assert (text.startswith("G92") and meaning.stopped) or "G10" in text


@pytest.mark.parametrize("text", ["#1=#5043\nG0 X#1", "#1=#5063"])
def test_a_parameter_that_only_the_probe_knows_stops(text):
    assert run(SKIP + text).findings[-1].meaning == "parameter_unknown"
    assert not run(SKIP + "#1=#5041\nG0 Z50\n#1=#5043").stopped


def test_linuxcnc_probes_alike():
    skip = SKIP.replace("G31", "G38.2")
    assert unknown_in(run(skip + "G0 Z50", "linuxcnc")) == []
    assert unknown_in(run(skip + "G0 X50", "linuxcnc")) == [3]
    assert run(skip + "G10 L20 P1 Z0", "linuxcnc").findings[-1].meaning == "measured_by_probe"


def test_many_plain_lines_after_a_skip_are_read_one_by_one_until_it_is_over():
    lines = "\n".join(f"G0 X{i} Z{60 + i}" for i in range(40))
    assert unknown_in(run(SKIP + lines)) == [3]
