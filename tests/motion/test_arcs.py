"""Arcs: how fast an axis runs on them, and how far out it comes, against dense sampling."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from motion.programs import RAPID_MM_S, axes_machine, program
from numpy.typing import NDArray

from gcodesim.motion.arc_moves import steepest_rises
from gcodesim.motion.overtravel import position_ranges
from gcodesim.motion.path import ARC_PIECE, CONSTANT_SPEED, Path, arc_displacement
from gcodesim.motion.planner import plan
from gcodesim.nc.program import Kind

DENSE = np.linspace(0.0, 1.0, 20_001)


def random_arcs(rng: np.random.Generator, count: int, growth: float) -> NDArray[np.void]:
    """Arcs in any plane, up to three turns, climbing, with radii that differ by up to `growth`."""
    arcs = np.zeros(count, ARC_PIECE)
    axes, _ = np.linalg.qr(rng.normal(size=(count, 3, 3)))
    arcs["u"], arcs["v"] = axes[:, 0], axes[:, 1]
    climbing = rng.random(count) < 0.5
    arcs["lift"] = axes[:, 2] * np.where(climbing, rng.uniform(-60, 60, count), 0.0)[:, None]
    arcs["r0"] = rng.uniform(1, 50, count)
    arcs["r1"] = arcs["r0"] * (1.0 + growth * rng.uniform(-1, 1, count))
    arcs["sweep"] = rng.uniform(-1080, 1080, count)
    return arcs


def dense(arc: np.void) -> NDArray[np.float64]:
    return arc_displacement(np.repeat(np.array([arc], ARC_PIECE), len(DENSE)), DENSE)


@pytest.mark.parametrize("growth", [0.0, 0.001, 0.9])
def test_the_steepest_rise_of_each_axis(growth: float, rng: np.random.Generator) -> None:
    arcs = random_arcs(rng, 200, growth)
    for arc, rises in zip(arcs, steepest_rises(arcs), strict=True):
        found = np.abs(np.diff(dense(arc), axis=0)).max(axis=0) * (len(DENSE) - 1)
        assert (rises >= found * (1 - 1e-9)).all()
        slack = abs(arc["r1"] - arc["r0"]) * (np.radians(abs(arc["sweep"])) + 2.0)
        slack += 1e-3 * max(arc["r0"], arc["r1"])
        assert (rises <= found + slack).all()


def test_a_circle_faster_than_its_axes_is_stretched_inside() -> None:
    """Half a circle ends where X began: only inside does X run at the speed of the arc."""
    arc = {"kind": Kind.ARC, "to": (0, 200), "center": (0, 100, 0), "f": 60_000.0}
    m = axes_machine()
    path, findings = plan(program([arc]), m)
    assert path.duration_s == pytest.approx(pi * 100 / RAPID_MM_S)
    assert [f.code for f in findings] == ["GC303"]
    assert findings[0].time_s == 0.0
    slow_y = replace(m, joints=tuple(replace(j, rapid=50.0 if j.name == "Y" else j.rapid)
                                     for j in m.joints))  # fmt: skip
    assert plan(program([arc]), slow_y)[0].duration_s == pytest.approx(pi * 100 / 50.0)
    # An eighth about the side of the circle, where Y moves least: X decides.
    c, s = np.cos(pi / 16), np.sin(pi / 16)
    start = {"kind": Kind.RAPID, "to": (-100 * s, -100 * c)}
    short = {"kind": Kind.ARC, "to": (100 * s, -100 * c), "center": (0, 0, 0), "f": 60_000.0}
    path, _ = plan(program([start, short]), slow_y)
    least = max(pi / 8 * 100 / RAPID_MM_S, pi / 8 * 100 * s / 50.0)
    assert np.diff(path.bounds_ps)[1] / 1e12 == pytest.approx(least)


@pytest.mark.parametrize("growth", [0.04, 0.3, 0.99])
def test_the_extremes_of_a_spiral_are_exact(growth: float, rng: np.random.Generator) -> None:
    arcs = random_arcs(rng, 60, growth)
    ends = arc_displacement(arcs, np.ones(len(arcs)))
    path = Path(
        joints=("X", "Y", "Z"),
        bounds_ps=np.arange(len(arcs) + 1) * 10**12,
        q0=np.zeros_like(ends),
        q1=ends,
        law=np.tile(CONSTANT_SPEED, (len(arcs), 1)),
        arc=np.arange(len(arcs), dtype=np.int32),
        arcs=arcs,
        xyz=(0, 1, 2),
        line=np.ones(len(arcs), np.int32),
    )
    for column in range(3):
        low, high = position_ranges(path, column)
        for arc, lowest, highest in zip(arcs, low, high, strict=True):
            moved = dense(arc)[:, column]
            step = np.abs(np.diff(moved)).max()
            assert moved.min() - step <= lowest <= moved.min() + 1e-9
            assert moved.max() - 1e-9 <= highest <= moved.max() + step
