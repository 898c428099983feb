"""Distances: how far apart every pair is at chosen instants, and between which points."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gcodesim.collision.bodies.scene import Scene, build_scene, is_present
from gcodesim.collision.bounds.forest import build_trees
from gcodesim.collision.geometry.closest import ForestArrays
from gcodesim.collision.geometry.poses import path_arrays
from gcodesim.collision.instants.contact import common_point, nearest_points
from gcodesim.collision.instants.nearest_triangles import nearest_triangles
from gcodesim.machine.kinematics import transform, world_from_link
from gcodesim.machine.model import Machine
from gcodesim.machine.spindle import bodies_in_place, table_entry, tool_body
from gcodesim.motion.path import Path
from gcodesim.motion.samples import tool_spans

Floats = NDArray[np.float64]
Times = NDArray[np.int64]

FRAMES, FEWEST = 250, 16
"""Frames at equal steps of time: at most, and at least, whatever they cost."""

WORK = 4_000_000
"""Steps of the walks that all frames may cost: some 2 s on one core."""

LINK_STEPS = 2_500
"""Steps for which the nearest points of a pair could be had."""

ROUNDS = 3
"""Of looking for the nearest moment: each within two steps of the one before."""


@dataclass(frozen=True)
class NearestPoints:
    """The nearest points of a pair at a frame, of a and of b, world coordinates (2, 3) [mm]."""

    frame: int
    pair: int
    points: Floats


@dataclass(frozen=True)
class Distances:
    """Distances of all pairs at n frames.

    Attributes:
        time_ps: when, ascending, shape (n,).
        distance: between the surfaces [mm], 0 where they touch, shape (n, pairs of the machine);
            NaN where a body of the pair is not there, or where it could not be decided.
        links: of the nearest pair of every frame, and of every pair at its nearest frame.
    """

    time_ps: Times
    distance: Floats
    links: tuple[NearestPoints, ...]


@dataclass(frozen=True)
class Separation:
    """A pair where it is nearest: its distance [mm], 0 where it touches, and its nearest points."""

    time_ps: int
    distance: float
    points: Floats


@dataclass(frozen=True)
class Rig:
    """The pairs that are there with one tool in the spindle.

    Attributes:
        columns: their numbers in the machine.
        triangles: of the forest, shape (n, 3, 3) [mm].
    """

    scene: Scene
    forest: ForestArrays
    columns: tuple[int, ...]
    triangles: Floats


@dataclass(frozen=True)
class Look:
    """Distances at n instants, as Distances has them, and what they come from.

    Attributes:
        rows: nearest triangles in the rig of the instant, shape (n, pairs, 2).
        rigs: of every instant, None where it has no pairs.
        steps: what it cost.
    """

    machine: Machine
    positions: Floats
    distance: Floats
    rows: NDArray[np.int32]
    rigs: list[Rig | None]
    steps: int = 0

    def links(self) -> Iterator[NearestPoints]:
        """Yield the links of Distances."""
        known = np.where(np.isnan(self.distance), np.inf, self.distance)
        nearest, when = known.argmin(axis=1), known.argmin(axis=0)
        for frame, own in enumerate(nearest.tolist()):
            for pair in sorted({own, *np.flatnonzero(when == frame).tolist()}):
                if known[frame, pair] < np.inf:
                    yield NearestPoints(frame, pair, self.points(frame, pair))

    def points(self, frame: int, pair: int) -> Floats:
        """Nearest points of a and b, world coordinates (2, 3) [mm]; twice the same of a touch."""
        rig = self.rigs[frame]
        assert rig is not None
        world = world_from_link(self.machine, self.positions[frame])
        both = zip(
            rig.scene.links[rig.columns.index(pair)], self.rows[frame, pair].tolist(), strict=True
        )
        a, b = (transform(world[link], rig.triangles[row]) for link, row in both)
        if self.distance[frame, pair] == 0.0:
            return np.tile(common_point(a, b), (2, 1))
        return nearest_points(a, b)


class Watch:
    """A machine on its path, to be looked at in single instants."""

    def __init__(self, machine: Machine, path: Path, device: str) -> None:
        self.machine, self.path, self.device = machine, path, device
        self.arrays = path_arrays(path, device)
        self.rigs: dict[tuple[bool, int], Rig | None] = {}

    def look(self, times_ps: Times) -> Look:
        """The distances at some times; a tool is there from its change on."""
        spans = tool_spans(self.path)
        span_at = np.searchsorted([s.start_ps for s in spans], times_ps, side="right") - 1
        rigs = [self._rig(spans[k].tool) for k in span_at.tolist()]
        distance = np.full((len(times_ps), len(self.machine.pairs)), np.nan)
        rows = np.zeros((*distance.shape, 2), np.int32)
        pieces, steps = self.path.piece_at(times_ps), 0
        for rig in {id(rig): rig for rig in rigs if rig}.values():
            chosen = np.array([k for k, other in enumerate(rigs) if other is rig])
            found = nearest_triangles(
                rig.scene, rig.forest, self.arrays, pieces[chosen], times_ps[chosen]
            )
            at = np.ix_(chosen, np.array(rig.columns))
            distance[at], rows[at] = found.distance, found.triangles
            steps += found.steps
        positions = self.path.positions(times_ps)
        return Look(self.machine, positions, distance, rows, rigs, steps)

    def _rig(self, tool: int | None) -> Rig | None:
        """The pairs that are there with a tool."""
        entry = table_entry(self.machine, tool)
        has_body = tool_body(self.machine, tool) is not None
        key = (True, entry.number) if entry else (False, int(has_body))
        if key not in self.rigs:
            bodies, pairs = bodies_in_place(self.machine, tool), self.machine.pairs
            columns = tuple(i for i, pair in enumerate(pairs) if is_present(pair, bodies))
            rig = None
            if columns:
                present = tuple(pairs[i] for i in columns)
                scene = build_scene(present, bodies, self.machine.joints, self.device)
                forest, _, _ = build_trees(scene)
                rig = Rig(scene, forest, columns, forest.triangles.numpy())
            self.rigs[key] = rig
        return self.rigs[key]


def distances(machine: Machine, path: Path, device: str, asked_ps: Times) -> Distances:
    """Distances at equal steps of time, fewer where a frame costs much, and at the times asked for.

    How many does not depend on the speed of the computer. Nothing is looked at where nothing moves.
    """
    if not len(path) or not machine.pairs:
        none = np.zeros((0, len(machine.pairs)))
        return Distances(np.zeros(0, np.int64), none, ())
    watch = Watch(machine, path, device)
    few = _equal_steps(0, path.duration_ps, FEWEST)
    each = watch.look(few).steps / len(few) + LINK_STEPS
    count = int(np.clip(WORK / each, FEWEST, FRAMES))
    times = np.unique(np.concatenate([_equal_steps(0, path.duration_ps, count), asked_ps]))
    look = watch.look(times)
    return Distances(times, look.distance, tuple(look.links()))


def nearest_moment(
    machine: Machine, path: Path, device: str, pair: tuple[str, str], begin_ps: int
) -> Separation:
    """The nearest that a pair is found to come at or after a time at which it is there.

    Looked for at equal steps of time, and again between the neighbours of the nearest: what is
    returned is true of its moment, but another may be nearer by what the pair moves within a step.
    """
    wanted = tuple(p for p in machine.pairs if (p.a, p.b) == pair)
    watch = Watch(replace(machine, pairs=wanted), path, device)
    low, high = begin_ps, path.duration_ps
    for _ in range(ROUNDS):
        times = _equal_steps(low, high, FRAMES)
        look = watch.look(times)
        best = int(np.nanargmin(look.distance[:, 0]))
        low, high = times[[max(best - 1, 0), min(best + 1, len(times) - 1)]].tolist()
    return Separation(int(times[best]), float(look.distance[best, 0]), look.points(best, 0))


def _equal_steps(low_ps: int, high_ps: int, count: int) -> Times:
    steps = np.linspace(0, high_ps - low_ps, count).astype(np.int64)
    return np.unique(low_ps + steps)
