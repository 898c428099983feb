"""Tools in time: which tool a stretch is checked with, and contacts of a tool that appears."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from collision.detecting import detected

from gcodesim.checking.evidence import contact_finding, first_contact
from gcodesim.collision.detector import Detection, Task, detect
from gcodesim.collision.search.span_search import Aims
from gcodesim.machine.model import Machine, Part, Tool, ToolMount
from gcodesim.motion.path import Path, ToolChange
from gcodesim.study.scenes import BED_MOVER, box, joint, machine, path

JOINTS = [joint("Z", [0, 0, 1])]
SAMPLE_PS = 1_000_000_000
LINES = ["(0)", "T1 M6", "T2 M6", "T3 M6"]


def tool(number: int, length: float) -> Tool:
    """A 4 mm square prism of the given length below the gauge point."""
    part = Part("flute", box([4, 4, length], [0, 0, -length / 2]), role="flute")
    return Tool(number, f"tool {number}", length, 4.0, (0.0,) * 6, (part,))


def spindle(lengths: dict[int, float], for_all: bool = False) -> Machine:
    """A table with its face at z = 0 and a spindle at z = 50 that carries no tool at the start."""
    m = machine(JOINTS, {"bed": box([100, 100, 20], [0, 0, -10])}, [*BED_MOVER, ("bed", "cutter")])
    mounted = tuple(
        replace(p, triangles=p.triangles + np.array([0, 0, 50.0])) for p in tool(0, 5).parts
    )
    mount = ToolMount(
        "cutter", "mover", np.array([0, 0, 50.0]), np.array([0, 0, 1.0]), mounted, 5.0, for_all
    )
    return replace(
        m,
        pairs=m.pairs[1:],
        tool=mount,
        tools={number: tool(number, length) for number, length in lengths.items()},
    )


def run(m: Machine, stops: list[float], changes: list[tuple[int, int]]) -> tuple[Detection, Path]:
    """One sample per stop; changes are (before piece, number)."""
    p = path(JOINTS, [0.0], [(1e-3, [z]) for z in stops])
    lined = tuple(ToolChange(piece, number, number + 1) for piece, number in changes)
    p = replace(p, tool_changes=lined)
    return detected(m, p, SAMPLE_PS), p


def test_each_stretch_is_checked_with_its_own_tool() -> None:
    m = spindle({1: 20.0, 2: 45.0})
    # Down to z = 50 - 26: free for tool 1, a contact for tool 2.
    free, _ = run(m, [-10, -26, 0], [(0, 1)])
    assert free.contact is None
    assert not free.missing[1:]
    found, p = run(m, [-26, 0, -4, -26, 0], [(0, 1), (2, 2)])
    assert found.contact is not None
    assert (found.contact.sample, found.contact.appears) == (4, False)
    assert first_contact(found.contact, p, LINES).tool == 2


def test_a_tool_that_appears_in_contact_is_named_with_its_block() -> None:
    found, p = run(spindle({1: 20.0, 2: 45.0}), [-26, 0], [(0, 1), (1, 2)])
    assert found.contact is not None
    assert (found.contact.sample, found.contact.appears) == (1, True)
    first = first_contact(found.contact, p, LINES)
    assert (first.tool, first.line, first.block, first.axes) == (2, 3, "T2 M6", {"Z": -26.0})
    finding = contact_finding(found.contact, first)
    assert (finding.code, finding.tool) == ("GC106", 2)


def test_a_tool_changed_after_the_last_move_is_looked_at() -> None:
    found, p = run(spindle({1: 20.0, 3: 45.0}), [-26], [(0, 1), (1, 3)])
    assert found.contact is not None
    assert (found.contact.sample, found.contact.appears) == (1, True)
    assert first_contact(found.contact, p, LINES).tool == 3


def test_a_tool_without_a_shape_leaves_its_stretch_unchecked() -> None:
    found, _ = run(spindle({1: 20.0}), [-10, -26, 0], [(0, 1), (1, 9), (2, 1)])
    assert [(s.tool, s.start_ps, s.end_ps) for s in found.missing] == [
        (9, SAMPLE_PS, 2 * SAMPLE_PS)
    ]
    assert found.contact is None


def test_a_tool_that_stands_for_all_is_checked_in_one_stretch() -> None:
    found, _ = run(replace(spindle({}, for_all=True), tools=None), [-10, -44, 0], [(0, 1), (1, 9)])
    assert [(s.tool, s.end_ps) for s in found.spans] == [(None, 3 * SAMPLE_PS)]
    assert not found.missing
    low, _ = run(replace(spindle({}, for_all=True), tools=None), [-10, -46, 0], [(0, 1), (1, 9)])
    assert low.contact is not None
    assert low.contact.sample == 2


@pytest.mark.parametrize("changes", [[(2, 2)], [(2, 2), (2, 1)]])
def test_a_tool_that_no_move_follows_keeps_its_clearance(changes: list[tuple[int, int]]) -> None:
    """Tool 2 ends 5 mm above the table for no time at all."""
    m = spindle({1: 20.0, 2: 45.0})
    p = path(JOINTS, [0.0], [(1e-3, [-5.0]), (1e-3, [0.0])])
    p = replace(p, tool_changes=tuple(ToolChange(*c, c[1] + 1) for c in [(0, 1), *changes]))
    aims = Aims(clearance=6.0, nearest=True)
    found = detect(Task(p, m, SAMPLE_PS, "cpu", "search", aims, lambda done: None))
    assert found.contact is None
    near = [n for span in found.findings for _, n in span.too_near]
    assert [(n.distance, n.time_ps) for n in near] == [(pytest.approx(5.0), p.duration_ps)]
    smallest = min(n.distance for span in found.findings for _, n in span.minimums)
    assert smallest == pytest.approx(5.0)


def test_a_pair_that_touches_as_it_appears_has_no_smallest_distance() -> None:
    m = spindle({1: 20.0, 2: 60.0})
    p = path(JOINTS, [0.0], [(1e-3, [-5.0]), (1e-3, [0.0])])
    p = replace(p, tool_changes=(ToolChange(0, 1, 2), ToolChange(2, 2, 3)))
    for wanted in ({"minimum": True}, {"nearest": True}):
        aims = Aims(stop_all=True, **wanted)
        found = detect(Task(p, m, SAMPLE_PS, "cpu", "search", aims, lambda done: None))
        assert found.contact is not None
        smallest = [n.distance for span in found.findings for _, n in span.minimums]
        assert np.isfinite(smallest).all()
        assert min(smallest) == pytest.approx(25.0, abs=0.03)
