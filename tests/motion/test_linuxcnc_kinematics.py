"""Joint positions under tool centre point control against LinuxCNC's documented kinematics."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from motion.linuxcnc_machines import CENTRE, LENGTH, MODULES, Module

from gcodesim.constants import TCP_DEVIATION_MM
from gcodesim.machine.control import control_for
from gcodesim.machine.loading import load_machine
from gcodesim.machine.model import Machine
from gcodesim.motion.path import Path as MotionPath
from gcodesim.motion.planner import plan
from gcodesim.nc.interpreter import interpret
from gcodesim.trace import Trace

MS_PS = 10**9
TOOLS = f"tools: [{{number: 1, name: probe, length: {LENGTH}}}]"
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
"""All coordinates change at once, then the rotary axes alone, C beyond a turn."""


def program(tilt: str, f: int) -> str:
    """The points under G43.4 at a feed, the first one at rapid."""
    words = [f"X{x} Y{y} Z{z} {tilt}{a} C{c}" for x, y, z, a, c in POINTS.tolist()]
    rest = "\n".join(words[1:])
    return f"G21 G90 G54 G94\nT1 M6\nG43.4 H1\nG0 {words[0]}\nG1 F{f}\n{rest}\nG49\nM30\n"


def planned(module: Module, folder: Path) -> tuple[Machine, MotionPath]:
    (folder / "m.yaml").write_text(module.yaml)
    (folder / "tools.yaml").write_text(TOOLS)
    machine = load_machine(str(folder / "m.yaml"), tools=str(folder / "tools.yaml"))
    meaning = interpret(program(module.tilt, 1500), control_for(machine, None, None, False), "p.nc")
    assert [finding for finding in meaning.findings if finding.severity == "error"] == []
    path, _ = plan(meaning.program, machine)
    return machine, path


@pytest.mark.parametrize("module", MODULES, ids=lambda module: module.name)
def test_slides_follow_the_documented_formulas_every_millisecond(
    module: Module, tmp_path: Path
) -> None:
    machine, path = planned(module, tmp_path)
    trace = Trace(path, machine, MS_PS)
    times = trace.times_ps
    q = dict(zip(machine.axes, trace.positions(times).T, strict=True))
    slides = np.stack([q["X"], q["Y"], q["Z"]], axis=1)
    off, seen = 0.0, 0
    first = 6  # the line of the first feed block
    for block, (start, end) in enumerate(zip(POINTS, POINTS[1:], strict=False)):
        (rows,) = np.nonzero(trace.lines(times) == first + block)
        seen += len(rows)
        for row in rows:
            # The rotary axes run linearly with the way of the tip: they tell where it must be.
            s = (q["C"][row] - start[4]) / (end[4] - start[4])
            assert -1e-9 <= s <= 1.0 + 1e-9
            tilt = start[3] + s * (end[3] - start[3])
            np.testing.assert_allclose(q[module.tilt][row], tilt, atol=1e-9)
            tip = start[:3] + s * (end[:3] - start[:3])
            expected = module.slides(tip, tilt, q["C"][row])
            off = max(off, float(np.linalg.norm(slides[row] - expected)))
    assert seen > 4000
    assert path.deviation_mm <= TCP_DEVIATION_MM
    assert off <= path.deviation_mm + 1e-9


@pytest.mark.parametrize("module", MODULES, ids=lambda module: module.name)
def test_the_formulas_tell_wrong_machines_apart(module: Module, tmp_path: Path) -> None:
    """A rotary axis the other way round, and a tool length forgotten, are far outside the bound."""
    p, tilt, c = CENTRE + [25.0, -3.0, 69.0], 30.0, 45.0
    right = module.slides(p, tilt, c)
    assert np.linalg.norm(module.slides(p, -tilt, c) - right) > 10.0
    assert np.linalg.norm(module.slides(p, tilt, -c) - right) > 10.0
    _, path = planned(module, tmp_path)
    found = path.q1[-1]
    assert np.isfinite(found).all()
