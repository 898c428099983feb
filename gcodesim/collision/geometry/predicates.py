"""The certified triangle test: pure Warp functions without arrays or state.

A direction separates two triangles when the gap between their projections is positive. Here it
counts only when the computed gap exceeds a proved bound of its own rounding error (csep):

    gap > 12 u S + tau,   S = sum_k |axis_k| P_k,   P_k = largest |coordinate| relative to A0.

Each projection errs by at most 4.01 u S (three products and two sums, any order, plus the rounded
subtraction of A0), so a gap beyond 8.02 u S + underflow is a true one. Hence **no intersecting or
touching pair is ever reported as separate**, whatever the axes are and however badly they are
rounded. Axis errors cost false alarms only; the second round of directions (accurate cross
products, vertex-edge and vertex-vertex directions) bounds those to a clearance of 26 u D, 3e-11 mm
for D = 10 m, for vertices on the grid of `snap`.

Sources: separating axes for triangles, Gottschalk et al. 1996; products with error terms, Dekker
1971 and Jeannerod, Louvet, Muller 2013 (ab - cd to 2 u). A triangle is a mat33d, a row a vertex.
"""

import warp as wp

from gcodesim.collision.geometry.device import BIT_EQUAL
from gcodesim.constants import (
    CERTIFICATE_FLOOR,
    CERTIFICATE_ULPS,
    RANGE_GUARD,
    SNAP_MM,
)

wp.set_module_options(BIT_EQUAL)

ERROR_FACTOR = wp.constant(wp.float64(CERTIFICATE_ULPS * 2.0**-53))
ERROR_FLOOR = wp.constant(wp.float64(CERTIFICATE_FLOOR))
GUARD = wp.constant(wp.float64(RANGE_GUARD))
SNAP = wp.constant(wp.float64(SNAP_MM))
SNAP_INVERSE = wp.constant(wp.float64(1.0 / SNAP_MM))
SPLITTER = wp.constant(wp.float64(2.0**27 + 1.0))
CAREFUL_DIRECTIONS = wp.constant(44)


@wp.func
def snap(x: wp.vec3d):
    """Round a point to the vertex grid."""
    return wp.vec3d(
        wp.rint(x[0] * SNAP_INVERSE) * SNAP,
        wp.rint(x[1] * SNAP_INVERSE) * SNAP,
        wp.rint(x[2] * SNAP_INVERSE) * SNAP,
    )


@wp.func
def abs_vec(x: wp.vec3d):
    """Absolute value by component."""
    return wp.vec3d(wp.abs(x[0]), wp.abs(x[1]), wp.abs(x[2]))


@wp.func
def separates(
    axis: wp.vec3d,
    a1: wp.vec3d,
    a2: wp.vec3d,
    b0: wp.vec3d,
    b1: wp.vec3d,
    b2: wp.vec3d,
    reach: wp.vec3d,
):
    """Certify that `axis` separates (0, a1, a2) from (b0, b1, b2); `reach` is P of the module."""
    zero = wp.float64(0.0)
    s1 = wp.dot(axis, a1)
    s2 = wp.dot(axis, a2)
    t0 = wp.dot(axis, b0)
    t1 = wp.dot(axis, b1)
    t2 = wp.dot(axis, b2)
    a_max = wp.max(zero, wp.max(s1, s2))
    a_min = wp.min(zero, wp.min(s1, s2))
    b_max = wp.max(t0, wp.max(t1, t2))
    b_min = wp.min(t0, wp.min(t1, t2))
    gap = wp.max(b_min - a_max, a_min - b_max)
    return gap > ERROR_FACTOR * wp.dot(abs_vec(axis), reach) + ERROR_FLOOR


@wp.func
def two_product_error(a: wp.float64, b: wp.float64, product: wp.float64):
    """Exact a*b - product by splitting (no fma, so that every device gives the same bits)."""
    ca = SPLITTER * a
    ah = ca - (ca - a)
    al = a - ah
    cb = SPLITTER * b
    bh = cb - (cb - b)
    bl = b - bh
    return ((ah * bh - product) + ah * bl + al * bh) + al * bl


@wp.func
def product_difference(a: wp.float64, b: wp.float64, c: wp.float64, d: wp.float64):
    """a*b - c*d to about two units in the last place, without cancellation."""
    ab = a * b
    cd = c * d
    return (ab - cd) + (two_product_error(a, b, ab) - two_product_error(c, d, cd))


@wp.func
def accurate_cross(x: wp.vec3d, y: wp.vec3d):
    """Cross product with every component accurate to about two units in the last place."""
    return wp.vec3d(
        product_difference(x[1], y[2], x[2], y[1]),
        product_difference(x[2], y[0], x[0], y[2]),
        product_difference(x[0], y[1], x[1], y[0]),
    )


@wp.func
def edge(t: wp.mat33d, i: wp.int32):
    """Edge i of a triangle, from vertex i to the next."""
    j = i + 1
    if j == 3:
        j = 0
    return t[j] - t[i]


@wp.func
def careful_direction(k: wp.int32, a: wp.mat33d, b: wp.mat33d):
    """Direction k of the second round: 2 normals, 9 edge pairs, 6 in plane, 18 V-E, 9 V-V."""
    if k < 2:
        if k == 0:
            return accurate_cross(edge(a, 0), edge(a, 1))
        return accurate_cross(edge(b, 0), edge(b, 1))
    if k < 11:
        return accurate_cross(edge(a, (k - 2) / 3), edge(b, (k - 2) % 3))
    if k < 14:
        return accurate_cross(accurate_cross(edge(a, 0), edge(a, 1)), edge(a, k - 11))
    if k < 17:
        return accurate_cross(accurate_cross(edge(b, 0), edge(b, 1)), edge(b, k - 14))
    if k < 26:
        e = edge(a, (k - 17) / 3)
        w = b[(k - 17) % 3] - a[(k - 17) / 3]
        return wp.cross(e, accurate_cross(w, e))
    if k < 35:
        e = edge(b, (k - 26) / 3)
        w = a[(k - 26) % 3] - b[(k - 26) / 3]
        return wp.cross(e, accurate_cross(w, e))
    return b[(k - 35) % 3] - a[(k - 35) / 3]


@wp.func
def quickly_separated(a: wp.mat33d, b: wp.mat33d, reach: wp.vec3d):
    """First round: the 17 classical axes, plain cross products. `a[0]` is the origin."""
    a1 = a[1]
    a2 = a[2]
    b0 = b[0]
    b1 = b[1]
    b2 = b[2]
    e0 = a1
    e1 = a2 - a1
    e2 = -a2
    f0 = b1 - b0
    f1 = b2 - b1
    f2 = b0 - b2
    na = wp.cross(e0, e1)
    if separates(na, a1, a2, b0, b1, b2, reach):
        return True
    nb = wp.cross(f0, f1)
    if separates(nb, a1, a2, b0, b1, b2, reach):
        return True
    for i in range(3):
        e = e0
        if i == 1:
            e = e1
        if i == 2:
            e = e2
        for j in range(3):
            f = f0
            if j == 1:
                f = f1
            if j == 2:
                f = f2
            if separates(wp.cross(e, f), a1, a2, b0, b1, b2, reach):
                return True
    for i in range(3):
        e = e0
        f = f0
        if i == 1:
            e = e1
            f = f1
        if i == 2:
            e = e2
            f = f2
        if separates(wp.cross(na, e), a1, a2, b0, b1, b2, reach):
            return True
        if separates(wp.cross(nb, f), a1, a2, b0, b1, b2, reach):
            return True
    return False


@wp.func
def triangles_touch(a: wp.mat33d, b: wp.mat33d):
    """Contact of two triangles: False only when they are certified separate.

    True also for input that cannot be judged (NaN, infinity, coordinates beyond RANGE_GUARD).
    """
    origin = a[0]
    la = wp.matrix_from_rows(a[0] - origin, a[1] - origin, a[2] - origin)
    lb = wp.matrix_from_rows(b[0] - origin, b[1] - origin, b[2] - origin)
    reach = wp.vec3d()
    total = wp.float64(0.0)
    for k in range(3):
        p = wp.max(wp.abs(la[1, k]), wp.abs(la[2, k]))
        q = wp.max(wp.abs(lb[0, k]), wp.max(wp.abs(lb[1, k]), wp.abs(lb[2, k])))
        reach[k] = wp.max(p, q)
        total += wp.abs(la[1, k]) + wp.abs(la[2, k])
        total += wp.abs(lb[0, k]) + wp.abs(lb[1, k]) + wp.abs(lb[2, k])
    if not (total < GUARD):
        return True
    if quickly_separated(la, lb, reach):
        return False
    for k in range(CAREFUL_DIRECTIONS):
        axis = careful_direction(k, la, lb)
        if separates(axis, la[1], la[2], lb[0], lb[1], lb[2], reach):
            return False
    return True
