"""The accuracy study: error against run time of every method on scenes with a known contact."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache, lru_cache
from math import ceil
from typing import Any

import numpy as np

from gcodesim.constants import DEFAULT_PERIOD_PS, PS_PER_S
from gcodesim.study.accuracy_goals import SPEED_SCENE, goals
from gcodesim.study.bench import environment
from gcodesim.study.methods import METHODS, PERIOD, Found, Method, Subject
from gcodesim.study.representation import chord_rows, cycle_rows, pose_rows
from gcodesim.study.scenes import SCENES, KnownScene, delayed

SCHEMA = "gcodesim.study.accuracy/1"
PS_PER_MS = PS_PER_S // 1000

FRACTION_MARGIN = 1e-5
"""Contacts nearer to a sample than this part of a period: rounding decides which sample has it."""


@dataclass(frozen=True)
class Extent:
    """How much to measure.

    Attributes:
        periods_ms: sample periods [ms].
        tolerances_mm: tolerances of the search between samples [mm].
        phases: random starts per setting; the median time is that of as many runs.
        sides: of the polygons that stand for round shapes.
        blocks: of the program whose cycle time is compared.
    """

    periods_ms: tuple[float, ...]
    tolerances_mm: tuple[float, ...]
    phases: int
    sides: tuple[int, ...]
    blocks: int


QUICK = Extent((10.0, 1.0, 0.1), (1e-1, 1e-3, 1e-6, 1e-9), 5, (8, 48), 2_000)
FULL = Extent(
    (10.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01),
    (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9),
    20,
    (8, 16, 32, 48, 64, 128, 256),
    100_000,
)

FINE_MS = 0.01
"""Period at which the scene of the speed goal is looked at in a quick study too [ms]."""

SEED = 6

ALARM_SLACK_MM = 2e-9
"""An alarm at this clearance [mm] is none: the slack of the proof, and of the pose."""

SUBJECTS = 512
"""Scenes laid out that are kept: all starts of one scene, which the methods share."""


def study_accuracy(
    extent: Extent, progress: Callable[[float], None], scenes: tuple[str, ...] = tuple(SCENES)
) -> dict[str, Any]:
    """Measure every setting; the result is ready for JSON."""
    settings = [
        (name, method, setting, extent.phases)
        for name in scenes
        for method, (knob, _) in METHODS.items()
        for setting in (extent.periods_ms if knob == PERIOD else extent.tolerances_mm)
    ]
    if FINE_MS not in extent.periods_ms and SPEED_SCENE in scenes:
        by_period = (method for method, (knob, _) in METHODS.items() if knob == PERIOD)
        settings += [(SPEED_SCENE, method, FINE_MS, 1) for method in by_period]
    rows = []
    for number, setting in enumerate(settings):
        rows.append(measure(*setting))
        progress((number + 1) / (len(settings) + 1))
    shown = [*pose_rows(), *chord_rows(extent.sides), *cycle_rows(extent.blocks)]
    progress(1.0)
    return {
        "schema": SCHEMA,
        **environment(),
        "device": "cpu",
        "phases": extent.phases,
        "seed": SEED,
        "rows": rows,
        "representation": shown,
        "goals": goals(rows, shown),
    }


@dataclass(frozen=True)
class StudyRun:
    """One run against the truth.

    Attributes:
        found_s, error_s: time of the contact found and its error [s]; None when none was found.
        missed, false: no contact found where there is one; one found where or when there is none.
        clearance_mm: true distance at the instant found, 0 where the bodies touch.
        expected: the sample is the one that the closed form says.
        wall_s: time of the run.
        counts: poses, box tests, triangle tests.
    """

    found_s: float | None
    error_s: float | None
    missed: bool
    false: bool
    clearance_mm: float
    expected: bool
    wall_s: float
    counts: tuple[int, ...]


def measure(name: str, method: str, setting: float, phases: int) -> dict[str, Any]:
    """One method with one setting of its knob on one scene, over random starts."""
    runs = list(_runs(name, method, setting, phases))
    errors = [abs(run.error_s) for run in runs if run.error_s is not None]
    scene = _scene(name)
    missed = sum(run.missed for run in runs)
    duration = scene.leaves_s - (scene.contact_s or 0.0)
    poses, boxes, triangles = np.median([run.counts for run in runs], axis=0).tolist()
    return {
        "scene": name,
        "method": method,
        "knob": METHODS[method][0],
        "setting": setting,
        "runs": len(runs),
        "unit": "s",
        "error_median": float(np.median(errors)) if errors else None,
        "error_max": max(errors, default=None),
        "latest": max((run.error_s for run in runs if run.error_s is not None), default=None),
        "missed": missed,
        "false": sum(run.false for run in runs),
        "alarms": sum(run.found_s is not None for run in runs),
        "clearance_mm": max(run.clearance_mm for run in runs),
        "missed_mm": scene.deepest_mm if missed else 0.0,
        "missed_s": duration if missed else 0.0,
        "unexpected": sum(not run.expected for run in runs),
        "wall_s": float(np.median([run.wall_s for run in runs])),
        "poses": poses,
        "box_tests": boxes,
        "triangle_tests": triangles,
        "found_s": [run.found_s for run in runs],
    }


@cache
def _scene(name: str) -> KnownScene:
    return SCENES[name]()


@lru_cache(maxsize=SUBJECTS)
def _subject(name: str, start_ps: int) -> Subject:
    return Subject(delayed(_scene(name), start_ps))


def _runs(name: str, method: str, setting: float, phases: int) -> Iterator[StudyRun]:
    """Yield one run per start; the first is done twice, to warm up."""
    knob, run = METHODS[method]
    period_ps = round(setting * PS_PER_MS) if knob == PERIOD else DEFAULT_PERIOD_PS
    starts = np.random.default_rng(SEED).uniform(0.0, period_ps, phases)
    for number, start in enumerate(starts.astype(np.int64).tolist()):
        subject = _subject(name, start)
        value = float(period_ps) if knob == PERIOD else setting
        if number == 0:
            run(subject, value)
        yield _one(subject, run, value, knob)


def _one(subject: Subject, method: Method, value: float, knob: str) -> StudyRun:
    begin = time.perf_counter()
    found = method(subject, value)
    wall_s = time.perf_counter() - begin
    scene, true_s = subject.scene, subject.scene.contact_s
    found_s = None if found.time_ps is None else found.time_ps / PS_PER_S
    error = None if found_s is None or true_s is None else found_s - true_s
    early = found_s is not None and (error is None or error < 0.0)
    distance = scene.clearance_at(_moment(subject, found)) if early else 0.0
    allowed = 0.0 if knob == PERIOD else value
    return StudyRun(
        found_s,
        error,
        missed=found_s is None and true_s is not None,
        false=distance > allowed + ALARM_SLACK_MM and (true_s is None or knob == PERIOD),
        clearance_mm=distance,
        expected=knob != PERIOD or _is_expected(subject, found, value),
        wall_s=wall_s,
        counts=tuple(found.counts.tolist()),
    )


def _moment(subject: Subject, found: Found) -> int:
    """Instant of a contact; the last sample may lie after the end of the path."""
    assert found.time_ps is not None
    return min(found.time_ps, subject.scene.path.duration_ps)


def _is_expected(subject: Subject, found: Found, period_ps: float) -> bool:
    """The first sample after the true contact is the one found, if it lies within the contact."""
    scene = subject.scene
    if scene.contact_s is None:
        return found.time_ps is None
    exact = scene.contact_s * PS_PER_S / period_ps
    if scene.contact_s and abs(exact - round(exact)) < FRACTION_MARGIN:
        return True
    sample = ceil(exact) * period_ps
    # The end of a path counts for the sample after it.
    seen = min(sample, scene.path.duration_ps) / PS_PER_S <= scene.leaves_s
    return found.time_ps == (sample if seen else None)
