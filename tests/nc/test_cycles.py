"""Canned cycles make the moves of the language's table, in every plane and dialect."""

import pytest

from gcodesim.nc.interpret import interpret
from gcodesim.nc.program import Kind

HEAD = "G90 G17 S500 M3 F100\nG0 X0 Y0 Z20\n"
APPROACH = ["R 10 0 20", "R 10 0 2"]


def path(meaning, axes=(0, 1, 2), behind=2):
    """Moves and dwells behind a line: R, F or D with the values of some axes."""
    program, rows = meaning.program, []
    for i in range(len(program)):
        kind, to = Kind(program.kind[i]), program.to[i]
        if program.line[i] > behind and kind in (Kind.RAPID, Kind.FEED):
            rows.append(" ".join(["RF"[kind], *(f"{round(to[a], 6) + 0.0:g}" for a in axes)]))
        elif program.line[i] > behind and kind == Kind.DWELL:
            rows.append(f"D {program.f[i]:g}")
    return rows


def test_a_cycle_drills_upwards_where_its_bottom_lies_above_its_r_level(control):
    meaning = interpret("S500 M3 F100 G19\nG0 X0 Y0 Z20\nG98 G83 X50 R10 Q30\nG80\nM30", control())
    assert not meaning.stopped, meaning.findings
    assert path(meaning, (0,)) == ["R 10", "F 40", "R 10", "R 39.746", "F 50", "R 0"]


@pytest.mark.parametrize(
    ("dialect", "block", "steps"),
    [
        ("fanuc", "G81 X10 Z-5 R2", ["F 10 0 -5", "R 10 0 20"]),
        ("linuxcnc", "G81 X10 Z-5 R2", ["F 10 0 -5", "R 10 0 2"]),
        ("fanuc", "G99 G82 X10 Z-5 R2 P250", ["F 10 0 -5", "D 0.25", "R 10 0 2"]),
        ("haas", "G99 G82 X10 Z-5 R2 P.25", ["F 10 0 -5", "D 0.25", "R 10 0 2"]),
        (
            "fanuc",
            "G99 G83 X10 Z-3 R2 Q2",
            ["F 10 0 0", "R 10 0 2", "R 10 0 0.254", "F 10 0 -2", "R 10 0 2", "R 10 0 -1.746"]
            + ["F 10 0 -3", "R 10 0 2"],
        ),
        (
            "fanuc",
            "G99 G73 X10 Z-3 R2 Q2",
            ["F 10 0 0", "R 10 0 0.254", "F 10 0 -2", "R 10 0 -1.746", "F 10 0 -3", "R 10 0 2"],
        ),
        ("haas", "G84 X10 Z-5 R2", ["F 10 0 -5", "F 10 0 2", "R 10 0 20"]),
        ("fanuc", "G99 G74 X10 Z-1 R2 Q2", ["F 10 0 0", "F 10 0 2", "F 10 0 -1", "F 10 0 2"]),
        ("fanuc", "G99 G89 X10 Z-5 R2 P100", ["F 10 0 -5", "D 0.1", "F 10 0 2"]),
        (
            "fanuc",
            "G76 X10 Z-5 R2 Q.5 P100",
            ["F 10 0 -5", "D 0.1", "R 10.5 0 -5", "R 10.5 0 20", "R 10 0 20"],
        ),
        (
            "linuxcnc",
            "G87 X10 Z-5 R2 I1 J.5 K-3",
            ["R 11 0.5 2", "R 11 0.5 -5", "R 10 0 -5", "F 10 0 -3", "F 10 0 -5"]
            + ["R 11 0.5 -5", "R 11 0.5 2", "R 10 0 2"],
        ),
    ],
)
def test_steps_after_the_approach(dialect, block, steps, control):
    meaning = interpret(f"{HEAD}{block}\nG80\nM30", control(dialect))
    assert not meaning.stopped, meaning.findings
    assert path(meaning) == APPROACH + steps


def test_fanuc_bores_back_from_below(control):
    meaning = interpret(f"{HEAD}G98 G87 X10 Z-5 R-9 Q1\nG80\nM30", control())
    around = ["R 10 0 20", "R 11 0 20", "R 11 0 -9", "R 10 0 -9", "F 10 0 -5"]
    assert path(meaning) == around + ["R 11 0 -5", "R 11 0 20", "R 10 0 20"]


@pytest.mark.parametrize(
    ("plane", "hole", "axes"), [("G18", "Z10 Y-5", (2, 0, 1)), ("G19", "Y10 X-5", (1, 2, 0))]
)
def test_other_planes_drill_along_their_normal(plane, hole, axes, control):
    meaning = interpret(f"G90 S500 M3 F100\n{plane} G99 G81 {hole} R2\nG80\nM30", control())
    wanted = ["R 0 0 2", "R 10 0 2", "F 10 0 -5", "R 10 0 2"]
    assert path(meaning, axes, behind=1) == wanted


def test_words_are_kept_until_the_cycle_ends(control):
    text = HEAD + "G99 G81 X10 Z-5 R2 K0\nX20\nZ-6\nR3\nX30\nG80\nX40\nM30"
    holes = ["R 20 0 20", "R 20 0 2", "F 20 0 -5", "R 20 0 2"]
    holes += ["F 20 0 -6", "R 20 0 2"]
    last = ["R 30 0 3", "F 30 0 -6", "R 30 0 3", "R 40 0 3"]
    usual, axis, place = (
        path(interpret(text, control(cycle_drills=reading)))
        for reading in ("axis_or_r", "axis", "xy")
    )
    assert usual == [*holes, "R 20 0 3", "F 20 0 -6", "R 20 0 3", *last]
    assert axis == [*holes, "R 20 0 3", *last]
    assert place == [*holes[:4], "R 20 0 3", *last]
    assert interpret(text, control("linuxcnc")).findings[-1].meaning == "axis_without_motion"


def test_incremental_repeats_step_from_hole_to_hole(control):
    meaning = interpret(HEAD + "G91 G99 G81 X5 Z-4 R-17 L2\nG80\nM30", control())
    one = ["R 5 0 20", "R 5 0 3", "F 5 0 -1", "R 5 0 3"]
    assert path(meaning) == [*one, "R 10 0 3", "F 10 0 -1", "R 10 0 3"]


def test_a_motion_code_ends_the_cycle_with_or_without_g80(control):
    for block in ("G0 X30", "G80 G0 X30", "G0 G80 X30"):
        meaning = interpret(f"{HEAD}G81 X10 Z-5 R2\n{block}\nX40\nM30", control("linuxcnc"))
        assert path(meaning, behind=3) == ["R 30 0 2", "R 40 0 2"]


def test_rigid_tapping_turns_the_spindle_itself(control):
    meaning = interpret("F100 G0 Z9\nM29 S500\nG84 X1 Z-1 R1\nG80\nM30", control())
    assert not meaning.stopped


def test_the_back_off_is_the_control_s_own(control):
    meaning = interpret(HEAD + "G73 X10 Z-3 R2 Q4\nG80\nM30", control(peck_backoff=0.5))
    assert path(meaning)[2:4] == ["F 10 0 -2", "R 10 0 -1.5"]


@pytest.mark.parametrize(
    ("way", "aside"), [("+X", "11 0"), ("-X", "9 0"), ("+Y", "10 1"), ("-Y", "10 -1")]
)
def test_boring_tools_leave_the_wall_as_the_machine_file_says(way, aside, control):
    meaning = interpret(HEAD + "G99 G76 X10 Z-3 R2 Q1\nG80\nM30", control(bore_shift=way))
    wanted = ["F 10 0 -3", f"R {aside} -3", f"R {aside} 2", "R 10 0 2"]
    assert path(meaning)[2:] == wanted
    meaning = interpret(HEAD + "G98 G87 X10 Z-5 R-9 Q1\nG80\nM30", control(bore_shift=way))
    assert path(meaning)[1:3] == [f"R {aside} 20", f"R {aside} -9"]
