"""Containment: a body wholly inside another touches nothing, and is a contact all the same.

Where two surfaces do not meet, every shell of one body lies wholly inside or wholly outside the
other, so one vertex per shell decides. The vertex is inside where the winding number of the closed
mesh, the sum of signed solid angles over 4 pi, is not zero (van Oosterom and Strackee 1983). Far
from the surface it is within rounding of an integer; on the surface the triangles touch anyway.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gcodesim.collision.bodies.scene import Scene
from gcodesim.machine.model import Part
from gcodesim.machine.shapes import shell_corners


@dataclass(frozen=True)
class Containment:
    """One part inside another, or a question that an open mesh leaves undecided.

    Attributes:
        pair: index of the pair in the scene.
        parts, roles: names and roles of the parts, in the order of the pair.
        outer_is_a: the part that is, or may be, around the other is that of body a.
        decided: False when `outer` is open.
    """

    pair: int
    parts: tuple[str, str]
    roles: tuple[str, str]
    outer_is_a: bool
    decided: bool

    @property
    def outer(self) -> str:
        """The part around the other."""
        return self.parts[0 if self.outer_is_a else 1]

    @property
    def inner(self) -> str:
        """The part inside the other."""
        return self.parts[1 if self.outer_is_a else 0]


def find_containments(scene: Scene, relative: list[NDArray[np.float64]]) -> list[Containment]:
    """Containments of all pairs at one pose.

    Args:
        scene: the pairs.
        relative: per pair the pose of body b in the frame of body a, shape (4, 4).
    """
    found: list[Containment] = []
    for index, ((a, b), pose) in enumerate(zip(scene.shapes, relative, strict=True)):
        for p, q in itertools.product(a.parts, b.parts):
            names, roles = (p.name, q.name), (p.role, q.role)
            for inner, outer, move in ((q, p, pose), (p, q, np.linalg.inv(pose))):
                answer = contains(outer, inner, np.asarray(move, np.float64))
                if answer is not False:
                    found.append(Containment(index, names, roles, outer is p, answer is True))
    return found


def contains(outer: Part, inner: Part, pose: NDArray[np.float64]) -> bool | None:
    """Tell whether a shell of `inner`, moved by `pose`, lies inside `outer`; None = open mesh."""
    if outer.shell:
        return False
    low, high = outer.triangles.min(axis=(0, 1)), outer.triangles.max(axis=(0, 1))

    def in_box(points: NDArray[np.float64]) -> NDArray[np.float64]:
        posed = points @ pose[:3, :3].T + pose[:3, 3]
        return posed[np.all((posed > low) & (posed < high), axis=1)]

    if not len(in_box(inner.triangles.reshape(-1, 3))):
        return False  # Most pairs are apart: no need to separate their shells.
    near = in_box(shell_vertices(inner.triangles))
    if len(near) and not outer.closed:
        return None
    return any(abs(winding_number(point, outer.triangles)) > 0.5 for point in near)


def winding_number(point: NDArray[np.float64], triangles: NDArray[np.float64]) -> float:
    """Times the closed surface wraps around the point: 1 inside, 0 outside."""
    a, b, c = np.moveaxis(triangles - point, 1, 0)
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    numerator = np.sum(a * np.cross(b, c), axis=1)
    denominator = (
        la * lb * lc
        + np.sum(a * b, axis=1) * lc
        + np.sum(b * c, axis=1) * la
        + np.sum(c * a, axis=1) * lb
    )
    return float(np.sum(np.arctan2(numerator, denominator)) / (2.0 * np.pi))


def shell_vertices(triangles: NDArray[np.float64]) -> NDArray[np.float64]:
    """One vertex of every connected shell, shape (shells, 3)."""
    points, _, label = shell_corners(triangles)
    return np.asarray(points[np.unique(label)])
