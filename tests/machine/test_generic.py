"""Machines that `machine new` writes: they load, lint clean, show and check a program."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from gcodesim.checking.lint import lint
from gcodesim.cli import main
from gcodesim.cli.machine import KINDS
from gcodesim.machine.generic import MACHINES
from gcodesim.machine.loading import load_machine
from gcodesim.machine.tool_centre import tool_centre

PROGRAM = """\
G21 G90 G17 G54
T1 M6
S1000 M3
G43 H1
G0 X50 Y20
Z100
G1 Z60 F1000
X-50
G0 Z100
G49
{five_axis}G91 G28 Z0
M30
"""
FIVE_AXIS = {
    kind: f"G43.4 H1\nG1 X10 Y10 Z80 {turn} C90 F2000\nX-40 Y-20 Z60\nG49\n"
    for kind, turn in {"table-table": "A-30", "head-table": "B30", "head-head": "B30"}.items()
}


def run(*args: str) -> tuple[int, str]:
    result = CliRunner().invoke(main, list(args))
    return result.exit_code, result.output


def test_every_kind_can_be_asked_for() -> None:
    assert tuple(MACHINES) == KINDS


@pytest.mark.parametrize("kind", KINDS)
def test_a_new_machine_is_whole(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "my mill.yaml"
    assert run("machine", "new", kind, str(path)) == (0, "")
    machine = load_machine(str(path))
    assert machine.name == "my_mill"
    assert not machine.verified
    assert {finding.severity for finding in lint(machine)} == {"note"}
    centre = tool_centre(machine)
    assert (centre is None) == (kind == "three-axis")
    assert centre is None or not centre.refusal
    code, shown = run("machine", "show", str(path))
    assert code == 0
    assert "unverified model" in shown
    assert all(f"  {name}: " in shown for name in machine.axes)


@pytest.mark.parametrize("kind", KINDS)
def test_a_new_machine_checks_a_program(kind: str, tmp_path: Path) -> None:
    """It passes above the table; a move down into it is a contact of the cutter with the table."""
    path, program = tmp_path / "m.yaml", tmp_path / "part.nc"
    run("machine", "new", kind, str(path))
    text = PROGRAM.format(five_axis=FIVE_AXIS.get(kind, ""))
    check = ("check", str(program), "--machine", str(path), "--device", "cpu")
    program.write_text(text)
    code, report = run(*check)
    assert code == 0, report
    assert report.startswith("PASS")
    assert "(unverified model)" in report
    program.write_text(text.replace("G1 Z60", "G1 Z-1"))
    code, report = run(*check)
    assert code == 1
    assert f"GC102 {program}:7: flute of cutter touches" in report
    assert "    G1 Z-1 F1000\n" in report


def test_nothing_is_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "m.yaml"
    path.write_text("mine")
    code, said = run("machine", "new", "head-head", str(path))
    assert code == 2
    assert "there is such a file already" in said
    assert path.read_text() == "mine"
    assert run("machine", "new", "head-head", str(tmp_path / "no" / "m.yaml"))[0] == 2
