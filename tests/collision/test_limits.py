"""Limits over time: none is missed, none is reported too early, however the path is cut."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from collision.random_programs import Setup, cut_up, random_trial
from numpy.typing import NDArray

from gcodesim.checking.flow import check_program
from gcodesim.checking.options import Options
from gcodesim.checking.verdict import CheckResult
from gcodesim.collision.bodies.keys import NO_CONTACT, contact_key
from gcodesim.collision.bodies.scene import build_scene
from gcodesim.collision.bounds.departure import Departures, departures
from gcodesim.collision.bounds.forest import build_forest
from gcodesim.collision.bounds.motion_bounds import travelled
from gcodesim.collision.geometry.poses import path_arrays
from gcodesim.collision.search.approach import distances_at, nearest_at
from gcodesim.collision.search.clearance import every_place
from gcodesim.collision.search.first_reach import LEFT_OUT, Limits, Reach, first_reached
from gcodesim.collision.search.intervals import contact_intervals
from gcodesim.collision.search.search import Searcher, SearchSettings
from gcodesim.collision.search.search_kernel import MODE_AT_ALL_TIMES
from gcodesim.machine.loading import load_machine
from gcodesim.machine.model import Servo
from gcodesim.machine.spindle import bodies_in_place
from gcodesim.motion.lag import lag_over_time
from gcodesim.motion.off_path import OffPath
from gcodesim.motion.path import Path as MotionPath
from gcodesim.motion.samples import Span
from gcodesim.motion.servo import servo_deviation
from gcodesim.nc.lines import read_program
from gcodesim.policy.policy import Policy

INSTANTS = 1500
GOOD_TO = 1e-6
CUTS = [
    Setup(level=0, chunk=7, batch=4),
    Setup(level=3, chunk=16, batch=8, threads=2),
    Setup(level=5, chunk=512),
]


class Case(NamedTuple):
    """A searcher of a random program whose joints lag, and how far its pairs may be off."""

    searcher: Searcher
    departures: Departures
    clearances: tuple[float, ...]


def random_case(seed: int) -> Case:
    rng = np.random.default_rng([31, seed])
    trial = random_trial(seed, rng.uniform(0, 90))
    path, m = trial.path, trial.machine
    constant = 10.0 ** rng.uniform(-3, -0.5)
    servos = (Servo(1, constant), Servo(2, constant, rng.uniform(0.3, 2.0)), None)
    m = replace(m, joints=tuple(replace(j, servo=servos[rng.integers(3)]) for j in m.joints))
    bodies = bodies_in_place(m, 1)
    scene = build_scene(m.pairs, bodies, m.joints, "cpu")
    joints = travelled(m.joints, path)
    off = OffPath(
        float(rng.choice([0.0, 0.3])),
        tuple(servo_deviation(path, m).tolist()),
        lag_over_time(path, m),
    )
    free = (0.0,) * len(m.pairs)
    settings = SearchSettings(trial.period_ps, MODE_AT_ALL_TIMES, free, 2)
    forest = build_forest(scene, joints)
    searcher = Searcher(scene, forest, path, path_arrays(path, "cpu"), joints, settings)
    clearances = rng.choice([LEFT_OUT, 0.0, 1.0, 10.0], len(m.pairs), p=[0.1, 0.5, 0.2, 0.2])
    return Case(searcher, departures(scene, joints, off), tuple(clearances.tolist()))


def limit_at(case: Case, pair: int, times: NDArray[np.int64]) -> NDArray[np.float64]:
    return case.clearances[pair] + case.departures.over(pair, times - 1, times)


@pytest.mark.parametrize("seed", range(24))
def test_the_first_time_at_a_limit_is_neither_missed_nor_reported_too_early(seed: int) -> None:
    case = random_case(seed)
    searcher, path = case.searcher, case.searcher.path
    limits = Limits(case.clearances, case.departures)
    found = first_reached(searcher, limits, 0, len(path), NO_CONTACT)
    rng = np.random.default_rng([32, seed])
    times = np.unique(rng.integers(1, path.duration_ps, INSTANTS))
    for pair, asked in enumerate(case.clearances):
        if asked < 0.0:
            assert pair not in found
            continue
        distance = distances_at(searcher, pair, times)
        reached = times[distance <= limit_at(case, pair, times) - GOOD_TO]
        if len(reached):
            assert found[pair].time_ps <= reached[0]
        if pair in found:
            _assert_not_too_early(case, pair, found[pair])


def _assert_not_too_early(case: Case, pair: int, reach: Reach) -> None:
    """The pair is at the limit then, and that is the largest of the sample step."""
    searcher, bounds = case.searcher, case.searcher.path.bounds_ps
    time = np.array([reach.time_ps])
    assert nearest_at(searcher, pair, reach.time_ps).distance <= reach.limit + GOOD_TO
    piece = searcher.path.piece_at(time)
    period = searcher.settings.period_ps
    start = np.maximum((time - 1) // period * period, bounds[piece])
    end = np.minimum(start // period * period + period, bounds[piece + 1])
    step = case.clearances[pair] + case.departures.over(pair, start, end)[0]
    assert reach.limit == pytest.approx(step, rel=1e-12)
    assert reach.departure == pytest.approx(reach.limit - case.clearances[pair])


def started(path: MotionPath, time_ps: int) -> int:
    """When the piece of a time began [ps]."""
    return int(path.bounds_ps[path.piece_at(np.array([time_ps]))[0]])


@pytest.mark.parametrize("seed", range(24))
def test_every_place_that_is_too_near_is_reported_once(seed: int) -> None:
    case = random_case(seed)
    searcher, path = case.searcher, case.searcher.path
    contacts = contact_intervals(searcher, Span(0, path.duration_ps, None, 0))
    stretch = (0, len(path))
    places = every_place(searcher, case.clearances, case.departures, stretch, contacts)
    times = np.unique(np.random.default_rng([33, seed]).integers(1, path.duration_ps, INSTANTS))
    for pair, asked in enumerate(case.clearances):
        # A touch that is not excluded is reported in place of a clearance that is lost before.
        begins = [p for p in places if p.pair == pair and not p.continues]
        stretches = [(started(path, p.time_ps), p.end_ps) for p in begins]
        assert asked >= 0.0 or not stretches
        assert all(end <= later for (_, end), (later, _) in pairwise(stretches))
        touching = [(c.start_ps, c.end_ps) for c in contacts if c.pair == pair]
        if asked < 0.0 or touching:
            continue
        reached = distances_at(searcher, pair, times) <= limit_at(case, pair, times) - GOOD_TO
        assert all(any(a <= t <= b for a, b in stretches) for t in times[reached].tolist())


def test_two_places_of_one_pair(tmp_path: Path) -> None:
    """2 mm above the table, up, and 1.5 mm above it: a clearance of 3 mm is lost twice."""
    lead, down = "G21 G90 G94 G54\nT1 M6\nG0 X0 Y0\nG43 H1 Z50\n", "G1 Z2 F3000"
    text = f"{lead}{down}\nX20\nG0 Z50\nG1 Z1.5\nX0\nG0 Z60\nM30\n"
    (tmp_path / "two.nc").write_text(text)
    ignored = text.replace(down, f"{down} (gcodesim: ignore GC201)")
    (tmp_path / "one.nc").write_text(ignored)
    model, policy = load_machine("table_tilt"), Policy(fail_on="warning")

    def judged(name: str, stop_all: bool) -> CheckResult:
        options = Options(clearance=3.0, stop_all=stop_all)
        text = read_program(tmp_path / name)
        result = check_program(text, name, model, options)
        return policy.apply(result, text, stop_all=stop_all)

    def lines(name: str, stop_all: bool) -> list[int | None]:
        return [f.line for f in judged(name, stop_all).findings if f.code == "GC201"]

    assert lines("two.nc", False) == [5]
    assert lines("two.nc", True) == [5, 8]
    assert judged("one.nc", False).verdict == "inconclusive"
    assert judged("one.nc", True).verdict == "fail"


@pytest.mark.parametrize("seed", range(12))
def test_cutting_the_path_up_changes_nothing(seed: int) -> None:
    case = random_case(seed)
    limits, path = Limits(case.clearances, case.departures), case.searcher.path
    whole = first_reached(case.searcher, limits, 0, len(path), NO_CONTACT)
    for setup in CUTS:
        with cut_up(setup):
            assert first_reached(case.searcher, limits, 0, len(path), NO_CONTACT) == whole
    for pair, reach in whole.items():
        before = contact_key(reach.time_ps // case.searcher.settings.period_ps - 1, pair)
        early = first_reached(case.searcher, limits, 0, len(path), max(before, 0))
        assert pair not in early
