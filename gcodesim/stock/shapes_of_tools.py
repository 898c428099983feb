"""What a tool looks like to the race: frusta and balls about its axis, flutes first, tip first.

Every part is given twice: to prove, flutes lie within the real ones and all else around them; to
witness, the other way round.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import SAME_HEIGHT_MM, TOUCHING_MM
from gcodesim.machine.flutes import round_profile
from gcodesim.machine.kinematics import rotation_from_z
from gcodesim.machine.model import Body, Machine, Part, ToolMount
from gcodesim.machine.shapes import shells
from gcodesim.machine.turned import stretches, turned_hull

Array = NDArray[np.float64]
Cone = tuple[float, float, float, float]

FRUSTUM, BALL = 0, 1
COVERED, FREE, CONVEX = 0.0, 1.0, 2.0

LEAST_BEND = 1.0e-6
"""Slopes that differ by less make no seam; it is then off by less than rounding."""


@dataclass(frozen=True)
class Frusta:
    """A part by frusta (z0, z1, r0, r1) inside it and around it, and a ball at its tip (z, r)."""

    inner: tuple[Cone, ...]
    outer: tuple[Cone, ...]
    ball: tuple[float, float] | None = None


@dataclass(frozen=True)
class Solid:
    """A frustum or a ball: see race.Primitive.

    Attributes:
        kind: FRUSTUM | BALL.
        part: number of its part of the tool.
        shape: z0, z1, r0, r1 from the gauge point up; of a ball its centre twice, its radius twice.
        seams: COVERED | FREE | CONVEX, of the faces below and above: a wider neighbour or a concave
            seam covers it, none does, or the profile goes on and is convex there.
        beside: slope of the neighbours there.
        limit: how far the profile may be made smaller before one of its stretches is gone [mm].
    """

    kind: int
    part: int
    shape: Cone
    seams: tuple[float, float] = (1.0, 1.0)
    beside: tuple[float, float] = (0.0, 0.0)
    limit: float = 0.0

    @property
    def middle(self) -> float:
        """Height of its centre [mm]."""
        return (self.shape[0] + self.shape[1]) / 2.0

    @property
    def lever(self) -> float:
        """Largest distance of its points from its centre; none of a ball moves as it turns [mm]."""
        if self.kind == BALL:
            return 0.0
        return self.reach

    @property
    def reach(self) -> float:
        """Largest distance of its points from its centre [mm]."""
        z0, z1, r0, r1 = self.shape
        return float(np.hypot((z1 - z0) / 2.0, max(r0, r1)))


@dataclass(frozen=True)
class ToolShape:
    """A tool to prove with and to witness with: flutes, then all else.

    Attributes:
        parts: of the tool, in the order of their numbers.
        proof, witness: flutes and others of each.
    """

    parts: tuple[Part, ...]
    proof: tuple[tuple[Solid, ...], tuple[Solid, ...]]
    witness: tuple[tuple[Solid, ...], tuple[Solid, ...]]


class NotTurnedError(ValueError):
    """A shape that the race cannot follow; the message says which part and why."""


def tool_shape(body: Body, machine: Machine) -> ToolShape:
    """The primitives of a tool in the spindle.

    Raises:
        NotTurnedError: a flute that is not round, or whose end is not known, or a body that is
            wider than the flute where the flute is.
    """
    mount = machine.tool
    assert mount is not None  # a body of it is given
    sides: dict[str, tuple[list[Solid], list[Solid]]] = {"inner": ([], []), "outer": ([], [])}
    parts: list[Part] = []
    for part in body.parts:
        for name, role, shape in _pieces_of(part, mount):
            number = len(parts)
            parts.append(part if part.name == name else replace(part, name=name, role=role))
            for side, (flutes, others) in sides.items():
                found = _solids(shape, side, number)
                (flutes if role == "flute" else others).extend(found)
    (flute_in, other_in), (flute_out, other_out) = sides["inner"], sides["outer"]
    _keep_apart(flute_in, other_out)
    order = _from_tip
    return ToolShape(
        tuple(parts),
        (order(flute_in), order(_outside(other_out, flute_in))),
        (order(flute_out), order(_outside(other_in, flute_in))),
    )


def _from_tip(solids: Sequence[Solid]) -> tuple[Solid, ...]:
    return tuple(sorted(solids, key=lambda s: s.shape[0] - (s.shape[2] if s.kind == BALL else 0)))


def _pieces_of(part: Part, mount: ToolMount) -> list[tuple[str, str, Frusta]]:
    """The part by its name and role, or as flute and shank where one shape is all of the tool."""
    shape = _turned_part(part) or _turned_mesh(part, tuple(mount.axis), tuple(mount.gauge_point))
    if part is not mount.one_shape:
        if part.role == "flute" and not (shape.inner or shape.ball):
            raise NotTurnedError(f"{part.name} is not round about the spindle axis, or open")
        return [(part.name, part.role, shape)]
    if not mount.flute:
        raise NotTurnedError(f"where the flute of {part.name} ends is not known")
    if not shape.inner:
        raise NotTurnedError(f"{part.name} is not round about the spindle axis, or open")
    end = mount.flute - mount.length
    return [
        (part.name, "flute", Frusta(_below(shape.inner, end), _below(shape.outer, end))),
        ("shank", "shank", Frusta(_above(shape.inner, end), _above(shape.outer, end))),
    ]


def _turned_part(part: Part) -> Frusta | None:
    """The frusta of a part whose outlines are known; a ball that the flute holds is one."""
    known = part.turned
    if known is None:
        return None
    inner, outer = stretches(known.inner), stretches(known.outer)
    ball = known.ball
    if ball is None or inner[-1][1] < ball[0] + ball[1]:
        return Frusta(inner, outer)
    return Frusta(_above(inner, ball[0]), _above(outer, ball[0]), ball)


def _below(cones: Sequence[Cone], height: float) -> tuple[Cone, ...]:
    return tuple(_cut(c, c[0], min(c[1], height)) for c in cones if c[0] < height - SAME_HEIGHT_MM)


def _above(cones: Sequence[Cone], height: float) -> tuple[Cone, ...]:
    return tuple(_cut(c, max(c[0], height), c[1]) for c in cones if c[1] > height + SAME_HEIGHT_MM)


def _cut(cone: Cone, low: float, high: float) -> Cone:
    z0, z1, r0, r1 = cone
    slope = (r1 - r0) / (z1 - z0)
    return low, high, r0 + slope * (low - z0), r0 + slope * (high - z0)


def _turned_mesh(
    part: Part, axis: tuple[float, float, float], point: tuple[float, float, float]
) -> Frusta:
    """Frusta within a part and around it; none within where it is not round, or open."""
    turn = rotation_from_z(np.array(axis))
    inner: list[Cone] = []
    outer: list[Cone] = []
    for shell in shells(part.triangles):
        standing = (shell - np.array(point)) @ turn
        profile = round_profile(standing) if part.closed else None
        if profile:
            inner += stretches(profile)
        outer += turned_hull(standing)
    return Frusta(tuple(inner), tuple(outer))


def _solids(shape: Frusta, side: str, part: int) -> list[Solid]:
    cones = sorted(shape.inner if side == "inner" else shape.outer)
    slopes = [(r1 - r0) / (z1 - z0) for z0, z1, r0, r1 in cones]
    below = [_seam(cones, slopes, i - 1, i, below=True) for i in range(len(cones))]
    above = [_seam(cones, slopes, i, i + 1, below=False) for i in range(len(cones))]
    limit = min(
        (
            (cone[1] - cone[0]) / (low[2] - high[2])
            for cone, low, high in zip(cones, below, above, strict=True)
            if low[2] > high[2]
        ),
        default=np.inf,
    )
    found = [
        Solid(FRUSTUM, part, cone, (low[0], high[0]), (low[1], high[1]), float(limit))
        for cone, low, high in zip(cones, below, above, strict=True)
    ]
    if shape.ball:
        z, r = shape.ball
        found.append(Solid(BALL, part, (z, z, r, r)))
    return found


def _seam(
    cones: Sequence[Cone], slopes: Sequence[float], i: int, j: int, *, below: bool
) -> tuple[float, float, float]:
    """The face between stretches i and j = i + 1, as that of j (below) or of i.

    Returns:
        Its kind, the slope beside it, and how far it rises as the profile shrinks by 1.
    """
    own, other = (j, i) if below else (i, j)
    inward = 1.0 if below else -1.0
    if i < 0 or j == len(cones) or abs(cones[i][1] - cones[j][0]) > SAME_HEIGHT_MM:
        return FREE, 0.0, inward
    step = cones[j][2] - cones[i][3]
    if abs(step) > TOUCHING_MM:
        is_covered = step < 0.0 if below else step > 0.0
        return (COVERED, 0.0, 0.0) if is_covered else (FREE, 0.0, inward)
    if slopes[j] >= slopes[i] - LEAST_BEND:
        return COVERED, 0.0, 0.0
    normals = [float(np.hypot(1.0, slopes[n])) for n in (own, other)]
    rise = (normals[0] - normals[1]) / (slopes[own] - slopes[other])
    return CONVEX, slopes[other], rise


def _keep_apart(flutes: Sequence[Solid], others: Sequence[Solid]) -> None:
    """Refuse a body that is wider than the flute at a height at which the flute cuts."""
    for other in others:
        for flute in flutes:
            z0, z1 = max(other.shape[0], flute.shape[0]), min(other.shape[1], flute.shape[1])
            if flute.kind == BALL or z1 - z0 <= TOUCHING_MM:
                continue
            ends = [(_cut(s.shape, z0, z1)[2:]) for s in (other, flute)]
            if any(a > b + TOUCHING_MM for a, b in zip(*ends, strict=True)):
                raise NotTurnedError("shank or holder is wider than the flute at the same height")


def _outside(others: Sequence[Solid], flutes: Sequence[Solid]) -> list[Solid]:
    """The bodies without what stands inside the flute: the flute comes there first."""
    top = max((f.shape[1] for f in flutes if f.kind == FRUSTUM), default=-np.inf)
    kept = []
    for other in others:
        if other.kind == BALL or other.shape[0] >= top - SAME_HEIGHT_MM:
            kept.append(other)
        elif other.shape[1] > top + SAME_HEIGHT_MM:
            kept.append(replace(other, shape=_cut(other.shape, top, other.shape[1])))
    return kept


def heights(shape: ToolShape) -> tuple[float, float, float]:
    """Lowest and highest point along the axis, and largest radius [mm]."""
    rows = [s for side in (shape.proof, shape.witness) for group in side for s in group]
    low = min(s.shape[0] - (s.shape[2] if s.kind == BALL else 0.0) for s in rows)
    return low, max(s.shape[1] for s in rows), max(max(s.shape[2:]) for s in rows)
