"""The leave-out study as a table for people and as rows for a spreadsheet."""

from __future__ import annotations

import csv
from typing import Any, TextIO

from rich.console import Console
from rich.table import Table

KINDS = ("axes", "pairs", "bodies", "triangles")
COLUMNS = ("program", "verdict", *KINDS, "looks", "ms", "saved", "agrees")


def print_leave_out(study: dict[str, Any], console: Console) -> None:
    """Print the table, a sum, and what was not even imported."""
    savings = study["savings"]
    title = f"Left out/all on {study['machine']}; looks and ms with everything -> with less"
    table = Table(title=title, title_justify="left")
    for name in COLUMNS:
        left = name in ("program", "verdict")
        table.add_column(name, justify="left" if left else "right", no_wrap=True, overflow="ignore")
    for row in savings:
        table.add_row(
            row["program"],
            row["verdict"],
            *(f"{row[f'{name}_out']}/{row[name]}" for name in KINDS),
            f"{row['items_full']} -> {row['items']}",
            f"{1e3 * row['seconds_full']:.1f} -> {1e3 * row['seconds']:.1f}",
            f"{100.0 * (1.0 - row['seconds'] / row['seconds_full']):.0f} %",
            "yes" if row["agrees"] else "NO",
        )
    console.print(table, crop=False)
    tests, looks = (sum(row[key] for row in savings) for key in ("tests", "items"))
    console.print(
        f"{tests} tests of a pair at a sample were proved needless by {looks} looks "
        f"at stretches of time: {tests / max(looks, 1):.0f} for each"
    )
    agree = sum(row["agrees"] for row in savings)
    console.print(f"with nothing left out the same answer: {agree} of {len(savings)} programs")
    console.print(f"a plain check imports none of: {', '.join(study['not_imported'])}")
    console.print(
        f"kernel modules compiled: {', '.join(study['kernels'])}; "
        f"not compiled: {', '.join(study['kernels_out'])}"
    )
    if study["imported"]:
        console.print(f"it imports: {', '.join(study['imported'])}")


def write_csv(study: dict[str, Any], out: TextIO) -> None:
    """Write one row per program."""
    savings = study["savings"]
    rows = csv.DictWriter(out, fieldnames=list(savings[0]), lineterminator="\n")
    rows.writeheader()
    rows.writerows(savings)
