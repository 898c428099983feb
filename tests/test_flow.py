"""What a check says on the way: that kernels are being compiled, only when they are."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from gcodesim.checking import flow
from gcodesim.checking.options import Options
from gcodesim.cli import main
from gcodesim.collision import detector
from gcodesim.machine.loading import load_machine
from gcodesim.nc.lines import read_program

SAMPLE = Path(__file__).parents[1] / "samples/tilt_into_holder.nc"


def test_kernels_that_take_long_to_load_are_told_once(monkeypatch: pytest.MonkeyPatch) -> None:
    noticed, lines, load = threading.Event(), list[str](), detector.load_kernels

    def notice(line: str) -> None:
        lines.append(line)
        noticed.set()

    def slow(method: str, device: str, stop_all: bool) -> tuple[str, ...]:
        assert noticed.wait(60.0)
        return load(method, device, stop_all)

    given: Any = read_program(SAMPLE), "a.nc", load_machine("table_tilt"), Options(device="cpu")
    flow.check_program(*given, notice=notice)
    assert lines == []
    monkeypatch.setattr(flow, "COMPILING_S", 0.0)
    monkeypatch.setattr(detector, "load_kernels", slow)
    flow.check_program(*given, notice=notice)
    assert lines == ["compiling kernels, once: about 20 s"]


@pytest.mark.parametrize("quiet", [[], ["--quiet"]])
def test_the_command_tells_it_beside_the_report_unless_quiet(
    quiet: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    check = flow.check_program

    def slow(*given: Any) -> Any:
        given[-1]("compiling")
        return check(*given)

    monkeypatch.setattr(flow, "check_program", slow)
    result = CliRunner().invoke(main, ["check", str(SAMPLE), "--machine", "table_tilt", *quiet])
    assert result.stdout.startswith("FAIL")
    assert result.stderr == ("" if quiet else "gcodesim: compiling\n")
