"""The triangle study: what textbook tests miss and invent on hard families, beside ours."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gcodesim.collision.geometry.triangles import triangles_intersect
from gcodesim.study.bench import environment
from gcodesim.study.clock import time_runs
from gcodesim.study.exact import label, squared_clearance, squared_depth
from gcodesim.study.families import FAMILIES, generate
from gcodesim.study.kernels.textbook import textbook_test

SCHEMA = "gcodesim.study.triangles/1"
SEED = 1
RUNS = 7
CHUNK = 2000
"""Pairs labelled between two steps of the progress bar."""

MM_PER_UNIT = {"F11": 1000.0}
"""Families in another unit than mm."""

FALSE_ALARM_MM = 1e-9
"""Largest clearance at which ours may report a contact (goal G2)."""

TIMES_NAIVE = 1.5
"""Goal G6. It was set for the first round alone; half of these pairs touch and need every round."""

Floats = NDArray[np.float64]
Verdicts = NDArray[np.bool_]
Test = Callable[[Floats, Floats], Verdicts]

OURS = "ours"
TESTS: dict[str, Test] = {
    "naive float32": partial(textbook_test, "17 axes", "float32"),
    "paper's 6/11 float32": partial(textbook_test, "6/11 axes", "float32"),
    "wp.intersect_tri_tri float32": partial(textbook_test, "wp.intersect_tri_tri", "float32"),
    "wp.intersect_tri_tri float64": partial(textbook_test, "wp.intersect_tri_tri", "float64"),
    "naive float64": partial(textbook_test, "17 axes", "float64"),
    OURS: triangles_intersect,
}
"""Name of each test -> the test: (n, 3, 3) twice in, n verdicts out."""


@dataclass
class LabelledPairs:
    """The pairs of one family with their exact answers; distances are found once, when asked for.

    Attributes:
        a, b: triangles, shape (n, 3, 3).
        touching: the truth, shape (n,).
        mm: millimetres per unit of the family.
    """

    a: Floats
    b: Floats
    touching: Verdicts
    mm: float

    def __post_init__(self) -> None:
        self._known: dict[int, float] = {}

    def distance(self, row: int) -> float:
        """How far a pair is from the wrong answer [mm]: its clearance, or its depth if it touches.

        Exact but for the last rounding.
        """
        if row not in self._known:
            measure = squared_depth if self.touching[row] else squared_clearance
            self._known[row] = sqrt(measure(self.a[row], self.b[row])) * self.mm
        return self._known[row]


def study_triangles(count: int, progress: Callable[[float], None]) -> dict[str, Any]:
    """Ask every test about `count` pairs of every family; the result is ready for JSON."""
    rows: list[dict[str, Any]] = []
    for number, family in enumerate(FAMILIES):
        pairs = _pairs(family, count, partial(_advance, progress, number))
        rows += [{"family": family} | compare(pairs, name, test) for name, test in TESTS.items()]
    totals = [_total([row for row in rows if row["test"] == name]) for name in TESTS]
    progress(1.0)
    return {
        "schema": SCHEMA,
        **environment(),
        "device": "cpu",
        "seed": SEED,
        "pairs": count,
        "rows": rows,
        "totals": totals,
        "goals": _goals(totals[-1], totals[-2]),
    }


def _advance(progress: Callable[[float], None], families: int, fraction: float) -> None:
    progress((families + fraction) / len(FAMILIES))


def _pairs(family: str, count: int, progress: Callable[[float], None]) -> LabelledPairs:
    a, b = generate(family, count, SEED)
    touching = []
    for first in range(0, count, CHUNK):
        touching.append(label(a[first : first + CHUNK], b[first : first + CHUNK]))
        progress(first / count)
    return LabelledPairs(a, b, np.concatenate(touching), MM_PER_UNIT.get(family, 1.0))


def compare(pairs: LabelledPairs, name: str, test: Test) -> dict[str, Any]:
    """Verdicts of one test against the truth, and its time per pair, copies included."""
    timing, found = time_runs(lambda: test(pairs.a, pairs.b), RUNS)
    missed = np.flatnonzero(pairs.touching & ~found)
    false = np.flatnonzero(found & ~pairs.touching)
    touching = int(pairs.touching.sum())
    return {
        "test": name,
        "pairs": len(found),
        "touching": touching,
        "missed": len(missed),
        "false": len(false),
        "deepest_miss_mm": max((pairs.distance(i) for i in missed.tolist()), default=0.0),
        "farthest_false_mm": max((pairs.distance(i) for i in false.tolist()), default=0.0),
        "ns_per_pair": timing.median / len(found) * 1e9,
    }


def _total(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """All families together, with the rates of misses and false alarms."""
    sums = {key: sum(row[key] for row in rows) for key in ("pairs", "touching", "missed", "false")}
    apart = sums["pairs"] - sums["touching"]
    return {
        "test": rows[0]["test"],
        **sums,
        "miss_rate": sums["missed"] / sums["touching"],
        "false_rate": sums["false"] / apart,
        "deepest_miss_mm": max(row["deepest_miss_mm"] for row in rows),
        "farthest_false_mm": max(row["farthest_false_mm"] for row in rows),
        "ns_per_pair": float(np.median([row["ns_per_pair"] for row in rows])),
    }


def _goals(ours: dict[str, Any], naive: dict[str, Any]) -> list[dict[str, Any]]:
    """Goals G1, G2 and G6 against what was found."""
    wanted = [
        ("G1", "touching pairs that ours misses", ours["missed"], 0),
        ("G2", "farthest false alarm of ours, mm", ours["farthest_false_mm"], FALSE_ALARM_MM),
        ("G6", "time of ours over naive float64, all rounds", _times(ours, naive), TIMES_NAIVE),
    ]
    return [
        {"goal": goal, "what": what, "found": found, "wanted": f"<= {most:g}", "ok": found <= most}
        for goal, what, found, most in wanted
    ]


def _times(ours: dict[str, Any], naive: dict[str, Any]) -> float:
    return float(ours["ns_per_pair"] / naive["ns_per_pair"])
