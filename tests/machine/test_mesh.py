"""Mesh files: kept in file order, judged closed or not, outward or not, unit believable or not."""

import zipfile

import numpy as np
import pytest
import trimesh
from machine.stl import stl_bytes

from gcodesim.errors import ModelError
from gcodesim.machine import mesh_counts, shapes
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
    mesh = read_mesh(stl(BOX))
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


@pytest.mark.parametrize(("scale", "fits"), [(1 / 80, "inch"), (1 / 1000, "m")])
def test_suspicious_unit(tiny, scale, fits):
    (tiny / "meshes" / "X.stl").write_bytes(stl_bytes(BOX * scale))
    machine = load_machine(str(tiny / "tiny.yaml"))
    assert codes(machine.findings) == ["GC503"]
    assert machine.findings[0].file == str(tiny / "meshes" / "X.stl")
    assert f"`units: {fits}`" in machine.findings[0].message


def test_unit_too_large(tiny, changed):
    machine = load_machine(changed("name: tiny", "name: tiny\nunits: m"))
    assert "`units: mm` makes it 300 mm" in machine.findings[0].message


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


def test_a_small_mesh_beside_a_tool_of_its_size_is_no_wrong_unit(tiny):
    """A sensor of 10 mm, far smaller than the travel, and not absurd beside the tool."""
    (tiny / "meshes" / "X.stl").write_bytes(stl_bytes(BOX / 30))
    assert codes(load_machine(str(tiny / "tiny.yaml")).findings) == []


@pytest.mark.parametrize(("unit", "size"), [("m", 300.0), ("mm", 0.3)])
def test_a_unit_that_stands_at_the_mesh_is_believed(tiny, changed, unit, size):
    (tiny / "meshes" / "X.stl").write_bytes(stl_bytes(BOX / 1000))
    machine = load_machine(changed("X.stl", f"X.stl, units: {unit}"))
    assert codes(machine.findings) == []
    (part,) = machine.bodies["X"].parts
    assert np.ptp(part.triangles[..., 0]) == pytest.approx(size, rel=1e-6)


def test_a_shell_may_be_open_and_has_no_inside(tiny, changed):
    (tiny / "meshes" / "X.stl").write_bytes(stl_bytes(BOX[2:]))
    machine = load_machine(changed("X.stl", "X.stl, shell: true"))
    assert codes(machine.findings) == []
    assert machine.bodies["X"].parts[0].shell
    assert "X: a shell, of which only the surface is checked" in machine.unchecked_by_rule


def test_units_and_shell_belong_to_a_mesh(changed):
    with pytest.raises(ModelError, match="`units` belongs to `mesh`"):
        load_machine(changed("mesh: meshes/X.stl", "box: {size: [1, 1, 1]}, units: inch"))


def text_stl(triangles, normal="0 0 1"):
    corners = ["".join(f"vertex {x:g} {y:g} {z:g}\n" for x, y, z in t) for t in triangles]
    facets = (f"facet normal {normal}\nouter loop\n{c}endloop\nendfacet\n" for c in corners)
    return "solid x\n" + "".join(facets) + "endsolid x\n"


def test_a_text_stl_is_read_whatever_its_normals_say(tmp_path, capfd):
    path = tmp_path / "part.stl"
    for normal in ("0 0 1", "0 0", "nan a b"):
        path.write_text(text_stl(BOX, normal))
        np.testing.assert_array_equal(read_mesh(path).triangles, BOX)
    assert capfd.readouterr().err == ""


def exported(form, encoding="ascii"):
    """A box as a file of a format, as bytes."""
    mesh = trimesh.Trimesh(*trimesh.triangles.to_kwargs(BOX).values())
    if form == "stl":
        return text_stl(BOX).encode()
    given = {"encoding": encoding} if form == "ply" else {}
    content = mesh.export(file_type=form, **given)
    return content if isinstance(content, bytes) else content.encode()


@pytest.mark.parametrize(
    ("form", "encoding"),
    [("off", ""), ("obj", ""), ("ply", "ascii"), ("ply", "binary"), ("stl", "")],
)
def test_a_file_that_is_cut_off_names_what_it_announces_and_holds(tmp_path, form, encoding):
    path = tmp_path / f"part.{form}"
    whole = exported(form, encoding).rstrip(b"\n")
    if encoding == "binary":
        whole = exported(form, encoding)
    path.write_bytes(whole)
    assert len(read_mesh(path).triangles) == 12
    # An OBJ file announces nothing: what is missing shows where its points are left over.
    for part in (0.4,) if form == "obj" else (0.97, 0.8, 0.6, 0.5):
        path.write_bytes(whole[: int(len(whole) * part)])
        with pytest.raises(ModelError, match=r"\d"):
            read_mesh(path)


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.stl", stl_bytes(BOX) + b"123", "announces 12 triangles and holds 12 and 3 bytes"),
        ("a.stl", stl_bytes(BOX)[:-60], "announces 12 triangles and holds 10 and 40 bytes"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nf 1 2 9\n", "names point 9, and the file holds 2 points"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nf 1 2\n", "does not name three points"),
        ("a.off", b"OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "2 faces and holds 1"),
        ("a.stl", stl_bytes(np.ones((4, 3, 3))), "all corners of its 4 triangles are one point"),
        ("a.step", b"ISO-10303-21;", "no reader for .step: export the mesh as binary STL"),
        ("a.3mf", b"PK", "no reader for .3mf: export the mesh as binary STL"),
    ],
)
def test_a_bad_mesh_is_named_in_a_sentence(tmp_path, name, content, said):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(ModelError, match=said):
        read_mesh(tmp_path / name)


@pytest.mark.parametrize(("form", "encoding"), [("off", ""), ("obj", ""), ("ply", "ascii")])
def test_an_open_mesh_whose_file_ends_too_early_is_refused(tmp_path, form, encoding):
    """Wherever it is cut off inside a line."""
    sphere = trimesh.creation.icosphere(2)
    given = {"include_normals": False} if form == "obj" else {}
    given |= {"encoding": encoding} if encoding else {}
    whole = sphere.export(file_type=form, **given)
    whole = (whole if isinstance(whole, bytes) else whole.encode()).rstrip(b"\n")
    path = tmp_path / f"part.{form}"
    path.write_bytes(whole)
    assert read_mesh(path).closed
    for end in range(len(whole) - 40, len(whole)):
        path.write_bytes(whole[:end])
        if not whole[:end].endswith(b"\n"):
            with pytest.raises(ModelError, match=r"cut off|damaged|three points"):
                read_mesh(path)


def test_an_open_obj_with_points_that_no_face_names_is_cut_off_or_a_shell(tmp_path):
    path = tmp_path / "part.obj"
    corners = "".join(f"v {i} {i * i} 0\n" for i in range(30))
    faces = "".join(f"f {i} {i + 1} {i + 2}\n" for i in range(1, 28))
    path.write_text(f"{corners}{faces}")
    with pytest.raises(ModelError, match=r"30 points, and its faces name 29 of them: .*shell"):
        read_mesh(path)
    assert not read_mesh(path, shell=True).closed


def test_a_damaged_head_of_a_mesh_file_is_a_sentence(tmp_path):
    many = "9" * 5000
    for name, text in (
        ("a.off", f"OFF\n{many} 1 0\n0 0 0\n"),
        ("a.obj", f"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 {many}\n"),
        ("a.ply", f"ply\nformat ascii 1.0\nelement vertex {many}\nend_header\n"),
        (
            "a.ply",
            "ply\nformat binary_little_endian 1.0\nelement face 3\nproperty list\n"
            "property\nend_header\n1234",
        ),
        ("a.ply", "ply\nformat ascii 1.0\nelement vertex \xb2\nend_header\n"),
    ):
        (tmp_path / name).write_text(text)
        with pytest.raises(ModelError):
            read_mesh(tmp_path / name)


def test_an_archive_that_unpacks_to_too_much_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(mesh_counts, "MOST_UNPACKED", 100_000)
    path = tmp_path / "part.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("part.stl", bytes(1_000_000))
    with pytest.raises(ModelError, match="unpacks to 1,000,000 bytes; at most 100,000 are read"):
        read_mesh(path)
