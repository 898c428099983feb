"""Machines of VERICUT: tree, turned frames, motion on the work side, limits, pairs and models."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from numpy.typing import NDArray

from gcodesim.cli import main
from gcodesim.errors import ModelError
from gcodesim.machine import shapes
from gcodesim.machine.kinematics import transform, world_from_link
from gcodesim.machine.loading import load_machine
from gcodesim.machine.mesh import read_mesh
from gcodesim.machine.model import Machine

NO_PLACE = '<Position X="0" Y="0" Z="0"/><Rotation I="0" J="0" K="0"/>'
LIMITS = '<TlRecord TlMin="{}" TlMax="{}" TlIgnore="off"/>'
MCH = f"""<?xml version="1.0"?>
<VcMachine Version="7.1" Unit="millimeter">
<Table Name="Initial Machine Location">
<Row><Value>0</Value><Value>0</Value><Value>900</Value></Row></Table>
<Table Name="Tool Change Location">
<Row><Value>10</Value><Value>-20</Value><Value>30</Value></Row></Table>
<Table Name="Tool Change Retraction">
<Row><Value>1</Value><Value>0</Value><Value>1</Value></Row></Table>
<Table Name="Work Offsets">
<Row><Value>1</Value></Row></Table>
<Collision>
<Between Sub1="off" Sub2="off" Tol="0.2">
<Component>Tool</Component><Component>C</Component></Between>
<Between Sub1="off" Sub2="off" Tol="1.5">
<Component>Probe</Component><Component>C</Component></Between>
<Between Sub1="on" Sub2="off" Tol="0">
<Component>Z</Component><Component>Base</Component></Between>
<Between Sub1="on" Sub2="off" Tol="0">
<Component>Z</Component><Component>Y</Component></Between>
<Between Sub1="off" Sub2="off" Tol="1">
<Component>Fixture</Component><Component>C</Component></Between>
</Collision>
<Component Name="Base" Type="base"><Attach></Attach>{NO_PLACE}
<Poly Unit="millimeter" Mirror="Off" Visible="on"><File>V:\\vericut\\mill\\BED.PLY</File>
<Position X="0" Y="0" Z="-500"/><Rotation I="0" J="0" K="0"/></Poly></Component>
<Component Name="Y" Type="linear"><Attach>Base</Attach>{NO_PLACE}
<Link Axis="Y" Register="Y" RapidRate="15000" Accel="125">{LIMITS.format(-200, 300)}</Link>
<Block Length="400" Width="300" Height="20" Visible="off"><Position X="-200" Y="-150" Z="-120"/>
<Rotation I="0" J="0" K="0"/></Block></Component>
<Component Name="C" Type="rotary"><Attach>Y</Attach><Position X="50" Y="60" Z="0"/>
<Rotation I="0" J="0" K="0"/>
<Link Axis="Z" Register="C" RapidRate="5000">{LIMITS.format(-29999, 29999)}</Link>
<Cylinder Radius="80" Height="40" Visible="on"><Position X="0" Y="0" Z="-40"/>
<Rotation I="0" J="0" K="0"/></Cylinder></Component>
<Component Name="Attach" Type="attach"><Attach>C</Attach>{NO_PLACE}</Component>
<Component Name="X" Type="linear"><Attach>Base</Attach>{NO_PLACE}
<Link Axis="X" Register="X" RapidRate="0">{LIMITS.format(-250, 250)}</Link></Component>
<Component Name="Z" Type="linear"><Attach>X</Attach>{NO_PLACE}
<Link Axis="Z" Register="Z" RapidRate="9000">{LIMITS.format(-400, 100)}</Link></Component>
<Component Name="Probe" Type="other"><Attach>Z</Attach><Position X="30" Y="0" Z="300"/>
<Rotation I="0" J="0" K="0"/>
<Block Length="2" Width="2" Height="50" Visible="on">{NO_PLACE}</Block></Component>
<Component Name="Tilt" Type="other"><Attach>Z</Attach><Position X="0" Y="7" Z="400"/>
<Rotation I="45" J="0" K="0"/>
<Block Length="20" Width="20" Height="50" Visible="on">{NO_PLACE}</Block></Component>
<Component Name="B" Type="rotary"><Attach>Tilt</Attach>{NO_PLACE}
<Link Axis="-Z" Register="B" RapidRate="5000">{LIMITS.format(0, 180)}</Link></Component>
<Component Name="Spindle" Type="spindle"><Attach>B</Attach><Position X="0" Y="0" Z="-100"/>
<Rotation I="-45" J="0" K="0"/>
<Poly Unit="inch" Mirror="On" Visible="on"><File>C:\\left\\nose.ply</File>{NO_PLACE}</Poly>
<Cone Visible="on"/></Component>
<Component Name="Tool" Type="tool"><Attach>Spindle</Attach>{NO_PLACE}</Component>
</VcMachine>
"""


def model_bytes(triangles: NDArray[np.float64], corners: int = 3) -> bytes:
    """A model as VERICUT writes it."""
    facets = (bytes([corners]) + t.astype("<f8").tobytes() + bytes(24) for t in triangles)
    return b"VERICUT-model\nversion-2.0\n1\n0 1 0\n" + b"".join(facets)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    bed = shapes.box([600, 600, 50], [0, 0, 0])
    (tmp_path / "bed.ply").write_bytes(model_bytes(bed))
    (tmp_path / "mill.mch").write_text(MCH)
    return tmp_path


def import_(folder: Path) -> Result:
    out = str(folder / "mill.yaml")
    return CliRunner().invoke(main, ["machine", "import", str(folder / "mill.mch"), "--out", out])


def imported(folder: Path) -> Machine:
    result = import_(folder)
    assert result.exit_code == 0, result.output
    return load_machine(str(folder / "mill.yaml"))


def test_the_tree_of_a_machine_comes_with_limits_speeds_and_places(folder: Path) -> None:
    machine = imported(folder)
    joints = {joint.name: joint for joint in machine.joints}
    assert set(joints) == {"X", "Y", "Z", "B", "C"}
    assert (joints["Y"].lower, joints["Y"].upper, joints["Y"].rapid) == (-200.0, 300.0, 250.0)
    assert np.isinf([joints["C"].lower, joints["C"].upper]).all()
    np.testing.assert_allclose(joints["C"].point, [50, 60, 0])
    np.testing.assert_allclose(joints["B"].point, [0, 7, 400])
    half = np.sqrt(0.5)
    np.testing.assert_allclose(joints["B"].axis, [0, half, -half], atol=1e-15)
    assert machine.work_link == "C"
    assert machine.tool is not None
    assert machine.tool.link == "B"
    np.testing.assert_allclose(machine.tool.gauge_point, [0, 7 + 100 * half, 400 - 100 * half])
    np.testing.assert_allclose(machine.tool.axis, [0, 0, 1], atol=1e-15)
    assert machine.start == {"X": 0, "Y": 0, "Z": 100, "B": 0, "C": 0}
    assert machine.readings.tool_change.position == {"X": 10, "Z": 30}  # type: ignore[union-attr]


def test_motion_on_the_work_side_is_turned_round(folder: Path) -> None:
    """The table at Y 10 has moved by -10; C 90 turns it clockwise, seen from above."""
    machine = imported(folder)
    at = dict.fromkeys(machine.axes, 0.0) | {"Y": 10.0, "C": 90.0, "X": 3.0}
    poses = world_from_link(machine, [at[axis] for axis in machine.axes])
    np.testing.assert_allclose(transform(poses["C"], [[51.0, 60.0, 0.0]]), [[50.0, 49.0, 0.0]])
    np.testing.assert_allclose(transform(poses["Z"], [[0.0, 0.0, 0.0]]), [[3.0, 0.0, 0.0]])


def test_shapes_stand_where_the_components_stand(folder: Path) -> None:
    bodies = imported(folder).bodies
    boxes = {
        (name, part.name): np.ptp(part.triangles.reshape(-1, 3), axis=0).tolist()
        + part.triangles.reshape(-1, 3).min(axis=0).tolist()
        for name, body in bodies.items()
        for part in body.parts
    }
    assert boxes["Base", "Base"] == [600, 600, 50, -300, -300, -525]
    assert boxes["Y", "Y"] == [400, 300, 20, -200, -150, -120]
    assert boxes["Z", "Probe_block"] == [2, 2, 50, 30, 0, 300]
    low = boxes["Z", "Tilt_block"]
    np.testing.assert_allclose(low[3:], [0, 7 - 50 * np.sqrt(0.5), 400])
    top = bodies["C"].parts[0].triangles.reshape(-1, 3).max(axis=0)[2]
    assert top == 0.0


def test_pairs_come_with_tolerances_and_by_component(folder: Path) -> None:
    """Z has two components with shapes: what means one of them names the part."""
    pairs = {(p.a, p.b, p.parts_a, p.parts_b): p.clearance for p in imported(folder).pairs}
    assert pairs == {
        ("Z", "C", ("Probe_block",), None): 1.5,
        ("Z", "Base", None, None): 0.0,
        ("Z", "Y", None, None): 0.0,
    }
    text = (folder / "mill.yaml").read_text()
    assert "  - {links: [tool, C], clearance: 0.2}\n" in text


def test_what_is_not_carried_over_is_listed(folder: Path) -> None:
    stderr = import_(folder).stderr
    text = (folder / "mill.yaml").read_text()
    for line in (
        "X: no RapidRate, 10000 a minute assumed",
        "Z: it stands at 900 at first, out of its travel: moved to the limit",
        "model C:\\left\\nose.ply: no such file, neither there nor beside the machine",
        "such a shape is not carried over",
        "pair Fixture and C: Fixture is of a project, not carried over",
        "table Work Offsets: offsets belong to the setup, tools to a tools file",
        "1 shapes that VERICUT does not show are part of the machine here",
        "Tool Change Location became `tool_change`: that Z goes first is assumed",
    ):
        assert line in stderr
        assert line in text


def test_an_axis_that_programs_do_not_move_stands(folder: Path) -> None:
    (folder / "mill.mch").write_text(MCH.replace('Register="B"', 'Register="U"'))
    result = import_(folder)
    assert "B: its register 'U' is no axis here, so axis_B stands" in result.stderr
    assert "axis_B" in load_machine(str(folder / "mill.yaml")).axes


def test_without_collision_pairs_every_two_links_are_checked(folder: Path) -> None:
    begin, end = MCH.index("<Collision>"), MCH.index("</Collision>")
    (folder / "mill.mch").write_text(MCH[:begin] + "<Collision>" + MCH[end:])
    assert "no collision pairs: every two links are checked" in import_(folder).stderr
    pairs = {(p.a, p.b) for p in load_machine(str(folder / "mill.yaml")).pairs}
    assert pairs == {("Base", "C"), ("Base", "Z"), ("C", "Z"), ("Y", "Z")}


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('Unit="millimeter">\n<Table', 'Unit="foot">\n<Table', "unknown Unit 'foot'"),
        ("<Attach>C</Attach>", "<Attach>CC</Attach>", "'CC', which is no component; "),
        ("<Attach>Base</Attach>", "<Attach>C</Attach>", "which leads back to itself"),
        ('Name="C"', 'Name="Y"', "there is a second component 'Y'"),
        ('Axis="Y"', 'Axis="Q"', "Axis 'Q' is none; write X, Y, Z or -X, -Y, -Z"),
        ('TlMin="-200"', 'TlMin="low"', "expected a number as in TlMin=\"1.5\", not 'low'"),
        ('TlMin="-200"', 'TlMin="400"', "TlMin 400 must be below TlMax 300"),
        ("<Value>900", "<Value>up", "expected a number, not 'up'"),
        ('X="50" Y="60"', 'X="50" Y="6O"', "expected a number as in Y="),
        ('Height="40"', 'Height="-4"', 'Height="-4" must be above 0'),
        ('Tol="1.5"', 'Tol="-1"', 'Tol="-1" must be 0 or more'),
        ('Tol="1.5"', 'Tol="1e99"', "expected a number as in Tol="),
        ("</Collision>", "</Between>", "no valid XML"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(
    folder: Path, old: str, new: str, message: str
) -> None:
    place = MCH.index(old)
    (folder / "mill.mch").write_text(MCH[:place] + new + MCH[place + len(old) :])
    result = import_(folder)
    assert result.exit_code == 2, result.output
    assert f"mill.mch:{MCH[:place].count(chr(10)) + 1}:" in result.stderr
    assert message in result.stderr
    assert "Traceback" not in result.stderr


def test_a_file_of_another_kind_is_refused(folder: Path) -> None:
    (folder / "mill.mch").write_text('<machine xmlns="machines">\n</machine>\n')
    result = import_(folder)
    assert result.exit_code == 2
    assert "mill.mch:1: " in result.stderr
    assert "expected <VcMachine> as the outermost element, as VERICUT 7" in result.stderr


def test_the_text_format_of_version_6_is_refused(folder: Path) -> None:
    (folder / "mill.mch").write_text('CGTech Machine\nVersion-6.2\n\nMACHINE "" {\n')
    result = import_(folder)
    assert result.exit_code == 2
    assert "mill.mch:1: the text format of VERICUT 6 is not read: save" in result.stderr


def test_a_model_is_read_where_a_mesh_is(folder: Path) -> None:
    bed = shapes.box([600, 600, 50], [0, 0, 0])
    mesh = read_mesh(folder / "bed.ply")
    np.testing.assert_array_equal(mesh.triangles, bed)
    assert mesh.closed
    whole = model_bytes(bed)
    for content, message in (
        (whole[:20], "has 4 lines before its facets: it is cut off"),
        (whole[:-5], "triangles of 97 bytes, and 92 bytes more: it is cut off or damaged"),
        (model_bytes(bed, 4), r"facet 0 \(counted from 0\) has 4 corners, not 3"),
        (whole[:34], "holds no triangle"),
    ):
        (folder / "bed.ply").write_bytes(content)
        with pytest.raises(ModelError, match=message):
            read_mesh(folder / "bed.ply")
