"""Primitives: closed, outward, of the right volume, and never smaller than the ideal shape."""

import numpy as np
import pytest

from gcodesim.machine import shapes
from gcodesim.machine.mesh import merge_corners, open_edge_count, signed_volume

CIRCUMSCRIBED = np.tan(np.pi / shapes.SIDES) * shapes.SIDES  # area of the polygon around r = 1
UP = [0.0, 0.0, 1.0]


def assert_sound(triangles):
    """Closed and outward oriented."""
    assert open_edge_count(merge_corners(triangles)) == 0
    assert signed_volume(triangles) > 0


@pytest.mark.parametrize(
    ("triangles", "volume"),
    [
        (shapes.box([2, 3, 4], [10, 20, 30]), 24),
        (shapes.cylinder(5, 7, [1, 2, 3], UP), CIRCUMSCRIBED * 25 * 7),
        (shapes.cone(6, 0, 9, [1, 2, 3], UP), CIRCUMSCRIBED * 36 * 9 / 3),
        (shapes.cone(2, 1, 3, [0, 0, 0], [1.0, 0, 0]), CIRCUMSCRIBED * 7),
        (shapes.revolve([[3, 0], [3, 5], [1, 5], [1, 9]]), CIRCUMSCRIBED * (9 * 5 + 4)),
        (shapes.revolve([[0, 9], [0, 5], [3, 5], [3, 0]]), CIRCUMSCRIBED * 9 * 5),
        (shapes.extrude([(0, 0), (4, 0), (4, 1), (1, 1), (1, 4), (0, 4)], 2), 14),
        (shapes.extrude([(0, 4), (1, 4), (1, 1), (4, 1), (4, 0), (2, 0), (0, 0)], 2), 14),
    ],
    ids=["box", "cylinder", "cone", "frustum", "step", "from axis", "L", "L clockwise, collinear"],
)
def test_closed_outward_and_volume(triangles, volume):
    assert_sound(triangles)
    assert signed_volume(triangles) == pytest.approx(volume, rel=1e-12)


def test_cylinder_is_drawn_around():
    """Flats touch the circle, corners stand out by the stated excess; size and place are right."""
    axis = np.array([0.6, 0.0, 0.8])
    triangles = shapes.cylinder(5, 8, [1, 2, 3], axis)
    local = triangles.reshape(-1, 3) - [1, 2, 3]
    along = local @ axis
    radius = np.linalg.norm(local - along[:, None] * axis, axis=1)
    rim = radius > 1e-9
    np.testing.assert_allclose(np.abs(along), 4, atol=1e-12)
    np.testing.assert_allclose(radius[rim], 5 + shapes.excess(5), rtol=1e-12)


@pytest.mark.parametrize(
    "profile", [[[1, 0], [1, 0]], [[0, 0], [0, 5]], [[1, 0], [2, 3], [1, 2]], [[-1, 0], [1, 1]],
                [[1, 0], [0, 1], [1, 2]], [[1, 0], [2, 0]]],
)  # fmt: skip
def test_impossible_profiles(profile):
    with pytest.raises(ValueError, match=r"profile|radius|turns back"):
        shapes.revolve(profile)


@pytest.mark.parametrize(
    "polygon", [[(0, 0), (1, 1), (1, 0), (0, 1)], [(0, 0), (1, 0), (2, 0)],
                [(0, 0), (2, 0), (2, 2), (1, 0), (0, 2)], [(0, 0), (1, 0), (0, 0), (1, 1)]],
)  # fmt: skip
def test_impossible_polygons(polygon):
    with pytest.raises(ValueError, match="polygon"):
        shapes.extrude(polygon, 1)
