"""The command line: commands, options, exit codes; the only file that knows click."""

from __future__ import annotations

import functools
import json
import math
import os
import re
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Literal

import click

from gcodesim import __version__
from gcodesim.constants import PS_PER_S
from gcodesim.errors import UsageError
from gcodesim.verdict import CONTRACT, EXIT_CODES, INTERRUPT_EXIT, USAGE_EXIT, worst_exit

if TYPE_CHECKING:
    from gcodesim.verdict import CheckResult

UNITS_PS = {"s": PS_PER_S, "ms": PS_PER_S // 1000, "us": PS_PER_S // 1_000_000}
DIALECT = click.Choice(["fanuc", "haas", "linuxcnc"])


def period(text: str) -> int:
    """A time with its unit, `0.1ms`, `100us` or `1e-4s`, as a count of picoseconds."""
    match = re.fullmatch(r"\s*((?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,2})?)\s*(s|ms|us)\s*", text)
    count = round(float(match[1]) * UNITS_PS[match[2]]) if match else 0
    if not 1_000_000 <= count <= 10 * PS_PER_S:
        raise click.BadParameter(f"{text!r}: expected a time from 1us to 10s, such as 0.1ms")
    return count


class FiniteRange(click.FloatRange):
    """A range of numbers: not a number and infinity, which compare oddly, are refused."""

    def convert(self, value: Any, param: Any, ctx: Any) -> float:
        """Parse a finite number within the range."""
        number = float(super().convert(value, param, ctx))
        if not math.isfinite(number):
            self.fail(f"{value!r}: expected a finite number, such as 2.5", param, ctx)
        return number


def exits_cleanly(command: Callable[..., Any]) -> Callable[..., Any]:
    """Turn errors and Ctrl-C into their exit codes: a crash must not look like FAIL, which is 1."""

    @functools.wraps(command)
    def run(*args: Any, **kwargs: Any) -> Any:
        try:
            return command(*args, **kwargs)
        except (click.ClickException, click.exceptions.Exit, click.Abort, BrokenPipeError):
            raise
        except (UsageError, OSError) as error:
            click.echo(f"gcodesim: {error}", err=True)
            sys.exit(USAGE_EXIT)
        except KeyboardInterrupt:
            click.echo("gcodesim: interrupted; what has no report is not decided", err=True)
            sys.exit(INTERRUPT_EXIT)
        except Exception:
            traceback.print_exc()
            click.echo("gcodesim: a defect of gcodesim, please report it", err=True)
            sys.exit(USAGE_EXIT)

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
    type=FiniteRange(min=0, min_open=True),
    metavar="MM/MIN",
    help="Feed until the first F word. Left out: a feed move before any F is an error.",
)
@click.option("--block-delete", is_flag=True, help="Leave out blocks that begin with /.")
@click.option(
    "--max-blocks",
    type=click.IntRange(min=1),
    metavar="N",
    help="Blocks after which the program counts as endless. Left out: 100 million.",
)
@click.option(
    "--rapids",
    type=click.Choice(["linear", "dogleg"]),
    help="Way of rapid moves: straight, or every axis at its own rate. Left out: as the machine "
    "file says.",
)
@click.option(
    "--sample-period",
    type=period,
    default="0.1ms",
    show_default=True,
    metavar="TIME",
    help="Time between samples, with its unit.",
)
@click.option(
    "--method",
    type=click.Choice(["search", "exhaustive", "paper"]),
    default="search",
    show_default=True,
    help="search: proves stretches of time free; exhaustive: every sample, certified; paper: the "
    "seed paper's way, for comparison. All find the same first contact at samples.",
)
@click.option(
    "--between-samples",
    type=click.Choice(["on", "off"]),
    default="on",
    show_default=True,
    help="Prove the time between the samples too (method search).",
)
@click.option(
    "--clearance",
    type=FiniteRange(min=0),
    metavar="MM",
    help="Distance every pair must keep, instead of what the machine file says.",
)
@click.option("--min-clearance", is_flag=True, help="Report how near every pair comes, and where.")
@click.option(
    "--stop",
    type=click.Choice(["first", "all"]),
    default="first",
    show_default=True,
    help="Stop at the first contact, or list every stretch of contact.",
)
@click.option("--audit", is_flag=True, help="Check again with nothing left out, and compare.")
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
@click.option("--quiet", is_flag=True, help="No progress bar.")
@click.option("--no-color", is_flag=True, help="No colours; NO_COLOR does the same.")
def check(programs: tuple[str, ...], **given: Any) -> None:
    """Check PROGRAMs: does the machine hit itself? `-` reads standard input."""
    _refuse_search_options(given)
    from gcodesim.check import Options, check_program
    from gcodesim.machine.loading import load_machine
    from gcodesim.nc.control import MAX_BLOCKS

    machine = load_machine(
        _machine_path(given["machine_path"], given["setup"]),
        tools=given["tools"],
        setup=given["setup"],
        allow_outside=given["allow_outside"],
    )
    machine = replace(machine, rapids=given["rapids"] or machine.rapids)
    options = Options(
        dialect=given["dialect"],
        feed=given["feed"],
        period_ps=given["sample_period"],
        device=given["device"],
        method=given["method"],
        between=given["between_samples"] == "on",
        clearance=given["clearance"],
        minimum=given["min_clearance"],
        stop_all=given["stop"] == "all",
        audit=given["audit"],
        block_delete=given["block_delete"],
        max_blocks=given["max_blocks"] or MAX_BLOCKS,
    )
    results, codes = [], []
    for program in programs:
        try:
            begin = time.perf_counter()
            name, text = _read_program(program)
            read_s = time.perf_counter() - begin
        except UsageError as error:
            # The other programs still get their reports.
            click.echo(f"gcodesim: {error}", err=True)
            codes.append(USAGE_EXIT)
            continue
        with _progress(name, given["quiet"]) as progress:
            result = check_program(text, name, machine, options, progress)
        results.append(replace(result, timing_s={"read": read_s} | result.timing_s))
        codes.append(EXIT_CODES[results[-1].verdict])
        if given["report_format"] == "text":
            _print_text(results[-1], given["no_color"])
    if given["report_format"] == "json" and (results or len(programs) > 1):
        _print_json(results, len(programs) > 1)
    sys.exit(worst_exit(codes))


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
    type=FiniteRange(min=0, min_open=True),
    metavar="MM/MIN",
    help="Feed until the first F word.",
)
@click.option("--block-delete", is_flag=True, help="Leave out blocks that begin with /.")
@click.option(
    "--max-blocks",
    type=click.IntRange(min=1),
    metavar="N",
    help="Blocks after which the program counts as endless. Left out: 100 million.",
)
def canon(program: str, machine_path: str | None, tools: str | None, **given: Any) -> None:
    """Print PROGRAM as canonical commands, JSON Lines in machine millimetres and degrees."""
    from gcodesim.findings import FAIL, INCONCLUSIVE
    from gcodesim.machine.control import bare_control, control_for
    from gcodesim.machine.loading import load_machine
    from gcodesim.nc.canon import write_canon
    from gcodesim.nc.control import MAX_BLOCKS
    from gcodesim.nc.interpreter import interpret

    most = given["max_blocks"] or MAX_BLOCKS
    choices = (given["dialect"], given["feed"], given["block_delete"], most)
    if machine_path:
        control = control_for(load_machine(machine_path, tools=tools), *choices)
    else:
        control = bare_control(tools, *choices)
    name, text = _read_program(program)
    with _progress(name, False) as progress:
        meaning = interpret(text, control, name, progress)
    write_canon(meaning, sys.stdout)
    effects = {finding.effect for finding in meaning.findings}
    sys.exit(EXIT_CODES.get(next((e for e in (FAIL, INCONCLUSIVE) if e in effects), "pass"), 0))


@main.command()
@click.argument("program")
@click.option(
    "--machine",
    "machine_path",
    default="table_tilt",
    show_default=True,
    metavar="M.yaml",
    help="Machine file, or the name of a shipped machine.",
)
@click.option(
    "--device",
    default="auto",
    show_default=True,
    metavar="auto|cpu|cuda[:N]",
    help="Where to compute; the paper's tables are measured on the CPU too.",
)
@click.option(
    "--seconds",
    type=click.FloatRange(min=0, min_open=True, max=1e6),
    default=600.0,
    show_default=True,
    help="Least machine time of the long search: the motion is repeated until then.",
)
@click.option(
    "--paper-samples",
    type=click.IntRange(min=1, max=100_000),
    default=50,
    show_default=True,
    metavar="N",
    help="Samples at which the paper's method is timed.",
)
@click.option("--json", "json_path", metavar="FILE", help="Write all figures as JSON.")
@click.option("--csv", "csv_path", metavar="FILE", help="Write all figures as rows.")
def bench(program: str, json_path: str | None, csv_path: str | None, **given: Any) -> None:
    """Measure this machine with PROGRAM: the seed paper's tables, every stage, the search."""
    from rich.console import Console

    from gcodesim.report.bench_report import print_bench, write_csv
    from gcodesim.study.bench import BenchOptions
    from gcodesim.study.bench import bench as measure

    options = BenchOptions(
        program, given["machine_path"], given["device"], given["seconds"], given["paper_samples"]
    )
    with _progress(program, False) as progress:
        report = measure(options, progress)
    print_bench(report, Console(highlight=False, soft_wrap=True))
    if json_path:
        with open(json_path, "w", encoding="utf-8") as out:
            out.write(json.dumps(report, indent=1) + "\n")
    if csv_path:
        with open(csv_path, "w", encoding="utf-8", newline="") as out:
            write_csv(report, out)


@main.command()
@click.argument("code")
def explain(code: str) -> None:
    """Say what CODE means and what to do: a code (GC405) or a meaning (feed_missing)."""
    from gcodesim.explain import explain as explained

    click.echo(explained(code))


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


def _refuse_search_options(given: dict[str, Any]) -> None:
    """Only the method search knows distances: its options must not be dropped in silence."""
    asked = {
        "--clearance": given["clearance"] is not None,
        "--min-clearance": given["min_clearance"],
        "--stop all": given["stop"] == "all",
        "--audit": given["audit"],
    }
    wrong = [option for option, is_given in asked.items() if is_given]
    if wrong and given["method"] != "search":
        raise UsageError(f"{wrong[0]} needs --method search, not {given['method']}")


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


def _print_text(result: CheckResult, no_color: bool) -> None:
    """Print the text report; without colour it holds no escape codes at all."""
    from rich.console import Console

    from gcodesim.report.text import print_report

    plain = no_color or bool(os.environ.get("NO_COLOR"))
    colors: Literal["auto"] | None = None if plain else "auto"
    print_report(result, Console(color_system=colors, highlight=False, soft_wrap=True))


def _print_json(results: list[CheckResult], several: bool) -> None:
    """Print the JSON report; several programs are one array, whatever became of them."""
    from gcodesim.report.json_report import report_dict

    reports = [report_dict(result) for result in results]
    click.echo(json.dumps(reports if several else reports[0], indent=2))
