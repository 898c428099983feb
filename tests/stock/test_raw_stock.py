"""Stocks that are no box: cylinders, castings with a bore, several at once, and turned ones."""

from __future__ import annotations

import numpy as np
import pytest
from stock.milling import BLANK, Program, end_mill, mill, raced

CYLINDER = "cylinder: {radius: 50, height: 50, center: [50, 50, -25]}"
RING = """\
parts:
      - {name: left, box: {size: [30, 100, 50], center: [15, 50, -25]}}
      - {name: right, box: {size: [30, 100, 50], center: [85, 50, -25]}}
      - {name: front, box: {size: [60, 30, 50], center: [50, 15, -25]}}
      - {name: rear, box: {size: [60, 30, 50], center: [50, 85, -25]}}
"""
TILTED = (
    "box: {size: [100, 100, 50], center: [0, 0, -25]}, "
    "placement: {translate: [50, 50, 0], rotate: [0, 0, 45]}"
)


def down(x: float, y: float, z: float = -10.0) -> Program:
    """A rapid down beside or into a stock, along x and y."""
    return Program().move(x, y, 5).move(x, y, z).move(x, y, 5)


def found(program: Program, blanks: str) -> bool:
    """Whether the race finds a contact; it decides in any case."""
    answer = raced(program, mill(end_mill(), blanks=blanks))
    assert answer.undecided == 0
    return bool(answer.events)


def test_a_cylinder_is_round() -> None:
    corner = 50.0 + (50.0 + 5.0) / np.sqrt(2.0) + 0.2
    assert not found(down(corner, corner), CYLINDER)
    assert found(down(corner - 0.5, corner - 0.5), CYLINDER)
    assert found(down(corner, corner), BLANK)


def test_a_cylinder_is_cut_like_a_box() -> None:
    program = Program().move(50, 50, 5).move(50, 50, -5, feed=300).move(-20, 50, -5, feed=800)
    assert not found(program.move(80, 50, -5, feed=800).move(20, 50, -5), CYLINDER)


def ring(holes: str = RING) -> str:
    return "blank:\n    link: C\n    role: stock\n    " + holes


def test_what_goes_into_the_bore_of_a_casting_is_free() -> None:
    assert not found(down(50, 50, -45), ring())
    assert not found(down(35.01, 50, -45), ring())
    assert found(down(34.9, 50, -45), ring())


def test_a_box_that_stands_askew_is_no_larger_than_it_is() -> None:
    assert found(down(50, -19), TILTED)
    assert not found(down(2, 2), TILTED)


def test_every_stock_is_raced_alone() -> None:
    blanks = (
        "near: {link: C, role: stock, box: {size: [20, 20, 20], center: [10, 10, -10]}}\n"
        "far: {link: C, role: stock, box: {size: [20, 20, 20], center: [90, 90, -10]}}"
    )
    machine = mill(end_mill(), blanks=blanks)
    program = Program().move(50, 50, 5).move(50, 50, -10).move(50, 90, -10).move(90, 90, -10)
    assert raced(program, machine, stock="far").events
    assert not raced(program, machine, stock="near").events


@pytest.mark.parametrize("turn", ["[90, 0, 0]", "[0, 90, 0]"])
def test_beams_run_along_the_axis_that_most_tools_have(turn: str) -> None:
    blanks = f"box: {{size: [80, 80, 80]}}, placement: {{translate: [50, 50, -40], rotate: {turn}}}"
    program = Program().move(50, 50, 5).move(50, 50, -10, feed=300).move(70, 50, -10, feed=900)
    assert not found(program.move(50, 50, -10).move(50, 50, 5), blanks)
