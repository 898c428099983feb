"""Tool centre point, tilted planes and table offsets put tips and axes where closed forms do."""

import numpy as np
import pytest
from nc.table_tilt import MEANINGS, RAISED, TableTilt

from gcodesim.errors import OrientationError
from gcodesim.nc.canon import canon_rows
from gcodesim.nc.control.runs import Runs
from gcodesim.nc.control.supply import WorkOffset
from gcodesim.nc.interpret import interpret
from gcodesim.nc.program import Frame, Kind

GAUGE_TO_TIP = np.array([[0.0, 0.0, 50.0]])


@pytest.fixture
def run(control):
    """Return a function that interprets a program on a table-tilting machine."""

    def interpreted(text, dialect="fanuc", **fields):
        offsets = {
            1: WorkOffset((10.0, 20.0, 30.0, 0.0, 0.0, 0.0)),
            2: WorkOffset((10.0, 20.0, 30.0, 0.0, 0.0, 0.0), rotation=90.0),
            3: WorkOffset((10.0, 20.0, 30.0, -20.0, 0.0, 35.0)),
        }
        reference = {"G28": {"X": 1.0, "Y": 2.0, "Z": 300.0, "A": 0.0, "C": 0.0}}
        given = {"kinematics": TableTilt(), "axes": "XYZAC", "offsets": offsets}
        chosen = control(dialect, **(given | {"reference": reference} | fields))
        return interpret(f"G90 G17 S1 M3\n{text}\nM30", chosen)

    return interpreted


def moves(meaning):
    assert not meaning.stopped, meaning.findings
    program = meaning.program
    chosen = program.kind <= Kind.ARC
    return program.frame[chosen].tolist(), program.to[chosen]


def axes_of(to, machine=None, tool=GAUGE_TO_TIP):
    return (machine or TableTilt()).axes_at(to[None, :3], to[None, 3:], tool)[0]


def test_tips_under_tool_centre_point_control_are_those_of_kinematics(run):
    text = "G43.4 H1\nG1 X20 Y-30 Z50 A30 C45 F100\nG49\nG0 G53 A0 C0"
    for sign, wanted in ((1.0, (24.79898987, -11.42011126)), (-1.0, (20.55634919, -3.03873304))):
        frames, to = moves(run(text, kinematics=TableTilt(sign)))
        assert frames == [Frame.WORK, Frame.MACHINE]
        np.testing.assert_allclose(to[0], (30, -10, 80, 30, 0, 45), atol=1e-12)
        np.testing.assert_allclose(to[1, :2], wanted, atol=1e-8)


@pytest.mark.parametrize(
    ("dialect", "on", "off"),
    [
        ("fanuc", "G43.4 H1", "G49"),
        ("fanuc", "G43.5 H1", "G43 H3"),
        ("fanuc", "G68.2 X1 Y2 Z3 I10 J20 K30", "G69"),
        ("fanuc", "G54.2 P1", "G54.2 P0"),
        ("haas", "G234 H1", "G49"),
        ("haas", "G254", "G255"),
        ("linuxcnc", "G43 H1\nM428", "M429\nG49"),
    ],
)
def test_switching_on_and_off_moves_nothing(run, dialect, on, off):
    start = "G0 X7 Y8 Z9 A-25 C70"
    frames, to = moves(run(f"{start}\n{on}\n{off}\nG53 G0 X1", dialect))
    assert frames == [Frame.MACHINE, Frame.MACHINE]
    assert to[1].tolist() == [1.0, *to[0, 1:]]
    _, to = moves(run(f"{start}\n{on}\nG53 G0 X1", dialect))
    assert to[1].tolist() == [1.0, *to[0, 1:]]


def test_words_left_out_keep_the_tip_and_machine_words_the_axes(run):
    text = "G0 X7 Y8 Z9 A-25 C70\nG43.4 H1\nG0 X5\nG1 C80 F9\nG53 G0 Z200\nG91 G28 Z0\nG90 G0 X0"
    frames, to = moves(run(text))
    assert frames == [0, 1, 1, 0, 0, 1]
    tip = TableTilt().tips(to[:1], GAUGE_TO_TIP)[0]
    np.testing.assert_allclose(to[1], [15, *tip[1:], -25, 0, 70], atol=1e-12)
    np.testing.assert_allclose(to[2], [15, *tip[1:], -25, 0, 80], atol=1e-12)
    before = axes_of(to[2])
    np.testing.assert_allclose(to[3], [*before[:2], 200, *before[3:]], atol=1e-12)
    np.testing.assert_allclose(to[4], [*before[:2], 300, *before[3:]], atol=1e-12)
    tip = TableTilt().tips(to[4:5], GAUGE_TO_TIP)[0]
    np.testing.assert_allclose(to[5], [10, *tip[1:], -25, 0, 80], atol=1e-12)


def test_a_turned_work_offset_stands_as_the_table_stood(run):
    machine = TableTilt()
    _, to = moves(run("G43.4 H1\nG56 G0 X3 Y4 Z5 A0 C0\nA10", kinematics=machine))
    # At the rotary values of G56 the axes are simply offset and tool length away from the point.
    np.testing.assert_allclose(axes_of(to[0], machine), (13, 24, 85, -20, 0, 35), atol=1e-9)
    np.testing.assert_allclose(to[1, :3], to[0, :3], atol=1e-12)


def test_program_axes_may_be_those_of_the_machine(run):
    text = "G0 A-40 C60\nG43.4 H1\nG0 X3 Y4 Z5\nX13"
    _, to = moves(run(text, tcp_frame="work"))
    np.testing.assert_allclose(axes_of(to[1]), (13, 24, 85, -40, 0, 60), atol=1e-9)
    np.testing.assert_allclose(axes_of(to[2]), (23, 24, 85, -40, 0, 60), atol=1e-9)


def test_feeds_of_tips_and_of_blocks_that_only_turn(run):
    lines = "".join(f"A{n}\n" for n in range(1, 40))
    text = f"G20 G43.4 H1\nG1 X1 F10\n{lines}X2 A0\nG93 A5 F6"
    for given, turning in ((None, 10.0), (3600.0, 3600.0)):
        program = run(text, tcp_rotary_feed=given).program
        feeds = program.f[program.kind == Kind.FEED]
        assert feeds.tolist() == [254.0, *[turning] * 39, 254.0, 6.0]


def test_arcs_under_tool_centre_point_control_lie_in_the_frame_of_the_tip(run):
    meaning = run("G43.4 H1\nG18 G0 X0 Y0 Z0\nG2 X4 I2 A20 F100")
    frames, to = moves(meaning)
    (arc,) = meaning.program.arcs
    assert frames == [1, 1]
    assert arc["center"].tolist() == [12.0, 20.0, 30.0]
    assert arc["normal"].tolist() == [0.0, 1.0, 0.0]
    assert to[1].tolist() == [14.0, 20.0, 30.0, 20.0, 0.0, 0.0]


def test_vectors_become_rotary_axes(run):
    text = "G43.5 H1\nG0 X0 Y0 Z0 I3 J-4 K5\nX9\nG1 I-3 J4 K5 F10\nG3 X10 R8 I0 J0 K1"
    frames, to = moves(run(text))
    assert frames == [1] * 4
    for row, wanted in ((0, (3, -4, 5)), (1, (3, -4, 5)), (2, (-3, 4, 5)), (3, (0, 0, 1))):
        direction = TableTilt().directions(to[row : row + 1, 3:])[0]
        np.testing.assert_allclose(direction, wanted / np.linalg.norm(wanted), atol=1e-12)
    # C turns less when A takes its other side; at the pole C stays.
    assert (to[2, 3], to[3, 5]) == (pytest.approx(-to[0, 3]), to[2, 5])
    frames, _ = moves(run(text, orientation="great_circle"))
    assert frames == [Frame.GREAT_CIRCLE] * 4
    _, turned = moves(run(f"G55\n{text}"))
    np.testing.assert_allclose(
        TableTilt().directions(turned[:1, 3:])[0], np.array([4, 3, 5]) / 50**0.5, atol=1e-12
    )


@pytest.mark.parametrize(
    ("angles", "normal", "along"),
    [
        ("I0 J90 K0", (0, -1, 0), (1, 0, 0)),
        ("I180 J90 K0", (0, 1, 0), (-1, 0, 0)),
        ("I90 J90 K0", (1, 0, 0), (0, 1, 0)),
        ("I-90 J90 K0", (-1, 0, 0), (0, -1, 0)),
        ("I40 J30 K0", (0.32139381, -0.38302222, 0.86602540), (0.76604444, 0.64278761, 0)),
        ("I0 J90 K90", (0, -1, 0), (0, 0, 1)),
        # I = C + 90, J = B, K = -90 is Rz(C) Ry(B).
        ("I110 J30 K-90", (0.46984631, 0.17101007, 0.86602540), (0.81379768, 0.29619813, -0.5)),
    ],
)
def test_tilted_planes_have_the_normals_of_kinematics(run, angles, normal, along):
    text = f"G68.2 X1 Y2 Z3 {angles}\nG53.1\nG0 X0 Y0 Z0\nX10\nX0 Z10"
    frames, to = moves(run(text))
    assert frames == [0, 1, 1, 1]
    np.testing.assert_allclose(TableTilt().directions(to[:1, 3:])[0], normal, atol=1e-8)
    assert to[0, :3].tolist() == [0, 0, 0]
    np.testing.assert_allclose(to[1, :3], (11, 22, 33), atol=1e-12)
    np.testing.assert_allclose(to[2, :3] - to[1, :3], 10 * np.array(along), atol=1e-7)
    np.testing.assert_allclose(to[3, :3] - to[1, :3], 10 * np.array(normal), atol=1e-7)
    assert (to[1:, 3:] == to[0, 3:]).all()


def test_the_preferred_side_of_the_tilt(run):
    for p, a in (("", 30), (" P1", 30), (" P2", -30)):
        _, to = moves(run(f"G68.2 I40 J30\nG53.1{p}"))
        assert to[0, 3] == pytest.approx(a)


def test_tools_arcs_and_cycles_follow_the_plane(run):
    text = (
        "G68.2 J90\nG53.1\nG43 H1\nG0 X0 Y0 Z0\nG2 X2 I1 F100\nG81 X5 Y0 Z-4 R1\nG80\nG0 C10\nG69"
    )
    meaning = run(text)
    frames, to = moves(meaning)
    assert frames == [0, 1, 1, 1, 1, 1, 1, 0]
    (arc,) = meaning.program.arcs
    np.testing.assert_allclose(arc["center"], (11, 20, 30), atol=1e-12)
    np.testing.assert_allclose(arc["normal"], (0, -1, 0), atol=1e-12)
    np.testing.assert_allclose(to[3:5, :3], [(12, 19, 30), (15, 19, 30)], atol=1e-12)
    np.testing.assert_allclose(to[5:7, :3], [(15, 24, 30), (15, 19, 30)], atol=1e-12)
    # The tip stands where the plane says, and the tool is 50 mm long against the normal.
    np.testing.assert_allclose(to[7, :3], axes_of(np.array([15, 19, 30, 90, 0, 10.0]))[:3])
    assert [f.meaning for f in meaning.findings] == []


def test_planes_from_the_tool_and_planes_in_planes(run):
    _, to = moves(run("G0 A30 C40\nG68.3 X1 R20\nG0 X0 Y0 Z0\nX10\nX0 Z10"))
    normal = TableTilt().directions(to[:1, 3:])[0]
    np.testing.assert_allclose(to[1, :3], (11, 20, 30), atol=1e-12)
    np.testing.assert_allclose(to[3, :3] - to[1, :3], 10 * normal, atol=1e-9)
    # At R0 X of the plane is X of the machine, seen from the turned table.
    seen = TableTilt().tips(
        np.array([[1.0, 0, 0, 30, 0, 40], [0, 0, 0, 30, 0, 40]]), 0 * to[:2, :3]
    )
    along = (to[2, :3] - to[1, :3]) / 10
    assert along @ (seen[0] - seen[1]) == pytest.approx(np.cos(np.radians(20)))
    _, to = moves(run("G68.2 X5 I90 J90\nG68.4 X1 Y2 J-90\nG53.1\nG0 X0 Y0 Z0\nX10"))
    np.testing.assert_allclose(to[-2:, :3], [(15, 21, 32), (15, 31, 32)], atol=1e-12)


def test_g92_counts_along_the_axes_of_the_plane(run):
    _, to = moves(run("G68.2 X1 I0 J90 K90\nG53.1\nG0 X5 Y6 Z7\nG92 X1 Z2\nG0 X2 Y6 Z4"))
    # X of the plane is Z of the work offset, Y is X turned over, Z is -Y.
    np.testing.assert_allclose(to[1, :3], (11 - 6, 20 - 7, 30 + 5), atol=1e-12)
    np.testing.assert_allclose(to[2, :3] - to[1, :3], (0, -2, 1), atol=1e-12)


@pytest.mark.parametrize(
    ("dialect", "on", "off"), [("haas", "G254", "G255"), ("fanuc", "G54.2 P1", "G54.2 P0")]
)
def test_the_table_carries_the_work_offset(run, dialect, on, off):
    text = f"{on}\nG0 C90\nX1 Y2\nG91 A-10 X1\nG90 G53 G0 X0\nG0 X1\n{off}\nG0 X1"
    frames, to = moves(run(text, dialect))
    assert frames == [0] * 6
    machine, origin = TableTilt(), np.array([[10.0, 20.0, 30.0]])
    at_90, tilted = (
        machine.carried(origin, np.array([rotary]))[0] for rotary in ((0, 0, 90), (-10, 0, 90))
    )
    assert to[0].tolist() == [0, 0, 0, 0, 0, 90]
    np.testing.assert_allclose(to[1], [at_90[0] + 1, at_90[1] + 2, 0, 0, 0, 90], atol=1e-12)
    np.testing.assert_allclose(to[2], [at_90[0] + 2, at_90[1] + 2, 0, -10, 0, 90], atol=1e-12)
    assert to[4, 0] == pytest.approx(tilted[0] + 1)
    assert to[5, 0] == 11.0


def test_vectors_and_planes_are_refused_where_they_mean_nothing(run, control):
    for text in ("G1 X1 I1 F9", "G43.5 H1\nG49 G1 X1 I1 F9", "G43.5 H1\nG1 X1 A5 F9", "G68.2 A5"):
        assert run(text).findings[-1].meaning.removesuffix("_open") == "unused_word"
    for text in ("G68.2 P1 X1 I1 J2 K3", "G43.4 H1\nG0 X1"):
        last = interpret(f"{text}\nM30", control()).findings[-1]
        assert (last.meaning, last.code) == ("unknown_g", "GC402")


@pytest.mark.parametrize("meaning", MEANINGS)
def test_what_cannot_be_done_has_its_meaning(run, meaning):
    text = MEANINGS[meaning]
    found = run(text).findings[-1]
    assert (found.meaning, found.line) == (meaning, text.count("\n") + 2)


@pytest.mark.parametrize("meaning", RAISED)
def test_what_kinematics_refuse_is_a_finding_of_the_block(run, meaning, monkeypatch):
    def refuse(*args):
        raise OrientationError(meaning, "not so")

    monkeypatch.setattr(TableTilt, "rotary_at", refuse)
    last = run("G68.2 J30\nG53.1").findings[-1]
    assert (last.meaning, last.line) == (meaning, 3)
    assert last.message.startswith("not so: ")


def test_canon_names_the_frame_of_a_move(run):
    rows = list(canon_rows(run("G0 X1\nG43.4 H1\nG0 X2\nG53 G0 X3")))
    assert [row.get("frame") for row in rows if row["kind"] == "rapid"] == [None, "work", None]


def test_canon_gives_minutes_where_only_kinematics_know_the_length(run):
    text = "G93 G1 X1 F2\nG43.4 H1\nX5 F4\nX7 F4\nG43.4 H3\nX8 F5\nX10 F5\nG49\nX11 F8\nX9 F8"
    rows = [row for row in canon_rows(run(text)) if row["kind"] == "feed"]
    found = [row.get("f", row.get("minutes")) for row in rows]
    assert [("f" in row) for row in rows] == [True, False, True, False, True, False, True]
    np.testing.assert_allclose(found[1:], [0.25, 8.0, 0.2, 10.0, 0.125, 16.0])


@pytest.mark.parametrize(
    ("head", "fields"),
    [
        ("G43.4 H1\nG0 X1", {}),
        ("G43.4 H1\nG56 G0 X1", {}),
        ("G0 A-30 C50\nG43.4 H1\nG0 X1", {"tcp_frame": "work"}),
        ("G68.2 X1 Y2 I30 J20 K10\nG53.1\nG43 H1\nG0 X1", {}),
        ("G68.2 X1 Y2 I30 J20 K10\nG0 X1", {}),
        ("G68.2 I30 J20\nG43.4 H1\nG0 X1", {}),
        ("G55\nG68.2 I30 J20 K10\nG53.1\nG0 X1", {}),
        ("G68 X1 Y2 R30\nG0 X1", {}),
        ("G51.1 X1\nG0 X1", {}),
        ("G54.2 P1\nG0 C40 X1", {}),
        ("G43.5 H1\nG1 X1 I1 J2 K3", {}),
    ],
)
def test_runs_of_tips_equal_the_block_by_block_way(run, head, fields, rng, monkeypatch):
    blocks = []
    for _ in range(60):
        rotary = rng.choice(["", "", "", "A5", "A-9.5 C400", "C-3"])
        words = [f"{axis}{rng.uniform(-20, 20):.3f}" for axis in "XYZ" if rng.random() < 0.6]
        arc = f"G2 X{rng.uniform(0, 9):.3f} Y{rng.uniform(0, 9):.3f} R40 G17"
        blocks.append(arc if rng.random() < 0.15 else f"G{rng.integers(2)} {' '.join(words)}")
        blocks.append(f"G1 X{rng.uniform(0, 9):.3f} {rotary}" if "43.5" not in head else "G1 Z1")
        blocks += [f"G1 X{n} Y{rng.uniform(-9, 9):.2f} F{n + 1}" for n in range(20)]
    text = f"F500\n{head}\n" + "\n".join(blocks)
    fast = run(text, **fields)
    monkeypatch.setattr(Runs, "take", lambda self, source, index, most: 0)
    slow = run(text, **fields)
    for column in ("kind", "line", "frame", "to", "f", "feed_mode", "speed", "aux", "arcs"):
        mine, theirs = getattr(fast.program, column), getattr(slow.program, column)
        assert mine.tobytes() == theirs.tobytes(), column
    assert (fast.findings, fast.blocks, fast.stopped) == (slow.findings, slow.blocks, False)
