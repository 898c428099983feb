"""How far each canonical move goes: what a feed is counted along."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gcodesim.nc.arcs import COINCIDENT_MM
from gcodesim.nc.program import CanonicalProgram, Kind

Floats = NDArray[np.float64]


def starts_of_moves(program: CanonicalProgram) -> Floats:
    """Return the machine position before every command, shape (n, 6), mm and deg."""
    is_move = program.kind <= Kind.ARC
    # Row 0 is the start; a move's row is its own number + 1, carried on over other commands.
    last = np.maximum.accumulate(np.where(is_move, np.arange(1, len(program) + 1), 0))
    before = np.concatenate(([0], last[:-1])) if len(program) else last
    positions = np.vstack([program.start[None, :], program.to])
    return np.asarray(positions[before], np.float64)


def path_lengths(program: CanonicalProgram) -> Floats:
    """Return what the feed of each command is counted along, shape (n,).

    XYZ path length [mm] where X, Y or Z moves, else the Euclidean length in A B C [deg];
    0 for commands that are no moves.
    """
    start = starts_of_moves(program)
    lengths = np.zeros(len(program))
    straight = program.kind <= Kind.FEED
    step = program.to[straight] - start[straight]
    linear = np.sqrt((step[:, :3] ** 2).sum(axis=1))
    rotary = np.sqrt((step[:, 3:] ** 2).sum(axis=1))
    lengths[straight] = np.where(linear > 0, linear, rotary)
    is_arc = program.kind == Kind.ARC
    if is_arc.any():
        arcs = program.arcs[program.aux[is_arc]]
        lengths[is_arc] = arc_lengths(start[is_arc, :3], program.to[is_arc, :3], arcs)
    return lengths


def arc_lengths(start: Floats, end: Floats, arcs: NDArray[Any]) -> Floats:
    """Return the lengths [mm] of arcs between points of shape (n, 3), helix and turns included.

    A radius that changes from start to end counts with its mean along the angle and its change
    across it, as the rise of a helix does.
    """
    first, last, rise = _in_plane(start, end, arcs)
    radius_first, radius_last = (np.sqrt((v**2).sum(axis=1)) for v in (first, last))
    along = (radius_first + radius_last) / 2 * np.abs(arc_sweeps(start, end, arcs))
    return np.sqrt(along**2 + (radius_last - radius_first) ** 2 + rise**2)


def arc_sweeps(start: Floats, end: Floats, arcs: NDArray[Any]) -> Floats:
    """Return the angles [rad] that arcs turn through, > 0 counter-clockwise, all turns included.

    The one place that decides between a full turn and none: an end nearer than COINCIDENT_MM
    along the arc is a full turn.
    """
    first, last, _ = _in_plane(start, end, arcs)
    sense = np.sign(arcs["turns"]).astype(np.float64)
    cross = (np.cross(first, last) * arcs["normal"]).sum(axis=1)
    angle = np.mod(sense * np.arctan2(cross, (first * last).sum(axis=1)), 2 * np.pi)
    radius = np.sqrt((first**2).sum(axis=1))
    angle = np.where(angle * radius < COINCIDENT_MM, angle + 2 * np.pi, angle)
    return np.asarray(sense * (angle + 2 * np.pi * (np.abs(arcs["turns"]) - 1)), np.float64)


def _in_plane(start: Floats, end: Floats, arcs: NDArray[Any]) -> tuple[Floats, Floats, Floats]:
    """Return start and end seen from the centre, within the plane, and the rise along the normal."""
    normal = arcs["normal"]
    vectors = []
    for point in (start, end):
        arm = point - arcs["center"]
        vectors.append(arm - (arm * normal).sum(axis=1)[:, None] * normal)
    rise = ((end - start) * normal).sum(axis=1)
    return vectors[0], vectors[1], rise
