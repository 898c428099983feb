"""Random machines and paths; the scenes with a closed form are in gcodesim.study.scenes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray

from gcodesim.machine.model import Joint
from gcodesim.motion.path import ARC_PIECE, Path
from gcodesim.study.scenes import (
    ACCELERATED,
    CONSTANT,
    JERKED,
    Array,
    KnownScene,
    joint,
    machine,
    path,
    turned,
)

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
    return turned(triangles * size, unit(rng), rng.uniform(0, np.pi)) + np.asarray(center)


def unit(rng: np.random.Generator) -> Array:
    """A random direction."""
    v = rng.normal(size=3)
    return np.asarray(v / np.linalg.norm(v))


def random_scene(rng: np.random.Generator, pieces: int = 8) -> KnownScene:
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
    return KnownScene(machine(joints, shapes, pairs), p, None)
