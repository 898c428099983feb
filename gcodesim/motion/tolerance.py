"""Path tolerance: how far a control may leave the programmed path, and where it must stop on it.

G61 keeps the path, G61.1 stops at the end of every block, G64 P rounds corners by at most P. What
plain G64, in force at program start, and rapid moves under it allow is up to the control: the
machine file says it under `path_tolerance`, or the exact path is assumed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gcodesim.machine.model import Machine
from gcodesim.nc.program import CanonicalProgram, Kind

EXACT_STOP, CONTINUOUS = 611, 640
"""G61.1 and G64, in tenths as the command PATH holds them."""


def path_modes(program: CanonicalProgram) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """Path mode in force at every command, and P of its G64 [mm], 0 without; shape (n,) each."""
    sets = program.kind == Kind.PATH
    last = np.maximum.accumulate(np.where(sets, np.arange(1, len(program) + 1), 0))
    mode = np.concatenate([[CONTINUOUS], program.aux])[last]
    p = np.concatenate([[0.0], program.f])[last]
    return mode.astype(np.int32), np.where(mode == CONTINUOUS, p, 0.0)


def corner_tolerances(program: CanonicalProgram, machine: Machine) -> NDArray[np.float64]:
    """How far the control may leave the path at every command, shape (n,) [mm]; 0 when unknown."""
    mode, p = path_modes(program)
    of = machine.path_tolerance
    plain = np.where(program.kind == Kind.RAPID, of.get("rapid") or 0.0, of.get("G64") or 0.0)
    return np.where(mode == CONTINUOUS, np.where(p > 0.0, p, plain), 0.0)


def path_tolerance(program: CanonicalProgram, machine: Machine) -> tuple[float, str]:
    """Largest distance of the real path from the programmed one [mm], and a sentence about it.

    The sentence, for the coverage, says which tolerances were in force and what is only assumed;
    it is empty for a program that stays on its path (G61, G61.1, or no motion).
    """
    is_rapid = program.kind == Kind.RAPID
    moves = is_rapid | (program.kind == Kind.FEED) | (program.kind == Kind.ARC)
    mode, p = path_modes(program)
    moves &= mode == CONTINUOUS
    largest = float(np.max(corner_tolerances(program, machine)[moves], initial=0.0))
    stated, assumed = [], []
    if (moves & (p > 0.0)).any():
        stated.append(f"G64 P {np.max(p[moves]):g} mm")
    for key, name, those in (
        ("G64", "G64", moves & ~is_rapid & (p == 0.0)),
        ("rapid", "rapid moves", moves & is_rapid & (p == 0.0)),
    ):
        value = machine.path_tolerance.get(key)
        if those.any() and value is None:
            assumed.append(name)
        elif those.any():
            stated.append(f"{name} {value:g} mm")
    parts = [f"clearances widened by {largest:g} mm ({', '.join(stated)})"] if stated else []
    if assumed:
        parts.append(f"exact path assumed: {', '.join(assumed)} (no path_tolerance given)")
    return largest, "; ".join(parts)
