"""`setup new`, and `init` with a machine and tools of one's own: what they write can be checked."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from machine.libraries import fusion_text, fusion_tool

from gcodesim.checking.lint import lint
from gcodesim.cli import main
from gcodesim.cli.machine import KINDS
from gcodesim.machine.loading import load_machine
from gcodesim.machine.placing import WorkFrames, extent

PROGRAM = """\
G21 G90 G17 G54
T1 M6
S1000 M3
G0 G43 H1 X0 Y0 Z20
G1 Z2 F500
X-10
G0 Z20
G49
M30
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*args: str) -> Result:
    return CliRunner().invoke(main, list(args))


@pytest.mark.parametrize("kind", KINDS)
def test_the_setup_of_any_machine_lints_clean_with_its_zero_on_the_part(
    folder: Path, kind: str
) -> None:
    assert run("machine", "new", kind, "mine.yaml").exit_code == 0
    assert run("setup", "new", "jobs.yaml", "--machine", "mine.yaml").exit_code == 0
    machine = load_machine("mine.yaml", setup="jobs.yaml")
    assert [f for f in lint(machine) if f.severity != "note"] == []
    part = machine.bodies["part"]
    low, high = extent(part.parts, WorkFrames.of(machine).zero_point(1, part.link))
    np.testing.assert_allclose((low + high)[:2], 0.0, atol=1e-6)
    assert high[2] == pytest.approx(0.0, abs=1e-6)
    again = run("setup", "new", "jobs.yaml", "--machine", "mine.yaml")
    assert again.exit_code == 2
    assert "there is such a file already" in again.output


def test_a_setup_names_its_files_from_its_own_folder(folder: Path) -> None:
    (folder / "jobs").mkdir()
    (folder / "shop.json").write_text(fusion_text(fusion_tool()))
    run("machine", "new", "three-axis", "mine.yaml")
    args = ("--machine", "mine.yaml", "--tools", "shop.json")
    assert run("setup", "new", "jobs/first.yaml", *args).exit_code == 0
    text = (folder / "jobs" / "first.yaml").read_text()
    assert "machine: ../mine.yaml\n" in text
    assert "tools: ../shop.json\n" in text


def test_a_machine_without_a_table_is_told_what_to_write(folder: Path) -> None:
    run("machine", "new", "three-axis", "mine.yaml")
    text = (folder / "mine.yaml").read_text()
    cut = text[: text.index("\nwork:")] + text[text.index("\nreference:") :]
    (folder / "mine.yaml").write_text(cut)
    refused = run("setup", "new", "jobs.yaml", "--machine", "mine.yaml")
    assert refused.exit_code == 2
    assert "write `work: {link: ...}`" in refused.output


@pytest.mark.parametrize("library", [True, False])
def test_a_project_with_ones_own_machine_and_tools_is_checked_at_once(
    folder: Path, library: bool
) -> None:
    run("machine", "new", "three-axis", "mine.yaml")
    (folder / "shop.json").write_text(fusion_text(fusion_tool()))
    run("tool", "import", "shop.json", "--out", "shop.yaml")
    tools = "shop.json" if library else "shop.yaml"
    done = run("init", "project", "--machine", "mine.yaml", "--tools", tools)
    assert done.exit_code == 0, done.output
    place = "tools.yaml" if library else "tools/shop.yaml"
    assert {"machines/mine.yaml", "setup.yaml", place} <= set(done.stdout.split())
    assert not (folder / "project" / "programs").exists()
    (folder / "project" / "programs").mkdir()
    (folder / "project" / "programs" / "first.nc").write_text(PROGRAM)
    checked = run("check", "project/programs/first.nc", "--setup", "project/setup.yaml",
                  "--device", "cpu", "--sample-period", "10ms")  # fmt: skip
    assert checked.exit_code == 0, checked.output


def test_init_takes_the_meshes_of_a_machine_along(folder: Path) -> None:
    done = run("init", "project", "--machine", "head_tilt")
    assert done.exit_code == 0
    assert (folder / "project" / "machines" / "head_tilt").is_dir()
    assert load_machine("project/machines/head_tilt.yaml", setup="project/setup.yaml").bodies[
        "vise"
    ]
