"""Poses on the device against exact angles, forward kinematics and the NumPy path."""

from decimal import Decimal

import numpy as np
import pytest
import warp as wp
from collision.scenes import random_joints, random_path

from gcodesim.collision.geometry.device import BIT_EQUAL
from gcodesim.collision.geometry.poses import (
    ChainArrays,
    PathArrays,
    chain_arrays,
    joint_position,
    joints_between,
    pair_pose,
    path_arrays,
    path_fraction_at,
    sincosd,
)
from gcodesim.machine.kinematics import world_from_link
from gcodesim.motion.path import Path
from gcodesim.study.exact_motion import exact_sincosd
from gcodesim.study.scenes import Array, joint, machine, path

wp.set_module_options(BIT_EQUAL)


@wp.kernel
def evaluate_sincosd(degrees: wp.array[wp.float64], pairs_out: wp.array[wp.vec2d]):
    i = wp.tid()
    pairs_out[i] = sincosd(degrees[i])


@wp.kernel
def evaluate_joints(
    path: PathArrays,
    time_ps: wp.array[wp.int64],
    piece: wp.array[wp.int32],
    positions_out: wp.array2d[wp.float64],
):
    i, joint = wp.tid()
    s = path_fraction_at(path, piece[i], time_ps[i])
    positions_out[i, joint] = joint_position(path, piece[i], s, joint)


@wp.kernel
def evaluate_pair_poses(
    path: PathArrays,
    chains: ChainArrays,
    time_ps: wp.array[wp.int64],
    piece: wp.array[wp.int32],
    turns_out: wp.array2d[wp.mat33d],
    shifts_out: wp.array2d[wp.vec3d],
):
    i, pair = wp.tid()
    pose = pair_pose(path, chains, pair, piece[i], time_ps[i])
    turns_out[i, pair] = pose.R
    shifts_out[i, pair] = pose.t


def sincosd_on(device: str, degrees: Array) -> Array:
    pairs = wp.zeros(len(degrees), dtype=wp.vec2d, device=device)
    values = wp.array(degrees, dtype=wp.float64, device=device)
    wp.launch(evaluate_sincosd, dim=len(degrees), inputs=[values], outputs=[pairs], device=device)
    return np.asarray(pairs.numpy())


def instants_on(device: str, p: Path, times: Array) -> list[wp.array]:
    times = np.asarray(times, np.int64)
    piece = wp.array(p.piece_at(times), dtype=wp.int32, device=device)
    return [wp.array(times, dtype=wp.int64, device=device), piece]


def test_right_angles_are_exact_after_any_number_of_turns(device: str) -> None:
    quarters = np.concatenate([np.arange(-9, 10), 400001 + np.arange(-8, 9), [4 * 10**12 + 3]])
    found = sincosd_on(device, 90.0 * quarters)
    expected = np.array([[(0, 1), (1, 0), (0, -1), (-1, 0)][q % 4] for q in quarters])
    np.testing.assert_array_equal(found, expected)
    assert 36000090.0 in 90.0 * quarters


@pytest.mark.parametrize("turns", [0, 1_000_000])
def test_sine_and_cosine_are_good_to_a_few_roundings(
    turns: int, device: str, rng: np.random.Generator
) -> None:
    degrees = rng.uniform(-720, 720, 400) + 360.0 * turns
    degrees = np.concatenate([degrees, 45.0 * np.arange(-17, 18) + 360.0 * turns, [1e-9, -1e-300]])
    found = sincosd_on(device, degrees)
    for angle, pair in zip(degrees, found, strict=True):
        for value, exact in zip(pair, exact_sincosd(float(angle)), strict=True):
            assert abs(Decimal(float(value)) - exact) <= Decimal("4e-16")


def test_small_angles_keep_their_digits(device: str) -> None:
    degrees = np.array([1e-300, 1e-9, 1e-3, 0.7, 44.9])
    for angle, (sine, _) in zip(degrees, sincosd_on(device, degrees), strict=True):
        exact = exact_sincosd(float(angle))[0]
        assert abs(Decimal(float(sine)) / exact - 1) <= Decimal("6e-16")


def test_joint_positions_equal_the_path_in_numpy(device: str, rng: np.random.Generator) -> None:
    for _ in range(8):
        joints = random_joints(rng)
        p = random_path(rng, joints, 40)
        times = np.concatenate([p.bounds_ps, rng.integers(0, p.duration_ps + 1, 500)])
        found = wp.zeros((len(times), len(joints)), dtype=wp.float64, device=device)
        wp.launch(
            evaluate_joints,
            dim=found.shape,
            inputs=[path_arrays(p, device), *instants_on(device, p, times)],
            outputs=[found],
            device=device,
        )
        np.testing.assert_allclose(found.numpy(), p.positions(times), rtol=0, atol=1e-12 * 1e3)
        np.testing.assert_array_equal(found.numpy()[1 : len(p) + 1], p.q1)
        assert (p.arc >= 0).any()


@pytest.mark.parametrize("turns", [0, 1_000_000])
def test_pair_poses_equal_forward_kinematics(
    turns: int, device: str, rng: np.random.Generator
) -> None:
    for _ in range(10):
        joints = random_joints(rng)
        m = machine(joints, {}, [])
        links = [(a, b) for a in m.links for b in m.links if a != b]
        q = rng.uniform(-500, 500, (30, len(joints)))
        q[:, [j.rotary for j in joints]] += 360.0 * turns
        p = path(joints, q[0], [(1e-3, row) for row in q[1:]])
        shape = (len(p), len(links))
        rotations = wp.zeros(shape, dtype=wp.mat33d, device=device)
        shifts = wp.zeros(shape, dtype=wp.vec3d, device=device)
        arrays = [path_arrays(p, device), chain_arrays(tuple(joints), links, device)]
        wp.launch(
            evaluate_pair_poses,
            dim=shape,
            inputs=[*arrays, *instants_on(device, p, p.bounds_ps[1:])],
            outputs=[rotations, shifts],
            device=device,
        )
        world = world_from_link(m, p.q1)
        for k, (a, b) in enumerate(links):
            pose = np.linalg.inv(world[a]) @ world[b]
            np.testing.assert_allclose(rotations.numpy()[:, k], pose[:, :3, :3], atol=1e-14)
            np.testing.assert_allclose(shifts.numpy()[:, k], pose[:, :3, 3], rtol=0, atol=1e-11)


def test_only_the_joints_between_two_links_count() -> None:
    # bed - Y - A - C carries the table, bed - X - Z the spindle.
    tree = [("Y", "bed"), ("A", "link Y"), ("C", "link A"), ("X", "bed"), ("Z", "link X")]
    joints = tuple(joint(n, [0, 0, 1], parent, f"link {n}") for n, parent in tree)

    def between(a: str, b: str) -> str:
        chain = joints_between(joints, a, b)
        return " ".join(f"{'-+'[sign > 0]}{joints[column].name}" for column, sign in chain)

    assert between("link Z", "link C") == "-Z -X +Y +A +C"
    assert between("link C", "link A") == "-C"
    assert between("link Y", "link C") == "+A +C"
    assert between("bed", "link A") == "+Y +A"
    assert between("link C", "bed") == "-C -A -Y"
    assert between("link A", "link A") == ""
