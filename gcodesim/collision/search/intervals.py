"""Contact intervals: every stretch of time in which a pair touches, for --stop all."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import warp as wp
from numpy.typing import NDArray

from gcodesim.collision.bodies.keys import NO_CONTACT
from gcodesim.collision.bodies.scene import SceneArrays
from gcodesim.collision.geometry.boxes import inverse
from gcodesim.collision.geometry.closest import nearest_on_triangle
from gcodesim.collision.geometry.device import BIT_EQUAL
from gcodesim.collision.geometry.poses import ChainArrays, PathArrays, pair_pose
from gcodesim.collision.search.approach import Approach, event_of
from gcodesim.collision.search.lasting import touches_at
from gcodesim.collision.search.search import Roots, Searcher
from gcodesim.constants import PS_PER_S
from gcodesim.motion.samples import Instants, Span, window, windows

wp.set_module_options(BIT_EQUAL)

MERGED_PS = PS_PER_S // 20
"""Contacts of one pair with less than 50 ms between them are one: people act on one place."""

FIRST_WINDOW, LAST_WINDOW = 4_096, 262_144
"""Samples looked at together while a contact lasts: at first, and at most."""

DEPTH_INSTANTS = 9
"""Instants of an interval at which the depth is measured."""

HALF_SPHERE = wp.constant(wp.float64(2.0 * np.pi))
"""Half the solid angle of a sphere: what the triangles all around a point add up to here."""


@dataclass(frozen=True)
class Interval:
    """A stretch of time in which a pair touches.

    Attributes:
        pair: index in the scene.
        start_ps, end_ps: first and last instant in contact.
        deepest: largest distance of a vertex inside the other body from its surface [mm].
        deepest_ps: when.
        between: it lies between two samples.
    """

    pair: int
    start_ps: int
    end_ps: int
    deepest: float = 0.0
    deepest_ps: int = 0
    between: bool = False


@wp.kernel
def measure_depths(
    path: PathArrays,
    chains: ChainArrays,
    place: wp.vec3i,  # pair, piece, 1 when the points belong to body a
    time_ps: wp.int64,
    points: wp.array[wp.vec3d],
    triangles: wp.array[wp.mat33d],
    depth_out: wp.array[wp.float64],
):
    """One thread per vertex: its distance from the other body's surface where it lies inside."""
    i = wp.tid()
    pose = pair_pose(path, chains, place[0], place[1], time_ps)
    if place[2] == 1:
        pose = inverse(pose)
    p = pose.R * points[i] + pose.t
    nearest = wp.float64(1.0e30)
    winding = wp.float64(0.0)
    for j in range(triangles.shape[0]):
        t = triangles[j]
        a = t[0] - p
        b = t[1] - p
        c = t[2] - p
        v = nearest_on_triangle(a, b, c)
        nearest = wp.min(nearest, wp.dot(v, v))
        la = wp.length(a)
        lb = wp.length(b)
        lc = wp.length(c)
        below = la * lb * lc + wp.dot(a, b) * lc + wp.dot(b, c) * la + wp.dot(c, a) * lb
        winding += wp.atan2(wp.dot(a, wp.cross(b, c)), below)
    if wp.abs(winding) > wp.float64(0.5) * HALF_SPHERE:
        depth_out[i] = wp.sqrt(nearest)


def contact_intervals(searcher: Searcher, span: Span) -> list[Interval]:
    """All contact intervals of all pairs within a span, in the order of time."""
    found: list[Interval] = []
    for pair in range(len(searcher.scene.pairs)):
        if searcher.settings.free_mm[pair] >= 0.0:
            merged: list[Interval] = []
            for interval in _intervals_of(_only(searcher, pair), span, pair):
                if merged and interval.start_ps - merged[-1].end_ps < MERGED_PS:
                    merged[-1] = replace(
                        merged[-1],
                        end_ps=interval.end_ps,
                        between=merged[-1].between and interval.between,
                    )
                else:
                    merged.append(interval)
            found += [_with_depth(searcher, interval) for interval in merged]
    return sorted(found, key=lambda i: (i.start_ps, i.pair))


def _only(searcher: Searcher, pair: int) -> Searcher:
    free = tuple(f if i == pair else -1.0 for i, f in enumerate(searcher.settings.free_mm))
    return replace(searcher, settings=replace(searcher.settings, free_mm=free))


def _intervals_of(searcher: Searcher, span: Span, pair: int) -> Iterator[Interval]:
    time: int | None = span.start_ps
    while time is not None and time < span.end_ps:
        event = _event_after(searcher, span, pair, time)
        if event is None:
            return
        if isinstance(event, Approach):
            yield Interval(pair, event.start_ps, event.end_ps, between=True)
            time = event.end_ps
            continue
        start, end, time = _lasting(searcher, span, pair, event[0])
        yield Interval(pair, start, end)


def _event_after(
    searcher: Searcher, span: Span, pair: int, time_ps: int
) -> tuple[int, int] | Approach | None:
    """The pair's first event after a free instant: the rest of its piece, then whole pieces."""
    path = searcher.path
    piece = int(path.piece_at(np.array([time_ps + 1]))[0])
    stop = int(path.bounds_ps[piece + 1])
    end = int(np.searchsorted(path.bounds_ps, span.end_ps))
    rest = Roots(*(np.array([v]) for v in (piece, -1, time_ps, stop)))
    outcome = searcher.search_stretches(rest, pair)
    near = np.full(len(searcher.scene.pairs), outcome.near.max())
    near[np.arange(len(near)) != pair] = NO_CONTACT
    event = event_of(searcher, replace(outcome, near=near), span.end_ps)
    for first, last in searcher.chunks(piece + 1, end):
        if event is not None:
            break
        event = event_of(searcher, searcher.search_pieces(first, last), span.end_ps)
    return event


def _lasting(searcher: Searcher, span: Span, pair: int, sample: int) -> tuple[int, int, int | None]:
    """First and last instant in contact from a sample on, and the free instant that follows."""
    start = end = -1
    period = searcher.settings.period_ps
    rest = replace(span, start_ps=max(span.start_ps, (sample - 1) * period + 1))
    for instants in _growing(searcher, rest):
        touches = touches_at(searcher, instants, pair)
        if start < 0:
            begin = int(np.argmax(touches))
            start = end = int(instants.time_ps[begin])
            touches[:begin] = True
        free = np.flatnonzero(~touches)
        if len(free):
            end = int(instants.time_ps[free[0] - 1]) if free[0] else end
            return start, end, int(instants.time_ps[free[0]])
        end = int(instants.time_ps[-1])
    return start, end, None


def _growing(searcher: Searcher, span: Span) -> Iterator[Instants]:
    """Yield the instants of a span in windows that grow; a long dwell is passed over."""
    path, period = searcher.path, searcher.settings.period_ps
    count, start = FIRST_WINDOW, span.start_ps
    while start <= span.end_ps:
        for first in windows(path, replace(span, start_ps=start), count, period):
            instants = window(path, replace(span, start_ps=start), first, count, period)
            start = (first + count - 1) * period + 1
            if len(instants):
                yield instants
            break
        else:
            return
        count = min(2 * count, LAST_WINDOW)


def _with_depth(searcher: Searcher, interval: Interval) -> Interval:
    times = np.unique(np.linspace(interval.start_ps, interval.end_ps, DEPTH_INSTANTS)).astype(int)
    depths = [_depth(searcher, interval.pair, int(time)) for time in times]
    deepest = int(np.argmax(depths))
    return replace(interval, deepest=depths[deepest], deepest_ps=int(times[deepest]))


def _depth(searcher: Searcher, pair: int, time_ps: int) -> float:
    """Largest depth of a vertex of either body inside the other [mm]."""
    scene = searcher.scene
    # Inside and outside need the whole closed bodies, whatever was left out of the search.
    shapes = [np.concatenate([p.triangles for p in s.parts]) for s in scene.shapes[pair]]
    piece = int(searcher.path.piece_at(np.array([time_ps]))[0])
    deepest = 0.0
    for own, other, of_a in ((shapes[1], shapes[0], 0), (shapes[0], shapes[1], 1)):
        points = np.unique(own.reshape(-1, 3), axis=0)
        depths = wp.zeros(len(points), dtype=wp.float64, device=scene.device)
        wp.launch(
            measure_depths,
            dim=len(points),
            inputs=[
                searcher.arrays,
                scene.chains,
                wp.vec3i(pair, piece, of_a),
                time_ps,
                wp.array(points, dtype=wp.vec3d, device=scene.device),
                wp.array(other, dtype=wp.mat33d, device=scene.device),
            ],
            outputs=[depths],
            device=scene.device,
        )
        deepest = max(deepest, float(depths.numpy().max()))
    return deepest
