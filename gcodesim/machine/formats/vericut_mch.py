"""Turns a VERICUT machine file (.mch with its models) into a machine file.

Components that do not move, as spindles and covers, become parts of what carries them. VERICUT
turns the motion round on the side of the work: so does `side: work`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from gcodesim.machine.formats.imported import (
    Imported,
    body_entry,
    number,
    plain_name,
    unique,
)
from gcodesim.machine.formats.link_poses import angles_of
from gcodesim.machine.formats.vericut_tree import MM, MOVING, MachTree, read_mach

Array = NDArray[np.float64]

UNLIMITED = 29999.0
"""A travel of VERICUT that ends at this or beyond is none."""

DEFAULT_SPEED = {"linear": 10_000.0, "rotary": 3600.0}
"""Rapid rate where the file gives none [mm/min, deg/min]."""

DIRECTIONS = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}
TABLE_AXES = "XYZABC"
"""Order of the values of a table."""

TABLES = {"Initial Machine Location", "Tool Change Location", "Tool Change Retraction",
          "Machine Reference Location"}  # fmt: skip
"""Tables that are carried over."""

TOOL = "tool"

ShapesOf = dict[str, list[tuple[str, str]]]
"""Component -> link and part of each of its shapes."""


def import_mch(path: str, folder: str) -> Imported:
    """The machine of a VERICUT machine file.

    Args:
        path: the file; models are looked for where it says, and then beside it.
        folder: where the machine file will lie; mesh paths are written relative to it.

    Raises:
        UsageError: the file cannot be read.
        ModelError: it is no such file, or holds what no machine file can say; names the line.
    """
    tree = read_mach(path, folder)
    machine = Imported(Path(path).stem, f"{Path(path).name} (VERICUT)", {"dialect": "auto"})
    links = _link_names(tree)
    parts, shapes = _bodies(tree, links)
    work = _only(tree, "attach")
    on_work_side = set(tree.above(work)) if work else set()
    machine.links = {link: body_entry(parts[link]) for link in links.values()}
    for name, link in links.items():
        if tree.components[name].get("Type") in MOVING:
            if name in on_work_side:
                machine.links[link] = {"side": "work", **machine.links[link]}
            letter, entry = _joint(tree, name, links, set(machine.joints))
            machine.joints[letter] = entry
    if not machine.joints:
        raise tree.error("no component moves: there is no machine in it", tree.root)
    tool = _only(tree, "tool")
    if tool:
        machine.sections["tool"] = _tool(tree, tool, links)
    if work:
        machine.sections["work"] = {"link": links[tree.carrier(work)]}
    _positions(tree, machine)
    pairs = list(_pairs(tree, links, shapes, tool))
    if pairs:
        machine.sections["pairs"] = pairs
    else:
        tree.remarks.append("no collision pairs: every two links are checked, less neighbours")
    machine.remarks = [*tree.remarks, *_left_behind(tree)]
    return machine


def _link_names(tree: MachTree) -> dict[str, str]:
    """Component -> link, for those that move and those that carry everything."""
    seen = {TOOL}
    carriers = [name for name in tree.components if tree.carrier(name) == name]
    return {name: unique(plain_name(name), seen) for name in carriers}


def _only(tree: MachTree, kind: str) -> str | None:
    """The component of a type of which a machine file has one; the first, where there are more."""
    found = tree.of_type(kind)
    if len(found) > 1:
        tree.remarks.append(f"{', '.join(found[1:])}: one {kind} only, and that is {found[0]}")
    if not found:
        tree.remarks.append(f"no component of the type {kind}: write `work` and `tool` yourself")
    return found[0] if found else None


def _bodies(
    tree: MachTree, links: dict[str, str]
) -> tuple[dict[str, list[dict[str, Any]]], ShapesOf]:
    """The parts of every link, and which of them are of which component."""
    parts: dict[str, list[dict[str, Any]]] = {link: [] for link in links.values()}
    taken: dict[str, set[str]] = {link: set() for link in links.values()}
    shapes: ShapesOf = {}
    for name, component in tree.components.items():
        link = links[tree.carrier(name)]
        shapes[name] = []
        for element in component:
            shape = _shape(tree, element)
            if shape is None:
                continue
            at = tree.poses[name].at(*tree.place(element))
            stem = Path(shape["mesh"]).stem if "mesh" in shape else f"{name}_{element.tag.lower()}"
            part = unique(plain_name(stem), taken[link])
            placement = {"translate": list(at.origin), "rotate": list(angles_of(at.turn))}
            placement = {k: v for k, v in placement.items() if any(number(x) != "0" for x in v)}
            shape |= {"placement": placement} if placement else {}
            parts[link].append({"name": part, **shape})
            shapes[name].append((link, part))
    return parts, shapes


def _shape(tree: MachTree, element: Element) -> dict[str, Any] | None:
    """A shape at the origin [mm]; None for what is none, or cannot be carried over."""
    if element.tag == "Poly":
        return _mesh(tree, element)
    if element.tag == "Cylinder":
        radius, height = (tree.size(element, k) for k in ("Radius", "Height"))
        return {"cylinder": {"radius": radius, "height": height, "center": [0, 0, height / 2]}}
    if element.tag == "Block":
        sides = [tree.size(element, k) for k in ("Length", "Width", "Height")]
        return {"box": {"size": sides, "center": [side / 2 for side in sides]}}
    if element.get("Visible") is not None:
        where = f"line {tree.lines[element]}"
        tree.remarks.append(f"<{element.tag}> in {where}: such a shape is not carried over")
    return None


def _mesh(tree: MachTree, element: Element) -> dict[str, Any] | None:
    name = (element.findtext("File") or "").strip()
    file = tree.mesh_file(element)
    unit = element.get("Unit", "millimeter")
    why = ""
    if file is None:
        why = "no such file, neither there nor beside the machine"
    elif element.get("Mirror", "Off").lower() != "off":
        why = "mirrored models are not carried over, mirror the file itself"
    elif unit not in MM:
        why = f"its unit {unit} is not known"
    if why or file is None:
        tree.remarks.append(f"model {name}: {why}")
        return None
    relative = tree.relative(file)
    if relative.startswith("../"):
        tree.remarks.append(f"model {name} lies outside the folder: needs --allow-outside")
    return {"mesh": relative, **({"units": "inch"} if unit == "inch" else {})}


def _joint(
    tree: MachTree, name: str, links: dict[str, str], taken: set[str]
) -> tuple[str, dict[str, Any]]:
    """Name and entry of the joint that moves a component."""
    component = tree.components[name]
    kind, link = MOVING[component.get("Type", "")], component.find("Link")
    if link is None:
        raise tree.error('a component that moves needs <Link Axis="..."/>', component)
    axis = link.get("Axis", "")
    if axis.lstrip("+-") not in DIRECTIONS or len(axis) > 2:
        raise tree.error(f"Axis {axis!r} is none; write X, Y, Z or -X, -Y, -Z", link)
    sign = -1.0 if axis.startswith("-") else 1.0
    pose, above = tree.poses[name], tree.parent(name)
    if not above:
        raise tree.error("a component that moves must be attached to another", component)
    entry: dict[str, Any] = {"type": kind, "parent": links[tree.carrier(above)]}
    direction = sign * pose.turn @ DIRECTIONS[axis.lstrip("+-")]
    entry |= {"child": links[name], "axis": list(direction)}
    entry |= {"point": list(pose.origin)} if kind == "rotary" else {}
    scale = tree.scale if kind == "linear" else 1.0
    limits = _limits(tree, name, link)
    entry |= {"limits": [end * scale for end in limits]} if limits else {}
    speed = tree.number(link, "RapidRate", "0") * scale
    if speed <= 0.0:
        speed = DEFAULT_SPEED[kind]
        tree.remarks.append(f"{name}: no RapidRate, {speed:g} a minute assumed")
    return _letter(tree, name, link, taken), entry | {"rapid": speed}


def _letter(tree: MachTree, name: str, link: Element, taken: set[str]) -> str:
    """Name of a joint: its register, where programs can have it, or else that of the component."""
    register = link.get("Register", "")
    rotary = tree.components[name].get("Type") == "rotary"
    usual = not re.fullmatch("[XYZUVW]" if rotary else "[ABC]", register)
    if (
        usual
        and re.fullmatch(r"[XYZABCUVW]|[A-Za-z][A-Za-z0-9_]+", register)
        and register not in taken
    ):
        return register
    letter = unique(re.sub(r"[^A-Za-z0-9]+", "_", f"axis {name}"), set(taken))
    tree.remarks.append(f"{name}: its register {register!r} is no axis here, so {letter} stands")
    return letter


def _limits(tree: MachTree, name: str, link: Element) -> tuple[float, float] | None:
    """Travel in units of the file, None where it is unlimited."""
    record = link.find("TlRecord")
    if record is None or record.get("TlIgnore", "off") == "on":
        tree.remarks.append(f"{name}: no limits of travel")
        return None
    low, high = (tree.number(record, key) for key in ("TlMin", "TlMax"))
    if low == high == 0.0 or (low <= -UNLIMITED and high >= UNLIMITED):
        return None
    if low >= high:
        raise tree.error(f"TlMin {low:g} must be below TlMax {high:g}", record)
    return low, high


def _tool(tree: MachTree, tool: str, links: dict[str, str]) -> dict[str, Any]:
    """Where tools are carried: at the origin of the tool component, along its Z."""
    pose, link = tree.poses[tool], links[tree.carrier(tool)]
    return {"link": link, "gauge_point": list(pose.origin), "axis": list(pose.turn[:, 2])}


def _positions(tree: MachTree, machine: Imported) -> None:
    """Start, reference point and tool changer from the tables of the file."""
    start = _table(tree, machine, "Initial Machine Location")
    for axis, entry in machine.joints.items():
        low, high = entry.get("limits", (-np.inf, np.inf))
        given = start.get(axis, 0.0)
        start[axis] = min(max(given, low), high)
        if start[axis] != given:
            text = f"{axis}: it stands at {given:g} at first, out of its travel: moved to the limit"
            tree.remarks.append(text)
    machine.sections["start"] = start
    reference = _table(tree, machine, "Machine Reference Location")
    if reference:
        machine.sections["reference"] = {"G28": reference}
    change = _table(tree, machine, "Tool Change Location")
    moved = _table(tree, machine, "Tool Change Retraction")
    change = {axis: value for axis, value in change.items() if moved.get(axis) or not moved}
    if change:
        order = {"retract": ["Z"]} if "Z" in change else {}
        machine.sections["control"] = {"tool_change": {**order, "position": change}}
        tree.remarks.append(
            "Tool Change Location became `tool_change`: that Z goes first is assumed"
        )


def _table(tree: MachTree, machine: Imported, title: str) -> dict[str, float]:
    """The first row of a table as axis -> value, of the axes that the machine has."""
    row = tree.root.find(f"Table[@Name='{title}']/Row")
    values: dict[str, float] = {}
    for axis, element in zip(TABLE_AXES, [] if row is None else row.findall("Value"), strict=False):
        try:
            value = float(element.text or "")
        except ValueError:
            raise tree.error(f"expected a number, not {element.text!r}", element) from None
        if axis in machine.joints:
            scale = tree.scale if machine.joints[axis]["type"] == "linear" else 1.0
            values[axis] = value if title == "Tool Change Retraction" else value * scale
    return values


def _pairs(
    tree: MachTree, links: dict[str, str], shapes: ShapesOf, tool: str | None
) -> Iterator[dict[str, Any]]:
    """Yield the collision pairs of the file, with its near-miss tolerances as clearances."""
    seen: set[frozenset[str]] = set()
    for between in tree.root.findall("Collision/Between"):
        named = [(e.text or "").strip() for e in between.findall("Component")]
        what = " and ".join(named)
        unknown = [name for name in named if name not in tree.components]
        if len(named) != 2 or unknown:
            of = f"{', '.join(unknown)} is of a project" if unknown else "two components needed"
            tree.remarks.append(f"pair {what}: {of}, not carried over")
            continue
        tolerance = tree.number(between, "Tol", "0") * tree.scale
        if tolerance < 0.0:
            raise tree.error(f'Tol="{between.get("Tol")}" must be 0 or more', between)
        sides = [
            _side(tree, name, between.get(key, "off") == "on", links, shapes, tool)
            for name, key in zip(named, ("Sub1", "Sub2"), strict=True)
        ]
        kept = 0
        for one, other in product(*sides):
            joined = _joined(tree, links, one.partition(".")[0], other.partition(".")[0])
            if joined or frozenset((one, other)) in seen:
                continue
            seen.add(frozenset((one, other)))
            kept += 1
            yield {"links": [one, other], **({"clearance": tolerance} if tolerance else {})}
        if not kept:
            text = "they have no shape, are one body or neighbours, or were named before"
            tree.remarks.append(f"pair {what}: {text}")


def _side(
    tree: MachTree,
    name: str,
    with_below: bool,
    links: dict[str, str],
    shapes: ShapesOf,
    tool: str | None,
) -> list[str]:
    """What one side of a pair means: links, and parts where not all of a link is meant."""
    meant = [c for c in tree.components if c == name or (with_below and name in tree.above(c))]
    wanted = [shape for component in meant for shape in shapes[component]]
    found = [TOOL] if tool in meant else []
    for link in links.values():
        whole = [part for of in shapes.values() for where, part in of if where == link]
        some = [part for where, part in wanted if where == link]
        if some and len(some) == len(whole):
            found.append(link)
        else:
            found += [f"{link}.{part}" for part in some]
    return found


def _joined(tree: MachTree, links: dict[str, str], one: str, other: str) -> bool:
    """Two links that one joint joins, or that are one: their guides overlap."""
    of = {link: name for name, link in links.items()}
    if TOOL in (one, other):
        return False
    parent = {a: tree.parent(of[a]) and tree.carrier(tree.parent(of[a])) for a in (one, other)}
    return one == other or parent[one] == of[other] or parent[other] == of[one]


def _left_behind(tree: MachTree) -> Iterator[str]:
    """Yield what is not carried over."""
    for table in tree.root.findall("Table"):
        if table.get("Name") not in TABLES:
            yield f"table {table.get('Name')}: offsets belong to the setup, tools to a tools file"
    if any(link.get("Accel") for link in tree.root.iter("Link")):
        yield "Accel, Decel, MaxLinearVelocity, MaxCornerVelocity: their units are not known"
    off = [e for e in tree.root.iter() if e.get("Visible") == "off" and e.tag != "Component"]
    if off:
        yield f"{len(off)} shapes that VERICUT does not show are part of the machine here"
    for link in tree.root.iter("Link"):
        if link.get("PartSide", "auto") != "auto" or link.get("DisableAuto", "off") != "off":
            yield f"line {tree.lines[link]}: which side an axis is on is taken from the tree"
