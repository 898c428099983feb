"""Arcs in displacement form: made from the program, and how fast each axis runs on them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gcodesim.motion.path import ARC_PIECE
from gcodesim.nc.program import CanonicalProgram, Kind, arc_sweeps


def arc_pieces(
    program: CanonicalProgram,
    rows: NDArray[np.intp],
    start: NDArray[np.float64],
    end: NDArray[np.float64],
) -> tuple[NDArray[np.int32], NDArray[np.void]]:
    """Arcs of the commands `rows`, which run from `start` to `end`, shapes (n, 3) [mm].

    Returns:
        Index of the arc of every command, -1 where it is none, shape (n,); rows of ARC_PIECE.
    """
    on_arc = np.flatnonzero(program.kind[rows] == Kind.ARC)
    index = np.full(len(rows), -1, np.int32)
    index[on_arc] = np.arange(len(on_arc), dtype=np.int32)
    source = program.arcs[program.aux[rows[on_arc]]]
    return index, displacement_arcs(source, start[on_arc], end[on_arc])


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


def steepest_rises(arcs: NDArray[np.void]) -> NDArray[np.float64]:
    """Largest |dx/ds| of X, Y and Z over each arc, s from 0 to 1 along it; shape (n, 3) [mm].

    At the angle p from where a coordinate is largest it changes by -w r sin(p) m + lift, m its
    share of the plane, w the sweep: largest at a quarter turn, if the arc comes by there, else at
    an end. Exact for a circle; where the radius grows by g, at most m |g| (|w| + 2) too large.
    """
    sweep = np.radians(arcs["sweep"])[:, None]
    share, base = np.hypot(arcs["u"], arcs["v"]), np.arctan2(arcs["v"], arcs["u"])
    low, high = np.minimum(sweep, 0.0) - base, np.maximum(sweep, 0.0) - base
    radii = arcs["r0"][:, None], arcs["r1"][:, None]
    ends = [-sweep * r * share * np.sin(p) for r in radii for p in (low, high)]
    most = np.abs(sweep) * share * np.maximum(*radii)
    quarter = np.sign(sweep) * np.pi / 2.0
    up = np.where(_passes(low, high, -quarter), most, np.max(ends, axis=0))
    down = np.where(_passes(low, high, quarter), -most, np.min(ends, axis=0))
    grown = share * np.abs(radii[1] - radii[0])
    rises = np.maximum(np.abs(up + arcs["lift"]), np.abs(down + arcs["lift"])) + grown
    return np.asarray(rises, np.float64)


def _passes(
    low: NDArray[np.float64], high: NDArray[np.float64], angle: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Whether an angle, or it plus whole turns, lies between two others [rad]."""
    turn = 2.0 * np.pi
    return np.asarray(np.floor((high - angle) / turn) >= np.ceil((low - angle) / turn))
