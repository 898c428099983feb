"""Slides that are not square: trace, check and the tip of the mesh agree on what X Y Z mean."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from machine.five_axis import random_machine, solved, tip_position

from gcodesim import Options, check
from gcodesim.machine.control_data import control_for
from gcodesim.machine.kinematics import transform, world_from_link
from gcodesim.machine.loading import load_machine
from gcodesim.machine.model import Machine
from gcodesim.motion.planner import plan
from gcodesim.nc.control.frames import inverse, product
from gcodesim.nc.interpret import interpret

LENGTH = 100.0
Y = (math.sin(math.radians(20)), math.cos(math.radians(20)), 0.0)
Z = (0.0, math.sin(math.radians(5)), math.cos(math.radians(5)))
F = np.column_stack([(1.0, 0.0, 0.0), Y, Z])
GAUGE = np.array([0.0, 0.0, 300.0])
MODEL = """
name: skew
links: {{bed: {{}}, X: {{}}, Y: {{}}, Z: {{}}, A: {{}}, C: {pin}}}
joints:
  A: {{type: rotary, parent: bed, child: A, axis: [-1, 0, 0], point: [0, 0, 0], rapid: 9000}}
  C: {{type: rotary, parent: A, child: C, axis: [0, 0, -1], point: [0, 0, 0], rapid: 9000}}
  X: {{type: linear, parent: bed, child: X, axis: [1, 0, 0], rapid: 9000}}
  Y: {{type: linear, parent: X, child: Y, axis: [{y[0]}, {y[1]}, 0], rapid: 9000}}
  Z: {{type: linear, parent: Y, child: Z, axis: [0, {z[1]}, {z[2]}], rapid: 9000}}
tool:
  link: Z
  gauge_point: [0, 0, 300]
  axis: [0, 0, 1]
  mounted: {{name: tool, length: 100, for: all, cylinder: {{radius: 0.5, height: 100,
    center: [0, 0, 250]}}}}
work: {{link: C, offsets: {{G54: {{X: 10, Y: 20, Z: -250}}}}}}
start: {{X: 0, Y: 0, Z: 300, A: 0, C: 0}}
"""
HEAD = "G21 G90 G54\nT1 M6\nS1000 M3\n"
TIPS = f"{HEAD}G43.4 H1\nG0 X0 Y0 Z100.\nA20. C30.\nG1 X30. Y40. Z5. F1000\nA-10. C75.\nM30\n"
SLIDES = f"{HEAD}G43 H1\nG0 X30. Y40. Z100.\nG1 Z5. F1000\nM30\n"
POINT = np.array([30.0, 40.0, 5.0]) + (10.0, 20.0, -250.0)
"""The last point of both programs, with the work offset."""


def write(folder: Path, text: str, pin: str = "{}") -> tuple[Path, Path]:
    model, program = folder / "skew.yaml", folder / "part.nc"
    model.write_text(MODEL.format(y=Y, z=Z, pin=pin))
    program.write_text(text)
    return program, model


def traced(program: Path, model: Path) -> tuple[Machine, np.ndarray]:
    """The machine, and the joint positions at each end of a block."""
    machine = load_machine(str(model))
    meaning = interpret(program.read_text(), control_for(machine, None, None, False))
    assert not meaning.stopped
    path, _ = plan(meaning.program, machine)
    ends = np.append(np.flatnonzero(np.diff(path.line)), len(path) - 1)
    return machine, path.positions(path.bounds_ps[1:][ends])


def seen_from_the_part(machine: Machine, q: np.ndarray) -> np.ndarray:
    """Where the tip of the mesh is in the part, by the displacements of the links alone."""
    back = np.linalg.inv(world_from_link(machine, q)[machine.work_link])
    return np.array([transform(back, tip_position(machine, q, LENGTH))])[0]


def test_under_tip_control_the_tip_of_the_mesh_is_at_the_point_along_the_slides(
    tmp_path: Path,
) -> None:
    machine, positions = traced(*write(tmp_path, TIPS))
    wanted = GAUGE + F @ POINT
    for q in positions[-2:]:  # the rotary axes turn in the last block, and the tip stays
        np.testing.assert_allclose(seen_from_the_part(machine, q), wanted, atol=1e-9)
    assert np.ptp(positions[-2:], axis=0).max() > 10.0


def test_without_it_words_are_positions_of_the_slides(tmp_path: Path) -> None:
    machine, positions = traced(*write(tmp_path, SLIDES))
    slides = [positions[-1][[j.name for j in machine.joints].index(name)] for name in "XYZ"]
    np.testing.assert_allclose(slides, POINT + (0.0, 0.0, LENGTH), atol=1e-12)
    wanted = GAUGE + F @ slides - (0.0, 0.0, LENGTH)
    np.testing.assert_allclose(tip_position(machine, positions[-1], LENGTH), wanted, atol=1e-9)


@pytest.mark.parametrize(
    ("text", "tip"),
    [
        (TIPS, GAUGE + F @ POINT),
        (SLIDES, GAUGE + F @ (POINT + (0.0, 0.0, LENGTH)) - (0.0, 0.0, LENGTH)),
    ],
)
def test_a_check_finds_the_pin_at_the_tip_and_none_where_square_slides_would_touch(
    tmp_path: Path, text: str, tip: np.ndarray
) -> None:
    def verdict(centre: np.ndarray) -> str:
        x, y, z = centre - (0.0, 0.0, 2.0)
        pin = f"{{cylinder: {{radius: 1, height: 4.2, center: [{x}, {y}, {z}]}}}}"
        return check(*write(tmp_path, text, pin), options=Options(device="cpu")).verdict

    square = GAUGE + POINT
    assert np.linalg.norm(square - tip) > 5.0
    assert (verdict(tip), verdict(square)) == ("fail", "pass")


def test_the_tip_of_any_machine_is_that_of_its_tool(rng: np.random.Generator) -> None:
    """The slide Z of these machines points anywhere, and the tool along its own axis."""
    for _ in range(50):
        machine = random_machine(rng)
        centre = solved(machine)
        points, rotary = rng.uniform(-200, 200, (5, 3)), rng.uniform(-80, 80, (5, 3))
        axes = centre.axes_at(points, rotary, np.array([0.0, 0.0, LENGTH]))
        for point, row in zip(points, axes, strict=True):
            q = np.array([row["XYZABC".index(joint.name)] for joint in machine.joints])
            wanted = machine.tool.gauge_point + centre.frame @ point
            np.testing.assert_allclose(seen_from_the_part(machine, q), wanted, atol=1e-6)


def test_a_turn_seen_in_skew_coordinates_is_taken_back_by_its_inverse() -> None:
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    seen = tuple(map(tuple, (np.linalg.inv(F) @ turn @ F).tolist()))
    np.testing.assert_allclose(product(inverse(seen), seen), np.eye(3), atol=1e-14)
    assert inverse(tuple(map(tuple, turn.tolist()))) == tuple(map(tuple, turn.T.tolist()))
