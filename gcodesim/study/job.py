"""A job to measure: the longest stretch of a program with one tool, as long as is asked for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gcodesim.collision.baseline.exhaustive import exhaustive_test, first_sampled_contact
from gcodesim.collision.bodies.scene import Scene, build_scene
from gcodesim.collision.bounds.forest import Forest, build_forest
from gcodesim.collision.bounds.motion_bounds import travelled
from gcodesim.collision.geometry.poses import path_arrays
from gcodesim.collision.instants.work import WorkCounts
from gcodesim.collision.search.approach import Approach, distances_at, first_event
from gcodesim.collision.search.search import Outcome, Roots, Searcher, SearchSettings
from gcodesim.collision.search.search_kernel import MODE_AT_ALL_TIMES, MODE_AT_SAMPLES
from gcodesim.constants import PS_PER_S, TOLERANCE_MM
from gcodesim.errors import UsageError
from gcodesim.machine.model import Machine
from gcodesim.machine.spindle import bodies_in_place
from gcodesim.motion.path import CONSTANT_SPEED, Path
from gcodesim.motion.samples import Span, sample_count, tool_spans

WINDOW_PS = PS_PER_S // 1000
"""Machine time of a window of the real-time question [ps]: 1 ms."""


@dataclass(frozen=True)
class StudyJob:
    """A path with one tool in the spindle, on one machine.

    Attributes:
        machine: with the bodies and pairs.
        path: without tool changes.
        tool: number of the tool, None = the one mounted at the start.
        period_ps: sample period [ps].
    """

    machine: Machine
    path: Path
    tool: int | None
    period_ps: int

    @property
    def samples(self) -> int:
        """Sample indices of the path."""
        return sample_count(self.path, self.period_ps)

    @property
    def length_mm(self) -> float:
        """Length of the motion of X, Y and Z, arcs included [mm]."""
        path = self.path
        columns = [column for column in path.xyz if column >= 0]
        moved = np.linalg.norm(path.q1[:, columns] - path.q0[:, columns], axis=1)
        on_arc = path.arc >= 0
        arcs = path.arcs[path.arc[on_arc]]
        along = np.radians(arcs["sweep"]) * (arcs["r0"] + arcs["r1"]) / 2.0
        climb = np.linalg.norm(arcs["lift"], axis=1)
        moved[on_arc] = np.hypot(np.hypot(along, arcs["r1"] - arcs["r0"]), climb)
        return float(moved.sum())

    def scene(self, device: str) -> Scene:
        """The pairs whose bodies are in place while this tool is in the spindle."""
        bodies = bodies_in_place(self.machine, self.tool)
        pairs = tuple(p for p in self.machine.pairs if p.a in bodies and p.b in bodies)
        return build_scene(pairs, bodies, self.machine.joints, device)

    def forest(self, scene: Scene) -> Forest:
        """Trees and levers of a scene for this path."""
        return build_forest(scene, travelled(self.machine.joints, self.path))

    def searcher(self, scene: Scene, threads: int, between: bool = True) -> Searcher:
        """The search of this path, all pairs, nothing left out."""
        arrays = path_arrays(self.path, scene.device)
        mode = MODE_AT_ALL_TIMES if between else MODE_AT_SAMPLES
        free = (TOLERANCE_MM if between else 0.0,) * len(scene.pairs)
        settings = SearchSettings(self.period_ps, mode, free, threads)
        joints = self.machine.joints
        return Searcher(scene, self.forest(scene), self.path, arrays, joints, settings)


def longest_job(path: Path, machine: Machine, period_ps: int) -> StudyJob:
    """The longest stretch of a path with one tool.

    Raises:
        UsageError: nothing moves.
    """
    if not len(path):
        raise UsageError("the program moves no axis: there is nothing to measure")
    span = max(tool_spans(path), key=lambda s: s.end_ps - s.start_ps)
    first, end = np.searchsorted(path.bounds_ps, [span.start_ps, span.end_ps])
    return StudyJob(machine, _cut(path, int(first), int(end)), span.tool, period_ps)


def _cut(path: Path, first: int, end: int) -> Path:
    """Pieces first..end of a path, without tool changes, time from zero."""
    return _taken(path, np.arange(first, end), np.diff(path.bounds_ps)[first:end])


def _taken(path: Path, pieces: NDArray[np.intp], ticks: NDArray[np.int64]) -> Path:
    """The given pieces one after the other, piece i lasting ticks[i] [ps]."""
    return replace(
        path,
        bounds_ps=np.concatenate([np.zeros(1, np.int64), np.cumsum(ticks)]),
        q0=path.q0[pieces],
        q1=path.q1[pieces],
        law=path.law[pieces],
        arc=path.arc[pieces],
        line=path.line[pieces],
        tool_changes=(),
    )


def repeated(job: StudyJob, seconds: float) -> StudyJob:
    """The same motion again and again until it lasts `seconds` at least.

    Where the end is not the start, a rapid move back to it stands between the rounds.
    """
    path = job.path
    rounds = max(1, int(np.ceil(seconds * PS_PER_S / path.duration_ps)))
    if rounds > 1 and not np.array_equal(path.q0[0], path.q1[-1]):
        path = _with_return(path, job.machine)
    pieces = np.tile(np.arange(len(path)), rounds)
    return replace(job, path=_taken(path, pieces, np.tile(np.diff(path.bounds_ps), rounds)))


def _with_return(path: Path, machine: Machine) -> Path:
    rates = np.array([joint.rapid for joint in machine.joints])
    seconds = float(np.max(np.abs(path.q0[0] - path.q1[-1]) / rates))
    ticks = max(1, round(seconds * PS_PER_S))
    return replace(
        path,
        bounds_ps=np.append(path.bounds_ps, path.duration_ps + ticks),
        q0=np.vstack([path.q0, path.q1[-1:]]),
        q1=np.vstack([path.q1, path.q0[:1]]),
        law=np.vstack([path.law, [CONSTANT_SPEED]]),
        arc=np.append(path.arc, np.int32(-1)),
        line=np.append(path.line, path.line[-1]),
    )


@dataclass(frozen=True)
class Answer:
    """What a search of a whole job found.

    Attributes:
        sample, pair: first contact, None when all is free.
        items: stretches looked at.
        triangle_tests: exact tests.
        end_ps: how far the search went [ps].
    """

    sample: int | None
    pair: str | None
    items: int
    triangle_tests: int
    end_ps: int


def search_job(searcher: Searcher) -> Answer:
    """Search a whole job as a check does, up to its first contact."""
    path, pairs = searcher.path, searcher.scene.pairs
    total = Outcome.nothing(len(pairs))
    for first, end in searcher.chunks(0, len(path)):
        outcome, event = first_event(searcher, first, end, path.duration_ps)
        total.merge(outcome)
        if isinstance(event, Approach):
            sample = -(-event.start_ps // searcher.settings.period_ps)
            pair = pairs[event.nearest.pair].name
            return Answer(sample, pair, total.items, total.triangle_tests, event.start_ps)
        if event:
            time_ps = min(event[0] * searcher.settings.period_ps, path.duration_ps)
            pair = pairs[event[1]].name
            return Answer(event[0], pair, total.items, total.triangle_tests, time_ps)
    return Answer(None, None, total.items, total.triangle_tests, path.duration_ps)


def exhaustive_job(searcher: Searcher) -> Answer:
    """Look at every sample and block end of a whole job, up to its first contact."""
    path, period_ps = searcher.path, searcher.settings.period_ps
    span, work = Span(0, path.duration_ps, None, 0), WorkCounts()
    test = exhaustive_test(searcher.scene, searcher.arrays, work)
    hit = first_sampled_contact(path, span, period_ps, test)
    if hit is None:
        return Answer(None, None, 0, int(work.counts[2]), path.duration_ps)
    end_ps = min(hit[0] * period_ps, path.duration_ps)
    return Answer(hit[0], searcher.scene.pairs[hit[1]].name, 0, int(work.counts[2]), end_ps)


def window_search(searcher: Searcher, number: int) -> Callable[[], Outcome]:
    """The search of one window of 1 ms, all pairs, ready to be timed.

    Motion tables and the first contact bound are warm, as in a control that looks ahead.
    """
    path = searcher.path
    start = number * WINDOW_PS
    end = min(start + WINDOW_PS, path.duration_ps)
    inside = path.bounds_ps[(path.bounds_ps > start) & (path.bounds_ps < end)]
    times = np.concatenate([[start], inside, [end]])
    pieces = path.piece_at(times[1:])
    roots = Roots(pieces, np.full(len(pieces), -1, np.int32), times[:-1], times[1:])
    motion = searcher.motion(int(pieces[0]), int(pieces[-1]) + 1)
    nothing = Outcome.nothing(len(searcher.scene.pairs))
    return lambda: searcher.launch(roots, motion, nothing.best, nothing.distance)


def clearances_at(searcher: Searcher, times_ps: NDArray[np.int64]) -> NDArray[np.float64]:
    """Smallest distance of each pair at some instants, shape (pairs, instants) [mm]."""
    pairs = range(len(searcher.scene.pairs))
    return np.array([distances_at(searcher, pair, times_ps) for pair in pairs])
