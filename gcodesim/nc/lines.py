"""Program text from bytes, and lines from text; nothing is changed or lost on the way."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from gcodesim.errors import UsageError
from gcodesim.input_file import read_bytes

CHUNK = 1 << 22
"""Bytes looked at in one step: small enough for its arrays to stay small."""

LEADER = b"\x00\x7f"
"""Tape leader: NUL and DEL before the first block and after the last are ignored."""


TAPE_CHARACTERS = "\0\x11\x12\x13\x14\x7f"
"""NUL, DC1 to DC4 (XON, XOFF) and DEL: what a tape or a serial line leaves in the text."""


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
        return decode(read_bytes(path))
    except OSError as error:
        raise UsageError(f"{path}: cannot be read: {error.strerror or error}") from error


class Lines(Sequence[str]):
    """The lines of a program, ended by LF, CRLF or CR and by nothing else; decoded when asked for.

    Attributes:
        data: the text as UTF-8 with LF line ends.
        bounds: where each line begins in data, and one past the last line end, shape (n + 1,).
    """

    def __init__(self, text: str) -> None:
        data = text.encode("utf-8", "surrogatepass")
        if b"\r" in data:
            data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        if data[:1] and data[0] in LEADER:
            data = data.lstrip(LEADER)
        if data[-1:] and data[-1] in LEADER:
            data = data.rstrip(LEADER)
        self.data = data
        self.bounds = _line_bounds(data)
        # Asked for one by one, the bounds come as plain numbers.
        self._bounds = self.bounds.data

    def __len__(self) -> int:
        return len(self.bounds) - 1

    @overload
    def __getitem__(self, index: int) -> str: ...
    @overload
    def __getitem__(self, index: slice) -> list[str]: ...
    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        count, bounds = len(self._bounds) - 1, self._bounds
        if index < 0:
            index += count
        if not 0 <= index < count:
            raise IndexError(index)
        return self.data[bounds[index] : bounds[index + 1] - 1].decode("utf-8", "surrogatepass")

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Sequence) and list(self) == list(other)

    __hash__ = None  # type: ignore[assignment]

    def line_at(self, place: int) -> int:
        """Return the index of the line that holds the byte at `place`."""
        return int(np.searchsorted(self.bounds, place, side="right")) - 1


def split_lines(text: str) -> Lines:
    """Return the lines of a program."""
    return Lines(text)


def _line_bounds(data: bytes) -> NDArray[np.int64]:
    characters = np.frombuffer(data, np.uint8)
    found = [np.zeros(1, np.int64)]
    for begin in range(0, len(data), CHUNK):
        ends = np.flatnonzero(characters[begin : begin + CHUNK] == ord("\n"))
        found.append(ends + (begin + 1))
    if data and data[-1:] != b"\n":
        found.append(np.array([len(data) + 1]))
    return np.concatenate(found)
