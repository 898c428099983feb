"""What `gcodesim machine show` and `gcodesim machine schema` print."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from pydantic import BaseModel

from gcodesim.machine.model import Body, Joint, Machine, Pair, Part, Tool
from gcodesim.machine.placing import PlaceError, WorkFrames, extent
from gcodesim.machine.schema import MachineFile, SetupFile, offset_name
from gcodesim.machine.tool_schema import ToolsFile

SCHEMAS: dict[str, type[BaseModel]] = {
    "machine": MachineFile,
    "tools": ToolsFile,
    "setup": SetupFile,
}


def schema_json(kind: str = "machine") -> dict[str, Any]:
    """JSON Schema of a machine, tools or setup file; `kind` is a key of SCHEMAS."""
    title = f"gcodesim {kind} file"
    draft = "https://json-schema.org/draft/2020-12/schema"
    return {"$schema": draft, **SCHEMAS[kind].model_json_schema(), "title": title}


def describe(machine: Machine) -> str:
    """The machine in plain text: tree, bodies, pairs, tools, findings."""
    verified = "verified model" if machine.verified else "unverified model"
    dialect = "auto" if machine.is_dialect_told else machine.readings.dialect
    lines = [f"{machine.name} ({verified}, dialect {dialect}), {machine.path}"]
    lines.append(f"rapids {machine.readings.rapids}, time {machine.time}{_tolerances(machine)}")
    lines.append(_control(machine))
    tools = machine.tools or {}
    for title, rows in (
        ("kinematic tree", (line for link in _fixed(machine) for line in _tree(machine, link, 1))),
        ("bodies", _bodies(machine)),
        ("setup", _standing(machine)),
        (f"pairs ({len(machine.pairs)})", (_pair(pair) for pair in machine.pairs)),
        ("allowed", (f"  {a}-{b}: {reason}" for a, b, reason in machine.allowed)),
        ("not checked by rule", (f"  {line}" for line in machine.unchecked_by_rule)),
        (f"tools ({len(tools)})", (f"  {tool_line(tool)}" for tool in tools.values())),
        ("findings", (f"  {f.code} {f.severity} {f.file}: {f.message}" for f in machine.findings)),
    ):
        listed = list(rows)
        if listed or title.startswith("pairs"):
            lines += ["", title, *listed]
    return "\n".join(lines) + "\n"


def _control(machine: Machine) -> str:
    readings = machine.readings
    feed = readings.tcp_rotary_feed
    return (
        f"pecks back off {readings.peck_backoff:g} mm, boring shift {readings.bore_shift}, "
        f"tool centre point: frame {readings.tcp_frame}, vectors by {readings.orientation}, "
        f"rotary feed {'F' if feed is None else f'{feed:g} deg/min'}"
    )


def _tolerances(machine: Machine) -> str:
    given = {k: v for k, v in machine.path_tolerance.items() if v is not None}
    listed = ", ".join(f"{name} {value:g} mm" for name, value in given.items())
    return f", path tolerance {listed}" if listed else ", path tolerance unknown"


def _tree(machine: Machine, link: str, depth: int) -> Iterator[str]:
    """Yield one line per link, indented by depth, with the joint that moves it."""
    joint = next((j for j in machine.joints if j.child == link), None)
    marks = [" <- tool"] if machine.tool and machine.tool.link == link else []
    marks += [" <- work"] if machine.work_link == link else []
    yield (
        "  " * depth
        + link
        + (f": {_joint(joint)}" if joint else _place(machine, link))
        + "".join(marks)
    )
    for below in machine.joints:
        if below.parent == link:
            yield from _tree(machine, below.child, depth + 1)


def _fixed(machine: Machine) -> list[str]:
    """Links that no joint moves."""
    moved = {joint.child for joint in machine.joints}
    return [link for link in machine.links if link not in moved]


def _place(machine: Machine, link: str) -> str:
    return " (root)" if link == machine.links[0] else " (fixed)"


def _joint(joint: Joint) -> str:
    unit = "deg" if joint.rotary else "mm"
    travel = f"{joint.lower:g} .. {joint.upper:g} {unit}"
    if math.isinf(joint.lower) and math.isinf(joint.upper):
        travel = "unlimited"
    text = f"{joint.name} {'rotary' if joint.rotary else 'linear'} {_vector(joint.axis)}"
    text += f" through {_vector(joint.point)}" if joint.rotary else ""
    text += f", {travel}, rapid {joint.rapid * 60.0:g} {unit}/min"
    for name, most, power in (
        ("acceleration", joint.max_acceleration, 2),
        ("jerk", joint.max_jerk, 3),
    ):
        text += f", {name} {most:g} {unit}/s^{power}" if most is not None else ""
    if joint.servo:
        text += f", servo of order {joint.servo.order}, {joint.servo.time_constant:g} s"
        text += f", damping {joint.servo.damping:g}" if joint.servo.order == 2 else ""
    return text + (f", wrap {joint.wrap}" if joint.wrap != "none" else "")


def _vector(vector: Any) -> str:
    return "[" + ", ".join(f"{v:g}" for v in vector) + "]"


def _bodies(machine: Machine) -> Iterator[str]:
    """Yield the bodies with their parts, then the mounted tool."""
    bodies = list(machine.bodies.values())
    if machine.tool and machine.tool.mounted:
        bodies.append(Body(machine.tool.name, machine.tool.link, machine.tool.mounted))
    for body in bodies:
        yield f"  {body.name}" + (f" on {body.link}" if body.link != body.name else "")
        for part in body.parts:
            yield f"    {_part(part)}"


def _standing(machine: Machine) -> Iterator[str]:
    """Yield where every body of the setup stands, in machine and work coordinates."""
    for body in machine.bodies.values():
        if body.name in machine.links:
            continue
        yield f"  {body.name} on {body.link}, with all axes at 0"
        yield f"    machine: {_corners(body, np.eye(4))}"
        for number in sorted(machine.offsets):
            try:
                frame = WorkFrames.of(machine).zero_point(number, body.link)
            except PlaceError:
                return
            yield f"    {offset_name(number)}: {_corners(body, frame)}"


def _corners(body: Body, frame: Any) -> str:
    """Lowest and highest coordinates of a body in a frame."""
    low, high = (np.round(corner, 6) + 0.0 for corner in extent(body.parts, frame))
    spans = zip("XYZ", low, high, strict=True)
    return ", ".join(f"{axis} {a:.6g} .. {b:.6g}" for axis, a, b in spans)


def _part(part: Part) -> str:
    size = np.ptp(part.triangles.reshape(-1, 3), axis=0)
    measures = " x ".join(f"{v:.6g}" for v in size)
    closed = "closed" if part.closed else "OPEN"
    count = len(part.triangles)
    return f"{part.name}: {count} triangles, {measures} mm, {closed}, {part.role}, {part.source}"


def _pair(pair: Pair) -> str:
    sides = [
        name if parts is None else f"{name}.{'+'.join(parts)}"
        for name, parts in ((pair.a, pair.parts_a), (pair.b, pair.parts_b))
    ]
    clearance = f", clearance {pair.clearance:g} mm ({pair.severity})" if pair.clearance else ""
    return f"  {sides[0]} - {sides[1]}{clearance}"


def tool_line(tool: Tool) -> str:
    """A tool in one line: number, name, type, lengths, parts, and what has no shape."""
    name = f" {tool.name}" if tool.name else ""
    kind = f" ({tool.type})" if tool.type != "mill" else ""
    size = f", diameter {tool.diameter:g} mm" if tool.diameter else ""
    parts = ", ".join(_span(part, tool.diameter) for part in tool.parts)
    missing = f"; not modelled: {', '.join(tool.unchecked)}" if tool.unchecked else ""
    length = f"length {tool.length:g} mm"
    if tool.offset[2] != tool.length:
        length += f", {tool.offset[2]:g} mm in the table of the control"
    return f"T{tool.number}{name}{kind}: {length}{size}, {parts or 'no shape'}{missing}"


def _span(part: Part, diameter: float) -> str:
    """Largest diameter of a part, where it is not that of the tool, and its ends below the face."""
    points = part.triangles.reshape(-1, 3)
    turned = part.turned.inner if part.turned else ()
    widest = max((r for r, _ in turned), default=float(np.hypot(*points[:, :2].T).max()))
    top, low = -float(points[:, 2].max()), -float(points[:, 2].min())
    # A ball drawn inside by chords is a little thinner than its diameter.
    size = "" if 0.0 <= diameter - 2.0 * widest < 0.01 * diameter else f"D{2.0 * widest:.6g} "
    return f"{part.name} {size}{top + 0.0:.6g}..{low:.6g}"
