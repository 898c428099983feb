"""Samples: integer time, every block end, and windows that neither lose nor repeat an instant."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from collision.scenes import random_joints, random_path
from motion.programs import planned
from numpy.typing import NDArray

from gcodesim.constants import DEFAULT_PERIOD_PS
from gcodesim.motion.path import Path, ToolChange
from gcodesim.motion.samples import (
    sample_count,
    sample_of,
    tool_spans,
    tool_times,
    window,
    windows,
)
from gcodesim.nc.program import Kind
from gcodesim.study.scenes import joint, path

PERIOD_PS = 1_000_000_000


def expected_instants(p: Path, period_ps: int) -> NDArray[np.int64]:
    """All samples and block ends, less those inside a piece that stands still."""
    still = (p.q0 == p.q1).all(axis=1) & (p.arc < 0)
    kept = {int(t) for t in p.bounds_ps}
    for i in range(len(p)):
        start, end = int(p.bounds_ps[i]), int(p.bounds_ps[i + 1])
        if not still[i]:
            kept |= set(range(sample_of(start, period_ps) * period_ps, end + 1, period_ps))
    return np.array(sorted(kept), np.int64)


def all_instants(p: Path, count: int, period_ps: int) -> list[tuple[int, int, int, int]]:
    """(span, time, piece, sample) of every instant, window by window."""
    return [
        (number, *map(int, row))
        for number, span in enumerate(tool_spans(p))
        for first in windows(p, span, count, period_ps)
        for found in [window(p, span, first, count, period_ps)]
        for row in zip(found.time_ps, found.piece, found.sample, strict=True)
    ]


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("count", [1, 2, 3, 7, 64, 10**6])
def test_windows_hold_every_instant_once(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    # Pieces from a tenth of a sample to thirty samples, a quarter of them dwells.
    p = random_path(rng, random_joints(rng), 60, seconds=10.0 ** rng.uniform(-3.5, -1.5))
    found = all_instants(p, count, PERIOD_PS)
    times = np.array([time for _, time, _, _ in found])
    np.testing.assert_array_equal(times, expected_instants(p, PERIOD_PS))
    np.testing.assert_array_equal([piece for *_, piece, _ in found], p.piece_at(times))
    assert [sample for *_, sample in found] == [sample_of(int(t), PERIOD_PS) for t in times]
    assert found[-1][-1] == sample_count(p, PERIOD_PS) - 1


@pytest.mark.parametrize("count", [1, 5, 1000])
def test_each_tool_has_its_instants_from_change_to_change(
    count: int, rng: np.random.Generator
) -> None:
    p = random_path(rng, random_joints(rng), 40, seconds=0.004)
    changes = tuple(ToolChange(piece, piece, 0) for piece in (0, 0, 7, 8, 8, 40))
    p = replace(p, tool_changes=changes)
    found = all_instants(p, count, PERIOD_PS)
    every = expected_instants(p, PERIOD_PS)
    for number, span in enumerate(tool_spans(p)):
        inside = every[(every >= span.start_ps) & (every <= span.end_ps)]
        assert [time for k, time, _, _ in found if k == number] == inside.tolist()


def test_samples_after_1e8_periods_are_exact() -> None:
    p = path([joint("X", [1, 0, 0])], [0.0], [(2e4, [12345.678])])
    span = tool_spans(p)[0]
    found = window(p, span, 10**8, 5, DEFAULT_PERIOD_PS)
    assert found.sample.tolist() == [10**8 + k for k in range(5)]
    assert found.time_ps.tolist() == [(10**8 + k) * DEFAULT_PERIOD_PS for k in range(5)]
    for time, (x,) in zip(found.time_ps.tolist(), p.positions(found.time_ps), strict=True):
        exact = Fraction(time, 2 * 10**16) * Fraction(12345.678)
        assert abs(Fraction(float(x)) - exact) <= Fraction(float(np.spacing(x)))


def test_many_block_ends_share_a_sample() -> None:
    rows = [{"kind": Kind.FEED, "to": (1e-4 * k,), "f": 20_000} for k in range(1, 3001)]
    p = planned(*rows)  # 0.3 us a block: 333 to a sample
    found = window(p, tool_spans(p)[0], 0, 100, DEFAULT_PERIOD_PS)
    assert set(p.bounds_ps.tolist()) <= set(found.time_ps.tolist())
    assert sample_count(p, DEFAULT_PERIOD_PS) == 10
    assert found.sample.max() == 9
    np.testing.assert_array_equal(found.sample, np.ceil(found.time_ps / DEFAULT_PERIOD_PS))


def test_a_long_dwell_costs_no_windows() -> None:
    move = {"kind": Kind.FEED, "to": (1,), "f": 60_000}
    p = planned(move, {"kind": Kind.DWELL, "f": 1e6}, {**move, "to": (2,)})
    span = tool_spans(p)[0]
    firsts = list(windows(p, span, 64, DEFAULT_PERIOD_PS))
    assert len(firsts) < 6
    assert firsts[-1] + 64 > sample_of(p.duration_ps, DEFAULT_PERIOD_PS)


def test_a_dwell_at_the_start_is_looked_at_when_it_begins_and_ends() -> None:
    p = planned({"kind": Kind.DWELL, "f": 0.01}, {"kind": Kind.FEED, "to": (1e-3,), "f": 60_000})
    found = window(p, tool_spans(p)[0], 0, 1000, DEFAULT_PERIOD_PS)
    assert found.sample.tolist() == [0, 100, 101]


@pytest.mark.parametrize(
    ("time_ps", "sample"), [(0, 0), (1, 1), (10**8, 1), (10**8 + 1, 2), (9 * 10**18, 9 * 10**10)]
)
def test_sample_of_a_time_is_the_ceiling(time_ps: int, sample: int) -> None:
    assert sample_of(time_ps, DEFAULT_PERIOD_PS) == sample


def test_program_time_is_shared_out_to_the_tools() -> None:
    move = {"kind": Kind.FEED, "f": 6_000}
    p = planned(
        {**move, "to": (1,)},
        {"kind": Kind.TOOL, "aux": 7},
        {**move, "to": (3,)},
        {"kind": Kind.TOOL, "aux": 2},
        {"kind": Kind.TOOL, "aux": 7},
        {**move, "to": (7,)},
    )
    assert p.duration_s == 0.07
    assert tool_times(p) == ((None, 0.01), (7, 0.06))
