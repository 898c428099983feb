"""The joint-space path: what every joint does over program time, as columns of path pieces."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import PS_PER_S

ARC_PIECE = np.dtype(
    [("u", "f8", 3), ("v", "f8", 3), ("lift", "f8", 3), ("r0", "f8"), ("r1", "f8"), ("sweep", "f8")]
)
"""An arc in the joints X Y Z: unit vector u from the centre to the start, v = u turned by +90
degrees in the plane, lift = motion along the normal [mm], radius r0 at the start and r1 at the end
[mm], sweep [deg] (positive from u to v, turns included)."""

CONSTANT_SPEED = (1.0, 0.0, 0.0)
"""Time law of constant speed: see Path.law."""


@dataclass(frozen=True)
class ToolChange:
    """Tool `number` goes into the spindle before piece `piece` (= piece count: at the end)."""

    piece: int
    number: int
    line: int


@dataclass(frozen=True)
class Ways:
    """n ways through joint space, straight or along an arc, each with the law it is run through.

    Linear joints are in mm; rotary joints stay in degrees to the end, because only degrees can be
    reduced to one turn without rounding.

    Attributes:
        q0, q1: joint positions at start and end, shape (n, joints).
        law: (c1, c2, c3) with s = c1 tau + c2 tau^2 + c3 tau^3, where tau runs 0..1 over the
            time and s is the fraction of the way; shape (n, 3). Every proof of the search rests
            on s never falling and staying within 0..1.
        arc: row in arcs, -1 for a joint-linear way, shape (n,).
        arcs: rows of ARC_PIECE.
        xyz: columns of the joints X, Y, Z (-1: no such joint).
    """

    q0: NDArray[np.float64]
    q1: NDArray[np.float64]
    law: NDArray[np.float64]
    arc: NDArray[np.int32]
    arcs: NDArray[np.void]
    xyz: tuple[int, int, int]

    def __len__(self) -> int:
        return len(self.q0)

    def positions_on(self, way: NDArray[np.integer], s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Joint positions at fractions `s` of the ways `way`, shape (m, joints)."""
        q0, q1 = self.q0[way], self.q1[way]
        q = q0 + s[:, None] * (q1 - q0)
        on_arc = np.flatnonzero(self.arc[way] >= 0)
        if len(on_arc):
            arcs = self.arcs[self.arc[way[on_arc]]]
            moved = arc_displacement(arcs, s[on_arc])
            for axis, column in enumerate(self.xyz):
                if column >= 0:
                    q[on_arc, column] = q0[on_arc, column] + moved[:, axis]
        at_end = s >= 1.0
        q[at_end] = q1[at_end]
        return q


@dataclass(frozen=True)
class Path(Ways):
    """n pieces, one after the other; piece i covers the times (bounds_ps[i], bounds_ps[i+1]].

    Attributes:
        joints: joint names, the order of the columns.
        bounds_ps: piece ends [ps], shape (n + 1,), strictly ascending from 0.
        line: source line, shape (n,).
        tool_changes: in the order of time.
        deviation_mm: no point of any link, nor the tip seen from the part, is farther than this
            from where the control would have it: pieces of tool centre point moves are chords.
        cuts: the flute may touch the part, for it is fed and the spindle may turn, shape (n,);
            None = throughout.
        touching: what the flute touches is what a skip move is for, shape (n,); None = nowhere.
    """

    joints: tuple[str, ...]
    bounds_ps: NDArray[np.int64]
    line: NDArray[np.int32]
    tool_changes: tuple[ToolChange, ...] = ()
    deviation_mm: float = 0.0
    cuts: NDArray[np.bool_] | None = None
    touching: NDArray[np.bool_] | None = None

    @property
    def duration_ps(self) -> int:
        """Program time [ps]."""
        return int(self.bounds_ps[-1])

    @property
    def duration_s(self) -> float:
        """Program time [s]."""
        return self.duration_ps / PS_PER_S

    def piece_at(self, time_ps: NDArray[np.int64]) -> NDArray[np.int32]:
        """Piece in force at each time; a boundary belongs to the piece that ends there."""
        piece = np.searchsorted(self.bounds_ps, time_ps, side="left") - 1
        return np.clip(piece, 0, max(len(self) - 1, 0)).astype(np.int32)

    def positions(self, time_ps: NDArray[np.int64]) -> NDArray[np.float64]:
        """Joint positions at the given times, shape (m, joints) [mm, deg].

        The NumPy twin of `joint_position` in collision/geometry/poses.py.
        """
        times = np.atleast_1d(np.asarray(time_ps, dtype=np.int64))
        piece = self.piece_at(times)
        start, end = self.bounds_ps[piece], self.bounds_ps[piece + 1]
        tau = (times - start) / (end - start)
        return self.positions_on(piece, path_fraction(self.law[piece], tau))


def path_fraction(law: NDArray[np.float64], tau: NDArray[np.float64]) -> NDArray[np.float64]:
    """Evaluate the time law: fraction of the path at the fraction `tau` of the duration."""
    s = tau * (law[:, 0] + tau * (law[:, 1] + tau * law[:, 2]))
    return np.where(tau >= 1.0, 1.0, s)


def standing(path: Path, time_ps: int) -> Path:
    """The picosecond before a time as one piece on which nothing moves; its bounds are not from 0.

    At time 0 it is the first picosecond.
    """
    start, at = max(time_ps - 1, 0), np.array([time_ps])
    return replace(
        path,
        q0=path.positions(at),
        q1=path.positions(at),
        law=np.array([CONSTANT_SPEED]),
        arc=np.array([-1], np.int32),
        bounds_ps=np.array([start, start + 1]),
        line=path.line[path.piece_at(at)],
        tool_changes=(),
        cuts=None if path.cuts is None else np.zeros(1, np.bool_),
        touching=None,
    )


def arc_displacement(arcs: NDArray[np.void], s: NDArray[np.float64]) -> NDArray[np.float64]:
    """Displacement from the start point after the fraction `s` of each arc, shape (m, 3) [mm].

    Written as a chord, 2 r sin(d/2), so that a tiny arc of a huge radius loses no digits.
    """
    half = np.radians(arcs["sweep"] * s * 0.5)
    sine, cosine = np.sin(half), np.cos(half)
    grown = (arcs["r1"] - arcs["r0"]) * s
    radius = arcs["r0"] + grown
    along_u = grown - 2.0 * radius * sine * sine
    along_v = 2.0 * radius * sine * cosine
    moved: NDArray[np.float64] = (
        along_u[:, None] * arcs["u"] + along_v[:, None] * arcs["v"] + s[:, None] * arcs["lift"]
    )
    return moved
