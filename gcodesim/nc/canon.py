"""Writes a canonical program as JSON Lines: one object per command, machine mm and degrees."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any, TextIO

import numpy as np

from gcodesim.nc.control.interpreter import Interpretation
from gcodesim.nc.program import CanonicalProgram, FeedMode, Frame, Kind, path_lengths

PLANES = ("YZ", "ZX", "XY")
"""Name of a plane by the axis its normal lies nearest to."""


def write_canon(interpretation: Interpretation, stream: TextIO) -> None:
    """Write commands, then the errors that stopped the program, one JSON object a line.

    Keys: line, kind (rapid feed arc dwell tool tool_offset g5x g92 message error), and by kind
    to, f [mm/min, deg/min for rotary axes alone, mm/rev under G95], plane, center, turns, index,
    value, seconds, text, meaning; file where a line is not of the main program; frame (work,
    great_circle) where a move holds the tip of the tool and not axis positions; there minutes
    instead of f where G93 times a move from a point that was counted otherwise. Stops of the
    program (M0 M1 M2 M30) and path modes (G61 G61.1 G64) are no commands here.
    """
    for row in canon_rows(interpretation):
        stream.write(json.dumps(row) + "\n")


def canon_rows(interpretation: Interpretation) -> Iterator[dict[str, Any]]:
    """Yield one object per command and error, as `write_canon` writes them."""
    program = interpretation.program
    feeds, main = _feeds(program), interpretation.files[0][0]
    for i in range(len(program)):
        kind = Kind(program.kind[i])
        if kind not in (Kind.STOP, Kind.PATH):
            file, line = interpretation.place(int(program.line[i]))
            place: dict[str, Any] = {"line": line} | ({"file": file} if file != main else {})
            row = place | {"kind": kind.name.lower()}
            frame = Frame(program.frame[i])
            is_tip = kind <= Kind.ARC and frame is not Frame.MACHINE
            row |= {"frame": frame.name.lower()} if is_tip else {}
            yield row | _details(program, i, kind, float(feeds[i]))
    for finding in interpretation.findings:
        if finding.severity == "error":
            error: dict[str, Any] = {"line": finding.line, "kind": "error"}
            error |= {"file": finding.file} if finding.file != main else {}
            yield error | {"text": finding.message, "meaning": finding.meaning}


def _details(program: CanonicalProgram, i: int, kind: Kind, feed: float) -> dict[str, Any]:
    to, aux = program.to[i].tolist(), int(program.aux[i])
    match kind:
        case Kind.RAPID:
            return {"to": to}
        case Kind.FEED:
            return {"to": to} | _feed(program, i, feed)
        case Kind.ARC:
            arc = program.arcs[aux]
            axis = int(np.argmax(np.abs(arc["normal"])))
            # A rotated work offset may turn the normal over; the named plane looks along +axis.
            sense = int(np.sign(arc["normal"][axis]))
            return {
                "plane": PLANES[axis],
                "to": to,
                "center": arc["center"].tolist(),
                "turns": sense * int(arc["turns"]),
                **_feed(program, i, feed),
            }
        case Kind.DWELL:
            return {"seconds": feed}
        case Kind.TOOL:
            return {"index": aux}
        case Kind.MESSAGE:
            return {"text": program.texts[aux]}
        case Kind.G5X:
            return {"index": aux, "value": to}
        case _:
            return {"value": to}


def _feed(program: CanonicalProgram, i: int, feed: float) -> dict[str, float]:
    return {"f": feed} if np.isfinite(feed) else {"minutes": 1.0 / float(program.f[i])}


def _feeds(program: CanonicalProgram) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Return f with inverse time turned into mm/min, or deg/min where only rotary axes move.

    Not a number where the move begins at a point that was counted in another frame, or as the tip
    of another tool: only the kinematics of the machine know how long it is.
    """
    moves = program.kind <= Kind.ARC
    inverse = (program.kind != Kind.RAPID) & moves & (program.feed_mode == FeedMode.INVERSE_TIME)
    lengths = path_lengths(program)
    tips = program.frame != Frame.MACHINE
    switches = np.diff(tips, prepend=False) | (tips & (program.kind == Kind.TOOL_OFFSET))
    last_move = np.maximum.accumulate(np.where(moves, np.arange(len(program)), -1))
    before = np.concatenate(([-1], last_move[:-1])) if len(program) else last_move
    count = np.cumsum(switches)
    known = count == np.where(before >= 0, count[before], 0)
    return np.where(inverse, np.where(known, program.f * lengths, np.nan), program.f)
