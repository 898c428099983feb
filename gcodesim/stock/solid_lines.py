"""Where the stock at the start lies on a beam: what the centre line crosses, and what is beside it.

Triangles are found by a grid across the beams. Which of them a line crosses is decided by half-open
rules on shared edges, so that every line crosses a closed mesh in and out alike.
"""

import warp as wp

from gcodesim.collision.geometry.device import BIT_EQUAL

wp.set_module_options(BIT_EQUAL)

MOST = wp.constant(32)  # intervals kept of one line
MANY_CELLS = wp.constant(64)  # a beam over more cells takes all of the height


@wp.struct
class SolidArrays:
    """A stock: its box, and its triangles by cell of a grid; without cells it fills its box."""

    low: wp.vec3d
    high: wp.vec3d
    cells: wp.vec2i
    triangles: wp.array[wp.mat33d]
    cell_first: wp.array[wp.int32]
    cell_triangle: wp.array[wp.int32]


@wp.struct
class Beam:
    """A square column about the line at (x, y): half its widths, 0 for the line alone."""

    at: wp.vec2d
    half: wp.vec2d
    r: wp.float64


@wp.func
def is_left(px: wp.float64, py: wp.float64, a: wp.vec3d, b: wp.vec3d):
    """Whether the ray from a point along +X crosses an edge; the same for both its directions."""
    if (a[1] > py) == (b[1] > py):
        return False
    low = a
    high = b
    if a[1] > b[1]:
        low = b
        high = a
    return px < low[0] + (py - low[1]) / (high[1] - low[1]) * (high[0] - low[0])


@wp.func
def is_under(at: wp.vec2d, t: wp.mat33d):
    """Whether the line through (x, y) crosses a triangle."""
    odd = wp.bool(False)
    for i in range(3):
        if is_left(at[0], at[1], t[i], t[(i + 1) % 3]):
            odd = not odd
    return odd


@wp.func
def slopes(t: wp.mat33d):
    """The normal of a triangle, not of unit length."""
    return wp.cross(t[1] - t[0], t[2] - t[0])


@wp.func
def cell_of(solid: SolidArrays, x: wp.float64, axis: wp.int32):
    """The column or row of cells that a coordinate lies in."""
    size = solid.high[axis] - solid.low[axis]
    c = wp.int32(wp.float64(solid.cells[axis]) * (x - solid.low[axis]) / size)
    return wp.clamp(c, 0, solid.cells[axis] - 1)


@wp.func
def joined(lists: wp.array2d[wp.vec2d], row: wp.int32, n: wp.int32, a: wp.float64, b: wp.float64):
    """Add an interval to a list whose intervals stand apart; the count, or -1: it is full."""
    lo = a
    hi = b
    m = wp.int32(0)
    count = n
    while m < count:
        u = lists[row, m]
        if u[0] <= hi and u[1] >= lo:
            lo = wp.min(lo, u[0])
            hi = wp.max(hi, u[1])
            count -= 1
            lists[row, m] = lists[row, count]
        else:
            m += 1
    if count >= MOST:
        return -1
    lists[row, count] = wp.vec2d(lo, hi)
    return count + 1


@wp.func
def crossings(solid: SolidArrays, at: wp.vec2d, lists: wp.array2d[wp.vec2d], row: wp.int32):
    """Heights at which a line crosses triangles, sorted, each with +1 upwards into the solid."""
    cell = cell_of(solid, at[1], 1) * solid.cells[0] + cell_of(solid, at[0], 0)
    n = wp.int32(0)
    for i in range(solid.cell_first[cell], solid.cell_first[cell + 1]):
        t = solid.triangles[solid.cell_triangle[i]]
        if is_under(at, t):
            if n >= MOST:
                return -1
            normal = slopes(t)
            z = t[0][2]
            if normal[2] != wp.float64(0.0):
                z -= (normal[0] * (at[0] - t[0][0]) + normal[1] * (at[1] - t[0][1])) / normal[2]
            z = wp.clamp(z, wp.min(t[0][2], wp.min(t[1][2], t[2][2])),
                         wp.max(t[0][2], wp.max(t[1][2], t[2][2])))  # fmt: skip
            into = wp.float64(1.0)
            if normal[2] > wp.float64(0.0):
                into = wp.float64(-1.0)
            k = n
            while k > 0 and lists[row, k - 1][0] > z:
                lists[row, k] = lists[row, k - 1]
                k -= 1
            lists[row, k] = wp.vec2d(z, into)
            n += 1
    return n


@wp.func
def on_line(
    solid: SolidArrays,
    at: wp.vec2d,
    within: wp.vec2d,
    lists: wp.array2d[wp.vec2d],
    row: wp.int32,
):
    """The intervals of a line in the solid within a stretch; -1: more than can be kept."""
    n = crossings(solid, at, lists, row)
    depth = wp.float64(0.0)
    begin = wp.float64(0.0)
    count = wp.int32(0)
    for i in range(n):
        u = lists[row, i]
        if depth <= wp.float64(0.0) and depth + u[1] > wp.float64(0.0):
            begin = u[0]
        if depth > wp.float64(0.0) and depth + u[1] <= wp.float64(0.0):
            lo = wp.max(begin, within[0])
            hi = wp.min(u[0], within[1])
            if lo < hi:
                lists[row, count] = wp.vec2d(lo, hi)  # never beyond what was read
                count += 1
        depth += u[1]
    if n < 0:
        return -1
    return count


@wp.func
def is_apart(t: wp.mat33d, beam: Beam):
    """Whether an edge of a triangle, seen along the beam, has all of the beam on one side of it.

    Of a wall, which is seen as a line, its edges are all there is.
    """
    for i in range(3):
        a = t[i]
        b = t[(i + 1) % 3]
        x = a[1] - b[1]
        y = b[0] - a[0]
        middle = x * (beam.at[0] - a[0]) + y * (beam.at[1] - a[1])
        reach = wp.abs(x) * beam.half[0] + wp.abs(y) * beam.half[1]
        c = t[(i + 2) % 3]
        third = x * (c[0] - a[0]) + y * (c[1] - a[1])
        low = wp.min(third, wp.float64(0.0))
        high = wp.max(third, wp.float64(0.0))
        if middle - reach > high or middle + reach < low:
            return True
    return False


@wp.func
def beside(t: wp.mat33d, beam: Beam):
    """The heights that a triangle may have within a beam; empty where it does not come there."""
    low = wp.vec3d(wp.float64(0.0))
    high = wp.vec3d(wp.float64(0.0))
    for axis in range(3):
        low[axis] = wp.min(t[0][axis], wp.min(t[1][axis], t[2][axis]))
        high[axis] = wp.max(t[0][axis], wp.max(t[1][axis], t[2][axis]))
    for axis in range(2):
        if low[axis] > beam.at[axis] + beam.half[axis]:
            return wp.vec2d(wp.float64(1.0), wp.float64(-1.0))
        if high[axis] < beam.at[axis] - beam.half[axis]:
            return wp.vec2d(wp.float64(1.0), wp.float64(-1.0))
    if is_apart(t, beam):
        return wp.vec2d(wp.float64(1.0), wp.float64(-1.0))
    normal = slopes(t)
    n2 = wp.abs(normal[2])
    lean = wp.abs(normal[0]) * beam.half[0] + wp.abs(normal[1]) * beam.half[1]
    if lean < wp.float64(1.0e6) * n2:
        d = normal[0] * (beam.at[0] - t[0][0]) + normal[1] * (beam.at[1] - t[0][1])
        z = t[0][2] - d / normal[2]
        return wp.vec2d(wp.max(low[2], z - lean / n2), wp.min(high[2], z + lean / n2))
    return wp.vec2d(low[2], high[2])


@wp.func
def in_solid(
    solid: SolidArrays,
    beam: Beam,
    within: wp.vec2d,
    lists: wp.array2d[wp.vec2d],
    row: wp.int32,
):
    """The intervals that the stock may have in a beam, at least; -1: a line with too many."""
    whole = solid.cells[0] == 0
    x0 = cell_of(solid, beam.at[0] - beam.half[0], 0)
    x1 = cell_of(solid, beam.at[0] + beam.half[0], 0)
    y0 = cell_of(solid, beam.at[1] - beam.half[1], 1)
    y1 = cell_of(solid, beam.at[1] + beam.half[1], 1)
    if whole or (x1 - x0 + 1) * (y1 - y0 + 1) > MANY_CELLS:
        lists[row, 0] = within
        return 1
    n = on_line(solid, beam.at, within, lists, row)
    if beam.r == wp.float64(0.0):
        return n
    for y in range(y0, y1 + 1):
        for x in range(x0, x1 + 1):
            cell = y * solid.cells[0] + x
            for i in range(solid.cell_first[cell], solid.cell_first[cell + 1]):
                u = beside(solid.triangles[solid.cell_triangle[i]], beam)
                lo = wp.max(u[0], within[0])
                hi = wp.min(u[1], within[1])
                if n >= 0 and lo <= hi and u[0] <= u[1]:
                    n = joined(lists, row, n, lo, hi)
    if n < 0:
        lists[row, 0] = within
        return 1
    return n
