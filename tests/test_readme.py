"""README: its commands work, its output is the real one, its tables are whole."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import click
import pytest
import yaml
from click.testing import CliRunner
from option_table import commands, option_table, options, with_table

from gcodesim.checking.verdict import CONTRACT
from gcodesim.cli import main
from gcodesim.report.json_report import SCHEMA
from gcodesim.report.text import CONTRACT as REPORTED

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
GUIDE = (ROOT / ".github/CONTRIBUTING.md").read_text(encoding="utf-8")
SETUP = re.findall(r"^```sh\n(.*?)```$", README, re.MULTILINE | re.DOTALL)
RUNS = re.findall(r"^```console\n\$ gcodesim (.*?)\n(.*?)```$", README, re.MULTILINE | re.DOTALL)
ROWS = re.findall(r"^\| `gcodesim ?(.*?)` \| .* \| (.*) ?\|$", README, re.MULTILINE)


def words(usage: str) -> tuple[str, ...]:
    """The command words of a usage line: ``machine show`` of ``machine show M.yaml``."""
    return tuple(word for word in usage.split() if re.fullmatch("[a-z]+(-[a-z]+)*", word))


def test_two_setup_commands_of_one_line_each() -> None:
    assert len(SETUP) == 2
    for command in SETUP:
        assert command.count("\n") == 1
        assert command.startswith("python3 -m venv .venv && .venv/bin/pip install -q ")
    assert "gcodesim check samples/part.nc" in SETUP[0]
    assert "pytest" in SETUP[1]


def test_ci_runs_the_test_command_of_the_readme_with_the_slow_tests() -> None:
    script = (ROOT / ".ci/run").read_text(encoding="utf-8").splitlines()
    assert f'{SETUP[1].strip()} -m "" -rs' in script


def test_the_workflow_runs_the_script_on_the_oldest_and_the_newest_python() -> None:
    workflow = yaml.safe_load((ROOT / ".github/workflows/ci.yml").read_text(encoding="utf-8"))
    (job,) = workflow["jobs"].values()
    assert [step["run"] for step in job["steps"] if "run" in step] == [".ci/run"]
    assert job["strategy"]["matrix"] == {"python": ["3.11", "3.14"]}
    assert job["container"] == "python:${{ matrix.python }}-bookworm"


def test_the_sample_of_the_setup_command_passes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    args = shlex.split(SETUP[0].rpartition("gcodesim ")[2])
    result = CliRunner().invoke(main, args)
    assert result.exit_code == 0, result.output
    assert result.stdout.startswith("PASS  samples/part.nc on table_tilt")


def test_the_shown_run_prints_what_the_readme_shows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    assert len(RUNS) == 1
    for command, shown in RUNS:
        result = CliRunner().invoke(main, [*shlex.split(command), "--device", "cpu"])
        assert result.exit_code == 1
        assert result.stdout == shown


def test_the_contract_is_the_same_everywhere() -> None:
    assert f"**{CONTRACT}**" in README
    help_text = CliRunner().invoke(main, ["--help"]).stdout
    assert CONTRACT in " ".join(help_text.split())
    assert REPORTED is CONTRACT
    assert all(f"  {CONTRACT}\n" in shown for _, shown in RUNS)


def test_every_command_and_option_is_documented_and_no_other() -> None:
    documented = {words(usage): set(re.findall(r"--[a-z-]+", row)) for usage, row in ROWS}
    assert documented == {path: set(options(command)) for path, command in commands()}


def test_the_table_of_options_is_the_one_that_the_commands_make() -> None:
    """After a change: python tests/option_table.py."""
    assert option_table() in README
    assert with_table(README) == README


def test_a_new_option_is_in_the_table_at_once() -> None:
    option = click.Option(["--speed"], metavar="N", default=3, show_default=True, help="How fast.")
    main.commands["trace"].params.append(option)
    try:
        assert "| `--speed N` | `trace`: How fast. Default: `3`. | |\n" in option_table()
    finally:
        main.commands["trace"].params.remove(option)


def test_every_choice_is_named() -> None:
    for _, command in commands():
        for parameter in command.params:
            if isinstance(parameter.type, click.Choice):
                for choice in parameter.type.choices:
                    assert f"`{choice}`" in README, f"{parameter.name}: {choice}"


@pytest.mark.parametrize("path", sorted(set(re.findall(r"`([\w.]+/[\w./]*)`", README + GUIDE))))
def test_files_that_are_named_exist(path: str) -> None:
    assert (ROOT / path).exists() or path == SCHEMA
