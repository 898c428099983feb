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


def ideal_radius(z, diameter, length, corner, taper):
    """Radius of the ideal cutter at height z above the tip, closed form."""
    t = np.radians(taper)
    middle = diameter / 2 + corner * (np.tan(t) - 1 / np.cos(t))
    side = diameter / 2 + z * np.tan(t)
    arc = middle + np.sqrt(np.clip(corner**2 - (corner - z) ** 2, 0, None))
    return np.where(z < corner * (1 - np.sin(t)), arc, side)


@pytest.mark.parametrize(
    ("diameter", "length", "corner", "taper"),
    [
        (10, 30, 0, 0),
        (10, 30, 5, 0),
        (10, 30, 2, 0),
        (6, 40, 2, 7),
        (20, 12, 1, -15),
        (1, 9, 0, 45),
    ],
    ids=["flat", "ball", "bull", "tapered bull", "dovetail", "chamfer"],
)
def test_cutter_contains_the_ideal_one(diameter, length, corner, taper):
    profile = np.array(shapes.cutter_profile(diameter, length, corner, taper))
    z = np.linspace(0, length, 2001)
    ideal = ideal_radius(z, diameter, length, corner, taper)
    drawn = np.interp(z, profile[:, 1], profile[:, 0])
    drawn[0] = profile[profile[:, 1] == 0, 0].max()
    assert (drawn >= ideal - 1e-12).all()
    assert (drawn[1:] - ideal[1:]).max() < 0.25 * max(corner, 1e-9)
    triangles = shapes.revolve(profile)
    assert_sound(triangles)
    assert triangles[..., 2].min() == 0
    assert triangles[..., 2].max() == length
    assert signed_volume(triangles) >= np.pi * np.trapezoid(ideal**2, z)


@pytest.mark.parametrize("shape", [(10, 30, 6, 0), (10, 3, 4, 0), (10, 30, 0, -20)])
def test_impossible_cutters(shape):
    with pytest.raises(ValueError, match=r"corner_radius|flute"):
        shapes.cutter_profile(*shape)
