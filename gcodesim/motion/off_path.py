"""How far the machine may be from the path that is checked: rounded corners and lagging drives."""

from __future__ import annotations

from dataclasses import dataclass

from gcodesim.machine.model import Machine
from gcodesim.motion.lag import Lag, lag_over_time
from gcodesim.motion.path import Path
from gcodesim.motion.servo import servo_deviation
from gcodesim.motion.tolerance import path_tolerance
from gcodesim.nc.program import CanonicalProgram


@dataclass(frozen=True)
class OffPath:
    """Bounds that widen every clearance.

    Attributes:
        tolerance_mm: how far any point may leave the path [mm].
        lag: how far every joint may ever stay behind, shape (joints,) [mm or deg]; () = not at all.
        late: the same over program time; None = `lag` at all times.
        corners: a sentence about rounded corners; empty when the path is kept.
    """

    tolerance_mm: float = 0.0
    lag: tuple[float, ...] = ()
    late: Lag | None = None
    corners: str = ""


def off_path(program: CanonicalProgram, path: Path, machine: Machine) -> OffPath:
    """The bounds of a program on a machine."""
    tolerance, corners = path_tolerance(program, machine)
    lag = tuple(servo_deviation(path, machine).tolist())
    return OffPath(tolerance, lag, lag_over_time(path, machine), corners)
