"""The overview of a batch: one row per program and machine, as a table on the terminal."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from rich.console import Console
from rich.table import Table
from rich.text import Text

from gcodesim.findings import FAIL, INCONCLUSIVE
from gcodesim.report.text import COLORS, printable
from gcodesim.verdict import PASS

ERROR = "error"
"""Stands in the column of verdicts where the command could not be carried out (exit code 2)."""

VERDICTS = (ERROR, FAIL, INCONCLUSIVE, PASS)
SEVERITIES = ("error", "warning", "note")

ALL_SHOWN = 50
"""Longest table that shows programs that pass: of more, a person wants to see the others."""


@dataclass(frozen=True)
class Row:
    """One program on one machine.

    Attributes:
        clearance_mm: smallest distance of any pair; 0 with a contact, None where not asked for.
        pair: that comes so near.
        cycle_s: duration of the program [s].
        worst: its worst finding, or why there is none.
        line: of that finding.
        seconds: that the check took.
        pictures: files that show what was found.
    """

    program: str
    machine: str
    setup: str
    verdict: str
    clearance_mm: float | None = None
    pair: str = ""
    cycle_s: float | None = None
    worst: str = ""
    line: int | None = None
    seconds: float = 0.0
    pictures: tuple[str, ...] = ()


def rows_of(
    records: Iterable[dict[str, Any]],
    missing: Iterable[dict[str, str]] = (),
    shards: Iterable[str] = (),
) -> list[Row]:
    """Rows of all jobs, the worst verdict first.

    Args:
        records: what became of jobs.
        missing: labels of jobs without a record.
        shards: parts of the batch that are not there.
    """
    rows = [_row(record) for record in records]
    rows += [
        Row(job["program"], job["machine"], job["setup"], INCONCLUSIVE, worst="not checked")
        for job in missing
    ]
    rows += [Row(f"shard {shard}", "", "", INCONCLUSIVE, worst="not there") for shard in shards]
    return sorted(rows, key=lambda row: (VERDICTS.index(row.verdict), row.program, row.machine))


def _row(record: dict[str, Any]) -> Row:
    place = record["program"], record["machine"], record["setup"]
    if verdict_of(record) == ERROR:
        return Row(*place, ERROR, worst=record["error"], seconds=record["seconds"])
    report = record["report"]
    distance, pair = _nearest(report)
    # Of equal severity what decided the verdict counts: it has the lower code.
    worst: dict[str, Any] = min(
        report["findings"],
        key=lambda f: (SEVERITIES.index(f["severity"]), f["code"]),
        default={"code": "", "message": ""},
    )
    return Row(
        *place,
        verdict_of(record),
        distance,
        pair,
        report["duration_s"],
        f"{worst['code']} {worst['message']}".strip(),
        worst.get("line"),
        record["seconds"],
        tuple(report["pictures"]),
    )


def _nearest(report: dict[str, Any]) -> tuple[float | None, str]:
    """Smallest distance of any pair and the pair, as far as it is known."""
    contact = report["first_contact"]
    if contact:
        return contact["distance_mm"], "-".join(contact["pair"])
    nearest = min(report["clearances"], key=lambda c: c["minimum_mm"], default=None)
    return (nearest["minimum_mm"], "-".join(nearest["pair"])) if nearest else (None, "")


def verdict_of(record: dict[str, Any]) -> str:
    """Verdict of a record, or ERROR."""
    return ERROR if "error" in record else str(record["report"]["verdict"])


def count_verdicts(verdicts: Counter[str]) -> str:
    """How often there is each verdict, in words."""
    return ", ".join(f"{verdicts[verdict]} {verdict.upper()}" for verdict in reversed(VERDICTS))


def headline(rows: Sequence[Row]) -> str:
    """The number of rows, and of their verdicts."""
    return f"{len(rows)} checks: {count_verdicts(Counter(row.verdict for row in rows))}"


def cells(row: Row) -> tuple[str, str, str, str, str, str]:
    """A row as text: verdict, program, machine, clearance, cycle time, worst finding."""
    near = "" if row.clearance_mm is None else f"{row.clearance_mm:.3f} {row.pair}"
    time = "" if row.cycle_s is None else f"{row.cycle_s:.1f}"
    machine = f"{row.machine} + {row.setup}" if row.setup else row.machine
    place = f"line {row.line}: " if row.line else ""
    texts = (row.verdict.upper(), row.program, machine, near, time, f"{place}{row.worst}")
    verdict, program, machine, near, time, worst = map(printable, texts)
    return verdict, program, machine, near, time, worst


def columns() -> tuple[str, str, str, str, str, str]:
    """Titles of the columns."""
    return "verdict", "program", "machine", "clearance mm", "cycle s", "worst finding"


def print_overview(rows: Sequence[Row], console: Console) -> None:
    """Print the table and the count of verdicts; of many programs only those that do not pass."""
    shown = [row for row in rows if len(rows) <= ALL_SHOWN or row.verdict != PASS]
    table = Table(box=None, pad_edge=False, header_style="dim")
    for column in columns():
        side: Literal["left", "right"] = "right" if column == "cycle s" else "left"
        table.add_column(column, justify=side, no_wrap=True, overflow="ellipsis")
    for row in shown:
        verdict, *rest = cells(row)
        table.add_row(Text(verdict, COLORS.get(row.verdict, "bold red")), *map(Text, rest))
    if shown:
        console.print(table)
    console.print(headline(rows))
