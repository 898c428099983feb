"""Writes files so that no half-written one ever stands under its name: beside it, then renamed."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path
from typing import IO, Any

from gcodesim.interrupt import before_end

_numbers = count(1)
_unfinished: set[Path] = set()


@contextmanager
def replacing(path: str | Path, mode: str = "wb", **how: Any) -> Iterator[IO[Any]]:
    """Open a file that takes the place of another, or of none, when all of it is written.

    Devices, pipes, and files in folders that take no new file are written in place.

    Args:
        path: the file; a link to it stays one.
        mode: "wb" or "w".
        how: encoding and the like, as for `open`.

    Raises:
        OSError: it cannot be written; whatever stood there stands there still.
    """
    final = Path(os.path.realpath(path))
    beside = _beside(final)
    if beside is None:
        with open(final, mode, opener=_open_at_once, **how) as file:
            yield file
        return
    try:
        with open(beside, mode, **how) as file:
            yield file
        os.replace(beside, final)
    finally:
        beside.unlink(missing_ok=True)
        _unfinished.discard(beside)


def write_bytes(path: str | Path, content: bytes) -> None:
    """Write a whole file; OSError."""
    with replacing(path) as file:
        file.write(content)


def write_text(path: str | Path, text: str, errors: str = "strict") -> None:
    """Write a whole text file, in UTF-8 and with its line ends as they are; OSError."""
    with replacing(path, "w", encoding="utf-8", errors=errors, newline="\n") as file:
        file.write(text)


def _discard_unfinished() -> None:
    """Remove what is only half written."""
    for file in list(_unfinished):
        with suppress(OSError):
            file.unlink()


before_end(_discard_unfinished)


def _open_at_once(path: str, flags: int) -> int:
    """Open a file; a pipe that nobody reads is an error, not something to wait for."""
    handle = os.open(path, flags | getattr(os, "O_NONBLOCK", 0), 0o666)
    if hasattr(os, "set_blocking"):
        os.set_blocking(handle, True)
    return handle


def _beside(final: Path) -> Path | None:
    """A new file in the folder of another, with its rights; None where it is written in place."""
    rights = None
    with suppress(FileNotFoundError):
        there = final.stat()
        if not stat.S_ISREG(there.st_mode):
            return None
        open(final, "r+b").close()  # whether it may be written at all
        rights = stat.S_IMODE(there.st_mode)
    beside = final.parent / f".gcodesim-{os.getpid()}-{next(_numbers)}.part"
    try:
        _unfinished.add(beside)
        beside.touch(exist_ok=False)
        if rights is not None:
            beside.chmod(rights)
    except PermissionError:
        _unfinished.discard(beside)
        return None
    except OSError:
        _unfinished.discard(beside)
        raise
    return beside
