"""The study of stability: every case is ok, and a formulation that is not is shown as FAIL."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from dataclasses import replace
from math import nan
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from gcodesim.cli import main
from gcodesim.motion.samples import Instants
from gcodesim.study import (
    stability,
    stability_drives,
    stability_motion,
    stability_scenes,
    stability_triangles,
    stability_turns,
)
from gcodesim.study.exact import label
from gcodesim.study.stability_case import Case
from gcodesim.study.stability_triangles import near_pairs, textbook_contact

GOOD = Case("time", "samples", "time of the last", "t += dt", 88.0, 0.0, 0.0, "s")


def test_the_quick_table_is_ok_and_the_usual_formulations_are_not(tmp_path: Path) -> None:
    table, figures = tmp_path / "out.csv", tmp_path / "out.json"
    args = ["study", "stability", "--quick", "--json", str(figures), "--csv", str(table)]
    done = CliRunner().invoke(main, args)
    assert done.exit_code == 0, done.output
    study = json.loads(figures.read_text())
    cases = study["cases"]
    assert study["ok"]
    assert all(row["ok"] for row in cases)
    assert {row["topic"] for row in cases} == {
        "time", "feed", "arcs", "servo", "ramps", "turns", "TCP", "scale", "numbers", "same",
    }  # fmt: skip
    compared = [row for row in cases if row["usual"]]
    assert len(cases) >= 75
    assert sum(not row["naive_ok"] for row in compared) >= 50
    assert f"{len(cases)} of {len(cases)} ok" in done.stdout
    assert "FAIL" not in done.stdout
    (collide,) = {row["case"] for row in cases if "random scenes" in row["case"]}
    assert collide == "10 random scenes, 6 collide"
    with table.open(newline="") as rows:
        assert [float(row["ours"]) for row in csv.DictReader(rows)] == [r["ours"] for r in cases]


def radians(degrees: Any) -> tuple[Any, Any]:
    return np.sin(np.radians(degrees)), np.cos(np.radians(degrees))


def explicit_euler(x: Any, damping: float | None) -> list[Any]:
    return [((1.0 - x / 20) ** 20, 0.0 * x)] * 4


def from_centre(arcs: Any, s: Any) -> Any:
    begin = np.arctan2(arcs["u"][:, 1], arcs["u"][:, 0])
    return stability_motion.from_centre(arcs, begin, s, np.float64)


def difference_of_squares(start: Any, end: Any, radius: float, *more: Any) -> tuple[float, float]:
    return end[0] / 2, np.sqrt(radius**2 - end[0] ** 2 / 4)


def float32_window(path: Any, span: Any, first: int, *more: Any) -> Instants:
    time = np.array([int(stability_motion.accumulated(np.float32, first) * 1e12)])
    return Instants(time, path.piece_at(time), np.array([first]))


def shrunk(scene: stability_scenes.RandomScene) -> stability_scenes.RandomScene:
    return scene.reshaped(lambda t: t * 0.9)


BROKEN: list[tuple[Any, str, Any, Callable[[bool], Any], str]] = [
    (stability_motion, "arc_displacement", from_centre, stability_motion.arcs,
     "R 1e8 mm, up to 1 m"),
    (stability_motion, "centre_from_radius", difference_of_squares, stability_motion.radius_words,
     "R half the chord + 1e-12 .. 1e-3"),
    (stability_motion, "window", float32_window, stability_motion.clocks, "1e7 samples of 0.1 ms"),
    (stability_drives, "exponentials", explicit_euler, stability_drives.steps_of_drives,
     "first order, tau 1e-9 .. 10 s"),
    (stability_turns, "sincosd", radians, stability_turns.right_angles,
     "multiples of 90 deg, 36000090 too"),
    (stability_triangles, "triangles_intersect", lambda a, b: textbook_contact(a, b, np.float32),
     stability_triangles.far_origins, "1 km from the origin"),
    (stability_triangles, "triangles_intersect", lambda a, b: np.zeros(len(a), bool),
     stability_triangles.not_numbers, "one coordinate is nan"),
]  # fmt: skip


@pytest.mark.parametrize(("module", "name", "broken", "compute", "case"), BROKEN)
def test_a_broken_formulation_fails(
    module: Any, name: str, broken: Any, compute: Callable[[bool], Any], case: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    assert all(found.ok for found in compute(True))
    monkeypatch.setattr(module, name, broken)
    assert case in {found.case for found in compute(True) if not found.ok}


def test_a_change_that_matters_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stability_scenes, "CHANGES", {"shrunk": (shrunk, stability_scenes.same)})
    (case,) = stability_scenes.invariances(True)
    assert case.ours >= 5
    assert not case.ok


def test_near_pairs_are_what_they_are_said_to_be() -> None:
    """Against the exact answer of integers, at the finest heights that are used."""
    for finest in (3, 20, 30, 36):
        a, b, touch = near_pairs(200, finest, 9)
        np.testing.assert_array_equal(label(a, b), touch)
        assert 50 < touch.sum() < 150


@pytest.mark.parametrize("ours", [1e-9, nan])
def test_one_failing_case_is_shown_and_ends_with_exit_code_1(
    ours: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bad = replace(GOOD, ours=ours)
    monkeypatch.setattr(stability, "TABLE", (lambda quick: [GOOD], lambda quick: [bad]))
    done = CliRunner().invoke(main, ["study", "stability", "--json", str(tmp_path / "out.json")])
    assert done.exit_code == 1
    assert done.stdout.count("FAIL") == 1
    assert "1 of 2 ok" in done.stdout
    study = json.loads((tmp_path / "out.json").read_text())
    assert [row["ok"] for row in study["cases"]] == [True, False]
