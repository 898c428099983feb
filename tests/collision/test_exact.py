"""The exact oracle against a second method and known cases; the families against their rates."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import permutations, product

import numpy as np
import pytest
from benchmarks.hard_pairs import EVERY_FAMILY, generate
from collision.counterexamples import COUNTEREXAMPLES, Counterexample

from gcodesim.study.exact import Corners, label, squared_clearance
from gcodesim.study.families import FAMILIES, Array

# Intersecting share of 1e5 pairs, from the C++/GMP prototype of these families.
INTERSECTING = {
    "F01": 0.14351, "F02": 0.43606, "F03": 0.37377, "F04": 0.49220, "F05": 0.28118,
    "F06": 0.13404, "F07": 0.22453, "F08": 0.85017, "F09": 0.30971, "F10": 0.39703,
    "F11": 0.43606, "F12": 0.43469, "F13": 0.32067,
}  # fmt: skip

TINY = 5e-324
STEP = 2.0**-20
ABOVE = float(np.nextafter(1000.0, 2000.0))
FACE = ((0, 0, 0), (4, 0, 0), (0, 4, 0))
HIGH = ((0, 0, 1000), (4, 0, 1000), (0, 4, 1000))
DIAGONAL = ((0, 0, 0), (2, 2, 2), (1, 1, 1))
STAR = ((0, 0, 0), (6, 0, 0), (3, 6, 0))
SLOPE = ((0, 0, 0), (4, 0, 4), (0, 4, 0))

KNOWN = [
    ("identical", FACE, FACE, True),
    ("edge through face", FACE, ((1, 1, -1), (1, 1, 1), (9, 9, 1)), True),
    ("edge past face", FACE, ((3, 3, -1), (3, 3, 1), (9, 9, 1)), False),
    ("vertex on face", FACE, ((1, 1, 0), (1, 1, 2), (2, 1, 2)), True),
    ("vertex just over face", FACE, ((1, 1, TINY), (1, 1, 2), (2, 1, 2)), False),
    ("vertex on edge", FACE, ((2, 2, 0), (3, 3, 1), (4, 4, 1)), True),
    ("vertex on vertex", FACE, ((4, 0, 0), (5, 0, 1), (5, 1, 1)), True),
    ("edge touches edge", FACE, ((2, -1, 1), (2, 1, -1), (2, -3, 0)), True),
    ("edge just off edge", FACE, ((2, -1 - STEP, 1), (2, 1 - STEP, -1), (2, -3, 0)), False),
    ("shared edge", FACE, ((0, 0, 0), (4, 0, 0), (0, 0, 4)), True),
    ("coplanar overlap", FACE, ((1, 1, 0), (5, 1, 0), (1, 5, 0)), True),
    ("coplanar star, no vertex inside", STAR, ((0, 4, 0), (6, 4, 0), (3, -2, 0)), True),
    ("coplanar nested", FACE, ((1, 1, 0), (1.5, 1, 0), (1, 1.5, 0)), True),
    ("coplanar neighbours", FACE, ((4, 0, 0), (0, 4, 0), (4, 4, 0)), True),
    ("coplanar vertex on edge", FACE, ((2, 2, 0), (5, 5, 0), (4, 5, 0)), True),
    ("coplanar apart", FACE, ((3, 3, 0), (5, 3, 0), (3, 5, 0)), False),
    ("parallel planes", SLOPE, [(x, y, z + 0.5) for x, y, z in SLOPE], False),
    ("one ulp apart", HIGH, ((1, 1, ABOVE), (1, 1, 2e3), (2, 1, 2e3)), False),
    ("segment through face", FACE, ((1, 1, -1), (1, 1, 1), (1, 1, 1)), True),
    ("segment past face", FACE, ((3, 3, -1), (3, 3, 1), (3, 3, 0)), False),
    ("segment in plane across face", FACE, ((-1, 1, 0), (9, 1, 0), (9, 1, 0)), True),
    ("segment in plane inside face", FACE, ((1, 1, 0), (2, 1, 0), (2, 1, 0)), True),
    ("segment in plane outside", FACE, ((3, 2, 0), (2, 3.5, 0), (2, 3.5, 0)), False),
    ("point in face", FACE, ((1, 1, 0),) * 3, True),
    ("point on edge", FACE, ((2, 2, 0),) * 3, True),
    ("point beside face", FACE, ((3, 3, 0),) * 3, False),
    ("collinear segments overlap", DIAGONAL, ((1, 1, 1), (3, 3, 3), (3, 3, 3)), True),
    ("collinear segments end to end", DIAGONAL, ((2, 2, 2), (3, 3, 3), (3, 3, 3)), True),
    ("collinear segments apart", DIAGONAL, ((2.5, 2.5, 2.5), (3, 3, 3), (3, 3, 3)), False),
    ("parallel segments", DIAGONAL, ((1, 0, 0), (3, 2, 2), (2, 1, 1)), False),
    ("crossing segments", DIAGONAL, ((2, 0, 0), (0, 2, 2), (0, 2, 2)), True),
    ("skew segments", DIAGONAL, ((2, 0, 1), (0, 2, 2), (0, 2, 2)), False),
    ("point on segment", DIAGONAL, ((1.5, 1.5, 1.5),) * 3, True),
    ("point beside segment", DIAGONAL, ((1, 1, 0),) * 3, False),
    ("equal points", ((1, 2, 3),) * 3, ((1, 2, 3),) * 3, True),
]  # fmt: skip


def share_a_point(a: Corners, b: Corners) -> bool:
    return bool(label([a], [b])[0])


@pytest.mark.parametrize(("a", "b", "expected"), [k[1:] for k in KNOWN], ids=[k[0] for k in KNOWN])
def test_known_pairs_in_every_order(a: Corners, b: Corners, expected: bool) -> None:
    for p, q in product(permutations(a), permutations(b)):
        assert share_a_point(p, q) is expected
        assert share_a_point(q, p) is expected


@pytest.mark.parametrize("case", COUNTEREXAMPLES, ids=[c.name for c in COUNTEREXAMPLES])
def test_counterexamples_carry_exact_labels(case: Counterexample) -> None:
    assert share_a_point(case.a, case.b) is case.intersects
    assert (squared_clearance(case.a, case.b) == 0) is case.intersects


@pytest.mark.parametrize(
    ("b", "squared"),
    [
        (((7, 0, 4), (8, 0, 4), (8, -1, 4)), Fraction(25)),  # vertex to vertex
        (((2, -3, 1), (1, -4, 1), (3, -4, 1)), Fraction(10)),  # edge to vertex
        (((1, 1, 2), (1, 1, 3), (2, 1, 3)), Fraction(4)),  # face to vertex
        (((2, -1, 2), (2, -3, 0), (2, -4, 5)), Fraction(9, 2)),  # edge to edge
        (((3, 3, 0), (5, 3, 0), (3, 5, 0)), Fraction(2)),  # coplanar
        (((1, 1, TINY), (1, 1, 2), (2, 1, 2)), Fraction(TINY) ** 2),
        (((1, 1, 0), (1, 1, 2), (2, 1, 2)), Fraction(0)),
    ],
)
def test_squared_clearance_is_exact(b: Corners, squared: Fraction) -> None:
    assert squared_clearance(FACE, b) == squared == squared_clearance(b, FACE)


def _touches_by_directions(a: Array, b: Array) -> Sequence[bool]:
    return [squared_clearance(p, q) == 0 for p, q in zip(a, b, strict=True)]


@pytest.mark.parametrize("reach", [1, 2, 3])
def test_oracle_equals_separating_directions_on_degenerate_integers(reach: int) -> None:
    rng = np.random.default_rng(reach)
    a, b = rng.integers(-reach, reach + 1, (2, 1000, 3, 3)).astype(np.float64)
    kind = rng.integers(0, 6, 1000)
    a[kind == 1, 2] = a[kind == 1, 1]
    b[kind == 2, 2] = 2 * b[kind == 2, 1] - b[kind == 2, 0]
    a[kind == 3, 1:] = a[kind == 3, :1]
    a[kind == 4, :, 2] = b[kind == 4, :, 2] = 0
    found = label(a, b)
    assert 0.1 < found.mean() < 0.9
    np.testing.assert_array_equal(found, _touches_by_directions(a, b))


@pytest.mark.parametrize("family", EVERY_FAMILY)
def test_oracle_equals_separating_directions_on_families(family: str) -> None:
    a, b = generate(family, 60, seed=3)
    np.testing.assert_array_equal(label(a, b), _touches_by_directions(a, b))


@pytest.mark.parametrize("family", EVERY_FAMILY)
def test_families_are_finite_and_reproducible(family: str) -> None:
    a, b = generate(family, 250, seed=1)
    again, other = generate(family, 250, seed=1), generate(family, 250, seed=2)
    assert a.shape == b.shape == (250, 3, 3)
    assert a.dtype == b.dtype == np.float64
    assert np.isfinite(a).all()
    assert np.isfinite(b).all()
    np.testing.assert_array_equal((a, b), again)
    assert not np.isin(a, other[0]).all(axis=(1, 2)).any()


@pytest.mark.parametrize("family", FAMILIES)
def test_families_intersect_as_often_as_measured(family: str) -> None:
    # 3000 pairs scatter by up to 0.9 % (one sigma).
    assert label(*generate(family, 3000, seed=0)).mean() == pytest.approx(
        INTERSECTING[family], abs=0.025
    )


def test_coordinates_that_are_no_numbers_are_refused() -> None:
    with pytest.raises(ValueError, match="NaN"):
        share_a_point(FACE, np.full((3, 3), np.nan).tolist())
    with pytest.raises(OverflowError):
        share_a_point(FACE, [[0.0, 0, -np.inf], [1.0, 1, np.inf], [1.0, 0, 0]])
