"""The search at samples: the answer of the exhaustive method, however it is cut up."""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from math import ceil
from unittest.mock import patch

import numpy as np
import pytest
from collision.random_programs import (
    Answer,
    Setup,
    Trial,
    answer,
    marginal_trial,
    random_trial,
    run,
)

from gcodesim.checking.evidence import detection_findings
from gcodesim.collision.search import search
from gcodesim.collision.search.search import Roots
from gcodesim.constants import DEFAULT_PERIOD_PS
from gcodesim.machine.model import Machine
from gcodesim.study.scenes import (
    SAMPLED,
    KnownScene,
    arc_grazes_face,
    blade_through_sheet,
    box,
    cube_on_slab,
    delayed,
    joint,
    machine,
    path,
)

PHASES = 20
FRACTION_MARGIN = 1e-5  # of a period: nearer to a sample, rounding would decide
SAMPLE_PS = 1_000_000_000

SETUPS = (
    Setup(level=0),
    Setup(level=3, chunk=8, batch=8),
    Setup(level=6, chunk=128, batch=64, threads=2),
    Setup(level=3, chunk=512, batch=16, threads=2),
)

SEEDS = (1, 2, 7, 8, 13, 14, 18, 19, 25, 31, 43, 44)
MARGINS = {0: 1e-6, 4: -1e-6, 20: 1e-3, 22: -1e-3, 30: 0.3, 35: 1e-2, 40: -1e-2, 47: 1e-4}
"""Seed -> depth of the grazing contact [mm], negative = clearance of the near miss."""


def trial(scene: KnownScene, period_ps: int = DEFAULT_PERIOD_PS) -> Trial:
    return Trial(0, scene.machine, scene.path, period_ps)


@cache
def trials() -> list[Trial]:
    """Twelve random programs, and eight that just touch or just do not."""
    return [random_trial(seed) for seed in SEEDS] + [
        marginal_trial(seed, margin) for seed, margin in MARGINS.items()
    ]


@cache
def truth() -> list[Answer | None]:
    return [answer(run(t, "exhaustive")) for t in trials()]


@cache
def proof(device: str) -> list[Answer | None]:
    return [answer(run(t, between=True, device=device)) for t in trials()]


# --- the exhaustive method ------------------------------------------------------------------------


@pytest.mark.parametrize("name", SAMPLED)
def test_scenes_in_every_phase(name: str, device: str) -> None:
    period_ps = DEFAULT_PERIOD_PS
    for j in range(PHASES):
        scene = delayed(SAMPLED[name](), j * period_ps // PHASES)
        assert scene.contact_s is not None
        exact = scene.contact_s * 1e12 / period_ps
        assert abs(exact - round(exact)) > FRACTION_MARGIN
        found = answer(run(trial(scene), device=device))
        assert found == answer(run(trial(scene), "exhaustive", device=device))
        assert found is not None
        assert found[0] == ceil(exact)
        # What is near before a touch is on its way into it.
        assert answer(run(trial(scene), between=True, device=device)) == found


def test_thin_blade_and_near_miss_at_samples_only(device: str) -> None:
    period_ps, hits = DEFAULT_PERIOD_PS, 0
    for j in range(PHASES):
        scene = delayed(blade_through_sheet(), j * period_ps // PHASES)
        assert scene.contact_s is not None
        first = ceil(scene.contact_s * 1e12 / period_ps)
        seen = first * period_ps / 1e12 <= scene.leaves_s
        found = answer(run(trial(scene), device=device))
        assert (found[0] if found else None) == (first if seen else None)
        assert found == answer(run(trial(scene), "exhaustive", device=device))
        hits += seen
        missed = delayed(arc_grazes_face(-1e-6), j * period_ps // PHASES)
        assert answer(run(trial(missed), device=device)) is None
    assert hits == 4


def test_touching_is_contact_and_a_micrometre_is_not(device: str) -> None:
    touching, lifted = trial(cube_on_slab(0.0)), trial(cube_on_slab(2.0**-20))
    for t in (touching, lifted):
        assert answer(run(t, device=device)) == answer(run(t, "exhaustive", device=device))
    found = answer(run(touching, device=device))
    assert found is not None
    assert (found[0], found[4]) == (0, 0)
    assert answer(run(lifted, device=device)) is None


def test_random_programs_are_a_fair_sample() -> None:
    found = truth()
    assert 8 <= sum(a is not None for a in found) <= 14
    assert sum(a is not None and a[0] > 20 for a in found) >= 6
    pieces = [len(t.path) for t in trials()]
    lengths = np.concatenate([np.diff(t.path.bounds_ps) / t.period_ps for t in trials()])
    assert max(pieces) > 64 * 4
    assert (lengths < 0.1).sum() > 100
    assert (lengths > 1000).sum() > 10
    assert sum((t.path.arc >= 0).sum() for t in trials()) > 30


def test_random_programs_as_the_exhaustive_method(device: str) -> None:
    assert [answer(run(t, device=device)) for t in trials()] == truth()


@pytest.mark.parametrize("setup", SETUPS, ids=str)
def test_how_it_is_cut_up_changes_nothing(setup: Setup, device: str) -> None:
    assert [answer(run(t, setup=setup, device=device)) for t in trials()] == truth()


@pytest.mark.parametrize("setup", SETUPS, ids=str)
def test_nor_does_it_between_samples(setup: Setup, device: str) -> None:
    found = [answer(run(t, between=True, setup=setup, device=device)) for t in trials()]
    assert found == proof(device)
    for whole, at_samples in zip(found, truth(), strict=True):
        if whole != at_samples:
            # Only a contact between samples comes before what the samples show.
            assert whole is not None
            assert whole[5]
            assert at_samples is None or whole[:2] < at_samples[:2]


def test_two_runs_are_equal() -> None:
    once, again = ([run(t, between=True) for t in trials()[:6]] for _ in range(2))
    assert [answer(d) for d in once] == [answer(d) for d in again]
    assert [d.work.as_report for d in once] == [d.work.as_report for d in again]


# --- ends and ties --------------------------------------------------------------------------------


def slider(*names: str) -> Machine:
    """A 2 mm cube at X0 between walls whose faces stand at X-4 and X4, named as asked."""
    joints = [joint("X", [1, 0, 0]), joint("Y", [0, 1, 0], "bed", names[0])]
    joints.append(joint("Z", [0, 0, 1], "bed", names[1]))
    shapes = {"mover": box([2, 2, 2])}
    shapes |= {name: box([2, 2, 2], [x, 0, 0]) for name, x in zip(names, (-5, 5), strict=True)}
    return machine(joints, shapes, sorted(("mover", name) for name in names))


def slide(
    *pieces: tuple[float, float], start: float = 0.0, walls: tuple[str, str] = ("p", "q")
) -> Trial:
    """A path of (samples, end of X) pieces."""
    m = slider(*walls)
    ends = [(count * 1e-3, [x, 0.0, 0.0]) for count, x in pieces]
    return Trial(0, m, path(m.joints, [start, 0, 0], ends), SAMPLE_PS)


@pytest.mark.parametrize("between", [False, True])
@pytest.mark.parametrize(
    ("made", "sample", "pair"),
    [
        (slide((1, 3.0)), 1, "mover-q"),
        (slide((0.2, 3.0)), 1, "mover-q"),
        (slide((1, 2.99)), None, ""),
        (slide((1e-6, 3.0)), 1, "mover-q"),
        (slide((1, 0.0), start=3.0), 0, "mover-q"),
        (slide((5, 2.9), (1, 3.0)), 6, "mover-q"),
        (slide((5, 2.9), (0.7, 3.0)), 6, "mover-q"),
        (slide((5000, 3.0)), 5000, "mover-q"),
        (slide((6.2, 1.0), (0.2, 3.5), (0.2, 1.0), (50, 1.0)), 7, "mover-q"),
        (slide((6.2, 1.0), (0.2, 3.5), (50, 3.5)), 7, "mover-q"),
        (slide((6.2, 1.0), (0.2, 3.5), (0.2, -3.5), (9, 0.0)), 7, "mover-p"),
        (slide((6.2, 1.0), (0.2, 3.5), (0.2, -3.5), (9, 0.0), walls=("q", "p")), 7, "mover-p"),
    ],
)
def test_first_and_last_instants_block_ends_and_ties(
    made: Trial, sample: int | None, pair: str, between: bool, device: str
) -> None:
    found = answer(run(made, between=between, device=device))
    assert (found[:2] if found else None) == (None if sample is None else (sample, pair))
    assert found == answer(run(made, "exhaustive", device=device))


# --- a stack that fills ---------------------------------------------------------------------------


def test_a_full_stack_is_split_and_run_again(device: str) -> None:
    with patch.object(search, "STACK_LIMIT", 16):
        again = [run(t, device=device) for t in trials()]
    assert [answer(d) for d in again] == truth()
    assert not any(f.overflows for d in again for f in d.findings)


def test_what_no_split_can_settle_is_never_an_answer(device: str) -> None:
    with patch.object(search, "STACK_LIMIT", 6):
        found = [run(t, between=True, device=device) for t in trials()]
    undecided = 0
    for t, detection, at_samples in zip(trials(), found, truth(), strict=True):
        codes = [f.code for f in detection_findings(detection, t.machine, t.path)]
        assert ("GC901" in codes) == any(f.overflows for f in detection.findings)
        undecided += "GC901" in codes
        contact = answer(detection)
        if "GC901" not in codes and not (contact and contact[5]):
            assert contact == at_samples
    assert undecided > 3


def test_roots_are_halved_down_to_one_sample() -> None:
    bounds = np.array([0, 25, 30, 31, 90]) * SAMPLE_PS // 10
    todo = [Roots(*(np.array([v]) for v in (0, 2, 0, 0)))]
    stretches = []
    while todo:
        roots = todo.pop()
        halves = roots.halves(bounds, SAMPLE_PS)
        todo += halves
        if not halves:
            piece, level = int(roots.piece[0]), int(roots.level[0])
            whole = bounds[[piece, piece + 1]].tolist()
            stretches.append(
                whole if level == 0 else [*map(int, (roots.start_ps[0], roots.end_ps[0]))]
            )
    ends = sorted({*range(0, 10 * SAMPLE_PS, SAMPLE_PS), *bounds.tolist()})
    assert sorted(stretches) == [list(pair) for pair in pairwise(ends)]
