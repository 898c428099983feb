"""Triangle pairs at extreme scales, far from the origin, in any order, and of no number at all.

The truth is known by construction: a vertex over a face at a height that is a small integer times a
power of two, sheared by a matrix of integers; no coordinate is rounded.
"""

from __future__ import annotations

import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from itertools import permutations
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gcodesim.collision.geometry.triangles import triangles_intersect
from gcodesim.errors import ModelError
from gcodesim.machine.mesh import read_mesh
from gcodesim.study.stability_case import Case
from gcodesim.study.stability_motion import SEED

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]
STL = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def near_pairs(count: int, finest: int, seed: int) -> tuple[Array, Array, Bools]:
    """Pairs about 100 mm across, and which of them touch.

    Vertex 0 of A stands over the inside of B in the plane z = 0 at a height of -64 .. 64 times
    2^-finest mm, the rest of A is above; a shear by integers turns both away from the axes, and a
    shift by integers moves them up to a metre away.
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
    shift = rng.integers(-1000, 1001, (count, 1, 3))
    turned = [np.einsum("nij,nkj->nki", shear, t) + shift for t in (a, b)]
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


def plane_contact(a: Array, b: Array) -> Bools:
    """Moeller's first test alone, which decides these pairs: n.x + d against 1e-6, float64."""
    normal = np.cross(b[:, 1] - b[:, 0], b[:, 2] - b[:, 0])
    away = np.einsum("nj,nkj->nk", normal, a) - np.einsum("nj,nj->n", normal, b[:, 0])[:, None]
    away = np.where(np.abs(away) < 1e-6, 0.0, away)
    return np.asarray(~((away > 0).all(axis=1) | (away < 0).all(axis=1)))


TextbookTest = Callable[[Array, Array], Bools]
TEXTBOOK: dict[str, TextbookTest] = {
    "17 axes, float32": lambda a, b: textbook_contact(a, b, np.float32),
    "17 axes, float64": lambda a, b: textbook_contact(a, b, np.float64),
    "n.x + d over 1e-6": plane_contact,
}


def contacts(a: Array, b: Array) -> dict[str, Bools]:
    """The verdicts of the textbook's tests, and of ours under the empty name."""
    with np.errstate(all="ignore"):
        found = {name: test(a, b) for name, test in TEXTBOOK.items()}
    return {**found, "": triangles_intersect(a, b)}


def scales(quick: bool) -> Iterator[Case]:
    """The same pairs times powers of two: 2^300 mm is 2e93 mm."""
    a, b, touch = near_pairs(500 if quick else 5000, 30, 1)
    missed, wrong = Counter[str](), Counter[str]()
    for exponent in range(-300, 301, 50):
        for name, found in contacts(np.ldexp(a, exponent), np.ldexp(b, exponent)).items():
            missed[name] += int(np.count_nonzero(touch & ~found))
            # Beyond RANGE_GUARD every pair counts as contact.
            wrong[name] += int(np.count_nonzero(touch != found)) if exponent <= 200 else 0
    yield from _counted("scale", "times 2^-300 .. 2^300", "touching pairs missed", missed)
    yield from _counted("scale", "times 2^-300 .. 2^200", "wrong verdicts", wrong)


def far_origins(quick: bool) -> Iterator[Case]:
    """Pairs with gaps down to 1e-6 mm, moved by a kilometre and by sixteen."""
    for power in (20, 24):
        a, b, touch = near_pairs(500 if quick else 20_000, 20, power)
        shift = np.ldexp([1.0, -0.75, 0.5], power)
        wrong = _wrong(contacts(a + shift, b + shift), touch)
        yield from _counted("scale", f"{2**power / 1e6:.0f} km from the origin",
                            "wrong verdicts", wrong)  # fmt: skip


def orders(quick: bool) -> Iterator[Case]:
    """Corners in any order, sides exchanged, mirrored, axes exchanged: nothing may change."""
    a, b, touch = near_pairs(300 if quick else 5000, 36, 2)
    variants = [(a[:, list(o)], b) for o in permutations(range(3))]
    variants += [(q, p) for p, q in variants]
    variants += [(a * m, b * m) for m in ([-1, 1, 1], [1, -1, 1], [1, 1, -1], [-1, -1, -1])]
    variants += [(a[..., c], b[..., c]) for c in ([1, 2, 0], [2, 0, 1], [1, 0, 2])]
    wrong = Counter[str]()
    for pair in variants:
        wrong.update(_wrong(contacts(*pair), touch))
    case = f"{len(variants)} orders, mirrors, axes"
    yield from _counted("same", case, "wrong verdicts", wrong)


def not_numbers(quick: bool) -> Iterator[Case]:
    """NaN and infinity in one coordinate: a verdict of "apart" would be a lie."""
    a, b, touch = near_pairs(900, 3, 3)
    a, b = a[~touch], b[~touch]
    for bad in (np.nan, np.inf):
        both = np.stack([a, b], axis=1).reshape(len(a), 18)
        row = np.arange(len(both))
        both[row, row % 18] = bad
        pairs = both.reshape(-1, 2, 3, 3)
        apart = _wrong(contacts(pairs[:, 0], pairs[:, 1]), np.ones(len(both), bool))
        yield from _counted("numbers", f"one coordinate is {bad}", "pairs called apart", apart)


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


def _wrong(found: dict[str, Bools], truth: Bools) -> dict[str, int]:
    return {name: int(np.count_nonzero(contact != truth)) for name, contact in found.items()}


def _counted(topic: str, case: str, quantity: str, counts: Mapping[str, int]) -> Iterator[Case]:
    """One case for every textbook test, beside ours."""
    ours = float(counts[""])
    for usual in TEXTBOOK:
        yield Case(topic, case, quantity, usual, float(counts[usual]), ours, 0.0, "pairs")


TRIANGLES = (scales, far_origins, not_numbers, bad_meshes, orders)
