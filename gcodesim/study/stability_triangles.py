"""Triangle pairs at extreme scales, far from the origin, in any order, and of no number at all.

The truth is known by construction: a vertex over a face at a height that is a small integer times a
power of two, sheared by a matrix of integers; no coordinate is rounded.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from itertools import permutations
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gcodesim.collision.triangles import triangles_intersect
from gcodesim.errors import ModelError
from gcodesim.machine.mesh import read_mesh
from gcodesim.study.stability_case import Case
from gcodesim.study.stability_motion import FLOATS, SEED

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]
STL = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def near_pairs(count: int, finest: int, seed: int) -> tuple[Array, Array, Bools]:
    """Pairs about 100 mm across, and which of them touch.

    Vertex 0 of A stands over the inside of B in the plane z = 0 at a height of -64 .. 64 times
    2^-finest mm, the rest of A is above; a shear by integers turns both away from the axes.
    """
    rng = np.random.default_rng([SEED, seed])
    b = np.zeros((count, 3, 3))
    b[..., :2] = np.array([[-40, -30], [50, -20], [0, 60]]) + rng.integers(-9, 10, (count, 3, 2))
    a = np.zeros((count, 3, 3))
    a[:, 1:] = rng.integers([-60, -60, 1], [61, 61, 40], (count, 2, 3))
    height = rng.integers(-64, 65, count)
    a[:, 0, 2] = np.ldexp(height.astype(np.float64), -finest)
    shear = np.tile(np.eye(3), (count, 1, 1))
    for row, column in ((0, 1), (1, 2), (2, 0), (0, 2), (2, 1)):
        step = np.tile(np.eye(3), (count, 1, 1))
        step[:, row, column] = rng.integers(-2, 3, count)
        shear = step @ shear
    turned = [np.einsum("nij,nkj->nki", shear, t) for t in (a, b)]
    return turned[0], turned[1], height <= 0


def textbook_contact(a: Array, b: Array, dtype: type[np.floating]) -> Bools:
    """Separating axes as in a textbook: 17 axes, a gap above 0 separates; minimum as in C."""
    p, q = (t.astype(dtype) for t in (a, b))
    edges_p, edges_q = (np.roll(t, -1, axis=1) - t for t in (p, q))
    normals = [np.cross(e[:, 0], e[:, 1]) for e in (edges_p, edges_q)]
    axes = [*normals]
    axes += [np.cross(edges_p[:, i], edges_q[:, j]) for i in range(3) for j in range(3)]
    for normal, edges in zip(normals, (edges_p, edges_q), strict=True):
        axes += [np.cross(normal, edges[:, i]) for i in range(3)]
    apart = np.zeros(len(a), bool)
    for axis in axes:
        along = [np.einsum("nj,nkj->nk", axis, t) for t in (p, q)]
        low, high = ([f.reduce(x, axis=1) for x in along] for f in (np.fmin, np.fmax))
        apart |= (low[1] > high[0]) | (low[0] > high[1])
    return ~apart


def ours_contact(a: Array, b: Array) -> Bools:
    """The certified test."""
    return np.asarray(triangles_intersect(a, b))


def scales(quick: bool) -> Iterator[Case]:
    """The same pairs times powers of two: 2^300 mm is 2e93 mm."""
    a, b, touch = near_pairs(500 if quick else 5000, 30, 1)
    for low, high, quantity in ((-300, 300, "touching pairs missed"), (-300, 200, "wrong verdicts")):
        counts = {"": 0, **dict.fromkeys(FLOATS, 0)}
        for exponent in range(low, high + 1, 50):
            scaled = np.ldexp(a, exponent), np.ldexp(b, exponent)
            with np.errstate(all="ignore"):
                found = {n: textbook_contact(*scaled, dtype) for n, dtype in FLOATS.items()}
            found[""] = ours_contact(*scaled)
            for name, contact in found.items():
                wrong = touch & ~contact if "missed" in quantity else touch != contact
                counts[name] += np.count_nonzero(wrong)
        case = f"times 2^{low} .. 2^{high}"
        yield from _counted(case, quantity, counts, "pairs")


def far_origins(quick: bool) -> Iterator[Case]:
    """Pairs with gaps down to 2^-20 mm, moved by a kilometre and by sixteen."""
    for power in (20, 24):
        a, b, touch = near_pairs(500 if quick else 20_000, 20, power)
        shift = np.ldexp([1.0, -0.75, 0.5], power)
        pairs = a + shift, b + shift
        counts = {n: textbook_contact(*pairs, dtype) for n, dtype in FLOATS.items()}
        counts[""] = ours_contact(*pairs)
        wrong = {name: np.count_nonzero(found != touch) for name, found in counts.items()}
        yield from _counted(f"2^{power} mm from the origin", "wrong verdicts", wrong, "pairs")


def orders(quick: bool) -> Iterator[Case]:
    """Corners in any order, sides exchanged, mirrored, axes exchanged: nothing may change."""
    a, b, touch = near_pairs(300 if quick else 5000, 44, 2)
    variants = [(a[:, list(o)], b) for o in permutations(range(3))]
    variants += [(q, p) for p, q in variants]
    variants += [(a * m, b * m) for m in ([-1, 1, 1], [1, -1, 1], [1, 1, -1], [-1, -1, -1])]
    variants += [(a[..., c], b[..., c]) for c in ([1, 2, 0], [2, 0, 1], [1, 0, 2])]
    counts = dict.fromkeys(["", *FLOATS], 0)
    for pair in variants:
        found = {n: textbook_contact(*pair, dtype) for n, dtype in FLOATS.items()}
        found[""] = ours_contact(*pair)
        for name, contact in found.items():
            counts[name] += np.count_nonzero(contact != touch)
    case = f"{len(variants)} orders, mirrors, axes"
    yield from _counted(case, "wrong verdicts", counts, "pairs")


def not_numbers(quick: bool) -> Iterator[Case]:
    """NaN and infinity in one coordinate: a verdict of "apart" would be a lie."""
    a, b, touch = near_pairs(900, 3, 3)
    a, b = a[~touch], b[~touch]
    for bad in (np.nan, np.inf):
        both = np.stack([a, b], axis=1)
        place = np.arange(len(both)) % 18
        both.reshape(len(both), 18)[np.arange(len(both)), place] = bad
        pairs = both[:, 0], both[:, 1]
        with np.errstate(all="ignore"):
            counts = {n: np.count_nonzero(~textbook_contact(*pairs, d)) for n, d in FLOATS.items()}
        counts[""] = np.count_nonzero(~ours_contact(*pairs))
        yield from _counted(f"one coordinate is {bad}", "pairs called apart", counts, "pairs")


def bad_meshes(quick: bool) -> Iterator[Case]:
    """Mesh files with a coordinate that is no number of mm."""
    accepted = 0
    values = (np.nan, np.inf, -np.inf, 3e38)
    with tempfile.TemporaryDirectory() as folder:
        for number, value in enumerate(values):
            table = np.zeros(4, STL)
            table["corners"] = np.random.default_rng(number).uniform(-9, 9, (4, 3, 3))
            table["corners"][number, 1, 2] = value
            file = Path(folder) / f"{number}.stl"
            file.write_bytes(bytes(80) + np.uint32(len(table)).tobytes() + table.tobytes())
            try:
                read_mesh(file)
                accepted += 1
            except ModelError:
                pass
    case = "NaN, infinity and 3e38 in an STL"
    yield Case("numbers", case, "meshes accepted", "", None, float(accepted), 0.0, "meshes")


def _counted(case: str, quantity: str, counts: dict[str, int], unit: str) -> Iterator[Case]:
    """Cases of one quantity: ours under the empty name, the textbook's under those of the types."""
    topic = "numbers" if "coordinate" in case else "scale"
    for name in FLOATS:
        yield Case(
            topic, case, quantity, f"17 axes, {name}", float(counts[name]), float(counts[""]),
            0.0, unit,
        )  # fmt: skip


TRIANGLES = (scales, far_origins, orders, not_numbers, bad_meshes)
