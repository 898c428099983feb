"""Which interval of a line a tool part sweeps as it moves straight with its axis fixed.

Lemma. {(u, sigma): point u of the line lies in the part at the fraction sigma of its way} is the
affine preimage of a convex set in a strip: convex. So a sweep cuts one interval, and its ends are
extreme points of that set: those at sigma = 0 or 1, on the rim of a face, or where the line touches
the side (dQ/dsigma = 0). Each candidate kept below lies in the set, and none is forgotten.
"""

import warp as wp

from gcodesim.collision.geometry.device import BIT_EQUAL
from gcodesim.stock.line_cuts import (
    FAR,
    Frustum,
    Growth,
    Seams,
    View,
    below_zero,
    changed,
    nothing,
    standing_cut,
    view_of,
)

wp.set_module_options(BIT_EQUAL)

BALL = wp.constant(wp.int32(1))
BALL_STEPS = wp.constant(wp.int32(40))
BALL_GOOD_TO = wp.constant(wp.float64(1.0e-7))
MISSED = wp.constant(wp.float64(-1.0e9))


@wp.func
def hull(a: wp.vec2d, b: wp.vec2d):
    """The smallest interval that holds two."""
    if b[0] > b[1]:
        return a
    if a[0] > a[1]:
        return b
    return wp.vec2d(wp.min(a[0], b[0]), wp.max(a[1], b[1]))


@wp.func
def ball_height(t: wp.float64, off: wp.float64, rise: wp.float64, size: wp.vec2d):
    """Height of the top of a ball (radius, narrower) over a line, its slope and its bend.

    t: distance of its centre along its way from the foot of the line, `off` that across it.
    """
    away = wp.sqrt(off * off + t * t)
    g = away + size[1]
    if g <= wp.float64(0.0):
        return wp.vec3d(t * rise + size[0], rise, wp.float64(0.0))
    if g >= size[0]:
        return wp.vec3d(MISSED, wp.float64(0.0), wp.float64(0.0))
    h = wp.sqrt(size[0] * size[0] - g * g)
    away = wp.max(away, wp.float64(1.0e-12))
    g1 = t / away
    fall = g * g1 / h
    bend = (g1 * g1 + g * off * off / (away * away * away) + fall * fall) / h
    return wp.vec3d(t * rise + h, rise - fall, bend)


@wp.func
def ball_top(span: wp.vec2d, off: wp.float64, rise: wp.float64, size: wp.vec2d, outer: wp.bool):
    """Largest height over a span: it is concave, so that slope times bracket bounds it."""
    a = span[0]
    b = span[1]
    ha = ball_height(a, off, rise, size)
    hb = ball_height(b, off, rise, size)
    best = wp.max(ha[0], hb[0])
    if ha[0] > MISSED and ha[1] <= wp.float64(0.0):
        return best
    if hb[0] > MISSED and hb[1] >= wp.float64(0.0):
        return best
    # Where the ball is not narrowed the top is known; elsewhere it is near that.
    left = wp.max(size[0] * size[0] - off * off, wp.float64(0.0))
    t = rise * wp.sqrt(left / (wp.float64(1.0) + rise * rise))
    step = wp.int32(0)
    slack = wp.float64(1.0)
    while slack > BALL_GOOD_TO and step < BALL_STEPS:
        if t <= a or t >= b:
            t = wp.float64(0.5) * (a + b)
        h = ball_height(t, off, rise, size)
        best = wp.max(best, h[0])
        slack = wp.abs(h[1]) * (b - a)
        if h[0] <= MISSED:
            slack = wp.float64(1.0)
        if h[1] > wp.float64(0.0):
            a = t
        else:
            b = t
        if step % 4 == 3 or h[2] <= wp.float64(0.0):
            t = wp.float64(0.5) * (a + b)
        else:
            t = t + h[1] / h[2]
        step += 1
    if outer:
        best += slack
    return best


@wp.func
def ball_sweep(centre: wp.vec3d, way: wp.vec3d, size: wp.vec2d, outer: wp.bool):
    """The interval of a line in the sweep of a ball (radius, narrower across the line).

    centre: the point of the line at height 0 as seen from the ball's centre.
    """
    reach = size[0] - size[1]
    if size[0] <= wp.float64(0.0) or reach <= wp.float64(0.0):
        return nothing()
    length = wp.sqrt(way[0] * way[0] + way[1] * way[1])
    q2 = centre[0] * centre[0] + centre[1] * centre[1]
    if length < wp.float64(1.0e-9):
        if q2 >= reach * reach:
            return nothing()
        g = wp.max(wp.sqrt(q2) + size[1], wp.float64(0.0))
        h = wp.sqrt(wp.max(size[0] * size[0] - g * g, wp.float64(0.0)))
        low = wp.min(way[2], wp.float64(0.0)) - h
        return wp.vec2d(low - centre[2], wp.max(way[2], wp.float64(0.0)) + h - centre[2])
    foot = (centre[0] * way[0] + centre[1] * way[1]) / length
    off = wp.abs(centre[0] * way[1] - centre[1] * way[0]) / length
    if off >= reach:
        return nothing()
    half = wp.sqrt(reach * reach - off * off)
    span = wp.vec2d(wp.max(-foot, -half), wp.min(length - foot, half))
    if span[0] >= span[1]:
        return nothing()
    rise = way[2] / length
    up = ball_top(span, off, rise, size, outer)
    down = ball_top(span, off, -rise, size, outer)
    return wp.vec2d(-down - centre[2] + foot * rise, up - centre[2] + foot * rise)


@wp.func
def rim_cut(line: View, face: wp.float64, radius: wp.float64):
    """The interval that a face alone sweeps: its plane crosses the line along a line in (u, sigma).

    Measured from the point of that line nearest to the axis, where the distance is exact.
    """
    m2 = line.ez * line.ez + line.vz * line.vz
    if m2 <= wp.float64(1.0e-18) or radius < wp.float64(0.0):
        return nothing()
    u0 = (face - line.oz) * line.ez / m2
    s0 = -(face - line.oz) * line.vz / m2
    w = line.op + u0 * line.ep - s0 * line.vp
    g = line.vz * line.ep - line.ez * line.vp
    lo = -FAR
    hi = FAR
    if wp.abs(line.ez) > wp.float64(1.0e-12):
        ta = -s0 / line.ez
        tb = (wp.float64(1.0) - s0) / line.ez
        lo = wp.min(ta, tb)
        hi = wp.max(ta, tb)
    elif s0 < wp.float64(0.0) or s0 > wp.float64(1.0):
        return nothing()
    gg = wp.dot(g, g)
    tm = wp.float64(0.0)
    if gg > wp.float64(1.0e-14):
        tm = -wp.dot(w, g) / gg
    w = w + tm * g
    c = wp.dot(w, w) - radius * radius - wp.float64(1.0e-18)
    t = below_zero(gg, wp.float64(0.0), c, lo - tm, hi - tm)
    if t[0] > t[1] or t[0] < wp.float64(-1.0e8) or t[1] > wp.float64(1.0e8):
        return nothing()
    ua = u0 + (tm + t[0]) * line.vz
    ub = u0 + (tm + t[1]) * line.vz
    return wp.vec2d(wp.min(ua, ub), wp.max(ua, ub))


@wp.func
def side_touch(line: View, g: Frustum, u: wp.float64, fraction: wp.float64):
    """A point at which the line touches the side, if it lies on the part and on its way."""
    z = line.oz + u * line.ez - fraction * line.vz
    if fraction < wp.float64(0.0) or fraction > wp.float64(1.0) or z < g.low or z > g.high:
        return nothing()
    return wp.vec2d(u, u)


@wp.func
def side_cut(line: View, g: Frustum):
    """The hull of the points at which the line touches the side of a moving frustum."""
    c0 = g.base + g.slope * line.oz
    c1 = g.slope * line.ez
    c2 = -g.slope * line.vz
    ss = wp.dot(line.vp, line.vp) - c2 * c2
    if ss <= wp.float64(1.0e-14):
        return nothing()
    us = (-wp.dot(line.ep, line.vp) - c1 * c2) / ss
    s = (-wp.dot(line.op, line.vp) - c0 * c2) / ss
    a = wp.dot(line.ep, line.ep) - c1 * c1 - us * us * ss
    b = wp.dot(line.op, line.ep) - c0 * c1 - us * s * ss
    c = wp.dot(line.op, line.op) - c0 * c0 - s * s * ss
    d = b * b - a * c
    if d < wp.float64(0.0):
        return nothing()
    ua = wp.float64(0.0)
    ub = wp.float64(0.0)
    if wp.abs(a) > wp.float64(1.0e-13):
        root = wp.sqrt(d)
        ua = (-b - root) / a
        ub = (-b + root) / a
    elif wp.abs(b) > wp.float64(1.0e-13):
        ua = -c / (wp.float64(2.0) * b)
        ub = ua
    else:
        return nothing()
    return hull(side_touch(line, g, ua, -(us * ua + s)), side_touch(line, g, ub, -(us * ub + s)))


@wp.func
def frustum_sweep(line: View, g: Frustum):
    """The interval of a line in the sweep of a frustum."""
    if g.low >= g.high:
        return nothing()
    r0 = g.base + g.slope * g.low
    r1 = g.base + g.slope * g.high
    widest = wp.max(r0, r1)
    ways = wp.dot(line.vp, line.vp)
    if line.sine < wp.float64(1.0e-9) and g.slope == wp.float64(0.0):
        # A cylinder along the line, as in most of three-axis work: one quadratic.
        c = wp.dot(line.op, line.op) - widest * widest
        s = below_zero(ways, -wp.dot(line.op, line.vp), c, wp.float64(0.0), wp.float64(1.0))
        if s[0] > s[1]:
            return nothing()
        lo = wp.min(s[0] * line.vz, s[1] * line.vz) + g.low - line.oz
        hi = wp.max(s[0] * line.vz, s[1] * line.vz) + g.high - line.oz
        if line.ez < wp.float64(0.0):
            return wp.vec2d(-hi, -lo)
        return wp.vec2d(lo, hi)
    out = standing_cut(line, wp.float64(0.0), g)
    if ways + line.vz * line.vz < wp.float64(1.0e-20):
        return out
    out = hull(out, standing_cut(line, wp.float64(1.0), g))
    out = hull(out, rim_cut(line, g.low, r0))
    out = hull(out, rim_cut(line, g.high, r1))
    return hull(out, side_cut(line, g))


@wp.func
def is_beside(at: wp.vec2d, origin: wp.vec3d, way: wp.vec3d, far: wp.float64):
    """Whether the projected way passes a line further away than any point of the part."""
    x = at[0] - origin[0]
    y = at[1] - origin[1]
    cross = x * way[1] - y * way[0]
    w2 = way[0] * way[0] + way[1] * way[1]
    if cross * cross > far * far * w2 + wp.float64(1.0e-12):
        return True
    along = x * way[0] + y * way[1]
    if along <= wp.float64(0.0):
        return x * x + y * y > far * far + wp.float64(1.0e-12)
    if along > w2:
        x = x - way[0]
        y = y - way[1]
        return x * x + y * y > far * far + wp.float64(1.0e-12)
    return False


@wp.struct
class Swept:
    """A tool part on its straight way: its gauge point at the start, the way, the fixed axis."""

    kind: wp.int32
    shape: wp.vec4d  # z0 z1 r0 r1 along the axis from the gauge point; a ball: z z r r
    seams: Seams
    origin: wp.vec3d
    way: wp.vec3d
    axis: wp.vec3d


@wp.func
def sweep_cut(part: Swept, at: wp.vec2d, growth: Growth):
    """The interval of the line through (x, y) that a changed part sweeps."""
    if part.kind == BALL:
        c = wp.vec3d(at[0], at[1], wp.float64(0.0)) - part.origin - part.shape[0] * part.axis
        size = wp.vec2d(part.shape[2] - growth.inset - growth.doubt, -growth.widen)
        return ball_sweep(c, part.way, size, growth.widen >= wp.float64(0.0))
    sine = wp.sqrt(part.axis[0] * part.axis[0] + part.axis[1] * part.axis[1])
    g = changed(part.shape, part.seams, growth, sine)
    far = wp.max(g.base + g.slope * g.low, g.base + g.slope * g.high)
    far += wp.float64(0.5) * (g.high - g.low) * sine
    middle = part.origin + wp.float64(0.5) * (g.low + g.high) * part.axis
    if g.low >= g.high or is_beside(at, middle, part.way, far):
        return nothing()
    return frustum_sweep(view_of(at, part.origin, part.way, part.axis), g)
