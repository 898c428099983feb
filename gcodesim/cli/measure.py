"""The commands `bench` and `study`: how fast, how exact, how stable."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from gcodesim.cli.arguments import machine_option, options_named, progress_bar
from gcodesim.cli.outputs import Output, claim, model_files, writing
from gcodesim.output_file import replacing, write_text

WIDTH = 160
"""Columns that the tables of a study take."""


class OutFile(click.Path):
    """A file to write: a folder that is missing is an error before the study, not after it."""

    def convert(self, value: Any, param: Any, ctx: Any) -> Any:
        """Refuse a file that could not be written."""
        path = Path(str(super().convert(value, param, ctx)))
        if not path.absolute().parent.is_dir():
            self.fail(f"{str(path)!r}: there is no folder {str(path.parent)!r}", param, ctx)
        return str(path)


OUT = OutFile(dir_okay=False, writable=True)

JSON = click.option(
    "--json", "json_path", type=OUT, metavar="FILE", help="Write all figures as JSON."
)
CSV = click.option("--csv", "csv_path", type=OUT, metavar="FILE", help="Write all figures as rows.")


def write_figures(
    report: dict[str, Any],
    write_rows: Callable[[dict[str, Any], Any], None],
    csv_path: str | None,
    json_path: str | None = None,
) -> None:
    """Write the figures of a measurement as JSON and as rows, where asked for."""
    if json_path:
        with writing(f"--json {json_path}"):
            write_text(json_path, json.dumps(report, indent=1) + "\n")
    if csv_path:
        with (
            writing(f"--csv {csv_path}"),
            replacing(csv_path, "w", encoding="utf-8", newline="") as out,
        ):
            write_rows(report, out)


@click.command()
@click.argument("program")
@machine_option(default="table_tilt")
@options_named("device")
@click.option(
    "--seconds",
    type=click.FloatRange(min=0, min_open=True, max=1e6),
    default=600.0,
    show_default=True,
    metavar="S",
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
@JSON
@CSV
def bench(program: str, json_path: str | None, csv_path: str | None, **given: Any) -> None:
    """Measure this machine with PROGRAM: the seed paper's tables, every stage, the search."""
    from rich.console import Console

    from gcodesim.report.bench_report import print_bench, write_csv
    from gcodesim.study.bench import BenchOptions
    from gcodesim.study.bench import bench as measure

    read = [(program, "the program"), *model_files(given["machine_path"], None)]
    claim(_asked(json=json_path, csv=csv_path), read)
    options = BenchOptions(
        program, given["machine_path"], given["device"], given["seconds"], given["paper_samples"]
    )
    with progress_bar(program, False) as progress:
        report = measure(options, progress)
    print_bench(report, Console(highlight=False, soft_wrap=True))
    write_figures(report, write_csv, csv_path, json_path)


@click.group()
def study() -> None:
    """Show error against run time, stability, and what leaving out saves."""


@study.command("leave-out")
@click.argument("programs", nargs=-1, metavar="[PROGRAM...]")
@machine_option(default="table_tilt")
@click.option(
    "--generated",
    type=click.IntRange(min=0),
    default=4,
    show_default=True,
    metavar="N",
    help="Random programs of each kind (3 axes, 3+2, 5 axes) besides.",
)
@click.option(
    "--seed", type=int, default=1, show_default=True, metavar="N", help="Of the random programs."
)
@click.option(
    "--refine",
    type=click.IntRange(0, 4),
    default=0,
    show_default=True,
    metavar="N",
    help="Times that every triangle is cut into four: what finer meshes gain.",
)
@JSON
@CSV
def leave_out(programs: tuple[str, ...], machine_path: str, **given: Any) -> None:
    """Check PROGRAMs with everything and with only what they need, and compare."""
    from gcodesim.report.leave_out_report import print_leave_out, write_csv
    from gcodesim.study.leave_out_study import leave_out_study

    read = [*((program, "a program") for program in programs), *model_files(machine_path, None)]
    claim(_asked(json=given["json_path"], csv=given["csv_path"]), read)
    with progress_bar("programs", False) as progress:
        report = leave_out_study(
            list(programs),
            machine_path,
            given["generated"],
            given["seed"],
            given["refine"],
            progress,
        ).as_report()
    print_leave_out(report, _wide_console())
    write_figures(report, write_csv, given["csv_path"], given["json_path"])


@study.command()
@click.option(
    "--quick/--full",
    default=True,
    show_default=True,
    help="Few settings and starts in a minute, or all of them with 20 starts each.",
)
@CSV
@click.option(
    "--plot",
    "plot_path",
    type=OUT,
    metavar="FILE",
    help="Draw the diagrams as PNG; needs gcodesim[plot].",
)
def accuracy(quick: bool, csv_path: str | None, plot_path: str | None) -> None:
    """Error of the first contact against run time, on scenes whose contact has a closed form."""
    from gcodesim.report.study_plot import plot_accuracy, require_matplotlib
    from gcodesim.report.study_report import print_accuracy, write_accuracy_csv
    from gcodesim.study.accuracy import FULL, QUICK, study_accuracy

    claim(_asked(csv=csv_path, plot=plot_path), [])
    if plot_path:
        require_matplotlib()
    with progress_bar("scenes", False) as progress:
        report = study_accuracy(QUICK if quick else FULL, progress)
    print_accuracy(report, _wide_console())
    write_figures(report, write_accuracy_csv, csv_path)
    if plot_path:
        plot_accuracy(report, plot_path)


@study.command()
@click.option(
    "--pairs",
    type=click.IntRange(min=1, max=1_000_000),
    default=2_000,
    show_default=True,
    metavar="N",
    help="Pairs of triangles of each family.",
)
@CSV
def triangles(pairs: int, csv_path: str | None) -> None:
    """Misses and false alarms of triangle tests on 13 hard families, against exact answers."""
    from gcodesim.report.study_report import print_triangles, write_triangles_csv
    from gcodesim.study.triangle_study import study_triangles

    with progress_bar("triangles", False) as progress:
        report = study_triangles(pairs, progress)
    print_triangles(report, _wide_console())
    write_figures(report, write_triangles_csv, csv_path)


@study.command()
@click.option(
    "--quick/--full",
    default=True,
    show_default=True,
    help="Few samples, blocks and scenes in some seconds, or all of them in a minute or two.",
)
@JSON
@CSV
def stability(quick: bool, json_path: str | None, csv_path: str | None) -> None:
    """Stiff and extreme cases, by the usual formulation and by ours; exit code 1 if one fails."""
    from gcodesim.report.stability_report import print_stability, write_csv
    from gcodesim.study.stability import stability_study

    claim(_asked(json=json_path, csv=csv_path), [])
    with progress_bar("cases", False) as progress:
        report = stability_study(quick, progress).as_report()
    print_stability(report, _wide_console())
    write_figures(report, write_csv, csv_path, json_path)
    sys.exit(0 if report["ok"] else 1)


def _asked(**paths: str | None) -> list[Output]:
    """The files that are asked for, by their options."""
    return [(f"--{name} {path}", path) for name, path in paths.items() if path]


def _wide_console() -> Any:
    """A console that does not squeeze wide tables where the terminal is narrow, or none."""
    from rich.console import Console

    console = Console(highlight=False, soft_wrap=True)
    console.width = max(console.width, WIDTH)
    return console
