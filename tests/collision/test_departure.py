"""Departure: the bound holds for random machines, and widens what is reported."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from collision.chord_bounds import random_chords

from gcodesim.collision.bounds import common_frame, travelled
from gcodesim.collision.departure import departures, largest_step
from gcodesim.flow import Options, check_program
from gcodesim.machine.kinematics import world_from_link
from gcodesim.machine.model import Joint, Machine, Servo
from gcodesim.motion.off_path import OffPath
from gcodesim.study.scenes import box, machine

INSTANTS = 40
PERIOD_PS = 10**8
GAP_MM = 0.5


@pytest.mark.parametrize("seed", range(12))
def test_no_body_departs_farther(seed: int) -> None:
    rng = np.random.default_rng([11, seed])
    case = random_chords(rng)
    m, scene, path = case.machine, case.scene, case.path
    lag = 10.0 ** rng.uniform(-4, 1, len(m.joints))
    bounds = departures(scene, travelled(m.joints, path), OffPath(0.0, tuple(lag)))
    times = rng.integers(0, path.duration_ps, INSTANTS)
    q = path.positions(times)
    off = q + lag * rng.choice([-1.0, 1.0, 0.3], q.shape)
    there, here = world_from_link(m, off), world_from_link(m, q)
    used = 0.0
    for shapes, links, bound in zip(scene.shapes, scene.links, bounds, strict=True):
        frame, moved = common_frame(m.joints, *links), np.zeros(INSTANTS)
        for shape, link in zip(shapes, links, strict=True):
            points = shape.regions.triangles.reshape(-1, 3)
            posed = [
                points @ seen[:, :3, :3].transpose(0, 2, 1) + seen[:, None, :3, 3]
                for seen in (np.linalg.inv(w[frame]) @ w[link] for w in (there, here))
            ]
            moved += np.linalg.norm(posed[0] - posed[1], axis=2).max(axis=1)
        assert moved.max() <= bound + 1e-9
        used = max(used, float(moved.max() / bound)) if bound else used
    assert used > 0.2  # no bound so wide that it says nothing


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
