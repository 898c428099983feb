"""A family of triangle pairs harder than those of the study: edges that are nearly parallel."""

from __future__ import annotations

import numpy as np

from gcodesim.study.families import (
    FAMILIES,
    TrianglePairs,
    edges_near,
    placed,
    powers,
    shuffled,
    signed,
)
from gcodesim.study.families import generate as of_study

HARD = "hard"
EVERY_FAMILY = (*FAMILIES, HARD)

GRID_MM = 2.0**-33
"""Snapping grid of every second half dozen; |x| < 2^20 mm stays exact in float64."""


def generate(family: str, count: int, seed: int) -> TrianglePairs:
    """Pairs of a family of the study, or of the hard one; two arrays (count, 3, 3)."""
    if family != HARD:
        return of_study(family, count, seed)
    rng = np.random.default_rng([seed, 12])
    return shuffled(rng, *_hard(rng, count))


def _hard(rng: np.random.Generator, n: int) -> TrianglePairs:
    """Nearly parallel edges, tilted in three ways, every other three pairs on the grid."""
    variant, snapped = np.arange(n) % 3, np.arange(n) // 3 % 2 == 1
    size_a, size_b = powers(rng, n, 2, 3), powers(rng, n, 2, 3)
    angle = np.where(variant == 2, powers(rng, n, -9, -7), powers(rng, n, -10, -5))
    tilt_a, tilt_b = (
        np.choose(variant, [np.ones(n), powers(rng, n, -8, -2), powers(rng, n, -9, -6)])
        for _ in range(2)
    )
    gap = signed(rng, n, -12, -5)
    a, b = placed(rng, edges_near(rng, size_a, size_b, gap, tilt_a, tilt_b, angle), 1000)
    for t in (a, b):
        t[snapped] = np.round(t[snapped] / GRID_MM) * GRID_MM
    return a, b
