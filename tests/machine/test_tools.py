"""Tools: tools file and tool table, profiles towards the tip, and mounting in the spindle."""

import numpy as np
import pytest

from gcodesim.errors import ModelError, UsageError
from gcodesim.machine.kinematics import sincosd
from gcodesim.machine.mesh import merge_corners, open_edge_count, signed_volume
from gcodesim.machine.model import ToolMount
from gcodesim.machine.tools import mount, read_tools

TOOLS = """\
tools:
  - number: 7
    name: ball 12
    length: 160
    flute: {diameter: 12, length: 30, corner_radius: 6}
    shank: [[6, 60], [6, 130]]
    holder: [[25, 0], [25, 20], [15, 60]]
  - {number: 8, length: 50, flute: {diameter: 4, length: 10}, holder: [[10, 0], [10, 20]]}
  - {number: 9, length: 50}
"""


@pytest.fixture
def tools(tmp_path):
    """The tools file."""
    (tmp_path / "tools.yaml").write_text(TOOLS)
    return str(tmp_path / "tools.yaml")


def extent(part):
    return part.triangles[..., 2].min(), part.triangles[..., 2].max()


def test_tools_file(tools):
    table = read_tools(tools)
    ball = table[7]
    assert (ball.number, ball.name, ball.length, ball.diameter) == (7, "ball 12", 160, 12)
    assert ball.offset == (0, 0, 160, 0, 0, 0)
    assert [(p.name, p.role, *extent(p)) for p in ball.parts] == [
        ("flute", "flute", -160, -130), ("shank", "shank", -130, -60), ("holder", "holder", -60, 0),
    ]  # fmt: skip
    for part in ball.parts:
        assert open_edge_count(merge_corners(part.triangles)) == 0
        assert signed_volume(part.triangles) > 0
    # every point of the ideal ball lies inside all planes of the flute (it is convex)
    sine, cosine = sincosd(np.linspace(0, 360, 97))
    rim = np.stack([6 * cosine, 6 * sine, np.full(97, -154.0)], axis=1)
    a, b, c = ball.parts[0].triangles.transpose(1, 0, 2)
    outside = np.einsum("tk,tpk->tp", np.cross(b - a, c - a), rim[None] - a[:, None])
    assert (outside <= 1e-9).all()
    assert ball.unchecked == ()
    assert table[8].unchecked == ("shank",)
    assert (table[9].parts, table[9].unchecked) == ((), ())


@pytest.mark.parametrize(
    ("old", "new", "line", "text"),
    [
        ("number: 7", "number: 8", 8, "given twice"),
        ("number: 7", "number: -1", 2, "greater than or equal to 0"),
        ("corner_radius: 6", "corner_radius: 7", 5, "larger than the diameter"),
        ("[25, 20]", "[25, -20]", 7, "turns back"),
        ("diameter: 12, ", "", 5, "give `diameter` and `length`"),
        ("shank:", "shaft:", 6, "did you mean"),
        ("[[6, 60], [6, 130]]", "{mesh: ../shank.stl}", 6, "outside the folder"),
    ],
)
def test_wrong_tools_file(tools, old, new, line, text):
    with open(tools, "w") as file:
        file.write(TOOLS.replace(old, new, 1))
    with pytest.raises(ModelError, match=text) as caught:
        read_tools(tools)
    assert caught.value.line == line


def test_tool_table(tmp_path):
    path = tmp_path / "tool.tbl"
    path.write_text("; mm\nT1 P1 Z50 D10 ;end mill\nT2 P2 X1.5 Z-3 B.5\n\nt30p30z80.5d+6\n")
    table = read_tools(str(path))
    assert list(table) == [1, 2, 30]
    mill = table[1]
    assert (mill.name, mill.length, mill.diameter, mill.unchecked) == (
        "end mill", 50, 10, ("holder",),
    )  # fmt: skip
    assert extent(mill.parts[0]) == (-50, 0)
    assert signed_volume(mill.parts[0].triangles) >= np.pi * 25 * 50
    assert (table[2].offset, table[2].parts) == ((1.5, 0, -3, 0, 0.5, 0), ())
    assert table[30].offset[2] == 80.5


@pytest.mark.parametrize("row", ["P1 Z50", "T1 Z50 G4", "T1 Z", "T1.5", "T1\nT1", "T1 Z5 (x)"])
def test_wrong_tool_table(tmp_path, row):
    (tmp_path / "tool.tbl").write_text(row)
    with pytest.raises(ModelError, match=r"tool\.tbl:[12]: "):
        read_tools(str(tmp_path / "tool.tbl"))
    with pytest.raises(UsageError, match="cannot be read"):
        read_tools(str(tmp_path / "missing.tbl"))


@pytest.mark.parametrize("axis", [[0, 0, 1], [0, 0, -1], [1, 0, 0], [0.6, 0, -0.8]])
def test_mount(tools, axis):
    """The tip comes to gauge point - length * axis, and the solid stays rigid and outward."""
    parts = read_tools(tools)[8].parts
    spindle = ToolMount("cutter", "Z", np.array([1.0, 2.0, 3.0]), np.array(axis, dtype=float))
    mounted = mount(parts, spindle)
    along = (mounted[0].triangles - spindle.gauge_point) @ spindle.axis
    assert along.min() == pytest.approx(-50, abs=1e-12)
    for before, after in zip(parts, mounted, strict=True):
        assert after.name == before.name
        volume = signed_volume(before.triangles)
        assert signed_volume(after.triangles) == pytest.approx(volume, rel=1e-12)
