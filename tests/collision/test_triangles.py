"""The public triangle test against the exact oracle: no miss, and no alarm beyond 1e-9 mm."""

from __future__ import annotations

from fractions import Fraction
from itertools import permutations

import numpy as np
import pytest
from benchmarks.hard_pairs import EVERY_FAMILY, HARD, generate
from collision.counterexamples import COUNTEREXAMPLES

import gcodesim
from gcodesim import triangles_intersect
from gcodesim.collision.bodies.regions import snapped
from gcodesim.study.exact import label, squared_clearance
from gcodesim.study.families import Array

FALSE_ALARM_MM = Fraction(1, 10**9)
UNIT_MM = {"F11": 1000}  # F11 is in metres

FACE = np.array([[0.0, 0, 0], [4, 0, 0], [0, 4, 0]])
PIERCING = np.array([[1.0, 1, -1], [1, 1, 1], [9, 9, 1]])
APART = FACE + np.array([0, 0, 0.5])


def count_false_alarms(found: Array, a: Array, b: Array, unit: int) -> int:
    """Number of false alarms; fails on a miss and on an alarm at more than FALSE_ALARM_MM."""
    exact = label(a, b)
    assert not np.flatnonzero(exact & ~found).size, "a true contact was missed"
    alarms = np.flatnonzero(found & ~exact)
    for i in alarms:
        assert squared_clearance(a[i], b[i]) * unit**2 <= FALSE_ALARM_MM**2
    return len(alarms)


@pytest.mark.parametrize("family", EVERY_FAMILY)
def test_no_miss_and_no_alarm_beyond_1e_9_mm(family: str, device: str) -> None:
    a, b = generate(family, 2000, seed=11)
    found = triangles_intersect(a, b, device)
    alarms = count_false_alarms(found, a, b, UNIT_MM.get(family, 1))
    if family not in ("F08", HARD):  # one ulp apart, and gaps from 1e-12 mm
        assert alarms == 0


def test_vertices_on_the_grid_of_the_detector_lose_nothing(device: str) -> None:
    a, b = (snapped(t) for t in generate(HARD, 2000, seed=12))
    count_false_alarms(triangles_intersect(a, b, device), a, b, 1)


@pytest.mark.parametrize("reach", [1, 2, 5])
def test_degenerate_integer_triangles_are_judged_exactly(reach: int, device: str) -> None:
    rng = np.random.default_rng(reach)
    a, b = rng.integers(-reach, reach + 1, (2, 3000, 3, 3)).astype(np.float64)
    kind = rng.integers(0, 7, 3000)
    for t, lines, points in ((a, (1, 3), (4, 6)), (b, (2, 3), (5, 6))):
        t[np.isin(kind, lines), 2] = 2 * t[np.isin(kind, lines), 1] - t[np.isin(kind, lines), 0]
        t[np.isin(kind, points)] = t[np.isin(kind, points), :1]
    np.testing.assert_array_equal(triangles_intersect(a, b, device), label(a, b))


def test_counterexamples_of_other_tests(device: str) -> None:
    a, b = (np.array([getattr(c, side) for c in COUNTEREXAMPLES]) for side in "ab")
    expected = [c.intersects for c in COUNTEREXAMPLES]
    assert triangles_intersect(a, b, device).tolist() == expected
    assert triangles_intersect(b, a, device).tolist() == expected


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e71, 1.7e308])
def test_what_cannot_be_judged_is_a_contact(bad: float, device: str) -> None:
    a = np.tile(FACE, (18, 1, 1))
    b = np.tile(APART, (18, 1, 1))
    assert not triangles_intersect(a, b, device).any()
    for i in range(18):
        (a, b)[i // 9][i].flat[i % 9] = bad
    assert triangles_intersect(a, b, device).all()


@pytest.mark.parametrize("family", ["F01", "F02", "F03", "F06", "F08"])
def test_verdicts_do_not_depend_on_scale(family: str, device: str) -> None:
    a, b = generate(family, 200, seed=13)
    exact, unscaled = label(a, b), triangles_intersect(a, b, device)
    for exponent in range(-300, 201, 50):
        scaled = [np.ldexp(t, exponent) for t in (a, b)]
        np.testing.assert_array_equal(triangles_intersect(*scaled, device), unscaled)
    if family != "F08":
        np.testing.assert_array_equal(unscaled, exact)


@pytest.mark.parametrize("exponent", [-1060, -1040, -1000, -700, -500, 230, 400, 600])
def test_no_miss_where_products_underflow_or_overflow(exponent: int, device: str) -> None:
    a, b = (np.ldexp(t, exponent) for t in generate("F02", 300, seed=14))
    # Scaled down, coordinates are rounded to denormals: the truth is that of what is left.
    missed = label(a, b) & ~triangles_intersect(a, b, device)
    assert not missed.any()


@pytest.mark.parametrize("family", ["F02", "F03", "F05", "F07"])
def test_order_side_and_handedness_change_nothing(family: str, device: str) -> None:
    a, b = generate(family, 300, seed=15)
    expected = triangles_intersect(a, b, device)
    assert 0 < expected.sum() < len(expected)
    for order in permutations(range(3)):
        np.testing.assert_array_equal(triangles_intersect(a[:, order], b, device), expected)
        np.testing.assert_array_equal(triangles_intersect(b, a[:, order], device), expected)
    for mirror in ([-1, 1, 1], [1, -1, 1], [1, 1, -1]):
        np.testing.assert_array_equal(triangles_intersect(a * mirror, b * mirror, device), expected)
    for cycle in ([1, 2, 0], [2, 0, 1], [1, 0, 2]):
        np.testing.assert_array_equal(
            triangles_intersect(a[..., cycle], b[..., cycle], device), expected
        )


@pytest.mark.parametrize(
    ("a", "b"),
    [
        (FACE, PIERCING),
        (FACE[None], np.tile(PIERCING, (2, 1, 1))),
        (FACE[None, :2], PIERCING[None, :2]),
        (FACE[None, :, :2], PIERCING[None, :, :2]),
        ([], []),
        (1.0, 1.0),
    ],
)
def test_wrong_shapes_are_refused(a: Array, b: Array) -> None:
    with pytest.raises(ValueError, match=r"\(n, 3, 3\)"):
        triangles_intersect(a, b)


def test_lists_and_no_pairs_at_all_are_welcome(device: str) -> None:
    both = triangles_intersect([FACE.tolist()] * 2, [PIERCING.tolist(), APART.tolist()], device)
    assert both.dtype == np.bool_
    assert both.tolist() == [True, False]
    assert triangles_intersect(np.zeros((0, 3, 3)), np.zeros((0, 3, 3)), device).shape == (0,)


def test_the_package_offers_nothing_else() -> None:
    with pytest.raises(AttributeError, match="no attribute 'tringles'"):
        _ = gcodesim.tringles
