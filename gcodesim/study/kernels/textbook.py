"""Textbook triangle tests in single and double precision, for the study only: no check uses them.

Separating axes without a bound on rounding, in one precision throughout; the split by coplanarity
of the seed paper; Warp's own test (Moeller 1997). The kernels are generic: the type of the arrays
they are launched with chooses the precision.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from gcodesim.collision.geometry.device import BIT_EQUAL

wp.set_module_options(BIT_EQUAL)

COPLANAR = wp.constant(1.0e-6)
"""Sine between two normals below which the 6/11 split takes triangles for coplanar."""

NEVER = np.iinfo(np.int32).max
DTYPES = {"float32": wp.mat33, "float64": wp.mat33d}


@wp.func
def apart_along(axis: Any, a: Any, b: Any):
    """A positive gap between the projections, as computed."""
    p0 = wp.dot(axis, a[0])
    p1 = wp.dot(axis, a[1])
    p2 = wp.dot(axis, a[2])
    q0 = wp.dot(axis, b[0])
    q1 = wp.dot(axis, b[1])
    q2 = wp.dot(axis, b[2])
    if wp.max(p0, wp.max(p1, p2)) < wp.min(q0, wp.min(q1, q2)):
        return True
    return wp.max(q0, wp.max(q1, q2)) < wp.min(p0, wp.min(p1, p2))


@wp.func
def apart_by_edges(a: Any, b: Any):
    """The nine products of two edges."""
    for i in range(3):
        e = a[(i + 1) % 3] - a[i]
        for j in range(3):
            if apart_along(wp.cross(e, b[(j + 1) % 3] - b[j]), a, b):
                return True
    return False


@wp.func
def apart_in_plane(na: Any, nb: Any, a: Any, b: Any):
    """The six normals of edges within the planes."""
    for i in range(3):
        if apart_along(wp.cross(na, a[(i + 1) % 3] - a[i]), a, b):
            return True
        if apart_along(wp.cross(nb, b[(i + 1) % 3] - b[i]), a, b):
            return True
    return False


@wp.func
def touch_17(a: Any, b: Any):
    """All seventeen axes."""
    na = wp.cross(a[1] - a[0], a[2] - a[0])
    nb = wp.cross(b[1] - b[0], b[2] - b[0])
    if apart_along(na, a, b) or apart_along(nb, a, b):
        return False
    if apart_by_edges(a, b):
        return False
    return not apart_in_plane(na, nb, a, b)


@wp.func
def touch_split(a: Any, b: Any):
    """Two normals, then six axes where the triangles count as coplanar, nine otherwise."""
    na = wp.cross(a[1] - a[0], a[2] - a[0])
    nb = wp.cross(b[1] - b[0], b[2] - b[0])
    if apart_along(na, a, b) or apart_along(nb, a, b):
        return False
    limit = type(a[0][0])(COPLANAR) * wp.length(na) * wp.length(nb)
    if wp.length(wp.cross(na, nb)) <= limit:
        return not apart_in_plane(na, nb, a, b)
    return not apart_by_edges(a, b)


@wp.kernel
def test_by_17(a: wp.array[Any], b: wp.array[Any], contact_out: wp.array[wp.int32]):
    """One thread per pair of triangles."""
    i = wp.tid()
    if touch_17(a[i], b[i]):
        contact_out[i] = 1


@wp.kernel
def test_by_split(a: wp.array[Any], b: wp.array[Any], contact_out: wp.array[wp.int32]):
    """One thread per pair of triangles."""
    i = wp.tid()
    if touch_split(a[i], b[i]):
        contact_out[i] = 1


@wp.kernel
def test_by_warp(a: wp.array[Any], b: wp.array[Any], contact_out: wp.array[wp.int32]):
    """One thread per pair of triangles."""
    i = wp.tid()
    p = a[i]
    q = b[i]
    contact_out[i] = wp.intersect_tri_tri(p[0], p[1], p[2], q[0], q[1], q[2])


for _kernel in (test_by_17, test_by_split, test_by_warp):
    for _triangle in DTYPES.values():
        # Both precisions in one module: compiled together, and once.
        wp.overload(_kernel, [wp.array[_triangle], wp.array[_triangle], wp.array[wp.int32]])

KERNELS = {"17 axes": test_by_17, "6/11 axes": test_by_split, "wp.intersect_tri_tri": test_by_warp}


def textbook_test(
    name: str, precision: str, a: NDArray[np.float64], b: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Verdicts of a textbook test on n pairs of triangles (n, 3, 3), on the CPU.

    Args:
        name: key of KERNELS.
        precision: float32 or float64; the coordinates are rounded to it first.
        a: triangles [mm].
        b: the triangles they are paired with.
    """
    dtype = DTYPES[precision]
    first, second = (wp.array(t.astype(precision), dtype=dtype, device="cpu") for t in (a, b))
    contact = wp.zeros(len(a), dtype=wp.int32, device="cpu")
    wp.launch(KERNELS[name], dim=len(a), inputs=[first, second], outputs=[contact], device="cpu")
    return np.asarray(contact.numpy() != 0)


@wp.func
def boxes_apart(a: Any, b: Any):
    """Boxes of two triangles that do not overlap."""
    for k in range(3):
        low_a = wp.min(a[0][k], wp.min(a[1][k], a[2][k]))
        high_a = wp.max(a[0][k], wp.max(a[1][k], a[2][k]))
        low_b = wp.min(b[0][k], wp.min(b[1][k], b[2][k]))
        high_b = wp.max(b[0][k], wp.max(b[1][k], b[2][k]))
        if high_a < low_b or high_b < low_a:
            return True
    return False


@wp.kernel
def sample_naively(
    a: wp.array[Any],
    b: wp.array[Any],
    turn: wp.array[Any],
    shift: wp.array[Any],
    first_out: wp.array[wp.int32],
    work_out: wp.array[wp.int64],
):
    """One thread per instant: every triangle pair by boxes, then by all seventeen axes."""
    i = wp.tid()
    if i >= first_out[0]:
        return
    tests = wp.int64(0)
    touch = wp.bool(False)
    for n in range(b.shape[0]):
        other = b[n]
        for k in range(3):
            other[k] = turn[i] * b[n][k] + shift[i]
        for m in range(a.shape[0]):
            if not touch and not boxes_apart(a[m], other):
                tests += wp.int64(1)
                touch = touch_17(a[m], other)
    wp.atomic_add(work_out, 0, wp.int64(1))
    wp.atomic_add(work_out, 1, wp.int64(a.shape[0]) * wp.int64(b.shape[0]))
    wp.atomic_add(work_out, 2, tests)
    if touch:
        wp.atomic_min(first_out, 0, i)


for _triangle, _vector in ((wp.mat33, wp.vec3), (wp.mat33d, wp.vec3d)):
    _arrays = [wp.array[each] for each in (_triangle, _triangle, _triangle, _vector)]
    wp.overload(sample_naively, [*_arrays, wp.array[wp.int32], wp.array[wp.int64]])


def first_naive_contact(
    triangles: tuple[NDArray[np.float64], NDArray[np.float64]],
    poses: NDArray[np.float64],
    precision: str,
    counts: NDArray[np.int64],
) -> int | None:
    """First of m instants at which two bodies touch by a textbook test, on the CPU.

    Args:
        triangles: of the two bodies, (n, 3, 3) each [mm].
        poses: of the second in the frame of the first, (m, 4, 4), rounded to the precision here.
        precision: float32 or float64.
        counts: poses, box tests and triangle tests, added to.
    """
    vector = wp.vec3 if precision == "float32" else wp.vec3d
    dtype = DTYPES[precision]
    a, b = (wp.array(t.astype(precision), dtype=dtype, device="cpu") for t in triangles)
    turn = wp.array(poses[:, :3, :3].astype(precision), dtype=dtype, device="cpu")
    shift = wp.array(poses[:, :3, 3].astype(precision), dtype=vector, device="cpu")
    first = wp.full(1, NEVER, dtype=wp.int32, device="cpu")
    work = wp.zeros(3, dtype=wp.int64, device="cpu")
    wp.launch(
        sample_naively,
        dim=len(poses),
        inputs=[a, b, turn, shift],
        outputs=[first, work],
        device="cpu",
    )
    counts += work.numpy()
    found = int(first.numpy()[0])
    return None if found == NEVER else found
