"""Options and habits that several commands share: times, numbers, programs, the progress bar."""

from __future__ import annotations

import math
import re
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NoReturn

import click

from gcodesim.checking.verdict import EXIT_CODES
from gcodesim.constants import PS_PER_S
from gcodesim.errors import UsageError
from gcodesim.findings.codes import FAIL, INCONCLUSIVE, Finding
from gcodesim.nc.control.readings import ROWS

UNITS_PS = {"s": PS_PER_S, "ms": PS_PER_S // 1000, "us": PS_PER_S // 1_000_000}
DIALECT = click.Choice([*ROWS])


def language_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """How the control reads a program: --dialect, --feed, --block-delete, --max-blocks."""
    for option in (
        click.option(
            "--max-blocks",
            type=click.IntRange(min=1),
            metavar="N",
            help="Blocks after which the program counts as endless. Left out: 100 million, or 5 "
            "million that loops and calls repeat.",
        ),
        click.option("--block-delete", is_flag=True, help="Leave out blocks that begin with /."),
        click.option(
            "--feed",
            type=FiniteRange(min=0, min_open=True),
            metavar="MM/MIN",
            help="Feed until the first F word. Left out: a feed move before any F is an error.",
        ),
        click.option(
            "--dialect",
            type=DIALECT,
            help="How the control reads the program. Left out: as the machine file says.",
        ),
    ):
        command = option(command)
    return command


def period(text: str) -> int:
    """A time with its unit, `0.1ms`, `100us` or `1e-4s`, as a count of picoseconds."""
    match = re.fullmatch(r"\s*((?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,2})?)\s*(s|ms|us)\s*", text)
    count = round(float(match[1]) * UNITS_PS[match[2]]) if match else 0
    if not 1_000_000 <= count <= 10 * PS_PER_S:
        raise click.BadParameter(f"{text!r}: expected a time from 1us to 10s, such as 0.1ms")
    return count


def device(text: str) -> str:
    """The name of a device; whether there is one is asked where it is used."""
    if not re.fullmatch(r"auto|cpu|cuda(:\d+)?", text):
        raise click.BadParameter(f"{text!r}: expected auto, cpu, cuda or cuda:N")
    return text


def period_text(picoseconds: int) -> str:
    """A period as `period` reads it."""
    return f"{picoseconds / UNITS_PS['ms']:g}ms"


class FiniteRange(click.FloatRange):
    """A range of numbers: not a number and infinity, which compare oddly, are refused."""

    def convert(self, value: Any, param: Any, ctx: Any) -> float:
        """Parse a finite number within the range."""
        number = float(super().convert(value, param, ctx))
        if not math.isfinite(number):
            self.fail(f"{value!r}: expected a finite number, such as 2.5", param, ctx)
        return number


def machine_path_of(machine: str | None, setup: str | None) -> str:
    """The machine file that was given, or the one that the setup names."""
    from gcodesim.machine.setup import read_setup

    path = machine or (read_setup(setup).machine if setup else None)
    if path is None:
        raise UsageError("no machine: give --machine M.yaml, or a --setup that names one")
    return path


def read_text(path: str) -> tuple[str, str]:
    """Name and text of a program; `-` is standard input."""
    from gcodesim.nc.lines import decode, read_program

    if path == "-":
        return "<stdin>", decode(sys.stdin.buffer.read())
    return path, read_program(path)


def exit_with(name: str, findings: Sequence[Finding]) -> NoReturn:
    """Exit with the code of a program's findings, and say which of them decides."""
    deciding = [f for effect in (FAIL, INCONCLUSIVE) for f in findings if f.effect == effect]
    if not deciding:
        sys.exit(0)
    finding = deciding[0]
    line = "" if finding.line is None else f":{finding.line}"
    click.echo(f"{finding.file or name}{line}: {finding.code} {finding.message}", err=True)
    sys.exit(EXIT_CODES[finding.effect])


@contextmanager
def progress_bar(name: str, quiet: bool) -> Iterator[Callable[[float], None]]:
    """A progress bar on stderr, shown after a second, and only on a terminal."""
    if quiet or not sys.stderr.isatty():
        yield lambda fraction: None
        return
    from rich.console import Console
    from rich.progress import Progress

    bar = Progress(console=Console(stderr=True), transient=True)
    task = bar.add_task(f"checking {name}", total=1.0)
    begin = time.monotonic()

    def advance(fraction: float) -> None:
        if time.monotonic() - begin > 1.0:
            bar.start()
        bar.update(task, completed=fraction)

    try:
        yield advance
    finally:
        bar.stop()
