"""The goals of the accuracy study: what was wanted, what was found, and whether it is enough."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import product
from typing import Any

from gcodesim.study.methods import METHODS, PERIOD
from gcodesim.study.representation import CYCLE_S, POSE_MM

CERTIFIED = ("paper", "exhaustive", "search")
"""Methods at samples whose answer must be the expected one."""

SPEED_SCENE, SPEED_ERROR_S, TIMES_FASTER = "S5", 1e-5, 1000
"""Wall time is compared where the error is at most this [s]."""

POSES, POSES_TOLERANCE_MM = 50, 1e-6
FEWER_POSES = {
    "S1": 80,
    "S2": 80,
    "S3": 80,
    "S4": 80,
    "S5": 80,
    "S8": 80,
    "S6": 8,
    "S9 1e-6": 8,
}
FEWER_AT_MS = 0.1
"""G10: times fewer poses than every sample, at this period."""

PROVED_CLEARANCE_SLACK_MM = 2e-9
"""Slack of the proofs and of the pose, on top of a tolerance [mm]."""

MOVED_PER_TICK_MM = {"S12": 6e-6}
"""What a body moves [mm] in 1 ps, the resolution of the search between samples, where it counts."""


def goals(rows: list[dict[str, Any]], shown: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """All goals that the rows can answer."""
    found = [
        *_expected_samples(rows),
        *_same_samples(rows),
        *_between(rows, "search between"),
        *_between(rows, "directed bound"),
        *_fewer_poses(rows),
        *_speed(rows),
        *_representation(shown),
    ]
    return [goal for goal in found if goal["found"] is not None]


def _goal(name: str, what: str, found: float | None, sign: str, wanted: float) -> dict[str, Any]:
    ok = found is not None and (found <= wanted if sign == "<=" else found >= wanted)
    return {"goal": name, "what": what, "found": found, "wanted": f"{sign} {wanted:g}", "ok": ok}


def _of(rows: list[dict[str, Any]], **wanted: Any) -> list[dict[str, Any]]:
    return [row for row in rows if all(row[key] == value for key, value in wanted.items())]


def _largest(values: Iterable[float]) -> float | None:
    return max(values, default=None)


def _total(values: Iterable[float]) -> float | None:
    each = list(values)
    return sum(each) if each else None


def _expected_samples(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """G7: the sample of the closed form, or a miss where no sample lies within the contact."""
    found = [row for row in rows if row["method"] in CERTIFIED]
    what = "runs at samples (" + ", ".join(CERTIFIED) + ") whose sample is not the expected one"
    return [_goal("G7", what, _total(row["unexpected"] for row in found), "<=", 0)]


def _same_samples(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """G9: every certified method names the same sample."""
    answers: dict[tuple[str, float], set[tuple[float | None, ...]]] = {}
    for row in rows:
        if row["method"] in CERTIFIED:
            key = (row["scene"], row["setting"])
            answers.setdefault(key, set()).add(tuple(row["found_s"]))
    differ = [len(each) - 1 for each in answers.values()]
    return [_goal("G9", "settings at which methods differ in a sample", _total(differ), "<=", 0)]


def _between(rows: list[dict[str, Any]], method: str) -> list[dict[str, Any]]:
    """G8: never late, never farther than the tolerance, nothing thin or quick missed."""
    found = [row for row in rows if row["method"] == method]
    excess = (
        row["clearance_mm"]
        - row["setting"]
        - PROVED_CLEARANCE_SLACK_MM
        - MOVED_PER_TICK_MM.get(row["scene"], 0.0)
        for row in found
        if row["setting"] >= POSES_TOLERANCE_MM
    )
    latest = _largest(row["latest"] for row in found if row["latest"] is not None)
    quick = [row["missed"] for row in found if row["scene"] in ("S7", "S12")]
    apart = [
        row["alarms"]
        for row in found
        if row["scene"].startswith("S9 ") and float(row["scene"][3:]) >= 2.0 * row["setting"]
    ]
    fine = [row for row in found if row["setting"] == POSES_TOLERANCE_MM]
    most = max(fine, key=lambda row: row["poses"], default=None)
    where = f" ({most['scene']})" if most else ""
    beyond = f"clearance beyond tolerances of {POSES_TOLERANCE_MM:g} mm and more, mm"
    poses = f"poses at {POSES_TOLERANCE_MM:g} mm, most of all scenes{where}"
    return [
        _goal("G8", f"{method}: latest error, s", latest, "<=", 0.0),
        _goal("G8", f"{method}: {beyond}", _largest(excess), "<=", 0.0),
        _goal("G8", f"{method}: S7 and S12 missed", _total(quick), "<=", 0),
        _goal("G8", f"{method}: alarms on S9 at twice the tolerance", _total(apart), "<=", 0),
        _goal("G8", f"{method}: {poses}", most["poses"] if most else None, "<=", POSES),
    ]


def _fewer_poses(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """G10: poses of the search against those of every sample."""
    found = []
    for scene, wanted in FEWER_POSES.items():
        both = [
            _of(rows, scene=scene, method=method, setting=FEWER_AT_MS)
            for method in ("exhaustive", "search")
        ]
        for every, few in product(*both):
            what = (
                f"{scene}: times fewer poses (three per item) than every sample, {FEWER_AT_MS:g} ms"
            )
            found.append(_goal("G10", what, every["poses"] / few["poses"], ">=", wanted))
    return found


def _speed(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """How much faster the search is than every sample at the same small error."""

    def quickest(method: str) -> float | None:
        enough = [
            row["wall_s"]
            for row in _of(rows, scene=SPEED_SCENE, method=method)
            if row["error_max"] is not None and row["error_max"] <= SPEED_ERROR_S
        ]
        return min(enough, default=None)

    search, found = quickest("search"), []
    for method in (m for m, (knob, _) in METHODS.items() if knob == PERIOD and m != "search"):
        every = quickest(method)
        if every and search:
            what = f"{SPEED_SCENE}, error {SPEED_ERROR_S:g} s: times the time of search, {method}"
            found.append(_goal("speed", what, every / search, ">=", TIMES_FASTER))
    return found


def _representation(shown: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """G12, G13: poses and cycle times."""
    poses = _of(shown, method="pose", knob="float64")
    times = _of(shown, method="picoseconds")
    pose, time = (_largest(row["error_max"] for row in each) for each in (poses, times))
    return [
        _goal("G12", "error of a pose in float64, mm", pose, "<=", POSE_MM),
        _goal("G13", "error of the program time in picoseconds, s", time, "<=", CYCLE_S),
    ]
