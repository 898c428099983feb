"""Touches that count in some pieces of a path only: the search and every sample agree on them."""

from __future__ import annotations

import numpy as np
import pytest
from collision.random_programs import Setup, Trial, cut_up, random_trial
from numpy.typing import NDArray

from gcodesim.collision.bodies.scene import build_scene, is_present
from gcodesim.collision.bounds.motion_bounds import travelled
from gcodesim.collision.forbidden import Touches, TouchOrder, forbidden_touches
from gcodesim.collision.geometry.poses import path_arrays
from gcodesim.collision.instants.work import WorkCounts
from gcodesim.collision.search.events import SpanContext
from gcodesim.machine.spindle import bodies_in_place
from gcodesim.motion.samples import Instants, SomePieces, Span, tool_spans
from gcodesim.study.scenes import joint, path

SEEDS = (1, 2, 7, 8, 13, 14, 18, 19, 25, 31, 43, 44)


def touches(trial: Trial, span: Span, wanted: NDArray[np.bool_], *, searches: bool) -> Touches:
    machine, bodies = trial.machine, bodies_in_place(trial.machine, span.tool)
    pairs = tuple(pair for pair in machine.pairs if is_present(pair, bodies))
    scene = build_scene(pairs, bodies, machine.joints, "cpu")
    travels = travelled(machine.joints, trial.path)
    context = SpanContext(machine, trial.path, scene, span, trial.period_ps, travels)
    order = TouchOrder(searches=searches, between=False, stop_all=False, threads=1)
    arrays = path_arrays(trial.path, "cpu")
    return forbidden_touches(context, arrays, wanted, order, WorkCounts())


def first(found: Touches) -> tuple[object, ...] | None:
    if not found.contacts:
        return None
    contact = found.contacts[0]
    return contact.sample, contact.time_ps, contact.pair.name, contact.parts, contact.triangles


@pytest.mark.parametrize("seed", SEEDS)
def test_search_and_samples_agree_on_the_first_touch_in_some_pieces(seed: int) -> None:
    trial = random_trial(seed)
    rng = np.random.default_rng(seed)
    for part in (0.2, 0.5, 0.9):
        wanted = rng.random(len(trial.path)) < part
        for span in tool_spans(trial.path):
            truth = first(touches(trial, span, wanted, searches=False))
            assert first(touches(trial, span, wanted, searches=True)) == truth
            with cut_up(Setup(level=3, chunk=8, batch=8)):
                assert first(touches(trial, span, wanted, searches=True)) == truth


def test_a_touch_in_other_pieces_does_not_count() -> None:
    trials = [random_trial(seed) for seed in SEEDS]
    found = 0
    for trial in trials:
        (span, *_) = tool_spans(trial.path)
        everywhere = np.ones(len(trial.path), np.bool_)
        hit = first(touches(trial, span, everywhere, searches=True))
        if hit is None or hit[-1] is None:
            continue
        piece = int(trial.path.piece_at(np.array([hit[1]]))[0])
        if not piece:
            continue
        found += 1
        before = np.arange(len(trial.path)) < piece
        assert first(touches(trial, span, before, searches=True)) is None
    assert found >= 3


def test_stretches_keep_both_ends_of_their_pieces() -> None:
    joints = [joint("X", [1, 0, 0], "bed", "X")]
    way = path(joints, [0.0], [(1.0, [1.0]), (1.0, [2.0]), (1.0, [3.0]), (1.0, [4.0])])
    stretches = SomePieces(way, np.array([False, True, True, False]))
    assert stretches.runs(0, 4) == [(1, 3)]
    assert stretches.runs(2, 4) == [(2, 3)]
    seconds = np.array([0, 1, 2, 3, 4]) * 10**12
    times = np.sort(np.concatenate([seconds, seconds[:-1] + 5 * 10**11]))
    instants = Instants(times, way.piece_at(times), times)
    assert (stretches.kept(instants).time_ps / 10**12).tolist() == [1.0, 1.5, 2.0, 2.5, 3.0]
    assert stretches.end_ps(10**12) == 3 * 10**12
