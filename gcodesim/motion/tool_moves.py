"""Moves under tool centre point control: from the canonical program to moves of the joints."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import STILL_MM
from gcodesim.errors import OrientationError
from gcodesim.findings.codes import Finding
from gcodesim.machine.model import Machine
from gcodesim.machine.standing import joint_positions
from gcodesim.machine.tool_centre import ToolCentre, tool_centre
from gcodesim.motion.arc_moves import arc_pieces
from gcodesim.motion.great_circle import cut_moves, levers
from gcodesim.motion.joint_moves import Moves
from gcodesim.motion.tool_path import (
    MAX_PIECES,
    Array,
    TipMoves,
    TipPieces,
    at_right_angles,
    solved_axes,
)
from gcodesim.nc.program import (
    CanonicalProgram,
    Frame,
    Kind,
    arc_lengths,
    starts_of_moves,
)


@dataclass(frozen=True)
class ToolMoves:
    """What a program moves under tool centre point control.

    Attributes:
        program: the program with axis positions in place of tips, arcs of the tip as straight.
        tips: its moves of the tip.
        lengths: what their feed is counted along [mm, or deg where the tip stands], shape (n,).
        levers: how far a link may reach from each rotary joint [mm], see great_circle.levers.
    """

    program: CanonicalProgram
    centre: ToolCentre
    tips: TipMoves
    lengths: Array
    levers: Array

    def cut(self, moves: Moves, machine: Machine) -> tuple[Moves, list[Finding]]:
        """Put the pieces of the moves of the tip into the moves of the program.

        Args:
            moves: a move for every row of `tips` among others.
            machine: its joints.

        Returns:
            The moves; and what could not be followed (GC304, GC424).
        """
        tips, cut = self.tips, cut_moves(self.tips, self.centre, self.levers)
        at = np.searchsorted(moves.row, tips.row)
        count = np.ones(len(moves), np.intp)
        count[at] = np.bincount(cut.move, minlength=len(at))
        if not count[at].all():
            return self._cut_short(moves, machine, int(np.argmin(count[at])))
        index = np.repeat(np.arange(len(moves)), count)
        under = np.zeros(len(moves), bool)
        under[at] = True
        own = np.flatnonzero(under[index])
        pieces = moves.taken(index, moves.seconds[index])
        pieces.seconds[own] *= cut.share
        inner = cut.inner
        knots = solved_axes(self.centre, cut.knots, tips.offset[cut.move[inner]])
        pieces.q0[own[inner]] = positions = joint_positions(machine, knots)
        pieces.q1[own[inner - 1]] = positions
        pieces = self._with_arcs(pieces, at, own, cut.move)
        return replace(pieces, deviation_mm=cut.deviation), self._straightened(cut)

    def _cut_short(self, moves: Moves, machine: Machine, end: int) -> tuple[Moves, list[Finding]]:
        """The same for the moves of the tip before number `end`, where the program stops."""
        row = self.tips.row[end]
        before = replace(self, tips=self.tips.taken(np.arange(end)), lengths=self.lengths[:end])
        kept = moves.first(int(np.searchsorted(moves.row, row)))
        pieces, findings = before.cut(kept, machine)
        message = f"more than {MAX_PIECES} pieces of tool centre point moves; the check ends here"
        line = int(self.program.line[row])
        return pieces, [*findings, Finding("GC424", message, "max_pieces", line=line)]

    def _straightened(self, cut: TipPieces) -> list[Finding]:
        if not cut.straightened:
            return []
        message = (
            f"the tool axis of {len(cut.straightened)} block(s) cannot follow its great circle "
            "without a jump of the rotary axes: they run linearly instead"
        )
        line = int(self.program.line[self.tips.row[cut.straightened[0]]])
        return [Finding("GC304", message, "near_pole", line=line)]

    def _with_arcs(
        self, pieces: Moves, at: NDArray[np.intp], own: NDArray[np.intp], move: NDArray[np.intp]
    ) -> Moves:
        """The pieces with arcs of the joints where the tip runs along an arc and no joint turns."""
        tips = self.tips
        whole = (tips.arc[move] >= 0) & ~tips.turns(self.centre)[move]
        whole &= at_right_angles(self.centre)
        whole &= np.bincount(move, minlength=len(at))[move] == 1
        chosen = move[whole]
        arcs = tips.arcs[tips.arc[chosen]].copy()
        for name in ("u", "v", "lift"):
            arcs[name] = self.centre.axis_directions(arcs[name], tips.start[chosen, 3:])
        arc = pieces.arc.copy()
        arc[own[whole]] = len(pieces.arcs) + np.arange(len(chosen), dtype=np.int32)
        return replace(pieces, arc=arc, arcs=np.concatenate([pieces.arcs, arcs]))


def followed(
    program: CanonicalProgram, machine: Machine
) -> tuple[CanonicalProgram, ToolMoves | None, list[Finding]]:
    """The program with axis positions throughout, and its moves under tool centre point control.

    None when it has none. On a machine that cannot follow them it ends before the first (GC402).
    """
    under = np.flatnonzero((program.kind <= Kind.ARC) & (program.frame != Frame.MACHINE))
    if not len(under):
        return program, None, []
    try:
        moves = tool_moves(program, machine, under)
    except OrientationError as error:
        line = int(program.line[under[0]])
        finding = Finding("GC402", f"{error}; the check ends here", error.meaning, line=line)
        return _before(program, int(under[0])), None, [finding]
    return moves.program, moves, []


def tool_moves(program: CanonicalProgram, machine: Machine, under: NDArray[np.intp]) -> ToolMoves:
    """What the moves `under` of a program mean for the joints.

    Raises:
        OrientationError: the machine cannot follow such moves.
    """
    centre = tool_centre(machine)
    if centre is None:
        message = "tool centre point control needs a rotary axis between the work and the tool"
        raise OrientationError("kinematics_unsolved", message)
    offset = _tool_offsets(program)
    to, kind = program.to.copy(), program.kind.copy()
    to[under] = solved_axes(centre, program.to[under], offset[under])
    kind[under] = np.where(kind[under] == Kind.ARC, Kind.FEED, kind[under])
    straight = replace(program, to=to, kind=kind)
    start = starts_of_moves(straight)[under]
    moved = (start != to[under]).any(axis=1) | (program.kind[under] == Kind.ARC)
    start[:, :3] = _start_tips(program, under, centre, start, offset)
    under, start, end = under[moved], start[moved], program.to[under[moved]]
    arc, arcs = arc_pieces(program, under, start[:, :3], end[:, :3])
    great = program.frame[under] == Frame.GREAT_CIRCLE
    tips = TipMoves(under, start, end, offset[under], arc, arcs, great)

    lengths = _tip_lengths(program, tips)
    alone = (lengths < STILL_MM) & tips.turns(centre)
    turned = np.linalg.norm(end[:, 3:] - start[:, 3:], axis=1)
    lengths = np.where(alone, turned, np.maximum(lengths, np.finfo(float).tiny))
    reach = levers(machine, centre) if great.any() else np.zeros(len(centre.rotary.joints))
    return ToolMoves(straight, centre, tips, lengths, reach)


def _before(program: CanonicalProgram, row: int) -> CanonicalProgram:
    """The commands before a row."""
    columns = ("kind", "line", "frame", "to", "f", "feed_mode", "speed", "aux")
    turning = None if program.turning is None else program.turning[:row]
    before = {name: getattr(program, name)[:row] for name in columns}
    return replace(program, turning=turning, **before)


def _tool_offsets(program: CanonicalProgram) -> Array:
    """Tool offset X Y Z in force at every command, shape (n, 3) [mm]."""
    sets = program.kind == Kind.TOOL_OFFSET
    last = np.maximum.accumulate(np.where(sets, np.arange(1, len(program) + 1), 0))
    return np.concatenate([np.zeros((1, 3)), program.to[:, :3]])[last]


def _start_tips(
    program: CanonicalProgram,
    under: NDArray[np.intp],
    centre: ToolCentre,
    before: Array,
    offset: Array,
) -> Array:
    """Tips (n, 3) before the moves `under`: the end of the tip move before, or from the joints."""
    moves = np.flatnonzero(program.kind <= Kind.ARC)
    previous = moves[np.maximum(np.searchsorted(moves, under) - 1, 0)]
    follows = (previous < under) & (program.frame[previous] != Frame.MACHINE)
    follows &= (offset[previous] == offset[under]).all(axis=1)
    tips = program.to[previous, :3]
    tips[~follows] = centre.tips(before[~follows], offset[under][~follows])
    return tips


def _tip_lengths(program: CanonicalProgram, tips: TipMoves) -> Array:
    """Length of the way of each tip [mm], shape (n,)."""
    lengths = np.linalg.norm(tips.end[:, :3] - tips.start[:, :3], axis=1)
    on_arc = np.flatnonzero(tips.arc >= 0)
    if len(on_arc):
        arcs = program.arcs[program.aux[tips.row[on_arc]]]
        lengths[on_arc] = arc_lengths(tips.start[on_arc, :3], tips.end[on_arc, :3], arcs)
    return np.asarray(lengths, np.float64)
