"""The commands `batch` and `merge`: many programs on many machines, and parts of a batch joined."""

from __future__ import annotations

import os
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click

from gcodesim.cli.check import check
from gcodesim.cli.options import FiniteRange, machine_path_of
from gcodesim.errors import UsageError

if TYPE_CHECKING:
    from gcodesim.batch.jobs import Job
    from gcodesim.batch.records import Record
    from gcodesim.batch.results import Results

    CheckJobs = Callable[[Sequence[Job]], Iterator[Record]]

OF_CHECK = (
    *("setup", "tools", "dialect", "feed", "block_delete", "max_blocks", "rapids"),
    *("sample_period", "between_samples", "clearance", "min_clearance", "audit"),
    *("fail_on", "select", "ignore", "baseline"),
    *("device", "allow_outside", "quiet", "no_color"),
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
@click.argument("patterns", nargs=-1, required=True, metavar="PATTERN...")
@click.option(
    "--machine",
    "machines",
    multiple=True,
    metavar="M.yaml",
    help="Machine file, or the name of a shipped machine; every program is checked on each. Left "
    "out: the one the setup names.",
)
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
    """Check all programs that PATTERNs name: files, globs and folders."""
    if given["resume"] and not given["out"]:
        raise UsageError("--resume needs --out FILE: the results to go on with")
    if given["jobs"] and given["scheduler"] not in (None, "local"):
        raise UsageError("--jobs is for workers of this machine: a scheduler has its own")
    with _workers(given) as check_jobs:
        results = _run(patterns, given, check_jobs)
    _show(results, given["html"], given["no_color"])
    sys.exit(results.exit_code)


batch.params += [option for option in check.params if option.name in OF_CHECK]


@click.command()
@click.argument("files", nargs=-1, required=True, metavar="RESULTS...")
@click.option("--out", metavar="FILE", help="Write the joined results.")
@click.option("--html", metavar="FILE", help="Write an overview page.")
@click.option("--no-color", is_flag=True, help="No colours; NO_COLOR does the same.")
def merge(files: tuple[str, ...], out: str | None, html: str | None, no_color: bool) -> None:
    """Join RESULTS of the parts of a batch; a part that is missing is INCONCLUSIVE."""
    from gcodesim.batch.results import merge_results, write_results

    results = merge_results(files)
    if out:
        write_results(out, results)
    _show(results, html, no_color)
    sys.exit(results.exit_code)


def _jobs(patterns: Sequence[str], given: dict[str, Any]) -> Iterator[Job]:
    """Yield every program on every machine."""
    from gcodesim.batch.jobs import Job, find_programs
    from gcodesim.flow import Options
    from gcodesim.nc.control import MAX_BLOCKS

    options = Options(
        dialect=given["dialect"],
        feed=given["feed"],
        period_ps=given["sample_period"],
        device=given["device"],
        between=given["between_samples"] == "on",
        clearance=given["clearance"],
        minimum=given["min_clearance"],
        audit=given["audit"],
        block_delete=given["block_delete"],
        max_blocks=given["max_blocks"] or MAX_BLOCKS,
    )
    for program in find_programs(patterns):
        for machine in given["machines"] or [machine_path_of(None, given["setup"])]:
            yield Job(
                program,
                machine,
                given["setup"],
                given["tools"],
                given["allow_outside"],
                given["rapids"],
                options,
                given["fail_on"],
                given["select"],
                given["ignore"],
                given["baseline"],
            )


@contextmanager
def _workers(given: dict[str, Any]) -> Iterator[CheckJobs]:
    """What checks jobs: workers of this machine, which warm up from now on, or a cluster."""
    limit_s = given["time_limit"]
    if given["scheduler"]:
        from gcodesim.batch.cluster import check_on_cluster

        yield lambda jobs: check_on_cluster(jobs, given["scheduler"], given["jobs"], limit_s)
        return
    from gcodesim.batch.pool import check_local, warm_workers, worker_devices

    with warm_workers(worker_devices(given["device"], given["jobs"])) as workers:
        yield lambda jobs: check_local(jobs, workers, limit_s)


def _run(patterns: Sequence[str], given: dict[str, Any], check_jobs: CheckJobs) -> Results:
    """Do what is not done yet; every record is written as soon as it is there."""
    from gcodesim.batch.jobs import prepare, shard_of
    from gcodesim.batch.results import Plan, Results, identity, start_results, write_record

    jobs = prepare(_jobs(patterns, given))
    jobs[0].policy()  # what is wrong with it is told before any check
    jobs = shard_of(jobs, *given["shard"])
    plan = Plan([job.label for job in jobs], given["shard"])
    path, results = given["out"], Results(plan)
    if path:
        results = start_results(path, plan, resume=given["resume"])
    left = [job for job in jobs if identity(job.label) not in results.records]
    if len(left) < len(jobs):
        click.echo(f"gcodesim: {len(jobs) - len(left)} of {len(jobs)} are done already", err=True)
    with (
        open(path or os.devnull, "a", encoding="utf-8") as out,
        _progress(len(left), given["quiet"]) as advance,
    ):
        for record in check_jobs(left):
            results.add(record)
            write_record(out, record)
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


def _show(results: Results, html: str | None, no_color: bool) -> None:
    """The overview, on standard output and as a page."""
    from rich.console import Console

    from gcodesim.report.overview import print_overview, rows_of
    from gcodesim.report.overview_page import overview_page

    rows = rows_of(results.done, results.missing, results.missing_shards)
    plain = no_color or bool(os.environ.get("NO_COLOR"))
    colors: Literal["auto"] | None = None if plain else "auto"
    # A file or a pipe has no width that would cut off what is said.
    width = None if sys.stdout.isatty() else WIDE
    print_overview(rows, Console(color_system=colors, highlight=False, width=width))
    if html:
        Path(html).write_text(overview_page(rows, results.plan.version), encoding="utf-8")
