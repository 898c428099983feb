"""The scene: the checked pairs of one stretch of program time, on the device."""

from __future__ import annotations

from dataclasses import dataclass, replace
from weakref import WeakKeyDictionary, ref

import numpy as np
import warp as wp
from numpy.typing import NDArray

from gcodesim.collision.bodies.regions import Regions, build_regions
from gcodesim.collision.geometry.poses import ChainArrays, chain_arrays
from gcodesim.machine.model import Body, Joint, Pair, Part

_regions: WeakKeyDictionary[Part, dict[tuple[ref[Part], ...], Regions]] = WeakKeyDictionary()
"""First part of a shape -> its other parts -> its regions, for the next tool or program: kept as
long as the parts are, with their machine, and no longer."""


@wp.struct
class SceneArrays:
    """Triangles and boxes of all bodies, and which of them each pair uses.

    Body a of a pair stands still in its own frame, body b moves; boxes are exact in the frame of
    their own body.
    """

    triangles: wp.array[wp.mat33d]
    region_first: wp.array[wp.int32]  # region -> its first triangle; one more entry than regions
    region_low: wp.array[wp.vec3d]
    region_high: wp.array[wp.vec3d]
    regions_a: wp.array[wp.vec2i]  # pair -> first and end region of body a
    regions_b: wp.array[wp.vec2i]
    box_a: wp.array2d[wp.vec3d]  # pair -> lowest and highest corner of body a
    box_b: wp.array2d[wp.vec3d]


@dataclass(frozen=True)
class CheckedShape:
    """The parts of a body that count for a pair, as one triangle list."""

    body: str
    parts: tuple[Part, ...]
    regions: Regions

    def find_triangle(self, number: int) -> tuple[Part, int]:
        """Part, and number within the part, of triangle `number` of the whole list."""
        for part in self.parts:
            if number < len(part.triangles):
                return part, number
            number -= len(part.triangles)
        raise IndexError(number)


@dataclass(frozen=True)
class Scene:
    """Pairs in tie order with their shapes.

    Attributes:
        pairs: as checked; index = position in the contact key.
        shapes: (a, b) of each pair.
        links: links of (a, b) of each pair.
        chains, arrays: the same on the device.
    """

    device: str
    pairs: tuple[Pair, ...]
    shapes: tuple[tuple[CheckedShape, CheckedShape], ...]
    links: tuple[tuple[str, str], ...]
    chains: ChainArrays
    arrays: SceneArrays


def is_present(pair: Pair, bodies: dict[str, Body]) -> bool:
    """Whether both bodies are there, with at least one of the parts that count."""
    return all(
        name in bodies and any(wanted is None or p.name in wanted for p in bodies[name].parts)
        for name, wanted in ((pair.a, pair.parts_a), (pair.b, pair.parts_b))
    )


def build_scene(
    pairs: tuple[Pair, ...],
    bodies: dict[str, Body],
    joints: tuple[Joint, ...],
    device: str,
) -> Scene:
    """Lay out the pairs whose bodies are all present and have triangles."""
    used: dict[tuple[str, tuple[Part, ...]], CheckedShape] = {}

    def shape(body: str, parts: tuple[str, ...] | None) -> CheckedShape:
        chosen = tuple(p for p in bodies[body].parts if parts is None or p.name in parts)
        return used.setdefault((body, chosen), _shape(body, chosen))

    shapes = tuple((shape(p.a, p.parts_a), shape(p.b, p.parts_b)) for p in pairs)
    links = tuple((bodies[p.a].link, bodies[p.b].link) for p in pairs)
    return Scene(
        device,
        pairs,
        shapes,
        links,
        chain_arrays(joints, list(links), device),
        _scene_arrays(shapes, device),
    )


def by_parts(scene: Scene, pair: int, joints: tuple[Joint, ...]) -> Scene:
    """A scene of each part of the one body of a pair with each part of the other, in full."""
    sides = [[_shape(shape.body, (part,)) for part in shape.parts] for shape in scene.shapes[pair]]
    shapes = tuple((a, b) for a in sides[0] for b in sides[1])
    links = (scene.links[pair],) * len(shapes)
    return Scene(
        scene.device,
        (scene.pairs[pair],) * len(shapes),
        shapes,
        links,
        chain_arrays(joints, list(links), scene.device),
        _scene_arrays(shapes, scene.device),
    )


def _shape(body: str, parts: tuple[Part, ...]) -> CheckedShape:
    kept, others = _regions.setdefault(parts[0], {}), tuple(map(ref, parts[1:]))
    if others not in kept:
        kept[others] = build_regions(np.concatenate([part.triangles for part in parts]))
    return CheckedShape(body, parts, kept[others])


def restricted(scene: Scene, keep: dict[int, NDArray[np.bool_]]) -> Scene:
    """The scene with only the regions kept of each shape; keys are ids of shapes."""
    smaller = {
        key: replace(shape, regions=shape.regions.only(keep[key]))
        for key, shape in {id(s): s for pair in scene.shapes for s in pair}.items()
    }
    shapes = tuple((smaller[id(a)], smaller[id(b)]) for a, b in scene.shapes)
    return replace(scene, shapes=shapes, arrays=_scene_arrays(shapes, scene.device))


def whole_scene(scene: Scene, pairs: list[int], joints: tuple[Joint, ...]) -> Scene:
    """Some pairs with all triangles of their bodies, whatever was left out of the scene."""
    shapes = tuple(
        (_shape(a.body, a.parts), _shape(b.body, b.parts))
        for a, b in (scene.shapes[pair] for pair in pairs)
    )
    links = tuple(scene.links[pair] for pair in pairs)
    return Scene(
        scene.device,
        tuple(scene.pairs[pair] for pair in pairs),
        shapes,
        links,
        chain_arrays(joints, list(links), scene.device),
        _scene_arrays(shapes, scene.device),
    )


def _scene_arrays(
    shapes: tuple[tuple[CheckedShape, CheckedShape], ...], device: str
) -> SceneArrays:
    """Concatenate the shapes, each once, and point every pair at its regions."""
    unique = list({id(s): s.regions for pair in shapes for s in pair}.items())
    triangle_at = np.cumsum([0, *(len(r.triangles) for _, r in unique)])
    region_at = np.cumsum([0, *(len(r.boxes) for _, r in unique)])
    place = {key: i for i, (key, _) in enumerate(unique)}

    def ranges(side: int) -> NDArray[np.int32]:
        bodies = [place[id(pair[side])] for pair in shapes]
        return np.stack([region_at[bodies], region_at[np.add(bodies, 1)]], axis=1).astype(np.int32)

    first = [r.first[:-1] + start for (_, r), start in zip(unique, triangle_at, strict=False)]
    boxes = np.concatenate([r.boxes for _, r in unique])
    arrays = SceneArrays()
    arrays.triangles = wp.array(
        np.concatenate([r.triangles for _, r in unique]), dtype=wp.mat33d, device=device
    )
    arrays.region_first = wp.array(
        np.concatenate([*first, triangle_at[-1:]]), dtype=wp.int32, device=device
    )
    arrays.region_low = wp.array(boxes[:, 0].copy(), dtype=wp.vec3d, device=device)
    arrays.region_high = wp.array(boxes[:, 1].copy(), dtype=wp.vec3d, device=device)
    arrays.regions_a = wp.array(ranges(0), dtype=wp.vec2i, device=device)
    arrays.regions_b = wp.array(ranges(1), dtype=wp.vec2i, device=device)
    arrays.box_a = wp.array(
        np.stack([a.regions.box for a, _ in shapes]), dtype=wp.vec3d, device=device
    )
    arrays.box_b = wp.array(
        np.stack([b.regions.box for _, b in shapes]), dtype=wp.vec3d, device=device
    )
    return arrays
