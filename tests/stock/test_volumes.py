"""What is taken away: four closed forms at the order of their lines, and by block."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from stock.milling import Program, ball_mill, drill, end_mill, mill, path_of

from gcodesim.constants import DEFAULT_PERIOD_PS
from gcodesim.machine.model import Tool
from gcodesim.stock.volumes import Volumes, removed_volumes
from gcodesim.stock.workpiece import StockTask

WHOLE = 100.0 * 100.0 * 50.0
CONE = 5.0 / np.tan(np.radians(59.0))
SLOT = Program().move(20, 50, 5).move(20, 50, -5, feed=300).move(80, 50, -5, feed=1000)
DRILLED = Program().move(50, 50, 5).move(50, 50, -20, feed=300).move(50, 50, 5)
GROOVE = Program().move(-20, 50, 5).move(-20, 50, -5, feed=300).move(120, 50, -5, feed=1000)


def tilted_strip() -> Program:
    """A flat end mill, tilted by 30 degrees about Y, whose tip runs along Y at X50, Z-10."""
    program = Program(["G21 G90 G94 G17", "T1 M6", "S5000 M3", "G43.4 H1"])
    program.move(50, -20, 60, 30, 0).move(50, -20, -10, 30, 0)
    return program.move(50, 120, -10, 30, 0, feed=1000)


def strip_area() -> float:
    """What of the strip of width 10 lies below Z0: a polygon."""
    sine, cosine = 0.5, np.sqrt(0.75)
    left = np.array([50 - 5 * cosine, -10 + 5 * sine])
    right = np.array([50 + 5 * cosine, -10 - 5 * sine])
    tops = [p + np.array([sine, cosine]) * (-p[1] / cosine) for p in (right, left)]
    x, y = np.array([left, right, *tops]).T
    return 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))


FORMS: dict[str, tuple[Program, Callable[[], Tool], float, int]] = {
    "slot": (SLOT, end_mill, 5 * (60 * 10 + 25 * np.pi), 0),
    "drilled": (DRILLED, drill, 25 * np.pi * (20 - CONE) + 25 * np.pi * CONE / 3, 0),
    "groove of a ball": (GROOVE, ball_mill, 1250 * np.pi, 1),
    "tilted strip": (tilted_strip(), lambda: end_mill(flute=40.0), 100 * strip_area(), 1),
}


def volumes(program: Program, tool: Tool, spacing: float, along: int | None = None) -> Volumes:
    machine = mill(tool)
    task = StockTask(machine, path_of(program, machine), DEFAULT_PERIOD_PS, "cpu")
    return removed_volumes(machine.bodies["blank"], task, spacing, along)


@pytest.mark.parametrize("name", FORMS)
def test_a_volume_comes_near_its_closed_form_as_lines_come_near_each_other(name: str) -> None:
    program, tool, exact, along = FORMS[name]
    found = [volumes(program, tool(), h, along).removed.sum() for h in (1.0, 0.5, 0.25)]
    errors = np.abs(np.array(found) / exact - 1.0)
    assert errors[2] < 1.5e-3
    # A midpoint sum whose integrand ends like a square root has the order 1.5.
    assert 1.1 < np.log2(errors[0] / errors[2]) / 2.0 < 2.0


def test_a_prism_is_exact_by_lines_across_it() -> None:
    found = volumes(tilted_strip(), end_mill(flute=40.0), 1.0, 0)
    assert found.removed.sum() == pytest.approx(100 * strip_area(), rel=1e-12)


def test_what_is_taken_and_what_is_left_are_all_of_the_stock() -> None:
    found = volumes(SLOT, end_mill(), 0.5)
    assert found.removed.sum() + found.left == pytest.approx(WHOLE, abs=1e-6)
    assert found.overflows == 0


def test_each_block_has_its_share() -> None:
    machine = mill(end_mill())
    path = path_of(SLOT, machine)
    by_block = volumes(SLOT, end_mill(), 0.25).by_block(path.line)
    assert list(by_block) == [6, 7]
    assert by_block[6] == pytest.approx(125 * np.pi, rel=1e-2)
    assert by_block[7] == pytest.approx(3000, rel=1e-2)
