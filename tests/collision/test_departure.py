"""Departure: the bound holds for random machines, and widens what is reported."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from collision.chord_bounds import Chords, random_chords

from gcodesim.checking.flow import check_program
from gcodesim.checking.options import Options
from gcodesim.checking.verdict import CheckResult
from gcodesim.collision.bounds.departure import departures, largest_step
from gcodesim.collision.bounds.motion_bounds import common_frame, travelled
from gcodesim.collision.detector import Task, detect
from gcodesim.collision.search.span_search import Aims
from gcodesim.machine.kinematics import world_from_link
from gcodesim.machine.model import Joint, Machine, Servo
from gcodesim.motion.lag import lag_over_time
from gcodesim.motion.off_path import OffPath
from gcodesim.motion.servo import lagged_positions, servo_deviation
from gcodesim.study.scenes import Array, box, joint, machine, path

INSTANTS = 40
PERIOD_PS = 10**8
GAP_MM = 0.5


@pytest.mark.parametrize("seed", range(12))
def test_no_body_departs_farther(seed: int) -> None:
    rng = np.random.default_rng([11, seed])
    case = random_chords(rng)
    m, scene, path = case.machine, case.scene, case.path
    lag = 10.0 ** rng.uniform(-4, 1, len(m.joints))
    bounds = departures(scene, travelled(m.joints, path), OffPath(0.0, tuple(lag))).largest
    times = rng.integers(0, path.duration_ps, INSTANTS)
    q = path.positions(times)
    off = q + lag * rng.choice([-1.0, 1.0, 0.3], q.shape)
    used = 0.0
    for moved, bound in zip(departed(case, q, off), bounds, strict=True):
        assert moved.max() <= bound + 1e-9
        used = max(used, float(moved.max() / bound)) if bound else used
    assert used > 0.2  # no bound so wide that it says nothing


def departed(case: Chords, here: Array, there: Array) -> Iterator[Array]:
    """How far the vertices of each pair are apart for two sets of joint positions, at most."""
    m = case.machine
    worlds = world_from_link(m, there), world_from_link(m, here)
    for shapes, links in zip(case.scene.shapes, case.scene.links, strict=True):
        frame, moved = common_frame(m.joints, *links), np.zeros(len(here))
        for shape, link in zip(shapes, links, strict=True):
            points = shape.regions.triangles.reshape(-1, 3)
            posed = [
                points @ seen[:, :3, :3].transpose(0, 2, 1) + seen[:, None, :3, 3]
                for seen in (np.linalg.inv(w[frame]) @ w[link] for w in worlds)
            ]
            moved += np.linalg.norm(posed[0] - posed[1], axis=2).max(axis=1)
        yield moved


@pytest.mark.parametrize("seed", range(8))
def test_no_body_lags_farther_at_any_time(seed: int) -> None:
    """The exact lagged motion against the bound of each instant, drives of 1 ns to 10 s."""
    rng = np.random.default_rng([13, seed])
    case = random_chords(rng)
    path = case.path
    constants = 10.0 ** rng.uniform(-9, 1, len(case.machine.joints))
    servos = [Servo(int(rng.integers(1, 3)), t, rng.uniform(0.3, 3)) for t in constants]
    joints = zip(case.machine.joints, servos, strict=True)
    m = replace(case.machine, joints=tuple(replace(j, servo=s) for j, s in joints))
    lag = tuple(servo_deviation(path, m).tolist())
    off = OffPath(0.0, lag, lag_over_time(path, m))
    bounds = departures(case.scene, travelled(m.joints, path), off)
    times = np.unique(rng.integers(1, path.duration_ps, INSTANTS))
    really = lagged_positions(path, m, times)
    for pair, moved in enumerate(departed(case, path.positions(times), really)):
        assert (moved <= bounds.over(pair, times - 1, times) + 1e-6).all()
        assert (bounds.over(pair, times - 1, times) <= bounds.largest[pair]).all()


@pytest.mark.parametrize("seed", range(8))
def test_no_vertex_steps_farther_from_sample_to_sample(seed: int) -> None:
    rng = np.random.default_rng([12, seed])
    case = random_chords(rng)
    m, scene, path = case.machine, case.scene, case.path
    step = largest_step(scene, travelled(m.joints, path), path, slice(None), PERIOD_PS)
    assert step is not None
    piece = rng.integers(0, len(path), INSTANTS)
    starts = path.bounds_ps[piece] + 1
    ends = np.minimum(starts + PERIOD_PS, path.bounds_ps[piece + 1])
    seen = [world_from_link(m, path.positions(times)) for times in (starts, ends)]
    largest = 0.0
    for shapes, links in zip(scene.shapes, scene.links, strict=True):
        frame, moved = common_frame(m.joints, *links), np.zeros(INSTANTS)
        for shape, link in zip(shapes, links, strict=True):
            points = shape.regions.triangles.reshape(-1, 3)
            posed = [
                points @ pose[:, :3, :3].transpose(0, 2, 1) + pose[:, None, :3, 3]
                for pose in (np.linalg.inv(w[frame]) @ w[link] for w in seen)
            ]
            moved += np.linalg.norm(posed[0] - posed[1], axis=2).max(axis=1)
        largest = max(largest, float(moved.max()))
    assert 0.01 * step.distance < largest <= step.distance * (1.0 + 1e-9)


def passing_by() -> Machine:
    """A cube that passes another one with a gap of half a millimetre, 100 mm/s."""
    slide = Joint(
        "X",
        rotary=False,
        parent="bed",
        child="X",
        axis=np.array([1.0, 0, 0]),
        point=np.zeros(3),
        lower=-500.0,
        upper=500.0,
        rapid=1000.0,
    )
    shapes = {"bed": box([10, 10, 10]) + [0, 10.0 + GAP_MM, 0], "X": box([10, 10, 10])}
    return replace(machine([slide], shapes, [("bed", "X")]), start={"X": -100.0})


PROGRAM = "G21 G90 G94\nG64 P{p}\nG1 X100. F6000.\nX-100.\nM30\n"


def outcome(m: Machine, p: float, clearance: float | None = None) -> list[tuple[str, float]]:
    options = Options(device="cpu", clearance=clearance)
    result = check_program(PROGRAM.format(p=p), "passing.nc", m, options)
    assert result.verdict == "pass"
    return [(f.code, f.time_s or 0.0) for f in result.findings if f.code.startswith("GC2")]


def test_path_tolerance_widens_what_must_be_free() -> None:
    m = passing_by()
    assert outcome(m, GAP_MM - 1e-6) == []
    [(code, time_s)] = outcome(m, GAP_MM + 1e-6)
    assert code == "GC202"
    # From X-100 at 100 mm/s the faces overlap along X from X-10 on.
    assert time_s == pytest.approx(0.9, abs=1e-4)


def test_clearance_and_path_tolerance_add_up() -> None:
    m = passing_by()
    assert outcome(m, 0.2, clearance=0.3 - 1e-6) == []
    assert [code for code, _ in outcome(m, 0.2, clearance=0.3 + 1e-6)] == ["GC201"]


def test_lag_of_a_drive_widens_along_its_axis_too() -> None:
    m = passing_by()
    # At 100 mm/s a first-order drive stays 100 mm/s times its time constant behind.
    for constant, codes in ((0.0049, []), (0.0051, ["GC202"])):
        lagging = replace(m, joints=(replace(m.joints[0], servo=Servo(1, constant)),))
        options = Options(device="cpu")
        text = PROGRAM.format(p=0).replace("G64 P0\n", "")
        result = check_program(text, "lag.nc", lagging, options)
        assert [f.code for f in result.findings if f.code.startswith("GC2")] == codes
        assert any("lag of the drives" in line for line in result.coverage.off_path)


TAU, FEED_MM_S, RAPID_MM_S = 0.05, 50.0, 100.0


def beside_a_fixture(tau: float, rapid: float) -> Machine:
    """A cube on X, Y and Z beside another; from Y0 the faces that look at each other are Y apart.

    All joints lag by a first-order drive.
    """
    servo = Servo(1, tau)
    slides = [
        replace(joint(name, axis, parent, child, rapid=rapid), servo=servo)
        for name, axis, parent, child in (
            ("X", [1, 0, 0], "bed", "X"),
            ("Y", [0, 1, 0], "X", "Y"),
            ("Z", [0, 0, 1], "Y", "Z"),
        )
    ]
    shapes = {"bed": box([10, 10, 10]), "Z": box([10, 10, 10]) + [0.0, 10.0, 0.0]}
    return machine(slides, shapes, [("bed", "Z")])


def checked(m: Machine, blocks: str, clearance: float | None = None) -> CheckResult:
    options = Options(device="cpu", clearance=clearance)
    result = check_program(f"G21 G90 G94\nG61\n{blocks}M30\n", "a.nc", m, options)
    assert result.verdict == "pass"
    return result


def alarms(m: Machine, blocks: str, clearance: float | None = None) -> list[tuple[str, float]]:
    found = checked(m, blocks, clearance).findings
    return [(f.code, f.time_s or 0.0) for f in found if f.code.startswith("GC2")]


def real_gap(m: Machine, blocks: str) -> float:
    """Smallest distance of the two cubes as the lagging joints really move [mm], scanned."""
    replay = checked(m, blocks).replay
    assert replay
    path = replay.path
    times = np.linspace(0, path.duration_ps, 200_001).astype(np.int64)
    apart = np.abs(lagged_positions(path, m, times) + [0.0, 10.0, 0.0]) - 10.0
    return float(np.linalg.norm(np.maximum(apart, 0.0), axis=1).min())


SLOW_CUT = "G0 Z100\nG0 X60 Y0.5\nG1 Z0 F600\nX-60\nZ100\nG0 X0\n"


def test_lag_of_a_rapid_does_not_widen_a_slow_cut() -> None:
    """10 ms behind: 5 mm in rapids at 30 m/min, 0.1 mm in the cut 0.5 mm beside the fixture."""
    m = replace(beside_a_fixture(0.01, 500.0), start={"Y": 50.0})
    blocks = SLOW_CUT
    assert alarms(m, blocks) == []
    assert alarms(m, blocks, clearance=0.39) == []
    [(code, time_s)] = alarms(m, blocks, clearance=0.41)
    assert code == "GC201"
    assert real_gap(m, blocks) > 0.4
    # It is lost in the cut, along Y10 at the top of the fixture, not in the rapids.
    assert time_s > 9.0


def test_lag_that_has_not_died_out_is_found_when_it_is_reached() -> None:
    """A rapid along the fixture, then a feed towards it, from 5.5 to 3 mm; dwells are in ms."""
    m = replace(beside_a_fixture(TAU, RAPID_MM_S), start={"X": 200.0, "Y": 5.5})
    towards = f"G1 Y3 F{60 * FEED_MM_S:g}\n"
    # The rapid is 2 s long. At t after it the gap is 5.5 - 50 t, the bound 2.5 + 2.5 exp(-t/tau).
    t = 0.0
    for _ in range(100):
        t = (3.0 - RAPID_MM_S * TAU * 0.5 * np.exp(-t / TAU)) / FEED_MM_S
    [(code, time_s)] = alarms(m, "G0 X0\n" + towards)
    assert code == "GC202"
    # A step counts with the largest lag of each joint in it: some steps too early, never late.
    assert -3e-4 < time_s - (2.0 + t) <= 1e-9
    assert alarms(m, "G0 X0\nG4 P1000\n" + towards) == []
    assert len(alarms(m, "G0 X0\nG4 P10\n" + towards)) == 1
    assert alarms(m, "G0 X0\nG4 P50\n" + towards) == []


@pytest.mark.parametrize("deviation", [0.0, 1e-3])
def test_what_a_path_stands_for_keeps_the_clearance_too(deviation: float) -> None:
    """Chords of a tip move pass at 0.3 mm; the true way may be nearer by their deviation."""
    m, slide = passing_by(), joint("X", [1, 0, 0], "bed", "X", rapid=1e3)
    p = replace(path([slide], [-100.0], [(2.0, [100.0])]), deviation_mm=deviation)
    aims = Aims(clearance=GAP_MM - 0.5e-3)
    found = detect(Task(p, m, 10**8, "cpu", "search", aims, lambda done: None))
    near = [n for span in found.findings for _, n in span.too_near]
    expected = [(pytest.approx(deviation), False)] if deviation else []
    assert [(n.departure, n.touch) for n in near] == expected
