"""The race on one beam: does a body that may not cut come to a point of the stock before a flute?

Theorem (race). A point of the stock is met by a body exactly if the first time at which a body
holds it comes before the first time at which a flute that cuts holds it. Both are minima: no order
of execution and no stock that changes.

Theorem (beam). With flutes smaller and bodies larger by the half diagonal r of a beam, a race that
is clear on its centre line is clear on each of its points: the nearest point of the line, at the
same height, is away by a vector across it of length at most r.

Order inside a piece. Tool parts stand apart along the axis, so a point passes them from the tip up
while the tool advances along its axis, and from the top down while it retracts.
"""

from __future__ import annotations

import warp as wp

from gcodesim.collision.geometry.device import BIT_EQUAL
from gcodesim.stock.line_cuts import Growth, Seams, nothing
from gcodesim.stock.solid_lines import MOST, Beam, SolidArrays, in_solid
from gcodesim.stock.sweeps import Swept, is_beside, sweep_cut

wp.set_module_options(BIT_EQUAL)

NEVER = wp.constant(wp.int64(1 << 60))
CUTS = wp.constant(1)  # flags of an item: its flute cuts, its flute is a body, so are the others
FLUTE_IS_BODY = wp.constant(2)
OTHERS_ARE_BODIES = wp.constant(4)
ROUNDING = wp.constant(wp.float64(1.0e-7))
BOX = wp.types.vector(length=6, dtype=wp.float32)
CLOCK = wp.types.vector(length=4, dtype=wp.int64)


@wp.struct
class Primitive:
    """A frustum or a ball of a tool: see shapes_of_tools."""

    kind: wp.int32
    part: wp.int32
    shape: wp.vec4d
    seams: Seams
    lever: wp.float64  # of its points about its centre, as it turns
    reach: wp.float64  # of its points from its centre
    middle: wp.float64  # height of its centre


@wp.struct
class ItemArrays:
    """Straight pieces of the tool's way in the frame of the stock, in the order of time."""

    origin: wp.array[wp.vec3d]
    way: wp.array[wp.vec3d]
    axis: wp.array[wp.vec3d]
    tilt: wp.array[wp.vec3d]
    doubt: wp.array[wp.vec2d]  # the model is off by doubt[0] + doubt[1] * lever
    flags: wp.array[wp.int32]
    muted: wp.array[wp.int32]  # bits of the parts that are no bodies in this item
    tool: wp.array[wp.int32]
    clock: wp.array[CLOCK]  # start and end of the item, then of its piece [ps]
    law: wp.array[wp.vec3d]
    fraction: wp.array[wp.vec2d]  # of the piece, at start and end of the item


@wp.struct
class RaceArrays:
    """Everything a race reads; two rows of primitives per tool: to prove, and to witness."""

    items: ItemArrays
    solid: SolidArrays
    primitives: wp.array[Primitive]
    rows: wp.array[wp.vec3i]  # first flute, first of the others, end
    cut_box: wp.array[BOX]
    body_box: wp.array[BOX]
    leaves: wp.int32
    count: wp.int32
    period_ps: wp.int64


@wp.struct
class Question:
    """How a race is run: proving (sure = 1) or looking for a witness (-1)."""

    beam: Beam
    inset: wp.float64
    sure: wp.float64
    least: wp.float64  # overlap along the line that counts [mm]
    last: wp.int64  # samples after this one do not matter
    row: wp.int32


@wp.struct
class Hit:
    """Where a body first meets the stock on a line, and how many items were looked at for it."""

    sample: wp.int64
    item: wp.int32
    part: wp.int32
    height: wp.float64
    looks: wp.int32


@wp.struct
class Visit:
    """Where and until which item bodies come at all."""

    low: wp.float64
    high: wp.float64
    last: wp.int32


@wp.struct
class Passed:
    """What is left of the list after a piece, and the first hit in it."""

    count: wp.int32
    hit: Hit


@wp.func
def fraction_at(items: ItemArrays, k: wp.int32, time: wp.int64):
    """Fraction of the way of an item that is done at a time."""
    clock = items.clock[k]
    if time >= clock[1]:
        return wp.float64(1.0)
    tau = wp.float64(time - clock[2]) / wp.float64(clock[3] - clock[2])
    law = items.law[k]
    s = tau * (law[0] + tau * (law[1] + tau * law[2]))
    part = items.fraction[k]
    if part[1] <= part[0]:
        return wp.float64(1.0)
    return wp.clamp((s - part[0]) / (part[1] - part[0]), wp.float64(0.0), wp.float64(1.0))


@wp.func
def cut_by(job: RaceArrays, q: Question, k: wp.int32, j: wp.int32, to: wp.float64, cuts: wp.bool):
    """The interval that primitive j sweeps in item k up to a fraction of its way.

    A turning tool is followed by a part that goes straight with its centre, at the mean axis.
    """
    prim = job.primitives[j]
    part = Swept()
    part.kind = prim.kind
    part.shape = prim.shape
    part.seams = prim.seams
    part.origin = job.items.origin[k]
    part.way = job.items.way[k]
    part.axis = job.items.axis[k]
    doubt = job.items.doubt[k]
    off = doubt[0] + doubt[1] * prim.lever
    tilt = job.items.tilt[k]
    far = prim.reach + q.beam.r + off
    centre = part.origin + prim.middle * part.axis
    if is_beside(q.beam.at, centre, to * (part.way + prim.middle * tilt), far):
        return nothing()
    if doubt[1] > wp.float64(0.0):
        mean = wp.normalize(part.axis + wp.float64(0.5) * tilt)
        part.origin += prim.middle * (part.axis - mean)
        part.way += prim.middle * tilt
        part.axis = mean
    part.way = to * part.way
    growth = Growth()
    if cuts:
        growth.doubt = q.sure * off
        growth.widen = -q.beam.r
    else:
        growth.inset = q.inset
        growth.doubt = -q.sure * off
        growth.widen = q.beam.r
    return sweep_cut(part, q.beam.at, growth)


@wp.func
def meets(box: BOX, beam: Beam, r: wp.float64, low: wp.float64, high: wp.float64):
    """Whether a box comes within r of a line between two heights."""
    x = beam.at[0]
    y = beam.at[1]
    return (
        x > wp.float64(box[0]) - r
        and x < wp.float64(box[1]) + r
        and y > wp.float64(box[2]) - r
        and y < wp.float64(box[3]) + r
        and wp.float64(box[4]) - r < high
        and wp.float64(box[5]) + r > low
    )


@wp.func
def following(node: wp.int32):
    """The next subtree in the order of time; 1 = the end."""
    i = node
    while i % 2 == 1:
        i = i / 2
    return i + 1


@wp.func
def is_body(job: RaceArrays, k: wp.int32, j: wp.int32, flute: wp.bool):
    """Whether a part may not touch the stock in an item."""
    if (job.items.muted[k] >> job.primitives[j].part) & 1 != 0:
        return False
    if flute:
        return (job.items.flags[k] & FLUTE_IS_BODY) != 0
    return (job.items.flags[k] & OTHERS_ARE_BODIES) != 0


@wp.func
def visited(job: RaceArrays, q: Question):
    """Where on the line and until when bodies come at all."""
    found = Visit()
    found.low = wp.float64(1.0e9)
    found.high = wp.float64(-1.0e9)
    found.last = -1
    low = job.solid.low[2]
    high = job.solid.high[2]
    i = wp.int32(1)
    go = wp.bool(True)
    while go:
        if meets(job.body_box[i], q.beam, q.beam.r, low, high):
            if i < job.leaves:
                i = 2 * i
                continue
            k = i - job.leaves
            if job.items.clock[k][0] > q.last * job.period_ps:
                return found
            row = job.rows[2 * job.items.tool[k] + q.row]
            to = fraction_at(job.items, k, q.last * job.period_ps)
            for j in range(row[0], row[2]):
                if is_body(job, k, j, j < row[1]):
                    u = cut_by(job, q, k, j, to, False)
                    a = wp.max(u[0], low)
                    b = wp.min(u[1], high)
                    if a < b:
                        found.low = wp.min(found.low, a)
                        found.high = wp.max(found.high, b)
                        found.last = k
        i = following(i)
        if i == 1:
            go = False
    return found


@wp.func
def first_sample(
    job: RaceArrays, q: Question, k: wp.int32, j: wp.int32, to: wp.float64, left: wp.vec2d
):
    """The first sample at which a body has met an interval: sweeps only grow, so by bisection."""
    clock = job.items.clock[k]
    end = wp.min(clock[1], q.last * job.period_ps)
    low = (clock[0] + job.period_ps - wp.int64(1)) / job.period_ps - wp.int64(1)
    high = (end + job.period_ps - wp.int64(1)) / job.period_ps
    while high - low > wp.int64(1):
        middle = (low + high) / wp.int64(2)
        u = cut_by(job, q, k, j, fraction_at(job.items, k, middle * job.period_ps), False)
        if wp.min(left[1], u[1]) - wp.max(left[0], u[0]) > q.least:
            high = middle
        else:
            low = middle
    return wp.max(high, low + wp.int64(1))


@wp.func
def height_at(
    job: RaceArrays, q: Question, k: wp.int32, j: wp.int32, sample: wp.int64, left: wp.vec2d
):
    """The middle of what a body has met of an interval by a sample."""
    u = cut_by(job, q, k, j, fraction_at(job.items, k, sample * job.period_ps), False)
    return wp.float64(0.5) * (wp.max(left[0], u[0]) + wp.min(left[1], u[1]))


@wp.func
def without(lists: wp.array2d[wp.vec2d], row: wp.int32, n: wp.int32, cut: wp.vec2d):
    """Take an interval out of a list. A full list keeps what would be one more, and says so."""
    m = wp.int32(0)
    count = n
    while m < count:
        u = lists[row, m]
        if u[0] >= cut[1] or u[1] <= cut[0]:
            m += 1
        elif u[0] < cut[0] and u[1] > cut[1]:
            if count < MOST:
                lists[row, count] = wp.vec2d(cut[1], u[1])
                lists[row, m] = wp.vec2d(u[0], cut[0])
                count += 1
            else:
                lists[row, MOST] = wp.vec2d(wp.float64(1.0), wp.float64(0.0))
            m += 1
        elif u[0] < cut[0]:
            lists[row, m] = wp.vec2d(u[0], cut[0])
            m += 1
        elif u[1] > cut[1]:
            lists[row, m] = wp.vec2d(cut[1], u[1])
            m += 1
        else:
            count -= 1
            lists[row, m] = lists[row, count]
    return count


@wp.func
def passed(
    job: RaceArrays,
    q: Question,
    k: wp.int32,
    within: wp.vec2d,
    n: wp.int32,
    lists: wp.array2d[wp.vec2d],
    line: wp.int32,
):
    """Let the parts of one item pass over the list in their order: flutes take, bodies hit."""
    out = Passed()
    out.count = n
    out.hit.sample = NEVER
    flags = job.items.flags[k]
    row = job.rows[2 * job.items.tool[k] + q.row]
    to = fraction_at(job.items, k, q.last * job.period_ps)
    axis = job.items.axis[k] + wp.float64(0.5) * job.items.tilt[k]
    up = wp.dot(job.items.way[k], axis) > wp.float64(0.0)
    for step in range(row[2] - row[0]):
        j = row[0] + step
        if up:
            j = row[2] - 1 - step
        flute = j < row[1]
        cuts = flute and (flags & CUTS) != 0
        if cuts or is_body(job, k, j, flute):
            u = cut_by(job, q, k, j, to, cuts)
            a = wp.max(u[0], within[0])
            b = wp.min(u[1], within[1])
            if cuts and a < b:
                out.count = without(lists, line, out.count, wp.vec2d(a, b))
            elif a < b:
                for m in range(out.count):
                    left = lists[line, m]
                    if wp.min(left[1], b) - wp.max(left[0], a) > q.least:
                        sample = first_sample(job, q, k, j, to, left)
                        if sample < out.hit.sample:
                            out.hit.sample = sample
                            out.hit.item = k
                            out.hit.part = job.primitives[j].part
                            out.hit.height = height_at(job, q, k, j, sample, left)
    return out


@wp.func
def race(job: RaceArrays, q: Question, lists: wp.array2d[wp.vec2d], line: wp.int32):
    """The first hit on the centre line of a beam; its sample is NEVER where the beam is clear."""
    hit = Hit()
    hit.sample = NEVER
    visit = visited(job, q)
    if visit.last < 0:
        return hit
    within = wp.vec2d(visit.low, visit.high)
    n = in_solid(job.solid, q.beam, within, lists, line)
    looks = wp.int32(0)
    lists[line, MOST] = wp.vec2d(wp.float64(0.0), wp.float64(0.0))
    i = wp.int32(1)
    while n > 0:
        if meets(job.cut_box[i], q.beam, wp.float64(0.0), visit.low, visit.high) or meets(
            job.body_box[i], q.beam, q.beam.r, visit.low, visit.high
        ):
            if i < job.leaves:
                i = 2 * i
                continue
            k = i - job.leaves
            if k > visit.last:
                hit.looks = looks
                return hit
            looks += 1
            step = passed(job, q, k, within, n, lists, line)
            if step.hit.sample < NEVER:
                hit = step.hit
                hit.looks = looks
                return hit
            n = step.count
        i = following(i)
        if i == 1:
            n = 0
    hit.looks = looks
    return hit
