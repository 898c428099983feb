"""Overtravel: crossings in closed form, extremes of arcs against dense sampling."""

from __future__ import annotations

from dataclasses import replace
from math import asin, pi

import numpy as np
import pytest
from collision.scenes import displacement, random_arc, random_joints, random_path
from motion.programs import axes_machine, program

from gcodesim.constants import TRAVEL_SLACK
from gcodesim.findings.codes import Finding
from gcodesim.motion.overtravel import overtravels, position_ranges
from gcodesim.motion.planner import plan
from gcodesim.nc.program import Kind
from gcodesim.study.scenes import JERKED, joint, path

SLACK = TRAVEL_SLACK
FEED, ARC, RAPID = Kind.FEED, Kind.ARC, Kind.RAPID
INFINITE = (-np.inf, np.inf)


def found(
    *rows: dict[str, object], start: object = (0.0,) * 6, **travel: tuple[float, float]
) -> list[Finding]:
    m = axes_machine(**travel)
    return overtravels(plan(program(rows, start), m)[0], m.joints)


def test_a_line_crosses_its_limit_when_it_does() -> None:
    (finding,) = found({"kind": FEED, "to": (0, 0, 0, 90), "f": 900}, A=(-120, 30))
    assert (finding.code, finding.line, finding.severity) == ("GC302", 1, "error")
    assert finding.time_s == pytest.approx((30 + SLACK) / 15, abs=1e-11)
    assert "A reaches 90 deg, 60 deg beyond its travel of -120 to 30" in finding.message
    (finding,) = found({"kind": RAPID, "to": (-100, 50)}, X=(-60, 10))
    assert finding.code == "GC301"
    assert finding.time_s == pytest.approx((60 + SLACK) / 500, abs=1e-11)
    assert "X reaches -100 mm, 40 mm beyond" in finding.message


@pytest.mark.parametrize("turns", [1, -1, 3, -4])
def test_a_circle_crosses_its_limit_inside_the_arc(turns: int) -> None:
    circle = {"kind": ARC, "to": (0, 0), "center": (-10, 0, 0), "turns": turns, "f": 600}
    finding = found(circle, Y=(-8, 8))[0]
    assert finding.time_s == pytest.approx(asin((8 + SLACK) / 10), abs=1e-9)  # 10 mm/s, R = 10
    assert f"Y reaches {10 * np.sign(turns)} mm" in finding.message
    (finding,) = found(circle, X=(-15, 1))
    crossing = pi / 2 + asin((5 + SLACK) / 10)
    assert finding.time_s == pytest.approx(crossing, abs=1e-9)
    assert "X reaches -20 mm, 5 mm beyond" in finding.message


def test_a_circle_that_leaves_on_both_sides_is_reported_twice() -> None:
    circle = {"kind": ARC, "to": (0, 0), "center": (-10, 0, 0), "f": 600}
    both = found(circle, Y=(-8, 8))
    assert [f.message[:12] for f in both] == ["Y reaches 10", "Y reaches -1"]
    assert both[1].time_s == pytest.approx(pi + asin((8 + SLACK) / 10), abs=1e-9)


def test_an_excursion_is_reported_once_with_its_farthest_position() -> None:
    stops = [5, 11, 14, 12, 9, 8, 13, 0]
    rows = [{"kind": FEED, "to": (x,), "f": 600} for x in stops]
    findings = found(*rows, X=(-10, 10))
    first, second = (f for f in findings if not f.continues)
    assert (first.line, second.line) == (2, 7)
    assert [(f.line, f.depth) for f in findings] == [(2, 1), (3, 4), (4, 4), (5, 2), (7, 3), (8, 3)]
    assert "X reaches 14 mm" in first.message
    assert "(until line 5)" in first.message
    assert "X reaches 13 mm" in second.message
    assert first.time_s == pytest.approx((10 + SLACK) / 10, abs=1e-11)


def test_ending_on_a_limit_is_no_finding() -> None:
    on = {"kind": FEED, "to": (10, -10, 0, 30), "f": 600}
    travel = {"X": (-10.0, 10.0), "Y": (-10.0, 10.0), "A": (-120.0, 30.0)}
    assert not found(on, **travel)
    circle = {"kind": ARC, "to": (10, 0), "center": (0, 0, 0), "f": 600}
    assert not found({"kind": RAPID, "to": (10,)}, circle, X=(-10, 10), Y=(-10, 10))
    assert not found({**on, "to": (10 + SLACK / 2,)}, **travel)
    assert len(found({**on, "to": (10 + 2 * SLACK,)}, **travel)) == 1


def test_starting_beyond_a_limit_is_reported_at_once() -> None:
    start = (20.0, 0, 0, 0, 0, 0)
    (finding,) = found({"kind": FEED, "to": (5,), "f": 600}, start=start, X=(-10, 10))
    assert finding.time_s == 0.0


def test_an_axis_without_limits_is_never_beyond() -> None:
    assert not found({"kind": RAPID, "to": (1e6, 0, 0, 0, 0, 1e6)}, X=INFINITE, C=INFINITE)
    (finding,) = found({"kind": RAPID, "to": (-7, 0)}, X=(-5, np.inf))
    assert "2 mm beyond its travel of -5 to inf" in finding.message


def test_findings_come_in_the_order_of_time() -> None:
    rows = [{"kind": FEED, "to": (0, y, z), "f": 600} for y, z in ((0, 9), (9, 9), (9, 0))]
    findings = found(*rows, Y=(-5, 5), Z=(-5, 5))
    assert [f.message[0] for f in findings if not f.continues] == ["Z", "Y"]


def test_the_crossing_under_another_time_law() -> None:
    joints = [joint("X", [1, 0, 0], travel=(-100, 7.3))]
    p = path(joints, [0.0], [(0.1, [50.0])], JERKED)
    (finding,) = overtravels(p, tuple(joints))
    assert finding.time_s == pytest.approx(0.1 * ((7.3 + SLACK) / 50) ** (1 / 3), abs=1e-11)


def test_the_crossing_of_an_arc_under_another_time_law() -> None:
    m = axes_machine(Y=(-8, 100))
    row = {"kind": ARC, "to": (0, 0), "center": (-10, 0, 0), "turns": 2, "f": 600}
    p = replace(plan(program([row]), m)[0], law=np.array([JERKED]))
    (finding,) = overtravels(p, m.joints)
    share = (pi + asin((8 + SLACK) / 10)) / (4 * pi)
    assert finding.time_s == pytest.approx(p.duration_s * share ** (1 / 3), abs=1e-9)


@pytest.mark.parametrize("seed", range(40))
def test_extremes_of_arcs_equal_dense_sampling(seed: int) -> None:
    rng = np.random.default_rng(seed)
    joints = [joint("X", [1, 0, 0]), joint("Y", [0, 1, 0], "mover", "m2")]
    joints.append(joint("Z", [0, 0, 1], "m2", "m3"))
    arc = random_arc(rng, 100.0)
    if seed % 3 == 0:
        arc["r1"] = arc["r0"] * rng.uniform(0.9, 1.1)  # controls accept less than this
    if seed % 4 == 0:
        arc["lift"] *= rng.uniform(0, 10)
    p = path(joints, np.zeros(3), [(1.0, displacement(arc))], arcs={0: arc})
    s = np.linspace(0, 1, 200_001)[:-1]
    dense = p.positions_on(np.zeros(len(s), np.int64), s)
    for column in range(3):
        low, high = (float(x[0]) for x in position_ranges(p, column))
        assert low <= dense[:, column].min() + 1e-9
        assert high >= dense[:, column].max() - 1e-9
        # Never beyond what is reached, to the resolution of the sampling.
        step = np.abs(np.diff(dense[:, column])).max()
        assert low >= min(dense[:, column].min(), 0.0) - 2 * step
        assert high <= max(dense[:, column].max(), 0.0) + 2 * step


def test_ranges_of_lines_and_rotary_axes_are_their_ends(rng: np.random.Generator) -> None:
    joints = random_joints(rng)
    p = random_path(rng, joints, 30)
    for column, j in enumerate(joints):
        low, high = position_ranges(p, column)
        plain = np.flatnonzero((p.arc < 0) | j.rotary)
        np.testing.assert_array_equal(low[plain], np.minimum(p.q0, p.q1)[plain, column])
        np.testing.assert_array_equal(high[plain], np.maximum(p.q0, p.q1)[plain, column])
