"""Loads a machine file with its tools and setup into a Machine, ready to be checked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib.resources import files
from pathlib import Path

import numpy as np

from gcodesim.errors import UsageError
from gcodesim.findings import Finding
from gcodesim.machine.bodies import PartReader, longest_travel
from gcodesim.machine.model import Body, Joint, Machine, Part, Tool, ToolMount, WorkOffset
from gcodesim.machine.pairs import LINK, TOOL, Member, choose_pairs
from gcodesim.machine.schema import (
    DIALECT_KEYS,
    MachineFile,
    Mounted,
    Offset,
    Position,
    SetupFile,
    offset_number,
)
from gcodesim.machine.tools import read_tools
from gcodesim.machine.tree import build_tree, unit_vector
from gcodesim.machine.yaml_lines import YamlFile, read_yaml, suggest

TOOL_PARTS = ("flute", "shank", "holder")


def load_machine(
    path: str, *, tools: str | None = None, setup: str | None = None, allow_outside: bool = False
) -> Machine:
    """A machine, its tools and its setup.

    Args:
        path: machine file, or name of a shipped machine (``table_tilt``).
        tools: tools file or LinuxCNC tool table; left out: the one the setup names, if any.
        setup: setup file.
        allow_outside: mesh files may lie outside the folder of the file that names them.

    Raises:
        UsageError: a file is missing or is no text.
        ModelError: a file is wrong; names file, line and key.
    """
    source = read_yaml(find_machine(path))
    file = source.parse(MachineFile)
    links, joints = build_tree(file, source)
    clamped = _read_setup(setup, source.path)
    tools = tools or clamped.tools
    table = None if tools is None else read_tools(tools, allow_outside=allow_outside)
    reader = PartReader(source, file.units, allow_outside, longest_travel(joints))
    bodies = _link_bodies(file, reader)
    mount = _tool_mount(file, reader, bodies)
    setup_bodies = clamped.bodies(links, [*bodies, *([mount.name] if mount else [])], reader)
    members = _members(bodies, mount, table, setup_bodies)
    pairs = choose_pairs(members, joints, file.pairs, file.allow, source)
    work = file.work
    if work is not None and work.link not in links:
        text = f"unknown link {work.link!r}; {suggest(work.link, links)}"
        raise source.error(text, "work", "link")
    offsets = {**(work.offsets if work else {}), **clamped.file.offsets}
    return Machine(
        name=file.name,
        path=str(source.path),
        verified=file.verified,
        links=links,
        joints=joints,
        bodies={**bodies, **setup_bodies},
        pairs=pairs.pairs,
        tool=mount,
        tools=table,
        work_link=work.link if work else None,
        offsets={offset_number(name): _work_offset(offset) for name, offset in offsets.items()},
        reference=_reference(file, joints, source),
        start=_start(file, clamped, joints, source),
        allowed=tuple((*spec.links, spec.reason) for spec in file.allow),
        unchecked_by_rule=pairs.unchecked_by_rule,
        findings=tuple(reader.findings),
        **_language(file),
    )
