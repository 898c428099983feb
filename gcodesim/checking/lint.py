"""What is wrong with a machine, its tools and its setup, before any program runs on it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path as FilePath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gcodesim.collision.bodies.scene import Scene, build_scene, is_present
from gcodesim.collision.bounds.leave_out import reach_distance
from gcodesim.collision.geometry.poses import PathArrays, joints_between, path_arrays
from gcodesim.collision.instants.containment import find_containments
from gcodesim.collision.instants.posed_pair import pose_pair
from gcodesim.constants import DEFAULT_PERIOD_PS, TOLERANCE_MM
from gcodesim.findings.codes import CONTAINMENT_UNDECIDED, Finding
from gcodesim.machine.kinematics import world_from_link
from gcodesim.machine.model import Machine, Pair
from gcodesim.machine.spindle import bodies_in_place
from gcodesim.machine.tool_centre import ToolCentre, tool_centre
from gcodesim.machine.yaml_lines import YamlFile, read_yaml
from gcodesim.motion.path import ARC_PIECE, CONSTANT_SPEED, Path

DEVICE = "cpu"
"""Two poses are looked at: not worth the start of a GPU."""


def lint(machine: Machine) -> tuple[Finding, ...]:
    """Everything there is to say about a machine that could be loaded.

    Errors: every program that goes there fails. Warnings: a question that a program may raise
    cannot be answered, or the model contradicts itself. Notes: worth knowing.
    """
    source = read_yaml(FilePath(machine.path))
    found = [
        *machine.findings,
        *_travels(machine, source),
        *_references(machine, source),
        *_kinematics(machine, source),
        *_missing(machine, source),
        *_shapeless_tools(machine),
        *_unpaired(machine, source),
    ]
    bodies = bodies_in_place(machine, None)
    pairs = tuple(pair for pair in machine.pairs if is_present(pair, bodies))
    if pairs:
        scene = build_scene(pairs, bodies, machine.joints, DEVICE)
        found += _contacts_at_rest(machine, source, scene)
        found += _pairs_apart(machine, source, scene)
    return tuple(found)


def _place(source: YamlFile, *key: str) -> dict[str, Any]:
    """File and line of a key, or of the nearest key above it, as fields of a finding."""
    return {"file": str(source.path), "line": source.line(key)}


def _pair_place(source: YamlFile, pair: Pair) -> dict[str, Any]:
    """Where a pair is named, or else the first of its bodies that the machine file holds."""
    for index, entry in enumerate(source.data.get("pairs") or ()):
        links = entry["links"] if isinstance(entry, dict) else entry
        if {name.partition(".")[0] for name in links} == {pair.a, pair.b}:
            return _place(source, "pairs", str(index))
    own = [("links", name) for name in (pair.a, pair.b) if name in source.data["links"]]
    return _place(source, *(own[0] if own else ()))


def _travels(machine: Machine, source: YamlFile) -> Iterator[Finding]:
    """Yield slides without limits, and travels that leave out the zero pose."""
    for joint in machine.joints:
        place = _place(source, "joints", joint.name, "limits")
        if not joint.rotary and math.isinf(joint.upper - joint.lower):
            text = f"{joint.name} has no limits, so that overtravel is not seen"
            yield Finding("GC430", text, "travel_unlimited", **place)
        if not joint.lower <= 0.0 <= joint.upper:
            text = (
                f"{joint.name} = 0, where the shapes are drawn, lies outside its travel "
                f"{joint.lower:g} to {joint.upper:g}: the machine never stands at the zero pose"
            )
            yield Finding("GC430", text, "zero_out_of_travel", **place)


def _references(machine: Machine, source: YamlFile) -> Iterator[Finding]:
    """Yield reference positions that the machine cannot go to."""
    joints = {joint.name: joint for joint in machine.joints}
    for code, position in machine.reference.items():
        for name, value in position.items():
            joint = joints[name]
            if not joint.lower <= value <= joint.upper:
                text = (
                    f"{code} sends {name} to {value:g}, outside its travel "
                    f"{joint.lower:g} to {joint.upper:g}"
                )
                place = _place(source, "reference", code, name)
                kind = "GC302" if joint.rotary else "GC301"
                yield Finding(kind, text, "reference_out_of_travel", **place)


def _kinematics(machine: Machine, source: YamlFile) -> Iterator[Finding]:
    """Yield why tool centre point control cannot run on a machine with rotary axes."""
    if not any(joint.rotary for joint in machine.joints):
        return
    absent = [key for key in ("tool", "work") if source.data.get(key) is None]
    if absent:
        text = f"no `{'` and no `'.join(absent)}`: G43.4 and tilted planes need both links"
        yield Finding("GC430", text, "tool_centre_unsolved", **_place(source), severity="warning")
        return
    refusal = _refusal(tool_centre(machine))
    if refusal:
        text = f"G43.4 and tilted planes cannot be followed: {refusal}"
        place = _place(source, "joints")
        yield Finding("GC430", text, "tool_centre_unsolved", **place, severity="warning")


def _refusal(centre: ToolCentre | None) -> str:
    if centre is None:
        return "no rotary axis stands between the work and the tool"
    return centre.refusal


def _missing(machine: Machine, source: YamlFile) -> Iterator[Finding]:
    """Yield what the file leaves open."""
    if not machine.verified:
        text = (
            "the model was not measured on the real machine: reports say so until `verified: true`"
        )
        yield Finding("GC430", text, "model_unverified", **_place(source, "verified"))
    unknown = [name for name, value in machine.path_tolerance.items() if value is None]
    if unknown:
        text = f"no path_tolerance for {' and '.join(unknown)}: the exact path is assumed"
        yield Finding("GC430", text, "path_tolerance_missing", **_place(source, "path_tolerance"))
    if machine.tool and not machine.tool.for_all and machine.tools is None:
        text = "no tool stands for every T number (`for: all`): T words need --tools"
        yield Finding("GC430", text, "tools_missing", **_place(source, "tool", "mounted"))
    if not machine.offsets:
        text = "no work offset: G54 needs `work: {offsets: ...}` or --setup"
        yield Finding("GC430", text, "offsets_missing", **_place(source, "work"))


def _shapeless_tools(machine: Machine) -> Iterator[Finding]:
    """Yield tools of the tools file that would leave something unchecked."""
    for number, tool in sorted((machine.tools or {}).items()):
        if not tool.parts:
            text = f"tool {number} has no shape: nothing is checked while it is in the spindle"
            yield Finding("GC421", text, "tool_without_shape", tool=number)
        elif tool.unchecked:
            text = f"tool {number} has no shape for its {', '.join(tool.unchecked)}: not checked"
            yield Finding("GC421", text, "tool_part_without_shape", tool=number)


def _unpaired(machine: Machine, source: YamlFile) -> Iterator[Finding]:
    """Yield bodies that nothing is checked against."""
    if not machine.pairs:
        text = "no two bodies are paired: nothing would be checked, and nothing could PASS"
        place = _place(source, "pairs")
        yield Finding("GC430", text, "pairs_missing", **place, severity="warning")
        return
    paired = {name for pair in machine.pairs for name in (pair.a, pair.b)}
    for name in machine.bodies:
        if name not in paired:
            text = f"{name} is in no pair: nothing sees what touches it"
            yield Finding("GC430", text, "body_unpaired", **_place(source, "links", name))


def _contacts_at_rest(machine: Machine, source: YamlFile, scene: Scene) -> Iterator[Finding]:
    """Yield checked pairs that touch, or hold one another, at the start or at the zero pose.

    At the start every program fails: an error. At the zero pose the drawing is at fault.
    """
    start = np.array([machine.start[name] for name in machine.axes])
    poses = {"at the start position": (start, "error")}
    if start.any() and all(joint.lower <= 0.0 <= joint.upper for joint in machine.joints):
        poses["at the zero pose"] = (np.zeros(len(start)), "warning")
    arrays = path_arrays(_standing(machine, [q for q, _ in poses.values()]), DEVICE)
    for piece, (where, (q, severity)) in enumerate(poses.items()):
        touching = dict(_touching(scene, arrays, piece))
        for index, parts in touching.items():
            pair = scene.pairs[index]
            text = f"{_named(pair.a, parts[0])} touches {_named(pair.b, parts[1])} {where}"
            place = _pair_place(source, pair)
            names = (pair.a, pair.b)
            yield Finding("GC502", text, "rest", **place, pair=names, severity=severity)
        for found in _containments(machine, source, scene, q, where, severity):
            if found.pair not in {(scene.pairs[i].a, scene.pairs[i].b) for i in touching}:
                yield found


def _touching(
    scene: Scene, arrays: PathArrays, piece: int
) -> Iterator[tuple[int, tuple[str, str]]]:
    """Yield the pairs whose surfaces touch on a piece that stands still, with their parts."""
    for index, (a, b) in enumerate(scene.shapes):
        posed = pose_pair(scene, arrays, index, piece, piece * DEFAULT_PERIOD_PS)
        rows = posed.touching()
        if rows:
            of_a, of_b = posed.numbers(*rows)
            yield index, (a.find_triangle(of_a)[0].name, b.find_triangle(of_b)[0].name)


def _containments(
    machine: Machine,
    source: YamlFile,
    scene: Scene,
    q: NDArray[np.float64],
    where: str,
    severity: str,
) -> Iterator[Finding]:
    """Yield bodies wholly inside another, and where an open mesh hides whether they are."""
    world = world_from_link(machine, q)
    relative = [np.linalg.inv(world[a]) @ world[b] for a, b in scene.links]
    for found in find_containments(scene, relative):
        pair = scene.pairs[found.pair]
        place, names = _pair_place(source, pair), (pair.a, pair.b)
        a, b = (_named(n, part) for n, part in zip(names, found.parts, strict=True))
        if found.decided:
            text = f"{a} is inside, or around, {b} {where}"
            yield Finding("GC502", text, "rest", **place, pair=names, severity=severity)
        else:
            outer, inner = (a, b) if found.outer_is_a else (b, a)
            text = f"{outer} is an open mesh: whether it encloses {inner} {where} is undecidable"
            yield Finding("GC501", text, CONTAINMENT_UNDECIDED, **place, pair=names)


def _standing(machine: Machine, poses: list[NDArray[np.float64]]) -> Path:
    """A path that stands at each pose for one piece."""
    q, n = np.array(poses), len(poses)
    return Path(
        q0=q,
        q1=q,
        law=np.tile(CONSTANT_SPEED, (n, 1)),
        arc=np.full(n, -1, np.int32),
        arcs=np.zeros(0, ARC_PIECE),
        xyz=(-1, -1, -1),
        joints=machine.axes,
        bounds_ps=np.arange(n + 1, dtype=np.int64) * DEFAULT_PERIOD_PS,
        line=np.zeros(n, np.int32),
    )


def _pairs_apart(machine: Machine, source: YamlFile, scene: Scene) -> Iterator[Finding]:
    """Yield pairs that cannot meet, wherever the axes stand within their travels."""
    # Of several tools another one may reach farther than the one in the spindle.
    changing = machine.tool.name if machine.tool and machine.tools is not None else ""
    for index, (pair, links) in enumerate(zip(scene.pairs, scene.links, strict=True)):
        if changing in (pair.a, pair.b):
            continue
        chain = [machine.joints[column] for column, _ in joints_between(machine.joints, *links)]
        if any(not j.rotary and math.isinf(j.upper - j.lower) for j in chain):
            continue
        apart = reach_distance(scene, machine.joints, index)
        if apart > pair.clearance + TOLERANCE_MM:
            text = f"{pair.a} and {pair.b} stay at least {apart:.4g} mm apart: the pair never meets"
            place = _pair_place(source, pair)
            yield Finding("GC430", text, "pair_out_of_reach", **place, pair=(pair.a, pair.b))


def _named(body: str, part: str) -> str:
    return body if body == part else f"{body}.{part}"
