"""Tables, rotation, mirror and polar words put points where the closed forms put them."""

import math

import numpy as np
import pytest

from gcodesim.nc.interpret import interpret
from gcodesim.nc.program import Kind

CASES = {
    "rotation": ("G68 X10 Y0 R90\nG0 X15 Y2 Z3", (8, 5, 3)),
    "rotation about the current point": ("G0 X4 Y4\nG68 R180\nG0 X5 Y4", (3, 4, 0)),
    "rotation in ZX": ("G18 G68 X0 Z0 R90\nG0 X1 Z5", (5, 0, -1)),
    "rotation off": ("G68 X1 Y1 R30\nG69\nG0 X5 Y6", (5, 6, 0)),
    "rotation under a work offset": ("G55\nG68 X0 Y0 R-90\nG0 X2 Y3 Z0", (103, 48, 10)),
    "rotation under G52": ("G52 X10\nG68 X0 Y0 R90\nG0 X1 Y0", (10, 1, 0)),
    "mirror": ("G51.1 X5\nG0 X7 Y1", (3, 1, 0)),
    "mirror of two axes": ("G51.1 X0 Y0\nG0 X7 Y1", (-7, -1, 0)),
    "mirror off for one axis": ("G51.1 X0 Y0\nG50.1 X0\nG0 X7 Y1", (7, -1, 0)),
    "mirror off": ("G51.1 X0\nG50.1\nG0 X7", (7, 0, 0)),
    "mirror off in a header": ("G51.1 X0\nG50.1 G0 X7", (7, 0, 0)),
    "mirror, then rotation": ("G51.1 X0\nG68 X0 Y0 R90\nG0 X2 Y1", (-1, -2, 0)),
    "polar": ("G16\nG0 X10 Y30", (10 * math.sqrt(0.75), 5, 0)),
    "polar, angle alone": ("G16 G0 X10 Y0\nY90", (0, 10, 0)),
    "polar, incremental angle": ("G16 G0 X10 Y30\nG91 Y60", (0, 10, 0)),
    "polar, incremental radius": ("G0 X1 Y0\nG16 G91 X10 Y90", (1, 10, 0)),
    "polar off": ("G16\nG15\nG0 X10 Y30", (10, 30, 0)),
    "L2": ("G10 L2 P1 X5 Y6\nG0 X1 Y1", (6, 7, 0)),
    "L2 in G91 adds": ("G55\nG91 G10 L2 P0 X5\nG90 G0 X0 Y0 Z0", (105, 50, 10)),
    "L2 of an offset the setup lacks": ("G10 L2 P9 Z3\nG59.3 G0 Z1", (0, 0, 4)),
    "L20 above P9 is additional": ("G10 L20 P11 X5\nG54.1 P11\nG0 X1", (6, 0, 0)),
    "L20 is additional": ("G0 X10\nG10 L20 P1 X3\nG54.1 P1 G0 X4", (7, 0, 0)),
    "L2 P0 is added to every offset": ("G10 L2 P0 X5\nG0 X1\nG10 L2 P1 Y2\nG0 Y0", (6, 2, 0)),
    "G54 P of Fanuc": ("G10 L20 P1 X3\nG54 P1\nG0 X4", (7, 0, 0)),
    "G92.1 of Fanuc": ("G0 X5\nG92 X0\nG92.1 X0\nG0 X1", (1, 0, 0)),
    "L10 of Fanuc is a length": ("G10 L10 P1 R30\nG10 L11 P1 R.5\nG43 H1 G0 Z0", (0, 0, 30.5)),
    "G31 goes to the end": ("G31 X5 F100", (5, 0, 0)),
}


def reached(text, control):
    meaning = interpret(f"G90 G17\n{text}\nM30", control)
    assert not meaning.stopped, meaning.findings
    return meaning.program.to[meaning.program.kind <= Kind.ARC][-1, :3]


@pytest.mark.parametrize("name", CASES)
def test_points_land_where_the_closed_form_says(name, control):
    text, wanted = CASES[name]
    np.testing.assert_allclose(reached(text, control()), wanted, atol=1e-12)


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("T1 M6 G43\nG0 Z7\nG10 L10 P1 Z0\nG43\nG0 Z0", (0, 0, 57)),
        ("G0 Z80\nG10 L11 P1 Z0\nT1 M6 G43\nG0 Z0", (0, 0, 80)),
        ("G10 L1 P2 Z7\nG43 H2 G0 X0 Y0 Z1", (1, 2, 8)),
        ("G0 X3\nG28.1\nG0 X9\nG28 X5", (3, 0, 0)),
        ("G38.2 X5 F100\nG0 Y2", (5, 2, 0)),
    ],
)
def test_tables_of_linuxcnc(text, wanted, control):
    np.testing.assert_allclose(reached(text, control("linuxcnc")), wanted, atol=1e-12)


def test_mirrored_and_turned_arcs_turn_as_they_are_seen(control):
    text = "G51.1 X0\nG68 X0 Y0 R90\nG0 X10 Y0\nG3 X0 Y10 I-10 F100 S1 M3\nM30"
    program = interpret(text, control()).program
    arc = program.arcs[0]
    np.testing.assert_allclose(program.to[program.kind == Kind.ARC][0, :3], (-10, 0, 0), atol=1e-12)
    np.testing.assert_allclose(arc["center"], (0, 0, 0), atol=1e-12)
    # (0, -10) to (-10, 0) by the short way is clockwise: the mirror turned G3 over.
    assert (arc["turns"], arc["normal"].tolist()) == (-1, [0, 0, 1])


def test_surface_speed_is_no_number_of_revolutions(control):
    refused = interpret("G96 S200 M3\nG95 G1 X1 F.1\nM30", control())
    assert refused.findings[-1].meaning == "feed_per_rev_no_spindle"
    for text in ("G96 S200 D900 M3\nG95 G1 X1 F.1", "G96 S200 M3\nG97 S900\nG95 G1 X1 F.1"):
        program = interpret(text + "\nM30", control()).program
        assert program.speed[program.kind == Kind.FEED].tolist() == [900.0]
