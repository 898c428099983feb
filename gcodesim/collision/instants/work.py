"""Work: machine-independent counters of what a check looks at."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

POSES, BOX_TESTS, TRIANGLE_TESTS = 0, 1, 2
"""Places of the counters."""


@dataclass
class WorkCounts:
    """Machine-independent counters of a check."""

    counts: NDArray[np.int64] = field(default_factory=lambda: np.zeros(3, np.int64))

    def add(self, items: int, triangle_tests: int) -> None:
        """Add the work of a search: an item is three poses of two nodes."""
        self.counts += np.array([3 * items, items, triangle_tests])

    @property
    def as_report(self) -> dict[str, int]:
        """The counters by their report names."""
        names = ("poses", "gap_tests", "triangle_tests")
        return {name: int(n) for name, n in zip(names, self.counts, strict=True)}
