"""The path in NumPy: arcs against 40 digits, time laws against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from collision.scenes import random_joints, random_path, unit
from motion.programs import planned
from numpy.typing import NDArray

from gcodesim.motion.path import ARC_PIECE, arc_displacement
from gcodesim.nc.program import Kind
from gcodesim.study.exact_motion import exact_displacement
from gcodesim.study.scenes import ACCELERATED, JERKED, joint, path


def plane(rng: np.random.Generator) -> tuple[NDArray[np.float64], ...]:
    u, w = unit(rng), unit(rng)
    n = np.cross(u, w) / np.linalg.norm(np.cross(u, w))
    return u, np.cross(n, u), n


@pytest.mark.parametrize("radius", [10.0**k for k in range(-4, 9)])
def test_arcs_of_any_radius_keep_their_digits(radius: float, rng: np.random.Generator) -> None:
    for _ in range(20):
        u, v, n = plane(rng)
        # Lengths from 1e-4 of the radius to three turns; the longest arcs of 1e8 mm are 0.1 mm.
        sweep = rng.choice([-1, 1]) * 10.0 ** rng.uniform(-9 if radius > 1 else -3, 3)
        growth = rng.choice([0.0, 1e-6, -0.3])
        lift = n * rng.choice([0.0, radius * np.radians(abs(sweep))])
        arc = np.array([(u, v, lift, radius, radius * (1 + growth), sweep)], ARC_PIECE)
        for s in (1e-3, rng.uniform(0, 1), 1.0):
            exact = exact_displacement(arc[0], s)
            found = arc_displacement(arc, np.array([s]))[0]
            # What the arc covers up to s: near full turns the displacement itself is far smaller.
            scale = min(radius, radius * np.radians(abs(sweep)) * s) + np.linalg.norm(exact)
            assert np.abs(found - exact).max() <= 1e-14 * scale + 3e-16 * abs(sweep) * s * radius


@pytest.mark.parametrize("turns", [10, 1000])
def test_many_turns_of_a_helix_stay_on_the_cylinder(turns: int) -> None:
    arc = np.array(
        [((1, 0, 0), (0, 1, 0), (0, 0, -50.0), 10.0, 10.0, 360.0 * turns + 77)], ARC_PIECE
    )
    for s in np.linspace(0.01, 1, 23):
        found = arc_displacement(arc, np.array([s]))[0]
        np.testing.assert_allclose(found, exact_displacement(arc[0], s), rtol=0, atol=1e-14 * turns)


@pytest.mark.parametrize("radius", [1e-4, 1e-2, 1.0, 1e3, 1e6])
def test_planned_arcs_end_where_the_program_says(radius: float, rng: np.random.Generator) -> None:
    for _ in range(20):
        start, end = rng.uniform(0, 2 * np.pi, 2)
        center = rng.uniform(-500, 500, 3)
        points = [center + radius * np.array([np.cos(a), np.sin(a), 0]) for a in (start, end)]
        turns = int(rng.choice([-2, -1, 1, 2]))
        p = planned(
            {"kind": Kind.FEED, "to": points[0], "f": 1e5},
            {"kind": Kind.ARC, "to": points[1], "center": center, "turns": turns, "f": 1000},
        )
        before, after = p.positions_on(np.array([1, 1]), np.array([1 - 1e-15, 1.0]))
        np.testing.assert_array_equal(after[:3], points[1])
        slip = 1e-15 * np.radians(abs(p.arcs["sweep"][0])) * radius
        assert np.abs(before - after).max() <= slip + 1e-15 * radius * 10 + 5e-13
        middle = p.positions_on(np.array([1]), np.array([0.37]))[0, :3]
        assert np.linalg.norm(middle - center) == pytest.approx(radius, abs=1e-12 + 1e-12 * radius)


def test_full_circle_comes_back_and_a_spiral_grows_steadily() -> None:
    p = planned(
        {"kind": Kind.ARC, "to": (0, 0), "center": (10, 0, 0), "f": 1000},
        {"kind": Kind.ARC, "to": (20.001, 0), "center": (10, 0, 0), "turns": -1, "f": 1000},
    )
    assert p.arcs["sweep"].tolist() == [360.0, -180.0]
    half = p.positions_on(np.array([0, 1]), np.array([0.5, 0.5]))[:, :3]
    np.testing.assert_allclose(half, [[20, 0, 0], [10, 10.0005, 0]], atol=1e-12)


def test_time_laws_in_closed_form() -> None:
    joints = [joint("X", [1, 0, 0]), joint("C", [0, 0, 1], "mover", "table")]
    times = np.array([0, 1, 10**9, 25 * 10**9, 10**11 - 1, 10**11])
    tau = times / 1e11
    for law, power in (((1.0, 0.0, 0.0), 1), (ACCELERATED, 2), (JERKED, 3)):
        p = path(joints, [3.0, 350.0], [(0.1, [28.0, 375.0])], law)
        found = p.positions(times)
        np.testing.assert_allclose(found[:, 0], 3 + 25 * tau**power, rtol=2e-16 * 4)
        np.testing.assert_allclose(found[:, 1], 350 + 25 * tau**power, rtol=2e-16 * 4)


def test_a_boundary_belongs_to_the_piece_that_ends_there(rng: np.random.Generator) -> None:
    p = random_path(rng, random_joints(rng), 50)
    inner = p.bounds_ps[1:-1]
    np.testing.assert_array_equal(p.piece_at(inner), np.arange(len(p) - 1))
    np.testing.assert_array_equal(p.piece_at(inner + 1), np.arange(1, len(p)))
    assert p.piece_at(np.array([0, p.duration_ps, p.duration_ps + 5])).tolist() == [0, 49, 49]
    np.testing.assert_array_equal(p.positions(p.bounds_ps[1:]), p.q1)
    np.testing.assert_array_equal(p.positions(p.bounds_ps[:1]), p.q0[:1])
    # Neither side of a boundary jumps: a picosecond moves no joint by more than a nanometre.
    for beside in (inner - 1, inner + 1):
        assert np.abs(p.positions(beside) - p.positions(inner)).max() < 1e-6
