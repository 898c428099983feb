"""Errors that no search can undo: of poses, of polygons for round shapes, of the sum of times."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from decimal import Decimal, localcontext
from fractions import Fraction
from math import asin, cos, degrees, pi, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import PS_PER_S
from gcodesim.machine.control_data import bare_control
from gcodesim.machine.kinematics import transform, world_from_link
from gcodesim.machine.model import Machine
from gcodesim.motion.planner import plan
from gcodesim.nc.interpret import interpret
from gcodesim.study.exact_motion import exact_sincosd
from gcodesim.study.methods import Subject, search_between
from gcodesim.study.scenes import (
    BED_MOVER,
    CONSTANT,
    SCENES,
    KnownScene,
    joint,
    machine,
    path,
    polygon,
    prism,
    rectangle,
)

Floats = NDArray[np.float64]

INSTANTS = 25
"""Instants at which poses are compared, spread over the path."""

DIGITS = 50


def _row(
    scene: str,
    method: str,
    knob: str,
    setting: float,
    unit: str,
    errors: Iterable[float],
    bound: float | None,
) -> dict[str, Any]:
    sizes = [abs(e) for e in errors]
    return {
        "scene": scene,
        "method": method,
        "knob": knob,
        "setting": setting,
        "unit": unit,
        "runs": len(sizes),
        "error_median": float(np.median(sizes)),
        "error_max": max(sizes),
        "bound": bound,
    }


# --- poses ----------------------------------------------------------------------------------------

POSE_SCENES = ("S1", "S3", "S4", "S5")
"""Straight moves of one joint: their poses have a closed form in a few roundings."""

POSE_MM = 1e-11
"""Goal G12 [mm]."""


def pose_rows() -> list[dict[str, Any]]:
    """Largest distance of a vertex from where it belongs, in two precisions, over a path [mm]."""
    rows = []
    for name in POSE_SCENES:
        scene = SCENES[name]()
        for precision in ("float32", "float64"):
            bound = POSE_MM if precision == "float64" else None
            errors = _pose_errors(scene, precision)
            rows.append(_row(name, "pose", precision, 0.0, "mm", errors, bound))
    return rows


def _pose_errors(scene: KnownScene, precision: str) -> Iterator[float]:
    path = scene.path
    vertices = np.unique(scene.machine.bodies["mover"].parts[0].triangles.reshape(-1, 3), axis=0)
    for time_ps in np.linspace(0, path.duration_ps, INSTANTS).astype(np.int64).tolist():
        q = path.positions(np.array([time_ps]))[0]
        pose = world_from_link(scene.machine, q)["mover"].astype(precision)
        posed = transform(pose, vertices.astype(precision))
        true = _posed_exactly(scene, time_ps, vertices)
        with localcontext(prec=DIGITS):
            yield max(_distance(p, t) for p, t in zip(posed, true, strict=True))


def _distance(point: Floats, true: list[Decimal]) -> float:
    squares = [(Decimal(float(x)) - t) ** 2 for x, t in zip(point, true, strict=True)]
    return float(sum(squares, Decimal(0)).sqrt())


def _posed_exactly(scene: KnownScene, time_ps: int, vertices: Floats) -> list[list[Decimal]]:
    """Vertices under the one joint of a scene, to 40 digits; its axis is a coordinate axis."""
    path, moving = scene.path, scene.machine.joints[0]
    piece = int(path.piece_at(np.array([time_ps]))[0])
    start, end = (int(t) for t in path.bounds_ps[piece : piece + 2])
    q0, q1 = Fraction(float(path.q0[piece, 0])), Fraction(float(path.q1[piece, 0]))
    q = q0 + (q1 - q0) * Fraction(time_ps - start, end - start)
    with localcontext(prec=DIGITS):
        points = [[Decimal(float(x)) for x in v] for v in vertices]
        k = int(np.argmax(np.abs(moving.axis)))
        sign = int(moving.axis[k])
        if not moving.rotary:
            way = sign * Decimal(q.numerator) / Decimal(q.denominator)
            return [[x + way * (i == k) for i, x in enumerate(p)] for p in points]
        sine, cosine = exact_sincosd(sign * q)
        i, j = (k + 1) % 3, (k + 2) % 3
        for p in points:
            p[i], p[j] = cosine * p[i] - sine * p[j], sine * p[i] + cosine * p[j]
        return points


# --- round shapes ---------------------------------------------------------------------------------

RADIUS, ARM, FACE, RATE = 8.0, 120.0, 60.0, 90.0
"""S4 with a smooth tool: its radius, distance from the table's axis, that of the face [mm], and the
rate of the table [deg/s]."""

PHASES = 20


def chord_rows(sides: tuple[int, ...]) -> list[dict[str, Any]]:
    """Distance of a smooth round tool from a face when the polygon in its place first touches it.

    S4: the gap of the smooth tool is FACE - RADIUS - ARM sin(angle). A polygon around the circle
    touches early, by what its corners stand out at most; one inside touches late.
    """
    rows = []
    for n in sides:
        outer, inner = RADIUS / cos(pi / n), RADIUS * cos(pi / n)
        for method, corner, bound in (
            ("polygon around", outer, outer - RADIUS),
            ("polygon inside", RADIUS, RADIUS - inner),
        ):
            gaps = [_smooth_gap(n, corner, j / PHASES) for j in range(PHASES)]
            rows.append(_row("S4", method, "sides", n, "mm", gaps, bound))
    return rows


def _smooth_gap(sides: int, radius: float, phase: float) -> float:
    """Gap of the smooth tool [mm] at the first touch of a prism turned by a part of its step."""
    tool = polygon(sides, radius, [ARM, 0.0], phase * 2.0 * pi / sides)
    block = rectangle([30, 30], [112, -75])
    joints = [joint("C", [0, 0, 1])]
    bodies = {"bed": prism(tool, -30, 60), "mover": prism(block, -20, 20)}
    scene = KnownScene(
        machine(joints, bodies, BED_MOVER),
        path(joints, [0.0], [(0.4, [0.4 * RATE])], CONSTANT),
        degrees(asin((FACE - RADIUS) / ARM)) / RATE,
    )
    found = search_between(Subject(scene), 1e-9).time_ps
    assert found is not None
    turned = found / PS_PER_S * RATE
    return FACE - RADIUS - ARM * sin(turned * pi / 180.0)


# --- cycle time -----------------------------------------------------------------------------------

STEP_MM, FEED = "0.0137", "1234.5"
"""One block of the program [mm] and its feed [mm/min]: its time is no whole number of ps."""

CYCLE_S = 1e-6
"""Goal G13 [s]."""

SUMS: dict[str, Callable[[Floats], float]] = {
    "float32 sum": lambda t: float(np.cumsum(t.astype(np.float32))[-1]),
    "float64 sum": lambda t: float(np.cumsum(t)[-1]),
}


def cycle_rows(blocks: int) -> list[dict[str, Any]]:
    """Program time of many equal blocks against the exact quotient of decimals [s]."""
    exact = blocks * Fraction(STEP_MM) * 60 / Fraction(FEED)
    text = "G21 G91 G94\nG1 F" + FEED + "\n" + f"X{STEP_MM}\n" * blocks + "M30\n"
    moving = machine([joint("X", [1, 0, 0], travel=(-1e9, 1e9))], {}, [])
    ours = Fraction(_planned_ps(text, moving), PS_PER_S)
    each = np.full(blocks, float(Fraction(STEP_MM) * 60 / Fraction(FEED)))
    rows = [
        _row("program", name, "blocks", blocks, "s", [float(Fraction(add(each)) - exact)], None)
        for name, add in SUMS.items()
    ]
    error = [float(ours - exact)]
    return [*rows, _row("program", "picoseconds", "blocks", blocks, "s", error, CYCLE_S)]


def _planned_ps(text: str, moving: Machine) -> int:
    meaning = interpret(text, bare_control(None, None, None, False), "cycle.nc")
    return plan(meaning.program, moving)[0].duration_ps
