"""The flute as it may not touch the part: inside the real one, and smaller by the inset.

A flute that is fed leaves the very surface that it touches, so that the whole of it would touch a
finished wall on its way out. Of a turned flute the outline inside the true one is taken, of every
shell of a mesh the largest solid of revolution inside: a profile (r, z) about the spindle axis. It
shrinks by the inset along r and along z, and is turned as a polygon inside its circles. What the
smaller flute touches, the real one is in by at least the inset square to a wall or floor; what the
real one is in by sqrt(2) times that, the smaller one touches, but for the corners of a coarse mesh.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import (
    FLUTE_INSET_MM,
    FLUTE_SIDES,
    MOST_SECTIONS,
    ROUND_SIDES,
    SAME_HEIGHT_MM,
    TOUCHING_MM,
)
from gcodesim.machine import shapes
from gcodesim.machine.kinematics import rotation_from_z
from gcodesim.machine.model import Body, Machine, Part
from gcodesim.machine.spindle import tool_body
from gcodesim.machine.turned import section_radius

Array = NDArray[np.float64]
Points = list[tuple[float, float]]


_made: WeakKeyDictionary[Part, dict[tuple[tuple[float, ...], ...], Part | None]] = (
    WeakKeyDictionary()
)
"""What was made of a part, for as long as the part is there."""


def smaller_flute(machine: Machine, number: int | None) -> tuple[Body | None, tuple[str, ...]]:
    """The flute of tool `number` (None: at program start), smaller by the inset.

    Returns:
        The body, None without a flute, and the names of parts that cannot be made smaller, for
        they are not round about the spindle axis, or not closed.
    """
    whole = tool_body(machine, number)
    if whole is None or machine.tool is None:
        return None, ()
    axis, point = (tuple(v.tolist()) for v in (machine.tool.axis, machine.tool.gauge_point))
    flutes = [part for part in whole.parts if part.role == "flute"]
    smaller = [(part, _kept_smaller(part, axis, point)) for part in flutes]
    parts = tuple(found for _, found in smaller if found)
    body = replace(whole, parts=parts) if parts else None
    return body, tuple(part.name for part, found in smaller if found is None)


def above_flute(machine: Machine) -> Body | None:
    """What of a mounted tool of one shape may never touch the part: all above the flute's end.

    Returns:
        The body, as a shank; None where the end is not known or the shape is not round.
    """
    mount = machine.tool
    whole = mount.one_shape if mount else None
    if mount is None or whole is None or not mount.flute or not whole.closed:
        return None
    turn, point = rotation_from_z(mount.axis), mount.gauge_point
    found = []
    for shell in shapes.shells(whole.triangles):
        standing = (shell - point) @ turn
        if round_profile(standing) is None:
            return None
        found += [_cut_off(standing, mount.flute - mount.length)]
    triangles = np.concatenate(found)
    if not len(triangles):
        return None
    part = replace(whole, triangles=shapes.place(triangles, turn, point), role="shank")
    return Body(mount.name, mount.link, (part,))


def _cut_off(shell: Array, height: float) -> Array:
    """What of a shell lies above a height, closed there: sections of it are about round."""
    kept: list[list[Array]] = []
    rim: list[Array] = []
    for triangle in shell:
        corners: list[Array] = []
        for start, end in zip(triangle, np.roll(triangle, -1, axis=0), strict=True):
            if start[2] >= height:
                corners.append(start)
            if (start[2] >= height) != (end[2] >= height):
                # From the lower to the upper end, so that both triangles of an edge agree.
                low, high = sorted((start, end), key=lambda p: float(p[2]))
                at = low + (height - low[2]) / (high[2] - low[2]) * (high - low)
                at[2] = height
                corners.append(at)
                rim.append(at)
        kept += [[corners[0], *corners[i : i + 2]] for i in range(1, len(corners) - 1)]
    if rim:
        ring = np.unique(np.array(rim), axis=0)
        ring = ring[np.argsort(np.arctan2(ring[:, 1], ring[:, 0]))]
        centre = np.array([0.0, 0.0, height])
        kept += [[centre, b, a] for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True)]
    return np.array(kept, np.float64).reshape(-1, 3, 3)


def _kept_smaller(
    part: Part, axis: tuple[float, float, float], point: tuple[float, float, float]
) -> Part | None:
    """As `_smaller`, made once for a part."""
    kept = _made.setdefault(part, {})
    if (axis, point) not in kept:
        kept[axis, point] = _smaller(part, axis, point)
    return kept[axis, point]


def _smaller(
    part: Part, axis: tuple[float, float, float], point: tuple[float, float, float]
) -> Part | None:
    """A part smaller by the inset, None where its shape does not allow it."""
    if not part.closed:
        return None
    turn = rotation_from_z(axis)
    found = []
    for profile in _profiles(part, turn, np.array(point)):
        smaller = shrunk(profile, FLUTE_INSET_MM) if profile else []
        if not smaller:
            return None
        inside = np.cos(np.pi / FLUTE_SIDES)
        try:
            found.append(shapes.revolve([(r * inside, z) for r, z in smaller], FLUTE_SIDES))
        except ValueError:
            return None
    triangles = shapes.place(np.concatenate(found), turn, point)
    return replace(part, triangles=triangles, source=f"{part.source}, {FLUTE_INSET_MM} mm smaller")


def _profiles(part: Part, turn: Array, point: Array) -> list[Points | None]:
    """A profile inside every shell: of a turned part the one that its numbers make."""
    if part.turned is None:
        return [round_profile((shell - point) @ turn) for shell in shapes.shells(part.triangles)]
    steps = (pair for pair in pairwise(part.turned.inner) if pair[0][1] < pair[1][1])
    return [[corner for pair in steps for corner in pair]]


def round_profile(shell: Array) -> Points | None:
    """Profile (r, z) of the largest solid of revolution about Z inside a closed shell.

    Between two heights of corners every triangle cuts a section along a line, whose distance from
    the axis is linear in z: the least of them is never below its chord, so the chord lies inside.

    Returns:
        None where a section is not round, or the axis lies outside.
    """
    z = shell[:, :, 2]
    heights = np.unique(z)
    heights = heights[np.diff(heights, prepend=-np.inf) > SAME_HEIGHT_MM]
    if not 2 <= len(heights) <= MOST_SECTIONS:
        return None
    normal = np.cross(shell[:, 1] - shell[:, 0], shell[:, 2] - shell[:, 0])
    across = np.hypot(normal[:, 0], normal[:, 1])
    offset = np.sum(normal * shell[:, 0], axis=1)
    profile: Points = []
    for low, high in pairwise(heights.tolist()):
        spans = (z.min(axis=1) < low + SAME_HEIGHT_MM) & (z.max(axis=1) > high - SAME_HEIGHT_MM)
        spans &= across > 0.0
        if not spans.any():
            return None
        for height in (low, high):
            lines = (offset[spans] - normal[spans, 2] * height) / across[spans]
            inner, outer = float(lines.min()), section_radius(shell[spans], height)
            if inner < outer * np.cos(np.pi / ROUND_SIDES) - TOUCHING_MM:
                return None
            profile.append((max(inner, 0.0), height))
    return profile


def shrunk(profile: Points, inset: float) -> Points:
    """A profile smaller by the inset along r and along z; empty where nothing is left.

    Its radius at a height is the least one within the inset above and below, less the inset.

    Args:
        profile: two points for every stretch of z, one after the other.
        inset: [mm].
    """
    stretches = [(a, b) for a, b in zip(profile[::2], profile[1::2], strict=True)]
    bottom, top = profile[0][1] + inset, profile[-1][1] - inset
    corners = np.unique([z for _, z in profile])
    nodes = np.concatenate([corners - inset, corners + inset, [bottom, top]])
    nodes = np.unique(nodes[(nodes >= bottom) & (nodes <= top)])
    found: Points = []
    for low, high in pairwise(nodes.tolist()):
        middle = (low + high) / 2.0
        least = [r for r, z in profile if middle - inset < z < middle + inset]
        edges = [_stretch_at(stretches, middle + side) for side in (-inset, inset)]
        ends = [
            min([*least, _radius(edges[0], z - inset), _radius(edges[1], z + inset)])
            for z in (low, high)
        ]
        found += _above_axis((ends[0] - inset, low), (ends[1] - inset, high))
    return found if any(r > 0.0 for r, _ in found) else []


def _stretch_at(
    stretches: list[tuple[tuple[float, float], tuple[float, float]]], z: float
) -> tuple[tuple[float, float], tuple[float, float]]:
    return next((s for s in stretches if z <= s[1][1]), stretches[-1])


def _radius(stretch: tuple[tuple[float, float], tuple[float, float]], z: float) -> float:
    (r0, z0), (r1, z1) = stretch
    return r0 + (r1 - r0) * min(max((z - z0) / (z1 - z0), 0.0), 1.0)


def _above_axis(start: tuple[float, float], end: tuple[float, float]) -> Points:
    """A stretch of a profile with 0 where its radius is negative."""
    (r0, z0), (r1, z1) = start, end
    points = [(max(r0, 0.0), z0), (max(r1, 0.0), z1)]
    if min(r0, r1) < 0.0 < max(r0, r1):
        points.insert(1, (0.0, z0 + (z1 - z0) * r0 / (r0 - r1)))
    return points
