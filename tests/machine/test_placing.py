"""Bodies of a setup at zero points, on tables and on each other, on every kind of machine."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gcodesim.errors import ModelError
from gcodesim.machine.describe import describe
from gcodesim.machine.kinematics import transform, world_from_link
from gcodesim.machine.loading import load_machine
from gcodesim.machine.model import Machine, ZeroPoint
from gcodesim.machine.placing import PlaceError, WorkFrames

MACHINES = ("table_tilt", "head_tilt", "nutating_head", "table_head")


def load(tmp_path: Path, text: str, machine: str = "table_tilt") -> Machine:
    path = tmp_path / "setup.yaml"
    path.write_text(text)
    return load_machine(machine, setup=str(path))


def box_of(machine: Machine, name: str) -> list[list[float]]:
    points = np.concatenate([p.triangles.reshape(-1, 3) for p in machine.bodies[name].parts])
    return [points.min(axis=0).round(9).tolist(), points.max(axis=0).round(9).tolist()]


@pytest.mark.parametrize("name", MACHINES)
@pytest.mark.parametrize("turned", [0.0, 37.0])
def test_at_the_axis_positions_of_a_point_the_gauge_point_is_on_it(
    name: str, turned: float
) -> None:
    """A point (x, y, z) of G54 is where offset + (x, y, z) brings the gauge point, seen from it."""
    machine = load_machine(name)
    assert machine.tool is not None
    assert machine.work_link is not None
    rotary = {axis: turned for axis in machine.axes if axis in "ABC"}
    values = {**dict.fromkeys("ABC", 0.0), "X": 11.0, "Y": -7.0, "Z": -120.0, **rotary}
    x, y, z, a, b, c = (values[axis] for axis in "XYZABC")
    machine = replace(machine, offsets={1: ZeroPoint((x, y, z, a, b, c))})
    frame = WorkFrames.of(machine).zero_point(1, machine.work_link)
    point = np.array([3.0, -4.0, 25.0])
    moved = {**values, **{a: values[a] + p for a, p in zip("XYZ", point, strict=True)}}
    poses = world_from_link(machine, [moved[axis] for axis in machine.axes])
    gauge = transform(poses[machine.tool.link], machine.tool.gauge_point)
    on_work = transform(poses[machine.work_link], transform(frame, point))
    np.testing.assert_allclose(gauge, on_work, rtol=0, atol=1e-8)
    np.testing.assert_allclose(frame[:3, :3].T @ frame[:3, :3], np.eye(3), atol=1e-11)


def test_a_part_exported_in_its_own_zero_comes_out_right(tmp_path: Path) -> None:
    """The spindle face of table_tilt is at Z 480: with axis Z at -480 it is in the origin."""
    text = """\
offsets: {G54: {X: 10, Y: 20, Z: -480}, G55: {X: 0, Y: 0, Z: -480, R: 90}}
bodies:
  part: {role: part, frame: G54, box: {size: [100, 60, 20], center: [50, 30, -10]}}
  blank: {role: stock, frame: G55, box: {size: [100, 60, 20], center: [50, 30, -10]}}
"""
    machine = load(tmp_path, text)
    assert machine.bodies["part"].link == "C"
    assert box_of(machine, "part") == [[10, 20, -20], [110, 80, 0]]
    assert box_of(machine, "blank") == [[-60, 0, -20], [0, 100, 0]]


STANDING = """\
bodies:
  part: {role: part, on: vise.base, box: {size: [50, 30, 40], center: [0, 5, 77]}}
  vise:
    role: fixture
    on: table
    parts:
      - {name: base, box: {size: [200, 120, 60], center: [0, 0, 30]}}
      - {name: jaw, box: {size: [200, 20, 40], center: [0, 50, 80]}}
  button: {role: fixture, on: vise, cylinder: {radius: 5, height: 4}}
"""


def test_bodies_stand_on_the_table_and_on_each_other(tmp_path: Path) -> None:
    machine = load(tmp_path, STANDING)
    assert box_of(machine, "vise") == [[-100, -60, -40], [100, 60, 60]]
    assert box_of(machine, "part") == [[-25, -10, 20], [25, 20, 60]]
    assert box_of(machine, "button")[0][2] == 60
    assert {body.link for name, body in machine.bodies.items() if name in STANDING} >= {"C"}


@pytest.mark.parametrize("name", MACHINES)
def test_a_table_frame_begins_in_the_middle_of_the_mount_face(name: str, tmp_path: Path) -> None:
    machine = load_machine(name)
    assert machine.work_link is not None
    frames = WorkFrames.of(machine)
    frame, up = frames.table(machine.work_link), frames.up(machine.work_link)
    tops = np.concatenate([p.triangles for p in machine.bodies[machine.work_link].parts]) @ up
    assert frame[:3, 3] @ up == pytest.approx(tops.max())
    joint = next((joint for joint in machine.joints if joint.child == machine.work_link), None)
    if joint is not None and joint.rotary:
        off = frame[:3, 3] - joint.point
        assert np.linalg.norm(off - (off @ joint.axis) * joint.axis) < 1e-9


HORIZONTAL = """\
name: horizontal
links:
  bed: {}
  X: {box: {size: [100, 100, 100], center: [0, -300, 0]}}
  B: {box: {size: [400, 60, 400], center: [0, -130, 0]}}
  Y: {}
  Z: {box: {size: [50, 50, 50], center: [0, 0, 500]}}
joints:
  X: {type: linear, parent: bed, child: X, axis: [-1, 0, 0], rapid: 1000}
  B: {type: rotary, parent: X, child: B, axis: [0, -1, 0], point: [30, 0, 0], rapid: 1000}
  Y: {type: linear, parent: bed, child: Y, axis: [0, 1, 0], rapid: 1000}
  Z: {type: linear, parent: Y, child: Z, axis: [0, 0, 1], rapid: 1000}
tool: {link: Z, gauge_point: [0, 0, 400]}
work: {link: B, offsets: {G54: {Z: -300}, G55: {Z: -300, B: 90}}}
"""


def test_on_a_horizontal_machine_things_stand_on_the_pallet(tmp_path: Path) -> None:
    """Up is Y there; a second side of a tombstone is a zero point with another B."""
    (tmp_path / "horizontal.yaml").write_text(HORIZONTAL)
    text = """\
bodies:
  tombstone: {role: fixture, on: table, box: {size: [80, 500, 80]}}
  front: {role: part, frame: G54, box: {size: [20, 30, 10]}}
  side: {role: part, frame: G55, box: {size: [20, 30, 10]}}
"""
    machine = load(tmp_path, text, str(tmp_path / "horizontal.yaml"))
    assert box_of(machine, "tombstone") == [[-10, -100, -40], [70, 400, 40]]
    assert box_of(machine, "front") == [[-10, -15, 95], [10, 15, 105]]
    # B 90 turns the pallet: what stands before the spindle then lies at the side of it at B 0.
    low, high = box_of(machine, "side")
    assert (np.subtract(high, low) == [10, 30, 20]).all()


WRONG: dict[str, tuple[str, str, int, str]] = {
    "frame": ("frame: G54", "frame: G59", 3, r"no offset G59 is given"),
    "frame name": ("frame: G54", "frame: top", 3, "write world, table, or a work offset"),
    "on": ("frame: G54", "on: wise", 3, r"no body 'wise'; did you mean 'vise'\?"),
    "part": ("frame: G54", "on: vise.jaw", 3, "vise has no part 'jaw'"),
    "link": ("frame: G54", "on: vise, link: A", 3, "vise is on link C"),
    "ring": ("role: fixture", "role: fixture, on: part", 3, "nothing carries them all"),
    "no shape": ("frame: G54", "on: table, link: bed", 3, "link bed has no shape"),
    "unknown link": ("frame: G54", "link: D", 3, "unknown link 'D'"),
}


@pytest.mark.parametrize(("old", "new", "line", "text"), WRONG.values(), ids=WRONG)
def test_a_wrong_place_names_line_and_what_would_be_right(
    tmp_path: Path, old: str, new: str, line: int, text: str
) -> None:
    setup = """\
offsets: {G54: {Z: -380}}
bodies:
  part: {role: part, frame: G54, box: {size: [10, 10, 10]}}
  vise: {role: fixture, link: C, box: {size: [10, 10, 10]}}
"""
    if "carries" in text:
        setup = setup.replace("frame: G54", "on: vise")
    with pytest.raises(ModelError, match=text) as caught:
        load(tmp_path, setup.replace(old, new, 1))
    assert caught.value.line == line


def test_without_a_tool_there_is_no_zero_point(tmp_path: Path) -> None:
    machine: Any = load_machine("table_tilt")
    where = machine.links, machine.joints, None, machine.bodies, machine.offsets
    frames = WorkFrames(*where, machine.start)
    with pytest.raises(PlaceError, match="says nothing of a `tool`"):
        frames.zero_point(1, "C")


def test_show_prints_where_every_body_stands_in_machine_and_work_coordinates(
    tmp_path: Path,
) -> None:
    text = """\
offsets: {G54: {X: 10, Y: 20, Z: -480}, G54.1 P2: {X: 0, Y: 0, Z: -500, R: 90}}
bodies:
  part: {role: part, frame: G54, box: {size: [100, 60, 20], center: [50, 30, -10]}}
"""
    shown = describe(load(tmp_path, text))
    assert "\n".join([
        "setup",
        "  part on C, with all axes at 0",
        "    machine: X 10 .. 110, Y 20 .. 80, Z -20 .. 0",
        "    G54: X 0 .. 100, Y 0 .. 60, Z -20 .. 0",
        "    G54.1 P2: X 20 .. 80, Y -110 .. -10, Z 0 .. 20",
    ]) in shown  # fmt: skip
