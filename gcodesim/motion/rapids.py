"""Rapid moves as doglegs: every axis at its own rate, so that the path is bent."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import PS_PER_S
from gcodesim.machine.model import Machine
from gcodesim.motion.joint_moves import Moves
from gcodesim.nc.program import CanonicalProgram, Frame, Kind, starts_of_moves


def doglegs(moves: Moves, program: CanonicalProgram, machine: Machine) -> Moves:
    """The moves with every rapid split where one of its axes arrives.

    x_j(t) = start + sign(d_j) min(v_j t, |d_j|) is straight between these instants, so that at
    most one move per axis is exact. Under tool centre point control the tip runs straight and
    nothing is split. The times of arrival are rounded to picoseconds: axes that arrive together
    do so exactly.
    """
    rates = np.array([joint.rapid for joint in machine.joints])
    plain = (program.kind[moves.row] == Kind.RAPID) & (program.frame[moves.row] == Frame.MACHINE)
    rapid = np.flatnonzero(plain)
    count, axes = len(moves), len(rates)
    q0, q1 = moves.q0[rapid], moves.q1[rapid]
    arrival = np.maximum(np.rint(np.abs(q1 - q0) / rates * PS_PER_S), q0 != q1) / PS_PER_S
    knots = np.zeros((len(rapid), axes + 1))
    knots[:, 1:] = np.sort(arrival, axis=1)
    is_leg = np.ones((count, axes), bool)
    is_leg[:, 1:] = False
    is_leg[rapid] = np.diff(knots, axis=1) > 0.0
    index, leg = np.nonzero(is_leg)
    split = moves.taken(index.astype(np.intp), moves.seconds[index])

    at = np.flatnonzero(plain[index])
    number = np.searchsorted(rapid, index[at])
    begins, ends = knots[number, leg[at]], knots[number, leg[at] + 1]
    split.seconds[at] = ends - begins
    for positions, times in ((split.q0, begins), (split.q1, ends)):
        positions[at] = _dogleg(q0[number], q1[number], arrival[number], times[:, None])
    return split


def _dogleg(
    q0: NDArray[np.float64],
    q1: NDArray[np.float64],
    arrival: NDArray[np.float64],
    time: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Joint positions at a time of a rapid, shape (m, joints)."""
    share = np.divide(time, arrival, out=np.ones_like(q0), where=arrival > time)
    return np.where(share >= 1.0, q1, q0 + share * (q1 - q0))


def may_bend(program: CanonicalProgram) -> tuple[int, int] | None:
    """Line of the first rapid move that a dogleg would bend, and how many there are."""
    plain = (program.kind == Kind.RAPID) & (program.frame == Frame.MACHINE)
    start = starts_of_moves(program)[plain]
    several = np.count_nonzero(program.to[plain] != start, axis=1) > 1
    lines = program.line[plain][several]
    return (int(lines[0]), len(lines)) if len(lines) else None
