"""Where reports go: standard output, the files of --report, and the step summary of GitHub."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from gcodesim.cli.outputs import Output, writing
from gcodesim.errors import UsageError
from gcodesim.output_file import write_text
from gcodesim.report.outcome import FORMATS, RunOutcome

if TYPE_CHECKING:
    from gcodesim.checking.verdict import CheckResult

OPTION, STDOUT = "--report", "-"


@dataclass(frozen=True)
class Destination:
    """A format and the file it is written to; ``-`` is standard output."""

    format: str
    path: str

    @property
    def asked(self) -> str:
        """The option that asks for it."""
        return f"{OPTION} {self.format}={self.path}"


def parse_destinations(texts: Sequence[str]) -> list[Destination]:
    """What --report asks for, as FORMAT=PATH.

    Raises:
        UsageError: no such format, no path, a path that is a folder, or given twice.
    """
    wanted: dict[str, Destination] = {}
    for text in texts:
        name, sign, path = text.partition("=")
        if name not in FORMATS:
            valid = ", ".join(FORMATS)
            raise UsageError(f"{OPTION} {text}: unknown format {name!r}; valid: {valid}")
        if not sign or not path:
            raise UsageError(f"{OPTION} {text}: expected FORMAT=PATH, such as junit=report.xml")
        if Path(path).is_dir():
            raise UsageError(f"{OPTION} {text}: {path} is a folder: choose another file")
        key = text if path == STDOUT else str(Path(path).resolve())
        if key in wanted:
            raise UsageError(f"{OPTION} {text}: {path} is given twice")
        wanted[key] = Destination(name, path)
    return list(wanted.values())


def report_files(destinations: Sequence[Destination], on_stdout: str = "") -> list[Output]:
    """The files among the destinations, and the step summary where GitHub asks for it."""
    files = [(place.asked, place.path) for place in destinations if place.path != STDOUT]
    summary = _summary_file(destinations, on_stdout)
    return [*files, *([(f"GITHUB_STEP_SUMMARY {summary}", summary)] if summary else [])]


def _summary_file(destinations: Sequence[Destination], on_stdout: str) -> str:
    """The file of the step summary; "" where none is written."""
    asked = "github" in (on_stdout, *(place.format for place in destinations))
    return os.environ.get("GITHUB_STEP_SUMMARY", "") if asked else ""


def print_text(result: CheckResult, no_color: bool) -> None:
    """Print the text report; without colour it holds no escape codes at all."""
    from rich.console import Console

    from gcodesim.report.text import print_report

    plain = no_color or bool(os.environ.get("NO_COLOR"))
    colors: Literal["auto"] | None = None if plain else "auto"
    print_report(result, Console(color_system=colors, highlight=False, soft_wrap=True))


def write_reports(run: RunOutcome, on_stdout: str, destinations: Sequence[Destination]) -> None:
    """Write every report but the text on standard output, which is printed as it comes.

    Raises:
        UsageError: a file cannot be written.
    """
    from gcodesim.report.formats import RENDER

    if on_stdout != "text" and (run.results or len(run.failures) > 1):
        click.echo(RENDER[on_stdout](run), nl=False)
    for destination in destinations:
        text = RENDER[destination.format](run)
        if destination.path == STDOUT:
            click.echo(text, nl=False)
        else:
            # Names of files may hold bytes that are no text.
            with writing(destination.asked):
                write_text(destination.path, text, errors="replace")
    if summary := _summary_file(destinations, on_stdout):
        from gcodesim.report.github import summary as summed_up

        how = {"encoding": "utf-8", "errors": "replace"}
        with writing(f"GITHUB_STEP_SUMMARY {summary}"), open(summary, "ab") as file:
            file.write(summed_up(run).encode(**how))
