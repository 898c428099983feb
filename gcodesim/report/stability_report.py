"""The study of stability as a table for people and as rows for a spreadsheet."""

from __future__ import annotations

import csv
from typing import Any, TextIO

from rich.console import Console
from rich.table import Table
from rich.text import Text


def print_stability(study: dict[str, Any], console: Console) -> None:
    """Print the table, one line for each case, and a sum."""
    table = Table(title="Stiff and extreme cases: distance from the truth", title_justify="left")
    for name in ("of", "case", "quantity", "usual formulation"):
        table.add_column(name)
    for name in ("it gives", "ours", "tolerance"):
        table.add_column(name, justify="right")
    table.add_column("")
    table.add_column("")
    before: dict[str, Any] = {}
    for row in study["cases"]:
        table.add_row(*_cells(row, before), row["unit"], _verdict(row["ok"]))
        before = row
    console.print(table)
    rows = study["cases"]
    failed = sum(not row["ok"] for row in rows)
    compared = [row for row in rows if row["usual"]]
    outside = sum(not row["naive_ok"] for row in compared)
    console.print(
        f"{len(rows) - failed} of {len(rows)} ok; "
        f"the usual formulation misses the tolerance in {outside} of {len(compared)}"
    )


def _cells(row: dict[str, Any], before: dict[str, Any]) -> list[str]:
    """Texts and numbers of a case; what the line above has too is left out."""
    names, same, texts = ("topic", "case", "quantity"), True, []
    for name in names:
        same = same and row[name] == before.get(name)
        texts.append("" if same else row[name])
    naive = _number(row["naive"]) if row["usual"] else ""
    return [*texts, row["usual"], naive, _number(row["ours"]), _number(row["tolerance"])]


def _number(value: float | None) -> str:
    if value is None:
        return "no number"
    return f"{value:.0f}" if value == int(value) and abs(value) < 1e5 else f"{value:.1e}"


def _verdict(ok: bool) -> Text:
    return Text("ok", "green") if ok else Text("FAIL", "bold red")


def write_csv(study: dict[str, Any], out: TextIO) -> None:
    """Write one row per case."""
    cases = study["cases"]
    rows = csv.DictWriter(out, fieldnames=list(cases[0]), lineterminator="\n")
    rows.writeheader()
    rows.writerows(cases)
