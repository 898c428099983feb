"""The commands `batch` and `merge`: many programs on many machines, and parts of a batch joined."""

from __future__ import annotations

import os
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from gcodesim.checking.verdict import USAGE_EXIT
from gcodesim.cli.arguments import every_option
from gcodesim.cli.outputs import Input, Output, claim, model_files, writing
from gcodesim.cli.pictures import Pictures, picture_names, refuse_ending
from gcodesim.cli.plan import CheckPlan
from gcodesim.cli.reports import Destination, parse_destinations, report_files, write_reports
from gcodesim.cli.run_options import BATCH, MERGE, RunOptions, run_options
from gcodesim.cli.settings import make_plans, tell_skipped
from gcodesim.errors import UsageError
from gcodesim.output_file import write_text

if TYPE_CHECKING:
    from gcodesim.batch.jobs import Job
    from gcodesim.batch.records import Record
    from gcodesim.batch.results import Results

    CheckJobs = Callable[[Sequence[Job]], Iterator[Record]]

WIDE = 1000
"""Width of the table where standard output is no terminal [characters]."""


@click.command()
@click.argument("patterns", nargs=-1, metavar="PATTERN...")
@every_option(BATCH)
def batch(patterns: tuple[str, ...], **given: object) -> None:
    """Check all programs that PATTERNs name: files, globs and folders.

    Of a folder, the files that end in .cnc .eia .gcode .min .mpf .nc .ngc .tap are taken, and
    those in .anc .din .gc .h .i .iso .ptp .spf .txt that read like a program; name others by a
    glob. Without PATTERNs the jobs of the settings file are carried out.
    """
    from gcodesim.batch.programs import find_programs, skipped

    plans = make_plans(click.get_current_context(), find_programs(patterns))
    tell_skipped(skipped(patterns))
    with plans[0].naming_places():
        sys.exit(_batch(plans))


@click.command()
@click.argument("files", nargs=-1, required=True, metavar="RESULTS...")
@every_option(MERGE)
def merge(files: tuple[str, ...], **given: object) -> None:
    """Join RESULTS of the parts of a batch; a part that is missing is INCONCLUSIVE."""
    from gcodesim.batch.results import merge_results, naming_damage, write_results

    run = run_options(given)
    destinations = parse_destinations(run.report)
    results = merge_results(files)
    claim([*_files(run), *report_files(destinations)], _inputs_of_merge(files, results))
    with naming_damage(", ".join(files)):
        code = results.exit_code
        if run.out:
            with writing(f"--out {run.out}"):
                write_results(run.out, results)
        _show(results, run, destinations)
    sys.exit(code)


def _batch(plans: Sequence[CheckPlan]) -> int:
    """Check everything and write all that is asked for; the exit code."""
    run = plans[0].run
    if run.resume and not run.out:
        raise UsageError("--resume needs --out FILE: the results to go on with")
    if run.jobs and run.scheduler not in (None, "local"):
        raise UsageError("--jobs is for workers of this machine: a scheduler has its own")
    with _workers(run) as check_jobs:
        destinations = parse_destinations(run.report)
        names = picture_names([check for plan in plans for check in plan.checks])
        pictures = Pictures(run.snapshot, None, None, len(names) > 1)
        outputs = [*_files(run), *pictures.files(names), *report_files(destinations)]
        claim(outputs, (file for plan in plans for file in plan.inputs))
        jobs = _jobs(plans, map(pictures.snapshot_file, names))
        results = _run(jobs, run, check_jobs)
    _show(results, run, destinations)
    unwritten = [record["unwritten"] for record in results.done if "unwritten" in record]
    for why in unwritten:
        click.echo(f"gcodesim: no snapshot: {why}", err=True)
    return USAGE_EXIT if unwritten and run.snapshot else results.exit_code


def _files(run: RunOptions) -> list[Output]:
    """The files that --out and --html ask for; UsageError where one cannot be meant."""
    if run.overview:
        refuse_ending("html", run.overview)
    files = {"out": run.out, "html": run.overview}
    return [(f"--{name} {file}", file) for name, file in files.items() if file]


def _inputs_of_merge(files: Sequence[str], results: Results) -> Iterator[Input]:
    """Yield what must not be overwritten: the parts, and what their batches read."""
    yield from ((file, "a part that is joined") for file in files)
    yield from ((job["program"], "a program that was checked") for job in results.plan.jobs)
    for machine, setup in {(job["machine"], job["setup"]) for job in results.plan.jobs}:
        yield from model_files(machine, setup or None)


def _jobs(plans: Sequence[CheckPlan], snapshots: Iterator[str]) -> Iterator[Job]:
    """Yield every program on every machine; whatever is wrong with its options is an error."""
    from gcodesim.batch.jobs import Job
    from gcodesim.policy.baseline import read_baseline

    path = plans[0].run.asked.baseline
    with plans[0].placing("baseline"):
        baseline = read_baseline(path) if path else None
    for plan in plans:
        asked = plan.asked_of_batch
        plan.policy(baseline)
        for program, machine in plan.checks:
            snapshot = next(snapshots)
            yield Job(
                program=program,
                machine=machine,
                asked=asked,
                snapshot=snapshot,
                ignored_by=plan.label("ignore"),
            )


@contextmanager
def _workers(run: RunOptions) -> Iterator[CheckJobs]:
    """What checks jobs: workers of this machine, which warm up from now on, or a cluster."""
    limit_s, address = run.time_limit, run.scheduler
    if address:
        from gcodesim.batch.cluster import check_on_cluster

        yield lambda jobs: check_on_cluster(jobs, address, run.jobs, limit_s)
        return
    from gcodesim.batch.pool import check_local, warm_workers, worker_devices

    with warm_workers(worker_devices(run.asked.options.device, run.jobs)) as workers:
        yield lambda jobs: check_local(jobs, workers, limit_s)


def _run(wanted: Iterable[Job], run: RunOptions, check_jobs: CheckJobs) -> Results:
    """Do what is not done yet; every record is written as soon as it is there."""
    from gcodesim.batch.jobs import prepare, shard_of
    from gcodesim.batch.results import Results, RunPlan, identity, start_results, write_record

    jobs = shard_of(prepare(wanted), *run.shard)
    plan = RunPlan([job.label for job in jobs], run.shard)
    path, results = run.out, Results(plan)
    if path:
        with writing(f"--out {path}"):
            results = start_results(path, plan, resume=run.resume)
    left = [job for job in jobs if identity(job.label) not in results.records]
    if len(left) < len(jobs):
        click.echo(f"gcodesim: {len(jobs) - len(left)} of {len(jobs)} are done already", err=True)
    with _progress(len(left), run.quiet) as advance:
        for record in check_jobs(left):
            results.add(record)
            if path:
                with writing(f"--out {path}"):
                    write_record(path, record)
            advance(record)
    return results


@contextmanager
def _progress(count: int, quiet: bool) -> Iterator[Callable[[Record], None]]:
    """Progress on stderr, on a terminal only: how many are done, of which verdicts, until when."""
    if quiet or not sys.stderr.isatty():
        yield lambda record: None
        return
    from rich import progress
    from rich.console import Console

    from gcodesim.report.overview import count_verdicts, verdict_of

    columns = (
        progress.MofNCompleteColumn(),
        progress.BarColumn(),
        progress.TextColumn("{task.description}"),
        progress.TimeRemainingColumn(),
    )
    counts: Counter[str] = Counter()
    with progress.Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("starting", total=count)

        def advance(record: Record) -> None:
            counts[verdict_of(record)] += 1
            bar.update(task, advance=1, description=count_verdicts(counts))

        yield advance


def _show(results: Results, run: RunOptions, destinations: Sequence[Destination]) -> None:
    """The overview, on standard output and as a page; then the reports."""
    from rich.console import Console

    from gcodesim.report.overview import print_overview, rows_of, shared_options
    from gcodesim.report.overview_page import overview_page
    from gcodesim.report.reading import outcome_of

    parts = results.done, results.missing, results.missing_shards
    rows = rows_of(*parts)
    plain = run.no_color or bool(os.environ.get("NO_COLOR"))
    colors: Literal["auto"] | None = None if plain else "auto"
    # A file or a pipe has no width that would cut off a text.
    width = None if sys.stdout.isatty() else WIDE
    print_overview(rows, Console(color_system=colors, highlight=False, width=width))
    if html := run.overview:
        options = shared_options([*results.done, *results.missing])
        page = overview_page(rows, results.plan.version, options, Path(html).parent)
        with writing(f"--html {html}"):
            write_text(html, page, errors="replace")
    if destinations:
        write_reports(outcome_of(*parts), "text", destinations)
