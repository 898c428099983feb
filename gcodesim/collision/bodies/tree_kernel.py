"""Builds one bounding-volume tree: a queue of nodes, each bounded, cut in two and queued again.

Compiled because a tree of 100,000 triangles takes NumPy seconds. Trees are built on the CPU, the
same for every device, one thread a tree.
"""

import warp as wp

from gcodesim.collision.geometry.device import BIT_EQUAL

# Loops stay loops: unrolled, the kernel takes twice as long to compile and is no faster.
wp.set_module_options({**BIT_EQUAL, "max_unroll": 2})

MOST_VERTICES = 8
VERTEX_LIMIT = wp.constant(MOST_VERTICES)
"""Distinct vertices a node may carry before it gets a box. More make fewer items, each at a higher
price; measured on three programs, 8 costs 0.7 of 48 and 0.95 of 12."""

MANY = wp.constant(16)
"""Triangles from which on a node is not even asked for its vertices: a closed surface of so many
has more than VERTEX_LIMIT."""

SMALL = wp.constant(24)
"""Triangles up to which a node is cut along the best of three axes. Larger ones lose 1 % of the
search and save half of the building."""

LEAST_SHARE = 8
SHARE = wp.constant(LEAST_SHARE)
"""A child holds at least 1/8 of its parent's triangles, which bounds the depth of the tree."""

NEEDLE = wp.constant(wp.float64(1.0e-8))
"""A triangle thinner than this part of its length gives no frame to a box."""

FAR = wp.constant(wp.float64(1.0e300))
"""Beyond every coordinate; the cost of a cut that leaves too few triangles on one side."""

EDGE_COST = wp.constant(wp.float64(1.0e-3))
"""Of two boxes of equal surface the shorter one is better: tells flat boxes apart."""


@wp.struct
class NodeArrays:
    """Nodes in the order of the queue, which is level by level; see trees.Tree for the fields."""

    left: wp.array[wp.int32]
    right: wp.array[wp.int32]
    triangle: wp.array[wp.int32]
    level: wp.array[wp.int32]
    frame: wp.array[wp.mat33d]
    centre: wp.array[wp.vec3d]
    extent: wp.array[wp.vec3d]
    vertex_first: wp.array[wp.int32]
    vertex_count: wp.array[wp.int32]
    vertices: wp.array[wp.vec3d]


@wp.struct
class Working:
    """What the building needs besides: the triangles and, per node, which of them are its own.

    `order` lists the triangles by the centre along each axis; those of a node stand together, from
    `first` on.
    """

    triangles: wp.array[wp.mat33d]
    low: wp.array[wp.vec3d]
    high: wp.array[wp.vec3d]
    order: wp.array2d[wp.int32]
    first: wp.array[wp.int32]
    count: wp.array[wp.int32]
    area: wp.array[wp.float64]
    second: wp.array[wp.int32]  # 1: the triangle goes to the second child
    put_by: wp.array[wp.int32]


@wp.struct
class NodeCut:
    """The cut of a node: the triangles up to `size` along `axis` go to the first child."""

    axis: wp.int32
    size: wp.int32
    cost: wp.float64


@wp.struct
class FramedBox:
    """A box in a frame, and what it costs."""

    frame: wp.mat33d
    low: wp.vec3d
    high: wp.vec3d
    cost: wp.float64


@wp.func
def half_surface(d: wp.vec3d):
    """Half the surface of a box of sides d."""
    return d[0] * d[1] + d[1] * d[2] + d[2] * d[0]


@wp.func
def box_in_frame(work: Working, first: wp.int32, count: wp.int32, frame: wp.mat33d):
    """The smallest box of some triangles with the rows of `frame` as axes."""
    box = FramedBox()
    box.frame = frame
    box.low = wp.vec3d(FAR, FAR, FAR)
    box.high = -box.low
    corners = wp.int32(3)
    for k in range(first, first + count):
        triangle = work.triangles[work.order[0, k]]
        for corner in range(corners):
            x = frame * triangle[corner]
            box.low = wp.min(box.low, x)
            box.high = wp.max(box.high, x)
    sides = box.high - box.low
    around = sides[0] + sides[1] + sides[2]
    box.cost = half_surface(sides) + EDGE_COST * around * around
    return box


@wp.func
def principal_frame(work: Working, first: wp.int32, count: wp.int32):
    """Principal axes of the vertices of some triangles, as rows."""
    corners = wp.int32(3)
    mean = wp.vec3d()
    for k in range(first, first + count):
        triangle = work.triangles[work.order[0, k]]
        mean += triangle[0] + triangle[1] + triangle[2]
    mean = mean / wp.float64(3 * count)
    moments = wp.mat33d()
    for k in range(first, first + count):
        triangle = work.triangles[work.order[0, k]]
        for corner in range(corners):
            x = triangle[corner] - mean
            moments += wp.outer(x, x)
    axes, _spread = wp.eig3(moments)
    return wp.transpose(axes)


@wp.func
def triangle_frame(work: Working, first: wp.int32, count: wp.int32):
    """Frame of the largest of some triangles, as rows: longest edge, in-plane normal, normal.

    The normal of a needle is noise: its frame would be skew, and the box would lose the triangle.
    """
    largest = work.order[0, first]
    most = wp.float64(-1.0)
    for k in range(first, first + count):
        triangle = work.triangles[work.order[0, k]]
        normal = wp.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
        area = wp.dot(normal, normal)
        if area > most:
            most = area
            largest = work.order[0, k]
    triangle = work.triangles[largest]
    normal = wp.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
    edge = triangle[0] - triangle[2]
    corners = wp.int32(2)
    for k in range(corners):
        other = triangle[k + 1] - triangle[k]
        if wp.dot(other, other) > wp.dot(edge, edge):
            edge = other
    if wp.length(normal) <= NEEDLE * wp.dot(edge, edge):
        return wp.identity(n=3, dtype=wp.float64)
    u = wp.normalize(edge)
    v = wp.normalize(wp.cross(normal, u))
    return wp.matrix_from_rows(u, v, wp.cross(u, v))


@wp.func
def take_vertices(work: Working, nodes: NodeArrays, first: wp.int32, count: wp.int32, at: wp.int32):
    """Distinct vertices of some triangles, written from `at` on; -1 when they are too many."""
    taken = wp.int32(0)
    corners = wp.int32(3)
    for k in range(first, first + count):
        triangle = work.triangles[work.order[0, k]]
        for corner in range(corners):
            alike = wp.int32(0)
            for j in range(at, at + taken):
                if nodes.vertices[j] == triangle[corner]:
                    alike += 1
            if alike == 0:
                if taken == VERTEX_LIMIT:
                    return -1
                nodes.vertices[at + taken] = triangle[corner]
                taken += 1
    return taken


@wp.func
def bound_node(work: Working, nodes: NodeArrays, node: wp.int32, at: wp.int32):
    """Bound a node by its vertices when they are few, else by the best of three boxes.

    The box of a node that carries its vertices only serves to aim: it stays axis-aligned.
    """
    first = work.first[node]
    count = work.count[node]
    box = box_in_frame(work, first, count, wp.identity(n=3, dtype=wp.float64))
    taken = wp.int32(-1)
    if count <= MANY:
        taken = take_vertices(work, nodes, first, count, at)
    if taken < 0:
        frames = wp.int32(2)
        for k in range(frames):
            frame = principal_frame(work, first, count)
            if k == 1:
                frame = triangle_frame(work, first, count)
            other = box_in_frame(work, first, count, frame)
            if other.cost < box.cost:
                box = other
    half = wp.float64(0.5)
    nodes.frame[node] = box.frame
    nodes.centre[node] = wp.transpose(box.frame) * (half * (box.low + box.high))
    nodes.extent[node] = half * (box.high - box.low)
    nodes.vertex_first[node] = at
    nodes.vertex_count[node] = wp.max(taken, 0)
    return at + wp.max(taken, 0)


@wp.func
def cut_along(work: Working, first: wp.int32, count: wp.int32, axis: wp.int32):
    """The cut of least surface-area cost among those along one axis."""
    low = wp.vec3d(FAR, FAR, FAR)
    high = -low
    for k in range(first, first + count):
        triangle = work.order[axis, k]
        low = wp.min(low, work.low[triangle])
        high = wp.max(high, work.high[triangle])
        work.area[k] = half_surface(high - low)
    best = NodeCut()
    best.axis = axis
    best.cost = wp.float64(wp.inf)
    low = wp.vec3d(FAR, FAR, FAR)
    high = -low
    for back in range(1, count):
        size = count - back
        triangle = work.order[axis, first + size]
        low = wp.min(low, work.low[triangle])
        high = wp.max(high, work.high[triangle])
        after = half_surface(high - low)
        cost = work.area[first + size - 1] * wp.float64(size) + after * wp.float64(back)
        if wp.min(size, back) < wp.max(1, count / SHARE):
            # Worse than any other, but it may be the only one.
            cost = FAR * (wp.float64(1.0) + wp.float64(wp.abs(size - back)) / wp.float64(count))
        if cost <= best.cost:
            best.cost = cost
            best.size = size
    return best


@wp.func
def best_cut(work: Working, first: wp.int32, count: wp.int32):
    """The best cut of a node: of all axes if it is small, else along its longest."""
    low = wp.vec3d(FAR, FAR, FAR)
    high = -low
    for k in range(first, first + count):
        triangle = work.order[0, k]
        centre = work.low[triangle] + work.high[triangle]
        low = wp.min(low, centre)
        high = wp.max(high, centre)
    sides = high - low
    best = cut_along(work, first, count, wp.int32(wp.argmax(sides)))
    if count <= SMALL:
        axes = wp.int32(3)
        for axis in range(axes):
            if axis != best.axis:
                other = cut_along(work, first, count, axis)
                if other.cost < best.cost:
                    best = other
    return best


@wp.func
def part(work: Working, first: wp.int32, count: wp.int32, cut: NodeCut):
    """Reorder the triangles of a node along every axis: first child, then second."""
    for k in range(count):
        work.second[work.order[cut.axis, first + k]] = wp.where(k < cut.size, 0, 1)
    axes = wp.int32(3)
    for axis in range(axes):
        kept = first
        moved = wp.int32(0)
        for k in range(first, first + count):
            triangle = work.order[axis, k]
            if work.second[triangle] == 1:
                work.put_by[moved] = triangle
                moved += 1
            else:
                work.order[axis, kept] = triangle
                kept += 1
        for k in range(moved):
            work.order[axis, kept + k] = work.put_by[k]


@wp.kernel
def build_nodes(work: Working, nodes_out: NodeArrays, counts_out: wp.array[wp.int32]):
    """One thread in all: the nodes of the tree, and how many nodes and vertices there are."""
    work.first[0] = 0
    work.count[0] = work.triangles.shape[0]
    queued = wp.int32(1)
    vertices = wp.int32(0)
    node = wp.int32(0)
    while node < queued:
        first = work.first[node]
        count = work.count[node]
        vertices = bound_node(work, nodes_out, node, vertices)
        nodes_out.left[node] = -1
        nodes_out.right[node] = -1
        nodes_out.triangle[node] = work.order[0, first]
        if count > 1:
            cut = best_cut(work, first, count)
            part(work, first, count, cut)
            nodes_out.triangle[node] = -1
            nodes_out.left[node] = queued
            nodes_out.right[node] = queued + 1
            work.first[queued] = first
            work.count[queued] = cut.size
            work.first[queued + 1] = first + cut.size
            work.count[queued + 1] = count - cut.size
            nodes_out.level[queued] = nodes_out.level[node] + 1
            nodes_out.level[queued + 1] = nodes_out.level[node] + 1
            queued += 2
        node += 1
    counts_out[0] = queued
    counts_out[1] = vertices
