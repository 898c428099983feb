"""Program text from bytes, and lines from text; nothing is changed or lost on the way."""

from __future__ import annotations

from pathlib import Path

from gcodesim.errors import UsageError


def decode(data: bytes) -> str:
    """Return the text of a program: UTF-8 (a byte order mark is dropped), else Latin-1."""
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def read_program(path: str | Path) -> str:
    """Return the text of the program file at `path`.

    Raises:
        UsageError: the file cannot be read.
    """
    try:
        return decode(Path(path).read_bytes())
    except OSError as error:
        raise UsageError(f"{path}: cannot be read: {error.strerror or error}") from error


def split_lines(text: str) -> list[str]:
    """Return the lines of a program, ended by LF, CRLF or CR and by nothing else."""
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    if lines[-1] == "":
        lines.pop()
    return lines
