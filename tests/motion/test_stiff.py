"""Stiff and extreme motion: the cases of the numerics study that end in a path, each to its digits.

Samples, arcs of any radius, poses at many turns and clocks that overflow stand in test_samples,
test_path, test_planner and test_poses; lags and ramps in test_servo and test_ramps.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from math import hypot, sqrt

import numpy as np
import pytest
from motion.programs import axes_machine, limited_machine, planned, program, straight_program

from gcodesim.constants import PS_PER_S
from gcodesim.machine.control_data import bare_control
from gcodesim.motion.joint_moves import sub_arcs
from gcodesim.motion.path import ARC_PIECE, arc_displacement
from gcodesim.motion.planner import plan
from gcodesim.nc.control.arcs import centre_from_radius
from gcodesim.nc.control.readings import ArcTolerance
from gcodesim.nc.interpret import interpret
from gcodesim.nc.program import FeedMode, Kind
from gcodesim.study.stability_motion import circle_program, helix_error

FEED, ARC, RAPID = Kind.FEED, Kind.ARC, Kind.RAPID
PROFILES = pytest.mark.parametrize("time", ["constant", "acceleration", "jerk"])


@pytest.mark.slow
@PROFILES
def test_a_million_tenth_micrometre_blocks(time: str) -> None:
    """100 mm at 20 m/min: 0.3 s, and what the ramps add; all block ends are there."""
    x = np.zeros((1_000_000, 6))
    x[:, 0] = np.arange(1, 1_000_001) * 1e-4
    path, _ = plan(straight_program(x, 20_000), limited_machine(time))
    speed, a, j = 20_000 / 60, 5000.0, 5e4
    ramps = {"constant": 0.0, "acceleration": speed / a, "jerk": 2 * sqrt(speed / j)}
    # Jerk: the two units that hold half the way each come to rest no faster than by closed form.
    assert path.duration_s == pytest.approx(0.3 + ramps[time], abs=1e-6 if time != "jerk" else 0.02)
    ends = path.q1[np.append(np.diff(path.line) > 0, True), 0]
    np.testing.assert_array_equal(ends, x[:, 0])
    assert (np.diff(path.bounds_ps) > 0).all()


@PROFILES
@pytest.mark.parametrize("feed", [1e9, 1e-6])
def test_extreme_feeds_stay_finite_and_monotone(time: str, feed: float) -> None:
    rows = [
        {"kind": FEED, "to": (0.01, 0, 0), "f": feed},
        {"kind": ARC, "to": (0.01, 0, 0), "center": (0, 0, 0), "f": feed},
        {"kind": FEED, "to": (0.01, 0, 0, 1e-3), "f": feed},
    ]
    machine = limited_machine(time)
    path, findings = plan(program(rows), machine)
    assert [f.code for f in findings] == (["GC303"] if feed > 1 else [])
    assert path.line[-1] == 3
    assert (np.diff(path.bounds_ps) > 0).all()
    times = np.linspace(0, path.duration_ps, 2001).astype(np.int64)
    steps = np.abs(np.diff(path.positions(times), axis=0)).max(axis=0)
    rates = np.array([joint.rapid for joint in machine.joints])
    assert (steps <= rates * (path.duration_s / 2000) * (1 + 1e-4) + 1e-12).all()
    if time == "constant":
        least = 0.01 / 500 + 0.02 * np.pi / 500 + 1e-3 / 100
        slow = 60 * (0.01 + 0.02 * np.pi + 1e-3) / feed
        assert path.duration_s == pytest.approx(least if feed > 1 else slow, rel=1e-6)


@PROFILES
@pytest.mark.parametrize("minutes", [1e-9, 1e5])
def test_extreme_inverse_times(time: str, minutes: float) -> None:
    row = {"kind": FEED, "to": (1,), "f": 1 / minutes, "mode": FeedMode.INVERSE_TIME}
    path, findings = plan(program([row]), limited_machine(time))
    assert path.q1[-1, 0] == 1.0
    assert path.duration_s >= 60 * minutes * (1 - 1e-12)
    assert path.duration_s <= max(60 * minutes, 1 / 500) + 2.0
    assert [f.code for f in findings] == (["GC303"] if minutes < 1 else [])


@pytest.mark.parametrize("turns", [10, 1000, 1_000_000])
@pytest.mark.parametrize("sense", [1, -1])
def test_helices_of_a_million_turns_keep_their_angle(turns: int, sense: int) -> None:
    """An eighth turn beyond k whole ones; at sixteenths of it all, R = 100, to 1e-12 mm."""
    end = (100 * sqrt(0.5), sense * 100 * sqrt(0.5), -50.0)
    row = {"kind": ARC, "to": end, "center": (0, 0, 0), "turns": sense * (turns + 1), "f": 1e6}
    path, _ = plan(program([row], (100.0, 0, 0, 0, 0, 0)), axes_machine())
    assert tuple(path.q1[-1, :3]) == end
    total = Fraction(8 * turns + 1, 8)  # turns in all
    assert helix_error(path, 0, total) <= 2e-12
    lasts = hypot(2 * np.pi * 100 * float(total), 50) / (1e6 / 60)
    slowest = 2 * np.pi * 100 * float(total) / 500  # X and Y at their rapid rates
    assert path.duration_s == pytest.approx(max(lasts, slowest), rel=1e-9)


@pytest.mark.parametrize("radius", [10.0**k for k in range(-4, 9)])
def test_parts_of_arcs_of_any_radius_add_up(radius: float, rng: np.random.Generator) -> None:
    """To 1e-12 mm on arcs of 1 m at most; a spiral is as good as its radii are stored."""
    growth = 1.000001 if radius <= 1e3 else 1.0
    for _ in range(20):
        u, w = rng.normal(size=(2, 3))
        u /= np.linalg.norm(u)
        n = np.cross(u, w) / np.linalg.norm(np.cross(u, w))
        sweep = np.degrees(10.0 ** rng.uniform(-3, 3) / radius) * rng.choice([-1, 1])
        sweep = np.clip(sweep, -700, 700)
        arc = np.array([(u, np.cross(n, u), 5 * n, radius, radius * growth, sweep)], ARC_PIECE)
        cuts = np.sort(np.append(rng.uniform(0, 1, 6), [0.0, 1.0]))
        parts = sub_arcs(np.repeat(arc, 7), cuts[:-1], cuts[1:])
        moved = np.cumsum(arc_displacement(parts, np.ones(7)), axis=0)
        whole = arc_displacement(np.repeat(arc, 7), cuts[1:])
        assert np.abs(moved - whole).max() <= 1e-12 + 4e-15 * min(radius, 1e3)


@pytest.mark.parametrize("words", ["", "X{x} Y{y} "])
def test_no_full_circle_vanishes(words: str, rng: np.random.Generator) -> None:
    """20,000 circles from any point under any offset: the end words absent, or the same."""
    circles = circle_program(rng.uniform(-500, 500, (20_000, 4)).round(4), words)
    text = f"%\nG21 G90 G17 G94 G54 S100 M3\n{circles}M30\n%"
    meaning = interpret(text, bare_control(None, "fanuc", None, False), "")
    assert not [f for f in meaning.findings if f.severity == "error"]
    path, _ = plan(meaning.program, axes_machine())
    sweeps = path.arcs["sweep"]
    assert len(sweeps) == 20_000
    np.testing.assert_allclose(sweeps, -360.0, rtol=0, atol=1e-9)


def test_rounded_centres_let_the_radius_run_evenly(rng: np.random.Generator) -> None:
    """I and J to 3 decimals: the end is exact and no place is off by more than the radii differ."""
    for _ in range(50):
        radius, begin, sweep = rng.uniform([1, 0, 0.1], [200, 6, 6])
        ends = [radius * np.array([np.cos(x), np.sin(x), 0]) for x in (begin, begin + sweep)]
        start = (*ends[0].round(4), 0, 0, 0)
        end, center = ends[1].round(4), np.array(start[:3]) + (-ends[0]).round(3)
        path, _ = plan(
            program([{"kind": ARC, "to": end, "center": center, "f": 1000}], start), axes_machine()
        )
        radii = [np.linalg.norm(p - center) for p in (np.array(start[:3]), end)]
        s = np.linspace(0, 1, 101)
        q = path.positions_on(np.zeros(101, np.intp), s)[:, :3]
        np.testing.assert_array_equal(q[-1], end)
        away = np.linalg.norm(q - center, axis=1)
        np.testing.assert_allclose(away, radii[0] + s * (radii[1] - radii[0]), atol=1e-12)


@pytest.mark.parametrize("excess", [10.0**-k for k in range(3, 13)])
def test_radius_arcs_near_half_a_circle_keep_their_centre(excess: float) -> None:
    """The height of the centre over the chord, to few roundings; R too short counts as R = c/2."""
    radius = 50.0 + excess
    exact = sqrt(Fraction(radius - 50.0) * (Fraction(radius) + 50))
    u, v = centre_from_radius((0.0, 0.0), (100.0, 0.0), radius, False, ArcTolerance())
    assert u == 50.0
    assert v == pytest.approx(exact, rel=1e-15)
    short = 50.0 - min(excess, 1e-3)
    assert centre_from_radius((0.0, 0.0), (100.0, 0.0), short, False, ArcTolerance()) == (50.0, 0.0)


@pytest.mark.parametrize(("wrap", "way"), [("none", -359.8), ("shortest", 0.2)])
def test_a_wrap_is_read_both_ways(wrap: str, way: float) -> None:
    text = "%\nG21 G90 G94 G54\nG0 C359.9\nC0.1\nC360000359.9\nM30\n%\n"
    control = replace(bare_control(None, "fanuc", None, False), axes="XYZAC", wrap={"C": wrap})
    path, _ = plan(interpret(text, control, "").program, axes_machine())
    c = path.q1[:, 4]
    first = -0.1 if wrap == "shortest" else 359.9
    assert c[0] == pytest.approx(first, abs=1e-12)
    assert path.q1[1, 4] - path.q0[1, 4] == pytest.approx(way, abs=1e-11)
    # A million turns: read as written, or as the way there; never reduced before it is differenced.
    last = 360_000_359.9 - 0.1 if wrap == "none" else -0.2
    assert path.q1[2, 4] - path.q0[2, 4] == pytest.approx(last, abs=1e-6)


@pytest.mark.parametrize("time", ["acceleration", "jerk"])
@pytest.mark.parametrize(("a", "j"), [(1e-3, 1e-3), (1e9, 1e9), (1e9, 1e-3), (1e-3, 1e9)])
def test_limits_apart_by_twelve_powers_of_ten(
    time: str, a: float, j: float, rng: np.random.Generator
) -> None:
    """Phases vanish at one end or the other: no gap, no negative time, block ends exact."""
    to = np.cumsum(10.0 ** rng.uniform(-4, 2, (300, 6)) * rng.choice([0, 1], (300, 6)), axis=0)
    to[:, 4] = 0.0
    text = straight_program(to, 10.0 ** rng.uniform(0, 6, 300))
    path, _ = plan(text, limited_machine(time, a=a, j=j))
    plain, _ = plan(text, axes_machine())
    np.testing.assert_array_equal(path.q0[1:], path.q1[:-1])
    np.testing.assert_array_equal(path.q1[np.append(np.diff(path.line) > 0, True)], plain.q1)
    assert (np.diff(path.bounds_ps) > 0).all()
    assert np.isfinite(path.law).all()
    slopes = [path.law @ [1, 2 * x, 3 * x * x] for x in np.linspace(0, 1, 11)]
    assert np.min(slopes) >= -1e-14
    assert path.duration_ps >= plain.duration_ps - len(path)
    if a == j == 1e9 and time == "acceleration":  # as good as no limit: 1e-6 s to full speed
        assert path.duration_s == pytest.approx(plain.duration_s, abs=300 * 2e-6 + 1e-9)


def test_cycle_time_is_a_sum_of_integers() -> None:
    p = planned(*({"kind": FEED, "to": (k % 7,), "f": 777} for k in range(5000)))
    assert p.duration_ps == sum(np.diff(p.bounds_ps).tolist())
    assert p.duration_s == p.duration_ps / PS_PER_S
