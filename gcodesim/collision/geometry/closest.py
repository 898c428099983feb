"""Closest points and separating directions of two triangles or two tree nodes, on the device.

Everything here only proposes a direction. What counts is the gap that the search then certifies
along it, so rounding or an early stop here costs time, never a contact.
"""

import warp as wp

from gcodesim.collision.geometry.device import BIT_EQUAL
from gcodesim.collision.geometry.poses import Pose

wp.set_module_options(BIT_EQUAL)

TINY = wp.constant(wp.float64(1.0e-30))
"""Vectors shorter than this, or triangles with a normal shorter, have no direction."""
AIM_STEPS = wp.constant(6)
GOOD_ENOUGH = wp.constant(wp.float64(0.4))
"""A direction whose gap is at least this part of the distance estimate is not refined further."""
NO_WAY = wp.constant(wp.float64(1.0e-9))
"""A way shorter than this [mm] gives no direction: the next guess is taken instead."""


@wp.struct
class ForestArrays:
    """Trees of all bodies, one after the other; see trees.Tree for the fields."""

    left: wp.array[wp.int32]
    right: wp.array[wp.int32]
    triangle: wp.array[wp.int32]  # into `triangles`, -1 above the leaves
    frame: wp.array[wp.mat33d]
    centre: wp.array[wp.vec3d]
    extent: wp.array[wp.vec3d]
    vertex_first: wp.array[wp.int32]
    vertex_count: wp.array[wp.int32]
    vertices: wp.array[wp.vec3d]
    size: wp.array[wp.float64]
    triangles: wp.array[wp.mat33d]
    root: wp.array[wp.int32]  # side (2 pair, 2 pair + 1) -> root node
    lever: wp.array[wp.float64]  # [mm], see motion_bounds.py
    lever_first: wp.array[wp.int32]  # side -> lever of node 0 and the first rotary joint
    lever_count: wp.array[wp.int32]  # side -> rotary joints, the stride of `lever`


@wp.func
def child_nodes(forest: ForestArrays, a: wp.int32, b: wp.int32, second: wp.bool):
    """One of the two pairs of nodes that the larger node of a pair splits into."""
    splits_a = forest.triangle[b] >= 0
    if forest.triangle[a] < 0 and forest.size[a] > forest.size[b]:
        splits_a = True
    if splits_a:
        return wp.vec2i(wp.where(second, forest.right[a], forest.left[a]), b)
    return wp.vec2i(a, wp.where(second, forest.right[b], forest.left[b]))


@wp.func
def highest(forest: ForestArrays, node: wp.int32, direction: wp.vec3d):
    """Support value: largest dot product of the node's points with a direction."""
    count = forest.vertex_count[node]
    if count == 0:
        u = forest.frame[node] * direction
        e = forest.extent[node]
        reach = wp.abs(u[0]) * e[0] + wp.abs(u[1]) * e[1] + wp.abs(u[2]) * e[2]
        return wp.dot(forest.centre[node], direction) + reach
    first = forest.vertex_first[node]
    best = wp.dot(forest.vertices[first], direction)
    for k in range(first + 1, first + count):
        best = wp.max(best, wp.dot(forest.vertices[k], direction))
    return best


@wp.func
def highest_point(forest: ForestArrays, node: wp.int32, direction: wp.vec3d):
    """Support point: a point of the node with the largest dot product."""
    count = forest.vertex_count[node]
    if count == 0:
        frame = forest.frame[node]
        u = frame * direction
        e = forest.extent[node]
        corner = wp.vec3d(
            wp.where(u[0] > wp.float64(0.0), e[0], -e[0]),
            wp.where(u[1] > wp.float64(0.0), e[1], -e[1]),
            wp.where(u[2] > wp.float64(0.0), e[2], -e[2]),
        )
        return forest.centre[node] + wp.transpose(frame) * corner
    first = forest.vertex_first[node]
    best = wp.dot(forest.vertices[first], direction)
    chosen = first
    for k in range(first + 1, first + count):
        value = wp.dot(forest.vertices[k], direction)
        if value > best:
            best = value
            chosen = k
    return forest.vertices[chosen]


@wp.func
def clamp_to_box(x: wp.vec3d, e: wp.vec3d):
    """Nearest point of the centred box with half extents e."""
    return wp.vec3d(
        wp.clamp(x[0], -e[0], e[0]), wp.clamp(x[1], -e[1], e[1]), wp.clamp(x[2], -e[2], e[2])
    )


@wp.func
def aim_at_box(forest: ForestArrays, a: wp.int32, b: wp.int32, pose: Pose):
    """Vector from box a to box b by two alternating projections, in the frame of body a."""
    frame = forest.frame[a]
    ea = forest.extent[a]
    eb = forest.extent[b]
    turn = frame * pose.R * wp.transpose(forest.frame[b])
    shift = frame * (pose.R * forest.centre[b] + pose.t - forest.centre[a])
    back = wp.transpose(turn)
    y = shift
    for _k in range(2):
        x = clamp_to_box(y, ea)
        y = turn * clamp_to_box(back * (x - shift), eb) + shift
    return wp.transpose(frame) * (y - clamp_to_box(y, ea))


@wp.func
def nearest_on_segment(p: wp.vec3d, q: wp.vec3d):
    """Point of the segment p q nearest to the origin."""
    d = q - p
    length = wp.dot(d, d)
    if length <= TINY:
        return p
    return p + wp.clamp(-wp.dot(p, d) / length, wp.float64(0.0), wp.float64(1.0)) * d


@wp.func
def nearer(p: wp.vec3d, q: wp.vec3d):
    """The one of two vectors that is shorter."""
    if wp.dot(q, q) < wp.dot(p, p):
        return q
    return p


@wp.func
def nearest_on_triangle(p: wp.vec3d, q: wp.vec3d, r: wp.vec3d):
    """Point of a triangle nearest to the origin: inside when its foot is, else on an edge."""
    normal = wp.cross(q - p, r - p)
    area = wp.dot(normal, normal)
    if area > TINY:
        u = wp.dot(wp.cross(p, q), normal)
        v = wp.dot(wp.cross(q, r), normal)
        w = wp.dot(wp.cross(r, p), normal)
        zero = wp.float64(0.0)
        if u >= zero and v >= zero and w >= zero:
            return (wp.dot(p, normal) / area) * normal
    best = nearer(nearest_on_segment(p, q), nearest_on_segment(q, r))
    return nearer(best, nearest_on_segment(r, p))


@wp.func
def between_segments(p0: wp.vec3d, p1: wp.vec3d, q0: wp.vec3d, q1: wp.vec3d):
    """Shortest vector from segment p to q (Ericson, Real-Time Collision Detection, 5.1.9)."""
    zero = wp.float64(0.0)
    one = wp.float64(1.0)
    d = p1 - p0
    e = q1 - q0
    r = p0 - q0
    a = wp.dot(d, d)
    b = wp.dot(d, e)
    c = wp.dot(d, r)
    ee = wp.dot(e, e)
    f = wp.dot(e, r)
    s = zero
    det = a * ee - b * b
    if det > TINY:
        s = wp.clamp((b * f - c * ee) / det, zero, one)
    t = zero
    if ee > TINY:
        t = (b * s + f) / ee
    if t < zero:
        t = zero
        if a > TINY:
            s = wp.clamp(-c / a, zero, one)
    if t > one:
        t = one
        if a > TINY:
            s = wp.clamp((b - c) / a, zero, one)
    return q0 + t * e - p0 - s * d


@wp.func
def between_triangles(a: wp.mat33d, b: wp.mat33d):
    """Shortest vector from triangle a to triangle b; any vector when they pierce each other."""
    best = b[0] - a[0]
    corners = wp.int32(3)
    for i in range(corners):
        corner_b = nearest_on_triangle(b[i] - a[0], b[i] - a[1], b[i] - a[2])
        best = nearer(best, corner_b)
        corner_a = nearest_on_triangle(b[0] - a[i], b[1] - a[i], b[2] - a[i])
        best = nearer(best, corner_a)
        for j in range(corners):
            best = nearer(best, between_segments(a[i], a[(i + 1) % 3], b[j], b[(j + 1) % 3]))
    return best


@wp.func
def node_gap(forest: ForestArrays, a: wp.int32, b: wp.int32, pose: Pose, n: wp.vec3d):
    """Gap of two nodes along the unit vector n (frame of body a): positive = n separates them."""
    low = wp.dot(n, pose.t) - highest(forest, b, -(wp.transpose(pose.R) * n))
    return low - highest(forest, a, n)


@wp.func
def aim_at_node(forest: ForestArrays, a: wp.int32, b: wp.int32, pose: Pose):
    """Unit vector along which the nodes are far apart; zero when none was found.

    Starts between the boxes, then follows support points: each step replaces the current point of
    the Minkowski difference by the nearest one of a triangle of points known to lie in it.
    """
    v = aim_at_box(forest, a, b, pose)
    length = wp.length(v)
    if length < NO_WAY:
        v = pose.R * forest.centre[b] + pose.t - forest.centre[a]
        length = wp.length(v)
        if length < NO_WAY:
            return wp.vec3d()
    n = v / length
    if forest.vertex_count[a] + forest.vertex_count[b] == 0:
        return n
    best_n = n
    point = posed_difference(forest, a, b, pose, n)
    best = wp.dot(n, point)
    last = point
    steps = wp.int32(AIM_STEPS)
    for _k in range(steps):
        length = wp.length(point)
        if length < NO_WAY or best >= (wp.float64(1.0) - GOOD_ENOUGH) * length:
            break
        n = point / length
        support = posed_difference(forest, a, b, pose, n)
        gap = wp.dot(n, support)
        if gap > best:
            best = gap
            best_n = n
        if gap >= (wp.float64(1.0) - GOOD_ENOUGH) * length:
            break
        nearest = nearest_on_triangle(point, last, support)
        last = support
        point = nearest
    return best_n


@wp.func
def posed_difference(forest: ForestArrays, a: wp.int32, b: wp.int32, pose: Pose, n: wp.vec3d):
    """Point of b minus point of a that lies lowest along n."""
    from_b = pose.R * highest_point(forest, b, -(wp.transpose(pose.R) * n)) + pose.t
    return from_b - highest_point(forest, a, n)
