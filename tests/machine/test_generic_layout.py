"""Machines of any layout that `machine new` writes: clean, and right on the first program."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from gcodesim.checking.lint import lint
from gcodesim.cli import main
from gcodesim.errors import UsageError
from gcodesim.machine.generic_layout import Layout, layout_text
from gcodesim.machine.kinematics import world_from_link
from gcodesim.machine.loading import load_machine
from gcodesim.machine.tool_centre import tool_centre

LAYOUTS = {
    "trunnion AC": Layout("YX", "AC"),
    "trunnion BC on X": Layout("X", "BC", travel=(500.0, 450.0, 400.0)),
    "fork CB": Layout("", "", "CB"),
    "mixed C, B": Layout("Y", "C", "B", (200.0, 150.0, 120.0), (-30.0, 95.0)),
    "four axes A": Layout("XY", "A"),
    "four axes, head B": Layout("X", "", "B"),
    "three axes": Layout("YX"),
    "gantry": Layout(""),
}
PROGRAM = (
    "G21 G90 G17 G54\nT1 M6\nS1000 M3\nG0 G43 H1 X0. Y0. Z60.\nG1 X20. Z50. F500\nG0 Z60.\nM30\n"
)


def run(*args: str) -> Result:
    return CliRunner().invoke(main, list(args))


@pytest.mark.parametrize("layout", LAYOUTS.values(), ids=LAYOUTS)
def test_a_machine_of_any_layout_lints_clean_and_checks(layout: Layout, tmp_path: Path) -> None:
    path, program = tmp_path / "m.yaml", tmp_path / "part.nc"
    path.write_text(layout_text(layout, "m"))
    program.write_text(PROGRAM)
    machine = load_machine(str(path))
    assert [f for f in lint(machine) if f.severity != "note"] == []
    assert sorted(machine.axes) == sorted("XYZ" + layout.rotary + layout.head)
    if len(layout.rotary + layout.head) == 2:
        assert tool_centre(machine).refusal == ""
    done = run("check", str(program), "--machine", str(path), "--sample-period", "10ms",
               "--device", "cpu")  # fmt: skip
    assert done.exit_code == 0, done.output


@pytest.mark.parametrize("layout", LAYOUTS.values(), ids=LAYOUTS)
def test_an_axis_moves_the_tool_over_the_work_as_programmed(layout: Layout, tmp_path: Path) -> None:
    """Whatever carries X, its plus is X plus of the tool seen from the work; turns likewise."""
    path = tmp_path / "m.yaml"
    path.write_text(layout_text(layout, "m"))
    machine = load_machine(str(path))
    assert machine.tool is not None
    assert machine.work_link is not None
    for column, joint in enumerate(machine.joints):
        q = np.zeros(len(machine.joints))
        q[column] = 1.0
        poses = world_from_link(machine, q)
        seen = np.linalg.inv(poses[machine.work_link]) @ poses[machine.tool.link]
        direction = np.eye(3)["XYZABC".index(joint.name) % 3]
        if joint.rotary:
            turn = seen[:3, :3] - seen[:3, :3].T
            axis = np.array([turn[2, 1], turn[0, 2], turn[1, 0]]) / 2.0
            np.testing.assert_allclose(axis, np.sin(np.radians(1.0)) * direction, atol=1e-12)
        else:
            np.testing.assert_allclose(seen[:3, 3], direction, atol=1e-12)


def test_the_command_writes_travel_and_tilt(tmp_path: Path) -> None:
    path = str(tmp_path / "mine.yaml")
    args = ("--rotary", "bc", "--table", "yx", "--travel", "500", "450", "400")
    assert run("machine", "new", path, *args, "--tilt", "-110", "110").exit_code == 0
    machine = load_machine(path)
    limits = {joint.name: (joint.lower, joint.upper) for joint in machine.joints}
    assert limits == {"X": (-250, 250), "Y": (-225, 225), "Z": (-400, 0), "B": (-110, 110),
                      "C": (-np.inf, np.inf)}  # fmt: skip
    assert [joint.child for joint in machine.joints][:4] == ["Y", "X", "B", "C"]


@pytest.mark.parametrize(
    ("layout", "text"),
    [
        ({"table": "ZX"}, "Z carries the spindle here"),
        ({"table": "XX"}, "expected slides, each once"),
        ({"rotary": "CA"}, "the axis that tilts comes first: AC or BC"),
        ({"rotary": "AC", "head": "B"}, "expected up to two of A, B and C"),
        ({"head": "C"}, "C turns about the spindle: name A or B last"),
        ({"tilt": (10.0, -10.0)}, "--tilt two angles, the lower first"),
    ],
)
def test_a_layout_that_does_not_exist_says_what_would_be_right(layout: dict, text: str) -> None:
    with pytest.raises(UsageError, match=text):
        Layout(**layout)


def test_a_kind_and_a_layout_exclude_each_other(tmp_path: Path) -> None:
    path = str(tmp_path / "m.yaml")
    refused = run("machine", "new", "three-axis", path, "--rotary", "A")
    assert refused.exit_code == 2
    assert "--rotary describes a machine of your own: leave out three-axis" in refused.output
    assert "KIND one of table-table" in run("machine", "new", "hexapod", path).output
