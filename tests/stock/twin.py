"""The twin of the race: a stock of mutable voxels, pose after pose, and one point on its own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gcodesim.constants import DEFAULT_PERIOD_PS
from gcodesim.machine.kinematics import world_from_link
from gcodesim.machine.model import Machine, Part
from gcodesim.machine.spindle import tool_body
from gcodesim.machine.turned import stretches
from gcodesim.motion.path import Path
from gcodesim.motion.samples import tool_spans
from gcodesim.stock.workpiece import StockEvent

STEP_MM = 0.1
"""Poses of the twin are so far apart, at the tip and at the top of the tool."""


@dataclass(frozen=True)
class Pose:
    """A pose of the tool in the frame of the stock's link."""

    time_ps: int
    cuts: bool
    parts: tuple[Part, ...]
    gauge: np.ndarray
    axis: np.ndarray


def poses(machine: Machine, path: Path, link: str, reach: float = 80.0) -> list[Pose]:
    """Poses of a path, densely: by the kinematics of the machine, not by that of the race."""
    mount = machine.tool
    assert mount is not None
    found = []
    for span in tool_spans(path):
        body = tool_body(machine, span.tool)
        first, end = np.searchsorted(path.bounds_ps, [span.start_ps, span.end_ps]).tolist()
        for piece in range(first, end):
            start, stop = path.bounds_ps[piece : piece + 2].tolist()
            q = path.q1[piece] - path.q0[piece]
            length = np.linalg.norm(q[[0, 1, 3]]) + np.radians(np.abs(q[[2, 4]])).sum() * reach
            if path.arc[piece] >= 0:
                length += 60.0
            count = max(1, int(np.ceil(length / STEP_MM)))
            times = start + (np.arange(count + 1) * (stop - start)) // count
            world = world_from_link(machine, path.positions(times))
            seen = np.linalg.inv(world[link]) @ world[mount.link]
            cuts = path.cuts is None or bool(path.cuts[piece])
            gauge = seen[:, :3, :3] @ mount.gauge_point + seen[:, :3, 3]
            axis = seen[:, :3, :3] @ mount.axis
            found += [
                Pose(int(t), cuts, body.parts if body else (), g, a)
                for t, g, a in zip(times, gauge, axis, strict=True)
            ]
    return found


def depth_in(part: Part, gauge: np.ndarray, axis: np.ndarray, points: np.ndarray) -> np.ndarray:
    """How deep points (n, 3) are in the stretches of a part, along its radius and its faces."""
    z = (points - gauge) @ axis
    r = np.linalg.norm(points - gauge - z[:, None] * axis, axis=1)
    best = np.full(len(points), -np.inf)
    assert part.turned is not None
    for z0, z1, r0, r1 in cones_of(part):
        slope = (r1 - r0) / (z1 - z0)
        side = (r0 + slope * (z - z0) - r) / np.hypot(1.0, slope)
        best = np.maximum(best, np.minimum(side, np.minimum(z - z0, z1 - z)))
    if part.turned.ball:
        centre, radius = part.turned.ball
        best = np.maximum(best, radius - np.hypot(z - centre, r))
    return best


def cones_of(part: Part) -> list[tuple[float, float, float, float]]:
    """The stretches of a part, of a ball end mill those above its ball."""
    assert part.turned is not None
    low = part.turned.ball[0] - 1e-9 if part.turned.ball else -np.inf
    return [cone for cone in stretches(part.turned.outer) if cone[0] >= low]


def first_voxel(
    machine: Machine, path: Path, link: str, box: np.ndarray, size: float, inset: float
) -> tuple[int, np.ndarray] | None:
    """The first pose at which a voxel that was not cut is deeper than the inset in a body.

    Flutes take a little more than they do, for what stands between two poses.
    """
    count = np.round((box[1] - box[0]) / size).astype(int)
    axes = [box[0, k] + (np.arange(count[k]) + 0.5) * size for k in range(3)]
    centres = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    left = np.ones(tuple(count), bool)
    for pose in poses(machine, path, link):
        for part in sorted(pose.parts, key=lambda p: p.role != "flute"):
            cuts = part.role == "flute" and pose.cuts
            low, high = part_box(part, pose)
            first = np.maximum(np.floor((low - box[0]) / size), 0).astype(int)
            last = np.minimum(np.ceil((high - box[0]) / size), count).astype(int)
            if (first >= last).any():
                continue
            where = tuple(slice(a, b) for a, b in zip(first, last, strict=True))
            block = centres[where]
            depth = depth_in(part, pose.gauge, pose.axis, block.reshape(-1, 3))
            depth = depth.reshape(block.shape[:3])
            if cuts:
                left[where] &= depth < -STEP_MM / 2.0
            elif (hit := left[where] & (depth > inset)).any():
                return pose.time_ps, block[hit][0]
    return None


def part_box(part: Part, pose: Pose) -> tuple[np.ndarray, np.ndarray]:
    """A box around a part in a pose."""
    assert part.turned is not None
    ends = [z for cone in cones_of(part) for z in cone[:2]]
    radius = max(r for cone in cones_of(part) for r in cone[2:])
    if part.turned.ball:
        ends.append(part.turned.ball[0] - part.turned.ball[1])
    points = [pose.gauge + z * pose.axis for z in (min(ends), max(ends))]
    return np.min(points, axis=0) - radius, np.max(points, axis=0) + radius


def is_witnessed(event: StockEvent, machine: Machine, path: Path, link: str, inset: float) -> bool:
    """Whether the point of an event is deep in the body then, and in no cutting flute before."""
    point = np.array([event.point])
    before = [p for p in poses(machine, path, link) if p.cuts and p.time_ps < event.time_ps]
    for pose in before:
        flutes = [part for part in pose.parts if part.role == "flute"]
        if any(depth_in(f, pose.gauge, pose.axis, point)[0] > 1e-6 for f in flutes):
            return False
    mount = machine.tool
    assert mount is not None
    # A witness is met within the sample period that ends with its sample.
    times = np.linspace(event.time_ps - DEFAULT_PERIOD_PS, event.time_ps, 5).astype(np.int64)
    world = world_from_link(machine, path.positions(times))
    seen = np.linalg.inv(world[link]) @ world[mount.link]
    gauges = seen[:, :3, :3] @ mount.gauge_point + seen[:, :3, 3]
    axes = seen[:, :3, :3] @ mount.axis
    depths = [depth_in(event.part, g, a, point)[0] for g, a in zip(gauges, axes, strict=True)]
    return max(depths) > inset / 2.0 - 1e-6
