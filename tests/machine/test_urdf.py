"""URDF robots become machines: frames, joints and shapes in the world at the zero pose."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from machine.stl import stl_bytes

from gcodesim.cli import main
from gcodesim.machine import shapes
from gcodesim.machine.formats.link_poses import angles_of, turn_of
from gcodesim.machine.kinematics import transform, world_from_link
from gcodesim.machine.loading import load_machine
from gcodesim.machine.model import Machine

RIGHT = "1.5707963267948966"
URDF = f"""\
<?xml version="1.0"?>
<robot name="small arm">
  <link name="base"/>
  <link name="frame"><visual><geometry><box size="1 1 0.1"/></geometry></visual></link>
  <link name="carriage">
    <visual><origin xyz="0 0 9"/><geometry><sphere radius="0.5"/></geometry></visual>
    <collision><origin xyz="0 0 0.01"/><geometry><sphere radius="0.03"/></geometry></collision>
    <collision name="rod"><origin rpy="0 {RIGHT} 0"/>
      <geometry><cylinder radius="0.02" length="0.3"/></geometry></collision>
  </link>
  <link name="tilt.plate">
    <collision><origin xyz="0.05 0 0"/><geometry><box size="0.2 0.1 0.04"/></geometry></collision>
    <collision><geometry>
      <mesh filename="package://arm/meshes/part.stl" scale="0.001 0.001 0.001"/>
    </geometry></collision>
  </link>
  <link name="tip"/>
  <joint name="weld" type="fixed"><parent link="base"/><child link="frame"/>
    <origin xyz="0.1 0 0.5" rpy="0 0 {RIGHT}"/></joint>
  <joint name="x_joint" type="prismatic"><parent link="frame"/><child link="carriage"/>
    <origin xyz="0 0.2 0"/><axis xyz="2 0 0"/>
    <limit lower="-0.1" upper="0.25" velocity="0.5" effort="1"/></joint>
  <joint name="shoulder" type="revolute"><parent link="carriage"/><child link="tilt.plate"/>
    <origin xyz="0 0 0.1" rpy="{RIGHT} 0 0"/><axis xyz="0 0 1"/>
    <limit lower="{math.radians(-30)}" upper="{math.radians(120)}" velocity="1" effort="1"/>
    <dynamics damping="1"/></joint>
  <joint name="spin" type="continuous"><parent link="tilt.plate"/><child link="tip"/>
    <origin xyz="0 0 0.3"/><axis xyz="0 1 0"/></joint>
</robot>
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A package `arm` with its robot and a mesh drawn in millimetres."""
    package = tmp_path / "arm"
    (package / "meshes").mkdir(parents=True)
    mesh = shapes.box([100, 20, 10], [7, 0, 0])
    (package / "meshes" / "part.stl").write_bytes(stl_bytes(mesh))
    (package / "arm.urdf").write_text(URDF)
    return package


def imported(folder: Path) -> Machine:
    """The machine of the robot, through the command and the file that it writes."""
    args = ["machine", "import", str(folder / "arm.urdf"), "--out", str(folder / "arm.yaml")]
    result = CliRunner().invoke(main, args)
    assert result.exit_code == 0, result.output
    return load_machine(str(folder / "arm.yaml"))


def test_joints_are_in_the_world_in_mm_and_degrees(folder: Path) -> None:
    machine = imported(folder)
    assert machine.name == "small_arm"
    # The fixed joint makes frame a part of base; its quarter turn about z sends x to y.
    assert machine.links == ("base", "carriage", "tilt_plate", "tip")
    x, a, c = machine.joints
    assert [j.name for j in machine.joints] == ["X", "A", "C"]
    np.testing.assert_allclose([x.axis, a.axis, c.axis], [[0, 1, 0], [1, 0, 0], [0, 0, 1]],
                               atol=1e-15)  # fmt: skip
    assert (x.lower, x.upper, x.rapid) == pytest.approx((-100, 250, 500), rel=1e-14)
    assert (a.lower, a.upper) == pytest.approx((-30, 120), rel=1e-14)
    assert a.rapid == pytest.approx(math.degrees(1.0), rel=1e-14)
    np.testing.assert_allclose(a.point, [-100, 0, 600], atol=1e-12)
    # 0.3 m along z of the tilted frame, which is x of the world.
    np.testing.assert_allclose(c.point, [200, 0, 600], atol=1e-12)
    assert (c.lower, c.upper, c.rapid) == (-np.inf, np.inf, 60.0)


def test_forward_kinematics_by_hand(folder: Path) -> None:
    """X 10 mm, A 90, C 90 deg: the origin of the tip, and a point 1 mm along its x, y and z."""
    machine = imported(folder)
    at_zero = np.array([[200, 0, 600], [201, 0, 600], [200, 1, 600], [200, 0, 601]], float)
    pose = world_from_link(machine, np.array([10.0, 90.0, 90.0]))["tip"]
    # C: x to y, y to -x; then A about the x axis through (-100, 0, 600): y to z, z to -y; and 10 y.
    expected = [[200, 10, 600], [200, 10, 601], [199, 10, 600], [200, 9, 600]]
    np.testing.assert_allclose(transform(pose, at_zero), expected, atol=1e-11)


def boxes(machine: Machine, body: str) -> dict[str, np.ndarray]:
    """Name of each part -> its lowest and highest corner [mm]."""
    return {
        part.name: np.array([part.triangles.min(axis=(0, 1)), part.triangles.max(axis=(0, 1))])
        for part in machine.bodies[body].parts
    }


def test_shapes_are_placed_in_the_world(folder: Path) -> None:
    machine = imported(folder)
    np.testing.assert_allclose(
        boxes(machine, "base")["base"], [[-400, -500, 450], [600, 500, 550]], atol=1e-9
    )
    plate = boxes(machine, "tilt_plate")
    # Local x, y, z of the plate are y, z, x of the world.
    np.testing.assert_allclose(plate["tilt_plate"], [[-120, -50, 550], [-80, 150, 650]], atol=1e-9)
    np.testing.assert_allclose(
        plate["tilt_plate_2"],
        [[-105, -43, 590], [-95, 57, 610]],
        atol=1e-5,  # STL holds floats
    )
    rod, ball = boxes(machine, "carriage")["rod"], boxes(machine, "carriage")["carriage"]
    # The rod lies along z of its frame turned about y: x of the carriage, y of the world.
    np.testing.assert_allclose(rod.mean(axis=0), [-100, 0, 500], atol=1e-9)
    np.testing.assert_allclose(rod[1, 1] - rod[0, 1], 300, atol=1e-9)
    np.testing.assert_allclose(ball[:, 2], [480, 540], atol=1e-9)


def test_a_sphere_is_drawn_around(folder: Path) -> None:
    machine = imported(folder)
    ball = next(p for p in machine.bodies["carriage"].parts if p.name == "carriage").triangles
    centre = np.array([-100, 0, 510])
    normal = np.cross(ball[:, 1] - ball[:, 0], ball[:, 2] - ball[:, 0])
    flat = normal / np.linalg.norm(normal, axis=1)[:, None]
    away = np.einsum("ij,ij->i", ball[:, 0] - centre, flat)
    assert away.min() >= 30.0 - 1e-9  # every face lies outside, or touches
    assert np.linalg.norm(ball - centre, axis=2).max() < 30.0 * 1.02


def test_turns_and_angles_are_inverse() -> None:
    rng = np.random.default_rng(5)
    turns = [turn_of(rng.uniform(-np.pi, np.pi, 3)) for _ in range(200)]
    turns += [turn_of(np.array([roll, pitch, 0.7])) for roll in (0.0, 2.0) for pitch in
              (np.pi / 2, -np.pi / 2, 1.5707963, 1.57079)]  # fmt: skip
    for turn in turns:
        np.testing.assert_allclose(turn_of(np.radians(angles_of(turn))), turn, atol=1e-14)


def test_what_is_left_behind_is_said_twice(folder: Path) -> None:
    (folder / "meshes" / "part.stl").unlink()
    result = CliRunner().invoke(main, ["machine", "import", str(folder / "arm.urdf")])
    assert result.exit_code == 0
    for said in (
        "mesh package://arm/meshes/part.stl: no such file",
        "joint shoulder became the axis A: rename it",
        "joint spin: no velocity, rapid 3600 deg/min assumed",
        "<dynamics> are not carried over",
        "tool and work: URDF does not say where they are",
    ):
        assert f"#   - {said}" in result.stdout
        assert said in result.stderr
    assert "# tool: {link: tip, " in result.stdout


def test_meshes_of_two_units_are_told_apart(folder: Path) -> None:
    mesh = '<visual><geometry><mesh filename="meshes/part.stl"/></geometry></visual>'
    tip = f'<link name="tip">{mesh}</link>'
    (folder / "arm.urdf").write_text(URDF.replace('<link name="tip"/>', tip))
    machine = imported(folder)
    yaml = (folder / "arm.yaml").read_text()
    assert "units: m\n" in yaml
    assert "mesh meshes/part.stl is in mm, others in m: convert it" in yaml
    sources = [p.source for body in machine.bodies.values() for p in body.parts]
    assert sources.count("meshes/part.stl") == 1


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("<robot", "<!DOCTYPE robot [<!ENTITY a 'b'>]>\n<robot",
         ":2: a document type or entity is refused"),
        ("<link name=\"base\"/>", "<link name=\"base\">", "no valid XML: mismatched tag"),
        ('version="1.0"', 'version="1.0" encoding="none-such"', "1: no valid XML: unknown enc"),
        ("<robot name", "<arm name", "no valid XML"),
        ("  <link name=\"base\"/>", "  <xacro:x xmlns:xacro='u'/><link name=\"base\"/>",
         ":3: xacro:x: macros are not expanded here: run xacro first"),
        ("<link name=\"tip\"/>", "<link name=\"base\"/>",
         ":17: link base: there is a second link 'base'"),
        ("<link name=\"tip\"/>", "<link/>", ":17: link: <link> needs name="),
        ("<link name=\"tip\"/>", "<link name=\"tip\"/><link name=\"loose\"/>",
         ":2: robot small arm: exactly one link must have no parent; found base, loose"),
        ("<child link=\"tip\"/>", "<child link=\"carriage\"/>",
         ":27: joint spin: link 'carriage' hangs on two joints"),
        ("<child link=\"tip\"/>", "<child link=\"top\"/>", "child 'top' is no link of this file"),
        ("<child link=\"tip\"/>", "", ":27: joint spin: a joint needs <child link=\"...\"/>"),
        ("type=\"continuous\"", "type=\"planar\"",
         ":27: joint spin: joint type 'planar' cannot be turned; valid: revolute, continuous,"),
        ("upper=\"0.25\"", "upper=\"-0.1\"", ":22: limit: lower -0.1 must be below upper -0.1"),
        ("upper=\"0.25\"", "upper=\"wide\"", "expected numbers as in upper=\"0\", not 'wide'"),
        ("<axis xyz=\"0 1 0\"/>", "<axis xyz=\"0 0 0\"/>", ":27: joint spin: an axis of length 0"),
        ("<axis xyz=\"0 1 0\"/>", "<axis xyz=\"0 1\"/>", "as in xyz=\"0 0 1\", not '0 1'"),
        ("radius=\"0.03\"", "radius=\"-1\"", ":7: sphere: sizes must be above 0"),
        ("radius=\"0.03\"", "", ":7: sphere: <sphere> needs radius="),
        ("<sphere radius=\"0.03\"/>", "<torus/>", ":7: torus: expected box, cylinder, sphere"),
    ],
)  # fmt: skip
def test_what_is_wrong_names_file_and_line(old: str, new: str, said: str, folder: Path) -> None:
    assert old in URDF
    (folder / "arm.urdf").write_text(URDF.replace(old, new, 1))
    result = CliRunner().invoke(main, ["machine", "import", str(folder / "arm.urdf")])
    assert (result.exit_code, result.stdout) == (2, "")
    assert said in result.stderr
    assert "Traceback" not in result.stderr


def test_a_fourth_slide_stands(folder: Path) -> None:
    links = "".join(f'<link name="l{i}"/>' for i in range(5))
    joints = "".join(
        f'<joint name="j{i}" type="prismatic"><parent link="l{i}"/><child link="l{i + 1}"/>'
        '<limit lower="0" upper="1"/></joint>'
        for i in range(4)
    )
    (folder / "arm.urdf").write_text(f"<robot>{links}{joints}</robot>")
    out = str(folder / "arm.yaml")
    result = CliRunner().invoke(main, ["machine", "import", str(folder / "arm.urdf"), "--out", out])
    assert result.exit_code == 0
    assert "joint j3 became axis_j3, which stands at its `start`" in result.stderr
    assert set(load_machine(out).axes) == {"X", "Y", "Z", "axis_j3"}
