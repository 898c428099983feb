"""Forward kinematics against closed forms, the sign convention, and the axioms of rigid motion."""

import math

import numpy as np
import pytest
from machine.five_axis import tip_position

from gcodesim.machine.kinematics import (
    rotation,
    rotation_from_z,
    sincosd,
    transform,
    world_from_link,
)
from gcodesim.machine.model import Joint, Machine, ToolMount
from gcodesim.nc.control.readings import ROWS

P, P2 = np.array([30.0, -10, 80]), (5, -7, 11)
SKEW = (0, math.sqrt(0.5), math.sqrt(0.5))


def joint(name, parent, axis, point=(0, 0, 0)):
    return Joint(name, name in "ABC", parent, name, np.array(axis, dtype=float),
                 np.array(point, dtype=float), -math.inf, math.inf, 1.0)  # fmt: skip


def chain(*joints, tool=None):
    links = ("bed", *(j.name for j in joints))
    return Machine(
        "test", "", True, links, joints, {}, (), tool, None, None, {}, {}, {}, ROWS["fanuc"]
    )


@pytest.mark.parametrize(
    ("letter", "sign", "p1", "expected"),
    [
        ("A", +1, (5, 5, 41), (24.79898987, -11.42011126, 76.55316534)),
        ("A", -1, (5, 5, 41), (20.55634919, -3.03873304, 90.67448568)),
        ("B", +1, (17, -7, 41), (43.25412335, 8.55634919, 70.87549581)),
        ("B", -1, (17, -7, 41), (0.57988874, -26.79898987, 76.55316534)),
    ],
)
def test_table_tilting(letter, sign, p1, expected):
    tilt = (sign, 0, 0) if letter == "A" else (0, sign, 0)
    machine = chain(joint(letter, "bed", tilt, p1), joint("C", letter, (0, 0, sign), P2))
    point = transform(world_from_link(machine, [30, 45])["C"], P)
    np.testing.assert_allclose(point, expected, rtol=0, atol=5e-9)


def test_head_head():
    """The tip meets the part point when the pivot stands where the closed form says."""
    pivot = np.array([136.06601718, 96.06601718, 339.80762114])
    spindle = ToolMount("t", "B", pivot - [0, 0, 120], np.array([0.0, 0, 1]))
    head = joint("C", "bed", (0, 0, 1), pivot), joint("B", "C", (0, 1, 0), pivot)
    tip = tip_position(chain(*head, tool=spindle), [45, 30], 180)
    np.testing.assert_allclose(tip, P, rtol=0, atol=5e-9)


def test_head_table():
    pivot = np.array([164.14213562, -28.28427125, 339.80762114])
    spindle = ToolMount("t", "B", pivot - [0, 0, 120], np.array([0.0, 0, 1]))
    machine = chain(
        joint("B", "bed", (0, 1, 0), pivot), joint("C", "bed", (0, 0, -1)), tool=spindle
    )
    part_point = transform(world_from_link(machine, [30, 45])["C"], P)
    np.testing.assert_allclose(tip_position(machine, [30, 45], 180), part_point, rtol=0, atol=5e-9)


def test_nutating():
    pose = world_from_link(chain(joint("B", "bed", SKEW, (3, 4, 5))), [50])["B"]
    np.testing.assert_allclose(pose[:3, 2], (0.54167522, 0.17860620, 0.82139380), atol=5e-9)
    upright = world_from_link(chain(joint("B", "bed", SKEW)), [180])["B"]
    np.testing.assert_allclose(upright[:3, 2], (0, 1, 0), atol=1e-15)  # n = 45: 90 deg at b = 180


def test_iso_tool_axis_seen_from_the_part():
    machine = chain(joint("A", "bed", (-1, 0, 0), (5, 5, 41)), joint("C", "A", (0, 0, -1), P2))
    (sin_a, sin_c), (cos_a, cos_c) = sincosd([30, 45])
    seen = world_from_link(machine, [30, 45])["C"][:3, :3].T @ [0, 0, 1]
    np.testing.assert_allclose(seen, (sin_c * sin_a, -cos_c * sin_a, cos_a), atol=1e-15)


@pytest.mark.parametrize("name", ["X", "Y", "Z", "A", "C"])
def test_sign_convention(name, rng):
    """Jog one joint a little from anywhere: the child moves along the vector of the file."""
    axis = rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    machine = chain(joint(name, "bed", axis, (3, -4, 5)))
    point = np.array([7.0, 11, -2])
    start = rng.uniform(-200, 200)
    before, after = (
        transform(world_from_link(machine, [q])[name], point) for q in (start, start + 1)
    )
    if name in "XYZ":
        np.testing.assert_allclose(after - before, axis, atol=1e-12)
    else:
        turned = np.cross(axis, (before + after) / 2 - [3, -4, 5])
        step = (after - before) / (2 * math.tan(math.radians(0.5)))
        np.testing.assert_allclose(step, turned, atol=1e-11)


@pytest.fixture
def rng():
    """A seeded generator."""
    return np.random.default_rng(20261121)


def random_machine(rng):
    def axis():
        v = rng.normal(size=3)
        return v / np.linalg.norm(v)

    parents = {"X": "bed", "A": "X", "C": "A", "Z": "bed"}
    return chain(*(joint(n, p, axis(), rng.uniform(-300, 300, 3)) for n, p in parents.items()))


def test_axioms(rng):
    """Rigid, identity at zero, periodic, order along the chain, other branches untouched."""
    for _ in range(50):
        machine = random_machine(rng)
        q = rng.uniform(-400, 400, 4)
        poses = world_from_link(machine, q)
        for pose in poses.values():
            turn = pose[:3, :3]
            np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-14)
            assert np.linalg.det(turn) == pytest.approx(1, abs=1e-14)
            np.testing.assert_array_equal(pose[3], [0, 0, 0, 1])
        for pose in world_from_link(machine, np.zeros(4)).values():
            np.testing.assert_array_equal(pose, np.eye(4))
        turned = world_from_link(machine, q + np.array([0, 360, -720, 0]))
        np.testing.assert_allclose(turned["C"], poses["C"], atol=1e-10)
        only_a = world_from_link(machine, q * [0, 1, 0, 0])["A"]
        only_x = world_from_link(machine, q * [1, 0, 0, 0])["X"]
        np.testing.assert_allclose(poses["A"], only_x @ only_a, atol=1e-12)
        np.testing.assert_array_equal(poses["Z"], world_from_link(machine, q * [0, 0, 0, 1])["Z"])


def test_batch_equals_single(rng):
    machine = random_machine(rng)
    q = rng.uniform(-400, 400, (5, 2, 4))
    batch = world_from_link(machine, q)["C"]
    assert batch.shape == (5, 2, 4, 4)
    for index in np.ndindex(5, 2):
        np.testing.assert_array_equal(batch[index], world_from_link(machine, q[index])["C"])
    with pytest.raises(ValueError, match="4 joint positions"):
        world_from_link(machine, [1, 2, 3])


def test_sincosd_is_exact_at_right_angles():
    for k in [*range(-8, 9), 400_001, -400_003, 10**12]:
        expected = [(0, 1), (1, 0), (0, -1), (-1, 0)][k % 4]
        assert tuple(float(v) for v in sincosd(90.0 * k)) == expected
    assert not np.signbit(sincosd([-180.0, 180.0, -360.0])[0]).any()
    angles = np.linspace(-720, 720, 10_001)
    radians = np.radians(angles)
    np.testing.assert_allclose(sincosd(angles), [np.sin(radians), np.cos(radians)], atol=3e-15)
    np.testing.assert_array_equal(sincosd(360e6 + 30.0), sincosd(30.0))


def test_rotation_from_z(rng):
    for axis in [*rng.normal(size=(20, 3)), [0, 0, 1.0], [0, 0, -1.0], [1e-200, 0, 1]]:
        unit = np.array(axis) / np.linalg.norm(axis)
        turn = rotation_from_z(unit)
        np.testing.assert_allclose(turn[:, 2], unit, atol=1e-15)
        np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-15)
    np.testing.assert_array_equal(rotation([0, 0, 1], 90), [[0, -1, 0], [1, 0, 0], [0, 0, 1]])
