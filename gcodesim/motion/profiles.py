"""Speeds over time within the limits of the axes: look-ahead, then phases with exact laws.

The path stays the programmed one. Each move has limits along it (blocks.py); a backward and a
forward pass find the speeds at its ends; ramps in closed form (ramps.py) join them. With
`time: acceleration` every move is planned by itself. With `time: jerk` ramps begin and end without
acceleration, and so moves shorter than such a ramp are planned together, within the limits of all
of them: else a curve of many short chords would never gain speed.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gcodesim.machine.model import Machine
from gcodesim.motion.blocks import Blocks, blocks, corner_speeds
from gcodesim.motion.joint_moves import Moves
from gcodesim.motion.path import CONSTANT_SPEED
from gcodesim.motion.ramps import Phases, phases, reachable_speed, reachable_speeds
from gcodesim.motion.stretches import stretches
from gcodesim.motion.tolerance import EXACT_STOP, corner_tolerances, path_modes
from gcodesim.nc.program import CanonicalProgram, Kind

Floats = NDArray[np.float64]

RAMPS_TOGETHER = 2.0
"""Moves are planned together until they last this many times a/j, the time of easing in: then
there is room for a ramp up and one down."""

ALIKE = 2.0
"""Moves are planned together only while their speeds differ by less than this factor."""

PASS = 500
"""A look at all units at once counts as one at this many more: it costs as much as walking 30."""

PATIENCE = 2
"""Units are walked once this many times their number were looked at: their chains are long."""


def profiled(moves: Moves, program: CanonicalProgram, machine: Machine) -> Moves:
    """The moves cut into phases of linear or quadratic speed, each with its time and law.

    A corner is passed at the speed that its path mode allows (see blocks.corner_speeds); exact stop
    (G61.1), a dwell, a tool change and a stop of the program end at rest.
    """
    still = (moves.arc < 0) & (moves.q0 == moves.q1).all(axis=1)
    if still.all():
        return moves
    moving = np.flatnonzero(~still)
    run = moves.taken(moving, moves.seconds[moving])
    limits = blocks(run, machine)
    stops = _stops(moves, moving, program)
    tolerance = corner_tolerances(program, machine)[run.row]
    corner = corner_speeds(limits, machine, tolerance, stops)
    unit = _units(limits, corner)
    cut = stretches(*_planned(limits, corner, unit), unit, limits.length)
    # Dwells go back to their places: each as one whole stretch at its own time.
    rests = np.flatnonzero(still)
    order = np.argsort(np.concatenate([moving[cut.move], rests]), kind="stable")
    zero, one = np.zeros(len(rests)), np.ones(len(rests))

    def joined(values: Floats, other: Floats) -> Floats:
        return np.concatenate([values, other])[order]

    pieces = moves.cut(
        np.concatenate([moving[cut.move], rests])[order],
        joined(cut.start, zero),
        joined(cut.end, one),
    )
    law = np.concatenate([cut.law, np.tile(CONSTANT_SPEED, (len(rests), 1))])[order]
    return replace(pieces, law=law, seconds=joined(cut.seconds, moves.seconds[rests]))


def _stops(moves: Moves, moving: NDArray[np.intp], program: CanonicalProgram) -> NDArray[np.bool_]:
    """Whether the machine stands after each moving move: by its mode, or by what follows it."""
    mode, _ = path_modes(program)
    halts = np.isin(program.kind, (Kind.TOOL, Kind.STOP)) | (
        (program.kind == Kind.DWELL) & (program.f > 0.0)
    )
    halted = np.cumsum(halts)[moves.row[moving]]
    after = np.append(np.diff(halted) > 0, True)
    leaves = np.append(np.diff(moves.row[moving]) > 0, True)
    return after | (leaves & (mode[moves.row[moving]] == EXACT_STOP))


def _units(limits: Blocks, corner: Floats) -> NDArray[np.intp]:
    """Which moves are planned together: the number of the unit of each move, shape (n,)."""
    count = len(limits.length)
    if np.isinf(limits.j).all():
        return np.arange(count)
    ramp = RAMPS_TOGETHER * limits.a / limits.j
    lasts = limits.length / limits.cap
    slower = np.minimum(limits.cap[1:], limits.cap[:-1])
    faster = np.maximum(limits.cap[1:], limits.cap[:-1])
    parted = (ALIKE * corner < slower) | (faster > ALIKE * slower)
    parted |= (lasts >= ramp)[1:] | (lasts >= ramp)[:-1]
    # Where no limit parts two moves, what their unit lasts so far may.
    filled, joined = 0.0, -1
    alike = np.flatnonzero(~parted)
    for i, last, enough in zip(
        alike.tolist(), lasts[alike].tolist(), ramp[alike + 1].tolist(), strict=True
    ):
        filled = last + (filled if joined == i - 1 else 0.0)
        if filled < enough:
            joined = i
        else:
            parted[i] = True
    return np.append(0, np.cumsum(parted))


def _planned(limits: Blocks, corner: Floats, unit: NDArray[np.intp]) -> tuple[Phases, Floats]:
    """Phases and lengths of the units."""
    first = np.flatnonzero(np.diff(unit, prepend=-1))
    length = np.add.reduceat(limits.length, first)
    a, j, cap = (np.minimum.reduceat(x, first) for x in (limits.a, limits.j, limits.cap))
    inner = np.append(np.where(np.diff(unit) > 0, np.inf, corner), np.inf)
    cap = np.minimum(cap, np.minimum.reduceat(inner, first))
    between = np.minimum(corner[first[1:] - 1], np.minimum(cap[1:], cap[:-1]))
    speed = boundary_speeds(length, between, a, j)
    return phases(speed[:-1], speed[1:], cap, length, a, j), length


def boundary_speeds(length: Floats, between: Floats, a: Floats, j: Floats) -> Floats:
    """Speeds at the ends of n units, at rest at both outer ends, shape (n + 1,).

    Backwards: from no speed may the next end be out of reach; forwards: nor be reached too soon.

    Args:
        length: of the units, shape (n,).
        between: largest speed from each unit to the next, shape (n - 1,).
        a: limits of acceleration, shape (n,).
        j: limits of jerk, shape (n,).
    """
    most = np.concatenate([[0.0], between, [0.0]])
    most = _reached(most[::-1], length[::-1], a[::-1], j[::-1])[::-1]
    return _reached(most, length, a, j)


def _reached(most: Floats, length: Floats, a: Floats, j: Floats) -> Floats:
    """Speeds from first to last, (n + 1,): the most allowed that the one before can reach.

    Most corners are slow enough, and most others bind only a few units on. So all units that may
    change are looked at together, then those after a change, until nothing does: the fixed point
    is the same as unit by unit. Chains that are longer than this pays are walked.
    """
    speed = most.copy()
    at = np.flatnonzero(most[1:] > most[:-1])
    looked = 0
    while len(at) and looked < PATIENCE * len(length):
        looked += len(at) + PASS
        end = np.minimum(most[at + 1], reachable_speeds(speed[at], length[at], a[at], j[at]))
        changed = np.flatnonzero(end != speed[at + 1])
        at = at[changed] + 1
        speed[at] = end[changed]
    if len(at):
        rest = slice(at[0], None)
        speed[rest] = _walked(at - at[0], speed[rest], most[rest], length[rest], a[rest], j[rest])
    return speed


def _walked(
    at: NDArray[np.intp], speed: Floats, most: Floats, length: Floats, a: Floats, j: Floats
) -> list[float]:
    """The same unit by unit: from each of `at`, ascending, on until nothing changes."""
    now: list[float] = speed.tolist()
    limits = most.tolist()
    lengths, accelerations, jerks = length.tolist(), a.tolist(), j.tolist()
    done = 0
    for first in at.tolist():
        i = first
        while i >= done:
            done = i + 1
            end = reachable_speed(now[i], lengths[i], accelerations[i], jerks[i])
            end = limits[done] if limits[done] < end else end
            if end != now[done]:
                now[done] = end
                i = done
    return now
