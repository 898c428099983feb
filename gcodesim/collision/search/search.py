"""The search over a path: windows of pieces times pairs, in the order of time, on all CPU threads.

A chunk of windows shares the tables of dyadic motion, so memory does not grow with the program.
Chunks grow with the path already searched, and windows with their chunk, up to 2^LEVEL pieces: an
early contact costs little more than the path before it. Batches of windows run as launches side by
side (a launch releases the interpreter lock), each with its own best contact, merged after it: the
minimum does not depend on which launch finds it.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import numpy as np
import warp as wp
from numpy.typing import NDArray

from gcodesim.collision.bodies.keys import NO_CONTACT, sample_and_pair
from gcodesim.collision.bodies.scene import Scene
from gcodesim.collision.bounds.chords import MotionArrays, pose_knots
from gcodesim.collision.bounds.forest import Forest
from gcodesim.collision.bounds.motion_bounds import dyadic_motion
from gcodesim.collision.geometry.device import lent
from gcodesim.collision.geometry.poses import PathArrays, Pose
from gcodesim.collision.search.search_kernel import (
    RESULT_SIZE,
    STACK_SIZE,
    Chains,
    RootArrays,
    search_roots,
)
from gcodesim.constants import SLACK_MM
from gcodesim.machine.model import Joint
from gcodesim.motion.path import Path
from gcodesim.motion.samples import SomePieces

LEVEL = 7
"""Pieces in a window: at most 2^7. Longer windows prove more at once, shorter ones share better."""

FIRST_CHUNK, LAST_CHUNK = 256, 8192
"""Pieces that share one set of motion tables: at the start of a search, and at most."""

WINDOWS = 32
"""Windows that a chunk has at least, unless they would be shorter than a piece."""

ALL = slice(None)

STACK_LIMIT = STACK_SIZE
"""Items a thread of the kernel may hold; fewer only make it split roots more often."""

BATCH = 1024
"""Pieces per launch on the CPU: what runs before a contact found elsewhere is heard of."""


@dataclass(frozen=True)
class SearchSettings:
    """How a search proves.

    Attributes:
        period_ps: sample period [ps].
        mode: one of the kernel's: MODE_AT_SAMPLES, MODE_AT_ALL_TIMES, MODE_MINIMUM (the smallest
            distance) or MODE_APPROACH (the first sample step in which a distance falls to free_mm).
        free_mm: per pair, a proof must leave more than this [mm]; negative = the pair is left out.
        threads: launches side by side on the CPU.
        part: MODE_MINIMUM need not tell distances apart that differ by less than this part.
        together: MODE_MINIMUM wants the smallest distance of all pairs only, in a slot of its own
            after theirs; what the others keep is an upper bound.
    """

    period_ps: int
    mode: int
    free_mm: tuple[float, ...]
    threads: int = field(default_factory=lambda: os.cpu_count() or 1)
    part: float = 0.0
    together: bool = False


@dataclass
class Outcome:
    """What a search found.

    Attributes:
        best: lowest key (sample, pair) in contact, NO_CONTACT when none.
        near: per pair (or root) the start of the first sample step [ps] in which the distance
            falls to free_mm between samples; NO_CONTACT when none.
        distance: per pair (or root) the smallest distance [mm], inf when not asked for.
        items, triangle_tests: work done.
        overflows: (root, pair)s whose stack was full; see Searcher.settle.
    """

    near: NDArray[np.int64]
    distance: NDArray[np.float64]
    best: int = NO_CONTACT
    items: int = 0
    triangle_tests: int = 0
    overflows: int = 0

    @classmethod
    def nothing(cls, slots: int, best: int = NO_CONTACT) -> Outcome:
        """The outcome before anything was looked at."""
        return cls(np.full(slots, NO_CONTACT), np.full(slots, np.inf), best)

    def merge(self, other: Outcome, slots: slice = ALL) -> None:
        """Add the outcome of a launch or of another search, which may have some slots only."""
        near, distance = self.near.copy(), self.distance.copy()
        near[slots] = np.minimum(near[slots], other.near)
        distance[slots] = np.minimum(distance[slots], other.distance)
        self.near, self.distance = near, distance
        self.best = min(self.best, other.best)
        self.items += other.items
        self.triangle_tests += other.triangle_tests
        self.overflows += other.overflows


@dataclass(frozen=True)
class Roots:
    """Where a search starts: runs of pieces (level >= 0) or stretches of one piece (-1).

    `free_mm` is what a proof must leave of each root [mm]; None = what it must of each pair.
    """

    piece: NDArray[np.int32]
    level: NDArray[np.int32]
    start_ps: NDArray[np.int64]
    end_ps: NDArray[np.int64]
    free_mm: NDArray[np.float64] | None = None

    def part(self, cut: slice | NDArray[np.intp]) -> Roots:
        """Some of the roots."""
        free = None if self.free_mm is None else self.free_mm[cut]
        return Roots(self.piece[cut], self.level[cut], self.start_ps[cut], self.end_ps[cut], free)

    def followed_by(self, other: Roots) -> Roots:
        """These roots and the others, without what a proof must leave of them."""
        names = ("piece", "level", "start_ps", "end_ps")
        return Roots(*(np.concatenate([getattr(r, n) for r in (self, other)]) for n in names))

    def halves(self, bounds_ps: NDArray[np.int64], period_ps: int) -> list[Roots]:
        """The first and the second half of the roots, or of the one root; cut at samples only.

        Empty where one root has no sample inside.
        """
        if len(self.piece) > 1:
            half = len(self.piece) // 2
            return [self.part(slice(half)), self.part(slice(half, None))]
        piece, level = int(self.piece[0]), int(self.level[0])
        if level > 0:
            ends = (piece, piece + (1 << (level - 1)))
            return [_root(p, level - 1, 0, 0, self.free_mm) for p in ends]
        start, end = int(self.start_ps[0]), int(self.end_ps[0])
        if level == 0:
            start, end = bounds_ps[[piece, piece + 1]].tolist()
        cut = max((start + end) // 2 // period_ps, start // period_ps + 1) * period_ps
        if cut >= end:
            return []
        return [_root(piece, -1, *ends, self.free_mm) for ends in ((start, cut), (cut, end))]


def _root(
    piece: int, level: int, start_ps: int, end_ps: int, free_mm: NDArray[np.float64] | None
) -> Roots:
    one = np.array([piece, level], np.int32), np.array([start_ps, end_ps], np.int64)
    return Roots(one[0][:1], one[0][1:], one[1][:1], one[1][1:], free_mm)


@dataclass(frozen=True)
class Searcher:
    """A scene with its forest, ready to search stretches of one path.

    Attributes:
        stretches: pieces to look at; None = all.
        undecided: roots that could not be searched to the end, shared by copies of the searcher;
            while there are any, no answer is complete.
    """

    scene: Scene
    forest: Forest
    path: Path
    arrays: PathArrays
    joints: tuple[Joint, ...]
    settings: SearchSettings
    stretches: SomePieces | None = None
    undecided: list[Roots] = field(default_factory=list)

    def chunks(self, first: int, end: int) -> Iterator[tuple[int, int]]:
        """Yield runs of pieces that share motion tables."""
        step = FIRST_CHUNK
        while first < end:
            yield first, min(first + step, end)
            first, step = first + step, min(2 * step, LAST_CHUNK)

    def windows(self, first: int, end: int) -> tuple[Roots, MotionArrays]:
        """The pieces first..end in windows of one length, and their motion tables."""
        level = min(LEVEL, max(0, ((end - first) // WINDOWS).bit_length() - 1))
        starts = np.arange(first, end, 1 << level, dtype=np.int32)
        levels = np.full(len(starts), level, np.int32)
        if self.stretches is not None:
            # Windows of wanted pieces only stay whole, of others the wanted pieces are left.
            wanted = self.stretches.wanted[first:end]
            whole = np.logical_and.reduceat(wanted, starts - first)
            alone = np.flatnonzero(wanted & ~np.repeat(whole, 1 << level)[: end - first]) + first
            starts = np.concatenate([starts[whole], alone]).astype(np.int32)
            levels = np.where(np.arange(len(starts)) < whole.sum(), level, 0).astype(np.int32)
            order = np.argsort(starts)
            starts, levels = starts[order], levels[order]
        zero = np.zeros(len(starts), np.int64)
        return Roots(starts, levels, zero, zero), self.motion(first, end, level)

    def until(self, time_ps: int, end_ps: int) -> int:
        """How far what begins at a time may be followed, at most to `end_ps` [ps]."""
        return end_ps if self.stretches is None else min(end_ps, self.stretches.end_ps(time_ps))

    def search_pieces(self, first: int, end: int, before: Outcome | None = None) -> Outcome:
        """Search the pieces first..end for all pairs, going on from what was found before."""
        roots, motion = self.windows(first, end)
        outcome = before or Outcome.nothing(len(self.scene.pairs))
        if not len(roots.piece):
            return outcome
        starts, level = roots.piece, int(roots.level.max())
        on_cpu = self.scene.device == "cpu"
        size = max(1, BATCH >> level) if on_cpu else len(starts)
        batches = [(i, min(i + size, len(starts))) for i in range(0, len(starts), size)]
        lock = threading.Lock()

        def run(batch: tuple[int, int]) -> None:
            part = roots.part(slice(*batch))
            sample = int(self.path.bounds_ps[part.piece[0]]) // self.settings.period_ps
            with lock:
                best, distance = outcome.best, outcome.distance
            if sample_and_pair(best)[0] < sample:
                return
            found = self.settle(part, motion, best, distance)
            with lock:
                outcome.merge(found)

        if on_cpu and self.settings.threads > 1 and len(batches) > 1:
            with ThreadPoolExecutor(self.settings.threads) as pool:
                list(pool.map(run, batches))
        else:
            for batch in batches:
                run(batch)
        return outcome

    def search_stretches(self, roots: Roots, pair: int) -> Outcome:
        """Search stretches of single pieces for one pair; outcomes have an entry per stretch."""
        first, end = int(roots.piece.min()), int(roots.piece.max()) + 1
        distance = np.full(len(roots.piece), np.inf)
        return self.settle(roots, self.motion(first, end), NO_CONTACT, distance, pair)

    def settle(
        self,
        roots: Roots,
        motion: MotionArrays,
        best: int,
        distance: NDArray[np.float64],
        pair: int | None = None,
    ) -> Outcome:
        """Run the kernel on some roots; where a stack was full, on their halves again.

        What was found before a stack was full is true all the same: a contact stays one.
        """
        found = self.launch(roots, motion, best, distance, pair)
        if not found.overflows:
            return found
        found.overflows = 0
        halves = roots.halves(self.path.bounds_ps, self.settings.period_ps)
        if not halves:
            self.undecided.append(roots)
        own_slots = pair is not None and len(roots.piece) > 1
        slot = 0
        for half in halves:
            slots = slice(slot, slot + len(half.piece)) if own_slots else ALL
            found.merge(
                self.settle(half, motion, min(best, found.best), found.distance[slots], pair), slots
            )
            slot += len(half.piece)
        return found

    def motion(self, first: int, end: int, level: int = 0) -> MotionArrays:
        """Motion tables of runs of 2^level pieces and less, and knot poses, of first..end."""
        device = self.scene.device
        tables = dyadic_motion(self.path, self.joints, first, end, level)
        count = ((end - first + (1 << level) - 1) >> level) << level
        arrays = MotionArrays()
        arrays.first, arrays.end = first, end
        arrays.level_first = lent(tables.level_first, wp.int32, device)
        arrays.moved = lent(tables.moved, wp.float64, device)
        arrays.deviation = lent(tables.deviation, wp.float64, device)
        arrays.row = self.forest.row
        sides = len(self.forest.distinct.first) - 1
        arrays.knot = wp.zeros((sides, count + 1), dtype=Pose, device=device)
        wp.launch(
            pose_knots,
            dim=(sides, count + 1),
            inputs=[self.arrays, self.forest.distinct, first, end - first],
            outputs=[arrays.knot],
            device=device,
        )
        return arrays

    def launch(
        self,
        roots: Roots,
        motion: MotionArrays,
        best: int,
        distance: NDArray[np.float64],
        pair: int | None = None,
    ) -> Outcome:
        """Run the kernel on some roots, for one pair or for all."""
        device = self.scene.device
        chains = Chains()
        chains.pairs, chains.sides = self.scene.chains, self.forest.sides
        arrays = RootArrays()
        arrays.piece = lent(roots.piece, wp.int32, device)
        arrays.level = lent(roots.level, wp.int32, device)
        arrays.start_ps = lent(roots.start_ps, wp.int64, device)
        arrays.end_ps = lent(roots.end_ps, wp.int64, device)
        arrays.period_ps = self.settings.period_ps
        free = np.array(self.settings.free_mm)
        if pair is not None:
            given = roots.free_mm
            free = np.full(len(roots.piece), free[pair]) if given is None else given
        arrays.free_mm = lent(free + SLACK_MM, wp.float64, device)
        arrays.touching_mm = SLACK_MM
        arrays.stack_limit = STACK_LIMIT
        arrays.mode = self.settings.mode
        arrays.part = self.settings.part
        arrays.together = len(self.scene.pairs) if self.settings.together else -1
        arrays.first_pair = pair or 0
        arrays.per_root = int(pair is not None)
        near = lent(np.full(len(distance), NO_CONTACT), wp.int64, device)
        distances = lent(distance.copy(), wp.float64, device)
        start = np.zeros(RESULT_SIZE, np.int64)
        start[0] = best
        result = lent(start, wp.int64, device)
        wp.launch(
            search_roots,
            dim=(len(roots.piece), 1 if pair is not None else len(self.scene.pairs)),
            inputs=[self.arrays, chains, self.forest.arrays, motion, arrays],
            outputs=[near, distances, result],
            device=device,
        )
        return Outcome(near.numpy(), distances.numpy(), *result.numpy().tolist())
