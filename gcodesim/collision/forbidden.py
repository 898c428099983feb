"""Forbidden touches: of pairs that may touch in some pieces of the path, and in others not.

The flute may be in the part while it cuts; in a rapid, or while the spindle stands, it may not.
Only those pieces are searched, each with both its ends, by the method of the check: on the way that
is programmed, without the lag of drives or rounded corners.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from gcodesim.collision.baseline.exhaustive import exhaustive_test, first_sampled_contact
from gcodesim.collision.bounds.forest import build_forest
from gcodesim.collision.geometry.poses import PathArrays, path_arrays
from gcodesim.collision.instants.contact import touching_triangles
from gcodesim.collision.instants.containment import Containment, shell_vertices, winding_number
from gcodesim.collision.instants.touches import first_touch
from gcodesim.collision.instants.work import WorkCounts
from gcodesim.collision.search.approach import Approach, first_event
from gcodesim.collision.search.events import Contact, SpanContext
from gcodesim.collision.search.intervals import Interval, contact_intervals
from gcodesim.collision.search.search import Searcher, SearchSettings
from gcodesim.collision.search.search_kernel import MODE_AT_ALL_TIMES, MODE_AT_SAMPLES
from gcodesim.constants import TOLERANCE_MM
from gcodesim.machine.kinematics import world_from_link
from gcodesim.machine.model import Part
from gcodesim.motion.path import standing
from gcodesim.motion.samples import Instants, SomePieces, sample_of, window


@dataclass
class Touches:
    """What was found of forbidden touches in one span.

    Attributes:
        contacts: the first one, or all, in the order of time; those inside a body among them.
        intervals: with all, the stretches of time in which surfaces touch.
        undecided: containments that an open mesh leaves undecided.
        overflows: stretches of time that could not be decided.
    """

    contacts: list[Contact] = field(default_factory=list)
    intervals: list[tuple[Interval, Contact]] = field(default_factory=list)
    undecided: list[Containment] = field(default_factory=list)
    overflows: int = 0


@dataclass(frozen=True)
class TouchOrder:
    """How forbidden touches are looked for.

    Attributes:
        searches: by the search, else by looking at every sample.
        between: prove the time between samples too.
        stop_all: list all, not only the first.
        threads: launches side by side on the CPU, 0 for one per core.
    """

    searches: bool
    between: bool
    stop_all: bool
    threads: int


def forbidden_touches(
    context: SpanContext,
    arrays: PathArrays,
    wanted: NDArray[np.bool_],
    order: TouchOrder,
    work: WorkCounts,
) -> Touches:
    """Touches and containments of all pairs of a scene in some pieces of a span.

    The start of the span always counts: that is where its tool appears.

    Args:
        context: of the span.
        arrays: its path.
        wanted: per piece of the path, whether a touch counts there.
        order: how to look.
        work: counts what is done.
    """
    span, path = context.span, context.path
    first, end = np.searchsorted(path.bounds_ps, [span.start_ps, span.end_ps]).tolist()
    if first == end:
        # A tool that no move follows stands there all the same, its spindle too.
        path, first, end = standing(path, span.start_ps), 0, 1
        wanted = np.ones(1, np.bool_)
        context, arrays = replace(context, path=path), path_arrays(path, context.scene.device)
    stretches = SomePieces(path, wanted)
    runs = stretches.runs(first, end)
    found = Touches()
    looker = _Looker(context, arrays, stretches, order, work)
    if appearing := looker.appearing():
        found.contacts.append(appearing)
        if not order.stop_all:
            return found
    inside = looker.first_inside(runs, found)
    while first < end:
        contact = looker.first_touch(first, end)
        if inside and (contact is None or inside.sample < contact.sample):
            contact, inside = inside, None
        if contact is None:
            break
        found.contacts.append(contact)
        here = next((run for run in runs if contact.time_ps <= path.bounds_ps[run[1]]), None)
        if not order.stop_all or here is None:
            break
        found.intervals += looker.intervals(here)
        first = here[1]
    found.overflows = len(looker.searcher.undecided)
    return found


class _Looker:
    """Looks for the first touch, by the method of the check."""

    def __init__(
        self,
        context: SpanContext,
        arrays: PathArrays,
        stretches: SomePieces,
        order: TouchOrder,
        work: WorkCounts,
    ) -> None:
        self.context, self.arrays, self.stretches = context, arrays, stretches
        self.order, self.work = order, work
        scene = context.scene
        free = TOLERANCE_MM + context.path.deviation_mm if order.between else 0.0
        mode = MODE_AT_ALL_TIMES if order.between else MODE_AT_SAMPLES
        threads = order.threads or os.cpu_count() or 1
        settings = SearchSettings(context.period_ps, mode, (free,) * len(scene.pairs), threads)
        forest = build_forest(scene, context.travels)
        self.searcher = Searcher(
            scene, forest, context.path, arrays, context.travels, settings, stretches
        )

    def appearing(self) -> Contact | None:
        """A touch as the span begins: the tool is there then, whatever moves next."""
        context, start = self.context, np.array([self.context.span.start_ps])
        begin = Instants(start, context.path.piece_at(start), -(-start // context.period_ps))
        hit = first_touch(context.scene, self.arrays, begin, self.work)
        if hit is None:
            return None
        return context.touch(*hit, touching_triangles(context.scene, self.arrays, begin, hit[1]))

    def first_touch(self, first: int, end: int) -> Contact | None:
        """The first touch of surfaces in the pieces first..end."""
        context, bounds = self.context, self.context.path.bounds_ps
        if not self.order.searches:
            test = exhaustive_test(context.scene, self.arrays, self.work)
            span = replace(context.span, start_ps=int(bounds[first]), end_ps=int(bounds[end]))
            kept = self.stretches.kept
            hit = first_sampled_contact(
                context.path,
                span,
                context.period_ps,
                lambda instants: test(some) if len(some := kept(instants)) else None,
            )
            return None if hit is None else self._touch(hit, first)
        for start, stop in self.searcher.chunks(first, end):
            outcome, event = first_event(self.searcher, start, stop, int(bounds[end]))
            self.work.add(outcome.items, outcome.triangle_tests)
            if isinstance(event, Approach):
                return context.approach(event)
            if event:
                return self._touch(event, first)
        return None

    def _touch(self, hit: tuple[int, int], first: int) -> Contact:
        context = self.context
        start = int(context.path.bounds_ps[first])
        span = replace(context.span, start_ps=start)
        instants = self.stretches.kept(window(context.path, span, hit[0], 1, context.period_ps))
        found = touching_triangles(context.scene, self.arrays, instants, hit[1])
        return context.touch(*hit, found)

    def intervals(self, run: tuple[int, int]) -> Iterator[tuple[Interval, Contact]]:
        """Yield all contacts of surfaces in one run of pieces."""
        if not self.order.searches:
            return
        start, end = self.context.path.bounds_ps[list(run)].tolist()
        span = replace(self.context.span, start_ps=start, end_ps=end)
        for interval in contact_intervals(self.searcher, span):
            yield interval, self.context.interval(interval, self.arrays)

    def first_inside(self, runs: list[tuple[int, int]], found: Touches) -> Contact | None:
        """The first body wholly inside another as span or run begins: no surface shows it."""
        context, best = self.context, None
        begins = [int(context.path.bounds_ps[first]) for first, _ in runs]
        times = np.unique([context.span.start_ps, *begins])
        world = world_from_link(context.machine, context.path.positions(times))
        scene = context.scene
        for pair, ((a, b), sides) in enumerate(zip(scene.links, scene.shapes, strict=True)):
            pose = np.linalg.inv(world[a]) @ world[b]
            for p, q in product(sides[0].parts, sides[1].parts):
                for inner, outer, move in ((q, p, pose), (p, q, np.linalg.inv(pose))):
                    which = _first_within(inner, outer, np.asarray(move, np.float64))
                    if which is None:
                        continue
                    names, roles = (p.name, q.name), (p.role, q.role)
                    item = Containment(pair, names, roles, outer is p, outer.closed)
                    if not outer.closed:
                        found.undecided.append(item)
                        continue
                    contact = self._contained(item, int(times[which]))
                    best = contact if best is None or contact.sample < best.sample else best
        return best

    def _contained(self, item: Containment, time_ps: int) -> Contact:
        context = self.context
        sample = sample_of(time_ps, context.period_ps)
        appears = time_ps <= context.span.start_ps
        found = context.containment(item)
        if not appears:
            found = replace(found, sample=sample, time_ps=time_ps, appears=False)
        return context.with_depth(found, self.arrays) if self.order.stop_all else found


def _first_within(inner: Part, outer: Part, moves: NDArray[np.float64]) -> int | None:
    """Number of the first pose (m, 4, 4) at which a shell of one part lies inside another.

    Where the outer part is open: at which it may.
    """
    if outer.shell:
        return None
    low, high = outer.triangles.min(axis=(0, 1)), outer.triangles.max(axis=(0, 1))
    points = shell_vertices(inner.triangles)
    posed = np.einsum("mij,sj->msi", moves[:, :3, :3], points) + moves[:, None, :3, 3]
    near = np.all((posed > low) & (posed < high), axis=2)
    for which in np.flatnonzero(near.any(axis=1)).tolist():
        if not outer.closed:
            return int(which)
        if any(abs(winding_number(p, outer.triangles)) > 0.5 for p in posed[which][near[which]]):
            return int(which)
    return None
