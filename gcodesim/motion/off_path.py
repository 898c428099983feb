"""How far the machine may be from the path that is checked: rounded corners and lagging drives."""

from __future__ import annotations

from dataclasses import dataclass

from gcodesim.machine.model import Machine
from gcodesim.motion.path import Path
from gcodesim.motion.servo import servo_deviation
from gcodesim.motion.tolerance import path_tolerance
from gcodesim.nc.program import CanonicalProgram


@dataclass(frozen=True)
class OffPath:
    """Bounds that widen every clearance.

    Attributes:
        tolerance_mm: how far any point may leave the path [mm].
        lag: how far every joint may stay behind, shape (joints,) [mm or deg]; () = not at all.
        corners: what is said about rounded corners; empty when the path is kept.
    """

    tolerance_mm: float = 0.0
    lag: tuple[float, ...] = ()
    corners: str = ""


def off_path(program: CanonicalProgram, path: Path, machine: Machine) -> OffPath:
    """The bounds of a program on a machine."""
    tolerance, corners = path_tolerance(program, machine)
    return OffPath(tolerance, tuple(servo_deviation(path, machine).tolist()), corners)
