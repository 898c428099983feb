"""Corner words put the arc, or the chamfer, that plane geometry gives between two blocks."""

import math

import numpy as np
import pytest

from gcodesim.nc.interpret import interpret
from gcodesim.nc.program import Kind, path_lengths

HEAD = "G90 G21 G17 S1 M3 F100\n"


def rows_of(text, control):
    meaning = interpret(f"{HEAD}{text}\nM30", control)
    assert not meaning.stopped, meaning.findings
    program = meaning.program
    chosen = program.kind <= Kind.ARC
    kinds = [Kind(kind).name for kind in program.kind[chosen]]
    return kinds, program.to[chosen][:, :3], program


@pytest.mark.parametrize(("turn", "side"), [(1, 1.0), (-1, -1.0)])
def test_a_right_angle_is_rounded(turn, side, control):
    kinds, to, program = rows_of(f"G1 X10 ,R2 F50\nY{10 * side} F80", control())
    assert kinds == ["FEED", "ARC", "FEED"]
    np.testing.assert_allclose(to, [(8, 0, 0), (10, 2 * side, 0), (10, 10 * side, 0)], atol=1e-12)
    (arc,) = program.arcs
    np.testing.assert_allclose(arc["center"], (8, 2 * side, 0), atol=1e-12)
    assert arc["turns"] == turn
    assert program.f[program.kind <= Kind.ARC].tolist() == [50.0, 50.0, 80.0]
    assert program.line[program.kind <= Kind.ARC].tolist() == [2, 2, 3]
    assert path_lengths(program).sum() == pytest.approx(16 + math.pi)


def test_every_angle_leaves_the_first_block_and_meets_the_second_at_a_tangent(control):
    for degrees in (-170, -100, -20, 20, 60, 130, 175):
        way = np.array([math.cos(math.radians(degrees)), math.sin(math.radians(degrees)), 0.0])
        end = np.array([50.0, 0.0, 0.0]) + 50 * way
        text = f"G1 X50 ,R1.5\nX{end[0]:.9f} Y{end[1]:.9f}"
        _, (first, last, _), program = rows_of(text, control())
        centre = program.arcs[0]["center"]
        arms = first - centre, last - centre
        assert [np.linalg.norm(arm) for arm in arms] == pytest.approx([1.5, 1.5])
        assert arms[0] @ (1, 0, 0) == pytest.approx(0.0, abs=1e-9)
        assert arms[1] @ way == pytest.approx(0.0, abs=1e-7)
        # The rounding turns as far as the path does.
        arc_length = path_lengths(program)[program.kind == Kind.ARC]
        assert arc_length == pytest.approx(1.5 * math.radians(abs(degrees)))


def test_corners_follow_each_other_and_the_frames(control):
    kinds, to, _ = rows_of("G1 X10 ,R2\nY4 ,C2\nX0 ,R1\nY5", control())
    # Nothing is left of the second block, nor of the last.
    assert kinds == ["FEED", "ARC", "FEED", "FEED", "ARC"]
    points = [(8, 0), (10, 2), (8, 4), (1, 4), (0, 5)]
    np.testing.assert_allclose(to[:, :2], points, atol=1e-12)
    kinds, to, program = rows_of("G51.1 X0\nG20 G18 G1 Z1 ,R.1 F9\nX1", control())
    points = [(0, 0, 22.86), (-2.54, 0, 25.4), (-25.4, 0, 25.4)]
    np.testing.assert_allclose(to, points, atol=1e-12)
    # Z to X turns counter-clockwise about Y; the mirror turns it over.
    assert (program.arcs[0]["turns"], program.arcs[0]["normal"].tolist()) == (-1, [0, 1, 0])


def test_blocks_in_one_line_have_no_corner(control):
    kinds, to, _ = rows_of("G1 X10 ,R2\n(a comment)\n\nX20", control())
    assert (kinds, to[:, 0].tolist()) == (["FEED", "FEED"], [10.0, 20.0])
