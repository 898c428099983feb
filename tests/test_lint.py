"""Lint: each fault of a model is found at its place, and nothing is found where none is."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from machine.stl import stl_bytes

from gcodesim.checking.lint import lint
from gcodesim.cli import main
from gcodesim.findings.codes import Finding
from gcodesim.machine import shapes
from gcodesim.machine.loading import load_machine

SOUND = """\
name: sound
verified: true
links:
  bed: {box: {size: [400, 300, 50], center: [0, 0, -200]}}
  X: {box: {size: [300, 200, 120], center: [0, 0, -100]}}
  A: {mesh: A.stl}
  Y: {}
  Z: {box: {size: [80, 80, 200], center: [0, 0, 300]}}
joints:
  X: {type: linear, parent: bed, child: X, axis: [-1, 0, 0], limits: [-100, 100], rapid: 12000}
  A: {type: rotary, parent: X, child: A, axis: [-1, 0, 0], point: [0, 0, 0], limits: [-90, 90], rapid: 9000}
  Y: {type: linear, parent: bed, child: Y, axis: [0, 1, 0], limits: [-90, 90], rapid: 24000}
  Z: {type: linear, parent: Y, child: Z, axis: [0, 0, 1], limits: [-200, 100], rapid: 24000}
tool:
  link: Z
  gauge_point: [0, 0, 200]
  mounted: {name: cutter, cylinder: {radius: 5, height: 50, center: [0, 0, 175]}, length: 50, for: all}
work: {link: A, offsets: {G54: {Z: -200}}}
reference: {G28: {Z: 100}}
start: {Z: 100}
pairs: [[cutter, A], [cutter, X], [Z, A], [bed, Z]]
path_tolerance: {G64: 0.1, rapid: 0.1}
"""  # noqa: E501 (one line per joint)
APART = ("GC430", "note", "pair_out_of_reach", 21)
"""The bed and the spindle head of the sound machine never meet."""


@pytest.fixture
def model(tmp_path: Path) -> Callable[..., list[Finding]]:
    """Function that lints the sound machine, with one text replaced."""
    (tmp_path / "A.stl").write_bytes(stl_bytes(shapes.box([100, 60, 20])))

    def find(old: str = "", new: str = "") -> list[Finding]:
        assert not old or SOUND.count(old) == 1
        (tmp_path / "m.yaml").write_text(SOUND.replace(old, new) if old else SOUND)
        return list(lint(load_machine(str(tmp_path / "m.yaml"))))

    return find


def rows(findings: list[Finding]) -> set[tuple[str, str, str, int | None]]:
    return {(f.code, f.severity, f.meaning, f.line) for f in findings}


def test_a_sound_machine_has_a_pair_that_never_meets(model: Callable[..., list[Finding]]) -> None:
    found = model()
    assert rows(found) == {APART}
    (apart,) = found
    assert apart.pair == ("bed", "Z")
    # Z comes down to 200 - 200 = 0, the bed ends at -175.
    assert "at least 175 mm apart" in apart.message


@pytest.mark.parametrize(
    ("old", "new", "code", "severity", "meaning", "line"),
    [
        ("limits: [-200, 100], ", "", "GC430", "note", "travel_unlimited", 13),
        ("[-200, 100]", "[10, 100]", "GC430", "note", "zero_out_of_travel", 13),
        ("G28: {Z: 100}", "G28: {Z: 100.1}", "GC301", "error", "reference_out_of_travel", 19),
        ("G28: {Z: 100}", "G30: {A: -91}", "GC302", "error", "reference_out_of_travel", 19),
        ("start: {Z: 100}", "start: {Z: -180}", "GC502", "error", "rest", 21),
        ("verified: true", "verified: false", "GC430", "note", "model_unverified", 2),
        ("G64: 0.1, ", "", "GC430", "note", "path_tolerance_missing", 22),
        (", for: all", "", "GC430", "note", "tools_missing", 17),
        (", offsets: {G54: {Z: -200}}", "", "GC430", "note", "offsets_missing", 18),
        ("work: {link: A, offsets: {G54: {Z: -200}}}", "", "GC430", "warning",
         "tool_centre_unsolved", None),
        ("axis: [0, 1, 0]", "axis: [0, 0, 1]", "GC430", "warning", "tool_centre_unsolved", 9),
        ("parent: bed, child: X", "parent: Z, child: X", "GC430", "warning",
         "tool_centre_unsolved", 9),
        (", [bed, Z]]", "]", "GC430", "note", "body_unpaired", 4),
        ("[[cutter, A], [cutter, X], [Z, A], [bed, Z]]", "[]", "GC430", "warning",
         "pairs_missing", 21),
    ],
)  # fmt: skip
def test_each_fault_is_found_at_its_line(
    model: Callable[..., list[Finding]],
    old: str,
    new: str,
    code: str,
    severity: str,
    meaning: str,
    line: int | None,
) -> None:
    assert (code, severity, meaning, line) in rows(model(old, new))


@pytest.mark.parametrize(("gap", "touches"), [(0.0, True), (1e-6, False)])
def test_a_touch_at_the_start_is_told_from_a_hair(
    model: Callable[..., list[Finding]], gap: float, touches: bool
) -> None:
    # At Z 100 the tip stands at 250; the top of A is put there.
    box = f"{{size: [9, 9, 9], center: [0, 0, {245.5 - gap}]}}"
    found = model("A: {mesh: A.stl}", f"A: {{box: {box}}}")
    rest = [f for f in found if f.meaning == "rest" and f.severity == "error"]
    assert bool(rest) == touches
    if touches:
        assert rest[0].message == "cutter touches A at the start position"


def test_a_touch_at_the_zero_pose_only_is_a_warning(model: Callable[..., list[Finding]]) -> None:
    found = model("center: [0, 0, 300]", "center: [0, 0, 110]")
    (rest,) = (f for f in found if f.meaning == "rest" and f.pair == ("Z", "A"))
    assert rest.severity == "warning"
    assert rest.message == "Z touches A at the zero pose"


def test_a_body_inside_another_counts_as_touching(
    model: Callable[..., list[Finding]], tmp_path: Path
) -> None:
    around = "A: {box: {size: [30, 30, 100], center: [0, 0, 275]}}"
    (rest,) = (f for f in model("A: {mesh: A.stl}", around) if f.pair == ("cutter", "A"))
    assert "is inside, or around," in rest.message
    opened = shapes.box([30, 30, 100], [0, 0, 275])[1:]
    (tmp_path / "A.stl").write_bytes(stl_bytes(opened))
    found = [f for f in model() if f.code == "GC501"]
    assert {f.meaning for f in found} == {"mesh_open", "containment_undecided"}


def test_triangles_drawn_twice_are_counted(
    model: Callable[..., list[Finding]], tmp_path: Path
) -> None:
    box = shapes.box([100, 60, 20])
    (tmp_path / "A.stl").write_bytes(stl_bytes(np.concatenate([box, box[:3, [1, 2, 0]]])))
    (found,) = (f for f in model() if f.meaning == "mesh_repeated")
    assert found.code == "GC504"
    assert found.message.startswith("3 of 15 triangles")
    assert found.file.endswith("A.stl")


@pytest.mark.usefixtures("model")
def test_a_tool_table_leaves_the_holders_open(tmp_path: Path) -> None:
    (tmp_path / "m.yaml").write_text(SOUND)
    (tmp_path / "tool.tbl").write_text("T1 P1 Z60 D6 ;\nT2 P2 Z50 ;\n")
    found = lint(load_machine(str(tmp_path / "m.yaml"), tools=str(tmp_path / "tool.tbl")))
    tools = [(f.code, f.severity, f.tool, f.meaning) for f in found if f.tool is not None]
    assert tools == [
        ("GC421", "warning", 1, "tool_part_without_shape"),
        ("GC421", "warning", 2, "tool_without_shape"),
    ]


@pytest.mark.usefixtures("model")
def test_exit_codes_and_formats(tmp_path: Path) -> None:
    path = tmp_path / "m.yaml"

    def run(text: str, *args: str) -> tuple[int, str]:
        path.write_text(text)
        result = CliRunner().invoke(main, ["machine", "lint", str(path), *args])
        return result.exit_code, result.stdout

    assert run(SOUND) == (
        0,
        f"{path}: 0 errors, 0 warnings, 1 note\n"
        f"  note GC430 {path}:21: bed and Z stay at least 175 mm apart: the pair never meets\n",
    )
    code, out = run(SOUND.replace("axis: [0, 1, 0]", "axis: [0, 0, 1]"))
    assert code == 3
    assert out.splitlines()[0] == f"{path}: 0 errors, 1 warning, 1 note"
    assert out.splitlines()[1].startswith(f"  warning GC430 {path}:9: G43.4 and tilted planes")
    code, out = run(SOUND.replace("G28: {Z: 100}", "G28: {Z: 101}"), "--format", "json")
    report = json.loads(out)
    assert (code, report["schema"]) == (1, "gcodesim.lint/1")
    assert report["findings"][0]["code"] == "GC301"
    assert report["findings"][0]["line"] == 19
    assert run(SOUND.replace("name:", "nmae:"))[0] == 2
