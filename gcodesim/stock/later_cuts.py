"""Which cut takes a point of the stock away later: what a finding says besides where it is."""

from __future__ import annotations

import warp as wp

from gcodesim.collision.geometry.device import BIT_EQUAL
from gcodesim.stock.race import CUTS, NEVER, Question, RaceArrays, cut_by, fraction_at

wp.set_module_options(BIT_EQUAL)

HALVINGS = wp.constant(40)


@wp.kernel
def cut_times(job: RaceArrays, first: wp.int32, point: wp.vec3d, time_out: wp.array[wp.int64]):
    """One thread per item: the time at which its flute comes to a point, or NEVER."""
    k = first + wp.tid()
    time_out[k - first] = NEVER
    q = Question()
    q.beam.at = wp.vec2d(point[0], point[1])
    q.sure = wp.float64(1.0)
    row = job.rows[2 * job.items.tool[k]]
    clock = job.items.clock[k]
    if (job.items.flags[k] & CUTS) != 0:
        for j in range(row[0], row[1]):
            u = cut_by(job, q, k, j, wp.float64(1.0), True)
            if u[0] < point[2] and point[2] < u[1]:
                low = clock[0]
                high = clock[1]
                for _step in range(HALVINGS):
                    middle = (low + high) / wp.int64(2)
                    v = cut_by(job, q, k, j, fraction_at(job.items, k, middle), True)
                    if v[0] < point[2] and point[2] < v[1]:
                        high = middle
                    else:
                        low = middle
                time_out[k - first] = wp.min(time_out[k - first], high)


def first_cut(
    job: RaceArrays, item: int, point: tuple[float, float, float], device: str
) -> tuple[int, int] | None:
    """Time [ps] and item of the first cut of a point from an item on, None where none comes."""
    count = int(job.count) - item
    found = wp.empty(count, dtype=wp.int64, device=device)
    wp.launch(
        cut_times, count, inputs=[job, item, wp.vec3d(*point)], outputs=[found], device=device
    )
    times = found.numpy()
    best = int(times.argmin())
    return None if times[best] >= int(NEVER) else (int(times[best]), item + best)
