"""Trees of real machines: fixed bodies beside the root, and axes of the part program."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from click.testing import CliRunner

from gcodesim.cli import main
from gcodesim.machine.describe import describe
from gcodesim.machine.kinematics import world_from_link
from gcodesim.machine.loading import load_machine

Change = Callable[[str, str], str]

PROGRAM = "G21 G90 G17 G54\nS1000 M3\nG0 X-90.\nM30\n"


def test_links_without_a_joint_stand_fixed(changed: Change) -> None:
    changed("  bed: {}", "  door: {box: {size: [9, 9, 9], center: [900, 0, 0]}}\n  bed: {}")
    machine = load_machine(changed("  Z: {revolve", "  tank: {}\n  Z: {revolve"))
    assert machine.links[:3] == ("bed", "door", "tank")
    paired = {name for p in machine.pairs for name in (p.a, p.b) if "door" in (p.a, p.b)}
    assert paired == {"door", "cutter", "A", "C", "X", "Y", "Z"}
    poses = world_from_link(machine, np.array([[10.0, 5.0, 3.0, 2.0, 1.0]]))
    assert (poses["door"] == np.eye(4)).all()
    shown = describe(machine)
    assert "  bed (root)\n" in shown
    assert "\n  door (fixed)\n  tank (fixed)\n" in shown


def test_a_fixed_body_is_found_by_the_search(changed: Change) -> None:
    """The cradle reaches X 100 + 90 where axis X is at -90, for X carries it."""
    post = "  post: {box: {size: [20, 20, 90], center: [170, 0, 30]}}\n"
    path = changed("  Z: {revolve", f"{post}  Z: {{revolve")
    program = path.replace("tiny.yaml", "part.nc")
    with open(program, "w") as file:
        file.write(PROGRAM)
    args = ["check", program, "--machine", path, "--device", "cpu", "--sample-period", "10ms"]
    done = CliRunner().invoke(main, [*args, "--rapids", "linear"])
    assert done.exit_code == 1, done.output
    assert "post" in done.output


def test_on_the_work_side_the_axis_may_be_that_of_the_part_program(changed: Change) -> None:
    plain = load_machine(changed("name: tiny", "name: tiny"))
    changed("  X: {mesh: meshes/X.stl}", "  X: {side: work, mesh: meshes/X.stl}")
    changed("  A: {parts:", "  A: {side: work, parts:")
    changed("axis: [-3, 0, 0]", "axis: [3, 0, 0]")
    changed("axis: [-1, 0, 0], point: [0, 5, 7]", "axis: [1, 0, 0], point: [0, 5, 7]")
    changed("  Z: {revolve", "  Z: {side: tool, revolve")
    machine = load_machine(changed("name: tiny", "name: tiny"))
    for joint, before in zip(machine.joints, plain.joints, strict=True):
        assert joint.name == before.name
        np.testing.assert_array_equal(joint.axis, before.axis)
