"""The studies as tables for people and as rows for a spreadsheet."""

from __future__ import annotations

import csv
from typing import Any, TextIO

from rich.console import Console
from rich.table import Table

RUN_COLUMNS = (
    "scene", "method", "knob", "setting", "unit", "runs", "error_median", "error_max", "bound",
    "latest", "missed", "false", "alarms", "clearance_mm", "missed_mm", "missed_s",
    "unexpected", "wall_s", "poses", "box_tests", "triangle_tests",
)  # fmt: skip
TRIANGLE_COLUMNS = (
    "family", "test", "pairs", "touching", "missed", "false", "deepest_miss_mm",
    "farthest_false_mm", "ns_per_pair",
)  # fmt: skip


def print_accuracy(report: dict[str, Any], console: Console) -> None:
    """Print every table of the accuracy study: a row for every setting, and misses in words."""
    _print_where(report, console)
    drawn = _table(f"First contact, {report['phases']} random starts", ("scene", "method"), (
        "setting", "error median", "maximum", "verdict", "clearance mm", "ms", "poses",
        "box tests", "triangles",
    ))  # fmt: skip
    for row in report["rows"]:
        unit = "ms" if "ms" in row["knob"] else "mm"
        drawn.add_row(
            row["scene"],
            row["method"],
            f"{row['setting']:g} {unit}",
            _number(row["error_median"]),
            _number(row["error_max"], " s"),
            verdict_of(row),
            _number(row["clearance_mm"] or None),
            f"{row['wall_s'] * 1e3:.2f}",
            *(f"{row[name]:.0f}" for name in ("poses", "box_tests", "triangle_tests")),
        )
    console.print(drawn)
    drawn = _table("What no search can undo", ("of", "by"), (
        "setting", "error median", "maximum", "bound",
    ))  # fmt: skip
    for row in report["representation"]:
        setting = f"{row['setting']:g} {row['knob']}" if row["setting"] else row["knob"]
        errors = [_number(row["error_median"]), _number(row["error_max"], f" {row['unit']}")]
        drawn.add_row(row["scene"], row["method"], setting, *errors, _number(row["bound"]))
    console.print(drawn)
    print_goals(report["goals"], console)


def verdict_of(row: dict[str, Any]) -> str:
    """What came of the runs of a setting: MISS n/m and FALSE n/m are never left out."""
    words = [
        f"{word} {row[key]}/{row['runs']}"
        for word, key in (("MISS", "missed"), ("FALSE", "false"))
        if row[key]
    ]
    if not words and not row["alarms"]:
        return "none, rightly"
    if not words and row["error_max"] is None:
        return "near"
    return ", ".join(words) or "hit"


def print_triangles(report: dict[str, Any], console: Console) -> None:
    """Print the triangle study: every family and test, then all families together."""
    _print_where(report, console)
    drawn = _table(f"{report['pairs']} pairs of each family, missed / false", ("family",), (
        "touching", *(total["test"] for total in report["totals"]),
    ))  # fmt: skip
    families = list(dict.fromkeys(row["family"] for row in report["rows"]))
    for family in families:
        rows = [row for row in report["rows"] if row["family"] == family]
        verdicts = [f"{row['missed']} / {row['false']}" for row in rows]
        drawn.add_row(family, str(rows[0]["touching"]), *verdicts)
    console.print(drawn)
    drawn = _table("All families", ("test",), (
        "missed", "rate", "deepest mm", "false", "rate", "farthest mm", "ns per pair",
    ))  # fmt: skip
    for total in report["totals"]:
        drawn.add_row(
            total["test"],
            str(total["missed"]),
            f"{total['miss_rate']:.3%}",
            _number(total["deepest_miss_mm"]),
            str(total["false"]),
            f"{total['false_rate']:.3%}",
            _number(total["farthest_false_mm"]),
            f"{total['ns_per_pair']:.0f}",
        )
    console.print(drawn)
    print_goals(report["goals"], console)


def print_goals(goals: list[dict[str, Any]], console: Console) -> None:
    """Print goals, what was found, and ok or short."""
    drawn = _table("Goals", ("goal", "what"), ("found", "wanted", ""))
    for goal in goals:
        word = "ok" if goal["ok"] else "SHORT"
        drawn.add_row(goal["goal"], goal["what"], f"{goal['found']:.3g}", goal["wanted"], word)
    console.print(drawn)


def write_accuracy_csv(report: dict[str, Any], out: TextIO) -> None:
    """Write a row for every setting of every method."""
    _write(RUN_COLUMNS, [*report["rows"], *report["representation"]], out)


def write_triangles_csv(report: dict[str, Any], out: TextIO) -> None:
    """Write a row for every family and test."""
    _write(TRIANGLE_COLUMNS, report["rows"], out)


def _write(columns: tuple[str, ...], rows: list[dict[str, Any]], out: TextIO) -> None:
    writer = csv.DictWriter(out, columns, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)


def _print_where(report: dict[str, Any], console: Console) -> None:
    versions = ", ".join(f"{name} {version}" for name, version in report["versions"].items())
    console.print(f"{report['date']}, {report['cpu']}, {report['cores']} cores, {versions}")


def _table(title: str, names: tuple[str, ...], figures: tuple[str, ...]) -> Table:
    drawn = Table(title=title, title_justify="left")
    for name in names:
        drawn.add_column(name)
    for name in figures:
        drawn.add_column(name, justify="right")
    return drawn


def _number(value: float | None, unit: str = "") -> str:
    return "-" if value is None else f"{value:.2g}{unit}"
