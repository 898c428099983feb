"""Which interval of a line lies in a frustum about the tool axis, larger or smaller than given.

A line runs along +Z of the stock's frame. Lengths are in mm; an empty interval has low > high.
"""

import warp as wp

from gcodesim.collision.geometry.device import BIT_EQUAL

wp.set_module_options(BIT_EQUAL)

FAR = wp.constant(wp.float64(1.0e9))
ACROSS = wp.constant(wp.float64(1.0e-9))  # cosine below which a line is parallel to the faces
COVERED = wp.constant(wp.float64(0.0))
FREE = wp.constant(wp.float64(1.0))
CONVEX = wp.constant(wp.float64(2.0))
FLAT = wp.constant(wp.float64(1.0e-12))  # a quadratic with less in front of u^2 is linear


@wp.struct
class Seams:
    """What a primitive has beside it: see shapes_of_tools.Solid."""

    low: wp.float64  # of the face at the tip's side: COVERED, FREE or CONVEX
    high: wp.float64
    below: wp.float64  # slope of the neighbour there
    above: wp.float64
    limit: wp.float64


@wp.struct
class Growth:
    """By how much a primitive is changed: smaller by inset and doubt, then larger across the line.

    The doubt is how far the part may be from where it is taken to be; negative, it makes the part
    larger. A negative `widen` makes it smaller across the line.
    """

    inset: wp.float64
    doubt: wp.float64
    widen: wp.float64


@wp.struct
class Frustum:
    """The heights of the faces along the tool axis, and radius = base + slope * height."""

    low: wp.float64
    high: wp.float64
    base: wp.float64
    slope: wp.float64


@wp.struct
class View:
    """A line, and the way of the tool, as seen from the tool: along its axis and across it."""

    oz: wp.float64
    ez: wp.float64
    vz: wp.float64
    sine: wp.float64  # of the angle between tool axis and line
    op: wp.vec3d
    ep: wp.vec3d
    vp: wp.vec3d


@wp.func
def nothing():
    """An empty interval."""
    return wp.vec2d(wp.float64(1.0), wp.float64(-1.0))


@wp.func
def view_of(at: wp.vec2d, origin: wp.vec3d, way: wp.vec3d, axis: wp.vec3d):
    """The line through (x, y) from a tool that moves along `way`."""
    view = View()
    o = wp.vec3d(at[0], at[1], wp.float64(0.0)) - origin
    view.oz = wp.dot(o, axis)
    view.ez = axis[2]
    view.vz = wp.dot(way, axis)
    view.sine = wp.sqrt(axis[0] * axis[0] + axis[1] * axis[1])
    view.op = o - view.oz * axis
    view.ep = wp.vec3d(wp.float64(0.0), wp.float64(0.0), wp.float64(1.0)) - view.ez * axis
    view.vp = way - view.vz * axis
    return view


@wp.func
def shifted_side(slope: wp.float64, sine: wp.float64):
    """How far the side moves, along the radius, as a point moves by 1 across the line."""
    k = wp.abs(slope)
    normal = wp.sqrt(wp.float64(1.0) + k * k)
    if k <= sine * normal:
        return normal
    return k * sine + wp.sqrt(wp.max(wp.float64(1.0) - sine * sine, wp.float64(0.0)))


@wp.func
def seam_rise(
    k: wp.float64, beside: wp.float64, shrink: wp.float64, r: wp.float64, sine: wp.float64
):
    """How far up two sides meet once each has moved in: by `shrink`, and r across the line."""
    one = wp.float64(1.0)
    normal = wp.sqrt(one + k * k) - wp.sqrt(one + beside * beside)
    across = shifted_side(k, sine) - shifted_side(beside, sine)
    return (shrink * normal + r * across) / (k - beside)


@wp.func
def face_rise(
    seam: wp.vec2d,
    k: wp.float64,
    up: wp.float64,
    growth: Growth,
    limit: wp.float64,
    sine: wp.float64,
):
    """How far up a face (its kind, the slope beside it) goes; up: 1 for the upper one, else -1.

    Of a convex profile, which is an intersection of cones, each side moves in for itself. A face
    that a wider neighbour covers stays, and so does a concave seam: past it there is more room.
    """
    zero = wp.float64(0.0)
    shrink = growth.inset + growth.doubt
    smaller = wp.max(shrink, zero)
    narrower = wp.max(-growth.widen, zero)
    outward = wp.max(-shrink, zero) + wp.max(growth.widen, zero) * sine
    if seam[0] == CONVEX and smaller + narrower <= limit:
        return up * outward + seam_rise(k, seam[1], smaller, narrower, sine)
    if seam[0] == COVERED:
        return up * outward
    return up * (outward - smaller - narrower * sine)


@wp.func
def changed(shape: wp.vec4d, seams: Seams, growth: Growth, sine: wp.float64):
    """A primitive (z0, z1, r0, r1) with its growth; a cone that is cut short ends at its apex."""
    g = Frustum()
    k = (shape[3] - shape[2]) / (shape[1] - shape[0])
    shrink = growth.inset + growth.doubt
    radial = growth.widen * shifted_side(k, sine) - shrink * wp.sqrt(wp.float64(1.0) + k * k)
    low = wp.vec2d(seams.low, seams.below)
    high = wp.vec2d(seams.high, seams.above)
    g.low = shape[0] + face_rise(low, k, wp.float64(-1.0), growth, seams.limit, sine)
    g.high = shape[1] + face_rise(high, k, wp.float64(1.0), growth, seams.limit, sine)
    g.slope = k
    g.base = shape[2] + radial - k * shape[0]
    r0 = g.base + k * g.low
    r1 = g.base + k * g.high
    if wp.max(r0, r1) <= wp.float64(0.0):
        g.high = g.low
    elif r0 < wp.float64(0.0):
        g.low = -g.base / k
    elif r1 < wp.float64(0.0):
        g.high = -g.base / k
    return g


@wp.func
def below_zero(a: wp.float64, b: wp.float64, c: wp.float64, lo: wp.float64, hi: wp.float64):
    """The part of [lo, hi] with a t^2 + 2 b t + c <= 0, for a >= 0."""
    if a < wp.float64(1.0e-14):
        if wp.abs(b) < wp.float64(1.0e-14):
            if c > wp.float64(0.0):
                return nothing()
            return wp.vec2d(lo, hi)
        z = -c / (wp.float64(2.0) * b)
        if b > wp.float64(0.0):
            return wp.vec2d(lo, wp.min(hi, z))
        return wp.vec2d(wp.max(lo, z), hi)
    d = b * b - a * c
    if d < wp.float64(0.0):
        return nothing()
    s = wp.sqrt(d)
    return wp.vec2d(wp.max(lo, (-b - s) / a), wp.min(hi, (-b + s) / a))


@wp.func
def standing_cut(line: View, sigma: wp.float64, g: Frustum):
    """The interval of a line in a frustum that stands at the fraction sigma of its way."""
    oz = line.oz - sigma * line.vz
    op = line.op - sigma * line.vp
    lo = -FAR
    hi = FAR
    if wp.abs(line.ez) < ACROSS:
        if oz <= g.low or oz >= g.high:
            return nothing()
    else:
        u0 = (g.low - oz) / line.ez
        u1 = (g.high - oz) / line.ez
        lo = wp.min(u0, u1)
        hi = wp.max(u0, u1)
    c0 = g.base + g.slope * oz
    c1 = g.slope * line.ez
    a = line.sine * line.sine - c1 * c1
    b = wp.dot(op, line.ep) - c0 * c1
    c = wp.dot(op, op) - c0 * c0
    if a >= FLAT:
        return below_zero(a, b, c, lo, hi)
    if a > -FLAT:
        return below_zero(wp.float64(0.0), b, c, lo, hi)
    d = b * b - a * c
    if d <= wp.float64(0.0):
        return wp.vec2d(lo, hi)
    # A line steeper than the side is inside beyond both roots, on one side of the apex each.
    s = wp.sqrt(d)
    if c1 > wp.float64(0.0):
        return wp.vec2d(wp.max(lo, (-b - s) / a), hi)
    return wp.vec2d(lo, wp.min(hi, (-b + s) / a))
