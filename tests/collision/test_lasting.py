"""Lasting contacts and depths equal what is found at every instant by itself."""

from __future__ import annotations

import numpy as np
import pytest
from collision.random_programs import random_trial

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

MOST = 3000
"""Instants looked at of one program."""


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


def depth_alone(searcher: Searcher, m: Machine, pair: int, time_ps: int) -> float:
    """Largest distance of a vertex of either body inside the other, by every triangle."""
    q = searcher.path.positions(np.array([time_ps]))[0]
    world, best = world_from_link(m, q), 0.0
    sides = [
        np.concatenate([p.triangles for p in shape.parts]) @ world[link][:3, :3].T
        + world[link][:3, 3]
        for shape, link in zip(searcher.scene.shapes[pair], searcher.scene.links[pair], strict=True)
    ]
    for own, other in (sides, sides[::-1]):
        low, high = other.min(axis=(0, 1)), other.max(axis=(0, 1))
        for p in np.unique(own.reshape(-1, 3), axis=0):
            if np.all((p > low) & (p < high)) and abs(winding_number(p, other)) > 0.5:
                best = max(best, surface_distance(p, other))
    return best


def surface_distance(p: np.ndarray, triangles: np.ndarray) -> float:
    """Distance of a point from triangles, by trimesh."""
    import trimesh

    nearest = trimesh.triangles.closest_point(triangles, np.tile(p, (len(triangles), 1)))
    return float(np.linalg.norm(nearest - p, axis=1).min())


@pytest.mark.parametrize("seed", range(8))
def test_depths_are_those_of_every_vertex_and_nothing_is_deeper_than_stated(seed: int) -> None:
    searcher, span, m = deep_searcher(seed)
    gauge = DepthGauge(searcher, [0])
    rng = np.random.default_rng([7, seed])
    start, end = sorted(rng.integers(span.start_ps, span.end_ps, 2).tolist())
    [depth] = gauge.deepest(0, [(start, end)])
    assert depth.deepest == pytest.approx(
        depth_alone(searcher, m, 0, depth.time_ps), abs=2 * GOOD_TO_MM
    )
    for time_ps in rng.integers(start, end + 1, 12).tolist():
        assert depth_alone(searcher, m, 0, time_ps) <= depth.deepest + depth.within + 1e-6
