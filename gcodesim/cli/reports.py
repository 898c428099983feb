"""Where reports go: standard output, the files of --report, and the step summary of GitHub."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from gcodesim.errors import UsageError
from gcodesim.report.run import FORMATS, Run

if TYPE_CHECKING:
    from gcodesim.verdict import CheckResult

STDOUT = "-"


@dataclass(frozen=True)
class Destination:
    """A format and the file it is written to; ``-`` is standard output."""

    format: str
    path: str


def parse_destinations(
    texts: Sequence[str], option: str, taken: Mapping[str, str]
) -> list[Destination]:
    """What --report asks for; folders that are missing are made.

    Args:
        texts: as FORMAT=PATH.
        option: what to call the option in errors.
        taken: files that must not be overwritten, and what they are.

    Raises:
        UsageError: no such format, no path, a path that is a folder or taken or given twice, or a
            folder that cannot be made.
    """
    wanted: dict[str, Destination] = {}
    kinds = {Path(file).resolve(): kind for file, kind in taken.items()} if texts else {}
    for text in texts:
        name, sign, path = text.partition("=")
        if name not in FORMATS:
            valid = ", ".join(FORMATS)
            raise UsageError(f"{option} {text}: unknown format {name!r}; valid: {valid}")
        if not sign or not path:
            raise UsageError(f"{option} {text}: expected FORMAT=PATH, such as junit=report.xml")
        kind = "a folder" if Path(path).is_dir() else kinds.get(Path(path).resolve())
        if kind:
            raise UsageError(f"{option} {text}: {path} is {kind}: choose another file")
        key = text if path == STDOUT else str(Path(path).resolve())
        if key in wanted:
            raise UsageError(f"{option} {text}: {path} is given twice")
        wanted[key] = Destination(name, path)
    for destination in wanted.values():
        folder = Path(destination.path).parent
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise UsageError(f"{option}: {folder}: cannot be made: {error.strerror}") from error
    return list(wanted.values())


def print_text(result: CheckResult, no_color: bool) -> None:
    """Print the text report; without colour it holds no escape codes at all."""
    from rich.console import Console

    from gcodesim.report.text import print_report

    plain = no_color or bool(os.environ.get("NO_COLOR"))
    colors: Literal["auto"] | None = None if plain else "auto"
    print_report(result, Console(color_system=colors, highlight=False, soft_wrap=True))


def write_reports(run: Run, on_stdout: str, destinations: Sequence[Destination]) -> None:
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
            _write(destination.path, text, "w")
    summary = os.environ.get("GITHUB_STEP_SUMMARY")
    if summary and "github" in (on_stdout, *(d.format for d in destinations)):
        from gcodesim.report.github import summary as summed_up

        _write(summary, summed_up(run), "a")


def _write(path: str, text: str, mode: Literal["w", "a"]) -> None:
    try:
        # Names of files may hold bytes that are no text.
        with open(path, mode, encoding="utf-8", errors="replace", newline="\n") as file:
            file.write(text)
    except OSError as error:
        raise UsageError(f"{path}: cannot be written: {error.strerror}") from error
