"""A tool library in the making: the data of a tools file, whose tools know where they came from."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from gcodesim.findings.printing import printable
from gcodesim.machine.cutters import cutter
from gcodesim.machine.formats.imported import flow
from gcodesim.machine.tool_schema import FluteSpec
from gcodesim.machine.yaml_lines import YamlFile

ToolData = dict[str, Any]

Made = tuple[str, ToolData | None, str]
"""Type, flute and remark that a foreign tool becomes."""

DECIMALS = 9
"""Of numbers that are converted [mm]: an inch is no round number of them in binary."""


@dataclass
class Library:
    """What was read of a foreign file of tools.

    Attributes:
        path: the file.
        kind: what it is, for people: "Fusion tool library".
        tools: entries as in a tools file.
        lines: the line of each entry in the file.
        remarks: what was not carried over, or had to be assumed.
        offsets: work offsets that it holds too, G54 -> letters.
    """

    path: Path
    kind: str
    tools: list[ToolData] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    offsets: dict[str, dict[str, float]] = field(default_factory=dict)

    def add(self, tool: ToolData, line: int, *, once: bool = False) -> None:
        """Take in a tool; a flute of impossible numbers is left out, so that it is unchecked.

        Args:
            tool: its entry; keys without a value are left out.
            line: where it is in the file.
            once: an equal one that was taken in before is enough.
        """
        entry = {key: rounded(value) for key, value in tool.items() if value not in (None, {}, [])}
        flute = entry.get("flute")
        if flute is not None:
            try:
                cutter(entry.get("type", "mill"), FluteSpec.model_validate(flute))
            except (ValueError, ValidationError) as error:
                entry.pop("flute")
                cause = error.errors()[0]["msg"] if isinstance(error, ValidationError) else error
                self.remark(entry, f"the flute has no shape: {cause}")
        if once and entry in self.tools:
            return
        self.tools.append(entry)
        self.lines.append(line)

    def remark(self, tool: ToolData, text: str) -> None:
        """Note what was not carried over of a tool."""
        name = f" ({tool['name']})" if tool.get("name") else ""
        self.remarks.append(f"T{tool['number']}{name}: {text}")

    def renumber(self, first: int) -> None:
        """Number the tools anew from `first` on, in their order, and the registers like them."""
        for number, tool in enumerate(self.tools, start=first):
            tool["number"] = number

    def add_lengths(self) -> None:
        """Take in a row for every length register that is not the number of its tool."""
        for tool, line in zip(list(self.tools), list(self.lines), strict=True):
            register = tool.pop("length_register", tool["number"])
            if register == tool["number"]:
                continue
            if any(other["number"] == register for other in self.tools):
                self.remark(tool, f"its length is in H{register}, the number of another tool")
                continue
            name = f"length of T{tool['number']}"
            row = {"number": register, "name": name, "length": 0.0, "offset": {"Z": tool["length"]}}
            self.add(row, line)

    @property
    def source(self) -> YamlFile:
        """The library as a tools file whose keys have the lines of the foreign file."""
        lines: dict[tuple[str, ...], int] = {("tools",): 1}
        lines |= {("tools", str(i)): line for i, line in enumerate(self.lines)}
        return YamlFile(self.path, {"tools": self.tools}, lines)

    @property
    def first(self) -> dict[int, ToolData]:
        """The tools by number; of several with one number the first."""
        found: dict[int, ToolData] = {}
        for tool in self.tools:
            found.setdefault(tool["number"], tool)
        return found

    @property
    def all_remarks(self) -> list[str]:
        """What a tools file made of it does not hold, a line each."""
        first = self.first
        twice = [tool for tool in self.tools if first[tool["number"]] is not tool]
        left_out = [f"T{tool['number']} {tool.get('name', '')}".strip() for tool in twice]
        remarks = [f"{name}: left out, an earlier tool has its number" for name in left_out]
        return [one_line(remark) for remark in [*remarks, *self.remarks]]

    @property
    def text(self) -> str:
        """A tools file."""
        first, remarks = self.first, self.all_remarks
        lines = [f"# Made by `gcodesim tool import` from {self.path.name}, a {self.kind}."]
        if remarks:
            lines.append("# Not carried over, or assumed; check every line of it:")
            lines += [f"#   - {remark}" for remark in remarks]
        lines += ["", "tools:" if first else "tools: []"]
        for tool in first.values():
            entries = [f"{key}: {flow(value)}" for key, value in tool.items()]
            lines += [f"  - {entries[0]}", *(f"    {entry}" for entry in entries[1:])]
        if self.offsets:
            lines += ["", "# Work offsets of the same file, for a setup file:", "# offsets:"]
            lines += [f"#   {name}: {flow(value)}" for name, value in self.offsets.items()]
        return "\n".join(lines) + "\n"


def one_line(text: str) -> str:
    """A text that stays within one comment."""
    return printable(" ".join(text.split()))


def rounded(value: Any) -> Any:
    """A value with its numbers rounded to DECIMALS; -0 becomes 0."""
    if isinstance(value, float):
        return round(value, DECIMALS) + 0.0
    if isinstance(value, list | tuple):
        return [rounded(item) for item in value]
    if isinstance(value, dict):
        return {key: rounded(item) for key, item in value.items()}
    return value
