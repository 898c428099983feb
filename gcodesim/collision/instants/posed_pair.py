"""The triangles of a pair at one instant: which touch, and which are nearest.

Only triangles near the other body are compared, found with a bounding-volume hierarchy whose float
boxes are rounded outwards; what decides is the exact test of the search and of every method.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from gcodesim.collision.bodies.keys import NO_CONTACT, pack_triangles, triangle_numbers
from gcodesim.collision.bodies.scene import Scene
from gcodesim.collision.geometry.boxes import posed_triangle, triangle_box
from gcodesim.collision.geometry.closest import between_triangles
from gcodesim.collision.geometry.device import BIT_EQUAL
from gcodesim.collision.geometry.poses import ChainArrays, PathArrays, pair_pose
from gcodesim.collision.geometry.predicates import triangles_touch

wp.set_module_options(BIT_EQUAL)

Floats = NDArray[np.float64]

FARTHEST = wp.constant(wp.float64(1.0e30))


@wp.struct
class Side:
    """Triangles of one body in the frame of body a, their numbers, and boxes around them."""

    triangles: wp.array[wp.mat33d]
    number: wp.array[wp.int32]
    low: wp.array[wp.vec3]
    high: wp.array[wp.vec3]


@wp.kernel
def pose_triangles(
    path: PathArrays,
    chains: ChainArrays,
    place: wp.vec2i,  # pair, piece
    time_ps: wp.int64,
    triangles: wp.array[wp.mat33d],
    posed_out: wp.array[wp.mat33d],
):
    """One thread per triangle of b."""
    i = wp.tid()
    pose = pair_pose(path, chains, place[0], place[1], time_ps)
    posed_out[i] = posed_triangle(pose, triangles[i])


@wp.kernel
def find_touching(a: Side, b: Side, tree: wp.uint64, lowest_out: wp.array[wp.int64]):
    """One thread per triangle of a: lowest (number in a, number in b) that touches."""
    i = wp.tid()
    query = wp.bvh_query_aabb(tree, a.low[i], a.high[i])
    j = wp.int32(0)
    while wp.bvh_query_next(query, j):
        key = pack_triangles(a.number[i], b.number[j])
        if key < lowest_out[0] and triangles_touch(a.triangles[i], b.triangles[j]):
            wp.atomic_min(lowest_out, 0, key)


@wp.kernel
def find_nearest(
    a: Side,
    b: Side,
    tree: wp.uint64,
    distance_out: wp.array[wp.float64],
    row_out: wp.array[wp.int32],
):
    """One thread per triangle of a: distance to the nearest triangle of b, and its row."""
    i = wp.tid()
    own = triangle_box(a.triangles[i])
    best = FARTHEST
    chosen = wp.int32(-1)
    query = wp.bvh_query_aabb(tree, a.low[i], a.high[i])
    j = wp.int32(0)
    while wp.bvh_query_next(query, j):
        other = triangle_box(b.triangles[j])
        apart = wp.max(wp.max(other.low - own.high, own.low - other.high), wp.vec3d())
        if wp.length(apart) > best:
            continue
        distance = wp.length(between_triangles(a.triangles[i], b.triangles[j]))
        if triangles_touch(a.triangles[i], b.triangles[j]):
            distance = wp.float64(0.0)
        # The order of the hits is not defined: of equals the lowest row counts.
        if distance < best or (distance == best and j < chosen):
            best = distance
            chosen = j
    distance_out[i] = best
    row_out[i] = chosen


@dataclass(frozen=True)
class PosedPair:
    """Both bodies of a pair at one instant.

    Attributes:
        a, b: triangles in the frame of body a's link, shape (n, 3, 3) [mm].
        number_a, number_b: their numbers in the whole shapes, shape (n,).
    """

    a: Floats
    b: Floats
    number_a: NDArray[np.int32]
    number_b: NDArray[np.int32]
    device: str

    def triangles(self, i: int, j: int) -> tuple[Floats, Floats]:
        """The triangles of two rows."""
        return self.a[i], self.b[j]

    def numbers(self, i: int, j: int) -> tuple[int, int]:
        """The numbers of two rows in the whole shapes."""
        return int(self.number_a[i]), int(self.number_b[j])

    def touching(self) -> tuple[int, int] | None:
        """Rows of the touching triangles with the lowest (number in a, number in b)."""
        near = self._near(0.0)
        if near is None:
            return None
        a, b, tree = near
        lowest = wp.full(1, NO_CONTACT, dtype=wp.int64, device=self.device)
        wp.launch(
            find_touching,
            dim=a.triangles.shape[0],
            inputs=[a, b, tree.id],
            outputs=[lowest],
            device=self.device,
        )
        key = int(lowest.numpy()[0])
        if key == NO_CONTACT:
            return None
        a_number, b_number = triangle_numbers(key)
        row_a = np.flatnonzero(self.number_a == a_number)
        row_b = np.flatnonzero(self.number_b == b_number)
        return int(row_a[0]), int(row_b[0])

    def nearest(self, within: float) -> tuple[float, int, int]:
        """Smallest distance [mm] and its rows, where it is known to be at most `within` [mm].

        Raises:
            ValueError: it is larger.
        """
        near = self._near(within)
        if near is None:
            raise ValueError(f"the pair is farther apart than {within} mm")
        a, b, tree = near
        count = a.triangles.shape[0]
        distance = wp.empty(count, dtype=wp.float64, device=self.device)
        row = wp.empty(count, dtype=wp.int32, device=self.device)
        wp.launch(
            find_nearest,
            dim=count,
            inputs=[a, b, tree.id],
            outputs=[distance, row],
            device=self.device,
        )
        distances = distance.numpy()
        i = int(np.argmin(distances))
        numbers = int(a.number.numpy()[i]), int(b.number.numpy()[row.numpy()[i]])
        rows = (
            int(np.flatnonzero(own == number)[0])
            for own, number in zip((self.number_a, self.number_b), numbers, strict=True)
        )
        return float(distances[i]), *rows

    def _near(self, within: float) -> tuple[Side, Side, Any] | None:
        """Triangles within reach of the other body's, those of b in a hierarchy; None = none."""
        boxes = [(t.min(axis=1), t.max(axis=1)) for t in (self.a, self.b)]
        kept = [np.arange(len(t)) for t in (self.a, self.b)]
        for side in (0, 1, 0):
            if not len(kept[0]) or not len(kept[1]):
                return None
            low = boxes[1 - side][0][kept[1 - side]].min(axis=0) - within
            high = boxes[1 - side][1][kept[1 - side]].max(axis=0) + within
            of_side = boxes[side][0][kept[side]], boxes[side][1][kept[side]]
            inside = (of_side[0] <= high).all(axis=1) & (of_side[1] >= low).all(axis=1)
            kept[side] = kept[side][inside]
        if not len(kept[0]) or not len(kept[1]):
            return None
        a = self._side(self.a[kept[0]], self.number_a[kept[0]], within)
        b = self._side(self.b[kept[1]], self.number_b[kept[1]], 0.0)
        return a, b, wp.Bvh(b.low, b.high)

    def _side(self, triangles: Floats, number: NDArray[np.int32], grown: float) -> Side:
        side = Side()
        low = _outwards(triangles.min(axis=1) - grown, -np.inf)
        high = _outwards(triangles.max(axis=1) + grown, np.inf)
        side.triangles = wp.array(triangles, dtype=wp.mat33d, device=self.device)
        side.number = wp.array(number, dtype=wp.int32, device=self.device)
        side.low = wp.array(low, dtype=wp.vec3, device=self.device)
        side.high = wp.array(high, dtype=wp.vec3, device=self.device)
        return side


def pose_pair(scene: Scene, path: PathArrays, pair: int, piece: int, time_ps: int) -> PosedPair:
    """Pose a pair at a time within a piece."""
    a, b = (shape.regions for shape in scene.shapes[pair])
    posed = wp.empty(len(b.triangles), dtype=wp.mat33d, device=scene.device)
    triangles = wp.array(b.triangles, dtype=wp.mat33d, device=scene.device)
    wp.launch(
        pose_triangles,
        dim=len(b.triangles),
        inputs=[path, scene.chains, wp.vec2i(pair, piece), time_ps, triangles],
        outputs=[posed],
        device=scene.device,
    )
    orders = (shape.order.astype(np.int32) for shape in (a, b))
    return PosedPair(a.triangles, posed.numpy(), *orders, scene.device)


def _outwards(values: Floats, towards: float) -> NDArray[np.float32]:
    """The next float beyond each value, in single precision."""
    return np.nextafter(values.astype(np.float32), np.float32(towards))
