"""The command `gcodesim check`: the gate."""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import click

from gcodesim.cli.options import (
    FiniteRange,
    language_options,
    machine_path_of,
    period,
    progress_bar,
    read_text,
)
from gcodesim.cli.pictures import Pictures, picture_options
from gcodesim.cli.reports import parse_destinations, print_text, write_reports
from gcodesim.cli.settings import Plan, make_plans, show_settings
from gcodesim.errors import UsageError
from gcodesim.report.run import FORMATS, Failure, Run
from gcodesim.verdict import EXIT_CODES, LEVELS, USAGE_EXIT, CheckResult, worst_exit

if TYPE_CHECKING:
    from gcodesim.flow import Options
    from gcodesim.machine.model import Machine
    from gcodesim.policy.baseline import Baseline
    from gcodesim.policy.policy import Policy


@click.command()
@click.argument("programs", nargs=-1, metavar="PROGRAM...")
@click.option(
    "--machine",
    "machine_path",
    metavar="M.yaml",
    help="Machine file, or the name of a shipped machine. Left out: the one the setup names.",
)
@click.option("--setup", metavar="FILE", help="Setup file: offsets, fixtures, part, stock, tools.")
@click.option("--tools", metavar="FILE", help="Tools file (YAML) or LinuxCNC tool table (.tbl).")
@language_options
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
    type=click.Choice(FORMATS),
    default="text",
    show_default=True,
    help="Form of the report on standard output.",
)
@click.option(
    "--report",
    multiple=True,
    metavar="FORMAT=PATH",
    help="Write the report in this form too; may be repeated. PATH - is standard output.",
)
@picture_options
@click.option(
    "--fail-on",
    type=click.Choice(LEVELS),
    default="error",
    show_default=True,
    help="What makes a program FAIL: contacts only, or findings of this severity and above.",
)
@click.option(
    "--select",
    multiple=True,
    metavar="CODE",
    help="Of what may be ignored only these codes count (GC201, or GC2 for all of GC2xx).",
)
@click.option(
    "--ignore",
    multiple=True,
    metavar="CODE[=REASON]",
    help="These codes do not count; contacts (GC1xx) need a reason.",
)
@click.option("--baseline", metavar="FILE", help="Findings in this file do not count.")
@click.option("--update-baseline", is_flag=True, help="Write what is found into the baseline.")
@click.option(
    "--settings",
    metavar="FILE",
    help="Settings file. Left out: gcodesim.toml or pyproject.toml above the programs.",
)
@click.option(
    "--show-settings", is_flag=True, help="Print the options in force, and check nothing."
)
@click.option(
    "--allow-outside",
    is_flag=True,
    help="Mesh files may lie outside the folder of the machine file.",
)
@click.option("--quiet", is_flag=True, help="No progress bar.")
@click.option("--no-color", is_flag=True, help="No colours; NO_COLOR does the same.")
def check(programs: tuple[str, ...], **given: Any) -> None:
    """Check PROGRAMs: does the machine hit itself? `-` reads standard input.

    Without PROGRAMs the jobs of the settings file are carried out.
    """
    context = click.get_current_context()
    settings, plans = make_plans(context, programs)
    if given["show_settings"]:
        click.echo(show_settings(context, settings, plans))
        return
    if not any(plan.programs for plan in plans):
        raise click.UsageError("Missing argument 'PROGRAM...', and no [[jobs]] in a settings file.")
    of_run = plans[0].values
    named = [program for plan in plans for program in plan.programs]
    destinations = parse_destinations(of_run["report"], plans[0].label("report"), named)
    baseline = _baseline(of_run["baseline"], given["update_baseline"])
    tasks = [task for plan in plans for task in _tasks(plan, baseline)]
    pictures = Pictures(of_run["snapshot"], of_run["html"], of_run["glb"], len(named) > 1)
    results, failures = _check_all(tasks, of_run, given["update_baseline"], pictures)
    run = Run(tuple(results), tuple(failures))
    write_reports(run, of_run["format"], destinations)
    codes = [EXIT_CODES[result.verdict] for result in results] + [USAGE_EXIT for _ in failures]
    codes += [USAGE_EXIT] if pictures.failed else []
    sys.exit(worst_exit(codes))


@dataclass(frozen=True)
class Task:
    """A program, and everything that decides what is said about it."""

    program: str
    machine: Machine
    setup: str
    options: Options
    policy: Policy


def _tasks(plan: Plan, baseline: Baseline | None) -> list[Task]:
    """The programs of a plan; whatever is wrong with its options is told before any check."""
    from gcodesim.machine.loading import load_machine
    from gcodesim.policy.policy import Policy
    from gcodesim.policy.rules import parse_prefix, parse_rule

    values = plan.values
    _refuse_search_options(values)
    policy = Policy(
        fail_on=values["fail_on"],
        select=tuple(parse_prefix(text, plan.label("select")) for text in values["select"]),
        ignore=tuple(parse_rule(text, plan.label("ignore")) for text in values["ignore"]),
        baseline=baseline,
    )
    machine = load_machine(
        machine_path_of(values["machine"], values["setup"]),
        tools=values["tools"],
        setup=values["setup"],
        allow_outside=values["allow_outside"],
    )
    machine = replace(machine, rapids=values["rapids"] or machine.rapids)
    options = _options(values)
    setup = values["setup"] or ""
    return [Task(program, machine, setup, options, policy) for program in plan.programs]


def _options(values: dict[str, Any]) -> Options:
    from gcodesim.flow import Options
    from gcodesim.nc.control import MAX_BLOCKS

    return Options(
        dialect=values["dialect"],
        feed=values["feed"],
        period_ps=values["sample_period"],
        device=values["device"],
        method=values["method"],
        between=values["between_samples"] == "on",
        clearance=values["clearance"],
        minimum=values["min_clearance"],
        stop_all=values["stop"] == "all",
        audit=values["audit"],
        block_delete=values["block_delete"],
        max_blocks=values["max_blocks"] or MAX_BLOCKS,
    )


def _baseline(path: str | None, update: bool) -> Baseline | None:
    from gcodesim.policy.baseline import read_baseline

    if path is None and update:
        raise UsageError("--update-baseline needs --baseline FILE")
    return None if path is None else read_baseline(path, may_be_new=update)


def _check_all(
    tasks: Sequence[Task], of_run: dict[str, Any], update: bool, pictures: Pictures
) -> tuple[list[CheckResult], list[Failure]]:
    """Check every program; text reports are printed as they come."""
    checked: list[tuple[Task, CheckResult, str]] = []
    results: list[CheckResult] = []
    failures: list[Failure] = []

    def judge(task: Task, result: CheckResult, text: str) -> None:
        judged = task.policy.apply(result, text, stop_all=task.options.stop_all)
        results.append(pictures.write(judged))
        if of_run["format"] == "text":
            print_text(results[-1], of_run["no_color"])

    for task in tasks:
        try:
            result, text = _check_one(task, of_run["quiet"])
        except UnreadableError as error:
            # The other programs still get their reports.
            click.echo(f"gcodesim: {error}", err=True)
            failures.append(Failure(task.program, str(error)))
            continue
        if update:
            checked.append((task, result, text))
        else:
            judge(task, result, text)
    if update:
        for task, result, text in _with_new_baseline(checked):
            judge(task, result, text)
    return results, failures


class UnreadableError(UsageError):
    """The program cannot be read."""


def _check_one(task: Task, quiet: bool) -> tuple[CheckResult, str]:
    from gcodesim.flow import check_program

    begin = time.perf_counter()
    try:
        name, text = read_text(task.program)
    except UsageError as error:
        raise UnreadableError(str(error)) from error
    read_s = time.perf_counter() - begin
    with progress_bar(name, quiet) as progress:
        result = check_program(text, name, task.machine, task.options, progress)
    timing = {"read": read_s} | result.timing_s
    return replace(result, timing_s=timing, setup=task.setup), text


def _with_new_baseline(
    checked: Sequence[tuple[Task, CheckResult, str]],
) -> list[tuple[Task, CheckResult, str]]:
    """Write the baseline from what was found, and put it in force."""
    from gcodesim.policy.policy import looked_at_all

    if not checked:
        return []
    old = checked[0][0].policy.baseline
    assert old is not None
    new = old.updated(
        (
            result,
            task.policy.wanted(result, text),
            looked_at_all(result, task.options.stop_all),
        )
        for task, result, text in checked
    )
    new.write()
    added, gone = new.entries.keys() - old.entries.keys(), old.entries.keys() - new.entries.keys()
    click.echo(f"gcodesim: {new.path}: {len(added)} added, {len(gone)} removed", err=True)
    return [
        (replace(task, policy=replace(task.policy, baseline=new)), result, text)
        for task, result, text in checked
    ]


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
