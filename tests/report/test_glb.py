"""The animated model: its chunks and accessors, trimesh's view of it, and poses at its keys."""

from __future__ import annotations

import io
import json
import struct
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray
from report.checked import crash, tools

from gcodesim.checking.replay import Replay
from gcodesim.constants import PS_PER_S
from gcodesim.machine.kinematics import world_from_link
from gcodesim.report.glb import model

WIDTH = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}
DTYPE = {5126: "<f4", 5125: "<u4"}


def read(data: bytes) -> tuple[dict[str, Any], bytes]:
    """Document and binary of a GLB file; the lengths of its header and chunks must be right."""
    magic, version, length = struct.unpack_from("<4sII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data))
    chunks, place = [], 12
    while place < len(data):
        size, kind = struct.unpack_from("<I4s", data, place)
        assert size % 4 == 0
        chunks.append((kind, data[place + 8 : place + 8 + size]))
        place += 8 + size
    assert place == len(data)
    assert [kind for kind, _ in chunks] == [b"JSON", b"BIN\0"]
    document = json.loads(chunks[0][1])
    assert 0 <= len(chunks[1][1]) - document["buffers"][0]["byteLength"] < 4
    return document, chunks[1][1]


def column(document: dict[str, Any], binary: bytes, number: int) -> NDArray[Any]:
    """Rows of an accessor, with its bounds and its place in the buffer checked."""
    accessor = document["accessors"][number]
    view = document["bufferViews"][accessor["bufferView"]]
    width, dtype = WIDTH[accessor["type"]], np.dtype(DTYPE[accessor["componentType"]])
    assert view["byteOffset"] % 4 == 0
    assert view["byteLength"] == accessor["count"] * width * dtype.itemsize
    assert view["byteOffset"] + view["byteLength"] <= document["buffers"][0]["byteLength"]
    flat = np.frombuffer(binary, dtype, accessor["count"] * width, view["byteOffset"])
    rows = flat.reshape(-1, width)
    assert rows.min(axis=0).tolist() == accessor["min"]
    assert rows.max(axis=0).tolist() == accessor["max"]
    return rows


def matrix(node: dict[str, Any]) -> NDArray[np.float64]:
    """Pose of a node below its parent."""
    x, y, z, w = node.get("rotation", (0.0, 0.0, 0.0, 1.0))
    turn = trimesh.transformations.quaternion_matrix([w, x, y, z])
    turn[:3, :3] *= node.get("scale", [1.0] * 3)
    turn[:3, 3] = node.get("translation", [0.0] * 3)
    return np.asarray(turn)


def world(nodes: list[dict[str, Any]]) -> dict[str, NDArray[np.float64]]:
    """Pose of every node by its name."""
    poses, pending = {}, [(0, np.eye(4))]
    while pending:
        number, above = pending.pop()
        node = nodes[number]
        poses[node["name"]] = above @ matrix(node)
        pending += [(child, poses[node["name"]]) for child in node.get("children", ())]
    return poses


def moved(document: dict[str, Any], binary: bytes, key: int) -> list[dict[str, Any]]:
    """The nodes with the joints as they stand at one key."""
    nodes = [dict(node) for node in document["nodes"]]
    (animation,) = document["animations"]
    for channel in animation["channels"]:
        sampler = animation["samplers"][channel["sampler"]]
        if sampler["interpolation"] == "LINEAR":
            values = column(document, binary, sampler["output"])
            nodes[channel["target"]["node"]][channel["target"]["path"]] = values[key].tolist()
    return nodes


def test_keys_pose_the_links_as_the_kinematics_do() -> None:
    replay = tools()[1]
    document, binary = read(model(replay))
    (animation,) = document["animations"]
    times = column(document, binary, animation["samplers"][0]["input"])[:, 0].astype(np.float64)
    assert (np.diff(times) > 0).all()
    assert abs(times[-1] - replay.path.duration_s) < 1e-6
    into_gltf = matrix(document["nodes"][0])
    for key, time in enumerate(times):
        q = replay.path.positions(np.array([round(time * PS_PER_S)]))[0]
        found = world(moved(document, binary, key))
        for link, pose in world_from_link(replay.machine, q).items():
            # 0.01 mm and deg is the stated tolerance; 500 mm from the axis that is 0.09 mm.
            np.testing.assert_allclose(found[link], into_gltf @ pose, atol=1e-4, err_msg=link)


def test_turns_are_short_enough_for_every_viewer_and_tools_come_and_go() -> None:
    replay = tools()[1]
    document, binary = read(model(replay))
    (animation,) = document["animations"]
    scales = {}
    for channel in animation["channels"]:
        sampler = animation["samplers"][channel["sampler"]]
        values = column(document, binary, sampler["output"])
        if channel["target"]["path"] == "rotation":
            np.testing.assert_allclose(np.linalg.norm(values, axis=1), 1.0, atol=1e-6)
            assert (np.sum(values[1:] * values[:-1], axis=1) > np.cos(np.radians(45.1))).all()
        if channel["target"]["path"] == "scale":
            assert sampler["interpolation"] == "STEP"
            name = document["nodes"][channel["target"]["node"]]["name"]
            times = column(document, binary, sampler["input"])[:, 0]
            scales[name] = (times.tolist(), values[:, 0].tolist())
    change = replay.path.bounds_ps[replay.path.tool_changes[1].piece] / PS_PER_S
    assert {name: sizes for name, (_, sizes) in scales.items()} == {
        "cutter T1": [1.0, 0.0],
        "cutter T2": [0.0, 1.0],
    }
    assert all(np.allclose(times, [0.0, change]) for times, _ in scales.values())


def test_trimesh_reads_every_part_with_all_its_triangles() -> None:
    replay = crash()[1]
    scene = trimesh.load_scene(io.BytesIO(model(replay)), file_type="glb")
    parts = [part for shown in replay.bodies() for part in shown.body.parts]
    assert len(scene.geometry) == len(parts) == len(scene.graph.nodes_geometry)
    counts = sorted(len(mesh.faces) for mesh in scene.geometry.values())
    assert counts == sorted(len(part.triangles) for part in parts)
    assert_bounds(scene, replay)


def assert_bounds(scene: trimesh.Scene, replay: Replay) -> None:
    """At the start the machine stands in metres with Y up."""
    poses = world_from_link(replay.machine, replay.path.positions(np.array([0]))[0])
    points = np.concatenate(
        [
            part.triangles.reshape(-1, 3) @ poses[shown.body.link][:3, :3].T
            + poses[shown.body.link][:3, 3]
            for shown in replay.bodies()
            for part in shown.body.parts
        ]
    )
    in_metres = points[:, [0, 2, 1]] * [1e-3, 1e-3, -1e-3]
    np.testing.assert_allclose(scene.bounds, [in_metres.min(0), in_metres.max(0)], atol=1e-6)
