"""Small machines and paths: scenes whose first contact has a closed form, and random ones.

Scene ids, parameters and instants of contact are those of the numerics study; every scene derives
its instant from the vertices as they are stored, and carries the published one beside it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import acos, asin, atan2, hypot, pi, sqrt

import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray

from gcodesim.collision.regions import snapped
from gcodesim.machine.kinematics import rotation
from gcodesim.machine.model import Body, Joint, Machine, Pair, Part
from gcodesim.motion.path import ARC_PIECE, Path

Array = NDArray[np.float64]
CONSTANT, ACCELERATED, JERKED = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
FEED = 10000.0 / 60.0  # mm/s


@dataclass(frozen=True)
class Scene:
    """One moving body that first touches another at `contact_s` [s]; None = it never does.

    `leaves_s` ends that contact; `published_s` is the instant given by the numerics study.
    """

    machine: Machine
    path: Path
    contact_s: float | None
    leaves_s: float = np.inf
    published_s: float | None = None


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
    shapes: dict[str, Array | dict[str, Array]],
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
        dialect="fanuc",
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


def delayed(scene: Scene, phase_ps: int) -> Scene:
    """The same scene after standing still for `phase_ps`: shifts the contact between samples."""
    if not phase_ps:
        return scene
    p, phase_s = scene.path, phase_ps / 1e12
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
    contact = None if scene.contact_s is None else scene.contact_s + phase_s
    return Scene(scene.machine, late, contact, scene.leaves_s + phase_s)


# --- shapes -------------------------------------------------------------------------------------


def box(size: ArrayLike, center: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
    """Triangles of a box, (12, 3, 3), its vertices on the grid of the detector."""
    return snapped(np.array(trimesh.creation.box(size).triangles) + np.asarray(center))


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


def vertex_meets_face() -> Scene:
    """S1: a tilted box comes down on a slab."""
    mover = turned(box([40, 30, 20]), [0, 0, 1], 0.2)
    mover = turned(turned(mover, [0, 1, 0], 0.4), [1, 0, 0], 0.7)
    still = box([300, 300, 20], [0, 0, -10])
    m, p = _straight("Z", [0, 0, 1], still, np.add(mover, [0, 0, 60]), 0.3, -0.3 * FEED)
    contact = (60 + mover[..., 2].min()) / FEED
    return Scene(m, p, contact, published_s=0.235912218371)


def edge_meets_edge() -> Scene:
    """S2: a bar rolled onto its edge comes down on another one across."""
    mover = turned(box([200, 30, 30]), [1, 0, 0], pi / 4)
    still = turned(box([30, 200, 30]), [0, 1, 0], pi / 4)
    m, p = _straight("Z", [0, 0, 1], still, snapped(np.add(mover, [3.3, 1.7, 150])), 0.3, -150)
    contact = (150 + mover[..., 2].min() - still[..., 2].max()) / 500
    return Scene(m, p, contact, published_s=0.215147186258)


def corner_turns_into_wall() -> Scene:
    """S3: a turning box reaches a low wall with a vertical edge."""
    still = box([50, 400, 10], [133, 0, 0])
    m, p = _straight("C", [0, 0, -1], still, box([200, 120, 40]), 0.2, 12)
    contact = np.degrees(atan2(60, 100) - acos(108 / hypot(100, 60))) / 60
    return Scene(m, p, contact, published_s=0.146623511833)


def table_turns_into_tool() -> Scene:
    """S4: a block on a turning table sweeps into a tool prism."""
    tool = polygon(32, 8, [120, 0], pi / 32)
    block = rectangle([30, 30], [112, -75])
    m, p = _straight("C", [0, 0, 1], prism(tool, -30, 60), prism(block, -20, 20), 0.4, 36)
    contact = np.degrees(turn_to_contact(block, tool)) / 90
    return Scene(m, p, contact, published_s=0.285368191297)


def trunnion_tilts_into_spindle() -> Scene:
    """S5: a block on a tilting cradle reaches the spindle face above."""
    block = box([120, 90, 60], [10, 35, -40])
    still = box([400, 400, 20], [0, 0, 70])
    m, p = _straight("A", [1, 0, 0], still, block, 2.0, 60)
    corners = np.unique(block.reshape(-1, 3), axis=0)
    tilts = [
        (asin(60 / hypot(y, z)) - atan2(z, y)) % (2 * pi) for _, y, z in corners if hypot(y, z) > 60
    ]
    return Scene(m, p, np.degrees(min(tilts)) / 30, published_s=1.840538948903)


def arc_grazes_face(depth: float = 1e-4) -> Scene:
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
        return Scene(m, p, None)
    half_time = 2 * asin(sqrt(depth / (2 * radius))) / rate
    published = 0.199151471792 if depth == 1e-4 else None
    return Scene(m, p, middle - half_time, middle + half_time, published)


def blade_through_sheet() -> Scene:
    """S7: a 0.01 mm blade passes a 0.01 mm sheet within 20 microseconds."""
    start, width = -137.2468, 0.01
    still, mover = box([width, 30, 30]), box([width, 20, 20])
    joints = [joint("X", [1, 0, 0])]
    m = machine(joints, {"bed": still, "mover": mover}, BED_MOVER)
    p = path(joints, [start], [(0.2, [start + 200])])
    width = float(np.ptp(still[..., 0]))
    return Scene(m, p, (-start - width) / 1000, (-start + width) / 1000, published_s=0.1372368)


def accelerated_start() -> Scene:
    """S8: 5000 mm/s^2 from rest over a gap of 7.3 mm."""
    return _from_rest(ACCELERATED, 0.1, 5000 * 0.1**2 / 2, sqrt(2 * 7.3 / 5000), 0.054037024344)


def jerked_start() -> Scene:
    """S8 with a constant jerk of 100,000 mm/s^3."""
    return _from_rest(JERKED, 0.1, 1e5 * 0.1**3 / 6, (6 * 7.3 / 1e5) ** (1 / 3), None)


def _from_rest(
    law: tuple[float, float, float],
    seconds: float,
    way: float,
    contact: float,
    published: float | None,
) -> Scene:
    joints = [joint("X", [1, 0, 0])]
    shapes = {"bed": box([20, 40, 40], [17.3, 0, 0]), "mover": box([10, 10, 10], [-5, 0, 0])}
    # The wall's face lies where the grid puts 7.3: off by less than 1e-10 mm.
    m = machine(joints, shapes, BED_MOVER)
    return Scene(m, path(joints, [0.0], [(seconds, [way])], law), contact, published_s=published)


def cube_on_slab(lift: float) -> Scene:
    """S10: a cube stands on a slab, or `lift` above it, in dyadic coordinates, and slides away."""
    joints = [joint("X", [1, 0, 0])]
    shapes = {"bed": box([64, 64, 16], [0, 0, -8]), "mover": box([8, 8, 8], [0, 0, 4 + lift])}
    p = path(joints, [0.0], [(0.004, [8.0])])
    return Scene(machine(joints, shapes, BED_MOVER), p, None if lift else 0.0)


def helix_meets_plane() -> Scene:
    """S11: a small cube sinks along a helix of pitch 5 and radius 20 onto a slab."""
    joints = [joint("X", [1, 0, 0]), joint("Y", [0, 1, 0], "mover", "m2")]
    joints.append(joint("Z", [0, 0, 1], "m2", "cube"))
    turns, pitch, height, seconds = 4, 5.0, 13.712345, 0.5
    lift = np.array([0, 0, -turns * pitch])
    u, v = np.array([1.0, 0, 0]), np.array([0, 1.0, 0])
    arc = np.array((u, v, lift, 20.0, 20.0, 360.0 * turns), ARC_PIECE)
    shapes = {"bed": box([200, 200, 20], [0, 0, -10]), "cube": box([4, 4, 4], [0, 0, 2])}
    p = path(joints, [20, 0, height], [(seconds, [20, 0, height + lift[2]])], arcs={0: arc})
    return Scene(machine(joints, shapes, [("bed", "cube")]), p, height / (turns * pitch) * seconds)


FLIP_START_S, FLIP_S = 123e-4, 1e-4


def flip_within_a_sample() -> Scene:
    """S12: the table turns 180 degrees between two samples, its block passing a pin."""
    pin, block = polygon(16, 4, [-20, 185], 0.1), rectangle([60, 30], [150, 40])
    joints = [joint("C", [0, 0, 1])]
    shapes = {"bed": prism(pin, -30, 30), "mover": prism(block, -10, 10)}
    pieces = [(FLIP_START_S, [0.0]), (FLIP_S, [180.0]), (1e-3, [180.0])]
    theta = turn_to_contact(block, pin)
    return Scene(
        machine(joints, shapes, BED_MOVER),
        path(joints, [0.0], pieces),
        FLIP_START_S + theta / pi * FLIP_S,
    )


def turn_to_contact(moving: Array, fixed: Array) -> float:
    """Least angle [rad] by which a polygon turns about the origin until it touches another.

    A corner at (rho, phi) lies on an edge line with normal angle psi and offset h from the origin
    after turning by psi +- acos(h/rho) - phi, if its foot is inside the edge; corners of the fixed
    polygon meet edges of the moving one at the opposite angles.
    """
    angles = [*_corner_on_edge(moving, fixed, 1.0), *_corner_on_edge(fixed, moving, -1.0)]
    return min(angles)


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


SAMPLED: dict[str, Callable[[], Scene]] = {
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


# --- random machines and paths --------------------------------------------------------------------

LAWS = (CONSTANT, ACCELERATED, JERKED, (2.0, -1.0, 0.0), (0.0, 3.0, -2.0), (0.5, 0.7, -0.2))


def random_joints(rng: np.random.Generator, count: int = 6, reach: float = 500.0) -> list[Joint]:
    """A random tree of linear and rotary joints with oblique axes that need not meet."""
    links, joints = ["bed"], []
    for name in rng.permutation(list("XYZABC"))[:count]:
        parent = links[rng.integers(len(links))]
        links.append(f"link {name}")
        point = rng.uniform(-reach, reach, 3)
        joints.append(joint(str(name), rng.normal(size=3), parent, links[-1], point))
    return joints


def random_path(
    rng: np.random.Generator,
    joints: Sequence[Joint],
    count: int,
    linear: float = 100.0,
    rotary: float = 180.0,
    seconds: float = 0.01,
) -> Path:
    """Lines, dwells and, given X, Y and Z, arcs, helices and spirals, with random time laws."""
    step = np.array([rotary if j.rotary else linear for j in joints])
    names = [j.name for j in joints]
    q, pieces, arcs = rng.uniform(-step, step), [], {}
    start = q
    for i in range(count):
        end = q + rng.uniform(-step, step) / 4
        kind = rng.integers(0, 4)
        if kind == 0:
            end = q
        elif kind == 1 and {"X", "Y", "Z"} <= set(names):
            arcs[i] = random_arc(rng, linear)
            end = end.copy()
            end[[names.index(a) for a in "XYZ"]] = q[
                [names.index(a) for a in "XYZ"]
            ] + displacement(arcs[i])
        pieces.append((rng.uniform(0.1, 1.0) * seconds, end))
        q = end
    made = path(joints, start, pieces, arcs=arcs)
    made.law[:] = rng.permutation(np.resize(LAWS, (count, 3)))
    return made


def random_arc(rng: np.random.Generator, radius: float) -> NDArray[np.void]:
    """An arc in one of the three planes or an oblique one; helix, spiral and turns included."""
    frames = [np.roll(np.eye(3), k, axis=1) for k in range(3)]
    frames.append(np.linalg.qr(rng.normal(size=(3, 3)))[0])
    u, v, normal = frames[rng.integers(4)]
    normal = normal * np.sign(np.cross(u, v) @ normal)
    r0 = rng.uniform(0.1, 1.0) * radius
    r1 = r0 * rng.choice([1.0, 1.05, 0.9])
    sweep = rng.choice([-1, 1]) * rng.choice([rng.uniform(5, 350), 360, 360 * 3 + 77])
    lift = normal * rng.choice([0.0, rng.uniform(-radius, radius)])
    return np.array((u, v, lift, r0, r1, sweep), ARC_PIECE)


def displacement(arc: NDArray[np.void]) -> Array:
    """Displacement from start to end of an arc, by its definition."""
    angle = np.radians(float(arc["sweep"]))
    arm = float(arc["r1"]) * (np.cos(angle) * arc["u"] + np.sin(angle) * arc["v"])
    return np.asarray(arm - arc["r0"] * arc["u"] + arc["lift"])


def random_mesh(rng: np.random.Generator, size: float, center: ArrayLike) -> Array:
    """A ball, a box or a torus, turned at random, its triangles in random order."""
    made = [
        lambda: trimesh.creation.icosphere(1, radius=1.0),
        lambda: trimesh.creation.box([1.5, 1.0, 0.7]),
        lambda: trimesh.creation.torus(1.0, 0.3, major_sections=10, minor_sections=5),
    ][rng.integers(3)]()
    triangles = rng.permutation(np.array(made.triangles))
    return turned(triangles * size, unit(rng), rng.uniform(0, pi)) + np.asarray(center)


def unit(rng: np.random.Generator) -> Array:
    """A random direction."""
    v = rng.normal(size=3)
    return np.asarray(v / np.linalg.norm(v))


def random_scene(rng: np.random.Generator, pieces: int = 8) -> Scene:
    """Three or four bodies on a random tree; about half of the scenes collide."""
    joints = random_joints(rng, int(rng.integers(3, 7)), reach=60.0)
    links = ["bed", *(j.child for j in joints)]
    chosen = sorted(str(link) for link in rng.choice(links, min(4, len(links)), replace=False))
    shapes: dict[str, Array | dict[str, Array]] = {}
    for k, link in enumerate(chosen):
        meshes = [random_mesh(rng, rng.uniform(8, 20), rng.uniform(-70, 70, 3)) for _ in "ab"]
        shapes[link] = {"first": meshes[0], "second": meshes[1]} if k == 0 else meshes[0]
    pairs = [(a, b) for i, a in enumerate(chosen) for b in chosen[i + 1 :]]
    p = random_path(rng, joints, pieces, linear=200, rotary=240)
    return Scene(machine(joints, shapes, pairs), p, None)
