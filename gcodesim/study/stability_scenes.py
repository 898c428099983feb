"""Random small scenes, changed in ways that must not change the first contact."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gcodesim.collision.bodies.regions import snapped
from gcodesim.collision.detector import Task, detect
from gcodesim.collision.search.span_search import Aims
from gcodesim.constants import DEFAULT_PERIOD_PS
from gcodesim.machine.kinematics import rotation
from gcodesim.machine.model import Body, Joint, Machine, Pair, Part
from gcodesim.machine.shapes import box, cylinder
from gcodesim.motion.path import Path
from gcodesim.study.stability_case import Case
from gcodesim.study.stability_motion import SEED, free_machine, path_of

Array = NDArray[np.float64]
SceneAnswer = tuple[int, str, bool] | None
"""Sample and pair of the first contact and whether it is between samples; None: free."""

FAR_MM = 1e5
"""Where a triangle is in no one's way."""

HEAD_MM, LOW_MM = 200.0, -90.0
"""How high the shapes of the head begin, and to what height about they go [mm]."""


@dataclass(frozen=True)
class RandomScene:
    """A machine with a few random shapes, a path, and the sample period [ps]."""

    machine: Machine
    path: Path
    period_ps: int = DEFAULT_PERIOD_PS

    def answer(self) -> SceneAnswer:
        """The first contact by the search, between samples too."""
        aims = Aims()
        task = Task(
            self.path, self.machine, self.period_ps, "cpu", "search", aims, lambda done: None
        )
        contact = detect(task).contact
        return (contact.sample, contact.pair.name, contact.between) if contact else None

    def reshaped(self, change: Callable[[Array], Array]) -> RandomScene:
        """The same with the triangles of every part changed."""
        bodies = {
            name: replace(
                body, parts=tuple(replace(p, triangles=change(p.triangles)) for p in body.parts)
            )
            for name, body in self.machine.bodies.items()
        }
        return replace(self, machine=replace(self.machine, bodies=bodies))

    def moved(self, turn: Array, shift: Array) -> RandomScene:
        """The whole machine turned or mirrored by an orthogonal matrix (3, 3), then shifted."""
        hand = round(float(np.linalg.det(turn)))
        joints = tuple(
            # An axis of rotation is a pseudovector: a mirror turns it round.
            replace(
                j,
                axis=turn @ j.axis * (hand if j.rotary else 1),
                point=turn @ j.point + shift,
            )
            for j in self.machine.joints
        )
        changed = self.reshaped(lambda t: (t @ turn.T + shift)[:, ::hand])
        return replace(changed, machine=replace(changed.machine, joints=joints))


def random_scene(seed: int) -> RandomScene:
    """Shapes on saddle, cradle and table, and on the head; lines and circles of five axes."""
    rng = np.random.default_rng([SEED, 100, seed])
    bodies = {}
    for link in ("X", "A", "C", "Z"):
        high = np.array([0.0, 0.0, HEAD_MM if link == "Z" else 0.0])
        parts = tuple(Part(name, _shape(rng) + high) for name in ("first", "second"))
        bodies[link] = Body(link, link, parts)
    pairs = (Pair("A", "Z"), Pair("C", "Z"), Pair("X", "Z"))
    machine = replace(free_machine(), bodies=bodies, pairs=pairs, tool=None)
    lines = ["G10 L2 P1 X0 Y0 Z0"]
    for _ in range(5):
        x, y, z = rng.uniform(-60, 60, 3) + [0.0, 0.0, LOW_MM]
        a, c = rng.uniform([-60, -180], [0, 180])
        lines.append(f"G1 X{x:.3f} Y{y:.3f} Z{z:.3f} A{a:.3f} C{c:.3f} F9000.")
        lines.append(f"G2 I{rng.uniform(5, 20):.3f} J{rng.uniform(-9, 9):.3f}")
    return RandomScene(machine, path_of("\n".join(lines), machine)[0])


def _shape(rng: np.random.Generator) -> Array:
    """A box or a cylinder, turned and placed at random; corners on a grid that can be halved."""
    size = rng.uniform(10, 30, 3)
    made = box(size) if rng.random() < 0.7 else cylinder(size[0] / 2, size[1], [0, 0, 0], [0, 0, 1])
    axis = rng.normal(size=3)
    turn = rotation(axis / np.linalg.norm(axis), rng.uniform(0, 180))
    placed = made @ turn.T + rng.uniform(-50, 50, 3)
    return np.asarray(2.0 * snapped(placed / 2.0))


# --- what must not matter -------------------------------------------------------------------------


def other_order(scene: RandomScene) -> RandomScene:
    """The triangles of every part in another order."""
    rng = np.random.default_rng(SEED)
    return scene.reshaped(rng.permutation)


def other_pairs(scene: RandomScene) -> RandomScene:
    """The pairs in reverse order, and each the other way round."""
    pairs = tuple(replace(p, a=p.b, b=p.a) for p in reversed(scene.machine.pairs))
    return replace(scene, machine=replace(scene.machine, pairs=pairs))


def mirrored(scene: RandomScene) -> RandomScene:
    """All of it as in a mirror across X."""
    return scene.moved(np.diag([-1.0, 1.0, 1.0]), np.zeros(3))


def shifted(scene: RandomScene) -> RandomScene:
    """All of it a metre away, by a vector of whole millimetres."""
    return scene.moved(np.eye(3), np.array([1024.0, -512.0, 333.0]))


def turned(scene: RandomScene) -> RandomScene:
    """All of it with X, Y and Z exchanged in turn."""
    return scene.moved(np.eye(3)[[1, 2, 0]], np.zeros(3))


def refined(scene: RandomScene) -> RandomScene:
    """Every triangle cut into four at the middles of its edges."""

    def quartered(t: Array) -> Array:
        middle = (t + np.roll(t, -1, axis=1)) / 2.0
        corners = [np.stack([t[:, i], middle[:, i], middle[:, i - 1]], axis=1) for i in range(3)]
        return np.concatenate([*corners, middle])

    return scene.reshaped(quartered)


def with_far_triangle(scene: RandomScene) -> RandomScene:
    """Every part with one more triangle, a hundred metres away."""
    far = np.array([[[0.0, 0, 0], [9, 0, 0], [0, 9, 0]]]) + [0.0, 0.0, FAR_MM]
    lifts = iter(range(1, 100))
    return scene.reshaped(lambda t: np.concatenate([t, far + [0.0, 0.0, 999.0 * next(lifts)]]))


def with_unused_axis(scene: RandomScene) -> RandomScene:
    """A rotary axis under the whole table side that stands still."""
    unit, point = np.array([0.0, 1.0, 0.0]), np.array([7.0, 8.0, 9.0])
    extra = Joint("B", True, "bed", "tilting base", unit, point, -90.0, 90.0, 100.0)
    joints = (
        extra,
        *(replace(j, parent="tilting base") if j.name == "Y" else j for j in scene.machine.joints),
    )
    links = ("bed", "tilting base", *scene.machine.links[1:])
    machine, path = replace(scene.machine, joints=joints, links=links), scene.path
    q0, q1 = (np.insert(q, 0, 0.0, axis=1) for q in (path.q0, path.q1))
    x, y, z = (column + 1 for column in path.xyz)
    names = ("B", *path.joints)
    return replace(
        scene, machine=machine, path=replace(path, q0=q0, q1=q1, joints=names, xyz=(x, y, z))
    )


def reversed_program(scene: RandomScene) -> RandomScene:
    """The same way backwards at the same speeds."""
    path, arcs = scene.path, scene.path.arcs.copy()
    angle = np.radians(arcs["sweep"])[:, None]
    u, v = np.cos(angle), np.sin(angle)
    arcs["u"] = u * path.arcs["u"] + v * path.arcs["v"]
    arcs["v"] = u * path.arcs["v"] - v * path.arcs["u"]
    arcs["r0"], arcs["r1"] = path.arcs["r1"], path.arcs["r0"]
    arcs["lift"], arcs["sweep"] = -path.arcs["lift"], -path.arcs["sweep"]
    bounds = path.duration_ps - path.bounds_ps[::-1]
    backwards = replace(
        path,
        q0=path.q1[::-1].copy(),
        q1=path.q0[::-1].copy(),
        arc=path.arc[::-1].copy(),
        arcs=arcs,
        line=path.line[::-1].copy(),
        bounds_ps=bounds,
    )
    return replace(scene, path=backwards)


def half_period(scene: RandomScene) -> RandomScene:
    """Twice as many samples."""
    return replace(scene, period_ps=scene.period_ps // 2)


# --- the same answer ------------------------------------------------------------------------------


def same(before: SceneAnswer, after: SceneAnswer) -> bool:
    """Sample, pair and kind."""
    return before == after


def same_sample(before: SceneAnswer, after: SceneAnswer) -> bool:
    """Of a sample with several contacts, another pair may come first."""
    return (before and (before[0], before[2])) == (after and (after[0], after[2]))


def same_freedom(before: SceneAnswer, after: SceneAnswer) -> bool:
    """Free stays free, and a contact is one backwards too."""
    return (before is None) == (after is None)


def same_time(before: SceneAnswer, after: SceneAnswer) -> bool:
    """The sample of the same instant: twice as far, or the one before."""
    if before is None or after is None:
        return before is after
    return after[0] in (2 * before[0], 2 * before[0] - 1)


Change = Callable[[RandomScene], RandomScene]
CHANGES: dict[str, tuple[Change, Callable[[SceneAnswer, SceneAnswer], bool]]] = {
    "triangles permuted": (other_order, same),
    "pairs permuted": (other_pairs, same_sample),
    "mirrored": (mirrored, same),
    "a metre away": (shifted, same),
    "axes exchanged": (turned, same),
    "triangles quartered": (refined, same),
    "far triangle added": (with_far_triangle, same),
    "unused axis added": (with_unused_axis, same),
    "program reversed": (reversed_program, same_freedom),
    "half the period": (half_period, same_time),
}


def invariances(quick: bool) -> Iterator[Case]:
    """Random scenes, about half of them with a contact, changed in every way."""
    scenes = [random_scene(seed) for seed in range(10 if quick else 100)]
    answers = [scene.answer() for scene in scenes]
    hits = sum(answer is not None for answer in answers)
    for name, (change, agrees) in CHANGES.items():
        pairs = zip(scenes, answers, strict=True)
        changed = sum(not agrees(answer, change(scene).answer()) for scene, answer in pairs)
        yield Case(
            "same", f"{len(scenes)} random scenes, {hits} collide", f"other answer: {name}",
            "", None, float(changed), 0.0, "scenes",
        )  # fmt: skip


SCENES = (invariances,)
