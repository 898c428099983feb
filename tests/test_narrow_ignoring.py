"""Ignoring is narrow: one block, the parts that touch in it, down to the accepted depth."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from reporting import NEAR, PASSED, TOUCH, finding

from gcodesim.cli import main
from gcodesim.constants import DEPTH_SLACK
from gcodesim.policy.baseline import Baseline
from gcodesim.policy.policy import Policy

MACHINE = """
name: merge
links:
  bed: {parts: [{name: clamp, box: {size: [10, 40, 20], center: [0, 0, 10]}},
                {name: vise, box: {size: [40, 40, 40], center: [VISE, 0, 20]}}]}
  X: {}
  Z: {box: {size: [60, 60, 60], center: [-100, 0, 230]}}
joints:
  X: {type: linear, parent: bed, child: X, axis: [1, 0, 0], limits: [0, 400], rapid: 30000}
  Z: {type: linear, parent: X, child: Z, axis: [0, 0, 1], limits: [-200, 200], rapid: 30000}
tool: {link: Z, gauge_point: [-100, 0, 200], axis: [0, 0, 1], mounted: {name: cutter, length: 100,
       for: all, cylinder: {radius: 5, height: 100, center: [-100, 0, 150]}}}
work: {link: bed, offsets: {G54: {X: 0, Y: 0, Z: 0}}}
control: {rapids: linear}
"""
HEAD = "G21 G90 G94 G17 G40\nM3 S100\nG0 X80. Z-85.\n"
IGNORED = "(gcodesim: ignore GC102 reason=dummy clamp gives way)"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "m.yaml").write_text(MACHINE.replace("VISE", "45"))
    (tmp_path / "near.yaml").write_text(MACHINE.replace("VISE", "30"))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def check(blocks: str, *args: str, machine: str = "m.yaml") -> Result:
    Path("part.nc").write_text(f"{HEAD}{blocks}\nM30\n")
    command = ["check", "part.nc", "--machine", machine, "--device", "cpu", "--stop", "all", *args]
    return CliRunner().invoke(main, command)


def counted(result: Result) -> list[tuple[str, str, float]]:
    findings = json.loads(result.stdout)["findings"]
    return [
        (f["block"].split(" ")[0], f["parts"][1], round(f["depth"], 3))
        for f in findings
        if f["code"] == "GC102"
    ]


def test_contacts_with_little_time_between_them_are_told_apart() -> None:
    """The cutter leaves the clamp, and 36 ms later it is in the vise."""
    result = check(f"N10 G1 X112. F6000. {IGNORED}\nN20 G0 X150.", "--format", "json")
    assert result.exit_code == 1
    assert [found[:2] for found in counted(result)] == [("N20", "vise")]


def test_another_part_counts_while_an_accepted_one_is_still_touched() -> None:
    blocks = f"N10 G1 X104. F6000. {IGNORED}\nN20 G0 X150."
    result = check(blocks, "--format", "json", machine="near.yaml")
    assert result.exit_code == 1
    assert "vise" in [part for _, part, _ in counted(result)]


def test_a_comment_ends_with_its_block() -> None:
    """Deeper, and to the side at the same depth: both are another block."""
    dips = f"G0 X100. Z0\nN10 G1 Z-80.01 F6000. {IGNORED}\n"
    assert check(dips + "G0 Z0").exit_code == 0, "out on the way in"
    for onward in ("N20 G1 Z-85.", "N20 G1 X102."):
        result = check(f"{dips}{onward}\nG0 Z0", "--format", "json")
        assert result.exit_code == 1, onward
        assert [found[:2] for found in counted(result)] == [("N20", "clamp")]


def test_what_counts_in_many_blocks_is_told_once_with_its_largest_depth() -> None:
    blocks = "G0 X100. Z0\nN10 G1 Z-80.5 F6000.\nN20 Z-81.\nN30 Z-82.\nG0 Z0"
    assert counted(check(blocks, "--format", "json")) == [("N10", "clamp", 2.0)]


def test_a_comment_may_name_a_depth() -> None:
    wish = "(gcodesim: ignore GC102 depth=0.5 reason=soft jaws)"
    for depth, code in (("80.5", 0), ("80.6", 1)):
        result = check(f"G0 X100. Z0\nN10 G1 Z-{depth} F6000. {wish}\nG0 Z0")
        assert result.exit_code == code
    assert "it is 0.6 mm now, and 0.5 mm were accepted" in result.stdout


def test_a_baseline_accepts_the_depth_it_was_made_at() -> None:
    at = ("--baseline", "b.json")
    program = "G0 X100. Z0\nN10 G1 ZDEPTH F6000.\nG0 Z0"
    offsets = {"-80.01": 0, "-80.015": 0, "-82.5": 1}
    check(
        program.replace("ZDEPTH", "Z#1").replace("G0 X100.", "#1=-80.01\nG0 X100."),
        *at,
        "--update-baseline",
    )
    (entry,) = json.loads(Path("b.json").read_text())["entries"]
    assert entry["depth"] == pytest.approx(0.01)
    accept("b.json")
    for place, code in offsets.items():
        moved = program.replace("ZDEPTH", "Z#1").replace("G0 X100.", f"#1={place}\nG0 X100.")
        result = check(moved, *at)
        assert result.exit_code == code, result.stdout
    assert "2.5 mm now, and 0.03 mm were accepted" in result.stdout
    check(moved, *at, "--update-baseline")
    (entry,) = json.loads(Path("b.json").read_text())["entries"]
    assert entry["reason"] == "", "the reason was given for a scratch"


def accept(path: str) -> None:
    text = Path(path).read_text()
    Path(path).write_text(text.replace('"reason": ""', '"reason": "scratch"'))


def test_a_plate_that_a_tool_goes_through_is_at_least_as_deep_as_half_of_it() -> None:
    """No vertex of either body lies inside the other."""
    thin = MACHINE.replace("[10, 40, 20], center: [0, 0, 10]", "[20, 20, 4], center: [0, 0, 18]")
    Path("thin.yaml").write_text(thin.replace("VISE", "300"))
    result = check(
        "G0 X100. Z0\nN10 G1 Z-95. F6000.\nG0 Z0", "--format", "json", machine="thin.yaml"
    )
    ((_, _, depth),) = counted(result)
    assert depth >= 2.0


def test_a_baseline_of_a_former_version_is_read_and_said_to_be_old(tmp_path: Path) -> None:
    deep = replace(TOUCH, parts=("flute", "table"), depth=0.3)
    before = replace(PASSED, findings=(replace(deep, parts=None, depth=None), NEAR))
    path = str(tmp_path / "b.json")
    old = Baseline(path, {}).updated([(before, before.findings, True)])
    entries = {key: replace(entry, reason="dummy") for key, entry in old.entries.items()}
    old = replace(old, entries=entries)
    later = replace(deep, block="N7", continues=True)
    judged = Policy(baseline=old).apply(replace(PASSED, findings=(deep,)), "", stop_all=True)
    assert judged.verdict == "pass"
    assert "baseline_old" in [f.meaning for f in judged.counted]
    two = replace(PASSED, findings=(deep, later))
    assert Policy(baseline=old).apply(two, "", stop_all=True).verdict == "fail", "another block"
    new = old.updated([(two, two.findings, True)])
    assert sorted((e.depth, e.reason) for e in new.entries.values()) == [(0.3, ""), (0.3, "dummy")]


def test_what_need_not_fail_the_program_counts_again_without_an_error(tmp_path: Path) -> None:
    near = finding("GC201", 8, pair=("cutter", "A"), depth=0.1)
    seen = replace(PASSED, findings=(near,))
    accepted = Baseline(str(tmp_path / "b.json"), {}).updated([(seen, seen.findings, True)])
    for depth, counts in ((0.1 + DEPTH_SLACK / 2, []), (0.2, ["GC201"])):
        now = replace(PASSED, findings=(replace(near, depth=depth),))
        judged = Policy(baseline=accepted).apply(now, "", stop_all=True)
        assert (judged.verdict, [f.code for f in judged.counted]) == ("pass", counts)


@pytest.mark.parametrize("form", ["junit", "github", "gitlab"])
def test_reports_of_ci_say_what_was_ignored(form: str) -> None:
    result = check(f"N10 G1 X112. F6000. {IGNORED}\nG0 Z0", "--format", form)
    assert result.exit_code == 0
    assert "dummy clamp gives way" in result.stdout
    assert "clamp of bed" in result.stdout
