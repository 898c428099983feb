"""A machine file made from a foreign one: its YAML text, with what could not be carried over."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from gcodesim.findings.printing import printable

FileEntry = Mapping[str, Any]

WRITTEN_AS_ZERO = 1e-12
"""Numbers below this are rounding of a turn [mm, deg, or a unit vector's part] and written as 0."""

PLAIN = re.compile(r"[A-Za-z][A-Za-z0-9_./-]*")
"""Text that YAML reads as itself, without quotes."""

WORDS = {"true", "false", "null"}


@dataclass
class Imported:
    """A machine file in the making.

    Attributes:
        name: of the machine.
        origin: the foreign file and what kind it is, for the head.
        settings: keys above the links, as `units`.
        links: link -> its shape; the root first.
        joints: axis letter -> its values, in the order of the tree.
        sections: keys below the joints.
        hints: comment lines at the end.
        remarks: what could not be carried over, or had to be assumed.
    """

    name: str
    origin: str
    settings: dict[str, str] = field(default_factory=dict)
    links: dict[str, FileEntry] = field(default_factory=dict)
    joints: dict[str, FileEntry] = field(default_factory=dict)
    sections: dict[str, FileEntry | list[Any]] = field(default_factory=dict)
    hints: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)

    @property
    def text(self) -> str:
        """The machine file."""
        lines = [f"# Made by `gcodesim machine import` from {self.origin}."]
        if self.remarks:
            lines.append("# Not carried over, or assumed; check every line of it:")
            # On one line each, so that nothing of a foreign file gets out of a comment.
            remarks = (printable(" ".join(remark.split())) for remark in self.remarks)
            lines += [f"#   - {remark}" for remark in remarks]
        lines += ["", f"name: {plain_name(self.name)}"]
        lines.append(
            "verified: false    # the model was not measured on the real machine: reports say so"
        )
        lines += [f"{key}: {value}" for key, value in self.settings.items()]
        lines += ["", "links:", *(f"  {name}: {flow(v)}" for name, v in self.links.items())]
        lines += ["", "joints:", *(f"  {name}: {flow(v)}" for name, v in self.joints.items()), ""]
        for key, value in self.sections.items():
            entries = value if isinstance(value, list) else None
            lines.append(f"{key}:" if entries else f"{key}: {flow(value)}")
            lines += [f"  - {flow(entry)}" for entry in entries or ()]
        return "\n".join([*lines, *(f"# {hint}" for hint in self.hints)]) + "\n"


def flow(value: Any) -> str:
    """A value in YAML's flow style."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key}: {flow(v)}" for key, v in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(flow(v) for v in value) + "]"
    if isinstance(value, str):
        plain = PLAIN.fullmatch(value) and value.lower() not in WORDS
        return value if plain else json.dumps(value, ensure_ascii=False)
    return number(value)


def number(value: float) -> str:
    """The shortest text of a number to 15 digits."""
    return "0" if abs(value) < WRITTEN_AS_ZERO else f"{value:.15g}"


def plain_name(text: str) -> str:
    """A name for a machine, link or part: what is no letter, digit, `-` or `_` becomes `_`."""
    return re.sub(r"[^A-Za-z0-9_-]+", "_", text).strip("_") or "unnamed"


def body_entry(parts: list[dict[str, Any]]) -> dict[str, Any]:
    """The shape of a link: none, one, or several with names that differ."""
    if len(parts) == 1:
        return {key: value for key, value in parts[0].items() if key != "name"}
    seen: set[str] = set()
    named = [part | {"name": unique(part["name"], seen)} for part in parts]
    return {"parts": named} if named else {}


def unique(name: str, seen: set[str]) -> str:
    """The name, with a number after it where it is taken; it is taken from now on."""
    found, count = name, 1
    while found in seen:
        count += 1
        found = f"{name}_{count}"
    seen.add(found)
    return found
