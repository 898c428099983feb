"""Departure: how far a pair may stand from where the path has it, and from sample to sample.

Three things keep a machine off the path that is checked: a control that rounds corners within a
stated tolerance, drives that lag, and straight pieces in place of a move under tool centre point
control. Each is bounded before the search, which then proves that much more distance: the lag of
the drives by what it can be at that time, the others by their largest value.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gcodesim.collision.bodies.scene import Scene
from gcodesim.collision.bounds.motion_bounds import axis_distances, common_frame
from gcodesim.collision.geometry.poses import joints_between
from gcodesim.constants import PS_PER_S
from gcodesim.machine.model import Joint
from gcodesim.motion.lag import Lag
from gcodesim.motion.off_path import OffPath
from gcodesim.motion.path import Path
from gcodesim.motion.speeds import piece_speeds


@dataclass(frozen=True)
class SampleStep:
    """How far a vertex of one body moves against its partner from one sample to the next.

    Attributes:
        distance: upper bound [mm].
        pair: index in the scene.
        piece: of the path.
    """

    distance: float
    pair: int
    piece: int


@dataclass(frozen=True)
class Departures:
    """How much nearer than on its path each pair of a scene may come.

    Attributes:
        largest: at any time, shape (pairs,) [mm].
        steady: the part of it that does not depend on time, shape (pairs,) [mm].
        levers: what a unit of lag of each joint of `late` adds, shape (pairs, its joints).
        late: the lag over time; None = nothing depends on time.
    """

    largest: NDArray[np.float64]
    steady: NDArray[np.float64]
    levers: NDArray[np.float64]
    late: Lag | None = None

    def varies(self, pair: int) -> bool:
        """Whether the departure of a pair depends on time."""
        return self.late is not None and bool(self.levers[pair].any())

    def over(
        self, pair: int, start_ps: NDArray[np.int64], end_ps: NDArray[np.int64]
    ) -> NDArray[np.float64]:
        """Bounds for one pair that hold all through some stretches of time, shape (m,) [mm]."""
        if self.late is None:
            return np.full(len(start_ps), self.largest[pair])
        bound = self.steady[pair] + self.late.over(start_ps, end_ps) @ self.levers[pair]
        return np.minimum(bound, self.largest[pair])

    def widened(self, more: NDArray[np.float64]) -> Departures:
        """The same with more at any time, shape (pairs,) [mm]."""
        return replace(self, largest=self.largest + more, steady=self.steady + more)


def departures(scene: Scene, joints: tuple[Joint, ...], off: OffPath) -> Departures:
    """How much nearer than on its path each pair of a scene may come.

    A joint that is off by e moves a point of the body it carries by at most e, or by e times its
    distance from the axis when it turns; what the joints between two bodies do adds up. (The
    deviation bound of motion_bounds.py, for a deviation that lasts.)

    Args:
        scene: the pairs.
        joints: with the travel of the program as their limits.
        off: see OffPath.
    """
    moving = [bool(joints_between(joints, *links)) for links in scene.links]
    steady = np.where(moving, off.tolerance_mm, 0.0)
    levers = np.zeros((len(scene.pairs), len(off.lag)))
    if any(off.lag):
        # Joints beyond a lagging axis may themselves be off, to either side of their travel.
        loose = tuple(
            replace(joint, lower=joint.lower - e, upper=joint.upper + e)
            for joint, e in zip(joints, off.lag, strict=True)
        )
        levers = joint_levers(scene, loose)
    largest = steady + levers @ np.array(off.lag)
    if off.late is None:
        return Departures(largest, largest, levers)
    return Departures(largest, steady, levers[:, off.late.columns], off.late)


def largest_step(
    scene: Scene, joints: tuple[Joint, ...], path: Path, pieces: slice, period_ps: int
) -> SampleStep | None:
    """The largest step from sample to sample of any pair on some pieces; None without motion."""
    speeds = piece_speeds(path, pieces)
    if not len(speeds) or not scene.pairs:
        return None
    steps = speeds @ joint_levers(scene, joints).T * (period_ps / PS_PER_S)
    piece, pair = np.unravel_index(int(np.argmax(steps)), steps.shape)
    return SampleStep(float(steps[piece, pair]), int(pair), (pieces.start or 0) + int(piece))


def joint_levers(scene: Scene, joints: tuple[Joint, ...]) -> np.ndarray:
    """How far a unit of each joint moves a point of one body of each pair against the other.

    Upper bounds, shape (pairs, joints): 1 for a linear joint between the two, the largest distance
    from the axis for a rotary one [mm/deg], 0 for a joint that moves both or none.
    """
    levers = np.zeros((len(scene.pairs), len(joints)))
    for pair, (shapes, links) in enumerate(zip(scene.shapes, scene.links, strict=True)):
        frame = common_frame(joints, *links)
        for shape, link in zip(shapes, links, strict=True):
            chain = joints_between(joints, frame, link)
            for step, (column, _) in enumerate(chain):
                lever = 1.0
                if joints[column].rotary:
                    triangles, beyond = shape.regions.triangles, chain[step + 1 :]
                    farthest = axis_distances(joints, column, beyond, triangles).max()
                    lever = float(np.radians(farthest))
                levers[pair, column] += lever
    return levers
