"""From the empty folder to the verdict on one's own machine: every command that it takes."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from machine.libraries import fusion_text, fusion_tool
from machine.stl import stl_bytes

from gcodesim.cli import main
from gcodesim.machine import shapes

LIBRARY = fusion_text(
    fusion_tool(),
    fusion_tool("ball end mill", 2, DC=6.0, LCF=15.0),
    fusion_tool("drill", 3, DC=8.0, LCF=40.0, LB=70.0, SIG=118.0),
)

SETUP = """\
machine: mine.yaml
tools: shop.json
offsets:
  G54: {X: -60, Y: 0, Z: -450}
  G55: {X: 60, Y: 0, Z: -450}
bodies:
  left:
    role: fixture
    on: table
    parts:
      - {name: base, box: {size: [80, 60, 20], center: [-60, 0, 10]}}
      - {name: fixed_jaw, box: {size: [80, 10, 30], center: [-60, 25, 35]}}
      - {name: moving_jaw, box: {size: [80, 10, 30], center: [-60, -25, 35]}}
  first: {role: part, frame: G54, mesh: part.stl}
  second: {role: part, frame: G55, mesh: part.stl}
"""

PROGRAM = """\
G21 G90 G17
{zero}
T1 M6
S8000 M3
G0 G43 H1 X0. Y0. Z60.
G1 Z2. F800
X15.
G0 Z60.
T3 M6
S2000 M3
G0 G43 H3 X0. Y0. Z60.
G1 Z{depth} F200
G0 Z60.
M30
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """What a shop has: a library of its CAM, a part exported in its own zero, and a program."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "shop.json").write_text(LIBRARY)
    part = shapes.box([60.0, 40.0, 50.0], [0.0, 0.0, -25.0])
    (tmp_path / "part.stl").write_bytes(stl_bytes(part))
    (tmp_path / "good.nc").write_text(PROGRAM.format(zero="G54", depth="3."))
    (tmp_path / "bad.nc").write_text(PROGRAM.format(zero="G55", depth="-60."))
    return tmp_path


def run(*args: str) -> Result:
    return CliRunner().invoke(main, list(args))


def test_four_commands_lead_from_the_empty_folder_to_a_true_verdict(folder: Path) -> None:
    layout = ("--table", "YX", "--rotary", "BC", "--travel", "500", "450", "400")
    made = run("machine", "new", "mine.yaml", *layout, "--tilt", "-110", "110")
    assert made.exit_code == 0, made.output
    (folder / "job.yaml").write_text(SETUP)

    shown = run("machine", "show", "mine.yaml", "--setup", "job.yaml")
    assert "    G54: X -30 .. 30, Y -20 .. 20, Z -50 .. 0" in shown.stdout
    assert "    G55: X -30 .. 30, Y -20 .. 20, Z -50 .. 0" in shown.stdout
    assert run("tool", "show", "shop.json", "--out", "tools.png").exit_code == 0

    options = ("--setup", "job.yaml", "--device", "cpu", "--sample-period", "10ms")
    good = run("check", "good.nc", *options)
    assert good.exit_code == 0, good.output
    bad = run("check", "bad.nc", *options)
    assert bad.exit_code == 1, bad.output
    assert "tool 3" in bad.output
    assert "bad.nc:12" in bad.output
