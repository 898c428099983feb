"""The loader: a good machine arrives complete, and every mistake is named with line and key."""

import math
from dataclasses import replace

import numpy as np
import pytest

from gcodesim.errors import ModelError, UsageError
from gcodesim.machine.control_data import control_for
from gcodesim.machine.describe import describe
from gcodesim.machine.loading import load_machine
from gcodesim.machine.mesh import signed_volume
from gcodesim.nc.control.readings import ROWS, ArcTolerance


def test_good_machine(tiny):
    machine = load_machine(str(tiny / "tiny.yaml"))
    assert machine.links == ("bed", "Y", "X", "A", "C", "Z")
    assert machine.axes == ("Y", "X", "A", "C", "Z")
    assert list(machine.bodies) == ["Y", "X", "A", "C", "Z"]
    x, c = machine.joints[1], machine.joints[3]
    assert (x.axis == [-1, 0, 0]).all()
    assert x.rapid == 200.0
    assert (c.lower, c.upper, c.wrap) == (-math.inf, math.inf, "shortest")
    assert machine.offsets[1].value == (0, 0, 40, 0, 0, 0)
    assert machine.offsets[1].rotation == 10
    assert machine.offsets[107].value[0] == 1
    assert machine.start == {"Y": 0, "X": 0, "A": 0, "C": 0, "Z": 100}
    assert machine.reference == {"G28": {"Z": 100}}
    assert machine.tool.for_all
    assert machine.tool.length == 100
    assert [part.role for part in machine.tool.mounted] == ["flute"]
    assert machine.findings == ()
    assert machine.bodies["A"].parts[0].name == "cradle"
    for body in machine.bodies.values():
        assert all(part.closed and signed_volume(part.triangles) > 0 for part in body.parts)


def test_control_keys(changed):
    machine = load_machine(
        changed(
            "name: tiny",
            "name: tiny\ndialect: haas\npath_tolerance: {G64: 0.1}\n"
            "control: {dwell_p: s, m_codes: {46: none, 60: clamp}, ignore_words: [E],\n"
            "  arc: {tol_mm: 2e-2}, r_and_ijk: r_wins}",
        )
    )
    readings = machine.readings
    assert (readings.dialect, readings.dwell_p, readings.r_and_ijk) == ("haas", "s", "r_wins")
    assert readings.m_codes == {46: "none", 60: "clamp"}
    assert readings.ignore_words == ("E",)
    assert readings.arc == ArcTolerance(tol_mm=0.02)
    assert readings == replace(ROWS["haas"], **machine.given | {"arc": readings.arc})
    assert machine.path_tolerance == {"G64": 0.1, "rapid": None}


def test_the_control_reads_programs_as_the_file_says(changed):
    keys = "{peck_backoff: 1.5, bore_shift: -Y, tcp_frame: work, tcp_rotary_feed: 3600}"
    path = changed("name: tiny", f"name: tiny\ncontrol: {keys}")
    control = control_for(load_machine(path), None, None, False, 77)
    readings = control.readings
    assert (readings.peck_backoff, readings.bore_shift, readings.tcp_frame) == (1.5, "-Y", "work")
    assert (readings.dialect, readings.tcp_rotary_feed) == ("fanuc", 3600.0)
    other = control_for(load_machine(path), "linuxcnc", None, False).readings
    assert other == replace(ROWS["linuxcnc"], **load_machine(path).given)
    assert control.max_blocks == 77
    assert control.kinematics is not None
    assert "boring shift -Y" in describe(load_machine(path))


def test_keys_of_motion(changed):
    plain = load_machine(changed("name: tiny", "name: tiny"))
    assert (plain.readings.rapids, plain.time) == ("both", "constant")
    assert [j.servo for j in plain.joints] == [None] * 5
    limits = ", rapid: 24000, max_acceleration: 3000, max_jerk: 6e4"
    moving = changed("[0, -1, 0], limits: [-200, 200], rapid: 24000",
                     "[0, -1, 0], limits: [-200, 200]" + limits
                     + ", servo: {order: 2, time_constant: 2e-3}")  # fmt: skip
    y = load_machine(moving).joints[0]
    assert (y.max_acceleration, y.max_jerk) == (3000, 6e4)
    assert (y.servo.order, y.servo.time_constant, y.servo.damping) == (2, 2e-3, 1.0)
    given = changed("name: tiny", "name: tiny\ncontrol: {rapids: dogleg}")
    assert load_machine(given).readings.rapids == "dogleg"


MISTAKES = {
    "time without limits": ("name: tiny", "name: tiny\ntime: jerk", 11, "joints.Y", "max_accel"),
    "damping of order 1": ("rapid: 12000", "rapid: 12000, servo: {time_constant: 1, damping: 1}",
                           11, "joints.X.servo", "`damping` belongs to `order: 2`"),
    "unknown key": ("[-200, 200], rapid", "[-200, 200], rapdi", 10, "joints.Y.rapdi", "'rapid'"),
    "unknown top key": ("name: tiny", "nam: tiny", 1, "nam", "did you mean 'name'"),
    "wrong type": ("rapid: 12000", "rapid: fast", 11, "joints.X.rapid", "valid number, not 'fast'"),
    "bool as number": ("rapid: 12000", "rapid: true", 11, "joints.X.rapid", "not True"),
    "not finite": ("rapid: 12000", "rapid: .inf", 11, "joints.X.rapid", "'.inf'"),
    "missing key": (", rapid: 12000", "", 11, "joints.X.rapid", "required and missing"),
    "given twice": ("  bed: {}", "  bed: {}\n  bed: {}", 4, "links.bed", "the first is in line 3"),
    "unknown parent": ("parent: bed, child: Y", "parent: bde, child: Y", 10, "joints.Y.parent",
                       "did you mean 'bed'"),
    "unknown child": ("child: Y", "child: W", 10, "joints.Y.child", "unknown link 'W'"),
    "two parents": ("child: X", "child: Y", 11, "joints.X.child", "already hangs on joint Y"),
    "cycle": ("parent: bed, child: Z", "parent: Z, child: Z", 14, "joints.Z.parent", "Z -> Z"),
    "cycle beside a root": ("parent: bed, child: Z", "parent: Y, child: bed", 14,
                            "joints.Z.parent", "bed -> Y -> bed"),
    "no root": ("tool:\n", "  B: {type: rotary, parent: Z, child: bed, axis: [0, 1, 0], "
                "point: [0, 0, 0], rapid: 1}\ntool:\n", 14, "joints.Z.parent", "must be the root"),
    "axis zero": ("axis: [0, 0, 1]", "axis: [0, 0, 0]", 14, "joints.Z.axis", "no direction"),
    "limits order": ("[-250, 250]", "[250, -250]", 11, "joints.X.limits", "[lower, upper]"),
    "no point": ("point: [1, 2, 0], ", "", 13, "joints.C", "`point`"),
    "letter": ("A: {type: rotary", "A: {type: linear", 12, "joints.A.type", "A, B and C are"),
    "axis letter": ("  A: {type", "  Q: {type", 12, "joints.Q", "'Q'"),
    "mesh missing": ("meshes/X.stl", "meshes/W.stl", 5, "links.X.mesh", "does not exist"),
    "mesh above": ("meshes/X.stl", "../X.stl", 5, "links.X.mesh", "outside the folder"),
    "mesh absolute": ("meshes/X.stl", "/X.stl", 5, "links.X.mesh", "outside the folder"),
    "two shapes": ("{mesh: meshes/X.stl}", "{mesh: a.stl, box: {size: [1, 1, 1]}}", 5, "links.X",
                   "mesh and box given"),
    "hollow profile": ("[[40, 300], [60, 400]]", "[[40, 300], [60, 400], [9, 350]]", 8,
                       "links.Z.revolve", "turns back"),
    "start outside": ("start: {Z: 100}", "start: {Z: 101}", 21, "start.Z", "from -400 to 100"),
    "start axis": ("start: {Z: 100}", "start: {B: 1}", 21, "start.B", "no axis B"),
    "reference axis": ("{G28: {Z", "{G28: {B", 20, "reference.G28.B", "no axis B"),
    "tool link": ("  link: Z", "  link: W", 16, "tool.link", "unknown link 'W'"),
    "work link": ("{link: C", "{link: W", 19, "work.link", "unknown link 'W'"),
    "offset name": ("G54: {Z", "G60: {Z", 19, "work.offsets.G60", "G54 ... G59"),
    "tool named as link": ("name: cutter", "name: X", 18, "tool.mounted.name", "a link is named X"),
    "flute longer than the tool": ("name: cutter", "flute: 999, name: cutter", 18,
                                   "tool.mounted.flute", "longer than the tool"),
    "no yaml": ("name: tiny", "name: [", 3, "", "no valid YAML"),
}  # fmt: skip


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistake_is_named(changed, mistake):
    old, new, line, key, text = MISTAKES[mistake]
    path = changed(old, new)
    with pytest.raises(ModelError) as caught:
        load_machine(path)
    assert (caught.value.line, caught.value.key) == (line, key), str(caught.value)
    assert text in str(caught.value)
    assert str(caught.value).startswith(f"{path}:{line}: ")


def test_default_start_outside_travel(changed):
    path = changed("limits: [-250, 250]", "limits: [10, 250]")
    with pytest.raises(ModelError, match=r"start position 0 of axis X .* from 10 to 250"):
        load_machine(path)


def test_allow_outside(tiny, changed):
    (tiny / "meshes" / "X.stl").rename(tiny.parent / "outside.stl")
    path = changed("meshes/X.stl", "../outside.stl")
    assert load_machine(path, allow_outside=True).bodies["X"].parts[0].closed


def test_symlink_may_not_escape(tiny, changed):
    (tiny / "meshes" / "X.stl").rename(tiny.parent / "linked.stl")
    (tiny / "meshes" / "X.stl").symlink_to(tiny.parent / "linked.stl")
    with pytest.raises(ModelError, match="outside the folder"):
        load_machine(str(tiny / "tiny.yaml"))


def test_shipped_name_and_missing_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    by_name = load_machine("table_tilt")
    assert by_name.name == load_machine("table_tilt.yaml").name == "table_tilt"
    with pytest.raises(UsageError, match="did you mean 'table_tilt'"):
        load_machine("tabletilt.yaml")
    (tmp_path / "table_tilt").write_text("name: mine")  # a file of that name comes first
    with pytest.raises(ModelError, match="links"):
        load_machine("table_tilt")


SETUP = """\
machine: tiny.yaml
tools: tools.yaml
offsets: {G54: {X: 3}, G55: {Y: 4}}
start: {X: -20}
bodies:
  vise: {link: C, role: fixture, box: {size: [60, 40, 20]}, placement: {translate: [5, 0, 50]}}
  blank: {link: C, role: stock, box: {size: [30, 20, 10]},
          placement: {rotate: [0, 90, 90], translate: [0, 0, 65]}}
"""


def test_setup(tiny, changed):
    (tiny / "tools.yaml").write_text("tools: [{number: 3, length: 80}]")
    (tiny / "setup.yaml").write_text(SETUP)
    machine = load_machine(changed("for: all", "for: all"), setup=str(tiny / "setup.yaml"))
    assert list(machine.bodies)[-2:] == ["vise", "blank"]
    assert (machine.bodies["vise"].link, machine.bodies["vise"].parts[0].role) == ("C", "fixture")
    blank = machine.bodies["blank"].parts[0].triangles.reshape(-1, 3)
    # 90 about Y takes (30, 20, 10) to (10, 20, 30), then 90 about Z to (20, 10, 30)
    np.testing.assert_array_equal(np.ptp(blank, axis=0), [20, 10, 30])
    np.testing.assert_array_equal(blank.min(axis=0), [-10, -5, 50])
    assert machine.offsets[1].value == (3, 0, 40, 0, 0, 0)  # Z of the machine file stays
    assert machine.offsets[1].rotation == 10
    assert machine.offsets[2].value == (0, 4, 0, 0, 0, 0)
    assert (machine.start["X"], machine.start["Z"]) == (-20, 100)
    assert list(machine.tools) == [3]


@pytest.mark.parametrize(
    ("old", "new", "key", "text"),
    [
        ("role: fixture", "role: clamp", "bodies.vise.role", "'fixture', 'part' or 'stock'"),
        ("  vise: {link: C", "  vise: {link: W", "bodies.vise.link", "unknown link 'W'"),
        ("  vise:", "  X:", "bodies.X", "choose another name"),
        ("  vise:", "  cutter:", "bodies.cutter", "choose another name"),
        ("box: {size: [60, 40, 20]}, ", "", "bodies.vise", "needs a shape"),
        ("X: -20", "X: -2000", "start.X", "from -250 to 250"),
        ("machine: tiny.yaml", "machine: table_tilt", "machine", "this setup is for table_tilt"),
    ],
)
def test_setup_mistakes(tiny, old, new, key, text):
    (tiny / "tools.yaml").write_text("tools: []")
    (tiny / "setup.yaml").write_text(SETUP.replace(old, new, 1))
    with pytest.raises(ModelError) as caught:
        load_machine(str(tiny / "tiny.yaml"), setup=str(tiny / "setup.yaml"))
    assert caught.value.key == key
    assert caught.value.path == str(tiny / "setup.yaml")
    assert text in str(caught.value)
