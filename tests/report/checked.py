"""Checked samples for the tests of pictures: each is checked once."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

from gcodesim.checking.flow import check_program
from gcodesim.checking.options import Options
from gcodesim.checking.replay import Replay
from gcodesim.checking.verdict import CheckResult
from gcodesim.machine.loading import load_machine

SAMPLES = Path(__file__).parents[2] / "samples"

HOSTILE = "(</script><script>document.title = 'taken'</script> @data@ \N{GREEK SMALL LETTER OMEGA})"
"""A comment that would be run as a script where text is taken for markup."""


@cache
def crash() -> tuple[CheckResult, Replay]:
    """The cradle of `table_tilt` rises into the holder at 2.009 s, in line 17."""
    text = (SAMPLES / "tilt_into_holder.nc").read_text()
    text = text.replace("%\n", f"%\n{HOSTILE}\n", 1)
    return _checked(text, "tilt.nc")


@cache
def tools() -> tuple[CheckResult, Replay]:
    """Two tools one after the other, and turns of more than half a circle."""
    text = "G21 G90 G0\nT1 M6\nC400.\nT2 M6\nC-100. X5.\nA-20.\nM30\n"
    return _checked(text, "tools.nc", str(Path(__file__).with_name("tools.yaml")))


@cache
def near() -> tuple[CheckResult, Replay]:
    """A finishing path on `table_tilt` that never touches, and comes to 3.21 mm of the table."""
    return _checked(
        (SAMPLES / "five_axis_finish.nc").read_text(), "near.nc", period_ps=10**9, clearance=7.0
    )


def _checked(
    text: str, name: str, tools: str | None = None, **options: Any
) -> tuple[CheckResult, Replay]:
    machine = load_machine("table_tilt", tools=tools)
    result = check_program(text, name, machine, Options(device="cpu", minimum=True, **options))
    assert result.replay is not None
    return result, result.replay
