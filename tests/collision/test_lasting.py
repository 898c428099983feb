"""Lasting contacts and depths equal what is found at every instant by itself."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from collision.random_programs import random_trial
from numpy.typing import NDArray

from gcodesim.collision.bodies.scene import build_scene
from gcodesim.collision.bounds.forest import build_forest
from gcodesim.collision.bounds.motion_bounds import travelled
from gcodesim.collision.geometry.poses import path_arrays
from gcodesim.collision.instants.containment import winding_number
from gcodesim.collision.instants.nearest_triangles import nearest_triangles
from gcodesim.collision.search.depths import GOOD_TO_MM, DepthGauge
from gcodesim.collision.search.lasting import touches_at
from gcodesim.collision.search.search import Searcher, SearchSettings
from gcodesim.collision.search.search_kernel import MODE_AT_SAMPLES
from gcodesim.machine.kinematics import world_from_link
from gcodesim.machine.model import Machine
from gcodesim.machine.spindle import bodies_in_place
from gcodesim.motion.samples import Instants, Span, tool_spans, window

Array = NDArray[np.float64]

MOST = 3000
"""Instants looked at of one program."""

EDGE_POINTS, EDGE_STEP_MM = 9, 4.0
"""Points looked at of every edge, and half of what may lie between two of them."""


def deep_searcher(seed: int) -> tuple[Searcher, Span, Machine]:
    """A searcher of a random program whose tool stands in the work."""
    trial = random_trial(seed, away=0.0)
    m, path = trial.machine, trial.path
    span = tool_spans(path)[-1]
    scene = build_scene(m.pairs, bodies_in_place(m, span.tool), m.joints, "cpu")
    joints = travelled(m.joints, path)
    free = (0.0,) * len(m.pairs)
    settings = SearchSettings(trial.period_ps, MODE_AT_SAMPLES, free, threads=2)
    forest = build_forest(scene, joints)
    return Searcher(scene, forest, path, path_arrays(path, "cpu"), joints, settings), span, m


def some_instants(searcher: Searcher, span: Span) -> Instants:
    period = searcher.settings.period_ps
    count = min(MOST, (span.end_ps - span.start_ps) // period)
    return window(searcher.path, span, -(-span.start_ps // period), count, period)


@pytest.mark.parametrize("seed", range(16))
def test_touches_are_those_of_every_instant_by_itself(seed: int) -> None:
    searcher, span, _ = deep_searcher(seed)
    instants = some_instants(searcher, span)
    alone = nearest_triangles(
        searcher.scene, searcher.forest.arrays, searcher.arrays, instants.piece, instants.time_ps
    ).distance
    for pair in range(len(searcher.scene.pairs)):
        found = touches_at(searcher, instants, pair)
        assert found.tolist() == (alone[:, pair] == 0.0).tolist()


def test_the_random_programs_touch_and_part() -> None:
    counts = np.zeros(2, int)
    for seed in range(16):
        searcher, span, _ = deep_searcher(seed)
        found = touches_at(searcher, some_instants(searcher, span), 0)
        counts += [np.count_nonzero(found), np.count_nonzero(~found)]
    assert counts.min() > 1000


def depths_alone(searcher: Searcher, m: Machine, time_ps: int) -> tuple[float, float]:
    """Depth of the deepest vertex of either body, and of the deepest point of an edge."""
    q = searcher.path.positions(np.array([time_ps]))[0]
    world, at_vertex, on_edge = world_from_link(m, q), 0.0, 0.0
    sides = [
        np.concatenate([p.triangles for p in shape.parts]) @ world[link][:3, :3].T
        + world[link][:3, 3]
        for shape, link in zip(searcher.scene.shapes[0], searcher.scene.links[0], strict=True)
    ]
    for own, other in (sides, sides[::-1]):
        at_vertex = max(at_vertex, deepest(np.unique(own.reshape(-1, 3), axis=0), other))
        ends = np.concatenate([own[:, [0, 1]], own[:, [1, 2]], own[:, [2, 0]]])
        shares = np.linspace(0.0, 1.0, EDGE_POINTS)[:, None]
        points = ends[:, None, 0] + shares * (ends[:, 1] - ends[:, 0])[:, None]
        on_edge = max(on_edge, deepest(points.reshape(-1, 3), other))
    return at_vertex, on_edge


def deepest(points: Array, triangles: Array) -> float:
    """Largest distance of points inside a closed surface from it."""
    low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    depths = [0.0]
    for p in points[np.all((points > low) & (points < high), axis=1)]:
        if abs(winding_number(p, triangles)) > 0.5:
            spread = np.tile(p, (len(triangles), 1))
            nearest = trimesh.triangles.closest_point(triangles, spread)
            depths.append(float(np.linalg.norm(nearest - p, axis=1).min()))
    return max(depths)


@pytest.mark.parametrize("seed", range(6))
def test_depths_are_those_of_vertices_and_edges_and_nothing_is_deeper_than_stated(
    seed: int,
) -> None:
    searcher, span, m = deep_searcher(seed)
    gauge = DepthGauge(searcher.scene, searcher.path, searcher.arrays, searcher.joints, [0])
    rng = np.random.default_rng([7, seed])
    start, end = sorted(rng.integers(span.start_ps, span.end_ps, 2).tolist())
    [depth] = gauge.deepest(0, [(start, end)])
    at_vertex, on_edge = depths_alone(searcher, m, depth.time_ps)
    assert at_vertex - 2 * GOOD_TO_MM <= depth.deepest <= on_edge + EDGE_STEP_MM
    for time_ps in rng.integers(start, end + 1, 8).tolist():
        at_vertex, _ = depths_alone(searcher, m, time_ps)
        assert at_vertex <= depth.deepest + depth.within + 1e-6
