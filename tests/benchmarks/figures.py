"""Regenerates the figures of the studies that the README quotes, and the results behind them.

Run from the repository root: python tests/benchmarks/figures.py [--quick] [--only NAME]
Writes CSV, PNG and the figures as JSON into tests/benchmarks/results/, and the tables between the
marks `<!-- figures: NAME -->` and `<!-- end -->` of the README.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from gcodesim.cli.arguments import progress_bar
from gcodesim.report.study_plot import plot_accuracy
from gcodesim.report.study_report import write_accuracy_csv, write_triangles_csv
from gcodesim.study.accuracy import FULL, QUICK, study_accuracy
from gcodesim.study.leave_out_study import leave_out_study
from gcodesim.study.stability import stability_study
from gcodesim.study.triangle_study import study_triangles

ROOT = Path(__file__).resolve().parents[2]
RESULTS = ROOT / "tests" / "benchmarks" / "results"
PAIRS, QUICK_PAIRS = 100_000, 2_000
USUAL = {"period [ms]": 0.1, "tolerance [mm]": 1e-3}
"""Settings that the README quotes: those of `gcodesim check`."""

Report = dict[str, Any]


def main() -> int:
    """Run the studies, write their results, and put the figures into the README."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="small studies, to try the script")
    parser.add_argument("--only", choices=sorted(STUDIES), help="run only this study")
    options = parser.parse_args()
    for name, (study, table) in STUDIES.items():
        if options.only not in (None, name):
            continue
        with progress_bar(name, False) as progress:
            report = study(options.quick, progress)
        kept = {
            key: value
            for key, value in report.items()
            if key not in ("rows", "representation", "cases", "savings", "runs")
        }
        kept["table"] = table(report)
        path = RESULTS / f"study-{name}.json"
        path.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
        print(f"written: {path}", file=sys.stderr)
        put_into_readme(name, kept["table"])
    return 0


def put_into_readme(name: str, table: list[str]) -> None:
    """Replace what stands between the marks of a table."""
    readme = ROOT / "README.md"
    marks = re.compile(rf"(<!-- figures: {name} -->\n).*?(<!-- end -->)", re.DOTALL)
    text = readme.read_text(encoding="utf-8")
    shown = "\n".join(table) + "\n"
    readme.write_text(marks.sub(lambda m: m[1] + shown + m[2], text), encoding="utf-8")


def measure_accuracy(quick: bool, progress: Callable[[float], None]) -> Report:
    """The accuracy study, with its rows and its diagrams."""
    report = study_accuracy(QUICK if quick else FULL, progress)
    with (RESULTS / "study-accuracy.csv").open("w", encoding="utf-8", newline="") as out:
        write_accuracy_csv(report, out)
    plot_accuracy(report, str(RESULTS / "study-accuracy.png"))
    return report


def accuracy_table(report: Report) -> list[str]:
    """Every method with the settings of a check: errors, misses, and the cost on S5."""
    lines = [
        "| method | largest error | missed | not the expected sample | ms on S5 | poses on S5 |",
        "|---|---|---|---|---|---|",
    ]
    for method in dict.fromkeys(row["method"] for row in report["rows"]):
        rows = [
            row
            for row in report["rows"]
            if row["method"] == method and row["setting"] == USUAL[row["knob"]]
        ]
        (cost,) = (row for row in rows if row["scene"] == "S5")
        largest = max(row["error_max"] for row in rows if row["error_max"] is not None)
        runs = sum(row["runs"] for row in rows)
        counts = [f"{sum(row[key] for row in rows)} of {runs}" for key in ("missed", "unexpected")]
        setting = f"{cost['setting']:g} {cost['knob'].partition('[')[2].rstrip(']')}"
        lines.append(
            f"| {method}, {setting} | {largest:.1e} s | {counts[0]} | {counts[1]} | "
            f"{cost['wall_s'] * 1e3:.2f} | {cost['poses']:.0f} |"
        )
    return [*lines, "", *goal_lines(report)]


def goal_lines(report: Report) -> list[str]:
    """How many goals are reached, and each that is not."""
    short = [goal for goal in report["goals"] if not goal["ok"]]
    reached = f"{len(report['goals']) - len(short)} of {len(report['goals'])} goals are reached."
    if not short:
        return [reached]
    rows = [
        f"| {goal['goal']} | {goal['what']} | {goal['found']:.3g} | {goal['wanted']} |"
        for goal in short
    ]
    return [f"{reached} Short are:", "", "| goal | | found | wanted |", "|---|---|---|---|", *rows]


def measure_triangles(quick: bool, progress: Callable[[float], None]) -> Report:
    """The triangle study, with its rows."""
    report = study_triangles(QUICK_PAIRS if quick else PAIRS, progress)
    with (RESULTS / "study-triangles.csv").open("w", encoding="utf-8", newline="") as out:
        write_triangles_csv(report, out)
    return report


def triangles_table(report: Report) -> list[str]:
    """Every test over all families."""
    lines = [
        "| test | missed | deepest miss | false alarms | farthest | ns per pair |",
        "|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {t['test']} | {t['missed']} ({t['miss_rate']:.2%}) | {t['deepest_miss_mm']:.1e} mm | "
        f"{t['false']} ({t['false_rate']:.2%}) | {t['farthest_false_mm']:.1e} mm | "
        f"{t['ns_per_pair']:.0f} |"
        for t in report["totals"]
    ]
    return [*lines, "", *goal_lines(report)]


def measure_stability(quick: bool, progress: Callable[[float], None]) -> Report:
    """The stability study, case by case."""
    return stability_study(quick, progress).as_report()


def stability_table(report: Report) -> list[str]:
    """Per topic: cases, those that keep their tolerance, and those the usual formulation misses."""
    lines = [
        "| topic | cases | ours within tolerance | usual formulation misses it |",
        "|---|---|---|---|",
    ]
    for topic in dict.fromkeys(case["topic"] for case in report["cases"]):
        cases = [case for case in report["cases"] if case["topic"] == topic]
        usual = [case["naive_ok"] for case in cases if case["usual"]]
        missed = f"{len(usual) - sum(map(bool, usual))} of {len(usual)}" if usual else "-"
        lines.append(f"| {topic} | {len(cases)} | {sum(c['ok'] for c in cases)} | {missed} |")
    return lines


def measure_leave_out(quick: bool, progress: Callable[[float], None]) -> Report:
    """What leaving out saves, on the samples and on random programs, as shipped and finer."""
    programs = [str(ROOT / "samples" / name) for name in ("part.nc", "five_axis_finish.nc")]
    count, times = (1, (0,)) if quick else (4, (0, 3))
    done = [leave_out_study(programs, "table_tilt", count, 1, refine, progress) for refine in times]
    return done[0].as_report() | {"runs": [asdict(study)["savings"] for study in done]}


def leave_out_table(report: Report) -> list[str]:
    """Per kind of program and fineness of the meshes: what is left out, and the time."""
    lines = [
        "| programs | triangles | pairs out | triangles out | tests a look | ms | answer |",
        "|---|---|---|---|---|---|---|",
    ]
    for savings in report["runs"]:
        for kind in dict.fromkeys(row["kind"] for row in savings):
            rows = [row for row in savings if row["kind"] == kind]
            total = {
                key: sum(row[key] for row in rows) for key in rows[0] if key.startswith(SUMMED)
            }
            times = (total["seconds_full"] * 1e3 / len(rows), total["seconds"] * 1e3 / len(rows))
            same = sum(row["agrees"] for row in rows)
            lines.append(
                f"| {kind} | {rows[0]['triangles']} | {total['pairs_out'] / total['pairs']:.0%} | "
                f"{total['triangles_out'] / total['triangles']:.0%} | "
                f"{total['tests'] / total['items']:.0f} | {times[0]:.0f} -> {times[1]:.0f} | "
                f"the same {same} of {len(rows)} |"
            )
    return lines


SUMMED = ("seconds", "pairs", "triangles", "tests", "items")

STUDIES = {
    "accuracy": (measure_accuracy, accuracy_table),
    "triangles": (measure_triangles, triangles_table),
    "stability": (measure_stability, stability_table),
    "leave-out": (measure_leave_out, leave_out_table),
}

if __name__ == "__main__":
    sys.exit(main())
