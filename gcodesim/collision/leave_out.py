"""Leaving out: what a program cannot need, each with the margin that proves it.

A pair is left out when the boxes of its regions, swept through everything the program moves, stay
farther apart than the pair must be proved apart. An axis that the program never moves, and a body
that no remaining pair needs, cost nothing either; they are named so that the report says so.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gcodesim.collision.poses import joints_between
from gcodesim.collision.reach import sweep
from gcodesim.collision.scene import Scene, restricted
from gcodesim.constants import SLACK_MM
from gcodesim.machine.model import Joint

LARGEST_TABLE = 4_000_000
"""Region pairs compared one by one at most; larger bodies are compared as a whole."""


@dataclass(frozen=True)
class LeftOut:
    """One thing that was not looked at, and why that is sound.

    Attributes:
        what: pair, axis or body.
        why: one short sentence.
        bound_mm: distance that had to be proved [mm].
        margin_mm: distance proved beyond it [mm]; 0 where no distance is involved.
        saved_tests: tests at samples that were not needed.
        triangles: triangles of a body that were left out, it and its pairs staying.
    """

    what: str
    why: str
    bound_mm: float = 0.0
    margin_mm: float = 0.0
    saved_tests: int = 0
    triangles: int = 0


def pairs_out_of_reach(
    scene: Scene, joints: tuple[Joint, ...], needed: Sequence[float], samples: int
) -> dict[int, LeftOut]:
    """Pairs of the scene that never come within `needed` of each other [mm].

    Args:
        scene: the pairs.
        joints: with the travel of the program as their limits.
        needed: per pair, the distance that must be proved [mm].
        samples: sample indices of the program, for the count of saved tests.
    """
    found = {}
    for index, (pair, links) in enumerate(zip(scene.pairs, scene.links, strict=True)):
        distance = reach_distance(scene, joints, index)
        bound = needed[index] + SLACK_MM
        if distance > bound:
            chain = joints_between(joints, *links)
            why = "reach envelopes never meet" if chain else "no joint between them"
            found[index] = LeftOut(pair.name, why, bound, distance - bound, samples)
    return found


def without_far_triangles(
    scene: Scene, joints: tuple[Joint, ...], needed: Sequence[float]
) -> tuple[Scene, list[LeftOut]]:
    """The scene without the regions that never come near any partner of their body.

    Args:
        scene: the pairs.
        joints: with the travel of the program as their limits.
        needed: per pair, the distance that must be proved [mm].
    """
    nearest: dict[int, NDArray[np.float64]] = {}
    shapes = {id(s): s for pair in scene.shapes for s in pair}
    for index, (pair, links) in enumerate(zip(scene.shapes, scene.links, strict=True)):
        for own, other in ((0, 1), (1, 0)):
            boxes = pair[own].regions.boxes
            chain = joints_between(joints, links[other], links[own])
            partner = pair[other].regions.box[None]
            # Counted from the distance that must be proved, so that pairs can be compared.
            spare = _distances(partner, sweep(boxes, joints, chain)).min(axis=0)
            spare = spare - needed[index] - SLACK_MM
            key = id(pair[own])
            nearest[key] = np.minimum(nearest.get(key, spare), spare)
    keep, items = {}, []
    for key, spare in nearest.items():
        # One region stays, so that no body is empty: its pairs are left out as pairs.
        keep[key] = (spare <= 0.0) | (np.arange(len(spare)) == np.argmin(spare))
        counts = np.diff(shapes[key].regions.first)
        dropped = int(counts[~keep[key]].sum())
        if dropped:
            why = f"{dropped} of {counts.sum()} never come near another body"
            margin = float(spare[~keep[key]].min())
            name = f"triangles of {shapes[key].body}"
            items.append(LeftOut(name, why, max(needed), margin, triangles=dropped))
    return restricted(scene, keep), items


def still_axes(joints: tuple[Joint, ...]) -> list[LeftOut]:
    """Axes that the program never moves; `joints` have the travel of the program as limits."""
    return [
        LeftOut(f"axis {joint.name}", f"stands at {joint.lower:g} all the time")
        for joint in joints
        if joint.lower == joint.upper
    ]


def reach_distance(scene: Scene, joints: tuple[Joint, ...], pair: int) -> float:
    """A distance [mm] that a pair never falls below, whatever the joints do in their travel."""
    (a, b), links = scene.shapes[pair], scene.links[pair]
    boxes_a, boxes_b = a.regions.boxes, b.regions.boxes
    if len(boxes_a) * len(boxes_b) > LARGEST_TABLE:
        boxes_a, boxes_b = a.regions.box[None], b.regions.box[None]
    swept = sweep(boxes_b, joints, joints_between(joints, *links))
    return float(_distances(boxes_a, swept).min())


def _distances(boxes_a: NDArray[np.float64], boxes_b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distances of all boxes a from all boxes b, shape (a, b) [mm]."""
    apart = np.maximum(
        boxes_a[:, None, 0] - boxes_b[None, :, 1], boxes_b[None, :, 0] - boxes_a[:, None, 1]
    )
    return np.asarray(np.linalg.norm(np.maximum(apart, 0.0), axis=2))
