"""Evidence: turns what the stages found into a first contact, findings and coverage."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from gcodesim.checking.verdict import (
    ContactInterval,
    Coverage,
    FirstContact,
    LargestStep,
    ReadingTaken,
    SmallestDistance,
)
from gcodesim.collision.bounds.leave_out import still_axes
from gcodesim.collision.detector import Detection
from gcodesim.collision.instants.containment import Containment
from gcodesim.collision.search.clearance import Nearness
from gcodesim.collision.search.events import Contact
from gcodesim.collision.search.intervals import Interval
from gcodesim.constants import CLEARANCE_SLACK_MM, PS_PER_S, SLACK_MM
from gcodesim.findings.codes import CONTAINMENT_UNDECIDED, Finding
from gcodesim.findings.left_out import LeftOut, NotRun
from gcodesim.findings.meanings import MEANINGS
from gcodesim.machine.model import Machine, Pair
from gcodesim.machine.spindle import table_entry
from gcodesim.motion.off_path import OffPath
from gcodesim.motion.path import Path
from gcodesim.motion.rapids import may_bend
from gcodesim.motion.samples import Span, tool_spans
from gcodesim.nc.control.interpreter import Interpretation
from gcodesim.nc.control.readings import BOTH, ReadingMet, ways_of
from gcodesim.nc.program import CanonicalProgram, Kind

TOOL_ROLES = frozenset({"flute", "shank", "holder"})
CUT_ROLES = frozenset({"part", "stock"})
SETUP_ROLES = CUT_ROLES | {"fixture"}


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
    surfaces = contact.triangles is not None or contact.between
    what = "touches" if surfaces else "is inside, or around,"
    if contact.between and contact.distance > SLACK_MM:
        what = f"comes within {contact.distance:.3g} mm of"
    where = "at the start" if contact.appears and not contact.time_ps else "here"
    if contact.appears and contact.time_ps:
        where = "as soon as the tool is in the spindle"
    if contact.between:
        where = "between two samples"
    if _contact_code(contact) == "GC105":
        where += ", in a rapid or with the spindle off"
    if contact.in_stock:
        what, surfaces, where = "is in what is left of", True, f"{where}, {contact.in_stock}"
    message = f"{_part_name(contact, 0)} {what} {_part_name(contact, 1)} {where}"
    return Finding(
        _contact_code(contact),
        message,
        "contact" if surfaces else "containment",
        line=first.line or None,
        time_s=first.time_s,
        pair=first.pair,
        parts=first.parts,
        depth=contact.depth,
        tool=first.tool,
    )


def detection_findings(detection: Detection, machine: Machine, path: Path) -> list[Finding]:
    """Findings about clearances, and about what the detector could not decide."""
    found = [_shapeless(span, machine) for span in detection.missing]
    used = [table_entry(machine, span.tool) for span in detection.spans]
    for number, tool in sorted({tool.number: tool for tool in used if tool}.items()):
        if tool.unchecked:
            message = f"tool {number} has no shape for its {', '.join(tool.unchecked)}: not checked"
            found.append(Finding("GC421", message, "tool_part_without_shape", tool=number))
    for (pair, part), span in detection.not_smaller.items():
        other = pair.b if machine.tool and pair.a == machine.tool.name else pair.a
        message = (
            f"{part} is not round about the spindle axis, or open: it is not checked against "
            f"{other} in rapids and with the spindle off"
        )
        names = (pair.a, pair.b)
        found.append(Finding("GC421", message, "flute_not_round", pair=names, tool=span.tool))
    for pair, span in detection.endless.items():
        message = (
            "where the flute of the mounted tool ends is not known (tool: {mounted: {flute: 25}}, "
            "from the tip): shank and holder are not checked where it cuts"
        )
        names = (pair.a, pair.b)
        found.append(Finding("GC421", message, "flute_end_unknown", pair=names, tool=span.tool))
    found += [_in_stock(touch, path) for touch in detection.in_stock]
    found += [_probed(touch, path) for touch in detection.probed]
    found += dict.fromkeys(_undecided(pair, item) for pair, item in detection.undecided)
    near_places = (entry for span in detection.findings for entry in span.too_near)
    found += [_too_near(*e, path) for e in near_places if not _touches_there(detection, *e)]
    if any(span.overflows for span in detection.findings):
        message = "the search ran out of stack: some stretches of time are not decided"
        found.append(Finding("GC901", message, "search_undecided"))
    return found


def _undecided(pair: Pair, item: Containment) -> Finding:
    """Whether a body is inside another is not known: the outer one is an open mesh."""
    names = (pair.a, pair.b)
    both = [p if p == n else f"{p} of {n}" for p, n in zip(item.parts, names, strict=True)]
    outer, inner = both if item.outer_is_a else reversed(both)
    message = f"{outer} is an open mesh: whether it encloses {inner} is undecidable; close it, or "
    message += "`shell: true` at the mesh where it has no inside"
    return Finding("GC501", message, CONTAINMENT_UNDECIDED, pair=names, parts=item.parts)


def _in_stock(contact: Contact, path: Path) -> Finding:
    """A touch of the raw part, which keeps its shape here: what was cut away is not known."""
    first = first_contact(contact, path, ())
    message = f"{_part_name(contact, 0)} is in {_part_name(contact, 1)} here, "
    message += "unless it was cut away before: the stock keeps its shape"
    return Finding(
        "GC426",
        message,
        "stock_keeps_shape",
        line=first.line or None,
        time_s=first.time_s,
        pair=first.pair,
        tool=first.tool,
    )


def _probed(contact: Contact, path: Path) -> Finding:
    """A touch that a skip move is for."""
    first = first_contact(contact, path, ())
    message = f"{_part_name(contact, 0)} touches {_part_name(contact, 1)} in a skip move: "
    return Finding(
        "GC430",
        message + MEANINGS["skip_touch"][1],
        "skip_touch",
        line=first.line or None,
        time_s=first.time_s,
        pair=first.pair,
        tool=first.tool,
    )


def _touches_there(detection: Detection, pair: Pair, near: Nearness) -> bool:
    """Whether a pair touches where it is too near: on its way into a contact it must be."""
    times = [touch.time_ps for _, touch in _intervals(detection) if touch.pair == pair]
    if detection.contact and detection.contact.pair == pair:
        times.append(detection.contact.time_ps)
    return any(near.time_ps <= time <= near.end_ps for time in times)


def _too_near(pair: Pair, near: Nearness, path: Path) -> Finding:
    asked, off = near.limit - near.departure + CLEARANCE_SLACK_MM, near.departure
    distance = _apart(near.distance, asked + off)
    message = f"{pair.a} comes to {distance} mm of {pair.b}; "
    code, meaning = "GC201", "clearance"
    if near.touch:
        code, meaning = "GC202", "path_tolerance"
        message += f"the machine may be off its path by {off:.6g} mm: a touch is not excluded"
    else:
        message += f"the clearance asked for is {asked:.9g} mm"
        message += f", and it may be off its path by {off:.6g} mm" if off > 0.0 else ""
    return Finding(
        code,
        message,
        meaning,
        line=_line(path, near.time_ps) or None,
        time_s=near.time_ps / PS_PER_S,
        pair=(pair.a, pair.b),
        depth=asked + off - (near.distance if near.in_block is None else near.in_block),
        continues=near.continues,
        severity=pair.severity,
    )


def _apart(distance: float, limit: float) -> str:
    """The distance [mm] in as many digits as tell it from a larger limit."""
    few = (text for n in range(6, 17) if (text := f"{distance:.{n}g}") != f"{limit:.{n}g}")
    return next(few, f"{distance:.6g}")


def all_contact_findings(detection: Detection, path: Path) -> list[Finding]:
    """A finding for the first contact, and with --stop all one for every block of every contact."""
    first = detection.contact
    if first is None:
        return []
    touches = _intervals(detection)
    # A body that is inside another while their surfaces touch is one contact.
    alone = [c for c in detection.contained if not any(_covers(i, t, c) for i, t in touches)]
    own = next((entry for entry in touches if _begins_with(*entry, first)), None)
    found = [] if own else [contact_finding(first, first_contact(first, path, ()))]
    for entry in sorted(touches, key=lambda entry: entry is not own):
        found += _block_findings(entry[0], first if entry is own else entry[1], path)
    found += [contact_finding(c, first_contact(c, path, ())) for c in alone if c is not first]
    return found


def _block_findings(interval: Interval, contact: Contact, path: Path) -> Iterator[Finding]:
    """Yield a finding for every block in which a contact lasts, with the depth it has there."""
    for number, block in enumerate(interval.blocks):
        if number:
            contact = replace(contact, appears=False, time_ps=block.start_ps + 1)
        found = contact_finding(contact, first_contact(contact, path, ()))
        time_s = block.start_ps / PS_PER_S if number else found.time_s
        message = found.message.replace(" touches ", " still touches ") if number else found.message
        yield replace(
            found, time_s=time_s, message=message, depth=block.depth.deepest, continues=bool(number)
        )


def _begins_with(interval: Interval, contact: Contact, first: Contact) -> bool:
    """Whether an interval is the one whose begin is the first contact."""
    touch = first.triangles is not None or first.between
    same = (contact.pair, contact.parts) == (first.pair, first.parts)
    return touch and same and interval.start_ps <= first.time_ps


def _covers(interval: Interval, touch: Contact, inside: Contact) -> bool:
    return touch.pair == inside.pair and interval.start_ps <= inside.time_ps <= interval.end_ps


def contacts(detection: Detection) -> tuple[ContactInterval, ...]:
    """All contact intervals, in the order of time."""
    return tuple(
        ContactInterval(
            (contact.pair.a, contact.pair.b),
            contact.parts,
            interval.start_ps / PS_PER_S,
            interval.end_ps / PS_PER_S,
            interval.deepest.deepest,
            interval.deepest.time_ps / PS_PER_S,
            interval.between is not None,
            interval.deepest.within,
        )
        for interval, contact in _intervals(detection)
    )


def _intervals(detection: Detection) -> list[tuple[Interval, Contact]]:
    return [entry for span in detection.findings for entry in span.intervals]


def clearances(detection: Detection, path: Path) -> tuple[SmallestDistance, ...]:
    """The smallest distance of every pair, over all spans."""
    smallest: dict[Pair, Nearness] = {}
    for pair, near in (entry for span in detection.findings for entry in span.minimums):
        if pair not in smallest or near.distance < smallest[pair].distance:
            smallest[pair] = near
    return tuple(
        SmallestDistance(
            (pair.a, pair.b),
            near.distance,
            near.time_ps / PS_PER_S,
            _line(path, near.time_ps),
        )
        for pair, near in smallest.items()
    )


def largest_step(detection: Detection, path: Path) -> LargestStep | None:
    """The largest step from sample to sample, over all spans; None when nothing moves."""
    if not detection.steps:
        return None
    pair, step = max(detection.steps, key=lambda entry: entry[1].distance)
    return LargestStep(step.distance, (pair.a, pair.b), int(path.line[step.piece]))


def left_out(detection: Detection, machine: Machine) -> tuple[LeftOut, ...]:
    """Pairs, axes and bodies that were not looked at."""
    smallest: dict[str, LeftOut] = {}
    for item in (item for span in detection.findings for item in span.left_out):
        known = smallest.setdefault(item.what, item)
        smallest[item.what] = min(known, item, key=lambda i: i.margin_mm)
    items, names = list(smallest.values()), set(smallest)
    items += still_axes(detection.travels)
    needed = {name for p in detection.checked if p.name not in names for name in (p.a, p.b)}
    # The flute is looked at in full, even where shank and holder never come near.
    needed |= {name for p in machine.cutting if p in detection.checked for name in (p.a, p.b)}
    for name in sorted(set(machine.bodies) - needed):
        items.append(LeftOut(f"body {name}", "no pair that is left needs it"))
    return tuple(items)


def coverage(
    detection: Detection,
    machine: Machine,
    meaning: Interpretation,
    between: bool,
    searches: bool,
    off_path: tuple[str, ...],
) -> Coverage:
    """What was checked and what was not."""
    pairs = [pair for pair in machine.pairs if pair in detection.checked]
    cutting = [pair for pair in machine.cutting if pair in detection.checked]
    names = dict.fromkeys((pair.a, pair.b) for pair in (*pairs, *cutting))
    return Coverage(
        pairs=tuple(names),
        between_samples=between,
        unsupported=meaning.unsupported,
        ignored=meaning.ignored,
        uncertified=tuple(
            f"clearance {pair.clearance:g} mm of {pair.name}: this method only tells contact"
            for pair in pairs
            if pair.clearance > 0.0 and not searches
        )
        + tuple(
            f"clearance {pair.clearance:g} mm of {pair.name}: not looked at with a tool that probes"
            for pair in sorted(detection.unmeasured, key=lambda pair: pair.name)
            if pair.clearance > 0.0
        ),
        unchecked_by_rule=(
            *machine.unchecked_by_rule,
            *(f"{a}-{b}: allowed, {reason}" for a, b, reason in machine.allowed),
        ),
        off_path=off_path,
        readings=_readings(meaning, machine),
        not_run=tuple(_in_its_file(entry, meaning) for entry in meaning.not_run),
    )


def _readings(meaning: Interpretation, machine: Machine) -> tuple[ReadingTaken, ...]:
    """The keys of the control that are not known and that the program depends on."""
    # Only a flute that may touch something asks whether the spindle turns.
    met = [e for e in meaning.readings if e.key != "spindle_at_stop" or machine.cutting]
    if machine.readings.rapids == BOTH and (bent := may_bend(meaning.program)):
        met.append(ReadingMet("rapids", *bent))
    return tuple(
        ReadingTaken(
            each.key,
            each.value or ways_of(each.key)[0],
            False,
            meaning.place(each.line)[1],
            each.count,
        )
        for each in met
    )


def other_programs(meaning: Interpretation) -> list[Finding]:
    """A note about the main programs that stand in the file too, and were not run."""
    if not (others := meaning.other_programs):
        return []
    names = ", ".join(name for name, _ in others)
    code, right = MEANINGS["other_programs"]
    message = f"not run: the file also holds {names}: {right}"
    return [Finding(code, message, "other_programs", line=min(line for _, line in others) + 1)]


def _in_its_file(entry: NotRun, meaning: Interpretation) -> NotRun:
    file, line = meaning.place(entry.line)
    where = "" if file == meaning.files[0][0] else f" in {file}"
    return replace(entry, what=entry.what + where, line=line)


def off_path_lines(
    off: OffPath, path: Path, machine: Machine, between: bool, searches: bool
) -> tuple[str, ...]:
    """How far the machine may be from the path that was checked, one line for each cause.

    Args:
        off: bounds of rounded corners and of the lag of the drives.
        path: with the deviation of moves under tool centre point control.
        machine: whose joints lag.
        between: the time between samples is proved too.
        searches: the method proves distances, not only tells contact.
    """
    lines = [off.corners] if off.corners else []
    late = "; ".join(_lags(off, machine))
    if late:
        lines.append(f"clearances widened by the lag of the drives at each time ({late})")
    if lines and not searches:
        lines.append("this method widens nothing: it tells contact on the path itself")
    if path.deviation_mm:
        proved = "the tolerance between samples is widened by it" if between else "not covered"
        good = f"{path.deviation_mm:.3g} mm"
        lines.append(f"moves under tool centre point control followed to {good}: {proved}")
    return tuple(lines)


def _lags(off: OffPath, machine: Machine) -> Iterator[str]:
    """Yield a text for every joint that lags: the most, and what half of the time is enough."""
    usual = off.late.usual().tolist() if off.late else []
    enough = dict(zip(off.late.columns.tolist(), usual, strict=True)) if off.late else {}
    for column, (joint, most) in enumerate(zip(machine.joints, off.lag, strict=True)):
        unit = "deg" if joint.rotary else "mm"
        half = f"{max(enough.get(column, most), SLACK_MM):.3g}"
        if most > 0.0:
            more = f", half of the time {half} {unit}" if half != f"{most:.3g}" else ""
            yield f"{joint.name} at most {most:.3g} {unit}{more}"


def placed(finding: Finding, file: str, meaning: Interpretation) -> Finding:
    """The finding with the file and the text of its block filled in."""
    block = _block(meaning.lines, finding.line or 0)
    if finding.line is None:
        return replace(finding, file=file, block=block)
    message = finding.message
    if (finding.is_contact or finding.code == "GC301") and _is_bare(meaning.program, finding.line):
        message += "; no tool length is active"
    # Lines of subprograms in files of their own are counted after the main program.
    name, line = meaning.place(finding.line)
    return replace(finding, file=name, line=line, block=block, message=message)


def _is_bare(program: CanonicalProgram, line: int) -> bool:
    """Whether every command of a line runs without a tool length."""
    lengths = np.where(program.kind == Kind.TOOL_OFFSET, program.to.any(axis=1), -1)
    at, changes = np.flatnonzero(program.line == line), np.flatnonzero(lengths >= 0)
    before = np.searchsorted(changes, at)
    active = np.concatenate(([0], lengths[changes]))[before]
    return bool(len(at)) and not active.any()


def _tool_at(contact: Contact, path: Path) -> int | None:
    """Tool in the spindle: the new one where its appearing is the contact."""
    if contact.appears:
        return contact.span.tool
    return next(span.tool for span in tool_spans(path) if contact.time_ps <= span.end_ps)


def _line_at(contact: Contact, path: Path) -> int:
    """Line of the block in force; the tool change, or 0, where a body appears."""
    if contact.appears:
        return contact.span.line
    piece = int(path.piece_at(np.array([contact.time_ps]))[0])
    touching = path.touching is not None and path.touching[piece]
    if _flute_cuts(contact) and path.cuts is not None and path.cuts[piece] and not touching:
        # Where it cuts it may touch: what counts is the move that begins there.
        piece += 1
    return int(path.line[piece])


def _flute_cuts(contact: Contact) -> bool:
    """Whether a contact is one of the flute with what it may cut."""
    return "flute" in contact.roles and bool(set(contact.roles) & CUT_ROLES)


def _line(path: Path, time_ps: int) -> int:
    return int(path.line[path.piece_at(np.array([time_ps]))[0]])


def _block(lines: Sequence[str], line: int) -> str:
    return lines[line - 1].strip() if 0 < line <= len(lines) else ""


def _part_name(contact: Contact, side: int) -> str:
    body, part = (contact.pair.a, contact.pair.b)[side], contact.parts[side]
    return part if part == body else f"{part} of {body}"


def _contact_code(contact: Contact) -> str:
    """The code of a contact: what meets, in either order of the pair, unless when it does counts.

    Two bodies of the setup that different links carry meet as a link of the machine meets one.
    """
    if contact.between:
        return "GC107"
    if contact.appears:
        return "GC106"
    roles = set(contact.roles)
    if not roles & TOOL_ROLES:
        return "GC108" if roles & SETUP_ROLES else "GC101"
    if roles & CUT_ROLES:
        return "GC105" if "flute" in roles else "GC103"
    return "GC104" if "fixture" in roles else "GC102"


def _shapeless(span: Span, machine: Machine) -> Finding:
    name = "no tool" if span.tool is None else f"tool {span.tool}"
    body = machine.tool.name if machine.tool else "tool"
    known = table_entry(machine, span.tool)
    cause = "is in the tools file without a shape" if known else "has no shape"
    if span.tool is None:
        cause = "is mounted at the start"
    message = f"{name} {cause}: pairs of {body} are not checked from here on"
    return Finding("GC421", message, "tool_without_shape", line=span.line or None, tool=span.tool)
