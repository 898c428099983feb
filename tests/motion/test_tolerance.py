"""Path tolerance: what a program and a machine file allow together, and the sentence about it."""

from __future__ import annotations

from dataclasses import replace

import pytest
from motion.programs import axes_machine, program

from gcodesim.machine.control_data import bare_control
from gcodesim.motion.tolerance import corner_tolerances, path_modes, path_tolerance
from gcodesim.nc.interpret import interpret
from gcodesim.nc.program import CanonicalProgram, Kind

UNKNOWN = {"G64": None, "rapid": None}


def read(*blocks: str) -> CanonicalProgram:
    text = "\n".join(["%", "G21 G90 S100 M3", *blocks, "M30", "%"])
    return interpret(text, bare_control(None, "linuxcnc", None, False), "").program


@pytest.mark.parametrize(
    ("blocks", "given", "largest", "sentence"),
    [
        (["G61", "G0 X1", "G1 X2 F100"], UNKNOWN, 0.0, ""),
        (["G61.1", "G1 X2 F100"], {"G64": 0.1, "rapid": 0.3}, 0.0, ""),
        (
            ["G1 X2 F100", "G0 X1"],
            UNKNOWN,
            0.0,
            "exact path assumed: G64, rapid moves (no path_tolerance given)",
        ),
        (["G0 X1"], {"G64": 0.1, "rapid": 0.3}, 0.3,
         "clearances widened by 0.3 mm (rapid moves 0.3 mm)"),
        (
            ["G64 P0.05", "G0 X1", "G1 X2 F100"],
            UNKNOWN,
            0.05,
            "clearances widened by 0.05 mm (G64 P 0.05 mm)",
        ),
        (
            ["G64 P0.02", "G0 X1", "G61", "G1 X2 F100", "G64", "G0 X3", "G1 X9"],
            {"G64": None, "rapid": 0.5},
            0.5,
            "clearances widened by 0.5 mm (G64 P 0.02 mm, rapid moves 0.5 mm); "
            "exact path assumed: G64 (no path_tolerance given)",
        ),
        (["G20", "G64 P0.001", "G1 X1 F9"], UNKNOWN, 0.0254,
         "clearances widened by 0.0254 mm (G64 P 0.0254 mm)"),
        (["G64 P0.7"], UNKNOWN, 0.0, ""),
    ],
)  # fmt: skip
def test_what_is_allowed_and_what_is_reported(
    blocks: list[str], given: dict[str, float | None], largest: float, sentence: str
) -> None:
    machine = replace(axes_machine(), path_tolerance=given)
    assert path_tolerance(read(*blocks), machine) == (pytest.approx(largest), sentence)


def test_modes_hold_until_the_next() -> None:
    rows = [
        {"kind": Kind.RAPID, "to": (1,)},
        {"kind": Kind.PATH, "aux": 640, "f": 0.2},
        {"kind": Kind.FEED, "to": (2,), "f": 100},
        {"kind": Kind.PATH, "aux": 611},
        {"kind": Kind.FEED, "to": (3,), "f": 100},
    ]
    mode, p = path_modes(program(rows))
    assert mode.tolist() == [640, 640, 640, 611, 611]
    assert p.tolist() == [0, 0.2, 0.2, 0, 0]
    machine = replace(axes_machine(), path_tolerance={"G64": 0.1, "rapid": 0.3})
    assert corner_tolerances(program(rows), machine).tolist() == [0.3, 0.2, 0.2, 0, 0]
