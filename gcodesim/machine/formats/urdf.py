"""Turns a URDF robot description into a machine file: links, joints and shapes at the zero pose.

URDF gives every link a frame of its own, in metres and radians; a machine file has one frame, the
world at the zero pose, in millimetres and degrees. Links joined by fixed joints become one.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from gcodesim.errors import ModelError
from gcodesim.machine.formats.imported import (
    Imported,
    body_entry,
    number,
    plain_name,
    unique,
)
from gcodesim.machine.formats.link_poses import LinkPose, angles_of
from gcodesim.machine.formats.xml_tree import read_xml

Array = NDArray[np.float64]

MM_PER_M = 1000.0
UNITS = {1.0: "m", 0.001: "mm", 0.0254: "inch"}
"""Scale of a mesh in URDF, from its numbers to metres -> unit of a machine file."""

MESHES = {".stl", ".obj", ".ply", ".off"}
"""Formats that are read without further packages."""

MOVING = {"revolute": True, "continuous": True, "prismatic": False}
"""Type of a moving joint -> it is rotary."""

DEFAULT_SPEED = {False: 10_000.0, True: 3600.0}
"""Rapid rate where the file gives none [mm/min, deg/min]."""

DROPPED = {"dynamics", "safety_controller", "calibration", "mimic", "transmission", "gazebo"}

SPHERE_STEP = 15.0
"""Turn [deg] between two tangents of the outline around a sphere."""


@dataclass
class Document:
    """The element tree of a file, with the line of every element.

    Attributes:
        folder: mesh paths are written relative to it.
    """

    path: str
    folder: str
    root: Element
    lines: dict[Element, int]
    remarks: list[str] = field(default_factory=list)

    def error(self, message: str, element: Element) -> ModelError:
        """A ModelError at an element."""
        key = " ".join(filter(None, [element.tag, element.get("name")]))
        return ModelError(message, self.path, self.lines[element], key)

    def attribute(self, element: Element, name: str) -> str:
        """An attribute that must be there."""
        text = element.get(name)
        if not text:
            raise self.error(f'<{element.tag}> needs {name}="..."', element)
        return text

    def numbers(self, element: Element, name: str, default: str) -> Array:
        """An attribute as finite numbers, as many as the default has."""
        text = element.get(name, default)
        try:
            found = np.array([float(word) for word in text.split()])
        except ValueError:
            found = np.zeros(0)
        if len(found) != len(default.split()) or not np.isfinite(found).all():
            wanted = f'{name}="{default}"'
            raise self.error(f"expected numbers as in {wanted}, not {text!r}", element)
        return found

    def link_of(self, joint: Element, side: str) -> str:
        """Name of the parent or child link of a joint."""
        child = joint.find(side)
        if child is None:
            raise self.error(f'a joint needs <{side} link="..."/>', joint)
        return self.attribute(child, "link")


def import_urdf(path: str, folder: str) -> Imported:
    """The machine of a URDF file.

    Args:
        path: the file.
        folder: where the machine file will lie; mesh paths are written relative to it.

    Raises:
        UsageError: the file cannot be read.
        ModelError: it is no URDF, or holds what no machine file can say; names the line.
    """
    document = read_urdf(path, folder)
    links, joints = _named(document)
    root = _root(document, links, joints)
    name = document.root.get("name") or Path(path).stem
    machine = Imported(name, f"{Path(path).name} (URDF)")
    letters = _letters(document, _poses(document, root, joints), joints)
    shapes: dict[str, list[dict[str, Any]]] = {}
    body_of = {root: plain_name(root)}
    seen = set(body_of.values())
    for link, frame, joint in _poses(document, root, joints):
        if joint is not None:
            parent = body_of[document.link_of(joint, "parent")]
            if joint.get("type") == "fixed":
                body_of[link] = parent
            else:
                body_of[link] = unique(plain_name(link), seen)
                entry = _joint(document, joint, frame, parent, body_of[link])
                machine.joints[letters[joint]] = entry
        shapes.setdefault(body_of[link], []).extend(_shapes(document, links[link], frame))
    if not machine.joints:
        raise document.error("no joint moves: there is no machine in it", document.root)
    machine.settings["units"] = _unit_of_meshes(document, shapes)
    machine.links = {body: body_entry(parts) for body, parts in shapes.items()}
    machine.sections["start"] = _start(document, machine)
    machine.remarks = [*document.remarks, *_left_behind(document, joints)]
    last = next(reversed(machine.links))
    machine.hints = [
        "To be added: where tools are carried, and what carries the work piece, as in",
        f"tool: {{link: {last}, gauge_point: [0, 0, 0], axis: [0, 0, 1]}}",
        f"work: {{link: {body_of[root]}, offsets: {{G54: {{X: 0, Y: 0, Z: 0}}}}}}",
    ]
    return machine


def read_urdf(path: str, folder: str) -> Document:
    """Parse the XML, refusing entities; UsageError or ModelError when that cannot be done."""
    root, lines = read_xml(path)
    document = Document(path, folder, root, lines)
    macro = next((e for e in root.iter() if str(e.tag).startswith("xacro:")), None)
    if macro is not None:
        raise document.error("macros are not expanded here: run xacro first", macro)
    if root.tag != "robot":
        raise document.error("expected <robot> as the outermost element", root)
    return document


def _named(document: Document) -> tuple[dict[str, Element], list[Element]]:
    """Links by name, and the joints; both ends of every joint are links."""
    links: dict[str, Element] = {}
    for link in document.root.findall("link"):
        name = document.attribute(link, "name")
        if name in links:
            raise document.error(f"there is a second link {name!r}", link)
        links[name] = link
    joints = document.root.findall("joint")
    for joint in joints:
        kind = joint.get("type", "")
        if kind not in MOVING and kind != "fixed":
            valid = ", ".join([*MOVING, "fixed"])
            raise document.error(f"joint type {kind!r} cannot be turned; valid: {valid}", joint)
        for side in ("parent", "child"):
            name = document.link_of(joint, side)
            if name not in links:
                raise document.error(f"{side} {name!r} is no link of this file", joint)
    return links, joints


def _root(document: Document, links: dict[str, Element], joints: list[Element]) -> str:
    """The link that no joint moves; every other link hangs on exactly one joint."""
    children: set[str] = set()
    for joint in joints:
        child = document.link_of(joint, "child")
        if child in children:
            raise document.error(f"link {child!r} hangs on two joints: one parent only", joint)
        children.add(child)
    roots = [name for name in links if name not in children]
    if len(roots) != 1:
        reason = f"found {', '.join(roots)}" if roots else "the joints form a cycle"
        raise document.error(f"exactly one link must have no parent; {reason}", document.root)
    reached = {link for link, _, _ in _poses(document, roots[0], joints)}
    apart = next((name for name in links if name not in reached), None)
    if apart is not None:
        raise document.error("its joints form a cycle, apart from the root", links[apart])
    return roots[0]


def _poses(
    document: Document, root: str, joints: list[Element]
) -> Iterator[tuple[str, LinkPose, Element | None]]:
    """Yield every link with its frame and the joint it hangs on, parents first."""
    waiting: list[tuple[str, LinkPose, Element | None]] = [
        (root, LinkPose(np.eye(3), np.zeros(3)), None)
    ]
    while waiting:
        link, frame, joint = waiting.pop(0)
        yield link, frame, joint
        for below in joints:
            if document.link_of(below, "parent") == link:
                at = frame.at(*_origin(document, below))
                waiting.append((document.link_of(below, "child"), at, below))


def _origin(document: Document, element: Element) -> tuple[Array, Array]:
    """The <origin> of an element: xyz [m] and rpy [rad], zero where it has none."""
    origin = element.find("origin")
    if origin is None:
        return np.zeros(3), np.zeros(3)
    return document.numbers(origin, "xyz", "0 0 0"), document.numbers(origin, "rpy", "0 0 0")


def _axis(document: Document, joint: Element, frame: LinkPose) -> Array:
    """Direction of a moving joint in the world, a unit vector."""
    given = joint.find("axis")
    vector = np.array([1.0, 0, 0]) if given is None else document.numbers(given, "xyz", "0 0 1")
    length = float(np.linalg.norm(vector))
    if length == 0.0:
        raise document.error("an axis of length 0 has no direction", joint)
    return np.asarray(frame.turn @ (vector / length))


def _letters(
    document: Document, poses: Iterator[tuple[str, LinkPose, Element | None]], joints: list[Element]
) -> dict[Element, str]:
    """Axis letter of every moving joint: of its name, else of its main direction, else the next."""
    moving = [(j, f) for _, f, j in poses if j is not None and j.get("type") != "fixed"]
    letters: dict[Element, str] = {}
    for joint, _ in moving:
        rotary = MOVING[joint.get("type", "")]
        name = re.fullmatch(
            r"(?:joint|axis)?[_-]?([a-z])[_-]?(?:joint|axis)?", joint.get("name", "").lower()
        )
        letter = name[1].upper() if name else ""
        if letter and letter in ("ABC" if rotary else "XYZUVW") and letter not in letters.values():
            letters[joint] = letter
    for joint, frame in moving:
        if joint in letters:
            continue
        order = np.argsort(-np.abs(_axis(document, joint, frame)), kind="stable")
        family = "ABC" if MOVING[joint.get("type", "")] else "XYZ"
        free = [family[i] for i in order if family[i] not in letters.values()]
        if free:
            remark = f"joint {joint.get('name')} became the axis {free[0]}: rename it"
        else:
            words = re.sub(r"[^A-Za-z0-9]+", "_", f"axis {joint.get('name')}")
            free = [unique(words, set(letters.values()))]
            remark = f"joint {joint.get('name')} became {free[0]}, which stands at its `start`"
        letters[joint] = free[0]
        document.remarks.append(remark)
    return letters


def _joint(
    document: Document, joint: Element, frame: LinkPose, parent: str, child: str
) -> dict[str, Any]:
    """The entry of a moving joint."""
    kind, name = joint.get("type", ""), joint.get("name")
    rotary = MOVING[kind]
    scale = math.degrees(1.0) if rotary else MM_PER_M
    entry: dict[str, Any] = {"type": "rotary" if rotary else "linear", "parent": parent}
    entry |= {"child": child, "axis": list(_axis(document, joint, frame))}
    entry |= {"point": list(frame.origin * MM_PER_M)} if rotary else {}
    limit = joint.find("limit")
    if kind != "continuous":
        if limit is None:
            raise document.error(f'a {kind} joint needs <limit lower="..." upper="..."/>', joint)
        low, high = (float(document.numbers(limit, k, "0")[0]) for k in ("lower", "upper"))
        if low >= high:
            text = f"lower {low:g} must be below upper {high:g}; make a joint that stands fixed"
            raise document.error(text, limit)
        entry["limits"] = [low * scale, high * scale]
    speed = 0.0 if limit is None else float(document.numbers(limit, "velocity", "0")[0])
    entry["rapid"] = speed * scale * 60.0
    if speed <= 0.0:
        entry["rapid"] = DEFAULT_SPEED[rotary]
        unit = "deg/min" if rotary else "mm/min"
        text = f"joint {name}: no velocity, rapid {entry['rapid']:g} {unit} assumed"
        document.remarks.append(text)
    return entry


def _shapes(document: Document, link: Element, frame: LinkPose) -> list[dict[str, Any]]:
    """The parts of a link in the world: its collision shapes, or else the visible ones."""
    kind = "collision" if link.find("collision") is not None else "visual"
    parts = []
    for element in link.findall(kind):
        geometry = element.find("geometry")
        if geometry is None or not len(geometry):
            raise document.error(f"<{kind}> needs a <geometry> with a shape", element)
        shape = _shape(document, geometry[0])
        if shape is None:
            continue
        at = frame.at(*_origin(document, element))
        placement = {"translate": list(at.origin * MM_PER_M), "rotate": list(angles_of(at.turn))}
        placement = {key: v for key, v in placement.items() if any(number(x) != "0" for x in v)}
        shape |= {"placement": placement} if placement else {}
        parts.append({"name": plain_name(element.get("name") or str(link.get("name"))), **shape})
    return parts


def _shape(document: Document, element: Element) -> dict[str, Any] | None:
    """A shape at the origin [mm]; None, and a remark, for one that cannot be carried over."""
    if element.tag == "mesh":
        return _mesh(document, element)
    if element.tag not in ("box", "cylinder", "sphere"):
        raise document.error("expected box, cylinder, sphere or mesh", element)
    keys = {"box": ["size"], "cylinder": ["radius", "length"], "sphere": ["radius"]}[element.tag]
    for key in keys:
        document.attribute(element, key)
    sizes = [document.numbers(element, k, "1 1 1" if k == "size" else "1") for k in keys]
    if min(size.min() for size in sizes) <= 0.0:
        raise document.error("sizes must be above 0", element)
    mm = [list(size * MM_PER_M) for size in sizes]
    if element.tag == "box":
        return {"box": {"size": mm[0]}}
    if element.tag == "cylinder":
        return {"cylinder": {"radius": mm[0][0], "height": mm[1][0]}}
    return {"revolve": _around_sphere(mm[0][0])}


def _around_sphere(radius: float) -> list[list[float]]:
    """Outline [r, z] of tangents to a sphere: never smaller than it."""
    corner = radius / math.cos(math.radians(SPHERE_STEP / 2.0))
    angles = np.radians(np.arange(-90.0 + SPHERE_STEP / 2.0, 90.0, SPHERE_STEP))
    return [[corner * math.cos(a), corner * math.sin(a)] for a in angles]


def _mesh(document: Document, element: Element) -> dict[str, Any] | None:
    name = document.attribute(element, "filename")
    scale = document.numbers(element, "scale", "1 1 1")
    file = _mesh_file(Path(document.path).parent, name)
    why = ""
    if file is None:
        why = "no such file"
    elif file.suffix.lower() not in MESHES:
        why = f"{file.suffix or 'such a format'} is not read, convert it to STL"
    elif not (scale == scale[0]).all() or float(scale[0]) not in UNITS:
        why = f"scale {element.get('scale')} is neither m, mm nor inch, scale the file itself"
    if why or file is None:
        document.remarks.append(f"mesh {name}: {why}")
        return None
    relative = Path(os.path.relpath(file, document.folder)).as_posix()
    if relative.startswith("../"):
        document.remarks.append(f"mesh {name} lies outside the folder: needs --allow-outside")
    return {"mesh": relative, "scale": float(scale[0])}


def _mesh_file(folder: Path, name: str) -> Path | None:
    """The file of a mesh: beside the URDF, or in a package of that name above it."""
    plain = name.removeprefix("file://")
    package = re.fullmatch(r"package://([^/]+)/(.+)", name)
    candidates = [folder / plain]
    if package:
        above = [folder, *folder.resolve().parents]
        candidates = [place / package[1] / package[2] for place in above]
        candidates += [place / package[2] for place in above if place.name == package[1]]
        candidates.append(folder / package[2])
    return next((file for file in candidates if file.is_file()), None)


def _unit_of_meshes(document: Document, shapes: dict[str, list[dict[str, Any]]]) -> str:
    """The unit of most meshes; those of another unit are taken out, for a file has one unit."""
    meshes = [part for parts in shapes.values() for part in parts if "mesh" in part]
    scales = [float(part.pop("scale")) for part in meshes]
    usual = max(UNITS, key=scales.count)
    strange = {id(part): s for part, s in zip(meshes, scales, strict=True) if s != usual}
    for parts in shapes.values():
        for part in [part for part in parts if id(part) in strange]:
            text = f"mesh {part['mesh']} is in {UNITS[strange[id(part)]]}, others in {UNITS[usual]}"
            document.remarks.append(f"{text}: convert it")
            parts.remove(part)
    return UNITS[usual] if meshes else "mm"


def _start(document: Document, machine: Imported) -> dict[str, float]:
    """The zero pose, or what is nearest to it within the travel."""
    start = {}
    for letter, entry in machine.joints.items():
        low, high = entry.get("limits", (0.0, 0.0))
        start[letter] = min(max(0.0, low), high)
        if start[letter]:
            document.remarks.append(f"{letter} cannot stand at 0: it starts at the limit")
    return start


def _left_behind(document: Document, joints: list[Element]) -> Iterator[str]:
    """Yield what a machine file has no place for."""
    yield "tool and work: URDF does not say where they are; see the end of the file"
    found = {str(element.tag) for element in document.root.iter()} & DROPPED
    if found:
        yield f"<{'>, <'.join(sorted(found))}> are not carried over"
    if any(joint.find("mimic") is not None for joint in joints):
        yield "<mimic>: such a joint follows another one there, and is an axis of its own here"
