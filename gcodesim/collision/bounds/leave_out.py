"""Leaving out: what a program cannot need, each with the margin that proves it.

A pair is left out when the boxes of its regions, swept through everything the program moves, stay
farther apart than the pair must be proved apart. An axis that the program never moves, and a body
that no remaining pair needs, cost nothing either; they are named so that the report says so.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from gcodesim.collision.bodies.reach import Boxes, sweep
from gcodesim.collision.bodies.regions import Regions
from gcodesim.collision.bodies.scene import Scene, restricted
from gcodesim.collision.geometry.poses import joints_between
from gcodesim.constants import SLACK_MM
from gcodesim.findings.left_out import LeftOut
from gcodesim.machine.model import Joint

MOST_BOXES = 128
"""Boxes of a body that are compared with those of another; more are joined, neighbours first."""


def swept_partners(scene: Scene, joints: tuple[Joint, ...]) -> list[Boxes]:
    """Per pair the region boxes of body b in the frame of body a, swept through all travel."""
    return [
        sweep(b.regions.boxes, joints, joints_between(joints, *links))
        for (_, b), links in zip(scene.shapes, scene.links, strict=True)
    ]


def pairs_out_of_reach(
    scene: Scene,
    joints: tuple[Joint, ...],
    swept: Sequence[Boxes],
    needed: Sequence[float],
    samples: int,
) -> dict[int, LeftOut]:
    """Pairs of the scene that never come within `needed` of each other [mm].

    Args:
        scene: the pairs.
        joints: with the travel of the program as their limits.
        swept: see swept_partners.
        needed: per pair, the distance that must be proved [mm].
        samples: sample indices of the program, for the count of saved tests.
    """
    found = {}
    for index, (pair, links) in enumerate(zip(scene.pairs, scene.links, strict=True)):
        distance = _reach_distance(scene.shapes[index][0].regions, swept[index])
        bound = needed[index] + SLACK_MM
        if distance > bound:
            chain = joints_between(joints, *links)
            why = "reach envelopes never meet" if chain else "no joint between them"
            found[index] = LeftOut(pair.name, why, bound, distance - bound, samples)
    return found


def without_far_triangles(
    scene: Scene,
    joints: tuple[Joint, ...],
    swept: Sequence[Boxes],
    needed: Sequence[float],
    apart: Collection[int],
) -> tuple[Scene, list[LeftOut]]:
    """The scene without the regions that never come near any partner of their body.

    Args:
        scene: the pairs.
        joints: with the travel of the program as their limits.
        swept: see swept_partners.
        needed: per pair, the distance that must be proved [mm].
        apart: pairs that are left out as a whole: their regions are not needed for them.
    """
    nearest: dict[int, NDArray[np.float64]] = {}
    shapes = {id(s): s for pair in scene.shapes for s in pair}
    for index, ((a, b), links) in enumerate(zip(scene.shapes, scene.links, strict=True)):
        if index in apart:
            continue
        back = sweep(a.regions.boxes, joints, joints_between(joints, links[1], links[0]))
        for own, partner, boxes in ((a, b, back), (b, a, swept[index])):
            # Counted from the distance that must be proved, so that pairs can be compared.
            spare = _distances(partner.regions.box[None], boxes).min(axis=0)
            spare = spare - needed[index] - SLACK_MM
            nearest[id(own)] = np.minimum(nearest.get(id(own), spare), spare)
    # One region stays of each body, so that none is empty: its pairs are left out as pairs.
    keep = {key: np.arange(len(s.regions.boxes)) == 0 for key, s in shapes.items()}
    items = []
    for key, spare in nearest.items():
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
    swept = sweep(b.regions.boxes, joints, joints_between(joints, *links))
    return _reach_distance(a.regions, swept)


def _reach_distance(regions: Regions, swept: Boxes) -> float:
    """A distance [mm] that the swept boxes of a body keep from the regions of its partner."""
    return float(_distances(_joined(regions.boxes), _joined(swept)).min())


def _joined(boxes: Boxes) -> Boxes:
    """Boxes around runs of the given ones, which stand in an order that keeps neighbours close."""
    starts = np.arange(0, len(boxes), -(-len(boxes) // MOST_BOXES))
    low, high = np.minimum.reduceat(boxes[:, 0], starts), np.maximum.reduceat(boxes[:, 1], starts)
    return np.stack([low, high], axis=1)


def _distances(boxes_a: NDArray[np.float64], boxes_b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distances of all boxes a from all boxes b, shape (a, b) [mm]."""
    apart = np.maximum(
        boxes_a[:, None, 0] - boxes_b[None, :, 1], boxes_b[None, :, 0] - boxes_a[:, None, 1]
    )
    return np.asarray(np.linalg.norm(np.maximum(apart, 0.0), axis=2))
