"""Events: the first contact in terms of the machine, with its bodies, parts and place."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gcodesim.collision.bodies.scene import Scene, by_parts
from gcodesim.collision.geometry.poses import PathArrays
from gcodesim.collision.instants.contact import TouchingTriangles, touching_triangles
from gcodesim.collision.instants.containment import Containment
from gcodesim.collision.search.approach import Approach
from gcodesim.collision.search.depths import DepthGauge
from gcodesim.collision.search.intervals import Interval
from gcodesim.machine.kinematics import transform, world_from_link
from gcodesim.machine.model import Joint, Machine, Pair
from gcodesim.motion.path import Path
from gcodesim.motion.samples import Instants, Span, sample_of


@dataclass(frozen=True)
class Contact:
    """The first contact, a containment, or a contact between two samples.

    Attributes:
        sample: sample index it counts for.
        parts, roles: names and roles of the two parts.
        appears: it is there the moment a body appears (start, tool change).
        triangles: numbers within the parts; None for a containment.
        point: a shared or halfway point [mm], world coordinates; None for a containment.
        between: it begins and ends between two samples, or comes within the tolerance there.
        distance: smallest distance of such a stretch [mm].
        depth: how deep a body lies inside another as it appears [mm]; None where not asked for.
        in_stock: of a stock as it is then: how deep, and what cuts it away later; else empty.
    """

    sample: int
    time_ps: int
    pair: Pair
    parts: tuple[str, str]
    roles: tuple[str, str]
    span: Span
    appears: bool
    triangles: tuple[int, int] | None = None
    point: NDArray[np.float64] | None = None
    between: bool = False
    distance: float = 0.0
    depth: float | None = None
    in_stock: str = ""


@dataclass(frozen=True)
class SpanContext:
    """What a span is checked in: a machine on its path, one scene, one stretch of program time.

    `travels` are the joints with the travel of the program as their limits.
    """

    machine: Machine
    path: Path
    scene: Scene
    span: Span
    period_ps: int
    travels: tuple[Joint, ...]

    def touch(self, sample: int, pair: int, found: TouchingTriangles) -> Contact:
        """The contact of two surfaces at a sample."""
        appears = found.time_ps == self.span.start_ps
        named = self._named(sample, found.time_ps, pair, found.numbers, found.point)
        return replace(named, appears=appears)

    def approach(self, found: Approach) -> Contact:
        """The contact of two surfaces between samples."""
        nearest = found.nearest
        sample = sample_of(found.start_ps, self.period_ps)
        # The point is posed where it was found; the event counts from where it began.
        named = self._named(sample, nearest.time_ps, nearest.pair, nearest.numbers, nearest.point)
        return replace(named, time_ps=found.start_ps, between=True, distance=nearest.distance)

    def interval(self, found: Interval, arrays: PathArrays) -> Contact:
        """The contact with which an interval of contact begins."""
        own = replace(self, scene=found.scene)
        if found.between:
            return own.approach(Approach(found.start_ps, found.end_ps, found.between))
        time = np.array([found.start_ps])
        sample = sample_of(found.start_ps, self.period_ps)
        instants = Instants(time, self.path.piece_at(time), np.array([sample]))
        touching = touching_triangles(found.scene, arrays, instants, found.own_pair)
        return own.touch(sample, found.own_pair, touching)

    def containment(self, found: Containment) -> Contact:
        """The contact of a body with one that it is inside of, at the start of the span."""
        start = self.span.start_ps
        sample = sample_of(start, self.period_ps)
        pair = self.scene.pairs[found.pair]
        return Contact(sample, start, pair, found.parts, found.roles, self.span, True)

    def with_depth(self, contact: Contact, arrays: PathArrays) -> Contact:
        """A containment with the depth that the one body has in the other as it begins."""
        pair = self.scene.pairs.index(contact.pair)
        scene = by_parts(self.scene, pair, self.travels)
        names = [tuple(shape.parts[0].name for shape in sides) for sides in scene.shapes]
        own = names.index(contact.parts)
        gauge = DepthGauge(scene, self.path, arrays, self.travels, [own])
        return replace(contact, depth=float(gauge.depths(0, np.array([contact.time_ps]))[0]))

    def _named(
        self,
        sample: int,
        time_ps: int,
        pair: int,
        numbers: tuple[int, int],
        point: NDArray[np.float64],
    ) -> Contact:
        a, b = self.scene.shapes[pair]
        (part_a, number_a), (part_b, number_b) = (
            shape.find_triangle(number) for shape, number in zip((a, b), numbers, strict=True)
        )
        q = self.path.positions(np.array([time_ps]))[0]
        world = world_from_link(self.machine, q)[self.scene.links[pair][0]]
        return Contact(
            sample,
            time_ps,
            self.scene.pairs[pair],
            (part_a.name, part_b.name),
            (part_a.role, part_b.role),
            self.span,
            False,
            (number_a, number_b),
            transform(world, point),
        )
