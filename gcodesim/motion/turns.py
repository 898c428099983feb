"""Arcs of many turns in stretches of whole turns, so that no angle loses its digits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gcodesim.motion.joint_moves import Moves

TURNS = 16
"""Whole turns that stay together: their angle is good to 2e-14 rad, that of a million to 5e-10."""


def unwound(moves: Moves) -> Moves:
    """The moves with arcs of more turns than TURNS cut after every TURNS of them.

    The angle beyond the whole turns is taken from the end point, which knows it to a rounding.
    """
    turned = np.zeros(len(moves))
    on_arc = moves.arc >= 0
    turned[on_arc] = np.abs(moves.arcs["sweep"][moves.arc[on_arc]]) / 360.0
    long = np.flatnonzero(turned > TURNS + 1)
    if not len(long):
        return moves
    parts = np.ones(len(moves), np.int64)
    parts[long] = np.floor(turned[long] / TURNS).astype(np.int64)
    index = np.repeat(np.arange(len(moves)), parts)
    number = np.arange(len(index)) - np.repeat(np.cumsum(parts) - parts, parts)
    split = moves.taken(index, moves.seconds[index])
    at = np.flatnonzero(parts[index] > 1)
    whole = moves.arcs[moves.arc[index[at]]]
    sweep = whole["sweep"]
    rest = _beyond_whole_turns(moves, index[at])
    all_turns = np.rint((sweep - rest) / 360.0)
    passed = np.sign(sweep) * TURNS * number[at]
    is_last = number[at] == parts[index[at]] - 1
    arcs = whole.copy()
    arcs["sweep"] = np.where(
        is_last, rest + 360.0 * (all_turns - passed), np.sign(sweep) * 360.0 * TURNS
    )
    start = passed * 360.0 / sweep
    end = np.where(is_last, 1.0, start + TURNS * 360.0 / np.abs(sweep))
    grown = whole["r1"] - whole["r0"]
    arcs["r0"], arcs["r1"] = whole["r0"] + grown * start, whole["r0"] + grown * end
    arcs["lift"] = whole["lift"] * (end - start)[:, None]
    split.q0[at], split.q1[at] = (_after_turns(moves, index[at], f) for f in (start, end))
    split.q1[at[is_last]] = moves.q1[index[at[is_last]]]
    split.seconds[at] *= end - start
    split.arc[at] = len(moves.arcs) + np.arange(len(at), dtype=np.int32)
    return replace(split, arcs=np.concatenate([moves.arcs, arcs]))


def _beyond_whole_turns(moves: Moves, index: NDArray[np.intp]) -> NDArray[np.float64]:
    """Angle from the start to the end of arcs without whole turns, -180..180 [deg]."""
    arcs = moves.arcs[moves.arc[index]]
    end = arcs["r0"][:, None] * arcs["u"]
    for axis, column in enumerate(moves.xyz):
        if column >= 0:
            end[:, axis] += moves.q1[index, column] - moves.q0[index, column]
    along_u, along_v = (np.sum(end * arcs[name], axis=1) for name in ("u", "v"))
    return np.degrees(np.arctan2(along_v, along_u))


def _after_turns(
    moves: Moves, index: NDArray[np.intp], share: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Joint positions after the shares of arcs that are whole turns, shape (m, joints)."""
    arcs = moves.arcs[moves.arc[index]]
    q0 = moves.q0[index]
    q = q0 + share[:, None] * (moves.q1[index] - q0)
    outward = ((arcs["r1"] - arcs["r0"]) * share)[:, None] * arcs["u"]
    moved = outward + share[:, None] * arcs["lift"]
    for axis, column in enumerate(moves.xyz):
        if column >= 0:
            q[:, column] = q0[:, column] + moved[:, axis]
    return q
