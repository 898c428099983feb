"""Loads a machine file with its tools and setup into a Machine, ready to be checked."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gcodesim.machine.bodies import PartReader, longest_travel
from gcodesim.machine.files import find_machine, inside
from gcodesim.machine.mesh_units import unit_findings
from gcodesim.machine.model import Body, Joint, Machine, Part, Tool, ToolMount, ZeroPoint
from gcodesim.machine.pairs import LINK, TOOL, Member, choose_pairs
from gcodesim.machine.placing import WorkFrames
from gcodesim.machine.schema import MachineFile, MountedSpec, offset_number
from gcodesim.machine.setup import Setup, read_setup
from gcodesim.machine.standing import standing_lines
from gcodesim.machine.tools import read_tools
from gcodesim.machine.tree import build_tree, unit_vector
from gcodesim.machine.yaml_lines import YamlFile, read_yaml, suggest
from gcodesim.nc.control.readings import STANDS_FOR, choose_readings

TOOL_PARTS = ("flute", "shank", "holder")

CALL_LETTERS = "GMNOPL"
"""Letters of codes, and of what calls run and how often."""


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
    law, missing = _law_of_time(file, source)
    given = _control_keys(file, joints, source, allow_outside)
    reader = PartReader(source, file.units, allow_outside)
    own = _link_bodies(file, links, reader)
    mount = _tool_mount(file, own, reader)
    job = read_setup(setup)
    _check_setup(job, source.path, [*links, *([mount.name] if mount else [])])
    job_reader = PartReader(job.source, job.file.units, allow_outside)
    start = _start(file, job, joints, source)
    frames = WorkFrames(links, joints, mount, own, _offsets(file, job), start)
    clamped = job.bodies(file.work.link if file.work else None, frames, job_reader)
    table = _tool_table(tools or job.tools, allow_outside)
    members = _members(own.values(), clamped.values(), mount, table)
    chosen = choose_pairs(members, joints, file.pairs, file.allow, source)
    bodies = {**own, **{name: body for name, (body, _) in clamped.items()}}
    read, mounted = [*reader.read, *job_reader.read], mount.mounted if mount else ()
    units = unit_findings(read, list(bodies.values()), mounted, longest_travel(joints))
    return Machine(
        name=file.name,
        path=str(source.path),
        verified=file.verified,
        links=links,
        joints=joints,
        bodies=bodies,
        pairs=chosen.pairs,
        cutting=chosen.cutting,
        tool=mount,
        tools=table,
        allowed=tuple((*spec.links, spec.reason) for spec in file.allow),
        unchecked_by_rule=chosen.unchecked_by_rule
        + (*_shells(bodies.values(), mount), *standing_lines(joints, start), *missing),
        findings=(*reader.findings, *job_reader.findings, *units),
        **_positions(file, job, joints, source),
        start=start,
        offsets=frames.offsets,
        readings=choose_readings("fanuc" if file.dialect == "auto" else file.dialect, given),
        is_dialect_told=file.dialect == "auto",
        unit=file.units if "units" in file.model_fields_set else None,
        given=given,
        path_tolerance=file.path_tolerance.model_dump(),
        time=law,
    )


def _tool_table(path: str | None, allow_outside: bool) -> dict[int, Tool] | None:
    return None if path is None else read_tools(path, allow_outside=allow_outside)


def _control_keys(
    file: MachineFile, joints: Sequence[Joint], source: YamlFile, allow_outside: bool
) -> dict[str, Any]:
    """The keys of `control` that the file gives, its programs by the paths of their files."""
    given = file.control.model_dump(exclude_none=True)
    _find_programs(given, source, allow_outside)
    _check_tool_change(given.get("tool_change"), joints, source)
    _check_ignored_words(given.get("ignore_words", ()), joints, source)
    return given


def _members(
    own: Iterable[Body],
    clamped: Iterable[tuple[Body, str]],
    mount: ToolMount | None,
    table: Mapping[int, Tool] | None,
) -> list[Member]:
    """All bodies as partners of pairs: links, setup, tool."""
    members = [Member(b.name, b.link, LINK, _names(b.parts)) for b in own]
    members += [Member(b.name, b.link, role, _names(b.parts)) for b, role in clamped]
    return members + ([_tool_member(mount, table)] if mount else [])


def _shells(bodies: Iterable[Body], mount: ToolMount | None) -> Iterator[str]:
    """Yield a line for every part that has no inside."""
    named = [(body.name, part) for body in bodies for part in body.parts]
    named += [(mount.name, part) for part in mount.mounted] if mount else []
    for body, part in named:
        if part.shell:
            name = body if part.name == body else f"{body}.{part.name}"
            yield f"{name}: a shell, of which only the surface is checked"


def _law_of_time(file: MachineFile, source: YamlFile) -> tuple[str, tuple[str, ...]]:
    """How speeds change, and for `auto` a line that says which limits are missing, if any.

    Raises:
        ModelError: a joint lacks a limit that the chosen `time` keeps.
    """
    needed = {"acceleration": ("max_acceleration",), "jerk": ("max_acceleration", "max_jerk")}
    lacking = {
        key: [name for name, spec in file.joints.items() if getattr(spec, key) is None]
        for key in needed["jerk"]
    }
    for key in needed.get(file.time, ()):
        for name in lacking[key]:
            text = f"`time: {file.time}` needs `{key}` of every joint, as 5000 of a slide"
            raise source.error(text, "joints", name)
    if file.time != "auto":
        return file.time, ()
    for key, law, how in (
        ("max_acceleration", "constant", "at constant speed"),
        ("max_jerk", "acceleration", "within `max_acceleration`, without a limit of jerk"),
    ):
        if lacking[key]:
            return law, (f"time: blocks run {how}: {', '.join(lacking[key])} without `{key}`",)
    return "jerk", ()


def _check_ignored_words(letters: Iterable[str], joints: Sequence[Joint], source: YamlFile) -> None:
    """A word that moves an axis, or that a call needs, is never left out."""
    for letter in letters:
        if letter in {joint.name for joint in joints}:
            text = f"{letter} is an axis of this machine: its words move it"
            raise source.error(text, "control", "ignore_words")
        if letter in CALL_LETTERS:
            text = f"{letter} says what is run: it belongs to every call or block"
            raise source.error(text, "control", "ignore_words")


def _check_setup(job: Setup, machine: Path, taken: Sequence[str]) -> None:
    """A setup that names a machine is used with that machine only, and no name is given twice."""
    if job.machine is not None and find_machine(job.machine).resolve() != machine.resolve():
        text = f"this setup is for {job.file.machine}, not for {machine}"
        raise job.source.error(text, "machine")
    for name in job.file.bodies:
        if name in taken:
            text = f"the machine already has a body named {name}: choose another name"
            raise job.source.error(text, "bodies", name)


def _link_bodies(file: MachineFile, links: Sequence[str], reader: PartReader) -> dict[str, Body]:
    """The bodies of the links that have a shape, in link order."""
    bodies = {}
    for name in links:
        parts = reader.parts(file.links[name], name, "machine", "links", name)
        if parts:
            bodies[name] = Body(name, name, parts)
    return bodies


def _tool_mount(
    file: MachineFile, bodies: Mapping[str, Body], reader: PartReader
) -> ToolMount | None:
    """Where tools are carried, with the tool that is mounted at the start."""
    spec, source = file.tool, reader.source
    if spec is None:
        return None
    if spec.link not in file.links:
        text = f"unknown link {spec.link!r}; {suggest(spec.link, file.links)}"
        raise source.error(text, "tool", "link")
    mounted = spec.mounted
    name = mounted.name if mounted else "tool"
    if name in file.links:
        text = f"a link is named {name} too: give `mounted` another `name`"
        raise source.error(text, "tool", "mounted", "name")
    if mounted and mounted.flute and mounted.flute > mounted.length:
        text = f"{mounted.flute:g} mm is longer than the tool, whose `length` is {mounted.length:g}"
        raise source.error(text, "tool", "mounted", "flute")
    return ToolMount(
        name=name,
        link=spec.link,
        gauge_point=np.array(spec.gauge_point),
        axis=unit_vector(spec.axis, source, "tool", "axis"),
        mounted=_mounted_parts(mounted, reader) if mounted else (),
        length=mounted.length if mounted else 0.0,
        for_all=mounted is not None and mounted.for_ == "all",
        flute=(mounted and mounted.flute) or 0.0,
    )


def _mounted_parts(mounted: MountedSpec, reader: PartReader) -> tuple[Part, ...]:
    """Parts of the mounted tool. One shape alone counts as flute: it holds the cutting edges."""
    key = ("tool", "mounted")
    if mounted.parts is None:
        return reader.parts(mounted, mounted.name, "flute", *key)
    return tuple(
        reader.part(shape, shape.name, _tool_role(shape.name), *key, "parts", i)
        for i, shape in enumerate(mounted.parts)
    )


def _tool_role(name: str) -> str:
    """Role of a named part of the mounted tool: what is no flute may not touch the part."""
    return name if name in TOOL_PARTS else "holder"


def _names(parts: Sequence[Part]) -> tuple[str, ...]:
    return tuple(part.name for part in parts)


def _tool_member(mount: ToolMount, table: Mapping[int, Tool] | None) -> Member:
    """The tool as a partner of pairs: parts that it has now or may get from the tools file."""
    parts = {part.name: part.role for part in mount.mounted}
    if table is not None:
        parts |= {name: name for name in TOOL_PARTS}
    uncut = tuple(name for name, role in parts.items() if role != "flute")
    flutes = tuple(name for name, role in parts.items() if role == "flute")
    return Member(mount.name, mount.link, TOOL, tuple(parts), uncut, flutes)


def _positions(
    file: MachineFile, job: Setup, joints: Sequence[Joint], source: YamlFile
) -> dict[str, Any]:
    """The fields of Machine that hold positions and variables."""
    work = file.work
    if work is not None and work.link not in file.links:
        text = f"unknown link {work.link!r}; {suggest(work.link, file.links)}"
        raise source.error(text, "work", "link")
    for code, position in file.reference.items():
        _check_axes(position, joints, source, "reference", code)
    return {
        "work_link": work.link if work else None,
        "reference": file.reference,
        "stock_inset": job.file.stock_check.inset,
        "variables": job.file.variables,
    }


def _find_programs(given: dict[str, Any], source: YamlFile, allow_outside: bool) -> None:
    """Let files and folder of programs be named from here, as meshes are."""
    key = "control", "programs"
    for number, name in given.get("programs", {}).items():
        if name not in STANDS_FOR:
            path = inside(source, name, allow_outside, *key, number)
            if not path.is_file():
                text = f"program {path} does not exist; write {', '.join(STANDS_FOR)} or a file"
                raise source.error(text, *key, number)
            given["programs"][number] = str(path)
    if given.get("library"):
        path = inside(source, given["library"], allow_outside, "control", "library")
        if not path.is_dir():
            raise source.error(f"{path} is no folder", "control", "library")
        given["library"] = str(path)


def _check_tool_change(motion: Any, joints: Sequence[Joint], source: YamlFile) -> None:
    """The motion of a tool change, where it is none of its words, names axes of the machine."""
    for key, axes in motion.items() if isinstance(motion, dict) else ():
        if key != "seconds":
            _check_axes(dict.fromkeys(axes, 0.0), joints, source, "control", "tool_change", key)


def _offsets(file: MachineFile, job: Setup) -> dict[int, ZeroPoint]:
    """Work offsets by number: those of the machine file, and the setup's."""
    given = job.offsets(file.work.offsets if file.work else {})
    return {
        offset_number(name): ZeroPoint((o.X, o.Y, o.Z, o.A, o.B, o.C), o.R)
        for name, o in given.items()
    }


def _check_axes(
    position: Mapping[Any, float], joints: Sequence[Joint], source: YamlFile, *key: str
) -> None:
    axes = [joint.name for joint in joints]
    for axis in position:
        if axis not in axes:
            text = f"the machine has no axis {axis}; {suggest(axis, axes)}"
            raise source.error(text, *key, axis)


def _start(
    file: MachineFile, job: Setup, joints: Sequence[Joint], source: YamlFile
) -> dict[str, float]:
    """Start position of every axis, 0 where no file gives one; it must lie within the travel."""
    _check_axes(file.start, joints, source, "start")
    _check_axes(job.file.start, joints, job.source, "start")
    given: dict[str, float] = {**file.start, **job.file.start}
    for joint in joints:
        place = job.source if joint.name in job.file.start else source
        position = given.setdefault(joint.name, 0.0)
        if not joint.lower <= position <= joint.upper:
            text = (
                f"start position {position:g} of axis {joint.name} lies outside its travel: "
                f"give one from {joint.lower:g} to {joint.upper:g}"
            )
            raise place.error(text, "start", joint.name)
    return {joint.name: given[joint.name] for joint in joints}
