"""Write the STL meshes of the shipped machines: ``python machines/build_machines.py [FOLDER]``.

Every mesh is a handful of closed, outward oriented shells. Shells of one link may overlap (they are
one rigid body) but never share a vertex, so that each stays a closed surface of its own. Vertices
lie on a grid of 1/1024 mm, which float32 holds exactly: the STL is the shape, not a rounding of it,
and a second run writes the same bytes. Round shapes are circumscribed: never smaller than the true
shape (to the grid), and larger at the corners by at most ``radius * (1 / cos(pi / segments) - 1)``.

World coordinates in mm at the zero pose of all joints, Z up, +Y away from the operator.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Point = tuple[float, float]
Shell = NDArray[np.float64]  # triangles of one closed surface, shape (n, 3, 3)

GRID = 1024  # vertices are multiples of 1 / GRID mm; exact in float32 up to 16 m
RECORD = np.dtype([("normal", "<f4", 3), ("vertices", "<f4", (3, 3)), ("attribute", "<u2")])


# -- shapes ----------------------------------------------------------------------------------------


def on_grid(points: object) -> NDArray[np.float64]:
    """Return the coordinates rounded to the grid."""
    return np.round(np.asarray(points, dtype=np.float64) * GRID) / GRID


def cross2(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the z component of the cross product of plane vectors, shape (..., 2)."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def ear_diagonal(outline: NDArray[np.float64], ring: list[int], at: int) -> float:
    """Return the squared length of the diagonal that cuts off a corner; inf if it is no ear."""
    last, here, after = ring[at - 1], ring[at], ring[(at + 1) % len(ring)]
    corners = outline[[last, here, after]]
    if cross2(corners[1] - corners[0], corners[2] - corners[1]) <= 0:
        return math.inf
    others = outline[[i for i in ring if i not in (last, here, after)]]
    sides = [cross2(corners[(k + 1) % 3] - corners[k], others - corners[k]) >= 0 for k in range(3)]
    if len(others) and np.logical_and.reduce(sides).any():
        return math.inf
    return float(((corners[2] - corners[0]) ** 2).sum())


def triangulate(outline: NDArray[np.float64]) -> list[tuple[int, int, int]]:
    """Clip the ears of a counter-clockwise outline, shortest diagonal first: n - 2 triangles."""
    ring = list(range(len(outline)))
    faces = []
    while len(ring) > 3:
        diagonals = [ear_diagonal(outline, ring, at) for at in range(len(ring))]
        at = diagonals.index(min(diagonals))
        faces.append((ring[at - 1], ring[at], ring[(at + 1) % len(ring)]))
        del ring[at]
    return [*faces, (ring[0], ring[1], ring[2])]


def extrude(axis: str, outline: Sequence[Point], low: float, high: float) -> Shell:
    """Return a prism of 4 n - 4 triangles.

    The outline runs counter-clockwise in the plane that follows the axis in cyclic order:
    (y, z) for x, (z, x) for y, (x, y) for z.
    """
    flat = on_grid(outline)
    count = len(flat)
    bottom = np.column_stack([flat, np.full(count, low)])
    top = np.column_stack([flat, np.full(count, high)])
    cap = triangulate(flat)
    after = [(i + 1) % count for i in range(count)]
    shell = [bottom[[c, b, a]] for a, b, c in cap] + [top[[a, b, c]] for a, b, c in cap]
    for i, j in enumerate(after):
        shell += [np.stack([bottom[i], bottom[j], top[j]]), np.stack([bottom[i], top[j], top[i]])]
    order = {"x": [2, 0, 1], "y": [1, 2, 0], "z": [0, 1, 2]}[axis]
    return on_grid(shell)[:, :, order]


def box(low: tuple[float, float, float], high: tuple[float, float, float]) -> Shell:
    """Return a box of 12 triangles between two corners."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    return extrude("z", [(x0, y0), (x1, y0), (x1, y1), (x0, y1)], z0, z1)


def ngon(centre: Point, radius: float, sides: int) -> list[Point]:
    """Return the corners of a regular polygon circumscribed about a circle; a side faces +u."""
    corner = radius / math.cos(math.pi / sides)
    turns = [(2 * i + 1) * math.pi / sides for i in range(sides)]
    return [(centre[0] + corner * math.cos(t), centre[1] + corner * math.sin(t)) for t in turns]


def revolve(profile: Sequence[Point], segments: int, centre: Point = (0.0, 0.0)) -> Shell:
    """Turn (r, z) rings about a vertical axis: 2 * segments * rings triangles.

    The profile runs upwards and begins and ends on the axis (r = 0).
    """
    circle = np.array(ngon((0.0, 0.0), 1.0, segments))
    rings = [
        on_grid(np.column_stack([circle * r + centre, np.full(segments, z)]))
        for r, z in profile[1:-1]
    ]
    bottom, top = (on_grid([*centre, profile[end][1]]) for end in (0, -1))
    shell = []
    for i in range(segments):
        j = (i + 1) % segments
        shell += [np.stack([bottom, rings[0][j], rings[0][i]])]
        for low, high in pairwise(rings):
            shell += [np.stack([low[i], low[j], high[j]]), np.stack([low[i], high[j], high[i]])]
        shell += [np.stack([top, rings[-1][i], rings[-1][j]])]
    return np.array(shell)


def leaning(shell: Shell, pivot: float) -> Shell:
    """Return a shell about +Z through the origin, its axis turned to (0, 1, 1) through a pivot."""
    x, y, z = np.moveaxis(shell, 2, 0)
    root = math.sqrt(0.5)
    return on_grid(np.stack([x, root * (y + z), root * (z - y) + pivot], axis=2))


# -- components that several machines share --------------------------------------------------------


def cutter(gauge: float, length: float) -> list[Shell]:
    """Return a 12 mm ball end mill in a slim shrink-fit holder HSK 63: 716 triangles.

    The ball's profile is the polygon of tangents at 0, 18, .. 90 degrees, so that it too is
    circumscribed and the tip lies exactly at ``gauge - length``.
    """
    tip, nose = gauge - length, gauge - 98
    half_step = math.radians(9)
    ball = [
        (r * math.sin(t), tip + 6 - r * math.cos(t))
        for r, t in [(6 / math.cos(half_step), half_step * (2 * i + 1)) for i in range(5)]
    ]
    stem = [(6, tip + 26), (5.5, tip + 28), (5.5, nose - 8), (6, nose - 4), (6, nose + 38)]
    tool = [(0, tip), *ball, *stem, (0, nose + 38)]
    taper = [(0, nose), (12, nose), (15, nose + 50), (26.5, nose + 60), (26.5, gauge - 26)]
    flange = [(31.5, gauge - 26), (31.5, gauge - 18), (28, gauge - 13), (31.5, gauge - 8)]
    holder = [*taper, *flange, (31.5, gauge), (0, gauge)]
    return [revolve(tool, 16), revolve(holder, 22)]


def slotted_rim(centre: Point, radius: float) -> list[Point]:
    """Return a disc with six radial slots, 14 mm wide, down to radius 45: 66 points."""
    half_slot = math.asin(7 / radius)
    step = (math.pi / 3 - 2 * half_slot) / 8
    corner = radius / math.cos(step / 2)
    outline = []
    for slot in range(6):
        middle = slot * math.pi / 3
        across = math.atan2(7, 45)
        inner = math.hypot(7, 45)
        polar = [(inner, middle - across), (inner, middle + across)]
        polar += [(corner, middle + half_slot + step * i) for i in range(9)]
        outline += [(centre[0] + r * math.cos(t), centre[1] + r * math.sin(t)) for r, t in polar]
    return outline


def rotary_table(centre: Point, top: float, radius: float) -> list[Shell]:
    """Return a round table with six T-slots on a hub: 548 triangles, 48 mm high."""
    hub = [(0, top - 48), (95, top - 48), (95, top - 30), (radius - 2, top - 30)]
    body = revolve([*hub, (radius - 2, top - 12), (0, top - 12)], 36, centre)
    return [body, extrude("z", slotted_rim(centre, radius), top - 14, top)]


def rail(y: float, top: float, half_length: float) -> Shell:
    """Return a linear guide rail along X with a waist, 32 mm high: 28 triangles."""
    right = [(22, -32), (22, -18), (14, -12), (18, 0)]
    section = right + [(-u, v) for u, v in reversed(right)]
    return extrude("x", [(y + u, top + v) for u, v in section], -half_length, half_length)


def mirrored(axis: str, outline: Sequence[Point], low: float, high: float) -> list[Shell]:
    """Return the prism between low and high on the axis, and the one between -high and -low."""
    return [extrude(axis, outline, low, high), extrude(axis, outline, -high, -low)]


# -- the machines ----------------------------------------------------------------------------------


def table_tilt() -> dict[str, list[Shell]]:
    """Table-tilting: base slide Y, saddle X, cradle A, table C; spindle head Z.

    Triangle counts as in the seed paper: X 44, Y 136, Z 180, A 164, C 548, cutter 716.
    The A axis runs through (0, -6, 0), the table's surface lies at z = -40. Everything on A
    and C stays within 196 mm of the A axis; the saddle's floor and the bulkhead of Y lie beyond.
    """
    upright = [(-106, -235), (94, -235), (64, 30), (-6, 95), (-76, 30)]
    saddle = [box((-285, -116, -245), (285, 104, -205)), *mirrored("x", upright, 215, 275)]
    bulkhead = [(150, -320), (236, -320), (236, 110), (206, 110), (206, -285), (150, -285)]
    base = [
        box((-420, -200, -330), (420, 190, -275)),
        rail(-76, -248, 410),
        rail(64, -248, 410),
        extrude("x", bulkhead, -400, 400),
        *(box((x - 15, -190, -360), (x + 15, 185, -320)) for x in (-315, -105, 105, 315)),
    ]
    arm = [(-96, -130), (84, -130), (84, -80), (44, 52), (-56, 52), (-96, -80)]
    cradle = [
        box((-190, -100, -135), (190, 88, -90)),
        *mirrored("x", arm, 165, 195),
        *mirrored("x", ngon((-6, 0), 45, 10), 185, 213),
        extrude("z", ngon((0, 0), 70, 8), -178, -120),
        box((60, -60, -165), (165, 50, -125)),
    ]
    head_front = [(-60, 1000), (-110, 950), (-110, 630), (-80, 600)]
    head_back = [(260, 600), (320, 680), (320, 960), (260, 1000)]
    nose = [(0, 480), (50, 480), (52, 500), (80, 600), (80, 645), (0, 645)]
    head = [
        extrude("x", head_front + head_back, -115, 115),
        revolve(nose, 16),
        box((-60, -60, 990), (60, 60, 1120)),
        box((-150, 300, 640), (150, 350, 990)),
    ]
    table = rotary_table((0, 0), -40, 150)
    return {"X": saddle, "Y": base, "Z": head, "A": cradle, "C": table, "cutter": cutter(480, 160)}


def spindle(gauge: float, pivot: float, hubs: Sequence[tuple[float, float]]) -> list[Shell]:
    """Return a swivelling spindle with bearing hubs along Y about its pivot."""
    nose = [(0, gauge), (45, gauge), (48, gauge + 18), (70, gauge + 85)]
    body = revolve([*nose, (70, pivot + 85), (60, pivot + 100), (0, pivot + 100)], 24)
    return [body, *(extrude("y", ngon((pivot, 0), 60, 16), low, high) for low, high in hubs)]


def slotted_plate() -> Shell:
    """Return the fixed table of head_tilt: 1300 x 700 mm, surface at z = 0, five slots along X."""
    top = [(350.0, 0.0)]
    for y in (240, 120, 0, -120, -240):
        top += [(y + 9, 0), (y + 9, -20), (y - 9, -20), (y - 9, 0)]
    return extrude("x", [(-350, -140), (350, -140), *top, (-350, 0)], -650, 650)


def head_tilt() -> dict[str, list[Shell]]:
    """Spindle-tilting: fixed table, travelling column X, saddle Z, ram Y, fork C, spindle B.

    The C and B axes meet in (0, 0, 900); the table's surface lies at z = 0.
    """
    bed = [
        slotted_plate(),
        box((-600, -300, -420), (600, 300, -130)),
        box((-950, 410, -420), (950, 800, -245)),
        rail(480, -215, 940),
        rail(740, -215, 940),
    ]
    portal = [(-170, -400), (1540, -400), (1540, 400), (-170, 400), (-170, 235), (1430, 235)]
    column = [
        box((-420, 430, -210), (420, 790, -120)),
        extrude("y", [*portal, (1430, -235), (-170, -235)], 440, 700),
        *(extrude("y", ngon((-165, x), 30, 12), 690, 770) for x in (-300, 300)),
    ]
    bracket = [(1115, -231), (1400, -231), (1400, 231), (1115, 231), (1115, 155), (1345, 155)]
    saddle = [
        extrude("y", [*bracket, (1345, -155), (1115, -155)], 420, 680),
        *mirrored("x", [(405, 1130), (436, 1130), (436, 1390), (405, 1390)], 160, 330),
        revolve([(0, 1390), (50, 1390), (50, 1425), (0, 1425)], 24, (0, 560)),
    ]
    half = [(1125, 120), (1145, 148), (1310, 148), (1330, 120)]
    section = [(z, -x) for z, x in half] + half[::-1]
    ram = [
        extrude("y", section, -165, 1000),
        revolve([(0, 1100), (150, 1100), (150, 1140), (0, 1140)], 32),
    ]
    arm = [(1070, 80), (870, 80), (815, 45), (800, 20)]
    arm_outline = arm + [(z, -x) for z, x in reversed(arm)]
    flange = [(0, 1062), (152, 1062), (160, 1070), (160, 1090), (150, 1097), (0, 1097)]
    fork = [revolve(flange, 32), *mirrored("y", arm_outline, 85, 130)]
    return {
        "bed": bed,
        "X": column,
        "Z": saddle,
        "Y": ram,
        "C": fork,
        "B": spindle(700, 900, [(55, 82), (-82, -55)]),
        "cutter": cutter(700, 150),
    }


def nutating_head() -> dict[str, list[Shell]]:
    """Spindle-nutating: bed, column, saddle and ram of head_tilt; carrier C, nutating spindle B.

    The axes of C (+Z) and B (0, 1, 1) meet in (0, 0, 900). C and B part in the plane through that
    point perpendicular to the axis of B: what is B stays below it, however it turns.
    """
    machine = head_tilt()
    flange = [(0, 1062), (152, 1062), (160, 1070), (160, 1090), (150, 1097), (0, 1097)]
    neck = [(0, 985), (80, 985), (80, 1070), (0, 1070)]
    nose = [(0, 700), (45, 700), (48, 718), (68, 785), (68, 815), (0, 815)]
    carrier = leaning(extrude("z", ngon((0, 0), 90, 24), 2, 75), 900)
    knuckle = leaning(extrude("z", ngon((0, 0), 90, 24), -75, -2), 900)
    machine["C"] = [revolve(flange, 32), revolve(neck, 24), carrier]
    machine["B"] = [revolve(nose, 24), knuckle]
    return machine


def table_head() -> dict[str, list[Shell]]:
    """One rotary joint in each branch: table slide X with table C; bridge Y, ram Z, spindle B.

    The C axis stands at (20, -15), the table's surface lies at z = 60, the B axis runs through
    (0, 0, 780).
    """
    wall = [(-420, -120), (420, -120), (420, 880), (330, 900), (-330, 900), (-420, 880)]
    bed = [
        box((-700, -430, -400), (700, 430, -110)),
        *mirrored("x", wall, 560, 690),
        rail(-160, -80, 550),
        rail(130, -80, 550),
    ]
    slide = [
        box((-180, -225, -55), (220, 195, 10)),
        *(box((x, y - 35, -77), (x + 90, y + 35, -50)) for x in (-170, 120) for y in (-160, 130)),
        extrude("x", ngon((-15, -22), 30, 16), 210, 255),
    ]
    beam = [(110, 905), (300, 905), (300, 1080), (260, 1120), (150, 1120), (110, 1080)]
    bridge = [
        extrude("x", beam, -640, 640),
        *mirrored("x", [(60, 903), (340, 903), (340, 960), (60, 960)], 565, 685),
        revolve([(0, 1110), (60, 1110), (60, 1160), (45, 1175), (0, 1175)], 32, (0, 205)),
    ]
    front = [(-75, 1300), (-75, 900), (76, 900), (76, 700)]
    back = [(150, 700), (150, 890), (105, 890), (105, 1300)]
    ram = [
        extrude("x", front + back, -90, 90),
        extrude("z", ngon((0, 15), 55, 24), 1290, 1400),
        extrude("y", ngon((780, 0), 65, 24), 140, 165),
    ]
    return {
        "bed": bed,
        "X": slide,
        "C": rotary_table((20, -15), 60, 140),
        "Y": bridge,
        "Z": ram,
        "B": spindle(600, 780, [(55, 73)]),
        "cutter": cutter(600, 140),
    }


# -- files -----------------------------------------------------------------------------------------


def write_stl(path: Path, shells: Iterable[Shell]) -> None:
    """Write a binary STL; the header names the machine and the link."""
    triangles = np.concatenate(list(shells))
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    records = np.zeros(len(triangles), dtype=RECORD)
    records["normal"] = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    records["vertices"] = triangles
    header = f"gcodesim {path.parent.name} {path.stem} mm".encode().ljust(80, b" ")
    path.write_bytes(header + np.uint32(len(triangles)).tobytes() + records.tobytes())


def main(folder: Path) -> None:
    """Write every mesh of every shipped machine below the folder."""
    for build in (table_tilt, head_tilt, nutating_head, table_head):
        (folder / build.__name__).mkdir(parents=True, exist_ok=True)
        for link, shells in build().items():
            write_stl(folder / build.__name__ / f"{link}.stl", shells)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
