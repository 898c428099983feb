"""The component tree of a VERICUT machine file: who is attached to whom, and where it stands."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path, PureWindowsPath
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import LARGEST_NUMBER
from gcodesim.errors import ModelError
from gcodesim.machine.formats.link_poses import LinkPose
from gcodesim.machine.formats.xml_tree import read_xml
from gcodesim.machine.yaml_lines import suggest

Array = NDArray[np.float64]

MM = {"millimeter": 1.0, "inch": 25.4}
MOVING = {"linear": "linear", "rotary": "rotary"}
"""Type of a component that a joint moves -> type of the joint."""

TOP = LinkPose(np.eye(3), np.zeros(3))
NO_PLACE = {"X": "0", "Y": "0", "Z": "0"}
NO_TURN = {"I": "0", "J": "0", "K": "0"}


@dataclass
class MachTree:
    """The elements of a file with their lines.

    Attributes:
        folder: mesh paths are written relative to it.
        scale: millimetres in a unit of the file.
        components: by name, parents before children.
        poses: where each component stands with every joint at 0 [mm].
        remarks: what could not be carried over.
    """

    path: str
    folder: str
    root: Element
    lines: dict[Element, int]
    scale: float = 1.0
    components: dict[str, Element] = field(default_factory=dict)
    poses: dict[str, LinkPose] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)

    def error(self, message: str, element: Element) -> ModelError:
        """A ModelError at an element."""
        key = " ".join(filter(None, [element.tag, element.get("Name")]))
        return ModelError(message, self.path, self.lines[element], key)

    def number(self, element: Element, name: str, default: str | None = None) -> float:
        """An attribute as a number that is finite, and not too large for a machine file."""
        text = element.get(name, default)
        try:
            value = float(text or "")
        except ValueError:
            value = np.nan
        if not abs(value) * self.scale <= LARGEST_NUMBER:
            raise self.error(f'expected a number as in {name}="1.5", not {text!r}', element)
        return value

    def size(self, element: Element, name: str) -> float:
        """An attribute as a length above 0 [mm]."""
        value = self.number(element, name) * self.scale
        if value <= 0.0:
            raise self.error(f'{name}="{element.get(name)}" must be above 0', element)
        return value

    def parent(self, name: str) -> str:
        """The component that one is attached to, "" for the base."""
        return (self.components[name].findtext("Attach") or "").strip()

    def carrier(self, name: str) -> str:
        """The component nearest to the base that moves with one: itself, or what carries it."""
        while self.components[name].get("Type") not in MOVING and self.parent(name):
            name = self.parent(name)
        return name

    def above(self, name: str) -> list[str]:
        """A component and all that carry it, the base last."""
        chain = [name]
        while self.parent(chain[-1]):
            chain.append(self.parent(chain[-1]))
        return chain

    def of_type(self, kind: str) -> list[str]:
        """Names of the components of one type."""
        return [name for name, element in self.components.items() if element.get("Type") == kind]

    def place(self, element: Element) -> tuple[Array, Array]:
        """Position [mm] and turns about fixed X, Y, Z [rad] of a component or model."""
        at, turn = element.find("Position"), element.find("Rotation")
        at = element if at is None else at
        turn = element if turn is None else turn
        xyz = [self.number(at, key, "0" if at is element else None) for key in NO_PLACE]
        ijk = [self.number(turn, key, "0" if turn is element else None) for key in NO_TURN]
        return np.array(xyz) * self.scale, np.radians(ijk)

    def mesh_file(self, element: Element) -> Path | None:
        """The file of a model, beside the machine file where its own folder is of another place."""
        name = PureWindowsPath((element.findtext("File") or "").strip())
        here = Path(self.path).parent
        for candidate in (Path(str(name).replace("\\", "/")), here / name.name):
            if name.name and candidate.is_file():
                return candidate
        same = name.name.lower()
        return next((f for f in sorted(here.iterdir()) if same and f.name.lower() == same), None)

    def relative(self, file: Path) -> str:
        """The path of a mesh for the machine file."""
        return Path(os.path.relpath(file, self.folder)).as_posix()


def read_mach(path: str, folder: str) -> MachTree:
    """The tree of a VERICUT machine file; names the line of what is wrong.

    Raises:
        UsageError: the file cannot be read.
        ModelError: it is none, or its components form no tree.
    """
    _refuse_text_format(path)
    root, lines = read_xml(path)
    tree = MachTree(path, folder, root, lines)
    if root.tag != "VcMachine":
        text = "expected <VcMachine> as the outermost element, as VERICUT 7 and later write it"
        raise tree.error(text, root)
    unit = root.get("Unit", "millimeter")
    if unit not in MM:
        raise tree.error(f"unknown Unit {unit!r}; {suggest(unit, MM)}", root)
    tree.scale = MM[unit]
    waiting = _named(tree)
    while waiting:
        ready = [n for n, (_, parent) in waiting.items() if not parent or parent in tree.components]
        if not ready:
            element, parent = next(iter(waiting.values()))
            raise tree.error(f"attached to {parent!r}, which leads back to itself", element)
        for name in ready:
            element, parent = waiting.pop(name)
            tree.components[name] = element
            tree.poses[name] = tree.poses.get(parent, TOP).at(*tree.place(element))
    return tree


def _refuse_text_format(path: str) -> None:
    try:
        with open(path, "rb") as file:
            begins = file.read(64).lstrip()
    except OSError:
        return  # the reader of XML says why
    if begins.startswith(b"CGTech"):
        text = "the text format of VERICUT 6 is not read: save the machine with VERICUT 7 or later"
        raise ModelError(text, path, 1)


def _named(tree: MachTree) -> dict[str, tuple[Element, str]]:
    """The components by name, with what they are attached to."""
    found: dict[str, tuple[Element, str]] = {}
    for element in tree.root.findall("Component"):
        name = element.get("Name", "")
        if not name:
            raise tree.error('a component needs Name="..."', element)
        if name in found:
            raise tree.error(f"there is a second component {name!r}", element)
        found[name] = element, (element.findtext("Attach") or "").strip()
    if not found:
        raise tree.error("there is no <Component> in it", tree.root)
    for element, parent in found.values():
        if parent and parent not in found:
            text = f"attached to {parent!r}, which is no component; {suggest(parent, found)}"
            raise tree.error(text, element)
    return found
