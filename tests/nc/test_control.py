"""What a control can be told, told by a toy language and by itself: no word of ISO is needed."""

import ast
import math
from pathlib import Path

import numpy as np
import pytest
from nc.table_tilt import TableTilt
from nc.toy_language import Toy

import gcodesim.nc.control
from gcodesim.nc.control import five_axes, moves, orders, tool_changes
from gcodesim.nc.control.drilling import Dwell, FeedTo, Hole, RapidTo, Shift, drill
from gcodesim.nc.control.frames import WORK, Frames, Level, mirrored_at, rotation, turned_about
from gcodesim.nc.control.interpreter import Interpreter
from gcodesim.nc.control.modal import CutterSide, TipControl
from gcodesim.nc.control.moves import How
from gcodesim.nc.control.readings import choose_readings
from gcodesim.nc.control.runs import Runs
from gcodesim.nc.control.state import State
from gcodesim.nc.control.supply import Control, ToolEntry
from gcodesim.nc.program import Kind

PROGRAM = """tool 3
frame 10 20 0
go X0 Y0 Z5
cut Z0 F300
loop 3
arc X0 Y10 centre 0 5
arc X0 Y0 centre 0 5
again
{plain}
go Z50
"""


def toy(text, **supplied):
    control = Control(choose_readings("fanuc"), **supplied)
    return Interpreter(Toy(control), lambda fraction: None).run(text, "part.toy")


def state(**supplied):
    made = State(Control(choose_readings("fanuc"), **supplied))
    made.modal.feed, made.modal.feed_given = 100.0, True
    made.frames.update()
    return made


def recorded(made):
    return made.recorder.program(made.start)


def test_a_toy_language_moves_cuts_arcs_and_loops():
    meaning = toy(PROGRAM.format(plain="1 2 3"))
    program = meaning.program
    kinds = [Kind(kind) for kind in program.kind if kind != Kind.MESSAGE]
    assert kinds == [Kind.TOOL, Kind.RAPID, Kind.FEED, *[Kind.ARC] * 6, Kind.FEED, Kind.RAPID]
    assert program.aux[0] == 3
    np.testing.assert_allclose(program.to[1, :3], [10.0, 20.0, 5.0])
    np.testing.assert_allclose(program.to[-1, :3], [11.0, 22.0, 50.0])
    assert (meaning.blocks, meaning.last_line) == (16, 10)
    assert {finding.meaning for finding in meaning.findings} == {
        *("tool_without_shape", "spindle_off_feed", "program_end_missing")
    }


def test_plain_lines_of_a_toy_language_mean_the_same_through_columns(monkeypatch):
    points = np.round(np.random.default_rng(4).uniform(-50, 50, (300, 3)), 3)
    plain = "\n".join(" ".join(str(value) for value in point) for point in points)
    take, counts = Runs.take, []

    def counted(runs, *where):
        counts.append(take(runs, *where))
        return counts[-1]

    monkeypatch.setattr(Runs, "take", counted)
    taken = toy(PROGRAM.format(plain=plain))
    assert sum(counts) == 300
    monkeypatch.setattr(Runs, "take", lambda *_: 0)
    alone = toy(PROGRAM.format(plain=plain))
    for column in ("kind", "line", "to", "f", "feed_mode", "aux"):
        np.testing.assert_array_equal(
            getattr(taken.program, column), getattr(alone.program, column)
        )
    assert (taken.blocks, taken.last_line) == (alone.blocks, alone.last_line)


def test_a_refused_line_of_a_toy_language_is_taken_back_and_named():
    control = {"tools": {1: ToolEntry(1, (0.0,) * 6, 10.0)}}
    meaning = toy("tool 1\ngo X1\ntool 9\ngo X2", **control)
    (finding,) = [f for f in meaning.findings if f.severity == "error"]
    assert (finding.meaning, finding.line, finding.file) == ("tool_not_found", 3, "part.toy")
    assert meaning.stopped
    assert len(meaning.program) == 2


def test_meaning_knows_no_language():
    for file in Path(gcodesim.nc.control.__file__).parent.glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text("utf-8"))):
            if isinstance(node, ast.ImportFrom):
                assert "iso" not in (node.module or "").split("."), file


def test_every_word_may_say_what_it_counts_from():
    made = state(wrap={"C": "shortest"})
    made.point = [10.0, 20.0, 30.0, 0.0, 0.0, 350.0]
    made.position = list(made.point)
    how = {0: How.INCREMENTAL, 1: How.ABSOLUTE, 5: How.POSITIVE}
    assert moves.point_to(made, {0: 1.0, 1: 2.0, 5: 10.0}, how) == [11, 2, 30, 0, 0, 370]
    assert moves.point_to(made, {5: 10.0}, {5: How.NEGATIVE})[5] == 10.0
    assert moves.point_to(made, {5: 340.0}, {5: How.POSITIVE})[5] == 700.0
    assert moves.point_to(made, {5: 10.0}, {5: How.SHORTEST})[5] == 370.0
    assert moves.point_to(made, {5: 10.0}, {5: How.INCREMENTAL})[5] == 360.0


def test_levels_act_from_the_last_to_the_first():
    frames = Frames((WORK, "shift", "turn", "mirror"))
    frames.levels[WORK] = Level((100.0, 0.0, 0.0, 0.0, 0.0, 7.0))
    frames.levels["shift"] = Level((0.0, 10.0, 0.0, 0.0, 0.0, 0.0))
    frames.levels["turn"] = turned_about([1.0, 0.0, 0.0], rotation(2, 90.0))
    frames.levels["mirror"] = mirrored_at({0: 2.0})
    frames.update()
    # Mirrored at x = 2: 3 -> 1; a quarter turn about (1, 0); then the shifts.
    position = frames.machine([3.0, 4.0, 5.0, 0.0, 0.0, 1.0])
    np.testing.assert_allclose(position, [97.0, 10.0, 5.0, 0.0, 0.0, 8.0])
    np.testing.assert_allclose(frames.program(position), [3.0, 4.0, 5.0, 0.0, 0.0, 1.0])
    assert frames.mirrored
    assert frames.joined == 2


@pytest.mark.parametrize("degrees", [90.0, 33.0])
def test_a_plane_that_is_set_further_tilts_in_the_plane_in_force(degrees):
    made = State(
        Control(choose_readings("fanuc"), kinematics=TableTilt(), axes="XYZAC"), (WORK, "plane")
    )
    five_axes.set_plane(made, "plane", rotation(0, degrees), [1.0, 2.0, 3.0])
    five_axes.set_further_plane(made, "plane", rotation(0, -degrees), [0.0, 0.0, 10.0])
    angle = math.radians(degrees)
    shift = [1.0, 2.0 - 10.0 * math.sin(angle), 3.0 + 10.0 * math.cos(angle)]
    np.testing.assert_allclose(made.frames.levels["plane"].shift[:3], shift, atol=1e-12)
    np.testing.assert_allclose(made.frames.levels["plane"].turn, np.eye(3), atol=1e-12)
    five_axes.end_plane(made, "plane")
    assert not made.frames.tilted
    assert made.frames.matrix is None


def test_a_hole_is_drilled_by_its_steps():
    made = state()
    steps = [FeedTo(-5.0), Dwell(0.5), Dwell(0.0), Shift(1.0, 0.0), RapidTo(2.0)]
    drill(made, Hole(steps, level=1.0), [10.0, 20.0, 99.0, 0.0, 0.0, 0.0])
    program = recorded(made)
    assert [Kind(k) for k in program.kind] == [
        *(Kind.RAPID, Kind.RAPID, Kind.FEED, Kind.DWELL, Kind.RAPID, Kind.RAPID)
    ]
    moved = program.to[program.kind <= Kind.FEED][:, :3]
    np.testing.assert_array_equal(
        moved, [[0, 0, 1], [10, 20, 1], [10, 20, -5], [11, 20, -5], [11, 20, 2]]
    )


def test_a_tool_goes_back_along_itself_as_far_as_the_travel_allows():
    made = state(travel={"Z": (-100.0, 80.0)})
    moves.retract(made, 30.0)
    moves.retract(made, None)
    assert recorded(made).to[:, 2].tolist() == [30.0, 80.0]


def test_a_tilted_tool_goes_back_along_itself():
    made = state(kinematics=TableTilt(), axes="XYZAC", start={"A": 30.0})
    before = made.axes
    moves.retract(made, 10.0)
    kinematics = TableTilt()
    tips = kinematics.tips(np.array([before, made.axes]), np.zeros((2, 3)))
    direction = kinematics.directions(np.array([before[3:]]))[0]
    np.testing.assert_allclose(tips[1] - tips[0], 10.0 * direction, atol=1e-9)


def test_a_retract_without_the_data_it_needs_is_refused():
    made = state(retract={"Z": 50.0})
    moves.retract_axes(made, "Z")
    assert made.axes[2] == 50.0
    for ask in (lambda: moves.retract(made, None), lambda: moves.retract_axes(made, "XZ")):
        with pytest.raises(Exception, match="GC402") as error:
            ask()
        assert error.value.finding.meaning == "retract_unknown"


def test_orders_that_move_nothing_are_recorded():
    made = state()
    made.frames.levels[WORK] = Level((5.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    made.frames.update()
    orders.define_stock(made, [0.0, 0.0, -10.0], [100.0, 50.0, 0.0])
    orders.dwell(made, 2.0)
    orders.compensate(made, CutterSide.LEFT, "RL")
    orders.stop(made, 30, ends=True)
    program = recorded(made)
    assert program.stock == ([5.0, 0.0, -10.0], [105.0, 50.0, 0.0])
    assert [Kind(k) for k in program.kind] == [Kind.DWELL, Kind.STOP]
    assert made.ended
    assert made.modal.side is CutterSide.LEFT
    assert [finding.meaning for finding in made.findings] == ["cutter_comp_uncompensated"]


def test_tool_centre_point_control_moves_nothing():
    made = state(kinematics=TableTilt(), axes="XYZAC", start={"X": 10.0, "A": 30.0})
    before = made.axes
    tool_changes.set_length(made, [0.0, 0.0, 100.0, 0.0, 0.0, 0.0], TipControl.ANGLES)
    assert made.axes == before
    five_axes.set_tip_control(made, TipControl.OFF)
    assert made.axes == before
    assert [Kind(k) for k in recorded(made).kind] == [Kind.TOOL_OFFSET]
