"""Knots: straight lines in time between them pass the path within the stated tolerance."""

from __future__ import annotations

import numpy as np
import pytest
from motion.programs import axes_machine, limited_machine, program
from numpy.typing import NDArray

from gcodesim.constants import PS_PER_S
from gcodesim.machine.model import Machine
from gcodesim.motion.knots import Knots, reduced
from gcodesim.motion.path import Path
from gcodesim.motion.planner import plan
from gcodesim.nc.program import Kind

ROWS = [
    {"kind": Kind.RAPID, "to": (10.0, 0.0, 0.0)},
    {"kind": Kind.ARC, "to": (10.0, 0.0, 5.0), "center": (0, 0, 0), "turns": 3, "f": 3000.0},
    {"kind": Kind.DWELL, "f": 0.5},
    {"kind": Kind.FEED, "to": (-40.0, 7.0, 5.0, 30.0, 0.0, 400.0), "f": 2000.0},
    *({"kind": Kind.FEED, "to": (-40.0 + 0.01 * k, 7.0), "f": 6000.0} for k in range(3000)),
]


def path(machine: Machine) -> Path:
    return plan(program(ROWS), machine)[0]


def deviation(knots: Knots, on: Path) -> float:
    """Largest deviation of any joint at 200,000 instants [mm or deg]."""
    times = np.linspace(0, on.duration_ps, 200_000).astype(np.int64)
    true: NDArray[np.float64] = on.positions(times)
    drawn = [np.interp(times / PS_PER_S, knots.time_s, column) for column in knots.positions.T]
    return float(np.abs(np.array(drawn).T - true).max())


@pytest.mark.parametrize("machine", [axes_machine(), limited_machine("jerk")])
@pytest.mark.parametrize("tolerance", [0.01, 1.0])
def test_knots_stay_within_the_tolerance_and_are_few(machine: Machine, tolerance: float) -> None:
    whole = path(machine)
    knots = reduced(whole, tolerance, 10**6)
    assert knots.tolerance == tolerance
    assert deviation(knots, whole) <= tolerance
    # The ends are the path's own, and 3000 short blocks in a row are one line or a few.
    assert np.array_equal(knots.positions[[0, -1]], whole.positions([0, whole.duration_ps]))
    assert knots.time_s[-1] == whole.duration_s
    assert (np.diff(knots.time_s) > 0).all()
    assert len(knots.time_s) < 600


def test_the_tolerance_grows_until_the_knots_are_few_enough() -> None:
    whole = path(axes_machine())
    knots = reduced(whole, 1e-4, 60)
    assert len(knots.time_s) <= 60
    assert deviation(knots, whole) <= knots.tolerance
    assert knots.tolerance == 1e-4 * 2 ** round(np.log2(knots.tolerance / 1e-4))
