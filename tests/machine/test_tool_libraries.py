"""FreeCAD bits, tables of LinuxCNC and Heidenhain, exports of controls, and what they become."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from machine.libraries import G10, SIEMENS, TOOL_T, bit_text, fusion_text, fusion_tool

from gcodesim.errors import ModelError
from gcodesim.machine.files import files_of
from gcodesim.machine.formats.libraries.freecad import SHAPES
from gcodesim.machine.tool_files import read_library
from gcodesim.machine.tools import read_tools

BITS = {
    "endmill": {"Diameter": "5.0000 mm", "CuttingEdgeHeight": "30 mm", "ShankDiameter": "3 mm"},
    "ballend": {"Diameter": "6 mm", "CuttingEdgeHeight": "40 mm", "ShankDiameter": "3 mm"},
    "bullnose": {"Diameter": "6 mm", "FlatRadius": "1.5 mm", "CuttingEdgeHeight": "40 mm"},
    "taperedballnose": {"Diameter": "2 mm", "TaperAngle": "10 °", "CuttingEdgeHeight": "20 mm"},
    "chamfer": {"Diameter": "12 mm", "TipDiameter": "5 mm", "CuttingEdgeAngle": "60 °",
                "CuttingEdgeHeight": "6 mm", "ShankDiameter": "6 mm"},
    "v-bit": {"Diameter": "10 mm", "TipDiameter": "0,1 mm", "CuttingEdgeAngle": "90.0 °",
              "CuttingEdgeHeight": "1 mm", "ShankDiameter": "5 mm"},
    "drill": {"Diameter": '0.25 "', "TipAngle": "119 °"},
    "reamer": {"Diameter": "8 mm", "CuttingEdgeHeight": "30 mm"},
    "tap": {"Diameter": "8 mm", "Pitch": "1.25 mm", "CuttingEdgeLength": "1 in"},
    "thread-mill": {"Diameter": "5 mm", "NeckDiameter": "3 mm", "NeckLength": "20 mm",
                    "Crest": "0.1 mm", "ShankDiameter": "5 mm"},
    "dovetail": {"Diameter": "20 mm", "NeckDiameter": "8 mm", "CuttingEdgeHeight": "9 mm"},
    "slittingsaw": {"Diameter": "76.2 mm", "BladeThickness": "3 mm", "CapDiameter": "8 mm",
                    "CapHeight": "3 mm", "ShankDiameter": "19.05 mm"},
    "radius": {"Diameter": "12 mm", "CuttingRadius": "3 mm", "CuttingEdgeHeight": "8 mm"},
    "probe": {"Diameter": "6 mm", "ShaftDiameter": "4 mm"},
}  # fmt: skip


@pytest.fixture
def library(tmp_path: Path) -> Path:
    """A FreeCAD library as FreeCAD lays it out, its bits in a folder beside."""
    (tmp_path / "Bit").mkdir()
    (tmp_path / "Library").mkdir()
    tools = []
    for number, (shape, parameters) in enumerate(BITS.items(), start=1):
        text = bit_text(shape, shape, Length="50 mm", **parameters)
        (tmp_path / "Bit" / f"{shape}.fctb").write_text(text, encoding="utf-8")
        tools.append({"nr": number, "path": f"{shape}.fctb"})
    path = tmp_path / "Library" / "Default.fctl"
    path.write_text(json.dumps({"tools": tools, "version": 1}, indent=1))
    return path


def test_every_shape_of_freecad_has_a_flute(library: Path) -> None:
    tools = read_tools(str(library))
    assert [tool.name for tool in tools.values()] == list(BITS)
    assert {name.replace("-", "") for name in BITS} <= SHAPES.keys()
    for tool in tools.values():
        assert tool.length == 50.0
        assert tool.unchecked == ("holder",)
        flute = tool.parts[0].turned
        assert flute is not None
        assert flute.outer[0][1] == -50.0
    by_name = {tool.name: tool for tool in tools.values()}
    assert by_name["drill"].diameter == pytest.approx(6.35)
    assert by_name["tap"].parts[0].triangles[..., 2].max() == pytest.approx(-50 + 25.4)
    saw = by_name["slittingsaw"].parts[0].turned
    assert saw is not None
    assert saw.outer == ((4.0, -50.0), (4.0, -47.0), (38.1, -47.0), (38.1, -44.0))


def test_the_flat_of_an_older_bull_nose_is_not_its_corner(library: Path) -> None:
    bull = next(t for t in read_library(library).tools if t["name"] == "bullnose")
    assert bull["flute"]["corner_radius"] == 1.5


def test_a_bit_alone_is_tool_1(tmp_path: Path) -> None:
    (tmp_path / "a.fctb").write_text(bit_text("endmill", Diameter="5 mm", Length="40 mm"))
    assert read_tools(str(tmp_path / "a.fctb"))[1].length == 40.0


def test_the_bits_are_files_of_the_run(library: Path) -> None:
    files = files_of("table_tilt", None, str(library))
    assert sum(file.suffix == ".fctb" for file in files) == len(BITS)


def test_a_missing_bit_and_a_strange_unit_are_named(library: Path) -> None:
    bit = library.parent.parent / "Bit" / "endmill.fctb"
    bit.write_text(bit.read_text().replace("5.0000 mm", "5 furlong"))
    with pytest.raises(ModelError, match=r"endmill\.fctb:\d: parameter\.Diameter: expected"):
        read_tools(str(library))
    bit.unlink()
    with pytest.raises(ModelError, match=r"Default\.fctl:5: path: no tool bit 'endmill\.fctb' in"):
        read_tools(str(library))


def test_columns_of_a_heidenhain_table(tmp_path: Path) -> None:
    path = tmp_path / "tool.t"
    path.write_text(TOOL_T)
    tools = read_tools(str(path))
    assert list(tools) == [1, 2, 3, 4, 5, 21]
    mill = tools[1]
    assert (mill.name, mill.length) == ("MILL_D10", 120.0)
    assert mill.diameter == pytest.approx(10.02)
    assert mill.parts[0].triangles[..., 2].max() == pytest.approx(-95.0)
    assert [tool.type for tool in tools.values()] == [
        "mill", "ball", "drill", "mill", "mill", "probe",
    ]  # fmt: skip
    drill = tools[3].parts[0].turned
    assert drill is not None
    assert drill.outer[0] == (0.0, -150.0)
    assert tools[5].parts == ()
    inch = TOOL_T.replace("TOOL.T MM", "TOOL.T INCH")
    path.write_text(inch)
    assert read_tools(str(path))[4].diameter == pytest.approx(12 * 25.4)


@pytest.mark.parametrize(
    ("old", "new", "line", "text"),
    [
        ("+120.5", "+12o.5", 4, "column L: expected a number, not '\\+12o.5'"),
        ("L        R  ", "LANG     R  ", 2, "the header has no column L"),
        ("TOOL.T MM", "TOOL.T FT", 1, "expected BEGIN TOOL.T MM, or INCH"),
    ],
)
def test_a_wrong_heidenhain_table(tmp_path: Path, old: str, new: str, line: int, text: str) -> None:
    (tmp_path / "tool.t").write_text(TOOL_T.replace(old, new, 1))
    with pytest.raises(ModelError, match=text) as caught:
        read_tools(str(tmp_path / "tool.t"))
    assert caught.value.line == line


def test_g10_blocks_give_lengths_and_work_offsets(tmp_path: Path) -> None:
    path = tmp_path / "offsets.nc"
    path.write_text(G10)
    library = read_library(path)
    tools = read_tools(str(path))
    assert tools[1].length == pytest.approx(199.95)
    assert (tools[1].name, tools[1].parts) == ("END MILL D10", ())
    assert tools[2].offset[2] == -31.5
    assert library.offsets == {
        "G54": {"X": -350.0, "Y": -200.5, "Z": -100.0}, "G54.1 P3": {"X": 10.0, "B": 5.0},
    }  # fmt: skip
    assert any("radius or a diameter" in remark for remark in library.remarks)
    path.write_text(G10.replace("G21", "G20"))
    assert read_tools(str(path))[1].length == pytest.approx(199.95 * 25.4)
    path.write_text(G10.replace("L11 P1", "L11 P1.5"))
    with pytest.raises(ModelError, match=r"offsets\.nc:7: G10 needs a P"):
        read_tools(str(path))


def test_tool_data_of_siemens(tmp_path: Path) -> None:
    path = tmp_path / "_N_TO_TOA.INI"
    path.write_text(SIEMENS)
    library, tools = read_library(path), read_tools(str(path))
    assert (tools[1].name, tools[1].length, tools[1].diameter) == ("MILL_D10", 118.0, 10.0)
    torus = tools[3].parts[0].turned
    assert torus is not None
    assert np.hypot(*np.subtract(torus.inner[0], (4.5, -90.0))) < 1e-9
    assert tools[9].parts == ()
    assert "T3: edge D2" in library.remarks
    assert library.offsets["G54"] == {"X": 10.0, "Y": -20.0, "Z": -300.5}
    path.write_text(SIEMENS.replace("=118.2", "=L1"))
    with pytest.raises(ModelError, match=r"\$TC_DP3: expected a number, not 'L1'"):
        read_tools(str(path))


def test_the_tools_file_of_a_library_holds_the_same_tools(library: Path, tmp_path: Path) -> None:
    sources = {"shop.json": fusion_text(*(fusion_tool(k, n) for n, k in enumerate(
        ("flat end mill", "ball end mill", "slot mill", "thread mill"), start=1))),
        "tool.t": TOOL_T, "_TOA.INI": SIEMENS, "o.nc": G10,
        "tool.tbl": "T1 P1 Z50 D10 ;end mill\nT2 X1.5 Z-3 B.5\nT9 D4\n"}  # fmt: skip
    for name, text in sources.items():
        (tmp_path / name).write_text(text)
    for path in [library, *(tmp_path / name for name in sources)]:
        written = tmp_path / "written.yaml"
        written.write_text(read_library(path).text, encoding="utf-8")
        direct, copied = read_tools(str(path)), read_tools(str(written))
        assert direct.keys() == copied.keys()
        for number, tool in direct.items():
            copy = copied[number]
            assert (copy.name, copy.type, copy.unchecked) == (tool.name, tool.type, tool.unchecked)
            assert copy.offset == pytest.approx(tool.offset)
            assert copy.diameter == pytest.approx(tool.diameter)
            for one, other in zip(copy.parts, tool.parts, strict=True):
                assert np.allclose(one.triangles, other.triangles, rtol=0, atol=1e-8)


def test_a_file_of_another_kind_names_those_that_are_read(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("buy a new drill\n")
    with pytest.raises(ModelError, match=r"no file of tools: expected a tools file \(\.yaml\)"):
        read_tools(str(tmp_path / "notes.txt"))


MANY = "9" * 5000


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.tbl", f"T{MANY} P1 Z50 D10\n"),
        ("a.t", "BEGIN TOOL.T MM\n\n1 X +1\n[END]\n"),
        ("a.t", TOOL_T.replace("+120.5", "1e999")),
        ("a.t", TOOL_T.replace("+120.5", "nan")),
        ("a.nc", f"G10 L10 P{MANY} R50.\n"),
        ("a.nc", f"G10 L10 P1 R{MANY}\n"),
        ("a.nc", f"G10 L{MANY} P1 R5\n"),
        ("a.spf", "$TC_DP1[1,1]=inf\n$TC_DP3[1,1]=100\n"),
        ("a.spf", f"$TC_DP1[{MANY},1]=120\n"),
        ("a.json", f'{{"data": [], "version": {MANY}}}'),
        ("a.json", fusion_text(fusion_tool(DC=float("inf")))),
        ("a.json", fusion_text(fusion_tool(DC=10**400))),
        ("a.fctb", bit_text("endmill", Length=f"{MANY} mm", CuttingEdgeHeight="3 mm")),
        ("a.fctb", bit_text("endmill").replace("{}", f'{{"Length": {10**400}}}')),
    ],
)
def test_numbers_beyond_belief_are_named_in_a_sentence(
    tmp_path: Path, name: str, text: str
) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(ModelError):
        read_tools(str(tmp_path / name))
