"""Distances at frames: equal to exact ones, with the tool of their time, and bounded in cost."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from collision.scenes import random_scene
from collision.test_tool_changes import JOINTS, spindle

from gcodesim.collision.views import distances as module
from gcodesim.collision.views.distances import (
    FEWEST,
    FRAMES,
    Distances,
    distances,
    nearest_moment,
)
from gcodesim.constants import DISTANCE_GOOD_TO_MM as GOOD_TO_MM
from gcodesim.motion.path import ToolChange
from gcodesim.study.scenes import SCENES, Array, KnownScene, arc_grazes_face, exact_clearance, path

NONE = np.zeros(0, np.int64)


def spans(found: Distances) -> Array:
    """Distance of the two points of every link, less the distance of its pair there."""
    apart = [np.linalg.norm(link.points[0] - link.points[1]) for link in found.links]
    return np.array(apart) - [found.distance[link.frame, link.pair] for link in found.links]


@pytest.mark.parametrize("name", SCENES)
def test_distances_are_those_of_exact_arithmetic(name: str, device: str) -> None:
    scene: KnownScene = SCENES[name]()
    asked = [] if scene.contact_s is None else [round(scene.contact_s * 1e12) + 1]
    found = distances(scene.machine, scene.path, device, np.array(asked, np.int64))
    assert set(asked) <= set(found.time_ps.tolist())
    for frame in range(0, len(found.time_ps), 25):
        true = scene.clearance_at(int(found.time_ps[frame]))
        assert found.distance[frame, 0] == pytest.approx(true, abs=2 * GOOD_TO_MM)


@pytest.mark.parametrize("seed", range(4))
def test_all_pairs_of_random_machines(seed: int, device: str) -> None:
    scene = random_scene(np.random.default_rng(seed))
    found = distances(scene.machine, scene.path, device, NONE)
    for frame in range(0, len(found.time_ps), 100):
        for column, pair in enumerate(scene.machine.pairs):
            time_ps = int(found.time_ps[frame])
            true = exact_clearance(scene.machine, scene.path, time_ps, (pair.a, pair.b))
            assert found.distance[frame, column] == pytest.approx(true, abs=2 * GOOD_TO_MM)
    np.testing.assert_allclose(spans(found), 0.0, atol=2 * GOOD_TO_MM)
    # Of every frame the nearest pair, of every pair its nearest frame.
    linked = {(link.frame, link.pair) for link in found.links}
    rows = np.arange(len(found.time_ps))
    assert linked >= set(zip(rows.tolist(), found.distance.argmin(axis=1).tolist(), strict=True))
    assert {pair for _, pair in linked} == set(range(len(scene.machine.pairs)))


def test_each_tool_from_its_change_on(device: str) -> None:
    # A spindle at Z50 over a table; no tool, one of 20 mm, one without a shape, one of 45 mm.
    p = path(JOINTS, [0.0], [(1.0, [0.0])] * 4)
    changes = tuple(ToolChange(piece, number, 0) for piece, number in ((1, 1), (2, 9), (3, 3)))
    m = spindle({1: 20.0, 3: 45.0})
    column = [pair.b for pair in m.pairs].index("cutter")
    found = distances(m, replace(p, tool_changes=changes), device, np.arange(4) * 10**12)
    expected = np.select([found.time_ps < k * 10**12 for k in (1, 2, 3)], [45.0, 30.0, np.nan], 5.0)
    np.testing.assert_allclose(found.distance[:, column], expected, atol=2 * GOOD_TO_MM)


def test_the_nearest_moment(device: str) -> None:
    # A cube on an arc comes to half a millimetre of a face after 0.2 s, and rises again.
    scene = arc_grazes_face(-0.5)
    middle = nearest_moment(scene.machine, scene.path, device, scene.pair, 10**10)
    assert middle.time_ps / 1e12 == pytest.approx(0.2, abs=1e-4)
    assert middle.distance == pytest.approx(0.5, abs=2 * GOOD_TO_MM)
    a, b = middle.points
    np.testing.assert_allclose(a - b, [0, 0, -0.5], atol=2 * GOOD_TO_MM)
    late = nearest_moment(scene.machine, scene.path, device, scene.pair, 3 * 10**11)
    assert late.time_ps == 3 * 10**11
    assert late.distance == pytest.approx(scene.clearance_at(late.time_ps), abs=2 * GOOD_TO_MM)


def test_frames_are_fewer_where_each_costs_more(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = random_scene(np.random.default_rng(1))
    asked = np.array([scene.path.duration_ps // 7])

    def frames() -> int:
        found = distances(scene.machine, scene.path, "cpu", asked)
        assert {0, *asked.tolist(), scene.path.duration_ps} <= set(found.time_ps.tolist())
        return len(found.time_ps)

    assert frames() == FRAMES + 1
    monkeypatch.setattr(module, "WORK", module.WORK // 10)
    assert FEWEST + 1 < frames() < FRAMES
    monkeypatch.setattr(module, "WORK", 1)
    assert frames() == FEWEST + 1


def test_nothing_is_measured_of_a_program_without_motion() -> None:
    scene = random_scene(np.random.default_rng(2))
    still = path(scene.machine.joints, np.zeros(len(scene.machine.joints)), [])
    found = distances(scene.machine, still, "cpu", NONE)
    assert (found.distance.shape, found.links) == ((0, len(scene.machine.pairs)), ())
