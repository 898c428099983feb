"""Evidence: turns what the stages found into a first contact, findings and coverage."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gcodesim.collision.detector import Detection
from gcodesim.collision.events import Contact
from gcodesim.constants import PS_PER_S, SLACK_MM
from gcodesim.findings import CONTAINMENT_UNDECIDED, Finding
from gcodesim.machine.model import Machine
from gcodesim.machine.spindle import table_entry
from gcodesim.motion.path import Path
from gcodesim.motion.samples import Span, tool_spans
from gcodesim.nc.interpreter import Interpretation
from gcodesim.verdict import Coverage, FirstContact

TOOL_ROLES = frozenset({"flute", "shank", "holder"})


def first_contact(contact: Contact, path: Path, lines: Sequence[str]) -> FirstContact:
    """The first contact in terms of the program: block, line and axis positions."""
    line = _line_at(contact, path)
    positions = path.positions(np.array([contact.time_ps]))[0]
    point = contact.point
    return FirstContact(
        sample=contact.sample,
        time_s=contact.time_ps / PS_PER_S,
        pair=(contact.pair.a, contact.pair.b),
        parts=contact.parts,
        triangles=contact.triangles,
        point_mm=None if point is None else (float(point[0]), float(point[1]), float(point[2])),
        line=line,
        block=_block(lines, line),
        axes={name: float(q) for name, q in zip(path.joints, positions, strict=True)},
        tool=_tool_at(contact, path),
        between_samples=contact.between,
        distance_mm=contact.distance,
    )


def contact_finding(contact: Contact, first: FirstContact) -> Finding:
    """The finding that goes with the first contact."""
    what = "touches" if contact.triangles else "is inside, or around,"
    if contact.between and contact.distance > SLACK_MM:
        what = f"comes within {contact.distance:.3g} mm of"
    where = "at the start" if contact.appears and not contact.time_ps else "here"
    if contact.appears and contact.time_ps:
        where = "as soon as the tool is in the spindle"
    if contact.between:
        where = "between two samples"
    message = f"{_part_name(contact, 0)} {what} {_part_name(contact, 1)} {where}"
    return Finding(
        _contact_code(contact),
        message,
        "contact" if contact.triangles else "containment",
        line=first.line or None,
        time_s=first.time_s,
        pair=first.pair,
        tool=first.tool,
    )


def detection_findings(detection: Detection, machine: Machine) -> list[Finding]:
    """Findings about what the detector could not decide."""
    found = [_shapeless(span, machine) for span in detection.missing]
    used = [table_entry(machine, span.tool) for span in detection.spans]
    for number, tool in sorted({tool.number: tool for tool in used if tool}.items()):
        if tool.unchecked:
            message = f"tool {number} has no shape for its {', '.join(tool.unchecked)}: not checked"
            found.append(Finding("GC421", message, "tool_part_without_shape", tool=number))
    for pair, part in detection.undecided:
        message = f"{part} is an open mesh: whether it encloses the other body is undecidable"
        text = (pair.a, pair.b)
        found.append(Finding("GC501", message, CONTAINMENT_UNDECIDED, pair=text))
    return found


def coverage(
    detection: Detection, machine: Machine, meaning: Interpretation, between: bool
) -> Coverage:
    """What was checked and what was not."""
    pairs = [pair for pair in machine.pairs if pair in detection.checked]
    return Coverage(
        pairs=tuple((pair.a, pair.b) for pair in pairs),
        between_samples=between,
        unsupported=meaning.unsupported,
        ignored=meaning.ignored,
        uncertified=tuple(
            f"clearance {pair.clearance:g} mm of {pair.name}: this method only tells contact"
            for pair in pairs
            if pair.clearance > 0.0
        ),
        unchecked_by_rule=machine.unchecked_by_rule,
    )


def placed(finding: Finding, file: str, lines: Sequence[str]) -> Finding:
    """The finding with the file and the text of its block filled in."""
    return replace(finding, file=file, block=_block(lines, finding.line or 0))


def _tool_at(contact: Contact, path: Path) -> int | None:
    """Tool in the spindle: the new one where its appearing is the contact."""
    if contact.appears:
        return contact.span.tool
    return next(span.tool for span in tool_spans(path) if contact.time_ps <= span.end_ps)


def _line_at(contact: Contact, path: Path) -> int:
    """Line of the block in force; the tool change, or 0, where a body appears."""
    if contact.appears:
        return contact.span.line
    return int(path.line[path.piece_at(np.array([contact.time_ps]))[0]])


def _block(lines: Sequence[str], line: int) -> str:
    return lines[line - 1].strip() if 0 < line <= len(lines) else ""


def _part_name(contact: Contact, side: int) -> str:
    body, part = (contact.pair.a, contact.pair.b)[side], contact.parts[side]
    return part if part == body else f"{part} of {body}"


def _contact_code(contact: Contact) -> str:
    if contact.between:
        return "GC107"
    if contact.appears:
        return "GC106"
    roles = set(contact.roles)
    if roles & {"stock", "part"}:
        return "GC103"
    if "fixture" in roles:
        return "GC104" if roles & TOOL_ROLES else "GC101"
    return "GC102" if roles & TOOL_ROLES else "GC101"


def _shapeless(span: Span, machine: Machine) -> Finding:
    name = "no tool" if span.tool is None else f"tool {span.tool}"
    body = machine.tool.name if machine.tool else "tool"
    known = table_entry(machine, span.tool)
    cause = "is in the tools file without a shape" if known else "has no shape"
    if span.tool is None:
        cause = "is mounted at the start"
    message = f"{name} {cause}: pairs of {body} are not checked from here on"
    return Finding("GC421", message, "tool_without_shape", line=span.line or None, tool=span.tool)
