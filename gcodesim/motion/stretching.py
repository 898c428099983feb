"""Blocks that ask a joint for more than its rapid rate, and the poles where they do."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import LEAST_LOSS, NEAR_POLE_DEG, PS_PER_S
from gcodesim.findings.codes import Finding
from gcodesim.machine.model import Joint, Machine
from gcodesim.machine.tool_centre import ToolCentre
from gcodesim.motion.arc_moves import steepest_rises
from gcodesim.motion.joint_moves import Moves
from gcodesim.nc.program import CanonicalProgram, Kind

SLOWEST_PART = 1e-9
"""A joint whose least time is shorter than the longest by no more than this part is the slowest."""


def least_times(moves: Moves, machine: Machine) -> NDArray[np.float64]:
    """Seconds each move takes at least, shape (n,): no joint ever faster than its rapid rate."""
    ways, least = farthest_ways(moves), np.zeros(len(moves))
    for column, joint in enumerate(machine.joints):
        np.maximum(least, ways[:, column] / joint.rapid, out=least)
    return least


def farthest_ways(moves: Moves) -> NDArray[np.float64]:
    """Largest |dq/ds| of every joint on every move, s from 0 to 1 along it; shape (n, joints)."""
    way = np.abs(moves.q1 - moves.q0)
    on_arc = np.flatnonzero(moves.arc >= 0)
    steepest = steepest_rises(moves.arcs[moves.arc[on_arc]])
    for axis, column in enumerate(moves.xyz):
        if column >= 0:
            way[on_arc, column] = steepest[:, axis]
    return way


def stretched(
    program: CanonicalProgram,
    wanted: Moves,
    least: NDArray[np.float64],
    clock: tuple[NDArray[np.intp], NDArray[np.int64]],
    machine: Machine,
    centre: ToolCentre | None,
) -> list[Finding]:
    """One finding for the blocks that a pole slows down (GC304), one for all others (GC303).

    Args:
        program: the commands.
        wanted: the moves at their programmed feed.
        least: their least times [s], shape (n,).
        clock: row of every move as it is run, and when these begin and end [ps].
        machine: its joints.
        centre: its tool centre, where the program asks for it.
    """
    is_feed = np.isin(program.kind[wanted.row], (Kind.FEED, Kind.ARC))
    lost = np.where(is_feed, np.maximum(least - wanted.seconds, 0.0), 0.0)
    slow = np.flatnonzero(lost > LEAST_LOSS * least)
    if not len(slow):
        return []
    angle = np.full(len(wanted), np.inf)
    if centre is not None:
        angle[slow] = _pole_angles(wanted, slow, machine, centre, least[slow])
    blocks, block = np.unique(wanted.row[slow], return_inverse=True)
    total = np.bincount(block, lost[slow])
    near = 2.0 * np.bincount(block, np.where(angle[slow] < NEAR_POLE_DEG, lost[slow], 0.0)) > total
    findings = []
    for some in (~near, near):
        if not some.any():
            continue
        worst = blocks[np.argmax(np.where(some, total, -1.0))]
        pieces = np.flatnonzero(wanted.row == worst)
        seconds = float(wanted.seconds[pieces].sum())
        example = f"{seconds:.4g} s programmed, {seconds + float(lost[pieces].sum()):.4g} s needed"
        code, meaning, why = "GC303", "axis_too_slow", "because an axis cannot keep the feed"
        if centre is not None and near[blocks == worst][0]:
            code, meaning, why = "GC304", "near_pole", "near a pole of the rotary axes"
            joint = centre.rotary.joints[0]
            column = machine.axes.index(joint.name)
            example += _pole_message(wanted, pieces, joint, column, angle)
        message = f"{some.sum()} block(s) stretched {why}; most here: {example}"
        line = int(program.line[worst])
        begin_ps = clock[1][min(int(np.searchsorted(clock[0], worst)), len(clock[0]))]
        time = float(begin_ps) / PS_PER_S
        findings.append(Finding(code, message, meaning, line=line, time_s=time))
    return findings


def _pole_angles(
    wanted: Moves,
    slow: NDArray[np.intp],
    machine: Machine,
    centre: ToolCentre,
    least: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Angle [deg] to the nearest pole, infinite for moves that another joint slows down."""
    columns = [machine.axes.index(joint.name) for joint in centre.rotary.joints]
    free = columns[0]
    way = np.abs(wanted.q1[slow, free] - wanted.q0[slow, free])
    is_slowest = way >= least * machine.joints[free].rapid * (1.0 - SLOWEST_PART)
    angles = [
        centre.rotary.pole_angles(centre.rotary.directions(q[slow][:, columns]))
        for q in (wanted.q0, wanted.q1)
    ]
    return np.where(is_slowest, np.degrees(np.min(angles, axis=0)), np.inf)


def _pole_message(
    wanted: Moves, pieces: NDArray[np.intp], joint: Joint, column: int, angle: NDArray[np.float64]
) -> str:
    """What the joint free at the pole would need where it needs most."""
    near = pieces[angle[pieces] < NEAR_POLE_DEG]
    way = np.abs(wanted.q1[near, column] - wanted.q0[near, column])
    with np.errstate(divide="ignore"):
        speed = 60.0 * way / wanted.seconds[near]
    worst = int(np.argmax(speed))
    need = f"need {speed[worst]:.4g} deg/min" if np.isfinite(speed[worst]) else "have to jump"
    return (
        f"; {joint.name} would {need}, it does {60.0 * joint.rapid:.4g}, "
        f"{angle[near[worst]]:.2g} deg from the pole"
    )
