"""Real programs, interpreted to their end."""

import re
from pathlib import Path

import numpy as np
import pytest
from nc.controls import make_control

from gcodesim.nc.control.runs import Runs
from gcodesim.nc.control.supply import ToolEntry, WorkOffset
from gcodesim.nc.iso.interpreter import interpret
from gcodesim.nc.lines import read_program
from gcodesim.nc.program import Kind

PROGRAM = Path(__file__).parents[1] / "data" / "real" / "mamp_model1_bc.nc"


CONTROL = make_control(
    "fanuc",
    axes="XYZBC",
    tool_for_all=True,
    ignore_words=("E",),
    m_codes={104: "none", 109: "none"},
)


def test_every_line_of_a_printing_path_is_followed():
    meaning = interpret(read_program(PROGRAM), CONTROL, PROGRAM.name)
    assert (meaning.blocks, meaning.last_line, meaning.line_count) == (34453, 34453, 34453)
    assert not meaning.stopped
    assert [finding.meaning for finding in meaning.findings] == ["spindle_off_feed"]
    text = PROGRAM.read_text()
    assert f"word E ({text.count('E')} times)" in meaning.ignored
    assert meaning.unsupported == ()
    program = meaning.program
    assert (program.kind == Kind.ARC).sum() == 0
    assert (program.to[:, 5].min(), program.to[:, 5].max()) == (-2689.72, 2912.699)
    assert program.to[program.kind <= Kind.ARC][-1].tolist() == [0.0, 0.0, 230.0, 0.0, 0.0, 0.0]


@pytest.mark.parametrize(("name", "blocks"), [("nist_box_op5", 18753), ("nist_plate1", 4152)])
def test_production_programs_are_followed_to_their_end(name, blocks):
    path = PROGRAM.with_name(f"{name}.nc")
    numbers = {int(n) for n in re.findall(r"[TH]([0-9]+)", path.read_text(encoding="latin-1"))}
    tools = {n: ToolEntry(n, (0.0, 0.0, 100.0, 0.0, 0.0, 0.0), 10.0) for n in numbers}
    offsets = {n: WorkOffset() for n in range(1, 10)}
    control = make_control("fanuc", axes="XYZ", tools=tools, offsets=offsets)
    meaning = interpret(read_program(path), control, path.name)
    assert meaning.findings == ()
    assert (meaning.blocks, meaning.stopped) == (blocks, False)
    assert meaning.last_line == meaning.line_count - 1
    assert (meaning.program.kind == Kind.ARC).sum() > 500


def test_runs_mean_what_the_general_way_makes_of_them(monkeypatch):
    text = read_program(PROGRAM)[:200_000] + "\nG20 G91 N7 G1 X1 F2\nN8 C3\nG0 F5\nX1"
    short = interpret(text, CONTROL).program
    monkeypatch.setattr(Runs, "take", lambda self, source, index, most: 0)
    general = interpret(text, CONTROL).program
    for column in ("kind", "line", "to", "f", "feed_mode", "speed", "aux"):
        np.testing.assert_array_equal(getattr(short, column), getattr(general, column))
    assert len(short) > 3000
