"""Poses on the device: joint positions along the path and the pose of one link in another's frame.

The pose of body b in the frame of body a needs only the joints on the tree path between them
(shared joints cancel), so it is a chain of screw motions: the joints of a inverted, from a to the
common ancestor, then those of b outwards. Product of exponentials form: joint axes and points are
world coordinates at the zero pose, where all link frames coincide with the world.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from gcodesim.collision.geometry.device import BIT_EQUAL
from gcodesim.machine.model import Joint
from gcodesim.motion.path import Path

wp.set_module_options(BIT_EQUAL)

DEGREE = wp.constant(wp.float64(np.pi / 180.0))


@wp.struct
class PathArrays:
    """A Path on the device; see motion/path.py for the fields."""

    bounds_ps: wp.array[wp.int64]
    q0: wp.array2d[wp.float64]
    q1: wp.array2d[wp.float64]
    law: wp.array[wp.vec3d]
    arc: wp.array[wp.int32]
    arc_u: wp.array[wp.vec3d]
    arc_v: wp.array[wp.vec3d]
    arc_lift: wp.array[wp.vec3d]
    arc_size: wp.array[wp.vec3d]  # r0, r1, sweep
    xyz: wp.vec3i


@wp.struct
class ChainArrays:
    """The joints between the bodies of each pair, in the order in which they are multiplied."""

    first: wp.array[wp.int32]  # pair -> its first step; one more entry than pairs
    joint: wp.array[wp.int32]  # step -> column of the joint
    sign: wp.array[wp.float64]  # +1 outwards to b, -1 inwards from a
    rotary: wp.array[wp.int32]  # joint -> 1 when it turns
    axis: wp.array[wp.vec3d]
    point: wp.array[wp.vec3d]


@wp.struct
class Pose:
    """A rigid motion x -> R x + t."""

    R: wp.mat33d
    t: wp.vec3d


@wp.func
def sincosd(degrees: wp.float64):
    """Sine and cosine of an angle in degrees, exact at multiples of 90, the same on every device.

    Exact reduction (fmod, then the nearest right angle), then the Taylor polynomials on
    [-45, 45] degrees: truncation below 3e-17, so the error is that of a few roundings.
    """
    r = wp.mod(degrees, wp.float64(360.0))
    quarter = wp.rint(r / wp.float64(90.0))
    x = (r - quarter * wp.float64(90.0)) * DEGREE
    y = x * x
    s = wp.float64(-7.6471637318198164759e-13)
    s = s * y + wp.float64(1.6059043836821614599e-10)
    s = s * y + wp.float64(-2.5052108385441718775e-8)
    s = s * y + wp.float64(2.7557319223985890653e-6)
    s = s * y + wp.float64(-1.9841269841269841270e-4)
    s = s * y + wp.float64(8.3333333333333333333e-3)
    s = s * y + wp.float64(-1.6666666666666666667e-1)
    sine = x + x * y * s
    c = wp.float64(4.7794773323873852974e-14)
    c = c * y + wp.float64(-1.1470745597729724714e-11)
    c = c * y + wp.float64(2.0876756987868098979e-9)
    c = c * y + wp.float64(-2.7557319223985890653e-7)
    c = c * y + wp.float64(2.4801587301587301587e-5)
    c = c * y + wp.float64(-1.3888888888888888889e-3)
    c = c * y + wp.float64(4.1666666666666666667e-2)
    cosine = wp.float64(1.0) - y * wp.float64(0.5) + y * y * c
    turn = (wp.int32(quarter) + 8) % 4
    if turn == 1:
        return wp.vec2d(cosine, -sine)
    if turn == 2:
        return wp.vec2d(-sine, -cosine)
    if turn == 3:
        return wp.vec2d(-cosine, sine)
    return wp.vec2d(sine, cosine)


@wp.func
def path_fraction_at(path: PathArrays, piece: wp.int32, time_ps: wp.int64):
    """Fraction of the piece's path at a program time, 0..1."""
    start = path.bounds_ps[piece]
    end = path.bounds_ps[piece + 1]
    if time_ps >= end:
        return wp.float64(1.0)
    tau = wp.float64(time_ps - start) / wp.float64(end - start)
    law = path.law[piece]
    return tau * (law[0] + tau * (law[1] + tau * law[2]))


@wp.func
def arc_displacement(path: PathArrays, arc: wp.int32, s: wp.float64):
    """Displacement of X Y Z from the start of an arc, as a chord: no digits lost on tiny arcs."""
    size = path.arc_size[arc]
    half = sincosd(size[2] * s * wp.float64(0.5))
    grown = (size[1] - size[0]) * s
    radius = size[0] + grown
    along_u = grown - wp.float64(2.0) * radius * half[0] * half[0]
    along_v = wp.float64(2.0) * radius * half[0] * half[1]
    return along_u * path.arc_u[arc] + along_v * path.arc_v[arc] + s * path.arc_lift[arc]


@wp.func
def joint_position(path: PathArrays, piece: wp.int32, s: wp.float64, joint: wp.int32):
    """Position [mm or deg] of one joint at the fraction `s` of a piece."""
    q1 = path.q1[piece, joint]
    if s >= wp.float64(1.0):
        return q1
    q0 = path.q0[piece, joint]
    arc = path.arc[piece]
    if arc >= 0:
        for k in range(3):
            if path.xyz[k] == joint:
                return q0 + arc_displacement(path, arc, s)[k]
    return q0 + s * (q1 - q0)


@wp.func
def rotation(axis: wp.vec3d, degrees: wp.float64):
    """Right-hand rotation about a unit vector."""
    sc = sincosd(degrees)
    s = sc[0] * axis
    k = (wp.float64(1.0) - sc[1]) * axis
    return wp.mat33d(
        sc[1] + k[0] * axis[0],
        k[0] * axis[1] - s[2],
        k[0] * axis[2] + s[1],
        k[1] * axis[0] + s[2],
        sc[1] + k[1] * axis[1],
        k[1] * axis[2] - s[0],
        k[2] * axis[0] - s[1],
        k[2] * axis[1] + s[0],
        sc[1] + k[2] * axis[2],
    )


@wp.func
def pair_pose(
    path: PathArrays, chains: ChainArrays, pair: wp.int32, piece: wp.int32, time_ps: wp.int64
):
    """Pose of body b in the frame of body a."""
    s = path_fraction_at(path, piece, time_ps)
    pose = Pose()
    pose.R = wp.identity(n=3, dtype=wp.float64)
    pose.t = wp.vec3d()
    for step in range(chains.first[pair], chains.first[pair + 1]):
        joint = chains.joint[step]
        q = chains.sign[step] * joint_position(path, piece, s, joint)
        if chains.rotary[joint] == 1:
            turn = rotation(chains.axis[joint], q)
            centre = chains.point[joint]
            pose.t = pose.t + pose.R * (centre - turn * centre)
            pose.R = pose.R * turn
        else:
            pose.t = pose.t + pose.R * (q * chains.axis[joint])
    return pose


def path_arrays(path: Path, device: str) -> PathArrays:
    """Copy a path to the device."""
    arrays = PathArrays()
    arcs = path.arcs
    size = np.stack([arcs["r0"], arcs["r1"], arcs["sweep"]], axis=-1)
    arrays.bounds_ps = wp.array(path.bounds_ps, dtype=wp.int64, device=device)
    arrays.q0 = wp.array(path.q0, dtype=wp.float64, device=device)
    arrays.q1 = wp.array(path.q1, dtype=wp.float64, device=device)
    arrays.law = wp.array(path.law, dtype=wp.vec3d, device=device)
    arrays.arc = wp.array(path.arc, dtype=wp.int32, device=device)
    arrays.arc_u = _vectors(arcs["u"], device)
    arrays.arc_v = _vectors(arcs["v"], device)
    arrays.arc_lift = _vectors(arcs["lift"], device)
    arrays.arc_size = _vectors(size, device)
    arrays.xyz = wp.vec3i(*path.xyz)
    return arrays


def _vectors(rows: NDArray[np.float64], device: str) -> Any:
    return wp.array(np.ascontiguousarray(rows), dtype=wp.vec3d, device=device)


def joints_between(joints: tuple[Joint, ...], a: str, b: str) -> list[tuple[int, int]]:
    """Joints (column, sign) on the tree path from link `a` to link `b`, in multiplication order."""
    parent = {joint.child: (column, joint.parent) for column, joint in enumerate(joints)}

    def upwards(link: str) -> list[int]:
        columns = []
        while link in parent:
            column, link = parent[link]
            columns.append(column)
        return columns

    from_a, from_b = upwards(a), upwards(b)
    shared = set(from_a) & set(from_b)
    inwards = [(column, -1) for column in from_a if column not in shared]
    return inwards + [(column, 1) for column in reversed(from_b) if column not in shared]


def chain_arrays(
    joints: tuple[Joint, ...], links: list[tuple[str, str]], device: str
) -> ChainArrays:
    """Chains between the given pairs of links on the device."""
    return step_arrays(joints, [joints_between(joints, a, b) for a, b in links], device)


def step_arrays(
    joints: tuple[Joint, ...], steps: list[list[tuple[int, int]]], device: str
) -> ChainArrays:
    """Chains given as joints (column, sign) on the device."""
    flat = [step for chain in steps for step in chain]
    arrays = ChainArrays()
    first = np.concatenate([[0], np.cumsum([len(chain) for chain in steps])])
    arrays.first = wp.array(first, dtype=wp.int32, device=device)
    arrays.joint = wp.array([column for column, _ in flat], dtype=wp.int32, device=device)
    arrays.sign = wp.array([float(sign) for _, sign in flat], dtype=wp.float64, device=device)
    arrays.rotary = wp.array([int(j.rotary) for j in joints], dtype=wp.int32, device=device)
    arrays.axis = _vectors(np.array([j.axis for j in joints]), device)
    arrays.point = _vectors(np.array([j.point for j in joints]), device)
    return arrays
