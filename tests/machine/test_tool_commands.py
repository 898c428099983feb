"""The commands `tool`: what import, new and show write and print, and what they refuse."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from machine.libraries import fusion_text, fusion_tool
from machine.stl import stl_bytes
from report.test_snapshot import decoded

from gcodesim.cli import main
from gcodesim.machine import shapes
from gcodesim.machine.cutters import USES
from gcodesim.machine.tools import read_tools
from gcodesim.report.tool_sheet import FLUTE, GAUGE, HEIGHT, HOLDER, SHANK, WIDTH

PROGRAM = "G21 G90 G17 G54\nT1 M6\nS1000 M3\nG0 G43 H1 Z100.\nG0 X10. Y10.\nG49\nG91 G28 Z0\nM30\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working folder with a Fusion library."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "shop.json").write_text(fusion_text(fusion_tool(), fusion_tool("hologram", 2)))
    return tmp_path


def run(*args: str) -> Result:
    return CliRunner().invoke(main, list(args))


def count(pixels: np.ndarray, color: tuple[int, int, int]) -> int:
    return int((pixels == color).all(axis=2).sum())


def test_new_writes_a_tool_of_every_type(folder: Path) -> None:
    assert run("tool", "new", "tools.yaml").exit_code == 0
    tools = read_tools("tools.yaml")
    assert {tool.type for tool in tools.values()} >= USES.keys() - {
        "countersink",
        "thread",
        "boring",
    }
    assert all(tool.unchecked == () for tool in tools.values())
    again = run("tool", "new", "tools.yaml")
    assert again.exit_code == 2
    assert "there is such a file already" in again.output


def test_import_says_what_it_could_not_carry_over(folder: Path) -> None:
    done = run("tool", "import", "shop.json", "--out", "tools.yaml")
    assert done.exit_code == 0
    remark = "T2 (hologram 2): type 'hologram' is not known"
    assert f"gcodesim: shop.json: {remark}" in done.stderr
    written = (folder / "tools.yaml").read_text()
    assert "\n# Made by `gcodesim tool import` from shop.json, a Fusion tool lib" in written
    assert f"#   - {remark}" in written
    first, _, rest = written.partition("\n")
    assert first == "# yaml-language-server: $schema=tools.schema.json"
    assert run("tool", "import", "shop.json").stdout == rest
    refused = run("tool", "import", "tools.yaml")
    assert refused.exit_code == 2
    assert "a tools file already" in refused.output


def test_a_catalogue_of_one_number_is_numbered_anew(folder: Path) -> None:
    catalogue = fusion_text(*(fusion_tool(DC=size) for size in (6.0, 8.0, 10.0)))
    (folder / "catalogue.json").write_text(catalogue)
    plain = run("tool", "import", "catalogue.json")
    assert plain.stderr.count("left out, an earlier tool has its number") == 2
    args = ("--number-from", "21", "--out", "mine.yaml")
    done = run("tool", "import", "catalogue.json", *args)
    assert "left out, an earlier" not in done.stderr
    tools = read_tools("mine.yaml")
    assert {number: tool.diameter for number, tool in tools.items()} == {21: 6, 22: 8, 23: 10}


def test_nothing_of_a_library_gets_out_of_a_comment(folder: Path) -> None:
    tool = fusion_tool("hologram") | {"description": "end\nmill: {bad}\x07 \"'"}
    (folder / "odd.json").write_text(fusion_text(tool, fusion_tool(number=2)))
    assert run("tool", "import", "odd.json", "--out", "odd.yaml").exit_code == 0
    tools = read_tools("odd.yaml")
    assert [tools[n].name for n in (1, 2)] == ["end\nmill: {bad}\x07 \"'", "flat end mill 2"]


def test_a_check_reads_a_library_itself(folder: Path) -> None:
    (folder / "part.nc").write_text(PROGRAM)
    done = run("check", "part.nc", "--machine", "table_tilt", "--tools", "shop.json",
               "--device", "cpu", "--sample-period", "10ms")  # fmt: skip
    assert done.exit_code == 0, done.output


def test_show_prints_and_draws_flute_shank_holder_and_gauge_line(folder: Path) -> None:
    shown = run("tool", "show", "shop.json", "--out", "tools.png")
    assert shown.exit_code == 0
    first, second = shown.stdout.splitlines()
    assert first == (
        "T1 flat end mill 1: length 95.8 mm, diameter 10 mm, flute 75.8..95.8, "
        "shank D9 50.8..75.8, holder D50.8 0..50.8"
    )
    assert second.endswith("; not modelled: flute")
    pixels = decoded((folder / "tools.png").read_bytes())
    assert pixels.shape == (HEIGHT, 2 * WIDTH, 3)
    left, right = pixels[:, :WIDTH], pixels[:, WIDTH:]
    for color in (FLUTE, SHANK, HOLDER, GAUGE):
        assert count(left, color) > 500
    assert count(right, HOLDER) > 500
    assert count(right, FLUTE) < 500  # only what it says of the missing one


def test_the_picture_is_true_to_scale(folder: Path) -> None:
    run("tool", "show", "shop.json", "--tool", "1", "--out", "one.png")
    pixels = decoded((folder / "one.png").read_bytes())
    rows = np.flatnonzero((pixels[:445] == FLUTE).all(axis=2).any(axis=1))
    across = (pixels[rows[len(rows) // 2]] == FLUTE).all(axis=1).sum() + 1  # the centre line
    assert len(rows) / across == pytest.approx(20.0 / 10.0, rel=0.06)


def test_a_mesh_is_drawn_as_wide_as_it_turns(folder: Path) -> None:
    box = shapes.box([30.0, 40.0, 60.0], [0.0, 0.0, -30.0])
    (folder / "holder.stl").write_bytes(stl_bytes(box))
    tool = "{number: 4, length: 100, flute: {diameter: 10, length: 40}, holder: {mesh: holder.stl}}"
    (folder / "mesh.yaml").write_text(f"tools: [{tool}]\n")
    shown = run("tool", "show", "mesh.yaml", "--out", "mesh.png")
    assert "holder D50 0..60" in shown.stdout
    pixels = decoded((folder / "mesh.png").read_bytes())
    widths = (pixels == HOLDER).all(axis=2).sum(axis=1)
    flute = (pixels[:430] == FLUTE).all(axis=2).sum(axis=1).max() + 1
    assert np.median(widths[widths > 0]) / flute == pytest.approx(5.0, rel=0.1)


@pytest.mark.parametrize(
    ("args", "text"),
    [
        (("--tool", "7"), "no tool 7; it has 1, 2"),
        (("--out", "shop.json"), "is the file of the tools: choose another file"),
    ],
)
def test_show_refuses(folder: Path, args: tuple[str, ...], text: str) -> None:
    refused = run("tool", "show", "shop.json", *args)
    assert refused.exit_code == 2
    assert text in refused.output
