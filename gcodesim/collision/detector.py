"""The detector: from a path and a machine to the first contact, tool by tool, window by window."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from gcodesim.collision.contact import touching_triangles
from gcodesim.collision.containment import find_containments
from gcodesim.collision.exhaustive import Work, first_contact_exhaustive
from gcodesim.collision.paper import first_contact_paper, prepare_paper
from gcodesim.collision.poses import PathArrays, path_arrays
from gcodesim.collision.scene import Scene, build_scene
from gcodesim.machine.kinematics import transform, world_from_link
from gcodesim.machine.model import Body, Joint, Machine, Pair
from gcodesim.machine.spindle import bodies_in_place, table_entry
from gcodesim.motion.limits import position_ranges
from gcodesim.motion.path import Path
from gcodesim.motion.samples import Instants, Span, sample_of, tool_spans, window, windows

WINDOW = 16_384
"""Samples per window: long enough to amortise a launch, short enough for progress and Ctrl-C."""

METHODS = ("exhaustive", "paper")


@dataclass(frozen=True)
class Contact:
    """The first contact, or a containment, in terms of the machine.

    Attributes:
        appears: it is there the moment a body appears (start, tool change).
        parts, roles: names and roles of the two parts.
        triangles: numbers within the parts; None for a containment.
        point: a shared point [mm], world coordinates; None for a containment.
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


@dataclass
class Detection:
    """What the detector found and what it cost.

    Attributes:
        contact: first contact, None when every sample is free.
        checked: pairs looked at.
        spans: stretches of program time looked at, each with its tool.
        missing: stretches of time in which the tool has no shape.
        undecided: open parts for which containment cannot be decided, with their pair.
    """

    contact: Contact | None = None
    checked: set[Pair] = field(default_factory=set)
    spans: list[Span] = field(default_factory=list)
    missing: list[Span] = field(default_factory=list)
    undecided: list[tuple[Pair, str]] = field(default_factory=list)
    work: Work = field(default_factory=Work)


@dataclass(frozen=True)
class Task:
    """One path to be checked on one machine.

    Attributes:
        period_ps: sample period [ps].
        device: resolved device name.
        method: one of METHODS.
        progress: called with the fraction of program time done.
    """

    path: Path
    machine: Machine
    period_ps: int
    device: str
    method: str
    progress: Callable[[float], None]


def detect(task: Task) -> Detection:
    """Find the first contact of the path, looking at every sample and every block end.

    Nothing is checked where the path has no pieces.
    """
    detection = Detection()
    if not len(task.path):
        return detection
    arrays = path_arrays(task.path, task.device)
    for span in _spans_by_body(task):
        detection.spans.append(span)
        bodies = bodies_in_place(task.machine, span.tool)
        pairs = tuple(p for p in task.machine.pairs if _is_present(p, bodies))
        if any(name not in bodies for p in task.machine.pairs for name in (p.a, p.b)):
            detection.missing.append(span)
        if not pairs:
            continue
        detection.checked.update(pairs)
        scene = build_scene(pairs, bodies, task.machine.joints, task.device)
        contacts = [
            _containment(task, scene, span, detection),
            _touch(task, scene, span, arrays, detection),
        ]
        found = [contact for contact in contacts if contact]
        if found:
            detection.contact = min(found, key=lambda c: (c.sample, c.triangles is None))
            break
    return detection


def _spans_by_body(task: Task) -> list[Span]:
    """Stretches of time with the same tool body; a change for the same one changes nothing."""
    merged: list[Span] = []
    mounted: int | None = None
    for span in tool_spans(task.path):
        entry = table_entry(task.machine, span.tool)
        number = entry.number if entry else _shapeless_number(task.machine, span.tool)
        if merged and number == mounted:
            merged[-1] = replace(merged[-1], end_ps=span.end_ps)
        else:
            merged.append(span)
        mounted = number
    return merged


def _shapeless_number(machine: Machine, number: int | None) -> int | None:
    """Number that tells tools without a table entry apart; None = the mounted tool stands in."""
    stands_for_all = machine.tool is not None and machine.tool.for_all
    return None if stands_for_all else number


def _is_present(pair: Pair, bodies: dict[str, Body]) -> bool:
    """Both bodies are there, with at least one of the parts that count."""
    return all(
        name in bodies and any(wanted is None or p.name in wanted for p in bodies[name].parts)
        for name, wanted in ((pair.a, pair.parts_a), (pair.b, pair.parts_b))
    )


def _touch(
    task: Task, scene: Scene, span: Span, arrays: PathArrays, detection: Detection
) -> Contact | None:
    """First contact of surfaces within one stretch."""
    prepared = prepare_paper(scene, _travelled(task)) if task.method == "paper" else []
    total = max(task.path.duration_ps, 1)
    for first in windows(task.path, span, WINDOW, task.period_ps):
        instants = window(task.path, span, first, WINDOW, task.period_ps)
        if task.method == "paper":
            hit = first_contact_paper(scene, prepared, arrays, instants, detection.work)
        else:
            hit = first_contact_exhaustive(scene, arrays, instants, detection.work)
        if hit:
            return _describe(task, scene, span, arrays, instants, *hit)
        task.progress(min(1.0, (first + WINDOW) * task.period_ps / total))
    return None


def _travelled(task: Task) -> tuple[Joint, ...]:
    """The joints with their travel as far as the path exceeds it; the path's own if unlimited."""
    joints = []
    for column, joint in enumerate(task.machine.joints):
        lows, highs = position_ranges(task.path, column)
        low, high = float(lows.min()), float(highs.max())
        lower = min(low, joint.lower) if np.isfinite(joint.lower) else low
        upper = max(high, joint.upper) if np.isfinite(joint.upper) else high
        joints.append(replace(joint, lower=lower, upper=upper))
    return tuple(joints)


def _describe(
    task: Task,
    scene: Scene,
    span: Span,
    arrays: PathArrays,
    instants: Instants,
    sample: int,
    pair: int,
) -> Contact:
    """Name the triangles, the parts and the point of a contact."""
    at_sample = instants.sample == sample
    chosen = Instants(
        instants.time_ps[at_sample], instants.piece[at_sample], instants.sample[at_sample]
    )
    touching = touching_triangles(scene, arrays, chosen, pair)
    a, b = scene.shapes[pair]
    (part_a, number_a), (part_b, number_b) = (
        shape.find_triangle(number) for shape, number in zip((a, b), touching.numbers, strict=True)
    )
    q = task.path.positions(np.array([touching.time_ps]))[0]
    world = world_from_link(task.machine, q)[scene.links[pair][0]]
    return Contact(
        sample,
        touching.time_ps,
        scene.pairs[pair],
        (part_a.name, part_b.name),
        (part_a.role, part_b.role),
        span,
        touching.time_ps == span.start_ps,
        (number_a, number_b),
        transform(world, touching.point),
    )


def _containment(task: Task, scene: Scene, span: Span, detection: Detection) -> Contact | None:
    """A body inside another at the start of a stretch: a contact that surfaces do not show."""
    q = task.path.positions(np.array([span.start_ps]))[0]
    world = world_from_link(task.machine, q)
    relative = [np.linalg.inv(world[a]) @ world[b] for a, b in scene.links]
    found = find_containments(scene, relative)
    detection.undecided += [(scene.pairs[c.pair], c.outer) for c in found if not c.decided]
    inside = next((c for c in found if c.decided), None)
    if inside is None:
        return None
    return Contact(
        sample_of(span.start_ps, task.period_ps),
        span.start_ps,
        scene.pairs[inside.pair],
        inside.parts,
        inside.roles,
        span,
        True,
    )
