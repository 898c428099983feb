"""One span of program time by the search: contacts, clearances, and what was left out."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from gcodesim.collision.bodies.keys import NO_CONTACT, contact_key
from gcodesim.collision.bounds.departure import Departures, departures
from gcodesim.collision.bounds.forest import build_forest
from gcodesim.collision.bounds.leave_out import (
    pairs_out_of_reach,
    swept_partners,
    without_far_triangles,
)
from gcodesim.collision.geometry.poses import PathArrays, path_arrays
from gcodesim.collision.instants.contact import touching_triangles
from gcodesim.collision.instants.touches import first_touch
from gcodesim.collision.instants.work import WorkCounts
from gcodesim.collision.search.approach import Approach, first_event
from gcodesim.collision.search.clearance import (
    Nearness,
    every_place,
    nearest_of_all,
    nearest_pair,
    too_near,
)
from gcodesim.collision.search.events import Contact, SpanContext
from gcodesim.collision.search.first_reach import LEFT_OUT
from gcodesim.collision.search.intervals import Interval, contact_intervals
from gcodesim.collision.search.search import Searcher, SearchSettings
from gcodesim.collision.search.search_kernel import MODE_AT_ALL_TIMES, MODE_AT_SAMPLES
from gcodesim.constants import CLEARANCE_SLACK_MM, TOLERANCE_MM
from gcodesim.findings.left_out import LeftOut
from gcodesim.machine.model import Pair
from gcodesim.motion.off_path import OffPath
from gcodesim.motion.path import standing
from gcodesim.motion.samples import Instants, sample_count, sample_of, window


@dataclass(frozen=True)
class Aims:
    """What a search is asked for.

    Attributes:
        between: prove the time between samples too.
        clearance: replaces the clearance of every pair [mm]; None = as the machine file says.
        minimum: find the smallest distance of every pair.
        nearest: find the pair that comes nearest, and its distance.
        stop_all: list every contact instead of stopping at the first.
        leave_out: leave out what the program cannot need.
        off_path: how far the machine may be from the path; widens every clearance.
        threads: launches side by side on the CPU, 0 for one per core.
    """

    between: bool = True
    clearance: float | None = None
    minimum: bool = False
    nearest: bool = False
    stop_all: bool = False
    leave_out: bool = True
    off_path: OffPath = field(default_factory=OffPath)
    threads: int = 0

    def clearance_of(self, pair: Pair) -> float:
        """Clearance that a pair must not fall below [mm]."""
        asked = pair.clearance if self.clearance is None else self.clearance
        return max(asked - CLEARANCE_SLACK_MM, 0.0)


@dataclass
class SpanFindings:
    """What the search of one span found besides the first contact.

    Attributes:
        too_near: pairs nearer than their clearance: where they first are, or every place.
        minimums: smallest distances asked for.
        intervals: all contacts, with --stop all.
        left_out: pairs left out.
        overflows: stretches of time that could not be decided; never an answer.
    """

    too_near: list[tuple[Pair, Nearness]] = field(default_factory=list)
    minimums: list[tuple[Pair, Nearness]] = field(default_factory=list)
    intervals: list[tuple[Interval, Contact]] = field(default_factory=list)
    left_out: list[LeftOut] = field(default_factory=list)
    overflows: int = 0


def search_span(
    context: SpanContext,
    arrays: PathArrays,
    aims: Aims,
    work: WorkCounts,
    progress: Callable[[float], None],
    known: int | None = None,
) -> tuple[Contact | None, SpanFindings]:
    """Search one span: its first contact, and what else was asked for.

    Args:
        context: of the span.
        arrays: the path.
        aims: what is asked for.
        work: counts what is done.
        progress: called with the fraction of program time done.
        known: sample of a contact found otherwise: clearances count up to it.
    """
    findings = SpanFindings()
    context, free, departing = _leave_out(context, aims, findings)
    span, path = context.span, context.path
    begin = Instants(
        np.array([span.start_ps]),
        path.piece_at(np.array([span.start_ps])),
        np.array([sample_of(span.start_ps, context.period_ps)]),
    )
    hit = first_touch(context.scene, arrays, begin, work)
    contact = None
    if hit:
        contact = context.touch(*hit, touching_triangles(context.scene, arrays, begin, hit[1]))
        if not aims.stop_all:
            return contact, findings
    first, end = np.searchsorted(path.bounds_ps, [span.start_ps, span.end_ps]).tolist()
    if first == end:
        # A tool that no move follows is there all the same, and the drives may still lag.
        path, first, end = standing(path, span.start_ps), 0, 1
        context, arrays = replace(context, path=path), path_arrays(path, context.scene.device)
    searcher = _searcher(context, arrays, aims, free)
    if contact is None:
        contact = _first_contact(context, searcher, (first, end), work, findings, progress)
    best = NO_CONTACT
    if contact is not None:
        pair = context.scene.pairs.index(contact.pair)
        best = contact_key(contact.sample, pair)
    if known is not None:
        best = min(best, contact_key(known, 0))
    if aims.stop_all and contact is not None:
        findings.intervals = [
            (interval, context.interval(interval, searcher.arrays))
            for interval in contact_intervals(searcher, span)
        ]
    _look_at_clearances(context, searcher, aims, (first, end, best), departing, findings)
    findings.overflows = len(searcher.undecided)
    return contact, findings


def _leave_out(
    context: SpanContext, aims: Aims, findings: SpanFindings
) -> tuple[SpanContext, tuple[float, ...], Departures]:
    """The context without what cannot matter.

    With it, per pair what a proof must leave [mm], and how far the pair may be off its path.
    """
    scene, travels = context.scene, context.travels
    tolerance = TOLERANCE_MM + context.path.deviation_mm if aims.between else 0.0
    free = [tolerance] * len(scene.pairs)
    departing = departures(scene, travels, aims.off_path)
    # What a pair must keep, it must keep of the true way too; the proof of no contact has its own.
    asked = np.array([aims.clearance_of(pair) for pair in scene.pairs]) + departing.largest
    departing = departing.widened(np.where(asked > 0.0, context.path.deviation_mm, 0.0))
    if not aims.leave_out:
        return context, tuple(free), departing
    needed = [
        max(tolerance, aims.clearance_of(pair) + off)
        for pair, off in zip(scene.pairs, departing.largest.tolist(), strict=True)
    ]
    samples = sample_count(context.path, context.period_ps)
    swept = swept_partners(scene, travels)
    apart = pairs_out_of_reach(scene, travels, swept, needed, samples)
    findings.left_out = list(apart.values())
    for pair in apart:
        free[pair] = LEFT_OUT
    if not (aims.minimum or aims.nearest):
        # The smallest distance may lie between triangles that no proof of freedom needs.
        scene, dropped = without_far_triangles(scene, travels, swept, needed, apart)
        findings.left_out += dropped
    return replace(context, scene=scene), tuple(free), departing


def _searcher(
    context: SpanContext, arrays: PathArrays, aims: Aims, free: tuple[float, ...]
) -> Searcher:
    mode = MODE_AT_ALL_TIMES if aims.between else MODE_AT_SAMPLES
    threads = aims.threads or os.cpu_count() or 1
    settings = SearchSettings(context.period_ps, mode, free, threads)
    forest = build_forest(context.scene, context.travels)
    return Searcher(context.scene, forest, context.path, arrays, context.travels, settings)


def _first_contact(
    context: SpanContext,
    searcher: Searcher,
    pieces: tuple[int, int],
    work: WorkCounts,
    findings: SpanFindings,
    progress: Callable[[float], None],
) -> Contact | None:
    path, span = context.path, context.span
    for first, end in searcher.chunks(*pieces):
        outcome, event = first_event(searcher, first, end, span.end_ps)
        work.add(outcome.items, outcome.triangle_tests)
        if isinstance(event, Approach):
            return context.approach(event)
        if event:
            instants = window(path, span, event[0], 1, context.period_ps)
            touching = touching_triangles(context.scene, searcher.arrays, instants, event[1])
            return context.touch(*event, touching)
        progress(int(path.bounds_ps[end]) / path.duration_ps)
    return None


def _look_at_clearances(
    context: SpanContext,
    searcher: Searcher,
    aims: Aims,
    stretch: tuple[int, int, int],
    departing: Departures,
    findings: SpanFindings,
) -> None:
    """Clearances that are not kept, and the smallest distances if asked for."""
    first, end, best = stretch
    pairs = context.scene.pairs
    asked = tuple(
        aims.clearance_of(pair) if free >= 0.0 else LEFT_OUT
        for pair, free in zip(pairs, searcher.settings.free_mm, strict=True)
    )
    if aims.stop_all:
        contacts = [interval for interval, _ in findings.intervals]
        near_places = every_place(searcher, asked, departing, (first, end), contacts)
    else:
        near_places = too_near(searcher, asked, departing, first, end, best)
    findings.too_near = [(pairs[near.pair], near) for near in near_places]
    nearest: list[Nearness] = []
    if aims.minimum:
        nearest = nearest_of_all(searcher, first, end, best)
    elif aims.nearest:
        nearest = [nearest_pair(searcher, first, end, best)]
    # Nothing is measured after a contact at the start: its pair and the others have no distance.
    findings.minimums = [(pairs[n.pair], n) for n in nearest if np.isfinite(n.distance)]
