"""The animated model: the machine and its motion as binary glTF 2.0, for other viewers."""

from __future__ import annotations

import json
import math
import struct
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gcodesim.checking.replay import Replay, Shown, indexed

if TYPE_CHECKING:
    from gcodesim.machine.model import Joint

Floats = NDArray[np.float64]

FLOAT, UINT = 5126, 5125
VERTICES, INDICES = 34962, 34963
KINDS = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}
"""Constants of glTF 2.0, section 3.6."""

LARGEST_TURN = 90.0
"""Largest turn from key to key [deg]: viewers take the shorter way round beyond 180."""

COLORS = {
    "machine": (0.55, 0.60, 0.64),
    "flute": (0.75, 0.46, 0.03),
    "shank": (0.48, 0.48, 0.44),
    "holder": (0.12, 0.13, 0.14),
    "fixture": (0.53, 0.26, 0.10),
    "part": (0.19, 0.41, 0.15),
    "stock": (0.38, 0.56, 0.33),
}
"""Role of a part -> colour, linear RGB."""


@dataclass
class Model:
    """A glTF document under construction."""

    nodes: list[dict[str, Any]] = field(default_factory=list)
    meshes: list[dict[str, Any]] = field(default_factory=list)
    accessors: list[dict[str, Any]] = field(default_factory=list)
    views: list[dict[str, Any]] = field(default_factory=list)
    samplers: list[dict[str, Any]] = field(default_factory=list)
    channels: list[dict[str, Any]] = field(default_factory=list)
    binary: bytearray = field(default_factory=bytearray)

    def add_node(self, parent: int | None, **values: Any) -> int:
        """Number of a new node."""
        self.nodes.append(values)
        number = len(self.nodes) - 1
        if parent is not None:
            self.nodes[parent].setdefault("children", []).append(number)
        return number

    def add_column(self, array: NDArray[Any], target: int | None = None) -> int:
        """Number of a new accessor: rows of 1, 3 or 4 floats, or unsigned integers."""
        is_float = array.dtype.kind == "f"
        rows = np.ascontiguousarray(array, dtype="<f4" if is_float else "<u4")
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": rows.nbytes}
        self.views.append(view | ({"target": target} if target else {}))
        self.binary += rows.tobytes()
        columns = rows.reshape(len(rows), -1)
        self.accessors.append(
            {
                "bufferView": len(self.views) - 1,
                "componentType": FLOAT if is_float else UINT,
                "count": len(rows),
                "type": KINDS[columns.shape[1]],
                "min": columns.min(axis=0).tolist(),
                "max": columns.max(axis=0).tolist(),
            }
        )
        return len(self.accessors) - 1

    def animate(self, node: int, what: str, times: int, values: Floats, way: str) -> None:
        """Move a node: `what` is translation, rotation or scale, `way` is LINEAR or STEP."""
        sampler = {"input": times, "output": self.add_column(values), "interpolation": way}
        self.samplers.append(sampler)
        target = {"node": node, "path": what}
        self.channels.append({"sampler": len(self.samplers) - 1, "target": target})

    def glb(self, name: str) -> bytes:
        """The file."""
        document: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": "gcodesim"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": self.nodes,
            "meshes": self.meshes,
            "materials": [_material(role) for role in COLORS],
            "accessors": self.accessors,
            "bufferViews": self.views,
            "buffers": [{"byteLength": len(self.binary)}],
        }
        if self.channels:
            animation = {"name": name, "samplers": self.samplers, "channels": self.channels}
            document["animations"] = [animation]
        text = json.dumps(document, separators=(",", ":")).encode()
        chunks = _chunk(b"JSON", text, b" ") + _chunk(b"BIN\0", bytes(self.binary), b"\0")
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def _chunk(kind: bytes, data: bytes, filler: bytes) -> bytes:
    data += filler * (-len(data) % 4)
    return struct.pack("<I4s", len(data), kind) + data


def _material(role: str) -> dict[str, Any]:
    surface = {"baseColorFactor": [*COLORS[role], 1.0], "metallicFactor": 0.1}
    return {"name": role, "doubleSided": True, "pbrMetallicRoughness": surface}


def model(replay: Replay) -> bytes:
    """The machine with its tools, moving as it was checked, as a GLB file in metres, Y up."""
    made, knots, machine = Model(), replay.knots(), replay.machine
    quarter = math.sqrt(0.5)
    root = made.add_node(
        None, name=machine.name, scale=[1e-3] * 3, rotation=[-quarter, 0.0, 0.0, quarter]
    )
    times, positions = _keys(knots.time_s, knots.positions, [j.rotary for j in machine.joints])
    clock = made.add_column(times) if len(times) > 1 else None
    moved = {joint.child for joint in machine.joints}
    fixed = [link for link in machine.links if link not in moved]
    frames = {link: made.add_node(root, name=link) for link in fixed}
    for column, joint in enumerate(machine.joints):
        parent = frames[joint.parent]
        frames[joint.child] = _add_link(made, parent, joint, clock, positions[:, column])
    for shown in replay.bodies():
        _add_body(made, frames[shown.body.link], shown, float(knots.time_s[-1]))
    return made.glb(machine.name)


def _keys(time_s: Floats, positions: Floats, rotary: list[bool]) -> tuple[Floats, Floats]:
    """Times [s] and positions with no large turn from one to the next; times differ as float32."""
    turn = np.abs(np.diff(positions[:, rotary], axis=0)).max(axis=1, initial=0.0)
    parts = np.maximum(np.ceil(turn / LARGEST_TURN), 1.0).astype(np.int64)
    number = np.arange(parts.sum()) - np.repeat(np.cumsum(parts) - parts, parts)
    row = np.repeat(np.arange(len(parts)), parts)
    share = number / parts[row]
    times = np.append(time_s[row] + share * (time_s[row + 1] - time_s[row]), time_s[-1])
    between = positions[row] + share[:, None] * (positions[row + 1] - positions[row])
    keys = np.vstack([between, positions[-1:]])
    _, distinct = np.unique(times.astype(np.float32), return_index=True)
    return times[distinct], keys[distinct]


def _add_link(made: Model, parent: int, joint: Joint, clock: int | None, q: Floats) -> int:
    """The node in which the bodies of a joint's child stand as at the zero pose."""
    if joint.rotary:
        half = np.radians(q)[:, None] / 2.0
        turns = np.concatenate([np.sin(half) * joint.axis, np.cos(half)], axis=1)
        pivot = made.add_node(
            parent,
            name=f"{joint.name} axis",
            translation=joint.point.tolist(),
            rotation=turns[0].tolist(),
        )
        if clock is not None:
            made.animate(pivot, "rotation", clock, turns, "LINEAR")
        return made.add_node(pivot, name=joint.child, translation=(-joint.point).tolist())
    slides = q[:, None] * joint.axis
    node = made.add_node(parent, name=joint.child, translation=slides[0].tolist())
    if clock is not None:
        made.animate(node, "translation", clock, slides, "LINEAR")
    return node


def _add_body(made: Model, parent: int, shown: Shown, end: float) -> None:
    """A body with its parts; one that is not always there is scaled to nothing while it is away."""
    node = made.add_node(parent, name=f"{shown.body.name} {shown.title}".strip())
    for part in shown.body.parts:
        vertices, faces = indexed(part.triangles)
        primitive = {
            "attributes": {"POSITION": made.add_column(vertices, VERTICES)},
            "indices": made.add_column(faces.ravel(), INDICES),
            "material": list(COLORS).index(part.role),
        }
        made.meshes.append({"name": part.name, "primitives": [primitive]})
        name = f"{shown.body.name} {shown.title} {part.name}".replace("  ", " ")
        made.add_node(node, name=name, mesh=len(made.meshes) - 1)
    if shown.spans is None or shown.spans == ((0.0, end),):
        return
    edges = sorted({0.0, *(time for span in shown.spans for time in span if time < end)})
    there = [any(start <= t < stop for start, stop in shown.spans) for t in edges]
    sizes = np.repeat(np.array(there, float)[:, None], 3, axis=1)
    made.nodes[node]["scale"] = sizes[0].tolist()
    if len(edges) > 1:
        made.animate(node, "scale", made.add_column(np.array(edges)), sizes, "STEP")
