"""How fast every joint goes on every piece of a path."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import PS_PER_S
from gcodesim.motion.arc_moves import steepest_rises
from gcodesim.motion.path import Path

Floats = NDArray[np.float64]


def piece_speeds(path: Path, pieces: slice = slice(None)) -> Floats:
    """Bound of the speed of every joint on some pieces, shape (n, joints) [mm/s or deg/s]."""
    rate = largest_slope(path.law[pieces]) * PS_PER_S / np.diff(path.bounds_ps)[pieces]
    way, arc = np.abs(path.q1[pieces] - path.q0[pieces]), path.arc[pieces]
    on_arc = np.flatnonzero(arc >= 0)
    moved = steepest_rises(path.arcs[arc[on_arc]])
    for axis, column in enumerate(path.xyz):
        if column >= 0:
            way[on_arc, column] = moved[:, axis]
    return np.asarray(way * rate[:, None])


def joint_speeds(path: Path) -> Floats:
    """Bound of the speed of every joint on the path, shape (joints,) [mm/s or deg/s]."""
    return piece_speeds(path).max(axis=0, initial=0.0)


def largest_slope(law: Floats) -> Floats:
    """Largest speed of each law: at an end, or where the second derivative vanishes, (n,)."""
    c1, c2, c3 = law.T
    turn = np.clip(np.divide(-c2, 3.0 * c3, out=np.zeros_like(c2), where=c3 != 0.0), 0.0, 1.0)
    slopes = [c1 + 2.0 * c2 * tau + 3.0 * c3 * tau * tau for tau in (0.0, 1.0, turn)]
    return np.asarray(np.max(slopes, axis=0))
