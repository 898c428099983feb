"""Minimal pairs of triangles that published or simpler intersection tests get wrong."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Counterexample(NamedTuple):
    """One pair, (3, 3) each, with the exact answer and what goes wrong elsewhere."""

    name: str
    a: NDArray[np.float64]
    b: NDArray[np.float64]
    intersects: bool
    why: str


def _stacked(name: str, size: float, height: float, why: str) -> Counterexample:
    a = np.array([[0, 0, 0], [size, 0, 0], [0, size, 0]], dtype=np.float64)
    return Counterexample(name, a, a + np.array([0, 0, height]), False, why)


def _below_float32(exponent: int) -> Counterexample:
    """Return a pair of size 2^exponent whose heights are fractions of the smallest float32."""
    size, eta = 2.0**exponent, 2.0**-149
    a = [[0, 0, 0], [size, 0, 3.49 * eta], [0, size, 0.49 * eta]]
    b = [
        [0.85 * size, 0.01 * size, 2.501 * eta],
        [0.85 * size, 0.02 * size, 3.9 * eta],
        [size * (3 - 0.4) / 3, 0.015 * size, 3.9 * eta],
    ]
    why = "float32 certificate without a floor: the conversion underflows"
    return Counterexample(f"C4 2^{exponent}", np.array(a), np.array(b), True, why)


COUNTEREXAMPLES = (
    _stacked("C1", 0.01, 0.009, "absolute epsilon of wp.intersect_tri_tri: data in metres"),
    _stacked("C1 control", 10.0, 9.0, "the same in mm"),
    Counterexample(
        "C2",
        np.array([[0.0, -532, 3528], [142, 4140, 1910], [746, 6529, -123]]),
        np.array([[718.0, 2494, -51], [300, 2432, 508], [909, 2666, 579]]),
        False,
        "float32 overload of wp.intersect_tri_tri: contact at 1248 mm clearance",
    ),
    Counterexample(
        "C3",
        np.array([[2254.0, 4227, -1367], [-79, 2071, -1316], [953, 815, -3706]]),
        np.array([[1120.0, 1277, -1075], [-1234, 2654, -2502], [-1381, -466, -1047]]),
        True,
        "float32 overload of wp.intersect_tri_tri: misses a contact 10 mm deep",
    ),
    *(_below_float32(exponent) for exponent in (14, 15, 17, 20)),
)
