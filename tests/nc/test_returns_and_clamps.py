"""A table that has wound up returns by a reading; one that a brake may hold is told of."""

import pytest
from nc.controls import make_control

from gcodesim.nc.control.supply import ToolEntry
from gcodesim.nc.interpret import interpret
from gcodesim.nc.program import Kind

TABLE = {"wrap": {"C": "shortest"}}
TOOLS = {n: ToolEntry(n, (0.0, 0.0, 50.0 * n, 0.0, 0.0, 0.0), 6.0) for n in (1, 2)}


def run(text, dialect="fanuc", **given):
    return interpret(f"{text}\nM30", make_control(dialect, **given))


def last(meaning):
    program = meaning.program
    return program.to[program.kind <= Kind.ARC][-1].tolist()


@pytest.mark.parametrize(
    ("wound", "dialect", "given", "ends"),
    [
        (365, "fanuc", {}, 360),
        (3650, "fanuc", {}, 3600),
        (3650, "linuxcnc", {}, 3600),
        (3650, "fanuc", {"g28_rotary": "unwind"}, 0),
        (3650, "fanuc", {"wrap": {}}, 0),
        (3650, "haas", {}, 3600),
    ],
)
def test_a_wound_table_returns_by_at_most_one_turn_where_it_is_not_unwound(
    wound, dialect, given, ends
):
    meaning = run(f"G91 G0 C{wound}\nG28 C0\nG90", dialect, **(TABLE | given))
    assert last(meaning)[5] == ends
    assert [r.key for r in meaning.readings if r.key == "g28_rotary"] == (
        ["g28_rotary"] if dialect == "haas" else []
    )


def test_a_table_within_half_a_turn_depends_on_nothing():
    assert "g28_rotary" not in [r.key for r in run("G0 C90\nG28 C0", "haas", **TABLE).readings]


CHANGE = "T1 M6\nG43 H1 G0 Z0\nT2 M6\n"


def test_a_haas_may_take_the_length_of_the_new_tool_until_the_program_gives_one():
    keys = {"tools": TOOLS, "tool_change": "stays"}
    assert last(run(CHANGE + "Z1", "haas", **keys))[2] == 51
    new = run(CHANGE + "Z1", "haas", **keys, length_at_tool_change="new_tool")
    assert last(new)[2] == 101
    assert [r.key for r in run(CHANGE + "Z1", "haas", **keys).readings] == ["length_at_tool_change"]
    for settled in ("G43 H2 Z1", "G91 Z1", "G49 Z1"):
        assert run(CHANGE + settled, "haas", **keys).readings == ()
    assert run(CHANGE + "Z1", tools=TOOLS, tool_change="stays").readings == ()


BRAKES = {10.0: "clamp", 11.0: "unclamp", 60.0: "clamp"}


@pytest.mark.parametrize("code", ["M10", "M60"])
def test_an_axis_that_turns_after_a_clamp_is_told_once_a_code(code):
    meaning = run(f"{code}\nG0 X5 Z5\nC90\nC0", m_codes=BRAKES)
    (note,) = meaning.findings
    assert (note.code, note.meaning, note.line) == ("GC430", "clamped_axis", 3)
    assert note.message.startswith(f"C turns after {code}")


def test_what_lets_go_ends_it_and_plain_lines_are_looked_at_too():
    assert run("M10\nM11\nG0 C90", m_codes=BRAKES).findings == ()
    lines = "\n".join(f"G0 X{i}" for i in range(40))
    meaning = run(f"M10\n{lines}\n{lines} C5\n{lines}", m_codes=BRAKES)
    assert [f.line for f in meaning.findings] == [81]
    assert run("M10\nG0 C90").findings == ()
