"""The leave-out study: less is looked at, and the answer is the same."""

from __future__ import annotations

import csv
import json
from pathlib import Path

from click.testing import CliRunner

from gcodesim.cli import main

ROOT = Path(__file__).parents[2]


def test_less_is_looked_at_for_the_same_answer(tmp_path: Path) -> None:
    table, figures = tmp_path / "out.csv", tmp_path / "out.json"
    args = ["study", "leave-out", str(ROOT / "samples" / "part.nc"), "--generated", "1"]
    done = CliRunner().invoke(main, [*args, "--json", str(figures), "--csv", str(table)])
    assert done.exit_code == 0, done.output
    study = json.loads(figures.read_text())
    by_kind = {row["kind"]: row for row in study["savings"]}
    assert set(by_kind) == {"program", "3 axes", "3+2 axes", "5 axes"}
    for row in study["savings"]:
        assert row["agrees"]
        assert row["items"] <= row["items_full"] < row["tests"] / 50
        assert row["pairs_out"] + row["triangles_out"] > 0
    # A program of three axes needs neither the rotary axes nor most of the machine.
    assert by_kind["3 axes"]["axes_out"] == 2
    assert by_kind["5 axes"]["axes_out"] == 0
    assert by_kind["3 axes"]["triangles_out"] > by_kind["5 axes"]["triangles_out"]
    assert study["imported"] == []
    assert "search_kernel" in study["kernels"]
    assert {"paper", "triangles", "lasting", "depths"} <= set(study["kernels_out"])
    with table.open(newline="") as rows:
        assert [row["program"] for row in csv.DictReader(rows)] == [
            row["program"] for row in study["savings"]
        ]


def test_nothing_to_check_is_an_error() -> None:
    done = CliRunner().invoke(main, ["study", "leave-out", "--generated", "0"])
    assert done.exit_code == 2
    assert "nothing to check" in done.stderr


def test_a_file_that_could_not_be_written_is_told_before_the_study(tmp_path: Path) -> None:
    for option in ("--json", "--csv"):
        args = ["study", "leave-out", option, str(tmp_path / "none" / "out")]
        done = CliRunner().invoke(main, args)
        assert done.exit_code == 2
        assert "there is no folder" in done.stderr
        assert done.stdout == ""
