"""Runs of plain blocks mean, bit for bit, what the block-by-block way makes of them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from nc.controls import make_control
from nc.table_tilt import TableTilt

from gcodesim.nc.control import runs
from gcodesim.nc.control.readings import ROWS
from gcodesim.nc.control.supply import ToolEntry, WorkOffset
from gcodesim.nc.interpret import interpret
from gcodesim.nc.iso.scan import scan
from gcodesim.nc.lines import Lines

COLUMNS = ("kind", "line", "frame", "to", "f", "feed_mode", "speed", "aux", "start", "arcs")
OFFSETS = {
    1: WorkOffset((1.0, -2.0, 0.1, 0.0, 0.0, 3.0)),
    2: WorkOffset((100.0, 50.0, 10.0, 0.0, 0.0, 0.0), rotation=30.0),
}
TOOLS = {number: ToolEntry(number, (0.0, 0.0, 9.5, 0.0, 0.0, 0.0), 6.0) for number in (1, 2)}
CONTROLS = [
    {"axes": "XYZAC", "wrap": {"C": "shortest"}},
    {"axes": "XYZABC", "wrap": {"A": "sign", "C": "shortest"}, "travel": {"C": (-400.0, 400.0)}},
    {"axes": "XYZBC", "ignore_words": ("E", "Q"), "feed": 500.0},
    {"axes": "XYZ", "program_unit": "inch", "block_delete": True},
    {"axes": "XYZAC", "max_blocks": 23, "tools": TOOLS},
    {"axes": "XYZA", "ignore_words": ("M", "S", "T")},
    {"axes": "XYZAC", "no_point": "both", "wrap": {"C": "shortest"}},
    {"axes": "XYZAC", "no_point": "increment", "program_unit": None},
    {"axes": "XYZ", "no_point": "open", "program_unit": None, "unit": "inch"},
    {"axes": "XYZAC", "kinematics": TableTilt(), "wrap": {"C": "shortest"}, "tcp_rotary_feed": 7.0},
]

NUMBERS = st.one_of(
    st.integers(-400, 400).map(str),
    st.decimals(-99, 99, places=3).map(str),
    st.decimals(-9999, 9999, places=5).map(str),
    st.sampled_from(["0", "-0", "+5", "5.", ".5", "-.5", "0.10", "007", "1234567.1234567"]),
    st.sampled_from(["0.000000001", "123456789", "-", ".", "1.2.3", "", "12345678.12345678"]),
)
AXIS_WORDS = st.builds("{}{}".format, st.sampled_from("XYZABC"), NUMBERS)
WORDS = st.one_of(
    *[AXIS_WORDS] * 5,
    st.builds("{}{}".format, st.sampled_from("EFNGQSTM"), NUMBERS),
    st.sampled_from(["F100", "F2.5", "G0", "G1", "g01", "G00", "N7"]),
    st.sampled_from(["S0", "S500", "S1234.5", "T1", "T2", "T0", "M7", "m08", "M9", "S-0", "M8.0"]),
)
PLAIN = st.lists(WORDS, max_size=5, unique_by=lambda word: word[:1].upper()).map(" ".join)
OTHER = st.sampled_from(
    ["G20", "G21", "G90", "G91", "G93", "G94", "G95", "G54", "G55", "S500 M3", "M5", "T1 M6"]
    + ["(a comment)", "/X5", "", " \t ", "G91 G28 Z0", "G80", "G52 X1", "G2 X5 R9", "G68 R5 X0 Y0"]
    + [
        "G69",
        "G96 S5 D7",
        "G97",
        "M4",
        "T2 M6",
        "G81 X1 R5 Z1",
        "#1=1",
        "IF[#1GT5]GOTO1",
        "G17",
        "x1(c)",
        "G0 X1;",
        "G16",
        "G15",
    ]
)

LENGTHS = st.sampled_from(["5", "-5", "2.5", "7.07", "0", "12.345", "100"])
ARCS = st.one_of(
    st.builds("G{} X{} Y{} R{}".format, st.integers(2, 3), LENGTHS, LENGTHS, st.just("9999")),
    st.builds("G{} X{} R{}".format, st.integers(2, 3), LENGTHS, LENGTHS),
    st.builds("G{} {}{} {}{}".format, st.integers(2, 3), *[st.sampled_from("IJKZ"), LENGTHS] * 2),
    st.builds("{}{} {}{}".format, *[st.sampled_from("XYZIJKR"), LENGTHS] * 2),
)
HOLES = st.one_of(
    *[st.builds("X{} Y{}".format, LENGTHS, LENGTHS)] * 4,
    st.builds("{}{}".format, st.sampled_from("XXXYYYF"), st.sampled_from(["1", "2.5", "9"])),
    st.sampled_from(["N5", "", "X0 Y0", "X0 Y0", "F50 X3", "N7 X-2 Y3 F3", "Z-5 R2", "G81 X3 Z-5"]),
    st.sampled_from(["R2", "G83 X5 Q1.5", "G81", "Q2", "X9 M8", "S300 Y1", "X2 S0", "T2", "T3 X1"]),
)
CYCLES = st.sampled_from(
    ["G81 Z-5 R2", "G82 Z-5 R2 P100", "G82 Z-5 R2", "G83 Z-5 R2 Q1.5", "G73 R2 Z-5.25 Q.75"]
    + ["G99 G84 Z-5 R2", "G85 R0 Z-1", "G89 P10 Z-4 R5", "G76 Q1 R2 Z-1", "G86 Z-5 R7", "G88 R1 Z0"]
    + ["G98 G83 Z-5 R9 Q2", "G81 Z1 R1", "G98 G81 Y3 X-8 Z-9 R.1", "G83 R3 Z-5 Q-1"]
)
MODES = st.sampled_from(["G90", "G91", "G54", "G55", "G20", "G21", "G0 Z50", "G80", "G98", "G99"])
FIVE_AXIS = st.sampled_from(
    ["G43.4 H1", "G43.4 H1", "G43.5 H1", "G49", "G68.2 X1 J9", "G69", "G54.2 P1"]
)
ODD = st.one_of(
    ARCS, PLAIN, MODES, st.sampled_from(["G0 X1", "X1 L2", "Z-3 R1", "A5", "M5", "G93"])
)


def section(head, lines):
    return "\n".join([head, *lines])


def arc(letters, kind, g, i, j, more):
    """Return an incremental arc that closes: half, quarter and full circle, and one with R."""
    u, v, centre_u, centre_v = letters
    end = [(2 * i, 2 * j), (i + j, j - i), (0, 0), (i, j)][kind]
    words = f"{u}{end[0]}{v}{end[1]}" if kind != 2 else ""
    centre = f"{centre_u}{i}{centre_v}{j}" if kind != 3 else f"R{abs(i) + abs(j)}"
    return f"{g}{words}{centre}{more}"


def arcs_of(head, letters, more):
    quarters = st.integers(1, 40).map(lambda n: (n - 20.5) / 4)
    codes, more = st.sampled_from(["G2", "G3", ""]), st.sampled_from(["", "", "F300", *more])
    lines = st.builds(arc, st.just(letters), st.integers(0, 3), codes, quarters, quarters, more)
    other = st.sampled_from(["G1 X1", "G0 Z-1", "N7", "F2", "X3", "", "I2 J2"])
    return st.builds(section, st.just(head), st.lists(st.one_of(*[lines] * 9, other), min_size=4))


ARC_PROGRAMS = st.one_of(
    arcs_of("G91 G17 G3 X5 R5", "XYIJ", ["Z1", "A3"]),
    arcs_of("G91 G18 G2 X5 R5", "ZXKI", ["Y-2"]),
    arcs_of("G91 G19 G2 Y5 R-9", "YZJK", ["X.1"]),
)
HOLE_PROGRAMS = st.builds(section, CYCLES, st.lists(HOLES, min_size=3))
MIXED = st.lists(
    st.one_of(ARC_PROGRAMS, HOLE_PROGRAMS, HOLE_PROGRAMS, MODES, ODD, FIVE_AXIS), max_size=8
)
LINES = st.lists(st.one_of(*[PLAIN] * 6, OTHER), max_size=40)


def with_and_without_runs(text, control):
    fast = interpret(text, control, "p.nc")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(runs.Runs, "take", lambda self, source, index, most: 0)
        return fast, interpret(text, control, "p.nc")


def lines_taken(text, control):
    """Return how many lines each attempt to begin a run has taken."""
    taken, take = [], runs.Runs.take
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(runs.Runs, "take", lambda *args: taken.append(take(*args)) or taken[-1])
        interpret(text, control)
    return taken


def assert_equal(fast, slow):
    for column in COLUMNS:
        mine, theirs = getattr(fast.program, column), getattr(slow.program, column)
        assert mine.dtype == theirs.dtype
        assert mine.tobytes() == theirs.tobytes(), column
    for name in (
        "findings",
        "blocks",
        "last_line",
        "ignored",
        "unsupported",
        "stopped",
        "readings",
    ):
        assert getattr(fast, name) == getattr(slow, name), name


@settings(derandomize=True, max_examples=1200, deadline=None, database=None)
@given(
    st.one_of(LINES, MIXED),
    st.sampled_from(CONTROLS),
    st.sampled_from(sorted(ROWS)),
    st.sampled_from([1, 2, 3, 5, 9, 50]),
)
def test_runs_equal_the_block_by_block_way(lines, fields, dialect, chunk):
    text = "\n".join(["G1 F100 S5 M3", "N1 G0 X0", *lines, "M30"])
    control = make_control(dialect, offsets=OFFSETS, **fields)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(runs, "SHORTEST", 1)
        patch.setattr(runs, "CHUNK", chunk)
        assert_equal(*with_and_without_runs(text, control))


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("fields", CONTROLS[:2])
def test_long_programs_are_run_in_runs(fields, end, rng):
    words = rng.uniform(-80, 80, (500, 5)).round(3)
    words[:, 4] = (words[:, 4] * (5 if len(fields["wrap"]) == 1 else 1)).round(3)
    blocks = [f"N{i} X{x} Y{y} Z{z} A{a / 9:.2f} C{c}" for i, (x, y, z, a, c) in enumerate(words)]
    text = end.join(["G90 G1 F900 S1 M3", *blocks, "M30"])
    control = make_control("fanuc", offsets=OFFSETS, **fields)
    fast, slow = with_and_without_runs(text, control)
    assert_equal(fast, slow)
    assert len(fast.program) == 503
    # The axis that is read by its sign is left to the block-by-block way.
    assert max(lines_taken(text, control)) == (0 if "A" in fields["wrap"] else 500)


LONG = {
    "arcs": ["G91 G1 X5", *["G2 X3 Y1 I1 J2 Z-.1", "G3 X-3. Y-1. R9.", "G1 X.5 Y-.25 A1"] * 200],
    "holes": ["G99 G83 Z-9 R2 Q2.5", *[f"X{i / 7:.3f} Y{-i % 11}" for i in range(600)]],
    "turned": ["G55 G98 G73 Z-9 R2 Q3", *[f"N{i} X{i}" for i in range(600)]],
    "speeds": ["G1 X0 (begin)", *[f"X{i / 7:.3f} S{i % 99}" for i in range(600)]],
    "others": ["G1 X0 (begin)", *[f"X{i / 7:.3f} T{i % 3} M{7 + i % 3}" for i in range(600)]],
    "drilled": [
        "G99 G81 Z-5 R2",
        *[f"X{i} Y{-i % 11} S{i} T{i % 3} M{7 + i % 3}" for i in range(600)],
    ],
    "tips": ["G43.4 H1", *[f"G1 X{i} Z{i % 7} A{i / 9:.3f} C{10 * i}" for i in range(600)]],
    "repeated": ["G89 Z-9 R2 P10", *[f"G89 Y{i % 13} Z-9 R2 F{i + 1}" for i in range(600)]],
}


@pytest.mark.parametrize("name", LONG)
def test_long_programs_of_arcs_and_holes_are_run_in_runs(name):
    text = "\n".join(["G90 G1 F900 S1 M3 Z30", *LONG[name], "M30"])
    control = make_control("fanuc", offsets=OFFSETS, axes="XYZAC", kinematics=TableTilt())
    fast, slow = with_and_without_runs(text, control)
    assert_equal(fast, slow)
    assert fast.blocks == 603
    assert sum(lines_taken(text, control)) >= 599


def test_numbers_are_those_of_float(rng):
    texts = [f"{rng.uniform(-1, 1) * 10.0**e:.{d}f}" for e in range(8) for d in range(8)] * 5
    texts += [
        "5",
        "5.",
        ".5",
        "+.25",
        "-0",
        "-0.0",
        "00012",
        "99999999.9999999",
        "12345678.1234567",
    ]
    lines = Lines("".join(f" x{text}\n" for text in texts))
    words = scan(lines, 0, len(lines), "XYZ", frozenset())
    digits = np.array([sum(c.isdigit() for c in text) for text in texts])
    short = np.array([len(t.lstrip("+-").partition(".")[0]) <= 8 for t in texts]) & (digits <= 15)
    assert words.plain.tolist() == short.tolist()
    wanted = np.array([float(text) for text in texts])
    assert words.value["X"][short].tobytes() == wanted[short].tobytes()


def test_what_is_no_plain_block_is_left_alone():
    texts = ["G1X1Y2", "g 0 x 1 . 5", "N5", "", "X1X2", "G4X1", "X", "X-", "X.", "X1.2.3", "1X1"]
    texts += ["X1%", "/X1", "X1(c)", "U1", "F0", "F-1", "N1.5", "N-1", "X1-", "-X1", "X\xe41", "."]
    texts += ["X1" + " " * 4095]
    lines = Lines("\n".join(texts))
    words = scan(lines, 0, len(lines), "XYZ", frozenset())
    assert [t for t, plain in zip(texts, words.plain, strict=True) if plain] == texts[:4]
    assert words.blank[:5].tolist() == [False, False, False, True, False]


def test_progress_is_told_as_the_lines_go_by(monkeypatch):
    monkeypatch.setattr(runs, "CHUNK", 100)
    fractions = []
    text = "G0\n" + "".join(f"X{i}\n" for i in range(398)) + "M30\n"
    interpret(text, make_control(), progress=fractions.append)
    assert fractions == pytest.approx([0.25, 0.5, 0.75, 0.9975])
