"""Rounds of beams: those that are not clear are quartered, until none is open or one is found.

Certificate and witness have two thresholds: nothing deeper than the inset, or a point deeper than
half of it. Between them either answer is right; so a wall that a body enters by any depth is
decided once r is an eighth of the inset.
"""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from gcodesim.collision.geometry.device import BIT_EQUAL, lent
from gcodesim.constants import WITNESS_OVERLAP_MM
from gcodesim.stock.race import NEVER, ROUNDING, Hit, Question, RaceArrays, race
from gcodesim.stock.solid_lines import MOST

wp.set_module_options(BIT_EQUAL)

CHUNK = 1024
"""Beams of one launch on the CPU: small enough to share the work, and its lists stay in cache."""

CHUNK_ON_GPU = 65536
"""Beams of one launch on a GPU."""

BRACKET = 2
"""Samples before the best within which no beam is opened again: a flat approach to a floor would
open all of it for one sample."""

MOST_BEAMS = 8_000_000
"""Beams of one round: beyond it the inset is too small for this stock and program."""

MOST_LOOKS = 200_000_000
"""Looks at items in all rounds, expected of the next one included: some minutes on two cores."""

MOST_PAIRS_AFTER_WITNESS = 250_000_000
"""Beams of one round times items of the program once a body is known to be in the stock: what more
of them would tell is whether it, or another, was there a little earlier."""

ROWS_ON_GPU = 10_000
"""Beams of the first round on a GPU, so that it has something to do."""


@wp.struct
class RoundArrays:
    """The beams of a round, and what is asked of each."""

    centres: wp.array[wp.vec2d]
    half: wp.vec2d
    inset: wp.float64
    witness: wp.float64
    overlap: wp.float64


@wp.struct
class FoundArrays:
    """Per beam: from which sample on it is not proved, the first witness on its line, the work."""

    proved: wp.array[wp.int64]
    sample: wp.array[wp.int64]
    item: wp.array[wp.int32]
    part: wp.array[wp.int32]
    height: wp.array[wp.float64]
    looks: wp.array[wp.int32]


@wp.kernel
def race_beams(
    job: RaceArrays,
    round_: RoundArrays,
    first: wp.int32,
    lists_out: wp.array2d[wp.vec2d],
    best_out: wp.array[wp.int64],
    found_out: FoundArrays,
):
    """One thread per beam: prove it, or look for a witness on its line."""
    line = wp.tid()
    i = first + line
    q = Question()
    q.beam.at = round_.centres[i]
    q.beam.half = round_.half
    q.beam.r = wp.length(round_.half)
    q.inset = round_.inset
    q.sure = wp.float64(1.0)
    q.least = ROUNDING
    q.last = best_out[0]
    q.row = 0
    proof = race(job, q, lists_out, line)
    hit = Hit()
    hit.sample = NEVER
    if proof.sample < NEVER:
        q.beam.half = wp.vec2d(wp.float64(0.0), wp.float64(0.0))
        q.beam.r = wp.float64(0.0)
        q.inset = round_.witness
        q.sure = wp.float64(-1.0)
        q.least = round_.overlap
        q.row = 1
        hit = race(job, q, lists_out, line)
        # A list that was full may hold what was cut away: no witness.
        if lists_out[line, MOST][0] > wp.float64(0.0):
            hit.sample = NEVER
    if hit.sample < NEVER:
        wp.atomic_min(best_out, 0, hit.sample)
    found_out.proved[i] = proof.sample
    found_out.sample[i] = hit.sample
    found_out.item[i] = hit.item
    found_out.part[i] = hit.part
    found_out.height[i] = hit.height
    found_out.looks[i] = proof.looks + hit.looks


@dataclass(frozen=True)
class RaceAim:
    """What the rounds are to decide.

    Attributes:
        inset: nothing may be deeper [mm]; a witness is deeper than `witness` of it.
        smallest: half diagonal of the smallest beams [mm].
        last: last sample that matters.
    """

    inset: float
    witness: float
    smallest: float
    last: int


@dataclass(frozen=True)
class Witness:
    """A point of the stock that a body is in: sample, item, part of the tool, place [mm]."""

    sample: int
    item: int
    part: int
    point: tuple[float, float, float]


@dataclass
class RoundsAnswer:
    """What the rounds found.

    Attributes:
        witness: the first one, None where none is.
        undecided: beams of the smallest width that are neither proved nor have a witness.
        width: of the smallest beams looked at [mm].
        proved: samples before this one are proved.
        beams: looked at.
        looks: at items, by all beams.
        too_many: the rounds ended because the next one would have had more than can be looked at.
    """

    witness: Witness | None = None
    undecided: int = 0
    width: float = 0.0
    proved: int = int(NEVER)
    beams: int = 0
    looks: int = 0
    too_many: bool = False
    rounds: list[tuple[float, int, int]] = field(default_factory=list)


def run_rounds(job: RaceArrays, aim: RaceAim, device: str, threads: int) -> RoundsAnswer:
    """Race beams over the stock, the widest first.

    Args:
        job: the race.
        aim: what is to be decided.
        device: Warp's name of it.
        threads: launches side by side on the CPU.
    """
    low, high = np.array(job.solid.low)[:2], np.array(job.solid.high)[:2]
    size = high - low
    least = float(size.min()) if device == "cpu" else float(np.sqrt(size.prod() / ROWS_ON_GPU))
    count = np.maximum(1, np.ceil(size / least - 1e-9)).astype(int)
    width = size / count
    grid = [low[k] + (np.arange(count[k]) + 0.5) * width[k] for k in (0, 1)]
    centres = np.stack(np.meshgrid(*grid), axis=-1).reshape(-1, 2)
    answer, best = RoundsAnswer(), aim.last + 1
    while len(centres):
        found = _raced(job, aim, centres, width, best, (device, threads))
        answer.beams += len(centres)
        nearest = int(found["sample"].min())
        if nearest < best:
            i = int(found["sample"].argmin())
            best = nearest
            point = (float(centres[i, 0]), float(centres[i, 1]), float(found["height"][i]))
            answer.witness = Witness(best, int(found["item"][i]), int(found["part"][i]), point)
        proved = found["proved"]
        limit = best - BRACKET if answer.witness else best
        is_open = proved < limit
        closed = proved[~is_open & (proved < best)]
        answer.proved = min(answer.proved, int(closed.min(initial=NEVER)))
        answer.width = float(width.max())
        answer.rounds.append((answer.width, len(centres), int(is_open.sum())))
        radius = float(np.hypot(*width) / 2.0)
        answer.looks += int(found["looks"].sum(dtype=np.int64))
        answer.too_many = _is_too_much(answer, 4 * found["looks"][is_open], job.leaves)
        if radius <= aim.smallest * 1.0001 or answer.too_many:
            answer.undecided = int(is_open.sum())
            answer.proved = min(answer.proved, int(proved[is_open].min(initial=NEVER)))
            break
        quarters = np.array([[-0.25, -0.25], [0.25, -0.25], [-0.25, 0.25], [0.25, 0.25]]) * width
        centres = (centres[is_open][:, None, :] + quarters).reshape(-1, 2)
        width = width / 2.0
    if answer.witness:
        answer.proved = min(answer.proved, answer.witness.sample)
    return answer


def _is_too_much(answer: RoundsAnswer, looks: NDArray[np.int32], items: int) -> bool:
    """Tell whether the next round is not worth its time, or beyond all bounds.

    Args:
        answer: so far.
        looks: of the beams that are open, four times: of those that each becomes.
        items: places in the tree of items.
    """
    beams = 4 * len(looks)
    if answer.witness:
        return beams > MOST_BEAMS or beams * items > MOST_PAIRS_AFTER_WITNESS
    expected = int(looks.sum(dtype=np.int64))
    return beams > MOST_BEAMS or answer.looks + expected > MOST_LOOKS


def _raced(
    job: RaceArrays,
    aim: RaceAim,
    centres: NDArray[np.float64],
    width: NDArray[np.float64],
    best: int,
    where: tuple[str, int],
) -> dict[str, NDArray[Any]]:
    """One round: launches of chunks of beams, side by side on the CPU."""
    device, threads = where
    count = len(centres)
    round_ = RoundArrays()
    round_.centres = lent(centres, wp.vec2d, device)
    round_.half = wp.vec2d(*(width / 2.0))
    round_.inset, round_.witness = aim.inset, aim.witness
    round_.overlap = WITNESS_OVERLAP_MM
    found = FoundArrays()
    names = {
        "proved": wp.int64,
        "sample": wp.int64,
        "item": wp.int32,
        "part": wp.int32,
        "height": wp.float64,
        "looks": wp.int32,
    }
    for name, dtype in names.items():
        setattr(found, name, wp.empty(count, dtype=dtype, device=device))
    best_so_far = wp.array([best], dtype=wp.int64, device=device)
    chunk = CHUNK if device == "cpu" else CHUNK_ON_GPU
    if device == "cpu":
        chunk = max(1, min(chunk, -(-count // (8 * threads))))
    firsts, lock = iter(range(0, count, chunk)), threading.Lock()

    def work() -> None:
        lists = wp.empty((min(chunk, count), MOST + 1), dtype=wp.vec2d, device=device)
        while True:
            with lock:
                first = next(firsts, None)
            if first is None:
                return
            wp.launch(
                race_beams,
                dim=min(chunk, count - first),
                inputs=[job, round_, first],
                outputs=[lists, best_so_far, found],
                device=device,
            )

    if device == "cpu" and threads > 1 and count > chunk:
        with ThreadPoolExecutor(threads) as pool:
            for each in [pool.submit(work) for _ in range(threads)]:
                each.result()
    else:
        work()
    return {name: getattr(found, name).numpy() for name in names}
