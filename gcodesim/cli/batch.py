"""The commands `batch` and `merge`: many programs on many machines, and parts of a batch joined."""

from __future__ import annotations

import os
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click

from gcodesim.checking.verdict import USAGE_EXIT
from gcodesim.cli.arguments import FiniteRange
from gcodesim.cli.check import check
from gcodesim.cli.outputs import Input, Output, claim, model_files, writing
from gcodesim.cli.pictures import Pictures, picture_names, refuse_ending
from gcodesim.cli.plan import Plan
from gcodesim.cli.reports import Destination, parse_destinations, report_files, write_reports
from gcodesim.cli.settings import make_plans, tell_skipped
from gcodesim.errors import UsageError

if TYPE_CHECKING:
    from gcodesim.batch.jobs import Job
    from gcodesim.batch.records import Record
    from gcodesim.batch.results import Results

    CheckJobs = Callable[[Sequence[Job]], Iterator[Record]]

OF_CHECK = (
    *("machines", "setup", "tools", "dialect", "feed", "block_delete", "max_blocks", "rapids"),
    *("sample_period", "method", "between_samples", "clearance", "min_clearance", "stop", "audit"),
    *("fail_on", "select", "ignore", "baseline", "settings", "show_settings"),
    *("report", "snapshot", "device", "allow_outside", "quiet", "no_color"),
)
"""Options that mean here what they mean in `gcodesim check`, by their names in Python."""

WIDE = 1000
"""Width of the table where standard output is no terminal [characters]."""


def shard(text: str) -> tuple[int, int]:
    """Part I of N of a batch, such as `2/5`, as two numbers."""
    index, _, count = text.partition("/")
    if not (index.isdecimal() and count.isdecimal() and 1 <= int(index) <= int(count)):
        raise click.BadParameter(f"{text!r}: expected a part and how many there are, such as 2/5")
    return int(index), int(count)


@click.command()
@click.argument("patterns", nargs=-1, metavar="PATTERN...")
@click.option(
    "--jobs",
    type=click.IntRange(min=1),
    metavar="N",
    help="Worker processes. Left out: one per core, or one per GPU.",
)
@click.option(
    "--time-limit",
    type=FiniteRange(min=0, min_open=True),
    metavar="S",
    help="Seconds after which a check is ended: INCONCLUSIVE (GC901).",
)
@click.option("--out", metavar="FILE", help="Results file: JSON Lines, one per program, at once.")
@click.option("--resume", is_flag=True, help="Go on with --out: skip what is done and unchanged.")
@click.option(
    "--shard",
    type=shard,
    default="1/1",
    metavar="I/N",
    help="Do part I of N; `gcodesim merge` joins the results.",
)
@click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="Dask scheduler that has the work done, tcp://HOST:PORT, or `local` for a cluster here.",
)
@click.option("--html", metavar="FILE", help="Write an overview page.")
def batch(patterns: tuple[str, ...], **given: Any) -> None:
    """Check all programs that PATTERNs name: files, globs and folders.

    Of a folder, the files that end in .cnc .eia .gcode .min .mpf .nc .ngc .tap are taken; name
    others by a glob. Without PATTERNs the jobs of the settings file are carried out.
    """
    from gcodesim.batch.programs import find_programs, skipped

    plans = make_plans(click.get_current_context(), find_programs(patterns))
    tell_skipped(skipped(patterns))
    with plans[0].naming_places():
        sys.exit(_batch(plans, given | plans[0].values))


batch.params += [option for option in check.params if option.name in OF_CHECK]


@click.command()
@click.argument("files", nargs=-1, required=True, metavar="RESULTS...")
@click.option("--out", metavar="FILE", help="Write the joined results.")
@click.option("--html", metavar="FILE", help="Write an overview page.")
def merge(files: tuple[str, ...], **given: Any) -> None:
    """Join RESULTS of the parts of a batch; a part that is missing is INCONCLUSIVE."""
    from gcodesim.batch.results import merge_results, write_results

    destinations = parse_destinations(given["report"])
    results = merge_results(files)
    claim([*_files(given), *report_files(destinations)], _inputs_of_merge(files, results))
    if given["out"]:
        with writing(f"--out {given['out']}"):
            write_results(given["out"], results)
    _show(results, given["html"], given["no_color"], destinations)
    sys.exit(results.exit_code)


merge.params += [option for option in check.params if option.name in ("report", "no_color")]


def _batch(plans: Sequence[Plan], of_run: dict[str, Any]) -> int:
    """Check everything and write all that is asked for; the exit code."""
    if of_run["resume"] and not of_run["out"]:
        raise UsageError("--resume needs --out FILE: the results to go on with")
    if of_run["jobs"] and of_run["scheduler"] not in (None, "local"):
        raise UsageError("--jobs is for workers of this machine: a scheduler has its own")
    with _workers(of_run) as check_jobs:
        destinations = parse_destinations(of_run["report"])
        names = picture_names([check for plan in plans for check in plan.checks])
        pictures = Pictures(of_run["snapshot"], None, None, len(names) > 1)
        outputs = [*_files(of_run), *pictures.files(names), *report_files(destinations)]
        claim(outputs, (file for plan in plans for file in plan.inputs))
        jobs = _jobs(plans, map(pictures.snapshot_file, names))
        results = _run(jobs, of_run, check_jobs)
    _show(results, of_run["html"], of_run["no_color"], destinations)
    unwritten = [record["unwritten"] for record in results.done if "unwritten" in record]
    for why in unwritten:
        click.echo(f"gcodesim: no snapshot: {why}", err=True)
    return USAGE_EXIT if unwritten and of_run["snapshot"] else results.exit_code


def _files(given: dict[str, Any]) -> list[Output]:
    """The files that --out and --html ask for; UsageError where one cannot be meant."""
    if given["html"]:
        refuse_ending("html", given["html"])
    return [(f"--{name} {given[name]}", given[name]) for name in ("out", "html") if given[name]]


def _inputs_of_merge(files: Sequence[str], results: Results) -> Iterator[Input]:
    """Yield what must not be overwritten: the parts, and what their batches read."""
    yield from ((file, "a part that is joined") for file in files)
    yield from ((job["program"], "a program that was checked") for job in results.plan.jobs)
    for machine, setup in {(job["machine"], job["setup"]) for job in results.plan.jobs}:
        yield from model_files(machine, setup or None)


def _jobs(plans: Sequence[Plan], snapshots: Iterator[str]) -> Iterator[Job]:
    """Yield every program on every machine; whatever is wrong with its options is told first."""
    from gcodesim.batch.jobs import Job
    from gcodesim.policy.baseline import read_baseline

    path = plans[0].values["baseline"]
    with plans[0].told_at("baseline"):
        baseline = read_baseline(path) if path else None
    for plan in plans:
        values, options = plan.values, plan.options(nearest=True)
        plan.policy(baseline)
        for program, machine in plan.checks:
            yield Job(
                program,
                machine,
                values["setup"],
                values["tools"],
                values["allow_outside"],
                values["rapids"],
                options,
                values["fail_on"],
                values["select"],
                values["ignore"],
                values["baseline"],
                next(snapshots),
            )


@contextmanager
def _workers(of_run: dict[str, Any]) -> Iterator[CheckJobs]:
    """What checks jobs: workers of this machine, which warm up from now on, or a cluster."""
    limit_s = of_run["time_limit"]
    if of_run["scheduler"]:
        from gcodesim.batch.cluster import check_on_cluster

        yield lambda jobs: check_on_cluster(jobs, of_run["scheduler"], of_run["jobs"], limit_s)
        return
    from gcodesim.batch.pool import check_local, warm_workers, worker_devices

    with warm_workers(worker_devices(of_run["device"], of_run["jobs"])) as workers:
        yield lambda jobs: check_local(jobs, workers, limit_s)


def _run(wanted: Iterable[Job], of_run: dict[str, Any], check_jobs: CheckJobs) -> Results:
    """Do what is not done yet; every record is written as soon as it is there."""
    from gcodesim.batch.jobs import prepare, shard_of
    from gcodesim.batch.results import Results, RunPlan, identity, start_results, write_record

    jobs = shard_of(prepare(wanted), *of_run["shard"])
    plan = RunPlan([job.label for job in jobs], of_run["shard"])
    path, results = of_run["out"], Results(plan)
    if path:
        with writing(f"--out {path}"):
            results = start_results(path, plan, resume=of_run["resume"])
    left = [job for job in jobs if identity(job.label) not in results.records]
    if len(left) < len(jobs):
        click.echo(f"gcodesim: {len(jobs) - len(left)} of {len(jobs)} are done already", err=True)
    with _progress(len(left), of_run["quiet"]) as advance:
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


def _show(
    results: Results, html: str | None, no_color: bool, destinations: Sequence[Destination]
) -> None:
    """The overview, on standard output and as a page; then the reports."""
    from rich.console import Console

    from gcodesim.report.overview import print_overview, rows_of, shared_options
    from gcodesim.report.overview_page import overview_page
    from gcodesim.report.reading import run_of

    told = results.done, results.missing, results.missing_shards
    rows = rows_of(*told)
    plain = no_color or bool(os.environ.get("NO_COLOR"))
    colors: Literal["auto"] | None = None if plain else "auto"
    # A file or a pipe has no width that would cut off what is said.
    width = None if sys.stdout.isatty() else WIDE
    print_overview(rows, Console(color_system=colors, highlight=False, width=width))
    if html:
        options = shared_options([*results.done, *results.missing])
        page = overview_page(rows, results.plan.version, options, Path(html).parent)
        with writing(f"--html {html}"):
            Path(html).write_text(page, encoding="utf-8", errors="replace")
    if destinations:
        write_reports(run_of(*told), "text", destinations)
