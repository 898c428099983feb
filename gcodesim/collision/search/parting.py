"""Parting: whether two bodies that touch only leave each other, so that no new contact begins."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gcodesim.collision.bounds.departure import joint_levers
from gcodesim.collision.search.depths import DepthGauge
from gcodesim.collision.search.search import Searcher
from gcodesim.constants import DEPTH_SLACK

ASKED_INSTANTS = 9
"""Instants of a stretch of time at which it is looked whether bodies part."""

WAY_INSTANTS = 257
"""Instants that stand for the way of a contact, with straight lines between them."""


class Parting:
    """Tells of some pairs of a scene whether they part; `row` counts these pairs.

    Attributes:
        depth_gauge: measures their depths.
    """

    def __init__(self, searcher: Searcher, pairs: list[int]) -> None:
        self.searcher = searcher
        self.depth_gauge = DepthGauge(
            searcher.scene, searcher.path, searcher.arrays, searcher.joints, pairs
        )
        self._levers = joint_levers(self.depth_gauge.scene, searcher.joints)

    def parting(self, row: int, since_ps: int, start_ps: int, end_ps: int) -> bool:
        """Whether a pair that touches since a time only parts in a stretch of time.

        The bodies go back the way they came, or stand still, or the depth falls all the way.
        """
        times = np.unique(np.linspace(start_ps, end_ps, ASKED_INSTANTS).astype(np.int64))
        if (self._ways_from(row, times, since_ps, start_ps) <= DEPTH_SLACK).all():
            return True
        found = self.depth_gauge.depths(row, times)
        # At its end surfaces may still be within the tolerance that are no longer in each other.
        return bool((np.diff(found[:-2]) < 0.0).all() and found[-2:].max() <= found[0] / 2.0)

    def _ways_from(
        self, row: int, times: NDArray[np.int64], start_ps: int, end_ps: int
    ) -> NDArray[np.float64]:
        """How far the bodies are at some times from where they were in a stretch of time [mm]."""
        path, levers = self.searcher.path, self._levers[row]
        known = np.linspace(start_ps, end_ps, WAY_INSTANTS).astype(np.int64)
        asked, way = (path.positions(t) * levers for t in (times, known))
        begin, step = way[:-1], np.diff(way, axis=0)
        size = np.maximum((step * step).sum(axis=1), np.finfo(np.float64).tiny)
        apart = asked[:, None, :] - begin
        share = np.clip((apart * step).sum(axis=2) / size, 0.0, 1.0)
        return np.asarray(np.abs(apart - share[..., None] * step).sum(axis=2).min(axis=1))
