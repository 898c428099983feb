"""Two-level boxes: one around a body, and one around each region of its triangles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import SNAP_MM

REGION_SIZE = 16
"""Triangles in a region at most. Smaller regions cull better and cost more box tests; measured on
the shipped machine, 8 to 24 differ by less than a fifth."""


@dataclass(frozen=True)
class Regions:
    """Triangles of one body sorted into regions.

    Attributes:
        triangles: vertices on the grid of `snap` [mm], region by region, shape (n, 3, 3).
        order: number each triangle had in the body, shape (n,).
        first: first triangle of each region, with the end appended, shape (m + 1,).
        boxes: lowest and highest corner of each region, shape (m, 2, 3); exact.
        box: the same for the whole body, shape (2, 3).
    """

    triangles: NDArray[np.float64]
    order: NDArray[np.int32]
    first: NDArray[np.int32]
    boxes: NDArray[np.float64]
    box: NDArray[np.float64]

    def only(self, keep: NDArray[np.bool_]) -> Regions:
        """The regions that are kept, with the numbers their triangles had before."""
        counts = np.diff(self.first)
        chosen = np.repeat(keep, counts)
        first = np.concatenate([[0], np.cumsum(counts[keep])]).astype(np.int32)
        return Regions(
            self.triangles[chosen], self.order[chosen], first, self.boxes[keep], self.box
        )


def snapped(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Round coordinates to the vertex grid; the NumPy twin of `predicates.snap`."""
    return np.asarray(np.rint(points / SNAP_MM) * SNAP_MM)


def build_regions(triangles: NDArray[np.float64], size: int = REGION_SIZE) -> Regions:
    """Split triangles of shape (n, 3, 3) at the median of their longest extent until they fit."""
    posed = snapped(triangles)
    centres = posed.mean(axis=1)
    regions: list[NDArray[np.intp]] = []
    stack = [np.arange(len(posed))]
    while stack:
        chosen = stack.pop()
        if len(chosen) <= size:
            regions.append(chosen)
            continue
        axis = int(np.argmax(np.ptp(centres[chosen], axis=0)))
        ordered = chosen[np.argsort(centres[chosen, axis], kind="stable")]
        half = len(ordered) // 2
        stack += [ordered[half:], ordered[:half]]
    order = np.concatenate(regions)
    first = np.concatenate([[0], np.cumsum([len(r) for r in regions])])
    low = np.array([posed[r].min(axis=(0, 1)) for r in regions])
    high = np.array([posed[r].max(axis=(0, 1)) for r in regions])
    return Regions(
        posed[order],
        order.astype(np.int32),
        first.astype(np.int32),
        np.stack([low, high], axis=1),
        np.stack([low.min(axis=0), high.max(axis=0)]),
    )
