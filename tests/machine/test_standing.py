"""Axes of other names than X Y Z A B C: they stand where `start` puts them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from gcodesim.cli import main
from gcodesim.errors import ModelError
from gcodesim.machine.kinematics import world_from_link
from gcodesim.machine.loading import load_machine
from gcodesim.machine.placing import WorkFrames
from gcodesim.machine.standing import joint_positions
from gcodesim.machine.tool_centre import tool_centre

Change = Callable[[str, str], str]

W = "W: {type: linear, parent: Z, child: quill, axis: [0, 0, 1], limits: [-150, 0], rapid: 6000}"
SWIVEL = (
    "B1: {type: rotary, parent: bed, child: swivel, axis: [0, 1, 0], point: [9, 0, 0], rapid: 9}"
)
PROGRAM = "G21 G90 G17 G54\nS1000 M3\nG0 Z-40.\nG1 X5. F500.\nM30\n"


@pytest.fixture
def quill(changed: Change) -> str:
    """The machine whose spindle stands in a quill that is 50 mm out, on a swivel for the table."""
    changed("  Z: {revolve", "  quill: {}\n  swivel: {}\n  Z: {revolve")
    changed("parent: bed, child: Y", "parent: swivel, child: Y")
    changed("tool:\n  link: Z", f"  {W}\n  {SWIVEL}\ntool:\n  link: quill")
    return changed("start: {Z: 100}", "start: {Z: 100, W: -50, B1: 20}")


def check(path: str, program: str = PROGRAM) -> Result:
    part = Path(path).with_name("part.nc")
    part.write_text(program)
    args = ["check", str(part), "--machine", path, "--device", "cpu", "--rapids", "linear"]
    return CliRunner().invoke(main, [*args, "--sample-period", "10ms"])


def test_a_quill_that_is_out_carries_the_tool_deeper(changed: Change, quill: str) -> None:
    """The cutter of 100 mm ends at Z 300 - 50 - 100; the post below it reaches 151.5."""
    body = "  post: {box: {size: [9, 9, 9], center: [0, 0, 147]}}\n"
    hit = check(changed("  quill: {}", f"  quill: {{}}\n{body}"))
    assert hit.exit_code == 1, hit.output
    assert "W: programs move X Y Z A B C only; it stands at -50 mm (`start`)" in hit.output
    assert "W -50.0000" in hit.output
    assert check(changed("W: -50", "W: -40")).exit_code == 0


def test_standing_axes_turn_and_shift_what_they_carry(quill: str) -> None:
    """Tips found by the tool centre are those of the poses of all links."""
    machine = load_machine(quill)
    centre = tool_centre(machine)
    assert centre is not None
    assert not centre.refusal
    rng = np.random.default_rng(5)
    axes = np.zeros((50, 6))
    axes[:, [0, 1, 2, 3, 5]] = rng.uniform(-90, 30, (50, 5))
    poses = world_from_link(machine, joint_positions(machine, axes))
    seen, zero = [], world_from_link(machine, joint_positions(machine, np.zeros((1, 6))))
    for work, quill_pose in zip(poses["C"], poses["quill"], strict=True):
        gauge = np.append([0.0, 0.0, 300.0 - 80.0], 1.0)
        seen.append((zero["C"][0] @ np.linalg.solve(work, quill_pose @ gauge))[:3])
    away = np.array(seen) - (zero["quill"][0] @ [0.0, 0.0, 220.0, 1.0])[:3]
    tips = centre.tips(axes, [0.0, 0.0, 80.0])
    start = centre.tips(np.zeros((1, 6)), [0.0, 0.0, 80.0])
    np.testing.assert_allclose((tips - start) @ centre.frame.T, away, atol=1e-9)


def test_the_zero_of_a_work_offset_follows_the_quill(changed: Change, quill: str) -> None:
    out = WorkFrames.of(load_machine(quill)).zero_point(1, "C")
    back = WorkFrames.of(load_machine(changed("W: -50", "W: 0"))).zero_point(1, "C")
    assert np.linalg.norm(out[:3, 3] - back[:3, 3]) == pytest.approx(50.0)


def test_a_word_for_an_axis_that_stands_is_not_followed(quill: str) -> None:
    done = check(quill, "G21 G90 G54\nG0 W-10.\nM30\n")
    assert done.exit_code == 3, done.output
    assert "W stands at its `start`: the axes that move are X Y Z A B C" in done.output


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("  W: {type: linear", "  B: {type: linear", "axis B cannot be linear: A, B and C are"),
        ("W: -50", "W2: -50", "the machine has no axis W2"),
        ("W: -50", "W: -151", "start position -151 of axis W lies outside its travel"),
        ("  W: {type: linear", "  7: {type: linear", "joints.7"),
    ],
)
def test_wrong_names_are_said_with_their_line(
    changed: Change, quill: str, old: str, new: str, message: str
) -> None:
    with pytest.raises(ModelError) as raised:
        load_machine(changed(old, new))
    assert message in str(raised.value)
    assert "tiny.yaml:" in str(raised.value)
