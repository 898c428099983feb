"""Fusion libraries: units, lengths, holders, shafts, and the true flute of every type."""

from __future__ import annotations

import json
import math
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from machine.libraries import HOLDER, fusion_text, fusion_tool

from gcodesim.errors import ModelError
from gcodesim.machine.formats.libraries.fusion_flutes import FLUTES
from gcodesim.machine.model import Part, Tool
from gcodesim.machine.tool_files import read_library
from gcodesim.machine.tools import read_tools


def read(tmp_path: Path, *tools: dict[str, Any]) -> dict[int, Tool]:
    """Tools of a library in a file."""
    path = tmp_path / "library.json"
    path.write_text(fusion_text(*tools))
    return read_tools(str(path))


def part(tool: Tool, name: str) -> Part:
    return next(part for part in tool.parts if part.name == name)


def outline(tool: Tool, name: str) -> list[tuple[float, float]]:
    """Points (r, z) of a part, from the gauge point, rounded."""
    turned = part(tool, name).turned
    assert turned is not None
    return [(round(r, 6), round(z, 6)) for r, z in turned.outer]


def test_a_tool_hangs_by_its_holder_from_the_gauge_line(tmp_path: Path) -> None:
    tool = read(tmp_path, fusion_tool())[1]
    assert (tool.name, tool.type, tool.diameter) == ("flat end mill 1", "mill", 10.0)
    length = 45.0 + 2 * 25.4
    assert tool.length == tool.offset[2] == pytest.approx(length)
    assert outline(tool, "flute") == [(5.0, -length), (5.0, -length + 20.0)]
    assert outline(tool, "shank") == [
        (4.5, -length + 20), (4.5, -length + 30), (4.0, -length + 30), (4.0, -length + 45),
    ]  # fmt: skip
    # What stands above the gauge line is inside the spindle.
    assert outline(tool, "holder") == [(12.7, -50.8), (15.24, -25.4), (25.4, -25.4), (25.4, 0.0)]
    assert tool.unchecked == ()


def test_every_tool_and_every_holder_has_its_own_unit(tmp_path: Path) -> None:
    inches = fusion_tool(number=2, DC=0.5, LCF=1.0, LB=2.0, SFDM=0.5, **{"shoulder-length": 1.0})
    inches |= {"unit": "inches", "holder": HOLDER | {"unit": "millimeters", "gaugeLength": 2.0}}
    tools = read(tmp_path, fusion_tool(), inches)
    assert tools[2].diameter == pytest.approx(12.7)
    assert tools[2].length == pytest.approx(50.8 + 2.0)
    assert outline(tools[2], "holder")[0] == (0.5, -2.0)
    assert tools[1].diameter == 10.0


def test_a_shaft_stands_on_the_shoulder_and_ends_at_the_holder(tmp_path: Path) -> None:
    tool = fusion_tool()
    tool["shaft"] = {"type": "shaft", "segments": [
        {"height": 5.0, "lower-diameter": 9.0, "upper-diameter": 12.0},
        {"height": 40.0, "lower-diameter": 12.0, "upper-diameter": 16.0}]}  # fmt: skip
    tip = -95.8
    found = outline(read(tmp_path, tool)[1], "shank")
    assert found == [
        (4.5, tip + 20), (4.5, tip + 30), (4.5, tip + 30), (6, tip + 35), (6, tip + 35),
        (6.5, tip + 45),
    ] or found == [
        (4.5, tip + 20), (4.5, tip + 30), (6, tip + 35), (6, tip + 35), (6.5, tip + 45),
    ]  # fmt: skip


def test_the_gauge_length_of_the_assembly_wins_and_a_difference_is_noted(tmp_path: Path) -> None:
    path = tmp_path / "library.json"
    path.write_text(fusion_text(fusion_tool(assemblyGaugeLength=100.0)))
    library = read_library(path)
    assert read_tools(str(path))[1].length == 100.0
    assert any("assemblyGaugeLength 100 mm is not LB and holder" in r for r in library.remarks)


def test_without_a_holder_it_is_unchecked(tmp_path: Path) -> None:
    tool = fusion_tool()
    del tool["holder"]
    found = read(tmp_path, tool)[1]
    assert found.length == 45.0
    assert found.unchecked == ("holder",)


GEOMETRY: dict[str, dict[str, float]] = {
    "ball end mill": {"RE": 5.0},
    "bull nose end mill": {"RE": 1.5},
    "tapered mill": {"TA": 10.0, "RE": 2.5},
    "chamfer mill": {"TA": 45.0, "tip-diameter": 1.0},
    "face mill": {"TA": 45.0, "DC": 50.0, "DCX": 63.0, "LCF": 12.0},
    "slot mill": {"LCF": 4.0, "RE": 0.3},
    "dovetail mill": {"DC": 20.0, "LCF": 10.0, "TA": 30.0, "shoulder-diameter": 8.45},
    "lollipop mill": {"RE": 5.0, "LCF": 9.0, "shoulder-diameter": 5.0},
    "radius mill": {"RE": 4.0, "tip-length": 1.0},
    "thread mill": {"TP": 1.5},
    "drill": {"SIG": 118.0},
    "spot drill": {"SIG": 90.0},
    "counter sink": {"SIG": 90.0, "tip-diameter": 1.2},
    "center drill": {"SIG": 118.0, "TA": 60.0, "tip-diameter": 2.0, "tip-length": 2.0},
    "tap right hand": {"TP": 1.5},
    "tap left hand": {"TP": 1.5},
    "probe": {"DC": 6.0, "RE": 3.0, "SFDM": 4.0, "shoulder-diameter": 4.0},
}


@pytest.mark.parametrize("kind", [k for k in FLUTES if k not in ("form mill",)])
def test_every_type_has_a_flute_that_holds_what_it_surely_cuts(tmp_path: Path, kind: str) -> None:
    tool = read(tmp_path, fusion_tool(kind, **GEOMETRY.get(kind, {})))[1]
    turned = part(tool, "flute").turned
    assert turned is not None
    outer, inner = np.array(turned.outer), np.array(turned.inner)
    assert outer[0, 1] == pytest.approx(-tool.length)
    z = np.linspace(outer[0, 1], outer[-1, 1], 500)[1:-1] + 1e-7
    around = np.interp(z, outer[:, 1], outer[:, 0])
    assert (np.interp(z, inner[:, 1], inner[:, 0]) <= around + 1e-9).all()
    assert 2.0 * outer[:, 0].max() >= tool.diameter - 1e-9


@pytest.mark.parametrize(
    ("kind", "height", "radius"),
    [
        ("chamfer mill", 2.0, 2.5),
        ("drill", 1.0, math.tan(math.radians(59.0))),
        ("spot drill", 3.0, 3.0),
        ("counter sink", 2.0, 2.6),
        ("center drill", 1.5, 1.0),
        ("dovetail mill", 10.0, 10.0 - 10.0 * math.tan(math.radians(30.0))),
        ("face mill", 3.0, 28.0),
        ("tapered mill", 20.0, 5.0 + 20.0 * math.tan(math.radians(10.0))),
        ("radius mill", 0.5, 5.0),
        ("radius mill", 6.0, 9.0),
    ],
)
def test_the_radius_at_a_height_is_that_of_the_type(
    tmp_path: Path, kind: str, height: float, radius: float
) -> None:
    tool = read(tmp_path, fusion_tool(kind, **GEOMETRY.get(kind, {})))[1]
    points = np.array(outline(tool, "flute"))
    at = np.interp(height - tool.length, points[:, 1], points[:, 0])
    assert at == pytest.approx(radius, abs=1e-5)


def test_a_form_mill_of_lines_is_drawn_and_one_of_arcs_is_unchecked(tmp_path: Path) -> None:
    steps: list[dict[str, Any]] = [{"end": [0, 0]}, {"end": [2, 1]}, {"end": [5, 8]}]
    lines, arcs = fusion_tool("form mill"), fusion_tool("form mill", number=2)
    lines["geometry"]["profile"] = steps
    arcs["geometry"]["profile"] = [*steps, {"arc": True, "end": [5, 9], "center": [5, 8.5]}]
    tools = read(tmp_path, lines, arcs)
    tip = -tools[1].length
    assert outline(tools[1], "flute") == [(0, tip), (2, round(tip + 1, 6)), (5, round(tip + 8, 6))]
    assert tools[2].unchecked == ("flute",)


def test_a_tool_without_the_numbers_of_its_flute_is_unchecked(tmp_path: Path) -> None:
    tool = fusion_tool()
    del tool["geometry"]["LCF"]
    path = tmp_path / "library.json"
    path.write_text(fusion_text(tool))
    assert read_tools(str(path))[1].unchecked == ("flute",)
    said = "T1 (flat end mill 1): the flute has no shape: give `diameter` and `length`"
    assert any(remark.startswith(said) for remark in read_library(path).remarks)


def test_a_length_register_of_another_number_gets_a_row(tmp_path: Path) -> None:
    tool = fusion_tool(number=3)
    tool["post-process"]["length-offset"] = 33
    tools = read(tmp_path, tool)
    assert tools[33].offset[2] == tools[3].length
    assert tools[33].parts == ()


def test_a_zip_of_it_is_the_same(tmp_path: Path) -> None:
    text = fusion_text(fusion_tool(), fusion_tool("drill", 2, SIG=118.0))
    with zipfile.ZipFile(tmp_path / "shop.tools", "w") as archive:
        archive.writestr("tools.json", text)
    (tmp_path / "shop.json").write_text(text)
    zipped, plain = (read_tools(str(tmp_path / f"shop.{end}")) for end in ("tools", "json"))
    assert zipped.keys() == plain.keys() == {1, 2}
    for number in plain:
        assert zipped[number].length == plain[number].length
        for one, other in zip(zipped[number].parts, plain[number].parts, strict=True):
            assert one.turned == other.turned


def test_equal_tools_count_once_and_others_of_one_number_are_refused(tmp_path: Path) -> None:
    assert list(read(tmp_path, fusion_tool(), fusion_tool())) == [1]
    with pytest.raises(ModelError, match=r"library\.json:\d+: .*tool 1 is given twice") as caught:
        read(tmp_path, fusion_tool(), fusion_tool(DC=8.0))
    assert caught.value.line == fusion_text(fusion_tool()).count("\n") - 1


def test_what_is_no_milling_tool_is_left_out_and_named(tmp_path: Path) -> None:
    path = tmp_path / "library.json"
    turning = fusion_tool("turning general", 7)
    path.write_text(fusion_text(fusion_tool(), turning, fusion_tool("hologram", 8)))
    library = read_library(path)
    assert [tool["number"] for tool in library.tools] == [1, 8]
    said = "\n".join(library.remarks)
    assert "1 of type turning general: no tool of a milling spindle" in said
    assert "T8 (hologram 8): type 'hologram' is not known" in said
    assert read_tools(str(path))[8].unchecked == ("flute",)


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        ('"DC": 10.0', '"DC": "ten"', r"geometry\.DC: expected a number, not 'ten'"),
        ('"DC": 10.0', '"DC": 1e999', r"geometry\.DC: expected a number up to"),
        ('"unit": "millimeters"', '"unit": "cubits"', "expected `unit` to be millimeters or"),
        ('"number": 1,', '"number": 1.5,', "expected a whole number, not 1.5"),
        ('{\n   "type": "flat end mill",', "{", "a tool needs its `type`"),
        ('"segments": [', '"segments": [{"height": -1},', "a segment needs height"),
        ('"geometry": {', '"geometry": 5, "other": {', "expected an object"),
        ('"version": 36', '"version" 36', "no valid JSON"),
    ],
)
def test_a_wrong_library_names_line_and_what_would_be_right(
    tmp_path: Path, old: str, new: str, text: str
) -> None:
    path = tmp_path / "library.json"
    whole = fusion_text(fusion_tool())
    assert old in whole
    path.write_text(whole.replace(old, new, 1))
    with pytest.raises(ModelError, match=text) as caught:
        read_tools(str(path))
    assert caught.value.line == whole[: whole.index(old)].count("\n") + 1


def test_a_zip_without_a_library_is_refused(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "a.tools", "w") as archive:
        archive.writestr("readme.txt", "nothing")
    with pytest.raises(ModelError, match=r"expected one \.json in it, found 0"):
        read_tools(str(tmp_path / "a.tools"))
    (tmp_path / "b.tools").write_bytes(b"PK nothing")
    with pytest.raises(ModelError, match=r"no valid \.tools file"):
        read_tools(str(tmp_path / "b.tools"))
    (tmp_path / "c.json").write_text(json.dumps({"numbers": []}))
    with pytest.raises(ModelError, match="neither a Fusion library"):
        read_tools(str(tmp_path / "c.json"))


def test_a_library_whose_compressed_data_is_damaged_is_an_error(tmp_path: Path) -> None:
    file = tmp_path / "bad.tools"
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("tools.json", '{"data": []}' * 500)
    content = bytearray(file.read_bytes())
    begin = content.index(b"tools.json") + len("tools.json")
    content[begin : begin + 12] = bytes(255 - byte for byte in content[begin : begin + 12])
    file.write_bytes(content)
    with pytest.raises(ModelError, match=r"bad\.tools: no valid \.tools file"):
        read_tools(str(file))
