"""Turned shapes: parts of a tool as frusta about its axis, inside the ideal shape and around it."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import SAME_HEIGHT_MM
from gcodesim.machine.shapes import Profile

Array = NDArray[np.float64]


def stretches(profile: Profile) -> tuple[tuple[float, float, float, float], ...]:
    """The frusta (z0, z1, r0, r1) under a profile of (r, z) points, from the tip up."""
    points = [(float(r), float(z)) for r, z in profile]
    if points[0][1] > points[-1][1]:
        points.reverse()
    return tuple(
        (z0, z1, r0, r1)
        for (r0, z0), (r1, z1) in pairwise(points)
        if z1 - z0 > SAME_HEIGHT_MM and max(r0, r1) > 0.0
    )


def turned_hull(standing: Array, most: int = 40) -> Sequence[tuple[float, float, float, float]]:
    """Frusta about Z around triangles (n, 3, 3), whatever their shape; at most so many.

    Between two heights of corners the distance of an edge from the axis is convex: the line between
    its largest values at both lies outside.
    """
    heights = np.unique(standing[:, :, 2])
    heights = heights[np.diff(heights, prepend=-np.inf) > SAME_HEIGHT_MM]
    if len(heights) > most + 1:
        heights = heights[np.linspace(0, len(heights) - 1, most + 1).astype(int)]
    found: list[tuple[float, float, float, float]] = []
    low, high = standing[:, :, 2].min(axis=1), standing[:, :, 2].max(axis=1)
    for z0, z1 in pairwise(heights.tolist()):
        here = standing[(low < z1 - SAME_HEIGHT_MM) & (high > z0 + SAME_HEIGHT_MM)]
        inside = standing[(low >= z0 - SAME_HEIGHT_MM) & (high <= z1 + SAME_HEIGHT_MM)]
        if not len(here):
            continue
        corners = np.concatenate([here, inside]).reshape(-1, 3)
        corners = corners[
            (corners[:, 2] > z0 - SAME_HEIGHT_MM) & (corners[:, 2] < z1 + SAME_HEIGHT_MM)
        ]
        ends = [section_radius(here, z) for z in (z0, z1)]
        between = np.hypot(corners[:, 0], corners[:, 1])
        across = corners[:, 2]
        share = (across - z0) / (z1 - z0)
        short = float(np.max(between - (ends[0] + share * (ends[1] - ends[0])), initial=0.0))
        found.append((z0, z1, ends[0] + max(short, 0.0), ends[1] + max(short, 0.0)))
    return tuple(found)


def section_radius(triangles: Array, height: float) -> float:
    """Largest distance from the axis Z of the section of triangles at a height [mm]."""
    start, end = triangles, np.roll(triangles, -1, axis=1)
    rise = end[:, :, 2] - start[:, :, 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        part = np.clip((height - start[:, :, 2]) / rise, 0.0, 1.0)
    points = start + np.nan_to_num(part)[:, :, None] * (end - start)
    here = np.abs(points[:, :, 2] - height) <= SAME_HEIGHT_MM
    distance = np.hypot(points[:, :, 0], points[:, :, 1])
    return float(distance[here].max(initial=0.0))
