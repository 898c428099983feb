"""Forward kinematics: where every link stands for given joint positions, float64 NumPy.

Product of exponentials: a link is displaced from its zero pose by ``D = T_1(q_1) ... T_n(q_n)``
over the joints from the root to it; axes and points are world coordinates at the zero pose.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gcodesim.machine.model import Joint, Machine

Array = NDArray[np.float64]


def sincosd(degrees: ArrayLike) -> tuple[Array, Array]:
    """Sine and cosine of angles in degrees, exact at every multiple of 90.

    The angle is reduced in degrees, where the reduction is exact (fmod; Sterbenz' lemma), so that a
    million turns cost no accuracy.
    """
    turned = np.fmod(np.asarray(degrees, dtype=np.float64), 360.0)
    quadrant = np.rint(turned / 90.0)
    rest = np.radians(turned - 90.0 * quadrant)
    s, c = np.sin(rest), np.cos(rest)
    k = quadrant.astype(np.int64)
    odd = (k & 1) == 1
    # + 0.0 turns -0.0 into 0.0, so that equal poses are equal bit for bit
    sine = np.where(odd, c, s) * (1.0 - (k & 2)) + 0.0
    cosine = np.where(odd, s, c) * (1.0 - ((k + 1) & 2)) + 0.0
    return sine, cosine


def rotation(axis: ArrayLike, degrees: ArrayLike) -> Array:
    """Right-hand rotation about a unit vector through the origin, (..., 3, 3) for (...) angles."""
    x, y, z = np.asarray(axis, dtype=np.float64)
    sine, cosine = sincosd(degrees)
    cross = cross_matrix(axis)
    along = np.outer([x, y, z], [x, y, z])
    sine, cosine = sine[..., None, None], cosine[..., None, None]
    return np.asarray(cosine * (np.eye(3) - along) + along + sine * cross)


def cross_matrix(axis: ArrayLike) -> Array:
    """The matrix of ``axis x v``, (3, 3)."""
    x, y, z = np.asarray(axis, dtype=np.float64)
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def turned(vectors: Array, axis: ArrayLike, degrees: Array) -> Array:
    """Vectors (n, 3) or (1, 3) turned right-handed about a unit vector by angles (n,) [deg]."""
    cross = cross_matrix(axis)
    sine, cosine = sincosd(degrees)
    swept = vectors @ cross.T
    return np.asarray(vectors + sine[:, None] * swept + (1.0 - cosine)[:, None] * (swept @ cross.T))


def rotation_from_z(axis: ArrayLike) -> Array:
    """The smallest rotation that turns +Z to a unit vector, (3, 3); half a turn about X for -Z."""
    x, y, z = np.asarray(axis, dtype=np.float64)
    if np.hypot(x, y) == 0.0:
        return rotation([1.0, 0.0, 0.0], 0.0 if z > 0 else 180.0)
    side = np.array([-y, x, 0.0]) / np.hypot(x, y)
    return rotation(side, np.degrees(np.arctan2(np.hypot(x, y), z)))


def joint_displacement(joint: Joint, q: ArrayLike) -> Array:
    """Displacement of the child of one joint, (..., 4, 4) for positions q (...) [mm or deg]."""
    position = np.asarray(q, dtype=np.float64)
    displacement = np.zeros((*position.shape, 4, 4))
    displacement[..., 3, 3] = 1.0
    if joint.rotary:
        turn = rotation(joint.axis, position)
        displacement[..., :3, :3] = turn
        displacement[..., :3, 3] = joint.point - turn @ joint.point
    else:
        displacement[..., :3, :3] = np.eye(3)
        displacement[..., :3, 3] = position[..., None] * joint.axis
    return displacement


def world_from_link(machine: Machine, q: ArrayLike) -> dict[str, Array]:
    """Pose of every link.

    Args:
        machine: the machine, with nj joints.
        q: joint positions in joint order, shape (..., nj) [mm or deg].

    Returns:
        Link name -> (..., 4, 4); the identity at the zero pose.
    """
    return poses_of(machine.links, machine.joints, q)


def poses_of(links: Sequence[str], joints: Sequence[Joint], q: ArrayLike) -> dict[str, Array]:
    """Pose of every link, as `world_from_link` gives it; joints parents first."""
    positions = np.asarray(q, dtype=np.float64)
    if positions.shape[-1:] != (len(joints),):
        raise ValueError(f"{len(joints)} joint positions expected, not {positions.shape}")
    moved = {joint.child for joint in joints}
    fixed = np.broadcast_to(np.eye(4), (*positions.shape[:-1], 4, 4))
    poses = {link: fixed.copy() for link in links if link not in moved}
    for index, joint in enumerate(joints):
        displacement = joint_displacement(joint, positions[..., index])
        poses[joint.child] = poses[joint.parent] @ displacement
    return poses


def transform(pose: Array, points: ArrayLike) -> Array:
    """Points (..., 3) moved by one pose (4, 4)."""
    return np.asarray(points, dtype=np.float64) @ pose[:3, :3].T + pose[:3, 3]
