"""Joint-space moves on their way from the program to the path: each stage maps moves to moves."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gcodesim.motion.path import Ways


@dataclass(frozen=True)
class Moves(Ways):
    """m moves in the order of execution; a dwell is a move that stands still.

    Attributes:
        row: command of the program a move belongs to, never falling, shape (m,).
        seconds: time it takes, shape (m,).
        deviation_mm: see Path.
    """

    row: NDArray[np.intp]
    seconds: NDArray[np.float64]
    deviation_mm: float = 0.0

    def first(self, count: int) -> Moves:
        """The first `count` moves."""
        return self.taken(np.arange(count), self.seconds[:count])

    def taken(self, index: NDArray[np.intp], seconds: NDArray[np.float64]) -> Moves:
        """The moves `index`, each with its time."""
        return replace(
            self,
            q0=self.q0[index],
            q1=self.q1[index],
            law=self.law[index],
            arc=self.arc[index],
            row=self.row[index],
            seconds=seconds,
        )

    def cut(
        self, index: NDArray[np.intp], start: NDArray[np.float64], end: NDArray[np.float64]
    ) -> Moves:
        """Stretches of moves, from fraction `start` to `end`; seconds are still to be set.

        The stretches of each move follow each other from 0 to 1. An end is the same number as the
        start of the next one: no gaps.
        """
        split = self.taken(index, np.zeros(len(index)))
        later = np.flatnonzero(start > 0.0)
        split.q0[later] = self.positions_on(index[later], start[later])
        split.q1[later - 1] = split.q0[later]
        parts = np.flatnonzero((split.arc >= 0) & ((start > 0.0) | (end < 1.0)))
        pieces = sub_arcs(self.arcs[split.arc[parts]], start[parts], end[parts])
        split.arc[parts] = len(self.arcs) + np.arange(len(parts), dtype=np.int32)
        return replace(split, arcs=np.concatenate([self.arcs, pieces]))


def sub_arcs(
    arcs: NDArray[np.void], start: NDArray[np.float64], end: NDArray[np.float64]
) -> NDArray[np.void]:
    """The stretches of arcs (ARC_PIECE) between two fractions, exact but for rounding."""
    cut = arcs.copy()
    # Whole turns leave the directions as they are; what is left keeps its digits.
    angle = np.radians(np.fmod(arcs["sweep"] * start, 360.0))
    sine, cosine = np.sin(angle)[:, None], np.cos(angle)[:, None]
    cut["u"] = cosine * arcs["u"] + sine * arcs["v"]
    cut["v"] = cosine * arcs["v"] - sine * arcs["u"]
    grown = arcs["r1"] - arcs["r0"]
    cut["r0"], cut["r1"] = arcs["r0"] + grown * start, arcs["r0"] + grown * end
    cut["sweep"] = arcs["sweep"] * (end - start)
    cut["lift"] = arcs["lift"] * (end - start)[:, None]
    return cut


def arc_lengths(arcs: NDArray[np.void]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Length of arcs in their plane and in all, shape (n,) each [mm].

    A radius that changes counts with its mean along the angle and its change across it.
    """
    along = (arcs["r0"] + arcs["r1"]) / 2.0 * np.radians(np.abs(arcs["sweep"]))
    flat = np.hypot(along, arcs["r1"] - arcs["r0"])
    return flat, np.hypot(flat, np.linalg.norm(arcs["lift"], axis=1))
