"""Rays: what an eye at infinity sees of a set of triangles, on the CPU or on CUDA."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import warp as wp
from numpy.typing import NDArray

# Starts Warp quietly, before the first array.
from gcodesim.collision.geometry.device import BIT_EQUAL

wp.set_module_options(BIT_EQUAL)

Floats = NDArray[np.float64]

NOTHING = -1
"""Number of the triangle where a ray meets none."""


@wp.kernel
def cast_rays(
    mesh: wp.uint64,
    corner: wp.vec3,
    across: wp.vec3,
    down: wp.vec3,
    direction: wp.vec3,
    reach: float,
    distance_out: wp.array2d[float],
    triangle_out: wp.array2d[wp.int32],
):
    """One thread per ray: the first triangle it meets, and how far away."""
    row, column = wp.tid()
    origin = corner + float(column) * across + float(row) * down
    hit = wp.mesh_query_ray(mesh, origin, direction, reach)
    distance_out[row, column] = reach
    triangle_out[row, column] = wp.int32(NOTHING)
    if hit.result:
        distance_out[row, column] = hit.t
        triangle_out[row, column] = hit.face


@dataclass(frozen=True)
class Grid:
    """Parallel rays from a square grid of origins, lengths in mm.

    Attributes:
        corner: origin of the first ray.
        across, down: from a ray to the next in its row, and to the next row.
        direction: unit vector.
        reach: length of the rays.
        size: rays in a row, and rows.
    """

    corner: Floats
    across: Floats
    down: Floats
    direction: Floats
    reach: float
    size: int


@dataclass(frozen=True)
class Hits:
    """What rays met.

    Attributes:
        distance: from the origin, the reach of the rays where nothing was met, (size, size) [mm].
        triangle: NOTHING where nothing was met, (size, size).
    """

    distance: NDArray[np.float32]
    triangle: NDArray[np.int32]


class Target:
    """Triangles to be looked at, shape (n, 3, 3) [mm]; either side is seen."""

    def __init__(self, triangles: Floats, device: str) -> None:
        self.device = device
        self.mesh = None
        if len(triangles):
            corners = wp.array(triangles.reshape(-1, 3), dtype=wp.vec3, device=device)
            numbers = wp.array(np.arange(3 * len(triangles)), dtype=wp.int32, device=device)
            self.mesh = wp.Mesh(corners, numbers)

    def first_hits(self, rays: Grid) -> Hits:
        """The first triangle on every ray, in the precision of a picture (float32)."""
        shape = (rays.size, rays.size)
        if self.mesh is None:
            return Hits(np.full(shape, rays.reach, np.float32), np.full(shape, NOTHING, np.int32))
        distance = wp.zeros(shape, dtype=float, device=self.device)
        triangle = wp.zeros(shape, dtype=wp.int32, device=self.device)
        vectors = (rays.corner, rays.across, rays.down, rays.direction)
        wp.launch(
            cast_rays,
            dim=shape,
            inputs=[self.mesh.id, *(wp.vec3(*v) for v in vectors), rays.reach],
            outputs=[distance, triangle],
            device=self.device,
        )
        return Hits(distance.numpy(), triangle.numpy())
