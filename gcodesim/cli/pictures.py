"""The pictures that `check` writes, and the command `view` that opens one."""

from __future__ import annotations

import os
import re
import webbrowser
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, count
from pathlib import Path
from typing import TYPE_CHECKING

import click

from gcodesim.cli.outputs import Output, writing
from gcodesim.errors import UsageError
from gcodesim.output_file import write_bytes

if TYPE_CHECKING:
    from gcodesim.checking.verdict import CheckResult

NONE = "none"
"""What `--snapshot` is given where no picture is wanted in CI either."""

ENDINGS = {"snapshot": ".png", "html": ".html", "glb": ".glb"}


@dataclass
class Pictures:
    """Which pictures a run writes.

    Attributes:
        snapshot, html, glb: as asked for; None: not asked for.
        several: the run has several checks; each then has files of its own.
        failed: a picture that was asked for could not be written.
    """

    snapshot: str | None
    html: str | None
    glb: str | None
    several: bool
    failed: bool = False

    def __post_init__(self) -> None:
        """Refuse names that cannot be meant.

        Raises:
            UsageError: a name has another ending than its kind of file.
        """
        if self.snapshot and Path(self.snapshot).name == NONE:
            self.snapshot = NONE
        for option in ("snapshot", "html", "glb"):
            path = getattr(self, option)
            if path and path != NONE:
                refuse_ending(option, path)

    def files(self, names: Sequence[str]) -> Iterator[Output]:
        """Yield every file that was asked for, of checks with these names."""
        for option in ("snapshot", "html", "glb"):
            path = getattr(self, option)
            if path and path != NONE:
                files = (str(self._file(path, name)) for name in names)
                yield from ((f"--{option} {file}", file) for file in files)

    def snapshot_file(self, name: str) -> str:
        """Where the snapshot of a check belongs if it shows anything; "" where none is wanted."""
        if self.snapshot == NONE:
            return ""
        if self.snapshot:
            return str(self._file(self.snapshot, name))
        in_ci = os.environ.get("CI", "").lower() == "true"
        return f"gcodesim-{name}.png" if in_ci else ""

    def write(self, result: CheckResult, name: str) -> CheckResult:
        """Write the pictures of a check; the result then knows them, and forgets the motion.

        The motion of a long program is large, and has served its turn.
        """
        try:
            result = self._write(result, name)
        except UsageError as error:
            click.echo(f"gcodesim: {error}", err=True)
            self.failed = True
        return replace(result, replay=None)

    def _write(self, result: CheckResult, name: str) -> CheckResult:
        """Write whatever is due; one that was not asked for may fail with a note.

        Raises:
            UsageError: one that was asked for cannot be written.
        """
        replay = result.replay
        if replay is None:
            return result
        if self.html:
            from gcodesim.report.html import page

            # Names of files may hold bytes that are no text.
            self._put("html", name, page(result, replay).encode("utf-8", "replace"))
        if self.glb:
            from gcodesim.report.glb import model

            self._put("glb", name, model(replay))
        file = self.snapshot_file(name)
        if not (file and result.shown):
            return result  # without one the module, which is slow to import, is not needed
        from gcodesim.report.snapshot import with_snapshot

        try:
            with writing(f"--snapshot {file}"):
                return with_snapshot(result, file)
        except UsageError as error:
            if self.snapshot:
                raise
            click.echo(f"gcodesim: no snapshot: {error}", err=True)
            return result

    def _put(self, option: str, name: str, content: bytes) -> None:
        """Write one file of a check; UsageError."""
        file = self._file(getattr(self, option), name)
        with writing(f"--{option} {file}"):
            write_bytes(file, content)

    def _file(self, asked: str, name: str) -> Path:
        """The file of one check: of several, its name is put before the ending."""
        path = Path(asked)
        return path.with_stem(f"{path.stem}-{name}") if self.several else path


def refuse_ending(option: str, path: str) -> None:
    """UsageError where a picture or page has not the ending of its kind: it may be a program."""
    if Path(path).suffix.lower() != ENDINGS[option]:
        text = f"--{option} {path}: expected the name of a {ENDINGS[option]} file"
        raise UsageError(text + f", or {NONE}" * (option == "snapshot"))


def picture_names(checks: Sequence[tuple[str, str]]) -> list[str]:
    """A part of a file name for each check, a program and a machine file: no two are the same.

    It is the name of the program, with that of the machine where the program has several, and with
    a number where files of one name lie in several folders.
    """
    machines: dict[str, set[str]] = {}
    for program, machine in checks:
        machines.setdefault(program, set()).add(machine)
    names: dict[str, None] = {}
    for program, machine in checks:
        several = len(machines[program]) > 1
        name = _stem(program) + (f"-{_stem(machine)}" if several else "")
        numbered = (f"{name}-{number}" for number in count(2))
        names[next(free for free in chain([name], numbered) if free not in names)] = None
    return list(names)


def _stem(file: str) -> str:
    """Name of a file without folder and ending, as a part of another."""
    return re.sub(r"[^\w.-]+", "", Path(file).stem) or "program"


@click.command()
@click.argument("page", metavar="REPORT.html")
def view(page: str) -> None:
    """Open a page that `check --html` wrote in the browser."""
    path = Path(page)
    if not path.is_file():
        raise UsageError(f"{page} does not exist: write it with gcodesim check ... --html {page}")
    with path.open("rb") as file:
        head = file.read(1000)
    if b'name="generator" content="gcodesim"' not in head:
        raise UsageError(f"{page} is no replay: write one with gcodesim check ... --html PATH.html")
    address = path.resolve().as_uri()
    if not webbrowser.open(address):
        raise UsageError(f"no browser was found: open {address} in one")
