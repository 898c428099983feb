"""The benchmark as tables for people and as rows for a spreadsheet."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from typing import Any, TextIO

from rich.console import Console
from rich.table import Table


def print_bench(report: dict[str, Any], console: Console) -> None:
    """Print every table of a benchmark."""
    program, search, windows = report["program"], report["search"], report["windows"]
    console.print(
        f"{program['file']} on {program['machine']}: {program['blocks']} blocks, "
        f"{program['duration_s']:.1f} s, {program['path_mm']:.0f} mm of X Y Z, "
        f"median clearance {program['median_clearance_mm']:.3g} mm"
    )
    console.print(f"{report['cpu']}, {report['cores']} cores; search on {report['device']}")
    for table in report["paper"]:
        console.print(_paper_table(table))
    console.print(_stage_table(report["stages"]))
    console.print(_search_table(search))
    console.print(
        f"one window of 1 ms of machine time, one thread: median {windows['median_us']:.0f} us, "
        f"99.9 % {windows['percentile_99_9_us']:.0f} us, "
        f"worst {windows['maximum_us']:.0f} us at {windows['maximum_at_s']:.3f} s "
        f"({windows['windows']} windows)"
    )
    console.print(_comparison(report["exhaustive"]))


def _comparison(exhaustive: dict[str, Any]) -> str:
    same = "the same answer" if exhaustive["same_answer"] else "ANOTHER ANSWER"
    return (
        f"exhaustive {exhaustive['exhaustive_us_per_sample']:.1f} us per sample, search "
        f"{exhaustive['search_us_per_sample']:.4f}: {exhaustive['ratio']:.0f} times; {same} "
        f"at {exhaustive['samples']} samples"
    )


def _paper_table(table: dict[str, Any]) -> Table:
    """The paper's Table 2 or 3 beside this machine."""
    title = f"The paper's method on {table['device']}, us per sample (Table {table['table']})"
    drawn = Table(title=title, title_justify="left")
    drawn.add_column("pair")
    for name in ("average", "minimum", "maximum", "paper average", "times faster"):
        drawn.add_column(name, justify="right")
    for row in table["pairs"]:
        figures = [f"{row[f'{name}_us']:.1f}" for name in ("average", "minimum", "maximum")]
        published, faster = row.get("paper_average_us"), row.get("times_faster_average")
        beside = [f"{published:.1f}", f"{faster:.1f}"] if published else ["-", "-"]
        drawn.add_row(row["pair"], *figures, *beside)
    return drawn


def _stage_table(stages: dict[str, dict[str, Any]]) -> Table:
    """Milliseconds of every stage."""
    drawn = Table(title="Stages of a check", title_justify="left")
    drawn.add_column("stage")
    drawn.add_column("ms", justify="right")
    drawn.add_column("")
    for stage, values in stages.items():
        note = values.get("note", "")
        if "blocks_per_s" in values:
            note = f"{values['blocks_per_s']:.0f} blocks/s"
        drawn.add_row(stage, f"{values['median_s'] * 1e3:.2f}", note)
    return drawn


def _search_table(search: dict[str, Any]) -> Table:
    """The long search with one thread and with two."""
    title = (
        f"Search of {search['searched_s']:.0f} s, {search['pairs']} pairs, "
        f"{search['pieces']} pieces: {search['items']} items, "
        f"{search['triangle_tests']} triangle tests"
    )
    drawn = Table(title=title, title_justify="left")
    for name in ("threads", "ms", "us per sample", "times machine speed"):
        drawn.add_column(name, justify="right")
    for row in search["threads"]:
        drawn.add_row(
            str(row["threads"]),
            f"{row['median_s'] * 1e3:.1f}",
            f"{row['us_per_sample']:.4f}",
            f"{row['times_machine_speed']:.0f}",
        )
    return drawn


def write_csv(report: dict[str, Any], out: TextIO) -> None:
    """Write all figures of a benchmark as rows section, item, quantity, value."""
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(("section", "item", "quantity", "value"))
    writer.writerows(_rows(report))


def _rows(report: dict[str, Any]) -> Iterator[tuple[str, str, str, Any]]:
    for section, values in report.items():
        for item, row in _items(section, values):
            for quantity, value in row.items():
                if isinstance(value, int | float | str):
                    yield section, item, quantity, value


def _items(section: str, values: Any) -> Iterator[tuple[str, dict[str, Any]]]:
    """The rows below one section, each with its name."""
    if section == "paper":
        for table in values:
            yield from ((f"{table['device']} {row['pair']}", row) for row in table["pairs"])
    elif section == "stages":
        yield from values.items()
    elif isinstance(values, dict):
        yield "", values
        for row in values.get("threads", []):
            yield f"{row['threads']} threads", row
    else:
        yield "", {section: values}
