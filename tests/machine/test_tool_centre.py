"""Tool tip and rotary axes: printed tables, round trips on random machines, poles and limits."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from machine.five_axis import (
    GAUGE,
    HEAD_SLIDES,
    ISO_AC,
    POINTS,
    TABLE_SLIDES,
    TYPES,
    machine,
    random_machine,
    rotary_solutions,
    solved,
)
from numpy.typing import ArrayLike, NDArray

from gcodesim.errors import OrientationError
from gcodesim.machine.kinematics import sincosd, transform, world_from_link
from gcodesim.machine.tool_centre import ToolCentre, tool_centre

Array = NDArray[np.float64]
POSES = 100_000

SOLUTIONS = [
    ("AC table, ISO", "AC", [(30, 40), (-30, -140)]),
    ("AC table, both turned round", "AC", [(-30, -40), (30, 140)]),
    ("BC table, ISO", "BC", [(30, -50), (-30, 130)]),
    ("CB head", "CB", [(-50, 30), (130, -30)]),
    ("B head, C table", "BC", [(30, -50), (-30, 130)]),
    ("nutating table", "BC", [(42.941403, -65.542268), (-42.941403, 145.542268)]),
    ("nutating head", "CB", [(-65.542268, 42.941403), (145.542268, -42.941403)]),
]
"""Solutions for the direction I 40, J 30, in the order of `letters`."""


def pick(abc: ArrayLike, letters: str) -> tuple[float, ...]:
    return tuple(float(np.asarray(abc)["ABC".index(letter)]) for letter in letters)


@pytest.mark.parametrize(("kind", "letters", "expected"), SOLUTIONS)
def test_both_solutions_of_the_reference_direction(
    kind: str, letters: str, expected: list[tuple[float, float]]
) -> None:
    (sin_i, sin_j), (cos_i, cos_j) = sincosd([40, 30])
    direction = np.array([sin_i * sin_j, -cos_i * sin_j, cos_j])
    np.testing.assert_allclose(direction, (0.32139381, -0.38302222, 0.86602540), atol=5e-9)
    centre = solved(machine(*TYPES[kind], POINTS))
    found = rotary_solutions(centre, direction)
    np.testing.assert_allclose(
        sorted(pick(abc, letters) for abc in found), sorted(expected), atol=5e-7
    )
    np.testing.assert_allclose(centre.directions(found), [direction] * 2, atol=1e-15)


@pytest.mark.parametrize(
    ("tilt", "sign", "point", "expected"),
    [
        ("A", +1, (5, 5, 41), (24.79898987, -11.42011126, 76.55316534)),
        ("A", -1, (5, 5, 41), (20.55634919, -3.03873304, 90.67448568)),
        ("B", +1, (17, -7, 41), (43.25412335, 8.55634919, 70.87549581)),
        ("B", -1, (17, -7, 41), (0.57988874, -26.79898987, 76.55316534)),
    ],
)
def test_a_table_holds_the_tip_at_the_closed_form(
    tilt: str, sign: int, point: ArrayLike, expected: ArrayLike
) -> None:
    axes = {**HEAD_SLIDES, "A": (sign, 0, 0), "B": (0, sign, 0), "C": (0, 0, sign)}
    centre = solved(machine(f"{tilt}C", "XYZ", axes, {tilt: point, "C": (5, -7, 11)}))
    part = np.array([30.0, -10.0, 80.0]) - GAUGE
    rotary = np.array([30.0 * (tilt == "A"), 30.0 * (tilt == "B"), 45.0])
    at = centre.axes_at(part, rotary, np.zeros(3))[0, :3] + GAUGE
    np.testing.assert_allclose(at, expected, atol=5e-9)
    np.testing.assert_allclose(centre.carried(part, rotary)[0] + GAUGE, expected, atol=5e-9)


@pytest.mark.parametrize(
    ("kind", "expected"),
    [
        ("CB head", (136.06601718, 96.06601718, 339.80762114)),
        ("B head, C table", (164.14213562, -28.28427125, 339.80762114)),
    ],
)
def test_a_head_stands_where_the_closed_form_puts_its_pivot(kind: str, expected: ArrayLike) -> None:
    """The pivot stands 120 above the gauge point and 300 above the tip; C turns about zero."""
    pivot = np.array(GAUGE) + (0, 0, 120)
    points = {"B": pivot, "C": pivot if kind == "CB head" else (0, 0, 0)}
    centre = solved(machine(*TYPES[kind], points))
    part = np.array([30.0, -10.0, 80.0]) - GAUGE
    axes = centre.axes_at(part, [0, 30, 45], [0, 0, 180])[0]
    np.testing.assert_allclose(axes[:3] + pivot, expected, atol=5e-9)


def random_poses(rng: np.random.Generator, centre: ToolCentre, count: int) -> tuple[Array, Array]:
    """Axes (n, 6) with everything nonzero, but 0 where the machine has no joint; tool offsets."""
    axes = np.zeros((count, 6))
    for step in centre.chain:
        ends = 170.0 if step.joint.rotary else 500.0
        axes[:, step.column] = rng.uniform(-ends, ends, count)
    offset = rng.uniform(-40, 40, (count, 3))
    offset[:, 2] += 150.0
    return axes, offset


@pytest.mark.parametrize("kind", TYPES)
def test_round_trips_of_random_poses(kind: str, rng: np.random.Generator) -> None:
    centre = solved(machine(*TYPES[kind], POINTS))
    axes, offset = random_poses(rng, centre, POSES)
    axes = axes[centre.volumes(axes[:, 3:]) > 0.05]  # the quill lies along X at B90
    offset = offset[: len(axes)]
    assert len(axes) > 0.8 * POSES
    tips = centre.tips(axes, offset)
    back = centre.axes_at(tips, axes[:, 3:], offset)
    np.testing.assert_array_equal(back[:, 3:], axes[:, 3:])
    assert np.abs(back - axes).max() < 1e-9
    assert np.abs(centre.tips(back, offset) - tips).max() < 1e-9


@pytest.mark.parametrize("kind", [kind for kind, _, _ in SOLUTIONS])
def test_round_trips_of_random_directions(kind: str, rng: np.random.Generator) -> None:
    centre = solved(machine(*TYPES[kind], POINTS))
    axes, _ = random_poses(rng, centre, POSES)
    solver = centre.rotary
    wanted = axes[:, [step.column for step in centre.chain if step.joint.rotary]]
    # A nutating joint at 180 stands on the edge of its cone, where a direction fixes it badly.
    directions = solver.directions(wanted)
    both, _ = solver.solutions(directions)
    for k in range(2):
        assert np.abs(solver.directions(both[:, k]) - directions).max() < 1e-13
    away = np.remainder(both - wanted[:, None, :] + 180.0, 360.0) - 180.0
    nearest = np.abs(away).max(axis=2).min(axis=1)
    conditioned = solver.pole_angles(directions) > 1e-4
    assert conditioned.mean() > 0.999
    assert np.radians(nearest[conditioned]).max() < 1e-11


def test_random_machines_go_there_and_back(rng: np.random.Generator) -> None:
    solvable = 0
    for _ in range(1000):
        centre = solved(random_machine(rng))
        axes, offset = random_poses(rng, centre, 10)
        tips = centre.tips(axes, offset)
        try:
            back = centre.axes_at(tips, axes[:, 3:], offset)
        except OrientationError:
            continue  # slides with a rotary joint between them may fall into one plane
        solvable += 1
        scale = np.abs(np.linalg.inv(centre.frame)).max()
        assert np.abs(centre.tips(back, offset) - tips).max() < 1e-9 * scale
    assert solvable > 990


def test_the_chain_is_the_forward_kinematics_of_the_tree(rng: np.random.Generator) -> None:
    """A part point under the tip stays under it: both links posed by world_from_link."""
    for _ in range(300):
        m = random_machine(rng)
        centre, tool = solved(m), m.tool
        assert tool is not None
        axes, offset = random_poses(rng, centre, 1)
        q = np.array([axes[0, "XYZABC".index(j.name)] for j in m.joints])
        poses = world_from_link(m, q)
        along = np.column_stack([centre.frame[:, :2], tool.axis])  # the length stands on the tool
        tip = transform(poses[tool.link], tool.gauge_point - along @ offset[0])
        part = centre.tips(axes, offset)[0] @ centre.frame.T + tool.gauge_point
        assert m.work_link is not None
        np.testing.assert_allclose(transform(poses[m.work_link], part), tip, atol=1e-9)
        seen = poses[m.work_link][:3, :3].T @ poses[tool.link][:3, :3] @ tool.axis
        direction = centre.frame @ centre.directions(axes[:, 3:])[0]
        np.testing.assert_allclose(direction / np.linalg.norm(direction), seen, atol=1e-12)


def test_a_frame_shift_of_the_whole_machine_changes_nothing(rng: np.random.Generator) -> None:
    m = random_machine(rng)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn *= np.linalg.det(turn)
    shift = rng.uniform(-1000, 1000, 3)
    tool = m.tool
    assert tool is not None
    moved = replace(
        m,
        joints=tuple(
            replace(j, axis=turn @ j.axis, point=turn @ j.point + shift) for j in m.joints
        ),
        tool=replace(tool, gauge_point=turn @ tool.gauge_point + shift, axis=turn @ tool.axis),
    )
    axes, offset = random_poses(rng, solved(m), 100)
    np.testing.assert_allclose(
        solved(moved).tips(axes, offset), solved(m).tips(axes, offset), atol=1e-8
    )
    np.testing.assert_allclose(
        solved(moved).directions(axes[:, 3:]), solved(m).directions(axes[:, 3:]), atol=1e-11
    )


def test_in_another_unit_the_linear_joints_scale(rng: np.random.Generator) -> None:
    m = random_machine(rng)
    tool = m.tool
    assert tool is not None
    metric = replace(
        m,
        joints=tuple(replace(j, point=25.4 * j.point) for j in m.joints),
        tool=replace(tool, gauge_point=25.4 * tool.gauge_point),
    )
    axes, offset = random_poses(rng, solved(m), 100)
    scaled = axes * ([25.4] * 3 + [1.0] * 3)
    tips = solved(m).tips(axes, offset)
    np.testing.assert_allclose(solved(metric).tips(scaled, 25.4 * offset), 25.4 * tips, atol=1e-8)


@pytest.mark.parametrize("kind", TYPES)
def test_at_rotary_zero_a_point_is_its_own_axis_position(kind: str) -> None:
    centre = solved(machine(*TYPES[kind], POINTS))
    points, offset = np.array([[1.0, 2.0, 3.0], [-40.0, 50.0, -60.0]]), np.array([7.0, 8.0, 90.0])
    at = centre.axes_at(points, np.zeros((2, 3)), offset)
    np.testing.assert_allclose(at[:, :3], points + offset, atol=1e-12)
    np.testing.assert_array_equal(centre.tips(np.zeros(6), np.zeros(3)), [[0, 0, 0]])


@pytest.mark.parametrize("kind", TYPES)
def test_a_whole_turn_changes_nothing_and_the_tool_length_follows_the_tool(
    kind: str, rng: np.random.Generator
) -> None:
    centre = solved(machine(*TYPES[kind], POINTS))
    axes, offset = random_poses(rng, centre, 10)
    turned = axes + [0, 0, 0, 360, -720, 360_000]
    np.testing.assert_allclose(centre.tips(turned, offset), centre.tips(axes, offset), atol=1e-9)
    longer = centre.tips(axes, offset + [0, 0, 50])
    along = centre.directions(axes[:, 3:])
    np.testing.assert_allclose(centre.tips(axes, offset) - longer, 50 * along, atol=1e-11)


def table_tilt(a: tuple[float, float] = (-120, 30), c: tuple[float, float] = (-math.inf, math.inf),
               rapid: float = 100.0) -> ToolCentre:  # fmt: skip
    m = machine(*TYPES["AC table, ISO"], POINTS)
    ends = {"A": a, "C": c}
    joints = tuple(
        replace(j, lower=ends[j.name][0], upper=ends[j.name][1], rapid=rapid if j.name == "C" else
                100.0) if j.rotary else j for j in m.joints
    )  # fmt: skip
    return solved(replace(m, joints=joints))


def direction(a: float, c: float) -> Array:
    (sin_a, sin_c), (cos_a, cos_c) = sincosd([a, c])
    return np.array([sin_c * sin_a, -cos_c * sin_a, cos_a])


@pytest.mark.parametrize(
    ("previous", "travel", "wanted", "expected"),
    [
        ((0, 0), (-120, 120), (50, 40), (50, 40)),
        ((-50, -130), (-120, 120), (50, 40), (-50, -140)),  # the shorter way
        ((0, 0), (-120, 30), (50, 40), (-50, -140)),  # the other one lies outside the travel
        ((0, 36_000), (-120, 120), (20, 40), (20, 36_040)),  # C stays unwound
        ((0, 3_600_000_100), (-120, 120), (20, 40), (20, 3_600_000_040)),
        ((0, 0), (-120, 120), (30, 90), (30, 90)),  # tie: A is not negative
        ((0, 77), (-120, 120), (0, 0), (0, 77)),  # the pole keeps C
        ((12, 77), (-120, 120), (0, 0), (0, 77)),
    ],
)
def test_the_choice_between_solutions(
    previous: tuple[float, float],
    travel: tuple[float, float],
    wanted: tuple[float, float],
    expected: tuple[float, float],
) -> None:
    centre = table_tilt(a=travel)
    before = [previous[0], 0, previous[1]]
    found = centre.rotary_at(direction(*wanted), before)
    np.testing.assert_allclose(pick(found, "AC"), expected, rtol=1e-15, atol=1e-12)


def test_the_sign_of_the_tilt_may_be_asked_for() -> None:
    centre = table_tilt(a=(-120, 120))
    for prefer, expected in ((1, (50, 40)), (-1, (-50, -140))):
        found = centre.rotary_at(direction(50, 40), [-10, 0, -100], prefer)
        np.testing.assert_allclose(pick(found, "AC"), expected, atol=1e-12)
    with pytest.raises(OrientationError, match="the sign asked for") as caught:
        table_tilt(a=(-120, 30)).rotary_at(direction(50, 40), [0, 0, 0], 1)
    assert caught.value.meaning == "orientation_out_of_travel"


def test_limits_of_a_bounded_joint_and_its_whole_turns() -> None:
    centre = table_tilt(a=(-5, 120), c=(-400, 400))
    before = [0, 0, 395]
    np.testing.assert_allclose(
        pick(centre.rotary_at(direction(50, 60), before), "AC"), (50, 60), atol=1e-12
    )  # 420 lies outside
    with pytest.raises(OrientationError, match="C and A cannot point") as caught:
        table_tilt(a=(-5, 30)).rotary_at(direction(50, 60), before)
    assert caught.value.meaning == "orientation_out_of_travel"


def test_the_slower_joint_decides_the_way() -> None:
    wanted, before = direction(30, 100), [0, 0, 0]  # (30, 100) or (-30, -80)
    assert pick(table_tilt(a=(-120, 120)).rotary_at(wanted, before), "A")[0] == pytest.approx(-30)
    before = [25, 0, 0]  # C 80 at 100 deg/s takes longer than A 55; at 200 deg/s A does
    assert pick(table_tilt((-120, 120)).rotary_at(wanted, before), "A")[0] == pytest.approx(-30)
    fast = table_tilt((-120, 120), rapid=200.0).rotary_at(wanted, before)
    assert pick(fast, "A")[0] == pytest.approx(30)


def test_what_a_nutating_head_cannot_reach() -> None:
    centre = solved(machine(*TYPES["nutating head"], POINTS))
    edge = centre.rotary_at([1, 0, 0], [0, 0, 0])  # exactly a right angle: B180
    np.testing.assert_allclose(pick(edge, "CB"), (-90, 180), atol=1e-6)
    with pytest.raises(OrientationError, match="cannot point") as caught:
        centre.rotary_at([1, 0, -1e-5], [0, 0, 0])
    assert caught.value.meaning == "direction_unreachable"
    assert rotary_solutions(centre, [1, 0, -1e-5]) == []
    with pytest.raises(OrientationError, match="no length"):
        centre.rotary_at([0, 0, 0], [0, 0, 0])


def test_one_rotary_axis_reaches_its_own_plane() -> None:
    centre = solved(machine(*TYPES["A table alone"], POINTS))
    found = centre.rotary_at(direction(-70, 0), [300, 0, 0])
    np.testing.assert_allclose(found, [290, 0, 0], atol=1e-12)
    with pytest.raises(OrientationError, match="cannot point"):
        centre.rotary_at(direction(50, 1), [0, 0, 0])
    c_table = solved(machine("XC", "YZ", {**ISO_AC, "Y": (0, 1, 0)}, POINTS))
    np.testing.assert_array_equal(c_table.rotary_at([0, 0, 1], [0, 0, 33]), [0, 0, 33])


def test_the_angle_to_the_pole() -> None:
    centre = solved(machine(*TYPES["AC table, ISO"], POINTS))
    assert centre.rotary is not None
    for tilt in (1e-7, 1e-3, 30.0):
        (angle,) = centre.rotary.pole_angles(np.array([direction(tilt, 50)]))
        assert angle == pytest.approx(math.radians(tilt))


@pytest.mark.parametrize(
    ("work", "tool", "changed", "reason"),
    [
        ("YXAC", "Z", {"C": (-1, 0, 0)}, "parallel"),
        ("YXAC", "Z", {"Y": (-1, 0, 0)}, "one plane"),
        ("YXACB", "Z", {}, "three linear and one or two rotary"),
        ("XAC", "Z", {}, "three linear"),
        ("YXA", "ZC", {}, "about its own axis"),
    ],
)
def test_a_machine_that_cannot_be_solved_says_so_only_when_asked(
    work: str, tool: str, changed: dict[str, ArrayLike], reason: str
) -> None:
    axes = {**TABLE_SLIDES, "A": (-1, 0, 0), "B": (0, 1, 0), "C": (0, 0, 1), **changed}
    centre = tool_centre(machine(work, tool, axes))
    assert centre is not None
    assert reason in centre.refusal
    for ask in (
        lambda: centre.tips(np.zeros(6), np.zeros(3)),
        lambda: centre.axes_at(np.zeros(3), np.zeros(3), np.zeros(3)),
        lambda: centre.rotary_at([0, 0, 1], [0, 0, 0]),
        lambda: centre.carried([0, 0, 1], [0, 0, 0]),
    ):
        with pytest.raises(OrientationError, match=reason) as caught:
            ask()
        assert caught.value.meaning == "kinematics_unsolved"


def test_a_machine_without_rotary_joints_has_no_tool_centre() -> None:
    assert tool_centre(machine("YX", "Z", TABLE_SLIDES)) is None
    assert tool_centre(replace(machine(*TYPES["CB head"]), tool=None)) is None
