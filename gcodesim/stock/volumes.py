"""How much each piece of a program takes away: lines over all of the stock, in one direction.

A line stands for a square column of the stock about it. What an item takes from the list of the
line is its share; the error falls with the 1.5th power of the spacing where walls are round.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import warp as wp
from numpy.typing import NDArray

from gcodesim.collision.geometry.device import BIT_EQUAL, lent
from gcodesim.machine.model import Body
from gcodesim.stock.race import CUTS, Question, RaceArrays, cut_by, following, meets, without
from gcodesim.stock.solid_lines import MOST, Beam, on_line
from gcodesim.stock.workpiece import StockRace, StockTask

wp.set_module_options(BIT_EQUAL)


@wp.func
def length_of(lists: wp.array2d[wp.vec2d], line: wp.int32, n: wp.int32):
    """Length of all intervals of a list."""
    total = wp.float64(0.0)
    for m in range(n):
        total += lists[line, m][1] - lists[line, m][0]
    return total


@wp.func
def whole_line(job: RaceArrays, at: wp.vec2d, lists: wp.array2d[wp.vec2d], line: wp.int32):
    """The stock at the start on a line."""
    within = wp.vec2d(job.solid.low[2], job.solid.high[2])
    if job.solid.cells[0] == 0:
        lists[line, 0] = within
        return 1
    return on_line(job.solid, at, within, lists, line)


@wp.kernel
def cut_lines(
    job: RaceArrays,
    centres: wp.array[wp.vec2d],
    lists_out: wp.array2d[wp.vec2d],
    removed_out: wp.array[wp.float64],
    left_out: wp.array[wp.float64],
):
    """One thread per line: what every item takes from it [mm], and what is left."""
    line = wp.tid()
    q = Question()
    q.beam.at = centres[line]
    q.sure = wp.float64(0.0)
    beam = Beam()
    beam.at = q.beam.at
    n = whole_line(job, q.beam.at, lists_out, line)
    zero = wp.float64(0.0)
    i = wp.int32(1)
    go = wp.bool(n > 0)
    while go:
        if meets(job.cut_box[i], beam, zero, job.solid.low[2], job.solid.high[2]):
            if i < job.leaves:
                i = 2 * i
                continue
            k = i - job.leaves
            row = job.rows[2 * job.items.tool[k]]
            if (job.items.flags[k] & CUTS) != 0:
                before = length_of(lists_out, line, n)
                for j in range(row[0], row[1]):
                    u = cut_by(job, q, k, j, wp.float64(1.0), True)
                    if u[0] < u[1]:
                        n = without(lists_out, line, n, u)
                wp.atomic_add(removed_out, k, before - length_of(lists_out, line, n))
        i = following(i)
        if i == 1 or n <= 0:
            go = False
    left_out[line] = length_of(lists_out, line, wp.max(n, 0))


@dataclass(frozen=True)
class Volumes:
    """What a program takes from a stock [mm^3].

    Attributes:
        removed: by path piece, shape (pieces,).
        left: of the stock at the end.
        overflows: lines with more intervals than are kept, which keep too much.
    """

    removed: NDArray[np.float64]
    left: float
    overflows: int = 0

    def by_block(self, lines: NDArray[np.int32]) -> dict[int, float]:
        """The same by line of the program."""
        found = np.flatnonzero(self.removed > 0.0)
        total: dict[int, float] = {}
        for line, volume in zip(lines[found].tolist(), self.removed[found].tolist(), strict=True):
            total[line] = total.get(line, 0.0) + volume
        return total


def removed_volumes(
    stock: Body, task: StockTask, spacing: float, along: int | None = None
) -> Volumes:
    """What each piece takes from a stock.

    Args:
        stock: the body.
        task: machine, path and device.
        spacing: of the lines [mm].
        along: axis of the stock's link that they run along; None: that of most tools.
    """
    race = StockRace.of(stock, task, along)
    items, job = race.job(task.machine.stock_inset / 4.0)
    low, high = race.near.low[:2], race.near.high[:2]
    count = np.maximum(np.rint((high - low) / spacing).astype(int), 1)
    width = (high - low) / count
    grid = [low[k] + (np.arange(count[k]) + 0.5) * width[k] for k in (0, 1)]
    centres = np.stack(np.meshgrid(*grid), axis=-1).reshape(-1, 2)
    device, area = task.device, float(width.prod())
    lists = wp.zeros((len(centres), MOST + 1), dtype=wp.vec2d, device=device)
    removed = wp.zeros(max(len(items), 1), dtype=wp.float64, device=device)
    left = wp.zeros(len(centres), dtype=wp.float64, device=device)
    wp.launch(
        cut_lines,
        len(centres),
        inputs=[job, lent(centres, wp.vec2d, device)],
        outputs=[lists, removed, left],
        device=device,
    )
    by_piece = np.zeros(len(task.path))
    np.add.at(by_piece, items.piece, removed.numpy()[: len(items)] * area)
    overflows = int((lists.numpy()[:, MOST, 0] > 0.0).sum())
    return Volumes(by_piece, float(left.numpy().sum()) * area, overflows)
