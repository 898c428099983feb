"""The ways to find a first contact that the accuracy study compares, on one scene each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from gcodesim.collision.baseline.exhaustive import WINDOW
from gcodesim.collision.baseline.paper import first_contact_paper, prepare_paper
from gcodesim.collision.bodies.keys import NO_CONTACT
from gcodesim.collision.bounds.motion_bounds import travelled
from gcodesim.collision.instants.touches import first_touch
from gcodesim.collision.instants.work import WorkCounts
from gcodesim.collision.search.search import SearchSettings
from gcodesim.collision.search.search_kernel import MODE_APPROACH, MODE_AT_SAMPLES
from gcodesim.constants import DEFAULT_PERIOD_PS
from gcodesim.machine.kinematics import world_from_link
from gcodesim.motion.samples import Instants, Span, window, windows
from gcodesim.study.advancing import advance
from gcodesim.study.job import StudyJob, search_job
from gcodesim.study.kernels.textbook import first_naive_contact
from gcodesim.study.scenes import KnownScene

RESOLUTION_PS = 1
"""The search between samples tells the first near instant to this [ps]."""

NAIVE_INSTANTS = 2048
"""Samples per launch of the naive methods: their poses are held in memory."""


@dataclass(frozen=True)
class Found:
    """What one run found, and its machine-independent work.

    Attributes:
        time_ps: first contact, None when all is free.
        counts: poses, box tests (of the search: items, a gap of two nodes each), triangle tests.
    """

    time_ps: int | None
    counts: NDArray[np.int64]


class Subject:
    """A scene laid out for every method, so that a run is the search alone.

    Attributes:
        scene: with its true first contact.
        searcher: the search of its path, one thread.
        prepared: what the paper's method lays out beforehand.
    """

    def __init__(self, scene: KnownScene) -> None:
        self.scene = scene
        job = StudyJob(scene.machine, scene.path, None, DEFAULT_PERIOD_PS)
        self.searcher = job.searcher(job.scene("cpu"), threads=1, between=False)
        joints = travelled(scene.machine.joints, scene.path)
        self.prepared = prepare_paper(self.searcher.scene, joints)

    @property
    def span(self) -> Span:
        """The whole path."""
        return Span(0, self.scene.path.duration_ps, None, 0)

    def triangles(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Triangles of the two bodies, each in the frame of its link."""
        a, b = self.searcher.scene.shapes[0]
        return a.regions.triangles, b.regions.triangles

    def poses(self, instants: Instants) -> NDArray[np.float64]:
        """Pose of the second body in the frame of the first, (instants, 4, 4)."""
        a, b = self.searcher.scene.links[0]
        world = world_from_link(self.scene.machine, self.scene.path.positions(instants.time_ps))
        return np.asarray(np.linalg.inv(world[a]) @ world[b])


Method = Callable[[Subject, float], Found]


def _every_sample(
    look: Callable[[Subject, Instants, WorkCounts], int | None],
    count: int,
    subject: Subject,
    period_ps: float,
) -> Found:
    """Look at all instants in the order of time, window by window."""
    path, work, period = subject.scene.path, WorkCounts(), round(period_ps)
    for first in windows(path, subject.span, count, period):
        sample = look(subject, window(path, subject.span, first, count, period), work)
        if sample is not None:
            return Found(sample * period, work.counts)
    return Found(None, work.counts)


def _look_exhaustively(subject: Subject, instants: Instants, work: WorkCounts) -> int | None:
    hit = first_touch(subject.searcher.scene, subject.searcher.arrays, instants, work)
    return hit[0] if hit else None


def _look_as_the_paper(subject: Subject, instants: Instants, work: WorkCounts) -> int | None:
    searcher = subject.searcher
    hit = first_contact_paper(searcher.scene, subject.prepared, searcher.arrays, instants, work)
    return hit[0] if hit else None


def _look_naively(
    precision: str, subject: Subject, instants: Instants, work: WorkCounts
) -> int | None:
    poses = subject.poses(instants)
    row = first_naive_contact(subject.triangles(), poses, precision, work.counts)
    return None if row is None else int(instants.sample[row])


def search_samples(subject: Subject, period_ps: float) -> Found:
    """The search, asked for samples only."""
    settings = SearchSettings(round(period_ps), MODE_AT_SAMPLES, (0.0,), 1)
    answer = search_job(replace(subject.searcher, settings=settings))
    work = WorkCounts()
    work.add(answer.items, answer.triangle_tests)
    time_ps = None if answer.sample is None else answer.sample * round(period_ps)
    return Found(time_ps, work.counts)


def search_between(subject: Subject, tolerance_mm: float) -> Found:
    """The search, asked for the first instant at which the distance falls to the tolerance."""
    settings = SearchSettings(RESOLUTION_PS, MODE_APPROACH, (tolerance_mm,), 1)
    searcher = replace(subject.searcher, settings=settings)
    outcome = searcher.search_pieces(0, len(subject.scene.path))
    work, near = WorkCounts(), int(outcome.near[0])
    work.add(outcome.items, outcome.triangle_tests)
    return Found(None if near == NO_CONTACT else near, work.counts)


def advance_directed(subject: Subject, tolerance_mm: float) -> Found:
    """From pose to pose by the directed bound."""
    work = WorkCounts()
    return Found(advance(subject.scene, tolerance_mm, work), work.counts)


PERIOD, TOLERANCE = "period [ms]", "tolerance [mm]"

METHODS: dict[str, tuple[str, Method]] = {
    "naive float32": (
        PERIOD,
        partial(_every_sample, partial(_look_naively, "float32"), NAIVE_INSTANTS),
    ),
    "naive float64": (
        PERIOD,
        partial(_every_sample, partial(_look_naively, "float64"), NAIVE_INSTANTS),
    ),
    "paper": (PERIOD, partial(_every_sample, _look_as_the_paper, WINDOW)),
    "exhaustive": (PERIOD, partial(_every_sample, _look_exhaustively, WINDOW)),
    "search": (PERIOD, search_samples),
    "search between": (TOLERANCE, search_between),
    "directed bound": (TOLERANCE, advance_directed),
}
"""Name of each method -> what its knob is, and the method. Periods are passed in ps."""
