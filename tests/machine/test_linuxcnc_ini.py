"""LinuxCNC INI files become machines whose poses are those of the kinematics modules."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from machine.five_axis import tip_position

from gcodesim.cli import main
from gcodesim.errors import ModelError, UsageError
from gcodesim.machine.formats.linuxcnc_ini import import_ini
from gcodesim.machine.kinematics import world_from_link
from gcodesim.machine.loading import load_machine
from gcodesim.machine.model import Machine

INI = """\
[EMC]
MACHINE = My Mill (test)
[KINS]
KINEMATICS = {kins}
JOINTS = 5
[TRAJ]
COORDINATES = {coordinates}
  LINEAR_UNITS = {unit}
ANGULAR_UNITS = degree
[HAL]
HALCMD = setp motion.analog-out-03 1
{hal}
"""
JOINT = """\
[JOINT_{n}]
TYPE = {type}          # of motion
HOME = {home}
MIN_LIMIT = {low}
MAX_LIMIT = {high}
MAX_VELOCITY = {speed}
MAX_ACCELERATION = 800
"""
TRT = """\
HALCMD = setp {0}.x-rot-point 5
HALCMD = setp {0}.y-rot-point -7
HALCMD = setp {0}.z-rot-point [GEOMETRY]ROT_Z
HALCMD = net :side {0}.{1}-offset gui.side
HALCMD = sets :side 12
HALCMD = setp {0}.z-offset 30
[GEOMETRY]
ROT_Z = 11
"""
POINT = np.array([30.0, -10.0, 80.0])


def ini(
    kins: str, coordinates: str, hal: str, unit: str = "mm", order: str = "", **more: object
) -> str:
    """An INI file with a joint for every letter."""
    text = INI.format(kins=kins, coordinates=coordinates, unit=unit, hal=hal)
    for n, letter in enumerate(order or coordinates):
        linear = letter in "XYZUVW"
        values = {"type": "LINEAR" if linear else "ANGULAR", "home": 0, "low": -200, "high": 150}
        text += JOINT.format(n=n, **{**values, "speed": 20 if linear else 30, **more})
    return text


def imported(folder: Path, text: str) -> Machine:
    """The machine of an INI file, through the command and the file that it writes."""
    (folder / "mill.ini").write_text(text)
    args = ["machine", "import", str(folder / "mill.ini"), "--out", str(folder / "mill.yaml")]
    result = CliRunner().invoke(main, args)
    assert result.exit_code == 0, result.output
    assert result.stdout == ""
    return load_machine(str(folder / "mill.yaml"))


def part_point(machine: Machine, axes: dict[str, float]) -> np.ndarray:
    """Where the tip of a tool of length 0 stands in the part, by forward kinematics alone."""
    q = np.array([axes[name] for name in machine.axes])
    pose = world_from_link(machine, q)[machine.work_link or ""]
    return np.linalg.inv(pose)[:3] @ np.append(tip_position(machine, q, 0.0), 1.0)


@pytest.mark.parametrize(
    ("kins", "side", "tilt", "joints"),
    [
        ("xyzac-trt-kins", "y", "A", (24.79898987, -11.42011126, 76.55316534)),
        ("xyzbc-trt-kins", "x", "B", (43.25412335, 8.55634919, 70.87549581)),
    ],
)
def test_tilting_tables(
    kins: str, side: str, tilt: str, joints: tuple[float, ...], tmp_path: Path
) -> None:
    hal = TRT.format(kins, side)
    machine = imported(tmp_path, ini(f"{kins} sparm=identityfirst", f"XYZ{tilt}C", hal))
    axes = {**dict(zip("XYZ", joints, strict=True)), tilt: 30.0, "C": 45.0}
    np.testing.assert_allclose(part_point(machine, axes), POINT, atol=2e-8)
    tilting = next(joint for joint in machine.joints if joint.name == tilt)
    np.testing.assert_array_equal(tilting.point, [5, 5, 41] if tilt == "A" else [17, -7, 41])
    assert (machine.name, machine.readings.dialect) == ("My_Mill_test", "linuxcnc")
    assert not machine.verified


# B of both modules turns about -y: the hand-computed poses of 30 degrees about +y are those of -30.
@pytest.mark.parametrize(
    ("kins", "pivot"),
    [
        ("5axiskins", (136.06601718, 96.06601718, 339.80762114)),
        ("maxkins", (164.14213562, -28.28427125, 339.80762114)),
    ],
)
@pytest.mark.parametrize(("unit", "length"), [("mm", 300.0), ("inch", 300.0 / 25.4)])
def test_tilting_heads(
    kins: str, pivot: tuple[float, ...], unit: str, length: float, tmp_path: Path
) -> None:
    order = "XYZABCUVW" if kins == "maxkins" else ""
    hal = f"HALFILE = pivot.hal\nHALFILE = LIB:basic_sim.tcl\n[HEAD]\nLENGTH = {length!r}"
    (tmp_path / "pivot.hal").write_text(f"setp {kins}.pivot-length [HEAD]LENGTH # to the tip\n")
    machine = imported(tmp_path, ini(kins, "XYZBC", hal, unit, order))
    x, y, z = pivot
    axes = {"X": x, "Y": y, "Z": z - 300.0, "B": -30.0, "C": 45.0}
    np.testing.assert_allclose(part_point(machine, axes), POINT, atol=2e-8)


def test_travels_speeds_and_start_are_converted(tmp_path: Path) -> None:
    text = ini("trivkins coordinates=XYZA", "XYZA", "", "inch", home=3, low=-2, high=4)
    text += "[AXIS_A]\nWRAPPED_ROTARY = 1\n"
    machine = imported(tmp_path, text)
    x, a = machine.joints[0], machine.joints[3]
    assert (x.lower, x.upper) == (-50.8, 101.6)
    assert x.rapid == pytest.approx(20 * 25.4, rel=1e-14)
    assert x.max_acceleration == pytest.approx(800 * 25.4, rel=1e-14)
    assert (a.lower, a.upper, a.rapid, a.wrap) == (-np.inf, np.inf, 30.0, "sign")
    assert machine.start == pytest.approx({"X": 76.2, "Y": 76.2, "Z": 76.2, "A": 3.0})


def test_the_joint_counts_before_the_axis_and_both_may_be_missing(tmp_path: Path) -> None:
    text = "[TRAJ]\nCOORDINATES = X Y\n[JOINT_0]\nMAX_LIMIT = 7\nMIN_LIMIT = -1e99\n"
    text = text.replace("-1e99", "-7") + "[AXIS_X]\nMAX_LIMIT = 9\nMIN_LIMIT = -9\nMAX_VELOCITY=2\n"
    x, y = imported(tmp_path, text).joints
    assert (x.lower, x.upper, x.rapid) == (-7.0, 7.0, 2.0)
    assert (y.lower, y.upper, y.rapid) == (-np.inf, np.inf, 1.0)


def test_what_is_left_behind_is_said_twice(tmp_path: Path) -> None:
    text = ini("5axiskins coordinates=XYZBCWY", "XYZBCWY", "HALCMD = setp 5axiskins.tilt 4")
    text += "[AXIS_W]\nMAX_LIMIT = 9\n[EMCIO]\nTOOL_TABLE = my.tbl\n"
    (tmp_path / "mill.ini").write_text(text)
    result = CliRunner().invoke(main, ["machine", "import", str(tmp_path / "mill.ini")])
    assert result.exit_code == 0
    for said in (
        "no number was found for 5axiskins.pivot-length: its default 250 is used",
        "5axiskins.tilt = 4 is not carried over",
        "axis W: it stands; give it a joint and a `start` if it carries things",
        "joints Y: several joints drive the axis",
        "[EMCIO]TOOL_TABLE = my.tbl: tools: give the file to --tools",
        "shapes: an INI file has none",
    ):
        assert f"#   - {said}" in result.stdout
        assert said in result.stderr
    (tmp_path / "mill.yaml").write_text(result.stdout)
    machine = load_machine(str(tmp_path / "mill.yaml"))
    assert machine.axes == ("X", "Y", "Z", "C", "B")


def test_included_files_are_read_in_their_place(tmp_path: Path) -> None:
    (tmp_path / "axes.inc").write_text("[TRAJ]\nCOORDINATES = XZ\n[JOINT_1]\nMIN_LIMIT = far\n")
    with pytest.raises(ModelError, match=r"axes\.inc:4: \[JOINT_1\]MIN_LIMIT: expected a number"):
        imported_text(tmp_path, "[EMC]\n#INCLUDE axes.inc\n")
    with pytest.raises(UsageError, match=r"none\.inc: cannot be read"):
        imported_text(tmp_path, "[EMC]\n#INCLUDE none.inc\n")
    (tmp_path / "axes.inc").write_text("#INCLUDE axes.inc\n")
    with pytest.raises(ModelError, match=r"axes\.inc:1: files include each other"):
        imported_text(tmp_path, "[EMC]\n#INCLUDE axes.inc\n")


def imported_text(folder: Path, text: str) -> str:
    (folder / "mill.ini").write_text(text)
    return import_ini(str(folder / "mill.ini")).text


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("[EMC]", "EMC", ":1: expected a [SECTION] before the first key"),
        ("JOINTS = 5", "= 5", ":5: expected [SECTION], KEY = value or a comment"),
        ("trivkins", "trivkin", ":4: [KINS]KINEMATICS: kinematics trivkin cannot be turned; did"),
        ("trivkins", "maxkin", "valid: xyzac-trt-kins, xyzbc-trt-kins, 5axiskins, maxkins, triv"),
        ("trivkins", "xyzbc-trt-kins", ":7: [TRAJ]COORDINATES: xyzbc-trt-kins needs an axis B"),
        ("COORDINATES = XYZAC", "", ":6: [TRAJ]: COORDINATES is missing"),
        ("= XYZAC", "= AC", ":7: [TRAJ]COORDINATES: there is no axis X, Y or Z"),
        ("= mm", "= ell", ":8: [TRAJ]LINEAR_UNITS: unknown unit 'ell'; valid: mm"),
        ("[JOINT_1]\nTYPE = LINEAR", "[JOINT_1]\nTYPE = ANGULAR", ":21: [JOINT_1]TYPE: axis Y"),
        ("[JOINT_0]\n", "[JOINT_0]\nMAX_VELOCITY = 0\n[x]\n", ":14: [JOINT_0]MAX_VELOCITY: a sp"),
        ("[JOINT_0]\n", "[JOINT_0]\nMIN_LIMIT = 5\nMAX_LIMIT = 5\nMAX_VELOCITY = 1\n[x]\n",
         ":14: [JOINT_0]MIN_LIMIT: MIN_LIMIT 5 of X is not below MAX_LIMIT 5"),
        ("[JOINT_0]\n", "[JOINT_0]\nMIN_LIMIT = 5\n[x]\n", "X has one limit only"),
        ("HOME = 0", "HOME = nan", "[JOINT_0]HOME: expected a number, not 'nan'"),
    ],
)  # fmt: skip
def test_what_is_wrong_names_file_and_line(old: str, new: str, said: str, tmp_path: Path) -> None:
    text = ini("trivkins", "XYZAC", "")
    assert old in text
    (tmp_path / "mill.ini").write_text(text.replace(old, new, 1))
    result = CliRunner().invoke(main, ["machine", "import", str(tmp_path / "mill.ini")])
    assert (result.exit_code, result.stdout) == (2, "")
    assert said in result.stderr
    assert "Traceback" not in result.stderr


@pytest.mark.parametrize(
    ("name", "data"), [("m.ini", b"\xff\xfe\x00"), ("m.txt", b""), ("m.urdf", b"")]
)
def test_files_that_are_none_of_it(name: str, data: bytes, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(data)
    result = CliRunner().invoke(main, ["machine", "import", str(tmp_path / name)])
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.startswith("gcodesim: ")
    missing = CliRunner().invoke(main, ["machine", "import", str(tmp_path / f"no-{name}")])
    assert missing.exit_code == 2
