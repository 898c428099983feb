"""Mesh files: kept in file order, judged closed or not, outward or not, unit believable or not."""

import numpy as np
import pytest
import trimesh
from machine.stl import stl_bytes

from gcodesim.errors import ModelError
from gcodesim.machine import shapes
from gcodesim.machine.loading import load_machine
from gcodesim.machine.mesh import read_mesh, signed_volume

BOX = shapes.box([300, 200, 40], [0, 0, -100])


def codes(findings):
    return [finding.code for finding in findings]


@pytest.fixture
def stl(tmp_path):
    """Function that writes a binary STL and returns its path."""

    def write(triangles):
        (tmp_path / "part.stl").write_bytes(stl_bytes(triangles))
        return tmp_path / "part.stl"

    return write


def test_good_stl_in_file_order(stl):
    mesh = read_mesh(stl(BOX), travel=500)
    assert mesh.closed
    assert mesh.findings == ()
    assert mesh.triangles.dtype == np.float64
    np.testing.assert_array_equal(mesh.triangles, BOX)
    np.testing.assert_array_equal(read_mesh(stl(BOX / 32), "inch").triangles, BOX / 32 * 25.4)


@pytest.mark.parametrize("suffix", ["obj", "ply", "off", "stl_ascii"])
def test_other_formats(tmp_path, suffix):
    """Trimesh formats give the same triangles in the same order."""
    corners, faces = np.unique(BOX.reshape(-1, 3), axis=0, return_inverse=True)
    path = tmp_path / f"part.{suffix.removesuffix('_ascii')}"
    trimesh.Trimesh(corners, faces.reshape(-1, 3), process=False).export(path, file_type=suffix)
    mesh = read_mesh(path)
    assert mesh.closed
    np.testing.assert_array_equal(mesh.triangles, BOX)


@pytest.mark.parametrize(
    ("triangles", "edges", "also"),
    [
        (BOX[1:], 3, []),
        (np.concatenate([BOX[:1, ::-1], BOX[1:]]), 3, []),
        (np.repeat(BOX, 2, axis=0), 18, ["GC504"]),
    ],
    ids=["one triangle missing", "one triangle turned", "every triangle twice"],
)
def test_open_mesh(stl, triangles, edges, also):
    path = stl(triangles)
    mesh = read_mesh(path)
    assert not mesh.closed
    assert codes(mesh.findings) == ["GC501", *also]
    assert mesh.findings[0].file == str(path)
    assert f"{edges} edges" in mesh.findings[0].message


def test_inward_mesh_is_turned(stl):
    mesh = read_mesh(stl(BOX[:, ::-1]))
    assert codes(mesh.findings) == ["GC504"]
    assert mesh.closed
    assert signed_volume(mesh.triangles) == pytest.approx(300 * 200 * 40)


def test_degenerate_triangles_are_noted(stl):
    point = np.zeros((1, 3, 3))
    line = np.array([[[0, 0, 0], [1, 1, 1], [2, 2, 2]]], dtype=float)
    mesh = read_mesh(stl(np.concatenate([BOX, point])))
    assert mesh.closed
    assert [(f.code, f.severity) for f in mesh.findings] == [("GC504", "note")]
    assert "1 of 13" in mesh.findings[0].message
    assert codes(read_mesh(stl(np.concatenate([BOX, line]))).findings) == ["GC501", "GC504"]


@pytest.mark.parametrize(("scale", "fits"), [(1 / 25.4, "inch"), (1 / 1000, "m")])
def test_suspicious_unit(tiny, scale, fits):
    (tiny / "meshes" / "X.stl").write_bytes(stl_bytes(BOX * scale))
    machine = load_machine(str(tiny / "tiny.yaml"))
    assert codes(machine.findings) == ["GC503"]
    assert machine.findings[0].file == str(tiny / "meshes" / "X.stl")
    assert f"`units: {fits}`" in machine.findings[0].message


def test_unit_too_large(tiny, changed):
    machine = load_machine(changed("name: tiny", "name: tiny\nunits: m"))
    assert "`units: mm` would make it 300 mm" in machine.findings[0].message


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e30])
def test_no_number(stl, bad):
    triangles = BOX.copy()
    triangles[7, 1, 2] = bad
    with pytest.raises(ModelError, match="triangle 7 "):
        read_mesh(stl(triangles))


@pytest.mark.parametrize("name", ["part.stl", "part.obj", "part.xyzzy"])
@pytest.mark.parametrize(
    "content", [b"", b"no mesh at all\n", stl_bytes(BOX)[:-7], stl_bytes(BOX[:0])]
)
def test_unreadable(tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(ModelError, match=name):
        read_mesh(tmp_path / name)
    with pytest.raises(ModelError, match="cannot be read"):
        read_mesh(tmp_path / "missing.stl")
