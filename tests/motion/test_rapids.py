"""Doglegs: every axis at its own rate, against the formula, and the way it bends."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from motion.programs import axes_machine, program, straight_program
from numpy.typing import NDArray

from gcodesim.constants import PS_PER_S
from gcodesim.motion.planner import plan
from gcodesim.nc.program import Kind

MACHINE = axes_machine().with_readings(rapids="dogleg")
RATES = np.array([joint.rapid for joint in MACHINE.joints])


def dogleg(
    start: NDArray[np.float64], end: NDArray[np.float64], seconds: NDArray[np.float64]
) -> NDArray[np.float64]:
    """x_j(t) = start + sign(d) min(v t, |d|)."""
    way = end - start
    return start + np.sign(way) * np.minimum(RATES * seconds[:, None], np.abs(way))


def test_every_axis_runs_at_its_own_rate(rng: np.random.Generator) -> None:
    to = rng.uniform(-100, 100, (200, 6)).round(3)
    to[:, 4] = 0.0
    to[rng.random((200, 6)) < 0.3] = 0.0  # axes that stand still
    to[50:60, 1:3] = to[50:60, :1]  # axes that arrive together
    rapids = straight_program(to, 0.0)
    rapids = replace(rapids, kind=np.full(200, Kind.RAPID, np.uint8))
    path, findings = plan(rapids, MACHINE)
    straight, _ = plan(rapids, axes_machine())
    assert not findings
    np.testing.assert_array_equal(path.q0[1:], path.q1[:-1])
    assert len(straight) < len(path) <= 5 * len(straight)
    columns = [0, 1, 2, 3, 5]
    start = np.zeros(5)
    for line in np.unique(path.line):
        (pieces,) = np.nonzero(path.line == line)
        first, last = path.bounds_ps[pieces[0]], path.bounds_ps[pieces[-1] + 1]
        end = to[line - 1][columns]
        seconds = np.max(np.abs(end - start) / RATES)
        assert abs((last - first) / PS_PER_S - seconds) <= 3e-12
        times = np.linspace(first + 1, last, 23).astype(np.int64)
        expected = dogleg(start, end, (times - first) / PS_PER_S)
        np.testing.assert_allclose(path.positions(times), expected, rtol=0, atol=2e-9)
        np.testing.assert_array_equal(path.q1[pieces[-1]], end)
        start = end


def test_feeds_stay_straight() -> None:
    rows = [{"kind": Kind.FEED, "to": (100, 50), "f": 1000}, {"kind": Kind.RAPID, "to": (0, 20)}]
    path, _ = plan(program(rows), MACHINE)
    assert path.line.tolist() == [1, 2, 2]
    assert path.q1[1].tolist() == [70, 20, 0, 0, 0]  # Y arrives after 30 mm of both
    assert path.positions_on(np.array([0]), np.array([0.5]))[0, :2].tolist() == [50, 25]
