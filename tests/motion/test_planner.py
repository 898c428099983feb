"""Planning: program times in closed form, to the picosecond."""

from __future__ import annotations

from fractions import Fraction
from math import fsum, pi, sqrt

import numpy as np
import pytest
from motion.programs import PLANES, axes_machine, planned, program, straight_program

from gcodesim.constants import LONGEST_S, PS_PER_S
from gcodesim.motion.path import ToolChange
from gcodesim.motion.planner import plan
from gcodesim.motion.samples import tool_spans
from gcodesim.nc.program import CanonicalProgram, FeedMode, Kind

RAPID, FEED, ARC, DWELL, TOOL = Kind.RAPID, Kind.FEED, Kind.ARC, Kind.DWELL, Kind.TOOL


def codes(p: CanonicalProgram) -> list[str]:
    return [finding.code for finding in plan(p, axes_machine())[1]]


def test_a_million_tenth_micrometre_blocks_take_what_they_should() -> None:
    x = np.zeros((1_000_000, 6))
    x[:, 0] = np.arange(1, 1_000_001) * 1e-4
    path, findings = plan(straight_program(x, 20_000), axes_machine())
    assert abs(path.duration_s - 0.3) < 1e-6
    assert len(path) == 1_000_000
    assert path.bounds_ps[0] == 0
    assert (np.diff(path.bounds_ps) > 0).all()
    assert not findings


def test_a_million_mixed_blocks_equal_the_exact_sum(rng: np.random.Generator) -> None:
    to = np.zeros((1_000_000, 6))
    to[:, :3] = rng.uniform(-1, 1, (1_000_000, 3))
    feed = 10.0 ** rng.uniform(1, 4, 1_000_000)
    path, _ = plan(straight_program(to, feed), axes_machine())
    step = np.diff(to, axis=0, prepend=np.zeros((1, 6)))
    exact = fsum(60.0 * np.sqrt((step**2).sum(axis=1)) / feed)
    assert abs(path.duration_s - exact) < 1e-6


@pytest.mark.parametrize(
    ("row", "seconds"),
    [
        ({"kind": FEED, "to": (3, 4), "f": 600}, 0.5),
        ({"kind": FEED, "to": (3, 4, 0, 90), "f": 300}, 1.0),  # XYZ way counts alone
        ({"kind": FEED, "to": (0, 0, 0, 30, 0, 40), "f": 3000}, 1.0),  # deg/min without XYZ
        ({"kind": FEED, "to": (3, 4), "f": 20, "mode": FeedMode.INVERSE_TIME}, 3.0),
        ({"kind": ARC, "to": (0, 20), "center": (0, 10, 0), "f": 4, "mode": 93}, 15.0),
        ({"kind": FEED, "to": (10,), "f": 0.5, "mode": 95, "speed": 1200}, 1.0),
        ({"kind": DWELL, "f": 1.25}, 1.25),
        ({"kind": DWELL, "f": 1e-12}, 1e-12),
        ({"kind": RAPID, "to": (100, -250, 3)}, 0.5),  # Y is the slowest
        ({"kind": RAPID, "to": (100, 0, 0, 0, 0, 70)}, 0.7),  # C is
        ({"kind": ARC, "to": (0, 20), "center": (0, 10, 0), "f": 600 * pi}, 1.0),
        ({"kind": ARC, "to": (0, 0), "center": (0, 10, 0), "f": 600 * pi}, 2.0),
        ({"kind": ARC, "to": (0, 0), "center": (0, 10, 0), "f": 600 * pi, "turns": -3}, 6.0),
        (
            {"kind": ARC, "to": (0, 20, 10 * pi), "center": (0, 10, 0), "f": 600 * pi},
            sqrt(2.0),
        ),
    ],
)
def test_a_move_takes_its_closed_form(row: dict[str, object], seconds: float) -> None:
    path = planned(row)
    assert len(path) == 1
    assert abs(path.duration_ps - seconds * 1e12) <= 1


@pytest.mark.parametrize("normal", PLANES.values(), ids=PLANES)
@pytest.mark.parametrize(("turns", "sweep"), [(1, 90), (2, 450), (-1, -270), (-3, -990)])
def test_a_helix_climbs_with_the_arc_in_every_plane(
    normal: tuple[int, int, int], turns: int, sweep: float
) -> None:
    n = np.array(normal)
    u = np.roll(n, 1)
    end = 5.0 * (u - np.cross(n, u)) + 4.0 * n  # seen from the centre: from -u to -v
    arc = {"kind": ARC, "to": end, "center": 5.0 * u, "normal": n, "turns": turns, "f": 600}
    path = planned(arc)
    assert path.arcs["sweep"][0] == pytest.approx(sweep, abs=1e-12)
    length = sqrt((np.radians(sweep) * 5) ** 2 + 16)
    assert path.duration_s == pytest.approx(length / 10, abs=2e-12)
    half = path.positions(np.array([path.duration_ps // 2]))[0, :3]
    angle = np.radians(sweep) / 2
    expected = 5 * u - 5 * (np.cos(angle) * u + np.sin(angle) * np.cross(n, u)) + 2 * n
    np.testing.assert_allclose(half, expected, atol=1e-9)


def test_moves_without_way_take_no_time_and_dwells_stand_still() -> None:
    path = planned(
        {"kind": FEED, "to": (5,), "f": 300},
        {"kind": FEED, "to": (5,), "f": 300},
        {"kind": DWELL, "f": 0.0},
        {"kind": DWELL, "f": 2.0},
        {"kind": RAPID, "to": (5,)},
        {"kind": FEED, "to": (5, 5), "f": 300},
    )
    assert path.line.tolist() == [1, 4, 6]
    assert path.duration_s == 4.0
    assert path.q0[1].tolist() == path.q1[1].tolist() == [5, 0, 0, 0, 0]


def test_a_feed_no_axis_can_keep_is_stretched_and_reported() -> None:
    rows = [
        {"kind": FEED, "to": (500, 0, 0), "f": 30_000},  # exactly the rapid rate
        {"kind": FEED, "to": (501, 0, 0, 0, 0, 200), "f": 60},  # C needs 2 s for 1 mm
        {"kind": FEED, "to": (501, 100, 0, 0, 0, 200), "f": 60_000},  # 0.2 s instead of 0.1
        {"kind": RAPID, "to": (501, 600, 0, 0, 0, 200)},
    ]
    path, findings = plan(program(rows), axes_machine())
    np.testing.assert_array_equal(np.diff(path.bounds_ps), [10**12, 2 * 10**12, 2e11, 10**12])
    assert [(f.code, f.line, f.severity) for f in findings] == [("GC303", 2, "note")]
    assert "2 block" in findings[0].message
    assert codes(program(rows[:1])) == []


def test_an_arc_that_is_stretched_is_reported_too() -> None:
    row = {"kind": ARC, "to": (0, 20, 600), "center": (0, 10, 0), "f": 600_000}
    path, findings = plan(program([row]), axes_machine())
    assert path.duration_s == 1.2  # Z at its rapid rate
    assert [f.code for f in findings] == ["GC303"]


def test_tool_changes_stand_between_the_pieces() -> None:
    path = planned(
        {"kind": TOOL, "aux": 3},
        {"kind": RAPID, "to": (50,)},
        {"kind": TOOL, "aux": 4},
        {"kind": FEED, "to": (50,), "f": 60},  # no way, no piece
        {"kind": TOOL, "aux": 5},
        {"kind": RAPID, "to": (0,)},
        {"kind": TOOL, "aux": 6},
    )
    assert path.tool_changes == (
        ToolChange(0, 3, 1), ToolChange(1, 4, 3), ToolChange(1, 5, 5), ToolChange(2, 6, 7),
    )  # fmt: skip
    spans = [(s.start_ps, s.end_ps, s.tool, s.line) for s in tool_spans(path)]
    tick = 10**11
    assert spans == [
        (0, 0, None, 0), (0, tick, 3, 1), (tick, tick, 4, 3), (tick, 2 * tick, 5, 5),
        (2 * tick, 2 * tick, 6, 7),
    ]  # fmt: skip


def test_time_beyond_the_clock_ends_the_program() -> None:
    rows = [
        {"kind": RAPID, "to": (50,)},
        {"kind": DWELL, "f": 8e6},
        {"kind": FEED, "to": (51,), "f": 1e-6, "mode": FeedMode.INVERSE_TIME},  # 6e7 s
        {"kind": TOOL, "aux": 7},
        {"kind": RAPID, "to": (0,)},
    ]
    path, findings = plan(program(rows), axes_machine())
    assert [(f.code, f.line) for f in findings] == [("GC424", 3)]
    assert path.duration_ps == 8 * 10**18 + 10**11 < LONGEST_S * PS_PER_S
    assert len(path) == 2
    assert path.tool_changes == ()


def test_a_feed_that_would_take_for_ever_ends_the_program_quietly() -> None:
    row = {"kind": FEED, "to": (1e5,), "f": 1e-300}
    path, findings = plan(program([row, {"kind": FEED, "to": (0,), "f": 1e-308}]), axes_machine())
    assert [f.code for f in findings] == ["GC424"]
    assert len(path) == 0


def test_block_times_are_rounded_once_and_never_added_in_floating_point() -> None:
    to = np.zeros((300_000, 6))
    to[:, 0] = np.arange(1, 300_001) % 2
    feed = np.tile([7.0, 11.0, 13.0], 100_000)
    path, _ = plan(straight_program(to, feed), axes_machine())
    ticks = [round(Fraction(60 * 10**12, k)) for k in (7, 11, 13)]
    found = np.diff(path.bounds_ps).reshape(-1, 3)
    assert np.abs(found - ticks).max() <= 1
    assert path.duration_ps == sum(found[0].tolist()) * 100_000


def test_a_program_without_motion_has_no_pieces() -> None:
    path = planned({"kind": TOOL, "aux": 1}, {"kind": Kind.STOP, "aux": 30})
    assert len(path) == 0
    assert path.duration_ps == 0
