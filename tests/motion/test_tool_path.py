"""Tool centre point moves: the tip in the part, the proved deviation, F, and the pole."""

from __future__ import annotations

from dataclasses import replace
from math import pi, radians
from typing import Any

import numpy as np
import pytest
from machine.five_axis import GAUGE, POINTS, TYPES, machine, random_machine, solved
from motion.programs import program
from numpy.typing import NDArray

from gcodesim.constants import TCP_DEVIATION_MM
from gcodesim.findings.codes import Finding
from gcodesim.machine.model import Body, Machine, Part, Tool
from gcodesim.motion.great_circle import levers
from gcodesim.motion.overtravel import overtravels
from gcodesim.motion.path import Path
from gcodesim.motion.planner import plan
from gcodesim.motion.tool_moves import followed
from gcodesim.nc.program import AXES, CanonicalProgram, FeedMode, Frame, Kind

Array = NDArray[np.float64]
RAPID, FEED, ARC, OFFSET = Kind.RAPID, Kind.FEED, Kind.ARC, Kind.TOOL_OFFSET
WORK, MACHINE = Frame.WORK, Frame.MACHINE
LENGTH = {"kind": OFFSET, "to": (1.5, -2.0, 140.0)}
AC, CB = "AC table, ISO", "CB head"
SINGLE = ("A table alone", "slide on the table", "quill in the head")


def of_type(kind: str, linear: float = 500.0, rotary: float = 100.0) -> Machine:
    """A machine of a type, its rapid rates in mm/s and deg/s."""
    m = machine(*TYPES[kind], POINTS)
    rated = [replace(j, rapid=rotary if j.rotary else linear) for j in m.joints]
    return replace(m, joints=tuple(rated))


def tip(*to: float, **more: Any) -> dict[str, Any]:
    """A feed of the tip to X Y Z A B C."""
    return {"kind": FEED, "to": to, "frame": WORK, "f": 600.0, **more}


def planned(m: Machine, *rows: dict[str, Any]) -> tuple[Path, list[Finding], CanonicalProgram]:
    """The path, the findings and the program: tool length first, then to tip (10, 20, 30)."""
    begin = tip(10, 20, 30, 0, 0, 0, kind=RAPID)
    p = program([LENGTH, begin, *rows])
    p.to[:, [i for i, name in enumerate(AXES) if name not in m.axes]] = 0.0
    path, findings = plan(p, m)
    return path, findings, p


def axes(m: Machine, q: Array) -> Array:
    """Joint positions as X Y Z A B C."""
    found = np.zeros((len(q), 6))
    found[:, [AXES.index(name) for name in m.axes]] = q
    return found


def samples(path: Path, line: int, per_piece: int = 17) -> tuple[Array, Array]:
    """Fractions of a block, by the pieces' number, and joint positions, dense on every piece."""
    pieces = np.flatnonzero(path.line == line)
    s = np.linspace(0.0, 1.0, per_piece)
    q = path.positions_on(np.repeat(pieces, per_piece), np.tile(s, len(pieces)))
    return (np.arange(len(pieces))[:, None] + s).reshape(-1) / len(pieces), q


def exact(m: Machine, p: CanonicalProgram, line: int, s: Array) -> tuple[Array, Array]:
    """The true tips and joint positions at fractions of a block."""
    _, under, findings = followed(p, m)
    assert under is not None
    assert not findings
    move = int(np.flatnonzero(p.line[under.tips.row] == line)[0])
    points = under.tips.at(np.full(len(s), move), s)
    offset = np.array(LENGTH["to"])
    return points, under.centre.axes_at(points[:, :3], points[:, 3:], offset)


def assert_follows(m: Machine, path: Path, p: CanonicalProgram, line: int) -> float:
    """Piece ends exact, everything between within the stated deviation; the largest one found."""
    assert path.deviation_mm <= TCP_DEVIATION_MM
    s, q = samples(path, line)
    points, wanted = exact(m, p, line, s)
    found = axes(m, q)
    off = np.linalg.norm(found[:, :3] - wanted[:, :3], axis=1)
    np.testing.assert_allclose(found[:, 3:], wanted[:, 3:], atol=1e-10)
    assert off.max() <= path.deviation_mm + 1e-9
    at_ends = np.isclose(np.mod(np.arange(len(s)), 17), 0) | (np.mod(np.arange(len(s)), 17) == 16)
    assert off[at_ends].max() < 1e-9
    tips = solved(m).tips(found, np.array(LENGTH["to"]))
    assert np.linalg.norm(tips - points[:, :3], axis=1).max() <= path.deviation_mm + 1e-9
    return float(off.max())


@pytest.mark.parametrize("kind", TYPES)
def test_the_tip_stays_in_the_part_while_the_rotary_joints_move(kind: str) -> None:
    m = of_type(kind)
    path, _, p = planned(m, tip(10, 20, 30, -70, 50, 200))
    found = assert_follows(m, path, p, 3)
    # The bound is no more than five times too careful, but where a joint turns slides.
    assert found > (0.01 if solved(m).between else 0.2) * path.deviation_mm
    assert len(path) > 50


@pytest.mark.parametrize("kind", TYPES)
def test_a_straight_move_with_turning_joints_is_straight_in_the_part(kind: str) -> None:
    m = of_type(kind)
    path, _, p = planned(m, tip(60, -40, 10, 35, -25, 80), tip(60, 50, 40, -10, 15, -720))
    for line in (3, 4):
        assert_follows(m, path, p, line)
    _, q = samples(path, 3)
    tips = solved(m).tips(axes(m, q), np.array(LENGTH["to"]))
    away = np.cross(tips - [10, 20, 30], [50, -60, -20]) / np.linalg.norm([50, -60, -20])
    assert np.linalg.norm(away, axis=1).max() <= path.deviation_mm


@pytest.mark.parametrize("kind", TYPES)
@pytest.mark.parametrize("turning", [0.0, 55.0])
def test_an_arc_of_the_tip(kind: str, turning: float) -> None:
    """A helix of one and a quarter turns; exact as an arc where no rotary joint turns."""
    m = of_type(kind)
    arc = {"center": (35, 20, 30), "normal": (0, 0, 1), "turns": 2}
    tilt = tip(10, 20, 30, 20, 20, 30)
    path, _, p = planned(m, tilt, tip(35, -5, 42, 20 + turning, 20, 30 - turning, kind=ARC, **arc))
    assert_follows(m, path, p, 4)
    pieces = np.count_nonzero(path.line == 4)
    whole = turning == 0.0 and not solved(m).between
    assert pieces == 1 if whole else pieces > 40
    if whole:
        assert path.arc[-1] >= 0
        length = np.hypot(2.5 * pi * 25, 12)
        assert np.diff(path.bounds_ps)[-1] == pytest.approx(length / 10 * 1e12, rel=1e-9)


def test_random_moves_stay_within_the_bound(rng: np.random.Generator) -> None:
    for kind in TYPES:
        m = of_type(kind)
        tips = rng.uniform(-300, 300, (20, 6)) * [1, 1, 1, 0.2, 0.2, 0.5]
        path, _, p = planned(m, *(tip(*to) for to in tips.tolist()))
        for line in range(3, 23):
            assert_follows(m, path, p, line)


def test_random_machines_stay_within_the_bound(rng: np.random.Generator) -> None:
    """Any order of slides and rotary joints, all of them oblique."""
    between = 0
    for _ in range(60):
        m = random_machine(rng)
        m = replace(m, joints=tuple(replace(j, rapid=200.0) for j in m.joints))
        way = rng.uniform(-100, 100, (2, 6)) * [1, 1, 1, 0.3, 0.3, 0.3]
        path, findings, p = planned(m, *(tip(*to) for to in way.tolist()))
        between += bool(solved(m).between)
        for line in set(path.line.tolist()) - {2}:
            assert_follows(m, path, p, line)
        flat = {f.code for f in findings} & {"GC402", "GC424"}
        assert not flat or solved(m).between, "only turned slides can come to lie in one plane"
    assert between > 20


def test_slides_that_come_to_lie_in_one_plane_end_the_program() -> None:
    """B turns the quill past X: no piece near B90 has a bound."""
    m = of_type("quill in the head, C table")
    path, findings, _ = planned(m, tip(10, 20, 30, 0, 60), tip(10, 20, 30, 0, 120))
    assert [(f.code, f.line, f.effect) for f in findings] == [("GC424", 4, "inconclusive")]
    assert set(path.line.tolist()) == {2, 3}


def test_oblique_slides_have_their_own_factor(rng: np.random.Generator) -> None:
    work, tool, directions = TYPES[AC]
    m = machine(work, tool, {**directions, "Y": (0.5, -1.0, 0.2), "Z": (0.1, 0.4, 1.0)}, POINTS)
    path, _, p = planned(m, tip(60, -40, 10, 35, 0, 80))
    assert_follows(m, path, p, 3)
    arc = {"center": (10, 45, 30), "normal": (0, 0, 1)}
    path, _, p = planned(m, tip(-15, 45, 30, 0, 0, 0, kind=ARC, **arc))
    assert_follows(m, path, p, 3)
    assert len(path) > 10  # an ellipse of the joints


def test_joints_that_stand_still_make_one_exact_piece() -> None:
    m = of_type(AC)
    path, _, p = planned(m, tip(10, 20, 30, 30, 0, 40), tip(110, -20, 35, 30, 0, 40))
    assert np.count_nonzero(path.line == 4) == 1
    assert assert_follows(m, path, p, 4) < 1e-10


@pytest.mark.parametrize(("kind", "turned"), [(AC, 50.0), (CB, 40.0)])
def test_the_feed_is_the_speed_of_the_tip_in_the_part(kind: str, turned: float) -> None:
    m = of_type(kind, linear=1e6, rotary=1e6)
    rows = [
        tip(40, -20, 30, -50, 30, 70, f=300),  # 50 mm at 5 mm/s
        tip(40, -20, 30, -20, 30, 30, f=1000),  # the tip stands: deg/min
        tip(40, 20, 30, 0, 0, 0, f=4, mode=FeedMode.INVERSE_TIME),  # 15 s
        tip(40, -20, 30, 5, 5, 5, f=0.5, mode=95, speed=1200),  # 40 mm at 10 mm/s
    ]
    path, findings, _ = planned(m, *rows)
    assert not findings
    for line, seconds in ((3, 10.0), (4, turned * 0.06), (5, 15.0), (6, 4.0)):
        pieces = path.line == line
        duration = np.diff(path.bounds_ps)[pieces]
        assert duration.sum() == pytest.approx(seconds * 1e12, rel=1e-10)
        assert np.ptp(duration) <= 1  # every piece at the same speed


def test_a_rapid_is_straight_at_the_tip_and_as_fast_as_the_slowest_joint() -> None:
    m = of_type(AC, linear=100.0, rotary=20.0)
    path, findings, p = planned(m, tip(60, -40, 10, -35, 0, 80, kind=RAPID))
    assert not findings
    assert_follows(m, path, p, 3)
    way = np.abs(path.q1 - path.q0)
    rates = np.array([joint.rapid for joint in m.joints])
    seconds = np.diff(path.bounds_ps) / 1e12
    np.testing.assert_allclose((way / rates).max(axis=1), seconds, atol=1e-11)


def test_no_joint_is_faster_than_its_rapid_rate_and_the_finding_says_when() -> None:
    m = of_type(AC, rotary=10.0)
    path, findings, _ = planned(m, tip(10, 120, 30), tip(20, 120, 30, -60, 0, 90, f=1200))
    seconds = np.diff(path.bounds_ps) / 1e12
    rates = np.array([joint.rapid for joint in m.joints])
    assert ((np.abs(path.q1 - path.q0) / rates).max(axis=1) <= seconds + 1e-11).all()
    (finding,) = findings
    assert (finding.code, finding.line) == ("GC303", 4)
    first = int(np.flatnonzero(path.line == 4)[0])
    assert finding.time_s == path.bounds_ps[first] / 1e12
    assert seconds[path.line == 4].sum() == pytest.approx(9.0)  # C, 90 deg at 10 deg/s


def test_near_the_pole_the_table_turns_as_fast_as_it_can() -> None:
    """A tenth of a degree from the pole C turns half round over 1 mm of the tip."""
    m = of_type(AC)
    path, findings, p = planned(
        m, tip(10, 20, 30, -0.1, 0, 0), tip(11, 20, 30, -0.1, 0, 180, f=600)
    )
    assert_follows(m, path, p, 4)
    (finding,) = findings
    assert (finding.code, finding.severity, finding.line) == ("GC304", "warning", 4)
    expected = "0.1 s programmed, 1.8 s needed; C would need 1.08e+05 deg/min, it does 6000"
    assert f"{expected}, 0.1 deg from the pole" in finding.message
    seconds = np.diff(path.bounds_ps)[path.line == 4].sum() / 1e12
    assert seconds == pytest.approx(1.8)
    radius = np.linalg.norm([10 - POINTS["C"][0] + 12, 20 - POINTS["C"][1] - 35])
    assert np.count_nonzero(path.line == 4) < 2.0 * radius * radians(180) / np.sqrt(8e-3)


def circle(*to: float, **more: Any) -> dict[str, Any]:
    return tip(*to, frame=Frame.GREAT_CIRCLE, **more)


def angles_off_the_circle(m: Machine, q: Array) -> Array:
    """Angle [rad] of the tool axis of positions (n, joints) to the circle from first to last."""
    seen = solved(m).directions(axes(m, q)[:, 3:])
    normal = np.cross(seen[0], seen[-1])
    return np.abs(np.arcsin(seen @ normal / np.linalg.norm(normal)))


@pytest.mark.parametrize("kind", [kind for kind in TYPES if kind not in SINGLE])
@pytest.mark.parametrize("tilts", [(20, 60), (-20, -60), (0.5, 0.7)])
def test_the_tool_axis_runs_along_a_great_circle(kind: str, tilts: tuple[float, float]) -> None:
    m = of_type(kind, linear=1e9, rotary=1e9)
    corner = Part("corner", np.full((1, 3, 3), 1500.0))
    links = [joint.child for joint in m.joints if joint.rotary]
    m = replace(m, bodies={name: Body(name, name, (corner,)) for name in links})
    first, last = tilts
    path, _, p = planned(m, tip(10, 20, 30, first, first, 20), circle(40, 0, 60, last, last, 160))
    pieces = np.flatnonzero(path.line == 4)
    ends = np.vstack([path.q0[pieces], path.q1[pieces[-1:]]])
    assert angles_off_the_circle(m, ends).max() < 1e-12
    assert path.deviation_mm <= TCP_DEVIATION_MM
    tips = solved(m).tips(axes(m, ends), np.array(LENGTH["to"]))
    away = np.cross(tips - [10, 20, 30], [30, -20, 30]) / np.linalg.norm([30, -20, 30])
    assert np.abs(away).max() < 1e-9
    np.testing.assert_allclose(axes(m, ends[-1:])[0, 3:], p.to[3, 3:], atol=1e-9)
    # Between: the tool axis by its share of time, the tip on its line, the slides by the inverse.
    seconds = np.diff(path.bounds_ps)[pieces]
    s = np.concatenate([[0], np.cumsum(seconds)]) / seconds.sum()
    share = np.repeat(s[:-1], 9) + np.repeat(np.diff(s), 9) * np.tile(
        np.linspace(0, 1, 9), len(s) - 1
    )
    q = axes(m, path.positions_on(np.repeat(pieces, 9), np.tile(np.linspace(0, 1, 9), len(pieces))))
    exact_q = true_joints(m, ends, share, q)
    point = np.array([10, 20, 30]) + share[:, None] * [30, -20, 30]
    true_axes = solved(m).axes_at(point, exact_q, np.array(LENGTH["to"]))
    off = np.linalg.norm(q[:, :3] - true_axes[:, :3], axis=1)
    centre = solved(m)
    columns = [AXES.index(joint.name) for joint in centre.rotary.joints]
    turned = np.radians(np.abs(q - true_axes)[:, columns])
    assert (off + turned @ levers(m, centre)).max() <= path.deviation_mm + 1e-8


def test_levers_reach_the_farthest_point_of_a_link_and_of_a_tool() -> None:
    m = of_type(AC)  # A carries C, C the part; slides and spindle do not count
    corner = np.array(POINTS["C"]) + [300.0, 0.0, 400.0]
    triangle = np.stack([corner, corner + [0, 1, 0], corner + [0, 0, -1]])[None]
    m = replace(m, bodies={"lC": Body("lC", "lC", (Part("table", triangle),))})
    arm = np.linalg.norm(np.subtract(POINTS["A"], POINTS["C"]))
    np.testing.assert_allclose(levers(m, solved(m)), [500.0, 500.0 + arm], rtol=1e-4)
    head = of_type(CB)
    tool = Tool(1, "long", 0.0, 0.0, (0.0,) * 6, (Part("shank", triangle - corner + [0, 0, -250]),))
    head = replace(head, tools={1: tool})
    reach = np.linalg.norm(np.subtract(GAUGE, POINTS["B"])) + 251.0
    between = np.linalg.norm(np.subtract(POINTS["B"], POINTS["C"]))
    np.testing.assert_allclose(levers(head, solved(head)), [reach + between, reach], rtol=1e-4)


def true_joints(m: Machine, ends: Array, share: Array, near: Array) -> Array:
    """A B C on the circle at shares of its angle, on the solution and turn next to `near`."""
    centre = solved(m)
    seen = centre.directions(axes(m, ends)[:, 3:])
    normal = np.cross(seen[0], seen[-1])
    angle = np.arctan2(np.linalg.norm(normal), seen[0] @ seen[-1])
    side = np.cross(normal / np.linalg.norm(normal), seen[0])
    turn = (share * angle)[:, None]
    both, _ = centre.rotary.solutions(np.cos(turn) * seen[0] + np.sin(turn) * side)
    columns = [AXES.index(joint.name) - 3 for joint in centre.rotary.joints]
    given = near[:, 3:][:, None, columns]
    both = both + 360.0 * np.rint((given - both) / 360.0)
    nearest = np.argmin(np.abs(both - given).max(axis=2), axis=1)
    found = near[:, 3:].copy()
    found[:, columns] = both[np.arange(len(both)), nearest]
    return found


def tip_off_its_line(m: Machine, path: Path, line: int, start: list[int], way: list[int]) -> float:
    """Largest distance of the tip from a straight line of the part, at dense positions [mm]."""
    _, q = samples(path, line)
    tips = solved(m).tips(axes(m, q), np.array(LENGTH["to"]))
    return float(np.linalg.norm(np.cross(tips - start, way), axis=1).max() / np.linalg.norm(way))


def test_a_great_circle_through_the_pole_turns_the_table_on_the_spot() -> None:
    """From the pole itself: C, which stood at 0, first turns to where the tool leans to."""
    m = of_type(AC)
    path, findings, _ = planned(m, tip(10, 20, 30, 0, 0, 0), circle(10, 60, 30, 30, 0, 90, f=600))
    assert [f.code for f in findings] == ["GC304"]
    assert "C would have to jump" in findings[0].message
    pieces = np.flatnonzero(path.line == 4)
    tilt, turn = axes(m, path.q1[pieces])[:, [3, 5]].T
    on_spot = tilt < 1e-6
    assert turn[on_spot][-1] == pytest.approx(90, abs=1e-5)
    assert np.diff(path.bounds_ps)[pieces][on_spot].sum() == pytest.approx(0.9e12, rel=1e-6)
    assert np.abs(turn[~on_spot] - 90).max() < 1e-5
    assert tip_off_its_line(m, path, 4, [10, 20, 30], [0, 40, 0]) <= path.deviation_mm + 1e-9
    assert np.diff(path.bounds_ps)[pieces].sum() == pytest.approx(4.9e12, rel=1e-6)


def test_a_great_circle_past_the_pole_swings_the_table_round() -> None:
    """The axis passes the pole nearer than a thousandth of a degree: C turns by 180 there."""
    m = of_type(AC)
    path, findings, _ = planned(
        m, tip(10, 20, 30, 10, 0, 0), circle(10, 60, 30, 10, 0, 179.99, f=6000)
    )
    assert [f.code for f in findings] == ["GC304"]
    pieces = np.flatnonzero(path.line == 4)
    assert 20 < len(pieces) < 5000
    assert angles_off_the_circle(m, path.q0[pieces]).max() < 1e-9
    tilt = axes(m, path.q0[pieces])[:, 3]
    assert 0.0 < tilt.min() < 0.01
    assert tip_off_its_line(m, path, 4, [10, 20, 30], [0, 40, 0]) <= path.deviation_mm + 1e-9
    rates = np.array([joint.rapid for joint in m.joints])
    seconds = np.diff(path.bounds_ps)[pieces] / 1e12
    assert (
        np.abs(path.q1 - path.q0)[pieces] <= (seconds * (1 + 1e-9) + 1e-12)[:, None] * rates
    ).all()


def test_a_great_circle_the_joints_cannot_follow_runs_linearly() -> None:
    m = of_type(AC, rotary=1e6)
    path, findings, p = planned(
        m,
        tip(10, 20, 30, 10, 0, 0),
        circle(10, 60, 30, -30, 0, 0),  # straight over the pole: linear is the great circle
        circle(10, 20, 30, 20, 0, 90),  # to the other side: from one solution to the other
    )
    for line in (4, 5):
        assert_follows(m, path, p, line)
    assert angles_off_the_circle(m, path.q0[path.line == 4]).max() < 1e-12
    assert [(f.code, f.line) for f in findings] == [("GC304", 5)]
    assert "1 block(s) cannot follow its great circle" in findings[0].message


def test_moves_of_the_joints_before_and_after(rng: np.random.Generator) -> None:
    """A switch moves nothing: every move starts where the last one ended, whatever its frame."""
    m = of_type(CB)
    rows = [
        {"kind": RAPID, "to": (100, 50, -20, 0, 30, 60)},
        tip(40, 20, 10, 0, -20, 90),
        {"kind": OFFSET, "to": (0.0, 0.0, 200.0)},
        tip(60, 20, 10, 0, -20, 90),
        tip(60, 30, 10, 0, 20, 90),
        {"kind": FEED, "to": (5, 5, 5, 0, 0, 0), "f": 1000.0},
        {"kind": Kind.DWELL, "f": 0.5},
        tip(60, 30, 10, 0, 20, 90),
    ]
    path, _, p = planned(m, *rows)
    np.testing.assert_array_equal(path.q1[:-1], path.q0[1:])
    centre = solved(m)
    for line, offset in ((4, LENGTH["to"]), (6, (0, 0, 200)), (7, (0, 0, 200)), (10, (0, 0, 200))):
        last = int(np.flatnonzero(path.line == line)[-1])
        at = centre.tips(axes(m, path.q1[[last]]), np.array(offset, float))
        np.testing.assert_allclose(at[0], p.to[line - 1, :3], atol=1e-9)
    # After the change of the tool length the tip is 60 mm further out: the feed starts there.
    first = int(np.flatnonzero(path.line == 6)[0])
    start = centre.tips(axes(m, path.q0[[first]]), np.array([0, 0, 200.0]))[0]
    length = np.linalg.norm(p.to[5, :3] - start)
    assert np.diff(path.bounds_ps)[path.line == 6].sum() == pytest.approx(length * 1e11, rel=1e-9)


def test_a_machine_that_cannot_follow_ends_the_program_there() -> None:
    m = replace(of_type(AC), work_link="bed")
    rows = [{"kind": FEED, "to": (10, 0, 0), "f": 600.0}, tip(10, 20, 30), {"kind": Kind.TOOL}]
    path, findings = plan(program(rows), m)
    assert [(f.code, f.line, f.effect) for f in findings] == [("GC402", 2, "inconclusive")]
    assert path.line.tolist() == [1]
    assert path.tool_changes == ()


def test_a_tip_move_that_leaves_the_travel_in_its_middle() -> None:
    """The tip stands, C turns nearly round: Y swings out between ends that both lie inside."""
    m = of_type(AC, rotary=90.0)
    turn = np.linspace(0.0, 330.0, 300_001)
    rotary = np.stack([0.0 * turn, 0.0 * turn, turn], axis=1)
    y = solved(m).axes_at([[30.0, -20.0, 30.0]], rotary, np.array(LENGTH["to"]))[:, 1]
    limit = y.max() - 5.0
    assert max(y[0], y[-1]) < limit
    joints = [replace(j, upper=limit) if j.name == "Y" else j for j in m.joints]
    path, _, _ = planned(m, tip(30, -20, 30), tip(30, -20, 30, 0, 0, 330, f=3600))
    (finding,) = overtravels(path, tuple(joints))
    assert (finding.code, finding.line) == ("GC301", 4)
    assert f"Y reaches {y.max():.6g}"[:14] == finding.message[:14]
    begin = path.bounds_ps[int(np.flatnonzero(path.line == 4)[0])] / 1e12
    crossing = turn[int(np.argmax(y > limit))] / 60.0
    assert finding.time_s == pytest.approx(begin + crossing, abs=1e-4)


def test_too_many_pieces_end_the_program() -> None:
    """C turns ten million times under the tip: that is not cut into pieces of 10 micrometres."""
    m = of_type(AC)
    path, findings, _ = planned(
        m,
        tip(40, 20, 30),
        tip(40, 20, 30, 0, 0, 3.6e9),
        tip(40, 20, 50),
        {"kind": RAPID, "to": (0,)},
    )
    assert [(f.code, f.line, f.effect) for f in findings] == [("GC424", 4, "inconclusive")]
    assert path.line.tolist()[-1] == 3


@pytest.mark.slow
def test_a_million_blocks(rng: np.random.Generator) -> None:
    n = 1_000_000
    turn = np.linspace(0.0, 200 * pi, n)
    to = np.zeros((n, 6))
    to[:, :3] = np.stack([40 * np.cos(turn), 40 * np.sin(turn), turn / 50], axis=1)
    to[:, 3], to[:, 5] = -30 + 10 * np.sin(turn), np.degrees(turn)
    p = CanonicalProgram(
        kind=np.full(n, FEED, np.uint8),
        line=np.arange(1, n + 1, dtype=np.int32),
        frame=np.full(n, WORK, np.uint8),
        to=to,
        f=np.full(n, 3000.0),
        feed_mode=np.full(n, FeedMode.PER_MINUTE, np.uint8),
        speed=np.zeros(n, np.float32),
        aux=np.zeros(n, np.int32),
        arcs=np.zeros(0, program([LENGTH]).arcs.dtype),
        start=np.zeros(6),
    )
    m = of_type(AC, linear=1e5, rotary=1e5)
    path, findings = plan(p, m)
    assert not findings
    assert n <= len(path) < n + 2000  # one piece each, but for the way to the first point
    length = np.linalg.norm(np.diff(to[:, :3], axis=0), axis=1).sum()
    first = path.bounds_ps[int(np.argmax(path.line == 2))]
    assert (path.duration_ps - first) / 1e12 == pytest.approx(length / 50, rel=1e-9)
    picked = np.sort(rng.choice(len(path), 1000, replace=False))
    at = solved(m).tips(axes(m, path.q1[picked]), np.zeros(3))
    last = np.append(path.line[1:] != path.line[:-1], True)[picked]
    assert np.abs(at[last] - to[path.line[picked][last] - 1, :3]).max() < 1e-9
