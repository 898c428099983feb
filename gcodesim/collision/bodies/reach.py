"""Reach: which triangles of two bodies can ever meet within the travels of the machine.

Each triangle's box is swept through the joints between the bodies, over their whole travel. The
sweep is conservative: a rotary joint is cut into short arcs, the box is turned by the middle angle
and widened by the chord a point can move from there, 2 r sin(half arc / 2).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gcodesim.collision.geometry.poses import joints_between
from gcodesim.constants import BOX_SLACK_MM
from gcodesim.machine.kinematics import rotation
from gcodesim.machine.model import Joint

ARC_DEG = 5.0
"""Arc [deg] into which a rotary travel is cut; smaller is tighter and slower."""

Boxes = NDArray[np.float64]
"""Lowest and highest corners [mm], shape (n, 2, 3)."""


def reachable(
    joints: tuple[Joint, ...],
    links: tuple[str, str],
    triangles_a: NDArray[np.float64],
    triangles_b: NDArray[np.float64],
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Tell which triangles of a and of b can come into the other body's box within the travels.

    The travels of linear joints must be finite.
    """
    boxes_a, boxes_b = triangle_boxes(triangles_a), triangle_boxes(triangles_b)
    swept_b = sweep(boxes_b, joints, joints_between(joints, *links))
    swept_a = sweep(boxes_a, joints, joints_between(joints, links[1], links[0]))
    return _meets(swept_a, boxes_b), _meets(swept_b, boxes_a)


def triangle_boxes(triangles: NDArray[np.float64]) -> Boxes:
    """Exact boxes of triangles of shape (n, 3, 3)."""
    return np.stack([triangles.min(axis=1), triangles.max(axis=1)], axis=1)


def sweep(boxes: Boxes, joints: tuple[Joint, ...], chain: list[tuple[int, int]]) -> Boxes:
    """Boxes that hold the given ones wherever the joints of the chain stand within their travel."""
    swept = boxes
    for column, sign in reversed(chain):
        joint = joints[column]
        ends = np.sort(sign * np.array([joint.lower, joint.upper]))
        swept = _turned(swept, joint, ends) if joint.rotary else _shifted(swept, joint, ends)
    return swept


def _shifted(boxes: Boxes, joint: Joint, ends: NDArray[np.float64]) -> Boxes:
    moves = np.where(joint.axis != 0.0, ends[:, None] * np.where(joint.axis, joint.axis, 1.0), 0.0)
    return boxes + np.stack([moves.min(axis=0), moves.max(axis=0)])


def _turned(boxes: Boxes, joint: Joint, ends: NDArray[np.float64]) -> Boxes:
    low, high = (ends[0], ends[1]) if ends[1] - ends[0] < 360.0 else (0.0, 360.0)
    count = int(np.ceil((high - low) / ARC_DEG)) or 1
    half_arc = np.radians((high - low) / count / 2.0)
    centre = boxes.mean(axis=1) - joint.point
    half = (boxes[:, 1] - boxes[:, 0]) / 2.0
    radius = np.linalg.norm(np.cross(joint.axis, centre), axis=1) + np.linalg.norm(half, axis=1)
    widened = (2.0 * radius * np.sin(min(half_arc, np.pi) / 2.0) + BOX_SLACK_MM)[:, None]
    angles = low + (np.arange(count) + 0.5) * (high - low) / count
    turns = rotation(joint.axis, angles).transpose(0, 2, 1)
    middle, extent = centre @ turns + joint.point, half @ np.abs(turns) + widened
    return np.stack([(middle - extent).min(axis=0), (middle + extent).max(axis=0)], axis=1)


def _meets(swept: Boxes, others: Boxes) -> NDArray[np.bool_]:
    low, high = others[:, 0].min(axis=0), others[:, 1].max(axis=0)
    near = (swept[:, 0] <= high + BOX_SLACK_MM) & (swept[:, 1] >= low - BOX_SLACK_MM)
    return np.asarray(near.all(axis=1))
