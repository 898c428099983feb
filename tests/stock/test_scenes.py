"""Scenes with known answers: what is in the stock is found, what only touches it is not."""

from __future__ import annotations

import numpy as np
import pytest
from stock.milling import (
    Program,
    ball_mill,
    boss,
    cutter,
    drill,
    end_mill,
    last_pass,
    mill,
    path_of,
    raced,
    roughing,
    slot,
)

from gcodesim.machine.model import Machine
from gcodesim.stock.workpiece import StockEvent


def is_clear(program: Program, machine: Machine) -> bool:
    """Whether nothing is found and nothing stays open."""
    answer = raced(program, machine)
    assert not answer.too_many
    return not answer.events and not answer.undecided


def only_event(program: Program, machine: Machine) -> StockEvent:
    """The first contact, proved to be the first."""
    answer = raced(program, machine)
    assert answer.undecided == 0
    assert len(answer.events) == 1
    return answer.events[0]


def line_of(event: StockEvent, program: Program, machine: Machine) -> int:
    return int(path_of(program, machine).line[event.piece])


def time_of_block(program: Program, machine: Machine, line: int) -> float:
    """When a block begins [s]."""
    path = path_of(program, machine)
    return float(path.bounds_ps[np.flatnonzero(path.line == line)[0]]) * 1e-12


def test_a_rapid_through_a_wall_that_was_cut_before_is_free() -> None:
    assert is_clear(boss(cut_before=True), mill(end_mill()))


def test_a_rapid_through_a_wall_that_is_cut_later_is_found_when_it_is_half_an_inset_deep() -> None:
    program, machine = boss(cut_before=False), mill(end_mill())
    event = only_event(program, machine)
    line = program.blocks.index("G0 X50.0000 Y50.0000 Z-3.0000") + 1
    assert line_of(event, program, machine) == line
    # The front of the flute stands at the wall; rapids run at 24 m/min, 400 mm/s.
    exact = time_of_block(program, machine, line) + 0.025 / 400.0
    assert 0.0 <= event.time_ps * 1e-12 - exact < 4e-4
    assert event.part.role == "flute"
    assert event.depth == pytest.approx(3.0, rel=0.1)
    assert event.removed is not None
    wall = program.blocks.index("G1 F1000 X50.0000 Y50.0000 Z-5.0000") + 1
    assert int(path_of(program, machine).line[event.removed[1]]) == wall


def test_a_holder_that_reaches_the_wall_in_the_last_pass_only_is_found_there() -> None:
    machine = mill(end_mill(shank=4.0, stick=24.0))
    program = last_pass(24.5)
    event = only_event(program, machine)
    line = program.blocks.index("G1 F300 X30.0000 Y50.0000 Z-24.5000") + 1
    assert line_of(event, program, machine) == line
    # The plunge is 6.6 mm long, at 5 mm/s: the holder is half an inset deep at -24.025.
    exact = time_of_block(program, machine, line) + (6.6 - 0.475) / 5.0
    assert 0.0 <= event.time_ps * 1e-12 - exact < 4e-4
    assert event.part.role == "holder"
    assert event.depth == pytest.approx(0.5, rel=0.1)
    assert event.removed is None
    assert is_clear(last_pass(23.9), machine)


def test_a_shank_as_thick_as_its_flute_goes_along_the_walls_that_it_cut() -> None:
    answer = raced(roughing(), mill(end_mill()))
    assert (answer.events, answer.undecided) == ([], 0)
    assert is_clear(roughing(), mill(end_mill(), inset=0.2))


@pytest.mark.parametrize("inset", [0.05, 0.2])
def test_a_holder_too_low_is_found_in_the_fifteenth_layer(inset: float) -> None:
    program, machine = roughing(), mill(end_mill(stick=35.0), inset=inset)
    event = only_event(program, machine)
    line = program.blocks.index("G1 F500 X10.0000 Y10.0000 Z-37.5000") + 1
    assert line_of(event, program, machine) == line
    exact = time_of_block(program, machine, line) + (0.1 + inset / 2.0) / (500.0 / 60.0)
    assert 0.0 <= event.time_ps * 1e-12 - exact < 4e-4


def test_a_shank_a_tenth_too_thick_is_found_unless_that_is_half_of_the_inset() -> None:
    machine = mill(end_mill(shank=5.1))
    event = only_event(roughing(), machine)
    assert event.part.role == "shank"
    assert event.depth == pytest.approx(0.1, rel=0.1)
    assert is_clear(roughing(), mill(end_mill(shank=5.1), inset=0.2))


TOUCHES = {
    "a rapid out of the pocket just cut": slot().move(80, 50, 5),
    "a rapid back through the slot just cut": slot().move(20, 50, -5),
    "a rapid down to the floor just finished": slot()
    .move(80, 50, 5)
    .move(50, 50, 5)
    .move(50, 50, -5),
    "a slow feed with a stopped spindle in the slot": slot().say("M5").move(30, 50, -5, feed=500),
    "a rapid down along the end of the slot": slot()
    .move(80, 50, 5)
    .move(20, 50, 5)
    .move(20, 50, -5),
    "a rapid 0.02 mm beside the slot": slot()
    .move(80, 50.02, 5)
    .move(80, 50.02, -5)
    .move(20, 50.02, -5),
    "a plunge of the shank beyond the flute": Program()
    .move(50, 50, 5)
    .move(50, 50, -30, feed=300)
    .move(50, 50, 5),
    "a full circle back to its start": Program()
    .move(50, 40, 5)
    .move(50, 40, -5, feed=300)
    .say("G2 X50 Y40 I0 J10 F1000")
    .move(50, 40, 5),
    "a rapid along the arc just cut, in chords": Program()
    .move(40, 50, 5)
    .move(40, 50, -5, feed=300)
    .say("G2 X60 Y50 I10 J0 F1000")
    .move(60, 50, 5),
    "a helix down and a rapid up its middle": Program()
    .move(52, 50, 5)
    .move(52, 50, 0, feed=300)
    .say("G3 X52 Y50 I-2 J0 Z-6 P3 F500")
    .say("G3 X52 Y50 I-2 J0 F500")
    .move(50, 50, -6, feed=500)
    .move(50, 50, 5),
}
"""What touches and is no contact, with a tool whose shank is as thick as its flute."""


@pytest.mark.parametrize("name", TOUCHES)
@pytest.mark.parametrize("tool", [end_mill(), ball_mill()], ids=["end mill", "ball"])
def test_nothing_alarms_at_touching(name: str, tool: object) -> None:
    assert is_clear(TOUCHES[name], mill(tool))


def peck(depth: float = 20.0, step: float = 5.0) -> Program:
    """A hole in pecks: out by rapid, down by rapid to just above the last depth."""
    program, z = Program().move(50, 50, 2), 0.0
    while z > -depth:
        z -= step
        program.move(50, 50, z, feed=200).move(50, 50, 2)
        if z > -depth:
            program.move(50, 50, z + 0.5)
    return program


def test_pecks_return_into_their_hole() -> None:
    answer = raced(peck(), mill(drill()))
    assert (answer.events, answer.undecided) == ([], 0)
    assert answer.items == 11


def test_a_peck_that_returns_below_its_depth_is_found() -> None:
    program = Program().move(50, 50, 2).move(50, 50, -5, feed=200).move(50, 50, 2)
    program.move(50, 50, -6)
    event = only_event(program, mill(drill()))
    assert (event.part.role, event.removed) == ("flute", None)
    assert event.depth == pytest.approx(np.sin(np.radians(59.0)), rel=0.15)


def test_drilling_cycles_are_followed() -> None:
    program = Program().move(50, 50, 5).say("G83 Z-20 R2 Q5 F200").say("X70").say("G80")
    assert is_clear(program.move(0, 0, 50), mill(drill()))


def test_a_rapid_beside_the_stock_enters_through_the_side() -> None:
    program = Program().move(-20, 50, 5).move(-20, 50, -5).move(20, 50, -5)
    event = only_event(program, mill(end_mill()))
    assert event.part.role == "flute"
    # Its front is at X-15 as it starts and half an inset deep after 15.025 mm.
    begin = time_of_block(program, mill(end_mill()), 7)
    assert 0.0 <= event.time_ps * 1e-12 - begin - 15.025 / 400.0 < 4e-4


def test_a_feed_with_the_spindle_off_is_found() -> None:
    program = Program().say("M5").move(50, 50, 5).move(50, 50, -5, feed=300)
    event = only_event(program, mill(end_mill()))
    assert (event.part.role, event.removed) == ("flute", None)


def test_a_neck_thinner_than_its_flute_may_go_deeper() -> None:
    tool = end_mill(radius=5.0, flute=6.0, shank=4.0)
    assert is_clear(roughing(layers=6), mill(tool))


def test_a_holder_ahead_of_its_flute_is_found_though_the_flute_follows() -> None:
    # Its collar is wider than the flute: as it goes along the slot, it is ahead of it.
    tool = cutter(
        1,
        100.0,
        ("flute", [(5.0, 0.0), (5.0, 10.0)]),
        ("holder", [(8.0, 12.0), (8.0, 100.0)]),
    )
    program = slot(15.0)
    assert only_event(program, mill(tool)).part.role == "holder"


def test_each_of_several_tools_cuts_for_the_others() -> None:
    wide, slim = end_mill(radius=8.0, shank=8.0), end_mill(3.0, 10.0, 3.0, 40.0, number=2)
    program = slot(12.0).move(80, 50, 50).say("T2 M6").say("G43 H2 S8000 M3")
    program.move(20, 50, 5).move(20, 50, -12).move(80, 50, -12).move(80, 50, 5)
    assert is_clear(program, mill(wide, slim))
    deeper = Program(program.blocks[:-1]).move(80, 50, -13).move(80, 50, 5)
    event = only_event(deeper, mill(wide, slim))
    assert (event.tool, event.part.role) == (2, "flute")


def test_a_tool_change_in_the_stock_is_found_as_the_tool_appears() -> None:
    program = Program().move(50, 50, 40).say("T2 M6").say("G43 H2").move(50, 50, 60)
    machine = mill(end_mill(), end_mill(stick=120.0, number=2))
    event = only_event(program, machine)
    assert event.tool == 2
    assert line_of(event, program, machine) == 8


def test_with_all_asked_for_every_block_and_body_is_told() -> None:
    program = Program().move(20, 50, 5).move(20, 50, -5).move(40, 50, -5).move(40, 50, 5)
    answer = raced(program, mill(end_mill()), stop_all=True)
    machine = mill(end_mill())
    lines = [line_of(event, program, machine) for event in answer.events]
    assert lines == [6, 7, 8]
    assert answer.undecided == 0


def test_the_answer_is_the_same_for_all_threads_and_with_nothing_left_out() -> None:
    machine = mill(end_mill(stick=35.0))
    program = roughing()
    answers = [raced(program, machine, threads=n) for n in (1, 2, 3)]
    answers.append(raced(program, machine, leave_out=False))
    keys = {(a.events[0].sample, a.events[0].point, a.beams, a.undecided) for a in answers[:3]}
    assert len(keys) == 1
    assert answers[3].events[0].sample == answers[0].events[0].sample


def test_an_inset_that_is_too_small_is_said_with_numbers() -> None:
    assert raced(slot(), mill(end_mill(), inset=0.005)).undecided == 0


def test_beams_run_along_the_tool() -> None:
    """A stock on its side: the tool comes along its Y, seen from a table that is turned."""
    program = Program().move(50, -5, 5, 0, 0).move(50, 50, 5).move(50, 50, -5, feed=300)
    assert is_clear(program.move(50, 50, 5), mill(end_mill()))
