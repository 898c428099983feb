"""The accuracy study against closed forms: its errors obey their formulas, its misses are told."""

from __future__ import annotations

import csv
import io
import sys
from itertools import chain
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from rich.console import Console

from gcodesim.cli import main
from gcodesim.constants import SLACK_MM
from gcodesim.errors import UsageError
from gcodesim.report.study_plot import plot_accuracy, require_matplotlib
from gcodesim.report.study_report import (
    RUN_COLUMNS,
    print_accuracy,
    verdict_of,
    write_accuracy_csv,
)
from gcodesim.study.accuracy import SCHEMA, Extent, measure, study_accuracy
from gcodesim.study.methods import METHODS, PERIOD
from gcodesim.study.scenes import FEED, SCENES

TINY = Extent((10.0, 1.0), (1e-3, 1e-6), 2, (8,), 200)
FEW = ("S1", "S7", "S9 1e-3")
AT_SAMPLES = [method for method, (knob, _) in METHODS.items() if knob == PERIOD]


@pytest.fixture(scope="module")
def report() -> dict[str, Any]:
    done: list[float] = []
    report = study_accuracy(TINY, done.append, FEW)
    assert done == sorted(done)
    assert done[-1] == 1.0
    return report


def rows(report: dict[str, Any], **wanted: object) -> list[dict[str, Any]]:
    """Rows of the study with the given values."""
    every = chain(report["rows"], report["representation"])
    return [row for row in every if all(row[key] == value for key, value in wanted.items())]


@pytest.mark.parametrize("method", AT_SAMPLES)
@pytest.mark.parametrize("name", ["S3", "S8"])
def test_every_sampled_method_errs_by_less_than_a_period(method: str, name: str) -> None:
    row = measure(name, method, 1.0, 3)
    assert 0.0 < row["error_median"] <= row["error_max"] < 1e-3
    assert (row["missed"], row["false"], row["unexpected"]) == (0, 0, 0)
    assert row["poses"] > 0
    assert row["triangle_tests"] > 0


def test_every_sample_costs_a_pose_and_the_search_does_not() -> None:
    every, few = (measure("S5", method, 0.1, 2) for method in ("exhaustive", "search"))
    assert every["found_s"] == few["found_s"]
    assert all(every["poses"] == pytest.approx(found / 1e-4, abs=3) for found in every["found_s"])
    assert few["poses"] < every["poses"] / 40


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4, 1e-6])
def test_between_samples_the_error_is_the_tolerance_over_the_speed(tolerance: float) -> None:
    row = measure("S1", "search between", tolerance, 2)
    assert row["error_max"] == pytest.approx((tolerance + SLACK_MM) / FEED, abs=2e-12)
    assert row["latest"] < 0.0
    assert row["clearance_mm"] == pytest.approx(tolerance + SLACK_MM, abs=1e-9)


@pytest.mark.parametrize("name", SCENES)
def test_the_directed_bound_needs_few_poses(name: str) -> None:
    """At 1e-6 mm: at most 50 poses, never late, never farther away than the tolerance."""
    row = measure(name, "directed bound", 1e-6, 1)
    assert row["poses"] <= 50
    assert (row["missed"], row["false"]) == (0, 0)
    assert row["latest"] is None or row["latest"] <= 0.0
    # S12 moves 6e-6 mm in the picosecond to which instants are told.
    assert row["clearance_mm"] <= 1e-6 + (6e-6 if name == "S12" else 0.0)


def test_what_samples_miss_is_told_with_depth_and_duration(report: dict[str, Any]) -> None:
    for method in AT_SAMPLES:
        (row,) = rows(report, scene="S7", method=method, setting=10.0)
        assert verdict_of(row) == "MISS 2/2"
        assert row["missed_mm"] == pytest.approx(0.01, abs=1e-9)
        assert row["missed_s"] == pytest.approx(2e-5, abs=1e-12)
        assert row["unexpected"] == 0
    for method in ("search between", "directed bound"):
        assert {verdict_of(row) for row in rows(report, scene="S7", method=method)} == {"hit"}
    turning = measure("S12", "exhaustive", 1.0, 2)
    # The block passes the whole pin, 8 mm thick, in a part of the 0.1 ms of the flip.
    assert turning["missed"] == 2
    assert 4.0 < turning["missed_mm"] < 38.0
    assert 0.0 < turning["missed_s"] < 1e-4


def test_near_misses_are_no_contact(report: dict[str, Any]) -> None:
    assert {verdict_of(row) for row in rows(report, scene="S9 1e-3", knob=PERIOD)} == {
        "none, rightly"
    }
    loose, tight = rows(report, scene="S9 1e-3", method="search between")
    assert (verdict_of(loose), verdict_of(tight)) == ("near", "none, rightly")
    assert loose["clearance_mm"] == pytest.approx(1e-3 + SLACK_MM, abs=1e-11)


def test_what_no_search_can_undo_stays_within_its_bound(report: dict[str, Any]) -> None:
    shown = report["representation"]
    assert {row["method"] for row in shown} == {
        "pose",
        "polygon around",
        "polygon inside",
        *("float32 sum", "float64 sum", "picoseconds"),
    }
    for row in shown:
        if row["bound"] is not None:
            assert row["error_max"] <= row["bound"]
    (single,) = rows(report, scene="S5", method="pose", knob="float32")
    (double,) = rows(report, scene="S5", method="pose", knob="float64")
    assert 0.0 < double["error_max"] < 1e-12 < 1e-7 < single["error_max"] < 1e-4


def test_goals_are_judged(report: dict[str, Any]) -> None:
    goals = {(goal["goal"], goal["what"]): goal for goal in report["goals"]}
    assert {name for name, _ in goals} == {"G7", "G8", "G9", "G12", "G13"}
    judged = [goal for goal in report["goals"] if goal["goal"] in ("G7", "G9", "G12", "G13")]
    assert all(goal["ok"] for goal in judged)
    for goal in report["goals"]:
        sign, limit = goal["wanted"].split()
        within = goal["found"] <= float(limit) if sign == "<=" else goal["found"] >= float(limit)
        assert goal["ok"] == within


def test_tables_and_rows(report: dict[str, Any]) -> None:
    drawn = io.StringIO()
    print_accuracy(report, Console(file=drawn, width=200))
    shown = drawn.getvalue()
    assert "MISS 2/2" in shown
    assert "none, rightly" in shown
    assert "SHORT" in shown
    written = io.StringIO()
    write_accuracy_csv(report, written)
    table = list(csv.DictReader(io.StringIO(written.getvalue())))
    assert len(table) == len(report["rows"]) + len(report["representation"])
    assert tuple(table[0]) == RUN_COLUMNS
    missed = {"scene": "S7", "method": "search", "setting": "1.0"}
    (row,) = (row for row in table if missed.items() <= row.items())
    assert row["missed"] == "2"
    assert row["error_max"] == ""
    assert report["schema"] == SCHEMA


def test_the_plot_is_a_png(report: dict[str, Any], tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    plot_accuracy(report, str(tmp_path / "a.png"))
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


def test_a_plot_without_matplotlib_is_refused_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(UsageError, match=r"pip install 'gcodesim\[plot\]'"):
        require_matplotlib()
    result = CliRunner().invoke(main, ["study", "accuracy", "--plot", "never.png"])
    assert result.exit_code == 2
    assert "gcodesim[plot]" in result.stderr
