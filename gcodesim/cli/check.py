"""The command `gcodesim check`: the gate."""

from __future__ import annotations

import re
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import click

from gcodesim.checking.request import CheckRequest
from gcodesim.checking.verdict import EXIT_CODES, USAGE_EXIT, CheckResult, worst_exit
from gcodesim.cli.arguments import every_option, progress_bar, read_text
from gcodesim.cli.outputs import claim
from gcodesim.cli.pictures import Pictures, picture_names
from gcodesim.cli.plan import CheckPlan
from gcodesim.cli.reports import parse_destinations, print_text, report_files, write_reports
from gcodesim.cli.run_options import CHECK, RunOptions
from gcodesim.cli.settings import make_plans
from gcodesim.errors import UsageError
from gcodesim.report.outcome import Failure, RunOutcome

if TYPE_CHECKING:
    from gcodesim.machine.model import Machine
    from gcodesim.policy.baseline import Baseline
    from gcodesim.policy.policy import Policy


UNFIT = re.compile(r"[^\w.-]+")
"""What of the name of a program does not belong into the name of a file."""


@click.command()
@click.argument("programs", nargs=-1, metavar="PROGRAM...")
@every_option(CHECK)
def check(programs: tuple[str, ...], **given: object) -> None:
    """Check PROGRAMs: does the machine hit itself? `-` reads standard input.

    Without PROGRAMs the jobs of the settings file are carried out.
    """
    plans = make_plans(click.get_current_context(), programs)
    with plans[0].naming_places():
        sys.exit(_run(plans))


def _run(plans: Sequence[CheckPlan]) -> int:
    """Check everything and write all that is asked for; the exit code."""
    run = plans[0].run
    destinations = parse_destinations(run.report)
    checks = list(_checks(plans, _baseline(plans[0])))
    pictures = Pictures(run.snapshot, run.html, run.glb, len(checks) > 1)
    outputs = [
        *pictures.files([each.picture for each in checks]),
        *report_files(destinations, run.format),
    ]
    claim(outputs, (file for plan in plans for file in plan.inputs))
    results, failures = _check_all(checks, run, pictures)
    write_reports(RunOutcome(tuple(results), tuple(failures)), run.format, destinations)
    codes = [EXIT_CODES[result.verdict] for result in results] + [USAGE_EXIT for _ in failures]
    codes += [USAGE_EXIT] if pictures.failed else []
    return worst_exit(codes)


@dataclass(frozen=True)
class ProgramCheck:
    """A program, and everything that decides the answer to it.

    `picture` is its part of the names of its pictures, unlike that of any other check; `read` is
    name and text of the program where it has been read already.
    """

    program: str
    machine: Machine
    asked: CheckRequest
    policy: Policy
    picture: str
    read: tuple[str, str] | None = None

    def each(self) -> Iterator[ProgramCheck]:
        """Yield a check for every main program of the file; this one where it cannot be read."""
        from gcodesim.machine.control_data import control_for
        from gcodesim.nc.interpret import main_programs

        options = self.asked.options
        try:
            read = read_text(self.program)
        except UsageError:
            yield self
            return
        for name in main_programs(read[1], control_for(self.machine, *options.language)):
            asked = replace(self.asked, options=replace(options, main_program=name))
            picture = self.picture + (f"-{UNFIT.sub('', name)}" if name else "")
            yield replace(self, asked=asked, picture=picture, read=read)


def _checks(plans: Sequence[CheckPlan], baseline: Baseline | None) -> Iterator[ProgramCheck]:
    """Yield all checks of a run; whatever is wrong with its options is an error before any."""
    from gcodesim.machine.loading import load_machine

    pictures = iter(picture_names([check for plan in plans for check in plan.checks]))
    for plan in plans:
        asked, policy, machines = plan.run.asked, plan.policy(baseline), {}
        for path in plan.machines:
            machine = load_machine(
                path, tools=asked.tools, setup=asked.setup, allow_outside=asked.allow_outside
            )
            machines[path] = machine.with_readings(rapids=asked.rapids)
        for program, path in plan.checks:
            check = ProgramCheck(program, machines[path], asked, policy, next(pictures))
            yield from check.each() if plan.run.all_programs else (check,)


def _baseline(plan: CheckPlan) -> Baseline | None:
    from gcodesim.policy.baseline import read_baseline

    path, update = plan.run.asked.baseline, plan.run.update_baseline
    if path is None and update:
        raise UsageError("--update-baseline needs --baseline FILE")
    with plan.placing("baseline"):
        return None if path is None else read_baseline(path, may_be_new=update)


def _check_all(
    checks: Sequence[ProgramCheck], run: RunOptions, pictures: Pictures
) -> tuple[list[CheckResult], list[Failure]]:
    """Check every program; text reports are printed as they come."""
    checked: list[tuple[ProgramCheck, CheckResult, str]] = []
    results: list[CheckResult] = []
    failures: list[Failure] = []

    def judge(check: ProgramCheck, result: CheckResult, text: str) -> None:
        judged = check.policy.apply(result, text, stop_all=check.asked.options.stop_all)
        results.append(pictures.write(judged, check.picture))
        if run.format == "text":
            print_text(results[-1], run.no_color)

    for check in checks:
        try:
            result, text = _check_one(check, run.quiet)
        except UnreadableError as error:
            # The other programs still get their reports.
            click.echo(f"gcodesim: {error}", err=True)
            failures.append(Failure(check.program, str(error)))
            continue
        if run.update_baseline:
            checked.append((check, result, text))
        else:
            judge(check, result, text)
    if run.update_baseline:
        for check, result, text in _with_new_baseline(checked):
            judge(check, result, text)
    return results, failures


class UnreadableError(UsageError):
    """The program cannot be read."""


def _check_one(check: ProgramCheck, quiet: bool) -> tuple[CheckResult, str]:
    from gcodesim.checking.flow import check_program

    begin = time.perf_counter()
    try:
        name, text = check.read or read_text(check.program)
    except UsageError as error:
        raise UnreadableError(str(error)) from error
    read_s = time.perf_counter() - begin

    def notice(line: str) -> None:
        if not quiet:
            click.echo(f"gcodesim: {line}", err=True)

    with progress_bar(name, quiet) as progress:
        options = check.asked.options
        result = check_program(text, name, check.machine, options, progress, notice)
    timing = {"read": read_s} | result.timing_s
    return replace(result, timing_s=timing, setup=check.asked.setup or ""), text


def _with_new_baseline(
    checked: Sequence[tuple[ProgramCheck, CheckResult, str]],
) -> list[tuple[ProgramCheck, CheckResult, str]]:
    """Write the baseline from what was found, and put it in force."""
    from gcodesim.policy.policy import looked_at_all

    if not checked:
        return []
    old = checked[0][0].policy.baseline
    assert old is not None
    new = old.updated(
        (
            result,
            check.policy.wanted(result, text),
            looked_at_all(result, check.asked.options.stop_all),
        )
        for check, result, text in checked
    )
    new.write()
    added, gone = new.entries.keys() - old.entries.keys(), old.entries.keys() - new.entries.keys()
    click.echo(f"gcodesim: {new.path}: {len(added)} added, {len(gone)} removed", err=True)
    return [
        (replace(check, policy=replace(check.policy, baseline=new)), result, text)
        for check, result, text in checked
    ]
