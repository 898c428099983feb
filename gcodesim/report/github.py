"""GitHub: annotations for the ten weightiest findings, and the step summary for all of them."""

from __future__ import annotations

from collections.abc import Sequence

from gcodesim.checking.verdict import CheckResult
from gcodesim.findings.printing import printable
from gcodesim.report.outcome import RunOutcome
from gcodesim.report.rows import (
    CountedFinding,
    ignored_rows,
    ignored_title,
    repository_path,
    rows,
    title,
)

ANNOTATIONS = 10
"""GitHub shows ten annotations of a step and drops the others without a word."""

SUMMARY_BYTES = 1 << 20
"""GitHub refuses a step summary above 1 MiB."""

COMMANDS = {"error": "error", "warning": "warning", "note": "notice"}
MORE = "\n{} more findings: see the other reports.\n"


def render(run: RunOutcome) -> str:
    """Workflow commands, one per line, for standard output."""
    lines = [
        _command("error", repository_path(failure.program), 1, None, failure.message)
        for failure in run.failures
    ]
    lines += [_annotation(row) for row in rows(run)[:ANNOTATIONS]]
    # What was ignored has the last place, however much else there is.
    ignored = _ignored(ignored_rows(run), ANNOTATIONS - len(lines))
    return "".join(f"{line}\n" for line in [*lines[: ANNOTATIONS - len(ignored)], *ignored])


def summary(run: RunOutcome) -> str:
    """The step summary, Markdown: a table of programs, then the findings that count."""
    text = "### gcodesim\n\n| verdict | program | machine | findings |\n|---|---|---|---|\n"
    text += "".join(
        f"| not read | {_cell(failure.program)} | | {_cell(failure.message)} |\n"
        for failure in run.failures
    )
    text += "".join(map(_program, run.results)) + "\n"
    found = rows(run)
    lines = [f"- **{_cell(title(row))}** {_place(row)}\n" for row in found]
    lines += [f"- {_cell(ignored_title(row))} {_place(row)}\n" for row in ignored_rows(run)]
    room = SUMMARY_BYTES - len(text.encode()) - len(MORE) - 20
    for i, line in enumerate(lines):
        room -= len(line.encode())
        if room < 0:
            return text + "".join(lines[:i]) + MORE.format(len(lines) - i)
    return text + "".join(lines)


def _annotation(row: CountedFinding) -> str:
    finding = row.finding
    command = COMMANDS[finding.severity]
    return _command(command, row.path, row.line, finding.column, title(row))


def _ignored(found: Sequence[CountedFinding], room: int) -> list[str]:
    """A notice for everything ignored where there is room, else one that tells how much it is."""
    lines = [
        _command("notice", row.path, row.line, None, ignored_title(row))
        for row in found[: max(room, 1)]
    ]
    if len(found) > len(lines):
        first = found[len(lines) - 1]
        text = f"{ignored_title(first)}, and {len(found) - len(lines)} more findings ignored"
        lines[-1] = _command("notice", first.path, first.line, None, text)
    return lines


def _command(command: str, path: str, line: int, column: int | None, message: str) -> str:
    col = f",col={column}" if column else ""
    return f"::{command} file={_property(path)},line={line}{col}::{_data(message)}"


def _data(text: str) -> str:
    """Escaped as the runner undoes it; what else does not print would end the command."""
    return printable(text).replace("%", "%25")


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")


def _program(result: CheckResult) -> str:
    counts = f"{len(result.counted)}"
    counts += f", {len(result.ignored)} ignored" if result.ignored else ""
    program = _cell(result.title)
    return f"| {result.verdict.upper()} | {program} | {_cell(result.machine)} | {counts} |\n"


def _place(row: CountedFinding) -> str:
    block = f" `{printable(row.finding.block.strip()).replace('`', chr(39))}`"
    return f"{_cell(row.path)}:{row.line}" + (block if row.finding.block.strip() else "")


def _cell(text: str) -> str:
    """Text that Markdown and HTML leave as it is."""
    text = printable(text)
    for mark in "\\|*_`[]":
        text = text.replace(mark, f"\\{mark}")
    return text.replace("&", "&amp;").replace("<", "&lt;")
