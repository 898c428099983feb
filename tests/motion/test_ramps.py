"""Ramps against 60 digits, where the usual formulas lose all of theirs."""

from __future__ import annotations

from decimal import Decimal, localcontext
from math import inf

import numpy as np
import pytest

from gcodesim.motion.ramps import (
    phases,
    ramp_time,
    reachable_speed,
    reachable_speeds,
    time_law,
    top_speed,
)
from gcodesim.study.stability_drives import ramp_errors

U = 2.0**-53


def one(*values: float) -> list[np.ndarray]:
    return [np.array([value]) for value in values]


def test_times_at_limited_acceleration_to_four_roundings(rng: np.random.Generator) -> None:
    """v 1e-3..1e3, a 1e-6..1e6, d 1e-6..1e4: (w - u)/a is wrong by up to 100 % here."""
    usual, ours = ramp_errors(2000, rng)
    assert ours <= 4 * U
    assert usual > 0.1


def test_reachable_speeds_at_limited_jerk(rng: np.random.Generator) -> None:
    """The way of a ramp to the reachable speed is the way given: both formulas, to rounding."""
    for _ in range(2000):
        v, a, j, d = 10.0 ** rng.uniform([-3, -3, -6, -6], [3, 6, 9, 4])
        w = reachable_speed(v, d, a, j)
        with localcontext(prec=60):
            u, a_, j_, rise = map(Decimal, (v, a, j, w))
            rise -= u
            time = rise / a_ + a_ / j_ if rise > a_ * a_ / j_ else 2 * (max(rise, 0) / j_).sqrt()
            way = float((2 * u + rise) / 2 * time)
            # How much the way changes when the speed moves by its last digits.
            slack = float(
                time + (u + rise) * (1 / a_ + 1 / (j_ * max(rise, Decimal(v * U))).sqrt())
            )
        assert abs(way - d) <= 1e-14 * d + 8 * w * U * slack


@pytest.mark.parametrize("j", [inf, 1e-6, 1e3, 1e12])
def test_many_reachable_speeds_are_those_of_each(j: float, rng: np.random.Generator) -> None:
    u, a, length = 10.0 ** rng.uniform([-6, -6, -6], [6, 9, 4], (2000, 3)).T
    u[:100] = 0.0
    jerk = np.full(2000, j)
    each = [reachable_speed(*row) for row in zip(u, length, a, jerk, strict=True)]
    np.testing.assert_allclose(reachable_speeds(u, length, a, jerk), each, rtol=8 * U)


@pytest.mark.parametrize("j", [1e-3, 1e3, 1e12])
def test_top_speeds_are_the_largest_whose_ramps_fit(j: float, rng: np.random.Generator) -> None:
    """Way up and down is at most the length, and a few roundings faster it is more."""
    a, length = 10.0 ** rng.uniform([-6, -6], [6, 4], (5000, 2)).T
    jerk = np.full(5000, j)
    u = 10.0 ** rng.uniform(-6, 6, 5000) * rng.integers(0, 2, 5000)
    w = rng.uniform(0, 1, 5000) ** 2 * (reachable_speeds(u, length, a, jerk) - u) + u
    u, w = np.where(rng.random(5000) < 0.5, (u, w), (w, u))
    top = top_speed(u, w, np.full(5000, inf), length, a, jerk)

    def way(v: np.ndarray) -> np.ndarray:
        up, down = (0.5 * (end + v) * ramp_time(end, v, a, jerk) for end in (u, w))
        return up + down

    least = top == np.maximum(u, w)
    assert (way(top)[~least] <= length[~least]).all()
    assert (way(top + 8 * np.spacing(top)) > length).all()
    assert least.mean() < 0.5


@pytest.mark.parametrize("j", [inf, 1e-3, 1e3, 1e12])
def test_phases_fill_their_length_whatever_the_ratios(j: float, rng: np.random.Generator) -> None:
    """Ratios of 1e12 and more: ways add up, no time is negative, laws never fall."""
    size = 5000
    a, length, cap = 10.0 ** rng.uniform([-6, -6, -6], [6, 4, 6], (size, 3)).T
    jerk = np.full(size, j)
    u = np.minimum(cap, 10.0 ** rng.uniform(-6, 6, size)) * rng.integers(0, 2, size)
    reach = [reachable_speed(*row) for row in zip(u, length, a, jerk, strict=True)]
    w = np.minimum(np.minimum(cap, reach), 10.0 ** rng.uniform(-6, 6, size))
    back = [reachable_speed(*row) for row in zip(w, length, a, jerk, strict=True)]
    u = np.minimum(u, back)
    found = phases(u, w, cap, length, a, jerk)
    assert (found.length >= 0).all()
    assert (found.seconds >= 0).all()
    np.testing.assert_allclose(found.length.sum(axis=1), length, rtol=1e-14)
    total = found.seconds.sum(axis=1)
    assert (total >= length / cap * (1 - 1e-12)).all()
    assert np.isfinite(total).all()
    speeds = np.concatenate([found.u, found.w[:, -1:]], axis=1)
    assert (speeds >= 0).all()
    assert (speeds <= np.maximum(cap, 0)[:, None] * (1 + 1e-12)).all()
    laws = time_law(found.shape.ravel(), found.u.ravel(), found.w.ravel())
    slopes = [laws @ [1, 2 * tau, 3 * tau**2] for tau in np.linspace(0, 1, 11)]
    assert np.min(slopes) >= -2e-15
    np.testing.assert_allclose(laws.sum(axis=1), 1.0, atol=1e-15)


def test_a_vanishing_rise_takes_the_time_it_should() -> None:
    u = np.array([100.0])
    for rise in 10.0 ** np.arange(-12.0, 1.0):
        exact = 2 * np.sqrt(((u + rise) - u) / 1e5)
        np.testing.assert_allclose(ramp_time(u, u + rise, *one(1e3, 1e5)), exact, rtol=1e-15)
