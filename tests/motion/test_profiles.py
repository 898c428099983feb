"""Speeds within limits: times in closed form, limits kept everywhere, stops where they belong."""

from __future__ import annotations

from dataclasses import replace
from math import cbrt, inf, pi, sqrt
from typing import Any

import numpy as np
import pytest
from motion.programs import limited_machine, program, straight_program
from numpy.typing import NDArray

from gcodesim.constants import PS_PER_S
from gcodesim.machine.model import Machine
from gcodesim.motion.path import Path
from gcodesim.motion.planner import plan
from gcodesim.motion.profiles import boundary_speeds
from gcodesim.motion.ramps import reachable_speed
from gcodesim.nc.program import CanonicalProgram, Kind

RAPID, FEED, ARC, DWELL, PATH = Kind.RAPID, Kind.FEED, Kind.ARC, Kind.DWELL, Kind.PATH
A, J = 5000.0, 5e4
TAU = np.linspace(0.0, 1.0, 17)
EXACT_STOP = {"kind": PATH, "aux": 611}
PROFILES = pytest.mark.parametrize("time", ["acceleration", "jerk"])


def planned(time: str, *rows: dict[str, Any]) -> Path:
    return plan(program(rows), limited_machine(time))[0]


def derivatives(path: Path) -> list[NDArray[np.float64]]:
    """s', s'', s''' of every piece over its time at TAU, shape (n, 17) each [1/s, ...]."""
    c1, c2, c3 = (column[:, None] for column in path.law.T)
    seconds = np.diff(path.bounds_ps)[:, None] / PS_PER_S
    slopes = c1 + 2 * c2 * TAU + 3 * c3 * TAU**2, 2 * c2 + 6 * c3 * TAU, 6 * c3 + 0 * TAU
    return [slope / seconds**k for k, slope in enumerate(slopes, start=1)]


def assert_sound(path: Path, machine: Machine) -> None:
    """No gaps, laws that never fall, and every limit of every joint kept on straight pieces."""
    np.testing.assert_array_equal(path.q0[1:], path.q1[:-1])
    assert (np.diff(path.bounds_ps) > 0).all()
    np.testing.assert_allclose(path.law.sum(axis=1), 1.0, atol=1e-15)
    first, second, third = derivatives(path)
    seconds = np.diff(path.bounds_ps) / PS_PER_S
    assert (first * seconds[:, None]).min() >= -1e-15
    straight = (path.arc < 0) & (seconds > 1e-7)  # shorter ones are rounded to 1 ps: 1e-5
    way = np.abs(path.q1 - path.q0)[straight]
    limits = [("rapid", first), ("max_acceleration", second), ("max_jerk", third)]
    for name, slope in limits[: 3 if machine.time == "jerk" else 2]:
        most = np.array([getattr(joint, name) for joint in machine.joints])
        used = way * np.abs(slope[straight]).max(axis=1)[:, None] / most
        assert used.max() <= 1 + 1e-5, name


@pytest.mark.parametrize(
    ("time", "length", "feed", "seconds"),
    [
        ("acceleration", 100, 100, 100 / 100 + 100 / A),
        ("acceleration", 1, 100, 2 * sqrt(1 / A)),
        ("jerk", 100, 100, 100 / 100 + 2 * sqrt(100 / J)),  # never holds the acceleration
        ("jerk", 500, 500, 500 / 500 + 2 * sqrt(500 / J)),
        ("jerk", 0.1, 100, 4 * cbrt(0.1 / (2 * J))),
    ],
)
def test_a_move_from_rest_to_rest_takes_its_closed_form(
    time: str, length: float, feed: float, seconds: float
) -> None:
    path = planned(time, {"kind": FEED, "to": (length,), "f": 60 * feed})
    assert path.duration_s == pytest.approx(seconds, abs=1e-11)
    assert len(path) == len(set(path.bounds_ps.tolist())) - 1


def test_seven_phases_in_closed_form() -> None:
    machine = limited_machine("jerk", a=1000.0, j=2e4)
    path, _ = plan(program([{"kind": FEED, "to": (400,), "f": 60 * 200}]), machine)
    ease, hold = 1000 / 2e4, 200 / 1000 - 1000 / 2e4
    ramp = 2 * ease + hold
    cruise = (400 - 200 * ramp) / 200
    expected = [ease, hold, ease, cruise, ease, hold, ease]
    np.testing.assert_allclose(np.diff(path.bounds_ps) / PS_PER_S, expected, atol=2e-12)
    middle = path.positions(np.array([round(0.5 * ease * PS_PER_S)]))[0, 0]
    assert middle == pytest.approx(2e4 * (0.5 * ease) ** 3 / 6, abs=1e-12)


def random_program(rng: np.random.Generator, count: int) -> CanonicalProgram:
    rows: list[dict[str, Any]] = []
    here = np.zeros(6)
    for _ in range(count):
        kind = rng.choice([RAPID, FEED, ARC, DWELL])
        row: dict[str, Any] = {"kind": kind, "f": 0.1}
        if kind != DWELL:
            size = 10.0 ** rng.uniform(-4, 2)
            row |= {"to": here + size * rng.uniform(-1, 1, 6), "f": 10.0 ** rng.uniform(1, 5)}
            row["to"][4] = 0.0
        if kind == ARC:
            start, sweep = rng.uniform(0, 2 * pi), rng.uniform(0.1, 6)
            ends = [size * np.array([np.cos(x), np.sin(x), 0]) for x in (start, start + sweep)]
            row["center"] = here[:3] - ends[0]
            row["to"][:3] = row["center"] + ends[1]
        here = row.get("to", here)
        rows.append(row)
    return program(rows)


@PROFILES
@pytest.mark.parametrize("seed", range(4))
def test_random_programs_keep_every_limit(time: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    text, machine = random_program(rng, 300), limited_machine(time)
    path, _ = plan(text, machine)
    plain, _ = plan(text, replace(machine, time="constant"))
    assert_sound(path, machine)
    assert path.duration_ps > plain.duration_ps
    # Every block ends where it does without limits, and dwells keep their time.
    last = np.append(np.diff(path.line) > 0, True)
    np.testing.assert_array_equal(path.q1[last], plain.q1)
    still = (plain.q0 == plain.q1).all(axis=1) & (plain.arc < 0)
    lasts = np.diff(path.bounds_ps)[np.isin(path.line, plain.line[still])]
    np.testing.assert_array_equal(lasts, np.diff(plain.bounds_ps)[still])


@PROFILES
def test_arcs_keep_their_circle_and_the_limits_of_its_axes(
    time: str, rng: np.random.Generator
) -> None:
    machine = limited_machine(time)
    for radius in 10.0 ** rng.uniform(-3, 2.5, 12):
        row = {"kind": ARC, "to": (0, 0, 3), "center": (radius, 0, 0), "turns": 2, "f": 25_000}
        path, _ = plan(program([row]), machine)
        # Sub-arcs meet on the circle: the centre seen from any place is one radius away.
        pieces = np.repeat(np.arange(len(path)), len(TAU))
        s = np.tile(TAU, len(path))
        q = path.positions_on(pieces, s)
        np.testing.assert_allclose(
            np.hypot(q[:, 0] - radius, q[:, 1]), radius, rtol=1e-13, atol=1e-13
        )
        times = np.linspace(0, path.duration_ps, 4001).astype(np.int64)
        h = path.duration_s / 4000
        x = path.positions(times)[:, :2]
        assert np.abs(np.diff(x, 2, axis=0)).max() / h**2 <= A * (1 + 1e-3)
        top = np.linalg.norm(np.diff(x, axis=0), axis=1).max() / h
        assert top**2 / radius <= sqrt(0.75) * A * (1 + 1e-3)
        if time == "jerk" and radius > 1.0:  # finite differences of shorter ones drown in rounding
            inner = np.diff(x, 3, axis=0) / h**3
            assert np.abs(inner).max() <= J * (1 + 1e-2)


def speed_at_end(path: Path, line: int) -> float:
    """Speed in X Y Z [mm/s] at the end of a block."""
    piece = np.flatnonzero(path.line == line)[-1]
    first, _, _ = derivatives(path)
    return float(np.linalg.norm((path.q1 - path.q0)[piece, :3]) * first[piece, -1])


SQUARE = [
    {"kind": FEED, "to": (100, 0), "f": 6000},
    {"kind": FEED, "to": (100, 100), "f": 6000},
]
STRAIGHT = [{"kind": FEED, "to": (100, 0), "f": 6000}, {"kind": FEED, "to": (200, 0), "f": 6000}]


@PROFILES
def test_corners_stop_and_straight_on_does_not(time: str) -> None:
    assert speed_at_end(planned(time, *SQUARE), 1) == pytest.approx(0.0, abs=1e-12)
    assert speed_at_end(planned(time, *STRAIGHT), 1) == pytest.approx(100.0)
    round_the_corner = [
        STRAIGHT[0],
        {"kind": ARC, "to": (120, 20), "center": (100, 20, 0), "f": 6000},
    ]
    assert speed_at_end(planned(time, *round_the_corner), 1) == pytest.approx(100.0)


@PROFILES
@pytest.mark.parametrize("between", [{"kind": DWELL, "f": 0.5}, {"kind": Kind.TOOL, "aux": 2},
                                     {"kind": Kind.STOP, "aux": 0}])  # fmt: skip
def test_what_stands_between_two_moves_stops_them(time: str, between: dict[str, Any]) -> None:
    path = planned(time, STRAIGHT[0], between, STRAIGHT[1])
    assert speed_at_end(path, 1) == pytest.approx(0.0, abs=1e-12)
    path = planned(time, STRAIGHT[0], {"kind": Kind.MESSAGE}, STRAIGHT[1])
    assert speed_at_end(path, 1) > 99.0


@PROFILES
def test_exact_stop_ends_every_block_at_rest(time: str) -> None:
    path = planned(time, EXACT_STOP, *STRAIGHT, {"kind": PATH, "aux": 610}, *SQUARE)
    assert speed_at_end(path, 2) == pytest.approx(0.0, abs=1e-12)
    assert speed_at_end(path, 3) == pytest.approx(0.0, abs=1e-12)  # G61.1 is in force up to here
    alone = planned(time, STRAIGHT[0]).duration_ps
    assert path.bounds_ps[np.flatnonzero(path.line == 2)[-1] + 1] == alone


@PROFILES
@pytest.mark.parametrize("tolerance", [0.05, 0.5])
def test_a_tolerance_gives_the_corner_its_speed(time: str, tolerance: float) -> None:
    mode = {"kind": PATH, "aux": 640, "f": tolerance}
    sine = sqrt(0.5)
    expected = sqrt(A * tolerance * sine / (1 - sine))
    assert speed_at_end(planned(time, mode, *SQUARE), 2) == pytest.approx(min(expected, 100.0))
    machine = replace(limited_machine(time), path_tolerance={"G64": tolerance, "rapid": None})
    by_file, _ = plan(program(SQUARE), machine)
    assert speed_at_end(by_file, 1) == pytest.approx(min(expected, 100.0))
    rapids = [{**row, "kind": RAPID} for row in SQUARE]
    assert speed_at_end(plan(program(rapids), machine)[0], 1) == pytest.approx(0.0, abs=1e-12)


@PROFILES
def test_a_circle_of_chords_runs_as_fast_as_the_circle(time: str) -> None:
    angle = np.linspace(0, 2 * pi, 3601)[1:]
    to = np.zeros((3600, 6))
    to[:, :2] = 40 * np.stack([np.sin(angle), 1 - np.cos(angle)], axis=1)
    machine = limited_machine(time)
    chords, _ = plan(straight_program(to, 6000), machine)
    assert_sound(chords, machine)
    circle = planned(time, {"kind": ARC, "to": (0, 0), "center": (0, 40, 0), "f": 6000})
    assert chords.duration_s == pytest.approx(circle.duration_s, rel=0.05)


@PROFILES
def test_the_look_ahead_brakes_over_many_blocks(time: str) -> None:
    """300 mm/s in blocks of 1 mm, then a corner: braking takes 9 of them at least."""
    to = np.zeros((200, 6))
    to[:, 0] = np.minimum(np.arange(1, 201), 150)
    to[150:, 1] = np.arange(1, 51)
    machine = limited_machine(time)
    path, _ = plan(straight_program(to, 18_000), machine)
    assert_sound(path, machine)
    speeds = [speed_at_end(path, line) for line in range(1, 151)]
    assert speeds[-1] == pytest.approx(0.0, abs=1e-12)
    assert max(speeds) > 200.0
    braking = np.arange(150 - len(speeds) + 1, 151)[np.array(speeds) > 1e-9]
    room = 150 - braking
    assert (np.array(speeds)[braking - 1] ** 2 <= 2 * A * room * (1 + 1e-9)).all()


@PROFILES
def test_programs_that_hardly_move(time: str) -> None:
    assert len(planned(time)) == 0
    assert planned(time, {"kind": DWELL, "f": 2.0}).duration_s == 2.0
    far = {"kind": FEED, "to": (1e5,), "f": 1e-300}
    path, findings = plan(program([STRAIGHT[0], far]), limited_machine(time))
    assert [finding.code for finding in findings] == ["GC424"]
    assert set(path.line.tolist()) == {1}


@pytest.mark.parametrize("j", [inf, J])
@pytest.mark.parametrize("length", [1e-4, 1e-2, 1.0, 100.0])
@pytest.mark.parametrize("stops", [0.5, 0.01, 0.0])
def test_speeds_at_boundaries_are_those_of_one_sweep_each_way(
    j: float, length: float, stops: float, rng: np.random.Generator
) -> None:
    """Chains of one unit to thousands, begun everywhere or at the ends only."""
    n = 3000
    way = length * rng.uniform(0.5, 2.0, n)
    between = rng.uniform(20, 300, n - 1) * (rng.random(n - 1) >= stops)
    a = rng.choice([A, A / 5], n)
    speed = [0.0, *between.tolist(), 0.0]
    for i in reversed(range(1, n)):
        speed[i] = min(speed[i], max(speed[i + 1], reachable_speed(speed[i + 1], way[i], a[i], j)))
    for i in range(n - 1):
        speed[i + 1] = min(speed[i + 1], max(speed[i], reachable_speed(speed[i], way[i], a[i], j)))
    found = boundary_speeds(way, between, a, np.full(n, j))
    np.testing.assert_allclose(found, speed, rtol=1e-14)
