"""Scenes of two bodies whose first contact has a closed form: the truth of study and tests.

Scene ids, parameters and instants of contact are those of the numerics study; every scene derives
its instant from the vertices as they are stored, and carries the published one beside it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import acos, asin, atan2, hypot, pi, sqrt

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gcodesim.collision.bodies.regions import snapped
from gcodesim.constants import PS_PER_S
from gcodesim.machine import shapes
from gcodesim.machine.kinematics import rotation, transform, world_from_link
from gcodesim.machine.model import Body, Joint, Machine, Pair, Part
from gcodesim.motion.path import ARC_PIECE, Path
from gcodesim.nc.control.readings import ROWS
from gcodesim.study.exact import squared_clearance

Array = NDArray[np.float64]
CONSTANT, ACCELERATED, JERKED = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
FEED = 10000.0 / 60.0  # mm/s


@dataclass(frozen=True)
class KnownScene:
    """One moving body that first touches another at `contact_s` [s]; None = it never does.

    Attributes:
        leaves_s: end of that contact; infinite when the path ends in it.
        deepest_mm: how deep it gets, where it ends; the end of a path is always looked at.
        clearance_mm: smallest distance, where the two never touch.
        published_s: the instant given by the numerics study.
    """

    machine: Machine
    path: Path
    contact_s: float | None
    leaves_s: float = np.inf
    deepest_mm: float = np.nan
    clearance_mm: float = 0.0
    published_s: float | None = None

    @property
    def pair(self) -> tuple[str, str]:
        """Names of the two bodies."""
        return self.machine.pairs[0].a, self.machine.pairs[0].b

    def clearance_at(self, time_ps: int) -> float:
        """Distance of the two bodies as they stand at one instant, exact but for the pose [mm]."""
        return exact_clearance(self.machine, self.path, time_ps, self.pair)


def exact_clearance(machine: Machine, path: Path, time_ps: int, pair: tuple[str, str]) -> float:
    """Distance of two bodies at one instant [mm], by integers from the posed vertices on."""
    world = world_from_link(machine, path.positions(np.array([time_ps]))[0])
    a, b = (
        transform(
            world[machine.bodies[body].link],
            np.concatenate([part.triangles for part in machine.bodies[body].parts]),
        )
        for body in pair
    )
    gaps = np.maximum(a.min(1)[:, None] - b.max(1)[None], b.min(1)[None] - a.max(1)[:, None])
    least = np.linalg.norm(np.maximum(gaps, 0.0), axis=2)
    best = np.inf
    for flat in np.argsort(least, axis=None):
        i, j = np.unravel_index(flat, least.shape)
        if least[i, j] > best or best == 0.0:
            break
        best = min(best, sqrt(squared_clearance(a[i], b[j])))
    return best


# --- machines and paths -------------------------------------------------------------------------


def joint(
    name: str,
    axis: ArrayLike,
    parent: str = "bed",
    child: str = "mover",
    point: ArrayLike = (0.0, 0.0, 0.0),
    travel: tuple[float, float] = (-1000.0, 1000.0),
    rapid: float = 500.0,
) -> Joint:
    """A joint; A, B and C are rotary. The axis need not be of unit length."""
    unit = np.asarray(axis, np.float64) / np.linalg.norm(axis)
    rotary = name in "ABC"
    return Joint(name, rotary, parent, child, unit, np.asarray(point, np.float64), *travel, rapid)


def machine(
    joints: Sequence[Joint],
    shapes: Mapping[str, Array | dict[str, Array]],
    pairs: Sequence[tuple[str, str]],
    open_parts: Sequence[str] = (),
) -> Machine:
    """A machine whose links carry the given triangles, whole or part by part."""
    bodies = {}
    for link, shape in shapes.items():
        parts = shape if isinstance(shape, dict) else {link: shape}
        bodies[link] = Body(
            link, link, tuple(Part(n, t, closed=n not in open_parts) for n, t in parts.items())
        )
    return Machine(
        name="test",
        path="test.yaml",
        verified=False,
        links=("bed", *(j.child for j in joints)),
        joints=tuple(joints),
        bodies=bodies,
        pairs=tuple(Pair(a, b) for a, b in pairs),
        tool=None,
        tools=None,
        work_link=None,
        offsets={},
        reference={},
        start={},
        readings=ROWS["fanuc"],
    )


def path(
    joints: Sequence[Joint],
    start: ArrayLike,
    pieces: Sequence[tuple[float, ArrayLike]],
    law: tuple[float, float, float] = CONSTANT,
    arcs: dict[int, NDArray[np.void]] | None = None,
) -> Path:
    """A path of (seconds, end position) pieces; `arcs` replaces pieces by number."""
    names = tuple(j.name for j in joints)
    q = np.array([start, *(end for _, end in pieces)], np.float64).reshape(-1, len(names))
    ticks = np.rint(np.array([s for s, _ in pieces]) * 1e12).astype(np.int64)
    rows = np.full(len(pieces), -1, np.int32)
    rows[list(arcs or {})] = np.arange(len(arcs or {}))
    return Path(
        joints=names,
        bounds_ps=np.concatenate([[0], np.cumsum(ticks)]),
        q0=q[:-1],
        q1=q[1:],
        law=np.tile(law, (len(pieces), 1)),
        arc=rows,
        arcs=np.array(list((arcs or {}).values()), ARC_PIECE).reshape(-1),
        xyz=tuple(names.index(a) if a in names else -1 for a in "XYZ"),  # type: ignore[arg-type]
        line=np.arange(1, len(pieces) + 1, dtype=np.int32),
    )


def delayed(scene: KnownScene, phase_ps: int) -> KnownScene:
    """The same scene after standing still for `phase_ps`: shifts the contact between samples."""
    if not phase_ps:
        return scene
    p, phase_s = scene.path, phase_ps / PS_PER_S
    late = Path(
        joints=p.joints,
        bounds_ps=np.concatenate([[0], p.bounds_ps + phase_ps]),
        q0=np.vstack([p.q0[:1], p.q0]),
        q1=np.vstack([p.q0[:1], p.q1]),
        law=np.vstack([p.law[:1], p.law]),
        arc=np.concatenate([np.full(1, -1, np.int32), p.arc]),
        arcs=p.arcs,
        xyz=p.xyz,
        line=np.concatenate([p.line[:1], p.line]),
    )
    # None stays None, and what touches at the start touches while it stands, too.
    contact = scene.contact_s + phase_s if scene.contact_s else scene.contact_s
    return replace(scene, path=late, contact_s=contact, leaves_s=scene.leaves_s + phase_s)


# --- shapes -------------------------------------------------------------------------------------


def box(size: ArrayLike, center: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
    """Triangles of a box, (12, 3, 3), its vertices on the grid of the detector."""
    return snapped(shapes.box(size, center))


def prism(polygon: Array, low: float, high: float) -> Array:
    """Triangles of a prism over a convex polygon (n, 2), counter-clockwise."""
    n = len(polygon)
    bottom, top = (np.column_stack([polygon, np.full(n, z)]) for z in (low, high))
    after = np.roll(np.arange(n), -1)
    sides = [[bottom[i], bottom[j], top[j]] for i, j in enumerate(after)]
    sides += [[bottom[i], top[j], top[i]] for i, j in enumerate(after)]
    caps = [[bottom[0], bottom[i + 1], bottom[i]] for i in range(1, n - 1)]
    caps += [[top[0], top[i], top[i + 1]] for i in range(1, n - 1)]
    return snapped(np.array(sides + caps))


def turned(triangles: Array, axis: ArrayLike, radians: float) -> Array:
    """Triangles turned about an axis through the origin, on the grid of the detector."""
    return snapped(triangles @ rotation(axis, np.degrees(radians)).T)


def polygon(n: int, radius: float, center: ArrayLike, phase: float) -> Array:
    """Corners of a regular polygon, (n, 2), on the grid of the detector."""
    angle = phase + 2 * pi * np.arange(n) / n
    return snapped(np.column_stack([np.cos(angle), np.sin(angle)]) * radius + np.asarray(center))


def rectangle(size: ArrayLike, center: ArrayLike) -> Array:
    """Corners of a rectangle, (4, 2), counter-clockwise."""
    return np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * np.asarray(size) / 2 + center


# --- scenes with a closed form --------------------------------------------------------------------

BED_MOVER = [("bed", "mover")]


def _straight(
    name: str, axis: ArrayLike, still: Array, mover: Array, seconds: float, end: float
) -> tuple[Machine, Path]:
    """A machine with one joint, which moves from 0 to `end` at constant speed."""
    joints = [joint(name, axis)]
    return machine(joints, {"bed": still, "mover": mover}, BED_MOVER), path(
        joints, [0.0], [(seconds, [end])]
    )


def vertex_meets_face() -> KnownScene:
    """S1: a tilted box comes down on a slab."""
    mover = turned(box([40, 30, 20]), [0, 0, 1], 0.2)
    mover = turned(turned(mover, [0, 1, 0], 0.4), [1, 0, 0], 0.7)
    still = box([300, 300, 20], [0, 0, -10])
    m, p = _straight("Z", [0, 0, 1], still, np.add(mover, [0, 0, 60]), 0.3, -0.3 * FEED)
    contact = (60 + mover[..., 2].min()) / FEED
    return KnownScene(m, p, contact, published_s=0.235912218371)


def edge_meets_edge() -> KnownScene:
    """S2: a bar rolled onto its edge comes down on another one across."""
    mover = turned(box([200, 30, 30]), [1, 0, 0], pi / 4)
    still = turned(box([30, 200, 30]), [0, 1, 0], pi / 4)
    m, p = _straight("Z", [0, 0, 1], still, snapped(np.add(mover, [3.3, 1.7, 150])), 0.3, -150)
    contact = (150 + mover[..., 2].min() - still[..., 2].max()) / 500
    return KnownScene(m, p, contact, published_s=0.215147186258)


def corner_turns_into_wall() -> KnownScene:
    """S3: a turning box reaches a low wall with a vertical edge."""
    still = box([50, 400, 10], [133, 0, 0])
    m, p = _straight("C", [0, 0, -1], still, box([200, 120, 40]), 0.2, 12)
    contact = np.degrees(atan2(60, 100) - acos(108 / hypot(100, 60))) / 60
    return KnownScene(m, p, contact, published_s=0.146623511833)


def table_turns_into_tool() -> KnownScene:
    """S4: a block on a turning table sweeps into a tool prism."""
    tool = polygon(32, 8, [120, 0], pi / 32)
    block = rectangle([30, 30], [112, -75])
    m, p = _straight("C", [0, 0, 1], prism(tool, -30, 60), prism(block, -20, 20), 0.4, 36)
    contact = np.degrees(turn_to_contact(block, tool)) / 90
    return KnownScene(m, p, contact, published_s=0.285368191297)


def trunnion_tilts_into_spindle() -> KnownScene:
    """S5: a block on a tilting cradle reaches the spindle face above."""
    block = box([120, 90, 60], [10, 35, -40])
    still = box([400, 400, 20], [0, 0, 70])
    m, p = _straight("A", [1, 0, 0], still, block, 2.0, 60)
    corners = np.unique(block.reshape(-1, 3), axis=0)
    tilts = [
        (asin(60 / hypot(y, z)) - atan2(z, y)) % (2 * pi) for _, y, z in corners if hypot(y, z) > 60
    ]
    return KnownScene(m, p, np.degrees(min(tilts)) / 30, published_s=1.840538948903)


def arc_grazes_face(depth: float = 1e-4) -> KnownScene:
    """S6: a cube on an arc of radius 100 dips `depth` below a face; lifted for negative depths."""
    radius, middle, rate = 100.0, 0.2, FEED / 100.0
    joints = [joint("X", [1, 0, 0]), joint("Z", [0, 0, 1], "mover", "cube")]
    angle = rate * middle
    u = np.array([-np.sin(angle), 0, -np.cos(angle)])
    v = np.array([np.cos(angle), 0, -np.sin(angle)])
    arc = np.array((u, v, np.zeros(3), radius, radius, np.degrees(2 * angle)), ARC_PIECE)
    top = radius * (1 - np.cos(angle)) - depth
    half = radius * np.sin(angle)
    shapes = {"bed": box([400, 400, 20], [0, 0, -10]), "cube": box([10, 10, 10], [0, 0, 5])}
    p = path(joints, [-half, top], [(2 * middle, [half, top])], arcs={0: arc})
    m = machine(joints, shapes, [("bed", "cube")])
    if depth < 0:
        return KnownScene(m, p, None, clearance_mm=-depth)
    half_time = 2 * asin(sqrt(depth / (2 * radius))) / rate
    published = {1e-4: 0.199151471792, 1e-7: 0.199973167184}.get(depth)
    return KnownScene(m, p, middle - half_time, middle + half_time, depth, published_s=published)


def blade_through_sheet() -> KnownScene:
    """S7: a 0.01 mm blade passes a 0.01 mm sheet within 20 microseconds."""
    start, width = -137.2468, 0.01
    still, mover = box([width, 30, 30]), box([width, 20, 20])
    joints = [joint("X", [1, 0, 0])]
    m = machine(joints, {"bed": still, "mover": mover}, BED_MOVER)
    p = path(joints, [start], [(0.2, [start + 200])])
    width = float(np.ptp(still[..., 0]))
    first, last = (-start - width) / 1000, (-start + width) / 1000
    return KnownScene(m, p, first, last, width, published_s=0.1372368)


def accelerated_start() -> KnownScene:
    """S8: 5000 mm/s^2 from rest over a gap of 7.3 mm."""
    return _from_rest(ACCELERATED, 0.1, 5000 * 0.1**2 / 2, sqrt(2 * 7.3 / 5000), 0.054037024344)


def jerked_start() -> KnownScene:
    """S8 with a constant jerk of 100,000 mm/s^3."""
    return _from_rest(JERKED, 0.1, 1e5 * 0.1**3 / 6, (6 * 7.3 / 1e5) ** (1 / 3), None)


def _from_rest(
    law: tuple[float, float, float],
    seconds: float,
    way: float,
    contact: float,
    published: float | None,
) -> KnownScene:
    joints = [joint("X", [1, 0, 0])]
    shapes = {"bed": box([20, 40, 40], [17.3, 0, 0]), "mover": box([10, 10, 10], [-5, 0, 0])}
    # The wall's face lies where the grid puts 7.3: off by less than 1e-10 mm.
    m = machine(joints, shapes, BED_MOVER)
    return KnownScene(
        m, path(joints, [0.0], [(seconds, [way])], law), contact, published_s=published
    )


def cube_on_slab(lift: float) -> KnownScene:
    """S10: a cube stands on a slab, or `lift` above it, in dyadic coordinates, and slides away."""
    joints = [joint("X", [1, 0, 0])]
    shapes = {"bed": box([64, 64, 16], [0, 0, -8]), "mover": box([8, 8, 8], [0, 0, 4 + lift])}
    p = path(joints, [0.0], [(0.004, [8.0])])
    contact = None if lift else 0.0
    return KnownScene(machine(joints, shapes, BED_MOVER), p, contact, clearance_mm=lift)


def helix_meets_plane() -> KnownScene:
    """S11: a small cube sinks along a helix of pitch 5 and radius 20 onto a slab."""
    joints = [joint("X", [1, 0, 0]), joint("Y", [0, 1, 0], "mover", "m2")]
    joints.append(joint("Z", [0, 0, 1], "m2", "cube"))
    turns, pitch, height, seconds = 4, 5.0, 13.712345, 0.5
    lift = np.array([0, 0, -turns * pitch])
    u, v = np.array([1.0, 0, 0]), np.array([0, 1.0, 0])
    arc = np.array((u, v, lift, 20.0, 20.0, 360.0 * turns), ARC_PIECE)
    shapes = {"bed": box([200, 200, 20], [0, 0, -10]), "cube": box([4, 4, 4], [0, 0, 2])}
    p = path(joints, [20, 0, height], [(seconds, [20, 0, height + lift[2]])], arcs={0: arc})
    return KnownScene(
        machine(joints, shapes, [("bed", "cube")]), p, height / (turns * pitch) * seconds
    )


FLIP_START_S, FLIP_S = 123e-4, 1e-4


def flip_within_a_sample() -> KnownScene:
    """S12: the table turns 180 degrees between two samples, its block passing a pin."""
    pin, block = polygon(16, 4, [-20, 185], 0.1), rectangle([60, 30], [150, 40])
    joints = [joint("C", [0, 0, 1])]
    shapes = {"bed": prism(pin, -30, 30), "mover": prism(block, -10, 10)}
    pieces = [(FLIP_START_S, [0.0]), (FLIP_S, [180.0]), (1e-3, [180.0])]
    first, last = turn_to_contact(block, pin), max(_touching_turns(block, pin))
    turns = np.linspace(first, last, 201)
    return KnownScene(
        machine(joints, shapes, BED_MOVER),
        path(joints, [0.0], pieces),
        FLIP_START_S + first / pi * FLIP_S,
        FLIP_START_S + last / pi * FLIP_S,
        max(_depth(_turned_polygon(block, turn), pin) for turn in turns),
    )


def turn_to_contact(moving: Array, fixed: Array) -> float:
    """Least angle [rad] by which a polygon turns about the origin until it touches another.

    A corner at (rho, phi) lies on an edge line with normal angle psi and offset h from the origin
    after turning by psi +- acos(h/rho) - phi, if its foot is inside the edge; corners of the fixed
    polygon meet edges of the moving one at the opposite angles.
    """
    return min(_touching_turns(moving, fixed))


def _touching_turns(moving: Array, fixed: Array) -> list[float]:
    return [*_corner_on_edge(moving, fixed, 1.0), *_corner_on_edge(fixed, moving, -1.0)]


def _turned_polygon(corners: Array, turn: float) -> Array:
    return corners @ rotation([0.0, 0.0, 1.0], np.degrees(turn))[:2, :2].T


def _depth(a: Array, b: Array) -> float:
    """Least way that takes two overlapping convex polygons apart, along the normals of edges."""
    edges = np.concatenate([np.roll(p, -1, axis=0) - p for p in (a, b)])
    normals = edges[:, ::-1] * [1, -1] / np.linalg.norm(edges, axis=1)[:, None]
    of_a, of_b = normals @ a.T, normals @ b.T
    overlaps = np.minimum(of_a.max(1) - of_b.min(1), of_b.max(1) - of_a.min(1))
    return float(overlaps.min())


def _corner_on_edge(corners: Array, outline: Array, sense: float) -> list[float]:
    found = []
    for start, end in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        along = (end - start) / np.linalg.norm(end - start)
        normal = np.array([along[1], -along[0]])
        offset, psi = float(normal @ start), atan2(normal[1], normal[0])
        for x, y in corners:
            rho, phi = hypot(x, y), atan2(y, x)
            if abs(offset) > rho:
                continue
            for side in (1.0, -1.0):
                at = psi + side * acos(offset / rho)
                foot = rho * (np.cos(at) * along[0] + np.sin(at) * along[1])
                if along @ start <= foot <= along @ end:
                    found.append(sense * (at - phi) % (2 * pi))
    return found


SAMPLED: dict[str, Callable[[], KnownScene]] = {
    "S1": vertex_meets_face,
    "S2": edge_meets_edge,
    "S3": corner_turns_into_wall,
    "S4": table_turns_into_tool,
    "S5": trunnion_tilts_into_spindle,
    "S6": arc_grazes_face,
    "S8": accelerated_start,
    "S8 jerk": jerked_start,
    "S11": helix_meets_plane,
}
"""Scenes that no sample period up to 1 ms can step over."""

SCENES: dict[str, Callable[[], KnownScene]] = {
    **SAMPLED,
    "S6 1e-7": partial(arc_grazes_face, 1e-7),
    "S7": blade_through_sheet,
    "S9 1e-3": partial(arc_grazes_face, -1e-3),
    "S9 1e-6": partial(arc_grazes_face, -1e-6),
    "S9 1e-9": partial(arc_grazes_face, -1e-9),
    "S10": partial(cube_on_slab, 0.0),
    "S10 lifted": partial(cube_on_slab, 2.0**-20),
    "S12": flip_within_a_sample,
}
"""All scenes; a number after the name is the depth or the clearance [mm]."""
