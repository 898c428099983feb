"""The overview of a batch: one row per program and machine, as a table on the terminal."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

from rich.cells import cell_len, set_cell_size
from rich.console import Console
from rich.text import Text

from gcodesim.checking.verdict import PASS, CheckResult
from gcodesim.findings.codes import FAIL, INCONCLUSIVE
from gcodesim.findings.printing import printable
from gcodesim.report.outcome import RunOutcome
from gcodesim.report.reading import result_of_record
from gcodesim.report.rows import rows as weightiest
from gcodesim.report.text import COLORS

ERROR = "error"
"""Stands in the column of verdicts where the command could not be carried out (exit code 2)."""

VERDICTS = (ERROR, FAIL, INCONCLUSIVE, PASS)

ALL_SHOWN = 50
"""Longest table that shows programs that pass: of more, a person wants to see the others."""

GAP = 2
"""Blanks between columns."""

BESIDE = 40
"""Least room for the worst finding in its column; with less it stands below its row."""

INDENT = 4
"""Blanks before a worst finding that stands below its row."""

SHRINKING = ((2, 10), (1, 16))
"""Columns that are cut where the others need the room, in this order, and their least width."""


@dataclass(frozen=True)
class ProgramRow:
    """One program on one machine.

    Attributes:
        clearance_mm: smallest distance of any pair; 0 with a contact, None where not asked for.
        pair: that comes so near.
        cycle_s: duration of the program [s].
        worst: its worst finding, the same as in every report, or why there is none.
        line: of that finding.
        ignored: how many contacts were ignored, and why.
        pictures: files that show what was found.
        options: that not every row has.
        number: counts rows of the same program, machine and setup, as JUnit reports do.
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
    ignored: str = ""
    pictures: tuple[str, ...] = ()
    options: tuple[str, ...] = ()
    number: int = 1


def rows_of(
    records: Iterable[dict[str, Any]],
    missing: Iterable[dict[str, Any]] = (),
    shards: Iterable[str] = (),
) -> list[ProgramRow]:
    """Rows of all jobs, the worst verdict first.

    Args:
        records: what became of jobs.
        missing: labels of jobs without a record.
        shards: parts of the batch that are not there.

    Raises:
        UsageError: a report is not one of this version.
    """
    jobs = sorted([*records, *missing], key=_place)
    shared = shared_options(jobs)
    counts: Counter[tuple[str, ...]] = Counter()
    rows = [
        ProgramRow(f"shard {shard}", "", "", INCONCLUSIVE, worst="not there") for shard in shards
    ]
    for job in jobs:
        counts[_place(job)] += 1
        own = tuple(option for option in job.get("options", ()) if option not in shared)
        rows.append(replace(_row(job), options=own, number=counts[_place(job)]))
    return sorted(rows, key=lambda row: (VERDICTS.index(row.verdict), row.program, row.machine))


def shared_options(jobs: Sequence[dict[str, Any]]) -> tuple[str, ...]:
    """Options that differ from the defaults, and are those of every job."""
    lists = [job.get("options", ()) for job in jobs] or [()]
    return tuple(option for option in lists[0] if all(option in other for other in lists))


def _place(job: dict[str, Any]) -> tuple[str, str, str]:
    return job["program"], job["machine"], job["setup"]


def _row(job: dict[str, Any]) -> ProgramRow:
    """The row of a record, or of the label of a job without one."""
    if "error" in job:
        return ProgramRow(*_place(job), ERROR, worst=job["error"])
    if "report" not in job:
        return ProgramRow(*_place(job), INCONCLUSIVE, worst="not checked")
    result = result_of_record(job)
    distance, pair = _nearest(result)
    heavy = (row.finding for row in weightiest(RunOutcome((result,))))
    # How the dialect was told stands in the report of every program.
    worst = next((finding for finding in heavy if finding.meaning != "dialect_told"), None)
    return ProgramRow(
        *_place(job),
        result.verdict,
        distance,
        pair,
        result.duration_s,
        f"{worst.code} {worst.message}" if worst else "",
        worst.line if worst else None,
        _ignored(result),
        result.pictures,
    )


def _nearest(result: CheckResult) -> tuple[float | None, str]:
    """Smallest distance of any pair and the pair, as far as it is known."""
    contact = result.first_contact
    if contact:
        return contact.distance_mm, "-".join(contact.pair)
    nearest = min(result.clearances, key=lambda c: c.minimum_mm, default=None)
    return (nearest.minimum_mm, "-".join(nearest.pair)) if nearest else (None, "")


def _ignored(result: CheckResult) -> str:
    """How many contacts were ignored, each reason once with who gave it."""
    marks = [f.ignored for f in result.ignored if f.ignored and f.is_contact]
    if not marks:
        return ""
    reasons = dict.fromkeys(f"{mark.by}: {mark.reason}" for mark in marks)
    count = f"{len(marks)} contact{'s' if len(marks) > 1 else ''}"
    return f"{count} ignored ({'; '.join(reasons)})"


def verdict_of(record: dict[str, Any]) -> str:
    """Verdict of a record, or ERROR."""
    return ERROR if "error" in record else str(record["report"]["verdict"])


def count_verdicts(verdicts: Counter[str]) -> str:
    """How often there is each verdict, in words."""
    return ", ".join(f"{verdicts[verdict]} {verdict.upper()}" for verdict in reversed(VERDICTS))


def headline(rows: Sequence[ProgramRow]) -> str:
    """The number of rows, and of their verdicts."""
    return f"{len(rows)} checks: {count_verdicts(Counter(row.verdict for row in rows))}"


def cells(row: ProgramRow) -> tuple[str, str, str, str, str, str]:
    """A row as text: verdict, program, machine, clearance, cycle time, worst finding."""
    program = row.program + (f" #{row.number}" if row.number > 1 else "")
    machine = f"{row.machine} + {row.setup}" if row.setup else row.machine
    near = "" if row.clearance_mm is None else f"{row.clearance_mm:.3f} {row.pair}"
    time = "" if row.cycle_s is None else f"{row.cycle_s:.1f}"
    place = f"line {row.line}: " if row.line else ""
    remarks = [f"{place}{row.worst}", row.ignored]
    if row.verdict == PASS:
        remarks.reverse()  # what does not count after all says more than a note
    texts = (
        *(row.verdict.upper(), program, " ".join([machine, *row.options])),
        *(near, time, "; ".join(filter(None, remarks))),
    )
    verdict, program, machine, near, time, worst = map(printable, texts)
    return verdict, program, machine, near, time, worst


def columns() -> tuple[str, str, str, str, str, str]:
    """Titles of the columns."""
    return "verdict", "program", "machine", "clearance mm", "cycle s", "worst finding"


def print_overview(rows: Sequence[ProgramRow], console: Console) -> None:
    """Print the table and the count of verdicts.

    Of many programs only those are shown that do not pass, or that pass with ignored contacts.
    """
    few = len(rows) <= ALL_SHOWN
    shown = [row for row in rows if few or row.verdict != PASS or row.ignored]
    if shown:
        for line in _table(shown, console):
            console.print(line, no_wrap=True, overflow="ellipsis")
    console.print(headline(rows))


def _table(rows: Sequence[ProgramRow], console: Console) -> Iterator[Text]:
    """Yield lines: every row with its worst finding, wrapped, beside or below it."""
    texts = [columns(), *map(cells, rows)]
    styles = ["bold", *(COLORS.get(row.verdict, "bold red") for row in rows)]
    widths = _widths(texts, console.width)
    indent = sum(widths) + GAP * len(widths)
    beside = console.width - indent >= BESIDE
    indent = indent if beside else INDENT
    for (verdict, *names, time, worst), style in zip(texts, styles, strict=True):
        line = Text.assemble((set_cell_size(verdict, widths[0]), style))
        for name, width in zip(names, widths[1:], strict=False):
            line.append(" " * GAP + _fitted(name, width))
        line.append(" " * GAP + time.rjust(widths[-1]))
        room = max(1, console.width - indent)
        lines = [part.plain.rstrip() for part in Text(worst).wrap(console, room) if part.plain]
        if lines and beside:
            line.append(" " * GAP + lines.pop(0))
        line.rstrip()
        yield line
        yield from (Text(" " * indent + part) for part in lines)


def _widths(texts: Sequence[Sequence[str]], room: int) -> list[int]:
    """Widths of the columns but the last; verdict, clearance and cycle time are never cut."""
    widths = [max(map(cell_len, column)) for column in zip(*texts, strict=True)][:-1]
    for column, least in SHRINKING:
        over = sum(widths) + GAP * (len(widths) - 1) - room
        widths[column] = min(widths[column], max(least, widths[column] - over))
    return widths


def _fitted(text: str, width: int) -> str:
    """The text in so many cells; of a longer one the end is kept, which names the file."""
    over = cell_len(text) - width
    return set_cell_size(f"…{text[over + 1 :]}" if over > 0 else text, width)
