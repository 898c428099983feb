"""Departure: how far a pair may stand from where the path has it, and what that widens.

Three things keep a machine off the path that is checked: a control that rounds corners within a
stated tolerance, drives that lag behind, and pieces that stand for a move under tool centre point
control. Each is bounded before the search, which then proves that much more distance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gcodesim.collision.bounds import axis_distances, common_frame
from gcodesim.collision.poses import joints_between
from gcodesim.collision.scene import Scene
from gcodesim.machine.model import Joint
from gcodesim.motion.off_path import OffPath


def departures(scene: Scene, joints: tuple[Joint, ...], off: OffPath) -> tuple[float, ...]:
    """How much nearer than on its path each pair of a scene may come [mm].

    A joint that is off by e moves a point of the body it carries by at most e, or by e times its
    distance from the axis when it turns; what the joints between two bodies do adds up. (The
    deviation bound of bounds.py, for a deviation that lasts.)

    Args:
        scene: the pairs.
        joints: with the travel of the program as their limits.
        off: see OffPath.
    """
    lag = off.lag or (0.0,) * len(joints)
    # Joints beyond a lagging axis may themselves be off, to either side of their travel.
    loose = tuple(
        replace(joint, lower=joint.lower - e, upper=joint.upper + e)
        for joint, e in zip(joints, lag, strict=True)
    )
    found = []
    for shapes, links in zip(scene.shapes, scene.links, strict=True):
        frame = common_frame(joints, *links)
        total = off.tolerance_mm if joints_between(joints, *links) else 0.0
        for shape, link in zip(shapes, links, strict=True):
            chain = joints_between(joints, frame, link)
            total += _side(loose, lag, chain, shape.regions.triangles)
        found.append(total)
    return tuple(found)


def _side(
    joints: tuple[Joint, ...],
    lag: Sequence[float],
    chain: list[tuple[int, int]],
    triangles: np.ndarray,
) -> float:
    moved = sum(lag[column] for column, _ in chain if not joints[column].rotary)
    for step, (column, _) in enumerate(chain):
        if joints[column].rotary and lag[column] > 0.0:
            lever = axis_distances(joints, column, chain[step + 1 :], triangles).max()
            moved += float(np.radians(lag[column]) * lever)
    return moved
