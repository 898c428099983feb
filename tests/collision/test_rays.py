"""Rays: the silhouette, the distance and the triangle of a box, against its measures."""

from __future__ import annotations

import numpy as np

from gcodesim.collision.views.rays import NOTHING, Grid, Target
from gcodesim.machine.shapes import box


def test_rays_see_a_box_as_large_and_as_far_as_it_is(device: str) -> None:
    triangles = box((20.0, 10.0, 4.0), (1.0, 2.0, 3.0))
    step = 0.5
    grid = Grid(
        corner=np.array([-19.75, -20.25, 50.0]),
        across=np.array([step, 0.0, 0.0]),
        down=np.array([0.0, step, 0.0]),
        direction=np.array([0.0, 0.0, -1.0]),
        reach=100.0,
        size=80,
    )
    hits = Target(triangles, device).first_hits(grid)
    met = hits.triangle != NOTHING
    # Rays lie a quarter of a millimetre off every edge: the count is exact.
    assert np.count_nonzero(met) * step**2 == 20.0 * 10.0
    np.testing.assert_allclose(hits.distance[met], 45.0, rtol=1e-6)
    assert (hits.distance[~met] == 100.0).all()
    assert (triangles[hits.triangle[met]][:, :, 2] == 5.0).all()
    rows, columns = np.nonzero(met)
    # x in -9 .. 11 and y in -3 .. 7
    assert (columns.min(), columns.max()) == (22, 61)
    assert (rows.min(), rows.max()) == (35, 54)


def test_nothing_is_seen_of_nothing(device: str) -> None:
    zero = np.zeros(3)
    grid = Grid(zero, zero, zero, np.array([0.0, 0.0, 1.0]), 7.0, 3)
    hits = Target(np.zeros((0, 3, 3)), device).first_hits(grid)
    assert (hits.triangle == NOTHING).all()
    assert (hits.distance == 7.0).all()
