"""`gcodesim bench`: its figures are whole and consistent; how fast it is, no test says."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from gcodesim.cli import main
from gcodesim.constants import PS_PER_S
from gcodesim.machine.control_data import control_for
from gcodesim.machine.loading import load_machine
from gcodesim.motion.planner import plan
from gcodesim.nc.interpret import interpret
from gcodesim.study.clock import RUNS, time_runs
from gcodesim.study.job import StudyJob, exhaustive_job, longest_job, repeated, search_job
from gcodesim.study.paper_tables import CPU_US, FIGURES, GPU_US

PROGRAM = "G21 G90\nT1 M6\nS1000 M3\nG0 X20. Y10.\nG1 A-20. C40. F3000.\nX40.\nM30\n"


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """The figures of a short program, with few samples."""
    folder = tmp_path_factory.mktemp("bench")
    (folder / "p.nc").write_text(PROGRAM)
    arguments = ["bench", str(folder / "p.nc"), "--device", "cpu", "--seconds", "5"]
    files = ["--json", str(folder / "b.json"), "--csv", str(folder / "b.csv")]
    result = CliRunner().invoke(main, [*arguments, "--paper-samples", "2", *files])
    assert result.exit_code == 0, result.output
    report = json.loads((folder / "b.json").read_text())
    rows = list(csv.reader((folder / "b.csv").read_text().splitlines()))
    assert rows[0] == ["section", "item", "quantity", "value"]
    written = {(s, i, q): v for s, i, q, v in rows[1:]}
    assert float(written["search", "1 threads", "us_per_sample"]) > 0.0
    for pair in CPU_US:
        assert ("paper", f"cpu {pair}", "average_us") in written
        assert pair in result.stdout
    return report


def job_of(text: str) -> StudyJob:
    machine = load_machine("table_tilt")
    meaning = interpret(text, control_for(machine, None, None, False), "p.nc")
    return longest_job(plan(meaning.program, machine)[0], machine, 100_000_000)


def test_the_figures_say_where_and_when_they_were_taken(report: dict[str, Any]) -> None:
    assert report["schema"] == "gcodesim.bench/1"
    assert set(report["versions"]) == {"gcodesim", "warp", "numpy", "python"}
    assert report["cpu"]
    assert report["device"] == "cpu"
    assert report["runs"] == RUNS >= 5


def test_the_eight_pairs_of_the_paper_and_their_ratios(report: dict[str, Any]) -> None:
    (table,) = (t for t in report["paper"] if t["device"] == "cpu")
    assert {row["pair"] for row in table["pairs"]} == CPU_US.keys() == GPU_US.keys()
    for row in table["pairs"]:
        assert row["minimum_us"] <= row["average_us"] <= row["maximum_us"]
        for figure, published in zip(FIGURES, CPU_US[row["pair"]], strict=True):
            assert row[f"paper_{figure}_us"] == published
            faster = published / row[f"{figure}_us"]
            assert row[f"times_faster_{figure}"] == pytest.approx(faster, rel=1e-12)


def test_every_stage_is_there(report: dict[str, Any]) -> None:
    wanted = "read|load machine|interpret|plan|limits|start|scene|forest|compile|search|whole check"
    assert "|".join(report["stages"]) == wanted
    assert all(stage["median_s"] >= 0.0 for stage in report["stages"].values())


def test_search_and_exhaustive_agree(report: dict[str, Any]) -> None:
    compared = report["exhaustive"]
    assert compared["same_answer"]
    quotient = compared["exhaustive_us_per_sample"] / compared["search_us_per_sample"]
    assert compared["ratio"] == pytest.approx(quotient)
    search = report["search"]
    assert search["searched_s"] == search["duration_s"] >= 5.0
    assert [row["threads"] for row in search["threads"]] == [1, 2]
    windows = report["windows"]
    assert windows["median_us"] <= windows["percentile_99_9_us"] <= windows["maximum_us"]


def test_path_length_and_clearance(report: dict[str, Any]) -> None:
    program = report["program"]
    assert program["path_mm"] == pytest.approx(np.hypot(20.0, 10.0) + 20.0, abs=1e-9)
    of_pairs = program["median_clearance_of_pairs_mm"]
    assert 0.0 < program["median_clearance_mm"] <= min(of_pairs.values())


def test_the_length_of_an_arc() -> None:
    job = job_of("G21 G90 G17\nG2 X0. Y0. I10. J0. F600.\nM30\n")
    assert job.length_mm == pytest.approx(20.0 * np.pi, rel=1e-12)


def test_a_repeated_job_is_one_continuous_motion() -> None:
    job = job_of(PROGRAM)
    again = repeated(job, 2.5 * job.path.duration_s)
    assert again.path.duration_s >= 2.5 * job.path.duration_s
    np.testing.assert_array_equal(again.path.q0[1:], again.path.q1[:-1])
    assert len(again.path) == 3 * (len(job.path) + 1)  # a way back after each round
    assert repeated(job, 0.0).path.duration_ps == job.path.duration_ps


def test_answers_of_a_colliding_job() -> None:
    job = job_of("G21 G90\nT1 M6\nG0 Z-560.\nM30\n")
    searcher = job.searcher(job.scene("cpu"), threads=1, between=False)
    found, expected = search_job(searcher), exhaustive_job(searcher)
    assert found.sample is not None
    assert (found.sample, found.pair, found.end_ps) == (
        expected.sample,
        expected.pair,
        expected.end_ps,
    )
    assert found.end_ps < job.path.duration_ps < PS_PER_S * 100


def test_what_cannot_be_measured_is_said(tmp_path: Path) -> None:
    (tmp_path / "still.nc").write_text("G21 G90\nM30\n")
    result = CliRunner().invoke(main, ["bench", str(tmp_path / "still.nc"), "--device", "cpu"])
    assert result.exit_code == 2
    assert "the program moves no axis" in result.stderr


def test_the_median_leaves_out_the_run_that_warms_up() -> None:
    calls: list[int] = []
    timing, last = time_runs(lambda: calls.append(1) or len(calls), runs=3)
    assert last == len(calls) == 4
    assert len(timing.runs) == 3
    assert timing.least <= timing.median <= max(timing.runs)
