"""What only LinuxCNC writes: @ and ^, computed calls, its own names, M70 to M73, fractional N."""

import pytest

from gcodesim.nc.interpret import interpret
from gcodesim.nc.program import Kind, Turning


def ends(meaning):
    """X Y Z at the end of every move."""
    points = meaning.program.to[meaning.program.kind <= Kind.ARC][:, :3]
    return [[round(float(x), 9) + 0.0 for x in point] for point in points]


def meanings(meaning):
    return [finding.meaning for finding in meaning.findings]


MOVES = {
    "radius and angle": ("G0 @5 ^90", [[0, 5, 0]]),
    "the radius stays": ("G0 @5 ^90\n^0", [[0, 5, 0], [5, 0, 0]]),
    "the angle stays": ("G0 X3 Y4\n@10 Z1", [[3, 4, 0], [6, 8, 1]]),
    "in steps": ("G0 X4\nG91 @1 ^90", [[4, 0, 0], [0, 5, 0]]),
    "in inches": ("G20 G0 @1 ^180", [[-25.4, 0, 0]]),
    "with a feed": ("G1 F9 S1 M3 @[2+3] ^#1", [[5, 0, 0]]),
    "a call by expression": (
        "#2=50\nO[#2*2] CALL [7]\nM2\nO100 SUB\nG0 X#1\nO100 ENDSUB",
        [[7, 0, 0]],
    ),
    "a call by parameter": ("#1=3\no#1 call\nM2\no3 sub\nG0 X1\no3 endsub", [[1, 0, 0]]),
    "exists": ("G0 X[EXISTS[#1]+EXISTS[#<_x>]*2] Y[EXISTS[#<_no>]]", [[3, 0, 0]]),
    "exists by way of another": (
        "#1=2\n#2=99999\nG0 X[EXISTS[##1]] Y[EXISTS[##2]] Z[EXISTS[#[#1-1]]]",
        [[1, 0, 1]],
    ),
    "the name of a program": ("O<MyProgram>\nG0 X1", [[1, 0, 0]]),
    "debugging": ("#5599=0\n(DEBUG,#1)\nG0 X1", [[1, 0, 0]]),
    "radius mode of lathes": ("G18 G8\nG0 X1", [[1, 0, 0]]),
    "in step with the spindle": (
        "S5 M3 G33 Z-5 K2\nX1 K1\nG20 G33.1 Z0 X0 K1",
        [[0, 0, -5], [1, 0, -5], [0, 0, 0], [1, 0, -5]],
    ),
    "fractional N": ("N1.5 G0 X1\nN.5 o1 if [1]\nX2\nN7 o1 endif", [[1, 0, 0], [2, 0, 0]]),
    "no value before a call": ("G0 X[#<_value>+1] Y#<_value_returned>", [[1, 0, 0]]),
    "a value after a call": (
        "o1 sub\no1 return [7]\no1 endsub\no1 call\nG0 X#<_value> Y#<_value_returned>",
        [[7, 1, 0]],
    ),
    "modes": ("G0 X#<_motion_mode> Y#<_plane> Z#<_metric>", [[800, 170, 1]]),
    "positions": ("G0 X2 Y3\nX[#<_x>+1] Z#<_abs_y>", [[2, 3, 0], [3, 3, 3]]),
    "tools": ("T2 M6\nG0 X#<_current_tool> Y#<_selected_tool>", [[2, 2, 0]]),
    "spindle": ("S5 $0 M3\nG0 X#<_spindle_on> Y#<_rpm>", [[1, 5, 0]]),
    "M99 goes to the start of the file": (
        "#100=[#100+1]\nO10 if [#100 GT 2]\nM30\nO10 endif\nO1\nG0 X#100\nM99",
        [[1, 0, 0], [2, 0, 0]],
    ),
    "M72": ("G0 X1\nM70\nG91 G20\nM72\nX1 Y2", [[1, 0, 0], [1, 2, 0]]),
    "M72 puts an offset back": ("M70\nG55\nG0 X0\nM72\nX0", [[100, 0, 0], [0, 0, 0]]),
    "M72 puts a length back": ("T2 M6 G43\nM70\nG49\nM72\nG0 Z0", [[0, 0, 75.5]]),
    "M72 leaves the motion mode": ("F9 S1 M3 G0 X1\nM70\nG1\nM72\nX2", [[1, 0, 0], [2, 0, 0]]),
    "M73 ends with its call": (
        "o1 sub\nM73\nG91 G20\nX1\no1 endsub\nG0 X1\no1 call\nX1",
        [[1, 0, 0], [26.4, 0, 0], [1, 0, 0]],
    ),
    "M70 does not": ("o1 sub\nM70\nG91\no1 endsub\nG0 X1\no1 call\nX1", [[1, 0, 0], [2, 0, 0]]),
    "M71 forgets": ("o1 sub\nM73\nM71\nG91\no1 endsub\nG0 X1\no1 call\nX1", [[1, 0, 0], [2, 0, 0]]),
}  # fmt: skip


@pytest.mark.parametrize("name", MOVES)
def test_linuxcnc_moves_as_its_text_says(name, control):
    text, wanted = MOVES[name]
    meaning = interpret(f"{text}\nM2", control("linuxcnc", max_blocks=50))
    assert ends(meaning) == wanted
    assert set(meanings(meaning)) <= {"parameter_undefined", "spindle_off_feed"}


@pytest.mark.parametrize(
    "block",
    [
        "G0 X#<_hal[plasmac.cut-feed-rate]>",
        "F#<_ini[traj]max>",
        "#1=#<_task>",
        "#1=EXISTS[#<_hal[pin]>]",
    ],
)
def test_what_only_the_running_control_knows_is_open(block, control):
    meaning = interpret(f"{block}\nM2", control("linuxcnc"))
    assert [(f.code, f.meaning) for f in meaning.findings] == [("GC402", "parameter_unknown")]


def test_modes_of_another_call_are_not_put_back(control):
    text = "M70\no1 sub\nM72\no1 endsub\no1 call\nM2"
    assert meanings(interpret(text, control("linuxcnc"))) == ["modes_not_saved"]


def test_the_spindle_that_m72_puts_back_turns(control):
    program = interpret("S1 M3\nM70\nM5\nG0 X1\nM72\nG0 X2\nM2", control("linuxcnc")).program
    turning = program.turning[program.kind <= Kind.ARC].tolist()
    assert turning == [Turning.STANDS, Turning.MAY_TURN]


def test_another_spindle_than_the_main_one_is_refused(control):
    assert meanings(interpret("S5 $0\nS5 $1\nM2", control("linuxcnc"))) == ["unused_word"]


@pytest.mark.parametrize("dialect", ["fanuc", "haas"])
def test_these_belong_to_linuxcnc_alone(dialect, control):
    assert meanings(interpret("G0 X1\nM70\nM30", control(dialect))) == ["unknown_m"]
    assert meanings(interpret("G0 @5\nM30", control(dialect))) == ["unused_word"]
    assert meanings(interpret("N1.5 G0 X1\nM30", control(dialect))) == ["integer_expected"]
