"""Completion in shells, and the schemas that editors find for generated files."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.shell_completion import ShellComplete
from click.testing import CliRunner

from gcodesim.cli import main


def completed(*args: str) -> list[str]:
    """What completes the last of some arguments."""
    shell = ShellComplete(main, {}, "gcodesim", "_GCODESIM_COMPLETE")
    return [item.value for item in shell.get_completions(list(args[:-1]), args[-1])]


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_script_of_a_shell_asks_gcodesim(shell: str) -> None:
    done = CliRunner().invoke(main, ["completion", shell])
    assert done.exit_code == 0
    assert f"_GCODESIM_COMPLETE={shell}_complete" in done.output


def test_another_shell_is_refused() -> None:
    done = CliRunner().invoke(main, ["completion", "tcsh"])
    assert done.exit_code == 2
    assert "'tcsh' is not one of 'bash', 'zsh', 'fish'" in done.output


def test_machines_codes_and_kinds_are_known() -> None:
    assert completed("check", "part.nc", "--machine", "table_t") == ["table_tilt", "table_t"]
    assert completed("machine", "show", "nut") == ["nutating_head", "nut"]
    assert completed("machine", "new", "head") == ["head-table", "head-head"]
    assert completed("explain", "gc30") == ["GC301", "GC302", "GC303", "GC304"]
    assert completed("explain", "feed_miss") == ["feed_missing"]
    assert completed("check", "--ignore", "GC42")[:2] == ["GC420", "GC421"]
    assert completed("machine", "schema", "to") == ["tools"]


@pytest.mark.parametrize(
    ("command", "kind"),
    [
        (["machine", "new", "three-axis"], "machine"),
        (["tool", "new"], "tools"),
        (["setup", "new"], "setup"),
    ],
)
def test_a_file_to_begin_with_names_its_schema_that_lies_beside_it(
    command: list[str], kind: str, tmp_path: Path
) -> None:
    path = tmp_path / "mine.yaml"
    assert CliRunner().invoke(main, [*command, str(path)]).exit_code == 0
    first = path.read_text().splitlines()[0]
    assert first == f"# yaml-language-server: $schema={kind}.schema.json"
    schema = json.loads((tmp_path / f"{kind}.schema.json").read_text())
    printed = CliRunner().invoke(main, ["machine", "schema", kind])
    assert schema == json.loads(printed.output)
    (tmp_path / f"{kind}.schema.json").write_text("{}")
    again = [*command, str(tmp_path / "second.yaml")]
    assert CliRunner().invoke(main, again).exit_code == 0
    assert (tmp_path / f"{kind}.schema.json").read_text() == "{}"


def test_a_project_has_the_schema_of_its_setup(tmp_path: Path) -> None:
    done = CliRunner().invoke(main, ["init", str(tmp_path / "project")])
    assert done.exit_code == 0
    assert "setup.schema.json" in done.output
    first = (tmp_path / "project" / "setup.yaml").read_text().splitlines()[0]
    assert first == "# yaml-language-server: $schema=setup.schema.json"


def test_a_tool_table_in_inch_is_read_in_inch(tmp_path: Path) -> None:
    (tmp_path / "tool.tbl").write_text("T1 P1 Z4 D0.5 A3 ;end mill\n")
    args = ["tool", "import", str(tmp_path / "tool.tbl"), "--units", "inch"]
    text = CliRunner().invoke(main, args).stdout
    assert "length: 101.6" in text
    assert "diameter: 12.7" in text
    assert "A: 3" in text


def test_units_are_asked_of_no_other_library(tmp_path: Path) -> None:
    (tmp_path / "lib.json").write_text('{"data": []}')
    args = ["tool", "import", str(tmp_path / "lib.json"), "--units", "inch"]
    done = CliRunner().invoke(main, args)
    assert done.exit_code == 2
    assert "--units is for a LinuxCNC tool table (.tbl); others tell theirs" in done.output
