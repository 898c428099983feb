"""Planning: from the canonical program to the joint-space path with its time law."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import LONGEST_S, PS_PER_S
from gcodesim.findings.codes import Finding
from gcodesim.machine.model import Machine
from gcodesim.machine.standing import joint_positions
from gcodesim.motion.arc_moves import arc_pieces
from gcodesim.motion.joint_moves import Moves
from gcodesim.motion.path import CONSTANT_SPEED, Path, ToolChange
from gcodesim.motion.profiles import profiled
from gcodesim.motion.rapids import doglegs
from gcodesim.motion.stretching import least_times, stretched
from gcodesim.motion.tool_moves import ToolMoves, followed
from gcodesim.motion.turns import unwound
from gcodesim.nc.program import (
    CanonicalProgram,
    FeedMode,
    Kind,
    Turning,
    path_lengths,
    starts_of_moves,
)


def plan(program: CanonicalProgram, machine: Machine) -> tuple[Path, list[Finding]]:
    """Turn canonical commands into the joint-space path: moves, rapids, speeds, the clock.

    Blocks that ask an axis for more than its rapid rate are stretched (GC303). A program longer
    than the clock can count ends where the clock does (GC424).
    """
    program, under, findings = followed(program, machine)
    wanted = joint_moves(program, machine, under)
    if under:
        wanted, remarks = under.cut(wanted, machine)
        findings += remarks
    least = least_times(wanted, machine)
    moves = replace(wanted, seconds=np.maximum(wanted.seconds, least))
    moves = unwound(moves)
    if machine.readings.rapids == "dogleg":
        moves = doglegs(moves, program, machine)
    if machine.time != "constant":
        moves = profiled(moves, program, machine)
    bounds, kept = _clock(moves.seconds)
    end = len(program)
    if kept < len(moves):
        end = int(moves.row[kept])
        line = int(program.line[end])
        message = f"program time passes {LONGEST_S:.3g} s here; what follows is not checked"
        findings.append(Finding("GC424", message, "time_limit", line=line))
        moves = moves.first(kept)
    path = Path(
        joints=machine.axes,
        bounds_ps=bounds,
        q0=moves.q0,
        q1=moves.q1,
        law=moves.law,
        arc=moves.arc,
        arcs=moves.arcs,
        xyz=moves.xyz,
        line=program.line[moves.row].astype(np.int32),
        tool_changes=_tool_changes(program, moves.row, end),
        deviation_mm=moves.deviation_mm,
        cuts=_cuts(program, moves.row),
        touching=np.isin(moves.row, program.touching) if len(program.touching) else None,
    )
    centre, clock = under.centre if under else None, (moves.row, bounds)
    return path, findings + stretched(program, wanted, least, clock, machine, centre)


def joint_moves(program: CanonicalProgram, machine: Machine, under: ToolMoves | None) -> Moves:
    """The moves and dwells of a program at their programmed feed, rapids in no time.

    Args:
        program: with axis positions throughout.
        machine: its joints.
        under: its moves under tool centre point control, which are still to be cut.
    """
    is_move = np.isin(program.kind, (Kind.RAPID, Kind.FEED, Kind.ARC))
    names = machine.axes
    before = starts_of_moves(program)
    lengths = path_lengths(program)
    if under:
        lengths[under.tips.row] = under.lengths
    dwells = (program.kind == Kind.DWELL) & (program.f > 0.0)
    rows = np.flatnonzero(dwells | (is_move & (lengths > 0.0)))
    q0 = joint_positions(machine, before[rows])
    q1 = np.where(is_move[rows, None], joint_positions(machine, program.to[rows]), q0)
    arc, arcs = arc_pieces(program, rows, before[rows, :3], program.to[rows, :3])
    return Moves(
        q0=q0,
        q1=q1,
        law=np.tile(CONSTANT_SPEED, (len(rows), 1)),
        arc=arc,
        arcs=arcs,
        xyz=tuple(names.index(a) if a in names else -1 for a in "XYZ"),  # type: ignore[arg-type]
        row=rows,
        seconds=_feed_times(program, lengths, rows),
    )


def _feed_times(
    program: CanonicalProgram, lengths: NDArray[np.float64], rows: NDArray[np.intp]
) -> NDArray[np.float64]:
    """Seconds each command takes at its programmed feed; rapids 0, dwells their own time."""
    kind, mode, feed = program.kind[rows], program.feed_mode[rows], program.f[rows]
    rate = np.where(mode == FeedMode.PER_REVOLUTION, feed * program.speed[rows], feed)
    amount = np.where(mode == FeedMode.INVERSE_TIME, 1.0, lengths[rows])
    moving = np.isin(kind, (Kind.FEED, Kind.ARC))
    with np.errstate(over="ignore"):  # tiny feeds take for ever: infinite is fine
        seconds = 60.0 * np.divide(amount, rate, out=np.zeros_like(rate), where=moving & (rate > 0))
    return np.where(kind == Kind.DWELL, feed, seconds)


def _clock(seconds: NDArray[np.float64]) -> tuple[NDArray[np.int64], int]:
    """Piece boundaries in picoseconds, and how many pieces fit the range of the clock.

    Integers add without rounding, so the cycle time is the same for any chunking: 1e6 blocks of
    half a picosecond of rounding each stay below 1e-6 s. A move takes at least 1 ps.
    """
    fits = np.cumsum(np.minimum(seconds, LONGEST_S)) < LONGEST_S
    kept = int(np.argmin(fits)) if not fits.all() else len(seconds)
    ticks = np.maximum(np.rint(seconds[:kept] * PS_PER_S), 1.0).astype(np.int64)
    return np.concatenate([np.zeros(1, np.int64), np.cumsum(ticks)]), kept


def _cuts(program: CanonicalProgram, rows: NDArray[np.intp]) -> NDArray[np.bool_] | None:
    """Whether the flute may touch the part in each move: none in rapids and as the spindle stands.

    In a skip move it may, whatever the spindle does.
    Where the spindle stands turned away from the wall, the flute is not round: nothing is asked.
    """
    if program.turning is None:
        return None
    kind, turning = program.kind[rows], program.turning[rows]
    away = turning == Turning.TURNED_AWAY
    fed = (kind != Kind.RAPID) & (turning != Turning.STANDS)
    return np.asarray(away | fed | np.isin(rows, program.touching))


def _tool_changes(
    program: CanonicalProgram, rows: NDArray[np.intp], end: int
) -> tuple[ToolChange, ...]:
    """Tool changes among the first `end` commands."""
    changes = np.flatnonzero(program.kind[:end] == Kind.TOOL)
    pieces = np.searchsorted(rows, changes)
    return tuple(
        ToolChange(int(piece), int(program.aux[row]), int(program.line[row]))
        for piece, row in zip(pieces, changes, strict=True)
    )
