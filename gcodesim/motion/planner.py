"""Planning: from the canonical program to the joint-space path with its time law."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import MAX_TIME_PS, PS_PER_S
from gcodesim.findings import Finding
from gcodesim.machine.model import Machine
from gcodesim.motion.path import ARC_PIECE, CONSTANT_SPEED, Path, ToolChange
from gcodesim.nc.program import (
    AXES,
    CanonicalProgram,
    FeedMode,
    Kind,
    arc_sweeps,
    path_lengths,
    starts_of_moves,
)


def plan(program: CanonicalProgram, machine: Machine) -> tuple[Path, list[Finding]]:
    """Turn canonical moves into path pieces at constant feed, rapids at the slowest axis' rate.

    Blocks that ask an axis for more than its rapid rate are stretched (GC303). A program longer
    than the clock can count ends where the clock does (GC424).
    """
    is_move = np.isin(program.kind, (Kind.RAPID, Kind.FEED, Kind.ARC))
    columns = [AXES.index(joint.name) for joint in machine.joints]
    before = starts_of_moves(program)
    lengths = path_lengths(program)
    dwells = (program.kind == Kind.DWELL) & (program.f > 0.0)
    rows = np.flatnonzero(dwells | (is_move & (lengths > 0.0)))
    q0 = before[rows][:, columns]
    q1 = np.where(is_move[rows, None], program.to[rows][:, columns], q0)
    wanted = _feed_times(program, lengths, rows)
    least = _least_times(machine, q0, q1)
    seconds = np.where(program.kind[rows] == Kind.RAPID, least, np.maximum(wanted, least))
    findings = _stretched(program, rows, wanted, least)

    bounds, kept = _clock(seconds)
    end = len(program)
    if kept < len(rows):
        end = int(rows[kept])
        line = int(program.line[end])
        limit = MAX_TIME_PS / PS_PER_S
        message = f"program time passes {limit:.3g} s here; what follows is not checked"
        findings.append(Finding("GC424", message, "time_limit", line=line))
        rows, q0, q1 = rows[:kept], q0[:kept], q1[:kept]
    arc, arcs = _arc_pieces(program, rows, before)
    names = machine.axes
    path = Path(
        joints=names,
        bounds_ps=bounds,
        q0=q0,
        q1=q1,
        law=np.tile(CONSTANT_SPEED, (len(rows), 1)),
        arc=arc,
        arcs=arcs,
        xyz=tuple(names.index(a) if a in names else -1 for a in "XYZ"),  # type: ignore[arg-type]
        line=program.line[rows].astype(np.int32),
        tool_changes=_tool_changes(program, rows, end),
    )
    return path, findings


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


def _least_times(
    machine: Machine, q0: NDArray[np.float64], q1: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Seconds each move takes at least: the slowest axis at its rapid rate (end to end)."""
    rates = np.array([joint.rapid for joint in machine.joints])
    least: NDArray[np.float64] = np.max(np.abs(q1 - q0) / rates, axis=1, initial=0.0)
    return least


def _stretched(
    program: CanonicalProgram,
    rows: NDArray[np.intp],
    wanted: NDArray[np.float64],
    least: NDArray[np.float64],
) -> list[Finding]:
    slow = np.flatnonzero((program.kind[rows] != Kind.RAPID) & (wanted < least * (1.0 - 1e-12)))
    if not len(slow):
        return []
    worst = slow[np.argmax(least[slow] - wanted[slow])]
    message = (
        f"{len(slow)} block(s) stretched because an axis cannot keep the feed; most here: "
        f"{wanted[worst]:.4g} s programmed, {least[worst]:.4g} s needed"
    )
    line = int(program.line[rows[worst]])
    return [Finding("GC303", message, "axis_too_slow", line=line)]


def _clock(seconds: NDArray[np.float64]) -> tuple[NDArray[np.int64], int]:
    """Piece boundaries in picoseconds, and how many pieces fit the range of the clock.

    Integers add without rounding, so the cycle time is the same for any chunking: 1e6 blocks of
    half a picosecond of rounding each stay below 1e-6 s. A move takes at least 1 ps.
    """
    longest = MAX_TIME_PS / PS_PER_S
    fits = np.cumsum(np.minimum(seconds, longest)) < longest
    kept = int(np.argmin(fits)) if not fits.all() else len(seconds)
    ticks = np.maximum(np.rint(seconds[:kept] * PS_PER_S), 1.0).astype(np.int64)
    return np.concatenate([np.zeros(1, np.int64), np.cumsum(ticks)]), kept


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


def _arc_pieces(
    program: CanonicalProgram,
    rows: NDArray[np.intp],
    before: NDArray[np.float64],
) -> tuple[NDArray[np.int32], NDArray[np.void]]:
    """Arc index per piece and the arcs in displacement form."""
    on_arc = np.flatnonzero(program.kind[rows] == Kind.ARC)
    index = np.full(len(rows), -1, np.int32)
    index[on_arc] = np.arange(len(on_arc), dtype=np.int32)
    chosen = rows[on_arc]
    source = program.arcs[program.aux[chosen]]
    return index, displacement_arcs(source, before[chosen, :3], program.to[chosen, :3])


def displacement_arcs(
    source: NDArray[np.void], start: NDArray[np.float64], end: NDArray[np.float64]
) -> NDArray[np.void]:
    """ARC_PIECE rows for arcs (nc ARC_DTYPE) from `start` to `end`, shapes (n, 3) [mm]."""
    normal = source["normal"]
    arcs = np.zeros(len(source), ARC_PIECE)
    arcs["u"], arcs["r0"] = _in_plane(start - source["center"], normal)
    _, arcs["r1"] = _in_plane(end - source["center"], normal)
    arcs["v"] = np.cross(normal, arcs["u"])
    arcs["sweep"] = np.degrees(arc_sweeps(start, end, source))
    arcs["lift"] = np.sum((end - start) * normal, axis=1)[:, None] * normal
    return arcs


def _in_plane(
    vector: NDArray[np.float64], normal: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Unit direction and length of the part of `vector` perpendicular to `normal`."""
    flat = vector - np.sum(vector * normal, axis=1)[:, None] * normal
    length = np.linalg.norm(flat, axis=1)
    return flat / np.where(length > 0.0, length, 1.0)[:, None], length
