"""Thirteen families of triangle pairs that break textbook intersection tests.

Nearly all pairs are near contact by design: a vertex over a face or an edge over an edge at a gap
of either sign, tiny against the size, moved far from the origin. The sign of the gap is no label;
the truth comes from study/exact.py. Lengths are in mm (F11: a machine in metres).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
TrianglePairs = tuple[Array, Array]
Scalar = float | Array


def generate(family: str, count: int, seed: int) -> TrianglePairs:
    """Return `count` triangle pairs of a family as two (count, 3, 3) arrays.

    The pairs depend on family, count and seed only; F11 is F02 times 1e-3.

    Raises:
        KeyError: there is no such family.
    """
    if family == "F11":
        a, b = generate("F02", count, seed)
        return a * 1e-3, b * 1e-3
    rng = np.random.default_rng([seed, list(_GENERATORS).index(family)])
    return shuffled(rng, *_GENERATORS[family](rng, count))


def powers(rng: np.random.Generator, n: int, low: float, high: float) -> Array:
    """Numbers whose decimal exponents are uniform between two, (n,)."""
    return np.asarray(10.0 ** rng.uniform(low, high, n))


def signed(rng: np.random.Generator, n: int, low: float, high: float) -> Array:
    """Such numbers of either sign: gaps, and how deep two triangles are in each other."""
    signs: Array = rng.choice([-1.0, 1.0], n)
    return powers(rng, n, low, high) * signs


def _polar(radius: Scalar, angle: Scalar, z: Scalar) -> Array:
    coordinates = np.broadcast_arrays(radius * np.cos(angle), radius * np.sin(angle), z)
    return np.stack(coordinates, axis=-1)


def _vertex_face(
    rng: np.random.Generator, size_a: Array, size_b: Array, gap: Array, tilt_a: Scalar
) -> TrianglePairs:
    """Return A standing on its first vertex at height gap over the face of B in plane z = 0."""
    n = len(gap)
    phi = rng.uniform(0, 2 * np.pi, (n, 1)) + np.arange(3) * (2 * np.pi / 3)
    b = _polar(
        size_b[:, None] * rng.uniform(0.3, 1, (n, 3)), phi + rng.uniform(-0.9, 0.9, (n, 3)), 0.0
    )
    angle = rng.uniform(0, 2 * np.pi, n)
    rise = rng.uniform(0.05, 1, (2, n)) * tilt_a * size_a + gap
    radius = size_a * rng.uniform(0.3, 1, (2, n))
    a = np.stack(
        [
            _polar(0.0, angle, gap),
            _polar(radius[0], angle, rise[0]),
            _polar(radius[1], angle + rng.uniform(0.2, 2.9, n), rise[1]),
        ],
        axis=1,
    )
    return a, b


def edges_near(
    rng: np.random.Generator,
    size_a: Array,
    size_b: Array,
    gap: Array,
    tilt_a: Scalar = 1.0,
    tilt_b: Scalar = 1.0,
    angle: Array | None = None,
) -> TrianglePairs:
    """Return A above and B below, edges crossing over the origin at height gap and at an angle."""
    n = len(gap)
    if angle is None:
        angle = rng.uniform(0.2, np.pi - 0.2, n)
    heading = rng.uniform(0, 2 * np.pi, n)

    def wedge(size: Array, heading: Array, z: Scalar, rise: Scalar) -> Array:
        third = rng.uniform(0, 2 * np.pi, n)
        return np.stack(
            [
                _polar(-size * rng.uniform(0.1, 1, n), heading, z),
                _polar(size * rng.uniform(0.1, 1, n), heading, z),
                _polar(size * rng.uniform(0, 1, n), third, z + rise * rng.uniform(0.05, 1, n)),
            ],
            axis=1,
        )

    a = wedge(size_a, heading, gap, tilt_a * size_a)
    return a, wedge(size_b, heading + angle, 0.0, -tilt_b * size_b)


def _mix(
    rng: np.random.Generator,
    size_a: Array,
    size_b: Array,
    gap: Array,
    tilt_a: Scalar = 1.0,
    tilt_b: Scalar = 1.0,
) -> TrianglePairs:
    """Return vertex-face and edge-edge contacts in turn."""
    a_vf, b_vf = _vertex_face(rng, size_a, size_b, gap, tilt_a)
    a_ee, b_ee = edges_near(rng, size_a, size_b, gap, tilt_a, tilt_b)
    even = (np.arange(len(gap)) % 2 == 0)[:, None, None]
    return np.where(even, a_vf, a_ee), np.where(even, b_vf, b_ee)


def placed(rng: np.random.Generator, pairs: TrianglePairs, offset: Scalar) -> TrianglePairs:
    """Turn every pair at random, then move it by up to the offset along each axis."""
    n = len(pairs[0])
    w, x, y, z = (q := rng.normal(size=(4, n))) / np.linalg.norm(q, axis=0)
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    shift = rng.uniform(-1, 1, (n, 1, 3)) * np.reshape(offset, (-1, 1, 1))
    a, b = (np.einsum("ijn,nvj->nvi", turn, t) + shift for t in pairs)
    return a, b


def shuffled(rng: np.random.Generator, a: Array, b: Array) -> TrianglePairs:
    """Reorder the vertices of every triangle and swap half of the pairs."""
    n = len(a)
    a, b = (
        np.take_along_axis(t, np.argsort(rng.random((n, 3)), axis=1)[:, :, None], axis=1)
        for t in (a, b)
    )
    swap = (rng.random(n) < 0.5)[:, None, None]
    return np.where(swap, b, a), np.where(swap, a, b)


def _near_contact(
    sizes_a: tuple[float, float],
    gaps: tuple[float, float],
    offset: float,
    sizes_b: tuple[float, float] | None = None,
    tilts: tuple[float, float] = (0.0, 0.0),
) -> Callable[[np.random.Generator, int], TrianglePairs]:
    """Return the generator of a mix whose decimal exponents are uniform in the given ranges."""

    def generator(rng: np.random.Generator, n: int) -> TrianglePairs:
        size_a, size_b = powers(rng, n, *sizes_a), powers(rng, n, *(sizes_b or sizes_a))
        gap, tilt_a, tilt_b = (
            signed(rng, n, *gaps),
            powers(rng, n, *tilts),
            powers(rng, n, *tilts),
        )
        return placed(rng, _mix(rng, size_a, size_b, gap, tilt_a, tilt_b), offset)

    return generator


def _random(rng: np.random.Generator, n: int) -> TrianglePairs:
    a, b = rng.uniform(-30, 30, (2, n, 1, 3)) + rng.uniform(-50, 50, (2, n, 3, 3))
    return a, b


def _parallel_edges(rng: np.random.Generator, n: int) -> TrianglePairs:
    angle = powers(rng, n, -9, -1)
    angle[: n // 5] = 0.0
    size_a, size_b = powers(rng, n, 0, 2), powers(rng, n, 0, 2)
    return placed(rng, edges_near(rng, size_a, size_b, signed(rng, n, -9, -1), angle=angle), 1000)


def _coplanar(rng: np.random.Generator, n: int) -> TrianglePairs:
    """Return pairs in one plane normal to an axis: A's apex over (or in) an edge of B."""
    size_a, size_b, gap = (
        powers(rng, n, -1, 2),
        powers(rng, n, -1, 2),
        signed(rng, n, -9, 0),
    )
    flat = np.zeros((2, n, 3, 2))
    flat[0, :, 0, 1] = gap
    flat[0, :, 1:, 0] = size_a[:, None] * rng.uniform(-1, 1, (n, 2))
    flat[0, :, 1:, 1] = gap[:, None] + size_a[:, None] * rng.uniform(0.05, 1, (n, 2))
    flat[1, :, :2, 0] = size_b[:, None] * rng.uniform(0.1, 1, (n, 2)) * [-1, 1]
    flat[1, :, 2, 0] = size_b * rng.uniform(-1, 1, n)
    flat[1, :, 2, 1] = -size_b * rng.uniform(0.05, 1, n)
    turn = rng.uniform(0, 2 * np.pi, (n, 1))
    shift = rng.uniform(-800, 800, (2, n, 1))
    x, y = np.moveaxis(flat, -1, 0)
    x, y = (
        np.cos(turn) * x - np.sin(turn) * y + shift[0],
        np.sin(turn) * x + np.cos(turn) * y + shift[1],
    )
    z = np.broadcast_to(rng.uniform(-800, 800, (n, 1)), x.shape)
    axes = (rng.integers(0, 3, (n, 1)) + np.arange(3)) % 3
    a, b = np.take_along_axis(np.stack([x, y, z], axis=-1), axes[None, :, None, :], axis=-1)
    return a, b


def _slivers(rng: np.random.Generator, n: int) -> TrianglePairs:
    """Return pairs of equally thin slivers: third vertices pulled almost onto the first edge."""
    size_a, size_b = powers(rng, n, 0, 2.5), powers(rng, n, 0, 2.5)
    a, b = _mix(rng, size_a, size_b, signed(rng, n, -8, -1))
    aspect = powers(rng, n, 3, 8)[:, None]
    for t in (a, b):
        foot = t[:, 0] + rng.uniform(0.2, 0.8, (n, 1)) * (t[:, 1] - t[:, 0])
        t[:, 2] = foot + (t[:, 2] - foot) / aspect
    return placed(rng, (a, b), 1000)


def _degenerate(rng: np.random.Generator, n: int) -> TrianglePairs:
    """Return segments and points: A segment, A point, B segment, both, A split at its middle."""
    size_a, size_b = powers(rng, n, 0, 2), powers(rng, n, 0, 2)
    a, b = _mix(rng, size_a, size_b, signed(rng, n, -8, -1))
    kind = rng.integers(0, 5, n)
    for t, segment in ((a, np.isin(kind, (0, 3))), (b, np.isin(kind, (2, 3)))):
        t[segment, 2] = t[segment, 1]
    a[kind == 1] = a[kind == 1, :1]
    a, b = placed(rng, (a, b), 1000)
    split = kind == 4
    for t in (a, b):
        t[split] = np.round(t[split] * 64) / 64
    a[split, 2] = (a[split, 0] + a[split, 1]) / 2
    return a, b


def _exact_touch(rng: np.random.Generator, n: int) -> TrianglePairs:
    """Return pairs that share one point or edge exactly; in a third B is then moved by one ulp."""
    a, b = rng.integers(-(2**19), 2**19, (2, n, 3, 3))
    kind = rng.integers(0, 4, n)
    vertex, edge, face, midpoints = (kind == k for k in range(4))
    b[vertex, 0] = a[vertex, 0]
    b[edge, :2] = a[edge, :2]
    e = np.round((a[face, 1:] - a[face, :1]) / 16).astype(np.int64) * 16
    a[face, 1:] = a[face, :1] + e
    b[face, 0] = a[face, 0] + (5 * e[:, 0] + 7 * e[:, 1]) // 16
    b[midpoints, 1] = a[midpoints, 0] + a[midpoints, 1] - b[midpoints, 0]
    a, b = a / 1024, b / 1024
    moved = np.flatnonzero(rng.random(n) < 1 / 3)
    axis, towards = rng.integers(0, 3, len(moved)), rng.choice([-np.inf, np.inf], len(moved))
    b[moved, :, axis] = np.nextafter(b[moved, :, axis], towards[:, None])
    return a, b


def _far_origin(rng: np.random.Generator, n: int) -> TrianglePairs:
    size_a, size_b = powers(rng, n, -3, 1), powers(rng, n, -3, 1)
    return placed(rng, _mix(rng, size_a, size_b, signed(rng, n, -6, 0)), powers(rng, n, 5, 7))


def _micro(rng: np.random.Generator, n: int) -> TrianglePairs:
    size = powers(rng, n, -4, -2)
    return placed(rng, _mix(rng, size, size, size * signed(rng, n, -3, 0)), 1.0)


_GENERATORS: dict[str, Callable[[np.random.Generator, int], TrianglePairs]] = {
    "F01": _random,
    "F02": _near_contact((-0.3, 2.3), (-9, -1), 1500),
    "F03": _parallel_edges,
    "F04": _coplanar,
    "F05": _near_contact((0, 2), (-9, -2), 1000, tilts=(-9, -2)),
    "F06": _slivers,
    "F07": _degenerate,
    "F08": _exact_touch,
    "F09": _far_origin,
    "F10": _micro,
    "F12": _near_contact((2.5, 3.7), (-6, 1), 3000),
    "F13": _near_contact((-3, -1), (-8, 0), 2000, sizes_b=(3, 4)),
}

FAMILIES = tuple(f"F{i:02d}" for i in range(1, 14))
