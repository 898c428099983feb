"""The command line: commands, options, exit codes; the only file that knows click."""

from __future__ import annotations

import functools
import json
import re
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import click

from gcodesim import __version__
from gcodesim.constants import DEFAULT_PERIOD_PS, PS_PER_S
from gcodesim.errors import UsageError
from gcodesim.verdict import CONTRACT, EXIT_CODES, INTERRUPT_EXIT, USAGE_EXIT, worst_exit

if TYPE_CHECKING:
    from gcodesim.verdict import CheckResult

UNITS_PS = {"s": PS_PER_S, "ms": PS_PER_S // 1000, "us": PS_PER_S // 1_000_000}
DIALECT = click.Choice(["fanuc", "haas", "linuxcnc"])


class Period(click.ParamType[int]):
    """A time with its unit, as an integer count of picoseconds."""

    name = "time"

    def convert(self, value: Any, param: Any, ctx: Any) -> int:
        """Parse `0.1ms`, `100us` or `1e-4s`."""
        if isinstance(value, int):
            return value
        match = re.fullmatch(r"\s*([0-9.]+(?:[eE][-+]?\d+)?)\s*(s|ms|us)\s*", str(value))
        try:
            period = round(float(match[1]) * UNITS_PS[match[2]]) if match else 0
        except ValueError:
            period = 0
        if not 1_000_000 <= period <= 10 * PS_PER_S:
            self.fail(f"{value!r}: expected a time from 1us to 10s, such as 0.1ms", param, ctx)
        return period


def exits_cleanly(command: Callable[..., Any]) -> Callable[..., Any]:
    """Turn errors of gcodesim and Ctrl-C into their exit codes."""

    @functools.wraps(command)
    def run(*args: Any, **kwargs: Any) -> Any:
        try:
            return command(*args, **kwargs)
        except UsageError as error:
            click.echo(f"gcodesim: {error}", err=True)
            sys.exit(USAGE_EXIT)
        except KeyboardInterrupt:
            click.echo("gcodesim: interrupted; nothing was decided", err=True)
            sys.exit(INTERRUPT_EXIT)

    return run


class Group(click.Group):
    """A group whose commands end with the exit codes of the contract."""

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command."""
        return exits_cleanly(super().invoke)(ctx)


@click.group(cls=Group, epilog=CONTRACT, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="gcodesim")
def main() -> None:
    """Find the first collision of a five-axis machine tool running an NC program.

    Exit codes: 0 PASS, 1 FAIL, 3 INCONCLUSIVE, 2 the command could not be carried out,
    130 interrupted.
    """


@main.command()
@click.argument("programs", nargs=-1, required=True, metavar="PROGRAM...")
@click.option(
    "--machine",
    "machine_path",
    metavar="M.yaml",
    help="Machine file, or the name of a shipped machine. Left out: the one the setup names.",
)
@click.option("--setup", metavar="FILE", help="Setup file: offsets, fixtures, part, stock, tools.")
@click.option("--tools", metavar="FILE", help="Tools file (YAML) or LinuxCNC tool table (.tbl).")
@click.option(
    "--dialect",
    type=DIALECT,
    help="How the control reads the program. Left out: as the machine file says.",
)
@click.option(
    "--feed",
    type=click.FloatRange(min=0, min_open=True),
    metavar="MM/MIN",
    help="Feed until the first F word. Left out: a feed move before any F is an error.",
)
@click.option("--block-delete", is_flag=True, help="Leave out blocks that begin with /.")
@click.option(
    "--sample-period",
    type=Period(),
    default=DEFAULT_PERIOD_PS,
    show_default="0.1ms",
    help="Time between samples, with its unit.",
)
@click.option(
    "--method",
    type=click.Choice(["exhaustive", "paper"]),
    default="exhaustive",
    show_default=True,
    help="exhaustive: every sample, certified; paper: the seed paper's way, for comparison.",
)
@click.option(
    "--device",
    default="auto",
    show_default=True,
    metavar="auto|cpu|cuda[:N]",
    help="Where to compute; auto takes CUDA when present.",
)
@click.option(
    "--format",
    "report_format",
    type=click.Choice(["text", "json"]),
    default="text",
    show_default=True,
    help="Form of the report on standard output.",
)
@click.option(
    "--allow-outside",
    is_flag=True,
    help="Mesh files may lie outside the folder of the machine file.",
)
@click.option("--quiet", is_flag=True, help="No progress, no notes.")
@click.option("--no-color", is_flag=True, help="No colours; NO_COLOR does the same.")
def check(programs: tuple[str, ...], **given: Any) -> None:
    """Check PROGRAMs: does the machine hit itself? `-` reads standard input."""
    from gcodesim.check import Options, check_program
    from gcodesim.machine.loading import load_machine

    machine = load_machine(
        _machine_path(given["machine_path"], given["setup"]),
        tools=given["tools"],
        setup=given["setup"],
        allow_outside=given["allow_outside"],
    )
    options = Options(
        dialect=given["dialect"],
        feed=given["feed"],
        period_ps=given["sample_period"],
        device=given["device"],
        method=given["method"],
        block_delete=given["block_delete"],
    )
    results = []
    for program in programs:
        name, text = _read_program(program)
        with _progress(name, given["quiet"]) as progress:
            results.append(check_program(text, name, machine, options, progress))
        if given["report_format"] == "text":
            _print_reports(results[-1:], "text", given["no_color"])
    if given["report_format"] == "json":
        _print_reports(results, "json", given["no_color"])
    sys.exit(worst_exit([EXIT_CODES[result.verdict] for result in results]))


@main.command()
@click.argument("program")
@click.option(
    "--machine",
    "machine_path",
    metavar="M.yaml",
    help="Machine file: offsets, tools, "
    "reference points. Left out: a control with everything at zero.",
)
@click.option("--tools", metavar="FILE", help="Tools file (YAML) or LinuxCNC tool table (.tbl).")
@click.option("--dialect", type=DIALECT, help="How the control reads the program.")
@click.option(
    "--feed",
    type=click.FloatRange(min=0, min_open=True),
    metavar="MM/MIN",
    help="Feed until the first F word.",
)
@click.option("--block-delete", is_flag=True, help="Leave out blocks that begin with /.")
def canon(program: str, machine_path: str | None, tools: str | None, **given: Any) -> None:
    """Print PROGRAM as canonical commands, JSON Lines in machine millimetres and degrees."""
    from gcodesim.findings import FAIL, INCONCLUSIVE
    from gcodesim.machine.control import bare_control, control_for
    from gcodesim.machine.loading import load_machine
    from gcodesim.nc.canon import write_canon
    from gcodesim.nc.interpreter import interpret

    choices = (given["dialect"], given["feed"], given["block_delete"])
    if machine_path:
        control = control_for(load_machine(machine_path, tools=tools), *choices)
    else:
        control = bare_control(tools, *choices)
    name, text = _read_program(program)
    meaning = interpret(text, control, name)
    write_canon(meaning, sys.stdout)
    effects = {finding.effect for finding in meaning.findings}
    sys.exit(EXIT_CODES.get(next((e for e in (FAIL, INCONCLUSIVE) if e in effects), "pass"), 0))


@main.group()
def machine() -> None:
    """Look at machine files."""


@machine.command()
@click.argument("path", metavar="M.yaml")
@click.option("--setup", metavar="FILE", help="Setup file.")
@click.option("--tools", metavar="FILE", help="Tools file or LinuxCNC tool table.")
@click.option("--allow-outside", is_flag=True, help="Mesh files may lie outside the folder.")
def show(path: str, setup: str | None, tools: str | None, allow_outside: bool) -> None:
    """Print the kinematic tree, bodies, pairs and tools of a machine."""
    from gcodesim.machine.describe import describe
    from gcodesim.machine.loading import load_machine

    click.echo(describe(load_machine(path, setup=setup, tools=tools, allow_outside=allow_outside)))


@machine.command()
@click.argument("kind", type=click.Choice(["machine", "tools", "setup"]), default="machine")
def schema(kind: str) -> None:
    """Print the JSON Schema of machine, tools or setup files."""
    from gcodesim.machine.describe import schema_json

    click.echo(json.dumps(schema_json(kind), indent=2))


def _machine_path(machine: str | None, setup: str | None) -> str:
    """The machine file that was given, or the one that the setup names."""
    from gcodesim.machine.setup import read_setup

    path = machine or (read_setup(setup).machine if setup else None)
    if path is None:
        raise UsageError("no machine: give --machine M.yaml, or a --setup that names one")
    return path


def _read_program(path: str) -> tuple[str, str]:
    """Name and text of a program; `-` is standard input."""
    from gcodesim.nc.reader import decode, read_program

    if path == "-":
        return "<stdin>", decode(sys.stdin.buffer.read())
    return path, read_program(path)


@contextmanager
def _progress(name: str, quiet: bool) -> Iterator[Callable[[float], None]]:
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


def _print_reports(results: list[CheckResult], report_format: str, no_color: bool) -> None:
    """Print what was checked; several programs are one JSON array."""
    if report_format == "json":
        from gcodesim.report.json_report import report_dict

        reports = [report_dict(result) for result in results]
        shown = reports[0] if len(reports) == 1 else reports
        click.echo(json.dumps(shown, indent=2, ensure_ascii=False))
        return
    from rich.console import Console

    from gcodesim.report.text import print_report

    console = Console(no_color=no_color or None, highlight=False, soft_wrap=True)
    for result in results:
        print_report(result, console)
