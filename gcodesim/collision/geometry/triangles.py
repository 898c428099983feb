"""The public triangle test: arrays of triangle pairs in, certified contacts out."""

from __future__ import annotations

import numpy as np
import warp as wp
from numpy.typing import ArrayLike, NDArray

from gcodesim.collision.geometry.device import BIT_EQUAL, resolve_device
from gcodesim.collision.geometry.predicates import triangles_touch

wp.set_module_options(BIT_EQUAL)


@wp.kernel
def test_triangle_pairs(
    triangles_a: wp.array[wp.mat33d],
    triangles_b: wp.array[wp.mat33d],
    contact_out: wp.array[wp.int32],
):
    """One thread per pair of triangles."""
    i = wp.tid()
    if triangles_touch(triangles_a[i], triangles_b[i]):
        contact_out[i] = 1


def triangles_intersect(a: ArrayLike, b: ArrayLike, device: str = "cpu") -> NDArray[np.bool_]:
    """Tell which pairs of triangles intersect or touch.

    False is a proof of separation. True means contact, or a clearance below 26 u D (3e-11 mm for
    coordinates that differ by 10 m), or coordinates that cannot be judged: NaN, infinity, sums
    beyond 1e70.

    Args:
        a: triangles [mm], shape (n, 3, 3): triangle, vertex, coordinate.
        b: the triangles they are paired with, same shape.
        device: auto, cpu, cuda or cuda:N.

    Returns:
        Shape (n,).

    Raises:
        ValueError: the shapes are not (n, 3, 3) or differ.
        UsageError: the device is not present.
    """
    first = np.ascontiguousarray(a, dtype=np.float64)
    second = np.ascontiguousarray(b, dtype=np.float64)
    if first.shape != second.shape or first.shape[1:] != (3, 3):
        raise ValueError(
            f"expected two arrays of shape (n, 3, 3), got {first.shape} and {second.shape}"
        )
    target = resolve_device(device)
    contact = wp.zeros(len(first), dtype=wp.int32, device=target)
    wp.launch(
        test_triangle_pairs,
        dim=len(first),
        inputs=[
            wp.array(first, dtype=wp.mat33d, device=target),
            wp.array(second, dtype=wp.mat33d, device=target),
        ],
        outputs=[contact],
        device=target,
    )
    result: NDArray[np.bool_] = contact.numpy() != 0
    return result
