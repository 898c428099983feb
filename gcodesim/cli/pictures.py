"""The pictures that `check` writes, and the command `view` that opens one."""

from __future__ import annotations

import os
import re
import webbrowser
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gcodesim.errors import UsageError

if TYPE_CHECKING:
    from gcodesim.verdict import CheckResult

NONE = "none"
"""What `--snapshot` is given where no picture is wanted in CI either."""

ENDINGS = {"snapshot": ".png", "html": ".html", "glb": ".glb"}

OPTIONS = (
    click.option(
        "--snapshot",
        metavar="PATH.png",
        help="Write a picture of the first contact. Left out: with the environment variable "
        "CI=true gcodesim-PROGRAM.png in the working folder, unless this says none.",
    ),
    click.option("--html", metavar="PATH.html", help="Write a page that replays the motion in 3D."),
    click.option("--glb", metavar="PATH.glb", help="Write the moving machine as animated glTF."),
)


def picture_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options that name pictures."""
    for option in reversed(OPTIONS):
        command = option(command)
    return command


@dataclass
class Pictures:
    """Which pictures a run writes.

    Attributes:
        snapshot, html, glb: as asked for; None: not asked for.
        several: the run has several programs; each then has files of its own.
        written: files so far.
        failed: a picture that was asked for could not be written.
    """

    snapshot: str | None
    html: str | None
    glb: str | None
    several: bool
    written: set[Path] = field(default_factory=set)
    failed: bool = False

    def __post_init__(self) -> None:
        """Refuse names that cannot be meant, and make folders that are missing.

        Raises:
            UsageError: a name has another ending than its kind of file.
        """
        if self.snapshot and Path(self.snapshot).name == NONE:
            self.snapshot = NONE
        for option in ("snapshot", "html", "glb"):
            path, ending = getattr(self, option), ENDINGS[option]
            if path and path != NONE:
                if Path(path).suffix.lower() != ending:
                    text = f"--{option} {path}: expected the name of a {ending} file"
                    raise UsageError(text + f", or {NONE}" * (option == "snapshot"))
                Path(path).parent.mkdir(parents=True, exist_ok=True)

    def write(self, result: CheckResult) -> CheckResult:
        """Write the pictures of one program; the result then knows them, and forgets the motion.

        The motion of a long program is large, and has served its turn.
        """
        try:
            pictures = tuple(str(file) for file in self._write(result))
        except OSError as error:
            click.echo(f"gcodesim: {error}", err=True)
            pictures, self.failed = (), True
        return replace(result, pictures=pictures, replay=None)

    def _write(self, result: CheckResult) -> Iterator[Path]:
        """Write whatever is due; yield the files that a report can show as pictures."""
        replay = result.replay
        if replay is None:
            return
        if self.html:
            from gcodesim.report.html import page

            text = page(result, replay).encode("utf-8")
            self._file(self.html, result.program).write_bytes(text)
        if self.glb:
            from gcodesim.report.glb import model

            self._file(self.glb, result.program).write_bytes(model(replay))
        contact = result.first_contact
        in_ci = os.environ.get("CI", "").lower() == "true"
        if contact and self.snapshot != NONE and (self.snapshot or in_ci):
            from gcodesim.report.snapshot import snapshot

            picture = snapshot(replay.machine, contact, result.device)
            yield from self._snapshot(result.program, picture)

    def _snapshot(self, program: str, picture: bytes) -> Iterator[Path]:
        """Write the snapshot; one that nobody asked for may fail with a note."""
        if self.snapshot:
            file = self._file(self.snapshot, program)
            file.write_bytes(picture)
            yield file
            return
        file = self._unwritten(Path(f"gcodesim-{_stem(program)}.png"))
        try:
            file.write_bytes(picture)
            yield file
        except OSError as error:
            click.echo(f"gcodesim: no snapshot: {error}", err=True)

    def _file(self, asked: str, program: str) -> Path:
        """The file of one program: of several, its name is put before the ending."""
        path = Path(asked)
        if self.several:
            path = path.with_stem(f"{path.stem}-{_stem(program)}")
        return self._unwritten(path)

    def _unwritten(self, path: Path) -> Path:
        """The path, or one with a number where programs of one name lie in several folders."""
        number, free = 1, path
        while free in self.written:
            number += 1
            free = path.with_stem(f"{path.stem}-{number}")
        self.written.add(free)
        return free


def _stem(program: str) -> str:
    """Name of a program without folder and ending, as a part of a file name."""
    return re.sub(r"[^\w.-]+", "", Path(program).stem) or "program"


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
