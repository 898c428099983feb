"""`time: auto`: blocks keep the limits that every joint has, and reports say what is missing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner

from gcodesim.cli import main
from gcodesim.errors import ModelError
from gcodesim.machine.loading import load_machine

Change = Callable[[str, str], str]


@pytest.fixture
def auto(changed: Change) -> str:
    return changed("name: tiny", "name: tiny\ntime: auto")


def give(path: str, key: str, value: int, but: str = "none") -> None:
    """Give every joint a limit, but for one."""
    lines = Path(path).read_text().splitlines()
    changed = [
        line if f"  {but}:" in line else line.replace("rapid:", f"{key}: {value}, rapid:")
        for line in lines
    ]
    Path(path).write_text("\n".join(changed))


def test_without_accelerations_blocks_run_at_constant_speed_and_the_report_says_so(
    auto: str,
) -> None:
    give(auto, "max_acceleration", 4000, but="C")
    machine = load_machine(auto)
    assert machine.time == "constant"
    line = "time: blocks run at constant speed: C without `max_acceleration`"
    assert line in machine.unchecked_by_rule
    program = Path(auto).with_name("part.nc")
    program.write_text("G21 G90 G17 G54\nS1000 M3\nG1 X5. F500.\nM30\n")
    args = ["check", str(program), "--machine", auto, "--device", "cpu", "--sample-period", "10ms"]
    assert line in CliRunner().invoke(main, args).output


def test_with_every_acceleration_they_are_kept_and_with_every_jerk_that_too(auto: str) -> None:
    give(auto, "max_acceleration", 4000)
    machine = load_machine(auto)
    assert machine.time == "acceleration"
    assert "without a limit of jerk: Y, X, A, C, Z without `max_jerk`" in str(
        machine.unchecked_by_rule
    )
    give(auto, "max_jerk", 50000)
    machine = load_machine(auto)
    assert machine.time == "jerk"
    assert "time:" not in str(machine.unchecked_by_rule)


def test_another_word_is_an_error_with_its_line(changed: Change) -> None:
    with pytest.raises(ModelError) as caught:
        load_machine(changed("name: tiny", "name: tiny\ntime: automatic"))
    assert "tiny.yaml:2: time" in str(caught.value)
    assert "'auto'" in str(caught.value)
