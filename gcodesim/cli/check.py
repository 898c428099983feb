"""The command `gcodesim check`: the gate."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import click

from gcodesim.checking.verdict import EXIT_CODES, LEVELS, USAGE_EXIT, CheckResult, worst_exit
from gcodesim.cli.arguments import (
    FiniteRange,
    device,
    language_options,
    period,
    progress_bar,
    read_text,
)
from gcodesim.cli.outputs import claim
from gcodesim.cli.pictures import Pictures, picture_names, picture_options
from gcodesim.cli.plan import Plan
from gcodesim.cli.reports import parse_destinations, print_text, report_files, write_reports
from gcodesim.cli.settings import make_plans
from gcodesim.errors import UsageError
from gcodesim.report.outcome import FORMATS, Failure, Outcome

if TYPE_CHECKING:
    from gcodesim.checking.options import Options
    from gcodesim.machine.model import Machine
    from gcodesim.policy.baseline import Baseline
    from gcodesim.policy.policy import Policy


@click.command()
@click.argument("programs", nargs=-1, metavar="PROGRAM...")
@click.option(
    "--machine",
    "machines",
    multiple=True,
    metavar="M.yaml",
    help="Machine file, or the name of a shipped machine; of several, every program is checked on "
    "each. Left out: the one the setup names.",
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
@click.option(
    "--min-clearance/--no-min-clearance",
    default=None,
    help="Report how near every pair comes, and where; left out: a batch tells the nearest pair.",
)
@click.option(
    "--stop",
    type=click.Choice(["first", "all"]),
    default="first",
    show_default=True,
    help="Stop at the first contact, or list every stretch of contact and every place that is too "
    "near.",
)
@click.option("--audit", is_flag=True, help="Check again with nothing left out, and compare.")
@click.option(
    "--device",
    default="auto",
    show_default=True,
    type=device,
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
    plans = make_plans(click.get_current_context(), programs)
    with plans[0].naming_places():
        sys.exit(_run(plans, given["update_baseline"]))


def _run(plans: Sequence[Plan], update: bool) -> int:
    """Check everything and write all that is asked for; the exit code."""
    of_run = plans[0].values
    destinations = parse_destinations(of_run["report"])
    tasks = list(_tasks(plans, _baseline(plans[0], update)))
    pictures = Pictures(of_run["snapshot"], of_run["html"], of_run["glb"], len(tasks) > 1)
    outputs = [*pictures.files([task.picture for task in tasks]), *report_files(destinations)]
    claim(outputs, (file for plan in plans for file in plan.inputs))
    results, failures = _check_all(tasks, of_run, update, pictures)
    write_reports(Outcome(tuple(results), tuple(failures)), of_run["format"], destinations)
    codes = [EXIT_CODES[result.verdict] for result in results] + [USAGE_EXIT for _ in failures]
    codes += [USAGE_EXIT] if pictures.failed else []
    return worst_exit(codes)


@dataclass(frozen=True)
class Task:
    """A program, and everything that decides what is said about it.

    `picture` is its part of the names of its pictures, unlike that of any other task.
    """

    program: str
    machine: Machine
    setup: str
    options: Options
    policy: Policy
    picture: str


def _tasks(plans: Sequence[Plan], baseline: Baseline | None) -> Iterator[Task]:
    """Yield all checks of a run; whatever is wrong with its options is told before any check."""
    from gcodesim.machine.loading import load_machine

    pictures = iter(picture_names([check for plan in plans for check in plan.checks]))
    for plan in plans:
        values, options, policy = plan.values, plan.options(), plan.policy(baseline)
        setup, machines = values["setup"], {}
        for path in plan.machines:
            machine = load_machine(
                path, tools=values["tools"], setup=setup, allow_outside=values["allow_outside"]
            )
            machines[path] = replace(machine, rapids=values["rapids"] or machine.rapids)
        for program, path in plan.checks:
            picture = next(pictures)
            yield Task(program, machines[path], setup or "", options, policy, picture)


def _baseline(plan: Plan, update: bool) -> Baseline | None:
    from gcodesim.policy.baseline import read_baseline

    path = plan.values["baseline"]
    if path is None and update:
        raise UsageError("--update-baseline needs --baseline FILE")
    with plan.told_at("baseline"):
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
        results.append(pictures.write(judged, task.picture))
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
    from gcodesim.checking.flow import check_program

    begin = time.perf_counter()
    try:
        name, text = read_text(task.program)
    except UsageError as error:
        raise UnreadableError(str(error)) from error
    read_s = time.perf_counter() - begin

    def notice(line: str) -> None:
        if not quiet:
            click.echo(f"gcodesim: {line}", err=True)

    with progress_bar(name, quiet) as progress:
        result = check_program(text, name, task.machine, task.options, progress, notice)
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
