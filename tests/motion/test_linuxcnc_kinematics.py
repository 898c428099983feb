"""Joint positions under tool centre point control against LinuxCNC's kinematics.

Against its documented formulas always, and against its own motion controller where it is installed.
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from motion.linuxcnc_controller import joint_samples
from motion.linuxcnc_machines import LENGTH, MODULES, Array, Module

from gcodesim.checking.trace import Trace
from gcodesim.constants import TCP_DEVIATION_MM
from gcodesim.machine.control_data import control_for
from gcodesim.machine.loading import load_machine
from gcodesim.motion.path import Path as MotionPath
from gcodesim.motion.planner import plan
from gcodesim.nc.interpret import interpret

MS_PS = 10**9
CONTROLLER_MM = 1e-3
"""LinuxCNC smooths the joints over its cycles of 1 ms, by a sixth of the second difference."""

POINTS = np.array(
    # X, Y, Z of the tip in the part [mm], tilt and C [deg]
    [
        (30.0, -10.0, 80.0, 20.0, 45.0),
        (-45.0, 25.0, 60.0, -35.0, 170.0),
        (-45.0, 25.0, 60.0, 50.0, -20.0),
        (10.0, 70.0, 95.0, 50.0, 200.0),
        (60.0, 70.0, 20.0, 5.0, -300.0),
    ]
)
"""All coordinates change at once, then the rotary axes alone, then C beyond a turn."""

FIRST_LINE = 6
"""Line of the first feed block of `program`."""

each_module = pytest.mark.parametrize("module", MODULES, ids=lambda module: module.name)


def blocks(tilt: str) -> list[str]:
    """The words of every point."""
    return [f"X{x} Y{y} Z{z} {tilt}{a} C{c}" for x, y, z, a, c in POINTS.tolist()]


def program(tilt: str) -> str:
    """The points under G43.4, the first one at rapid."""
    first, *rest = blocks(tilt)
    lines = ["G21 G90 G54 G94", "T1 M6", "G43.4 H1", f"G0 {first}", "G1 F1500", *rest, "G49", "M30"]
    return "\n".join(lines)


def planned(
    module: Module, folder: Path, yaml: str = "", length: float = LENGTH
) -> tuple[MotionPath, Array, Array]:
    """The path; joints X Y Z, tilt, C of every millisecond, shape (n, 5); and their lines."""
    (folder / "m.yaml").write_text(yaml or module.yaml)
    (folder / "tools.yaml").write_text(f"tools: [{{number: 1, name: probe, length: {length}}}]")
    machine = load_machine(str(folder / "m.yaml"), tools=str(folder / "tools.yaml"))
    meaning = interpret(program(module.tilt), control_for(machine, None, None, False), "p.nc")
    assert [finding for finding in meaning.findings if finding.severity == "error"] == []
    path, _ = plan(meaning.program, machine)
    trace = Trace(path, machine, MS_PS)
    columns = [machine.axes.index(name) for name in ("X", "Y", "Z", module.tilt, "C")]
    return path, trace.positions(trace.times_ps)[:, columns], trace.lines(trace.times_ps)


def farthest(module: Module, q: Array, lines: Array) -> float:
    """Largest distance of the slides from the formulas [mm], over all feed blocks."""
    off = 0.0
    for line, (start, end) in enumerate(pairwise(POINTS), FIRST_LINE):
        of_block = q[lines == line]
        assert len(of_block) > 1000
        # The rotary axes run linearly with the way of the tip: they tell where it must be.
        s = (of_block[:, 4] - start[4]) / (end[4] - start[4])
        assert s.min() >= -1e-9
        assert s.max() <= 1.0 + 1e-9
        tips = start + s[:, None] * (end - start)
        np.testing.assert_allclose(of_block[:, 3:], tips[:, 3:], atol=1e-9)
        for row, tip in zip(of_block, tips, strict=True):
            expected = module.slides(tip[:3], row[3], row[4])
            off = max(off, float(np.linalg.norm(row[:3] - expected)))
    return off


@each_module
def test_slides_follow_the_documented_formulas_every_millisecond(
    module: Module, tmp_path: Path
) -> None:
    path, q, lines = planned(module, tmp_path)
    assert path.deviation_mm <= TCP_DEVIATION_MM
    assert farthest(module, q, lines) <= path.deviation_mm + 1e-9


@each_module
def test_a_wrong_sign_or_length_would_be_seen(module: Module, tmp_path: Path) -> None:
    """The comparison can fail: a table or head that turns the other way, a tool 1 mm longer."""
    turned = {"[0, 0, 1], point": "[0, 0, -1], point", "[0, 0, -1], point": "[0, 0, 1], point"}
    old, new = next((o, n) for o, n in turned.items() if o in module.yaml)
    _, q, lines = planned(module, tmp_path, module.yaml.replace(old, new))
    assert farthest(module, q, lines) > 10.0
    _, q, lines = planned(module, tmp_path, length=LENGTH + 1.0)
    assert farthest(module, q, lines) > 0.5


@pytest.mark.parametrize(
    "module",
    [MODULES[0], *(pytest.param(module, marks=pytest.mark.slow) for module in MODULES[1:])],
    ids=lambda module: module.name,
)
def test_the_motion_controller_moves_its_joints_along_our_path(
    module: Module, tmp_path: Path
) -> None:
    """At the same position of C, every joint of the controller is where our path has it."""
    lines = ["G21 G90 G61.1 G94", f"G43.1 Z{LENGTH}", "G1 F12000", *blocks(module.tilt)[:4], "M2"]
    theirs = joint_samples(module, "\n".join(lines) + "\n")
    # C climbs from 0 past the first point: what follows is compared, down to the end.
    theirs = theirs[int(np.argmax(theirs[:, 4] >= POINTS[0, 4])) :]
    np.testing.assert_allclose(theirs[0, 3:], POINTS[0, 3:], atol=0.1)
    np.testing.assert_allclose(theirs[-1, 3:], POINTS[3, 3:], atol=1e-6)
    path, _, _ = planned(module, tmp_path)
    columns = [path.joints.index(name) for name in ("X", "Y", "Z", module.tilt, "C")]
    nearest = np.full(len(theirs), np.inf)
    for line in range(FIRST_LINE, FIRST_LINE + 3):
        of_block = path.line == line
        knots = np.vstack([path.q0[of_block], path.q1[of_block][-1:]])[:, columns]
        knots = knots[np.argsort(knots[:, 4], kind="stable")]
        c = theirs[:, 4]
        at = np.stack([np.interp(c, knots[:, 4], knots[:, k]) for k in range(4)], axis=1)
        away = np.linalg.norm(theirs[:, :4] - at, axis=1)
        reached = (c >= knots[0, 4] - 1e-6) & (c <= knots[-1, 4] + 1e-6)
        nearest = np.where(reached, np.minimum(nearest, away), nearest)
    assert len(nearest) > 1000
    assert nearest.max() <= TCP_DEVIATION_MM + CONTROLLER_MM
