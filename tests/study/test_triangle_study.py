"""The triangle study: ours misses nothing, the textbook tests do, depth and clearance are exact."""

from __future__ import annotations

import csv
from math import sqrt
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from gcodesim.cli import main
from gcodesim.study.exact import squared_clearance, squared_depth
from gcodesim.study.families import FAMILIES
from gcodesim.study.kernels.textbook import KERNELS, textbook_test
from gcodesim.study.triangle_study import FALSE_ALARM_MM, OURS, TESTS, study_triangles

FLAT = np.array([[0.0, 0.0, 0.0], [8.0, 0.0, 0.0], [0.0, 8.0, 0.0]])


def standing(depth: float) -> np.ndarray:
    """A triangle that stands on its tip, `depth` below the plane of FLAT, amid it."""
    return np.array([[2.0, 2.0, -depth], [1.0, 2.0, 5.0], [3.0, 2.5, 5.0]])


@pytest.mark.parametrize("depth", [0.0, 2.0**-30, 0.25])
def test_depth_of_a_tip_in_a_face(depth: float) -> None:
    assert sqrt(squared_depth(FLAT, standing(depth))) == depth
    assert sqrt(squared_clearance(FLAT, standing(-depth))) == depth


def test_depth_of_crossing_edges_and_of_one_plane() -> None:
    # An edge along y dips 0.5 below one along x, at right angles: the way out is up.
    a = np.array([[-4.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 0.0, -9.0]])
    b = np.array([[0.0, -4.0, -0.5], [0.0, 4.0, -0.5], [0.0, 0.0, 9.0]])
    assert squared_depth(a, b) == 0.25
    assert squared_depth(FLAT, FLAT + [1.0, 1.0, 0.0]) == 0


@pytest.mark.parametrize("precision", ["float32", "float64"])
@pytest.mark.parametrize("name", KERNELS)
def test_textbook_tests_are_right_where_nothing_is_near(name: str, precision: str) -> None:
    cases = [(standing(1.0), True), (standing(-1.0), False), (FLAT + [9.0, 9.0, 0.0], False)]
    cases += [(FLAT + [1.0, 1.0, 0.0], True), (FLAT + [0.0, 0.0, 0.5], False)]
    others = np.array([other for other, _ in cases])
    found = textbook_test(name, precision, np.broadcast_to(FLAT, others.shape), others)
    assert found.tolist() == [touches for _, touches in cases]


def test_ours_misses_nothing_and_the_others_do() -> None:
    report = study_triangles(150, lambda done: None)
    totals = {total["test"]: total for total in report["totals"]}
    assert totals.keys() == TESTS.keys()
    assert (totals[OURS]["missed"], totals[OURS]["deepest_miss_mm"]) == (0, 0.0)
    assert totals[OURS]["farthest_false_mm"] <= FALSE_ALARM_MM
    assert {row["family"] for row in report["rows"]} == set(FAMILIES)
    for row in report["rows"]:
        if row["test"] == OURS and row["family"] != "F08":  # F08: one ulp apart
            assert row["false"] == 0
    single = totals["naive float32"]
    assert 0.01 < single["miss_rate"] < 0.2
    assert 0.1 < single["false_rate"] < 0.5
    assert single["farthest_false_mm"] > 1e-3
    assert totals["wp.intersect_tri_tri float64"]["missed"] > 0
    assert [goal["ok"] for goal in report["goals"][:2]] == [True, True]


def test_the_command_prints_and_writes(tmp_path: Path) -> None:
    out = tmp_path / "t.csv"
    result = CliRunner().invoke(main, ["study", "triangles", "--pairs", "20", "--csv", str(out)])
    assert result.exit_code == 0, result.output
    assert "farthest false alarm of ours, mm" in result.stdout
    rows = list(csv.DictReader(out.read_text().splitlines()))
    assert len(rows) == len(FAMILIES) * len(TESTS)
    assert {row["missed"] for row in rows if row["test"] == OURS} == {"0"}
