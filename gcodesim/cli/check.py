"""The command `gcodesim check`: the gate."""

from __future__ import annotations

import json
import os
import sys
import time
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Literal

import click

from gcodesim.cli.options import (
    DIALECT,
    FiniteRange,
    machine_path_of,
    period,
    progress_bar,
    read_text,
)
from gcodesim.errors import UsageError
from gcodesim.verdict import EXIT_CODES, USAGE_EXIT, worst_exit

if TYPE_CHECKING:
    from gcodesim.verdict import CheckResult


@click.command()
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
        machine_path_of(given["machine_path"], given["setup"]),
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
            name, text = read_text(program)
            read_s = time.perf_counter() - begin
        except UsageError as error:
            # The other programs still get their reports.
            click.echo(f"gcodesim: {error}", err=True)
            codes.append(USAGE_EXIT)
            continue
        with progress_bar(name, given["quiet"]) as progress:
            result = check_program(text, name, machine, options, progress)
        results.append(replace(result, timing_s={"read": read_s} | result.timing_s))
        codes.append(EXIT_CODES[results[-1].verdict])
        if given["report_format"] == "text":
            _print_text(results[-1], given["no_color"])
    if given["report_format"] == "json" and (results or len(programs) > 1):
        _print_json(results, len(programs) > 1)
    sys.exit(worst_exit(codes))


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
