"""The interval that a part sweeps from a line is that of many standing cuts, in every direction."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import warp as wp

from gcodesim.stock.line_cuts import Growth, Seams
from gcodesim.stock.sweeps import BALL, Swept, sweep_cut

COUNT, STEPS = 1500, 1000
KINDS = (
    "general",
    "axis along the line",
    "axis across the line",
    "way along the line",
    "way across the line",
    "way along the axis",
    "way across the axis",
    "way along a generatrix",
    "no way",
    "line, way and axis in one plane",
)


@wp.struct
class Case:
    part: Swept
    growth: Growth


@wp.kernel(enable_backward=False)
def compare(
    cases: wp.array[Case], steps: int, swept_out: wp.array[wp.vec2d], stood_out: wp.array[wp.vec2d]
):
    i = wp.tid()
    case = cases[i]
    at = wp.vec2d(wp.float64(0.0), wp.float64(0.0))
    swept_out[i] = sweep_cut(case.part, at, case.growth)
    low = wp.float64(1.0e9)
    high = wp.float64(-1.0e9)
    way = case.part.way
    origin = case.part.origin
    case.part.way = wp.vec3d(wp.float64(0.0), wp.float64(0.0), wp.float64(0.0))
    for j in range(steps + 1):
        case.part.origin = origin + wp.float64(j) / wp.float64(steps) * way
        u = sweep_cut(case.part, at, case.growth)
        if u[0] < u[1]:
            low = wp.min(low, u[0])
            high = wp.max(high, u[1])
    stood_out[i] = wp.vec2d(low, high)


def unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=1)[:, None]


def random_cases(rng: np.random.Generator, kind: str) -> tuple[np.ndarray, ...]:
    """Kinds, shapes, origins, ways, axes, widenings and insets of random sweeps."""
    axis = unit(rng.normal(size=(COUNT, 3)))
    way = rng.normal(size=(COUNT, 3)) * 10 ** rng.uniform(-3, 1, (COUNT, 1))
    ball = rng.integers(0, 2, COUNT)
    origin = rng.normal(size=(COUNT, 3)) * 3
    z0 = rng.uniform(-2, 2, COUNT)
    low = rng.uniform(0, 4, COUNT) * (rng.random(COUNT) > 0.2)
    shape = np.column_stack([z0, z0 + rng.uniform(0.05, 6, COUNT), low, rng.uniform(0.2, 4, COUNT)])
    round_ = rng.random(COUNT) < 0.15
    shape[round_, 3] = shape[round_, 2] = shape[round_, 2] + 0.3
    radius = rng.uniform(1, 4, COUNT)
    shape[ball == 1] = np.column_stack([z0, z0, radius, radius])[ball == 1]
    if kind == "axis along the line":
        axis = np.array([0, 0, 1.0]) * rng.choice([-1, 1], (COUNT, 1))
    if kind == "axis across the line":
        axis[:, 2] = 0
        axis = unit(axis)
    if kind == "way along the line":
        way[:, :2] = 0
    if kind == "way across the line":
        way[:, 2] = 0
    if kind == "way along the axis":
        way = axis * way[:, :1]
    if kind == "way across the axis":
        way -= axis * (way * axis).sum(1)[:, None]
    if kind == "way along a generatrix":
        slope = (shape[:, 3] - shape[:, 2]) / np.where(ball == 1, 1.0, shape[:, 1] - shape[:, 0])
        across = unit(np.cross(axis, rng.normal(size=(COUNT, 3))))
        way = (axis + slope[:, None] * across) * way[:, :1]
    if kind == "no way":
        way[:] = 0
    if kind == "line, way and axis in one plane":
        origin[:, 1] = way[:, 1] = axis[:, 1] = 0
        axis = unit(axis)
    widen = rng.choice([0, 0.05, -0.05, 0.4, -0.4], COUNT)
    inset = rng.choice([0, 0.05, 0.2], COUNT)
    return ball, shape, origin, way, axis, widen, inset


def as_cases(columns: tuple[np.ndarray, ...]) -> Any:
    cases = []
    for ball, shape, origin, way, axis, widen, inset in zip(*columns, strict=True):
        case = Case()
        case.part.kind = int(ball)
        case.part.shape = wp.vec4d(*shape)
        case.part.seams = Seams()
        case.part.seams.low = case.part.seams.high = 1.0
        case.part.origin, case.part.way = wp.vec3d(*origin), wp.vec3d(*way)
        case.part.axis = wp.vec3d(*axis)
        case.growth.widen, case.growth.inset = float(widen), float(inset)
        cases.append(case)
    return wp.array(cases, dtype=Case, device="cpu")


@pytest.mark.parametrize("kind", KINDS)
def test_a_sweep_is_the_union_of_standing_cuts(kind: str, rng: np.random.Generator) -> None:
    columns = random_cases(rng, kind)
    swept = wp.zeros(COUNT, dtype=wp.vec2d, device="cpu")
    stood = wp.zeros(COUNT, dtype=wp.vec2d, device="cpu")
    wp.launch(compare, COUNT, [as_cases(columns), STEPS], [swept, stood], device="cpu")
    got, want = swept.numpy(), stood.numpy()
    seen, hit = want[:, 0] < want[:, 1], got[:, 0] < got[:, 1]
    assert seen.sum() > COUNT / 20
    assert hit[seen].all()
    short = np.maximum(got[:, 0] - want[:, 0], want[:, 1] - got[:, 1])[seen]
    beyond = np.maximum(want[:, 0] - got[:, 0], got[:, 1] - want[:, 1])[seen]
    is_ball = columns[0][seen] == int(BALL)
    assert short[~is_ball].max(initial=0.0) < 1e-12
    assert short[is_ball].max(initial=0.0) < 1e-6
    # What the union has more is what so many standing cuts do not see.
    step = np.linalg.norm(columns[3], axis=1)[seen] / STEPS
    assert np.median(beyond) < 1e-6
    assert np.percentile(beyond - 50.0 * step, 99) < 1e-3
