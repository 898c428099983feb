"""What several commands share: the model of options as options of click, programs, progress."""

from __future__ import annotations

import math
import re
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, NoReturn, TypeVar

import click

from gcodesim.checking.option_kinds import (
    Count,
    Device,
    DialectName,
    Number,
    OneOf,
    OptionKind,
    Period,
    Shard,
    Switch,
)
from gcodesim.checking.options import OptionField
from gcodesim.checking.verdict import EXIT_CODES
from gcodesim.cli.completion import codes, machines
from gcodesim.cli.run_options import MODEL, of_command, run_options
from gcodesim.constants import PS_PER_S
from gcodesim.errors import UsageError
from gcodesim.findings.codes import FAIL, INCONCLUSIVE, Finding
from gcodesim.input_file import read_stream

Decorated = TypeVar("Decorated", bound=Callable[..., Any])

COMPLETED = {"machine": machines, "select": codes, "ignore": codes}
"""Option -> what completes its values."""

UNITS_PS = {"s": PS_PER_S, "ms": PS_PER_S // 1000, "us": PS_PER_S // 1_000_000}


def every_option(command: str) -> Callable[[Decorated], Decorated]:
    """Add all options that the model gives to a command."""
    return _with(list(of_command(command).values()))


def options_named(*fields: str) -> Callable[[Decorated], Decorated]:
    """Add options of the model, by the names of their fields, to a command with others."""
    return _with([each for each in MODEL if each.field in fields])


def language_options(command: Decorated) -> Decorated:
    """Add what says how the control reads a program."""
    return _with([each for each in MODEL if each.option.language])(command)


def language_of(given: Mapping[str, Any]) -> tuple[str | None, float | None, bool, int | None]:
    """What `control_for` takes, of the values of a command with `language_options`."""
    return run_options(given).asked.options.language


def machine_option(
    left_out: str = "", default: str | None = None
) -> Callable[[Decorated], Decorated]:
    """Add --machine for a command with one machine.

    Args:
        left_out: what happens without it.
        default: machine that is taken then.
    """
    text = f"Machine file, or the name of a shipped machine.{left_out and f' Left out: {left_out}'}"
    return click.option(
        "--machine",
        "machine_path",
        default=default,
        show_default=default is not None,
        metavar="M.yaml",
        help=text,
        shell_complete=machines,
    )


def _with(wanted: Sequence[OptionField]) -> Callable[[Decorated], Decorated]:
    def add(command: Decorated) -> Decorated:
        for each in reversed(wanted):
            command = _click_option(each)(command)
        return command

    return add


def _click_option(each: OptionField) -> Callable[[Decorated], Decorated]:
    """An option of the model as one of click; its value is that of the field."""
    option, name = each.option, f"--{each.option.name}"
    more: dict[str, Any] = {"help": option.help, "metavar": option.metavar or None}
    more |= {"shell_complete": COMPLETED[option.name]} if option.name in COMPLETED else {}
    match option.kind:
        case Switch(words=None, negative=no):
            flag = {"default": None} if no else {"is_flag": True}
            return click.option(each.field, f"{name}/--{no}" if no else name, **more, **flag)
        case Switch(words=(off, on)) as kind:
            words = (on, off) if each.default else (off, on)
            more |= {"type": WordSwitch(words, on), "default": kind.written(each.default)}
        case Period() as kind:
            more |= {"type": period, "default": kind.written(each.default)}
        case Shard() as kind:
            more |= {"type": shard, "default": kind.written(each.default)}
        case kind:
            more |= {"type": _type(kind), "default": each.default or None}
    more["show_default"] = more["default"] is not None and not isinstance(option.kind, Shard)
    return click.option(each.field, name, multiple=option.many, **more)


def _type(kind: OptionKind) -> Any:
    """What click reads values of a kind with."""
    match kind:
        case OneOf(words=words) | DialectName(words=words):
            return click.Choice(words)
        case Number(above_zero=above_zero):
            return FiniteRange(min=0, min_open=above_zero)
        case Count(low=low):
            return click.IntRange(min=low)
        case Device():
            return device
    return str


class WordSwitch(click.Choice[str]):
    """Two words for False and True."""

    def __init__(self, words: Sequence[str], on: str) -> None:
        super().__init__(words)
        self.on = on

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        """Whether it is the word for True."""
        return super().convert(value, param, ctx) == self.on


def period(text: str) -> int:
    """A time with its unit, `0.1ms`, `100us` or `1e-4s`, as a count of picoseconds."""
    match = re.fullmatch(r"\s*((?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d{1,2})?)\s*(s|ms|us)\s*", text)
    count = round(float(match[1]) * UNITS_PS[match[2]]) if match else 0
    if not Period().fits(count):
        raise click.BadParameter(f"{text!r}: expected a time from 1us to 10s, such as 0.1ms")
    return count


def device(text: str) -> str:
    """The name of a device; whether there is one is asked where it is used."""
    if not Device().fits(text):
        raise click.BadParameter(f"{text!r}: expected {Device().right}")
    return text


def shard(text: str) -> tuple[int, int]:
    """Part I of N of a batch, such as `2/5`, as two numbers."""
    index, _, count = text.partition("/")
    part = (int(index), int(count)) if index.isdecimal() and count.isdecimal() else (0, 0)
    if not Shard().fits(part):
        raise click.BadParameter(f"{text!r}: expected {Shard().right}")
    return part


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
        if sys.stdin is None:
            raise UsageError("-: standard input is closed")
        try:
            return "<stdin>", decode(read_stream(sys.stdin.buffer))
        except OSError as error:
            raise UsageError(f"-: cannot be read: {error.strerror}") from error
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
