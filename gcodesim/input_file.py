"""Reads files whole; what would never end or does not fit (devices, lone pipes) is refused.

Whatever cannot be read is an OSError whose `strerror` says why, so that a caller names the file.
"""

from __future__ import annotations

import errno
import hashlib
import io
import os
import select
import stat
from collections.abc import Iterable
from pathlib import Path
from typing import BinaryIO

TEXT_BYTES = 4 << 20
"""Largest file written by hand: machine, tools, setup, settings, INI [bytes]. PyYAML reads about a
megabyte a second."""

DATA_BYTES = 2 << 30
"""Largest program, mesh or list of results [bytes]: a hundred million blocks."""

PIPE_S = 10
"""A pipe from which nothing came for so long is taken for one that nobody writes to [s]."""

CHUNK_BYTES = 1 << 16


def file_mark(path: str | Path) -> str:
    """Return what tells one content of a file from another; "" where it cannot be read."""
    try:
        return hashlib.sha256(read_bytes(path)).hexdigest()
    except OSError:
        return ""


def read_bytes(path: str | Path, limit: int = DATA_BYTES) -> bytes:
    """Return the content of a file, or of a pipe such as `<(unzip -p a.zip)`.

    Args:
        path: the file.
        limit: largest size that is read [bytes].

    Raises:
        OSError: it cannot be read, is a device or a pipe that nobody writes to, or is too large.
    """
    try:
        # A pipe without a writer must not hold us up while it is opened.
        flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
        handle = os.open(path, flags)
    except ValueError:  # of Python, where a name cannot be handed to the system
        raise OSError(errno.EINVAL, "no file has such a name", str(path)) from None
    with os.fdopen(handle, "rb", buffering=0) as file:
        kind = os.fstat(handle)
        if stat.S_ISDIR(kind.st_mode):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
        if stat.S_ISREG(kind.st_mode):
            if kind.st_size > limit:
                raise _too_large(path, kind.st_size, limit)
            try:
                return file.readall()
            except MemoryError:
                raise OSError(errno.ENOMEM, os.strerror(errno.ENOMEM), str(path)) from None
        if stat.S_ISFIFO(kind.st_mode) or stat.S_ISSOCK(kind.st_mode):
            return _piped(path, handle, limit)
        if str(path) == os.devnull:
            return b""
    raise OSError(errno.EINVAL, "a device, not a file", str(path))


def read_stream(stream: BinaryIO) -> bytes:
    """Return all that comes through a stream that is open, as standard input is.

    Raises:
        OSError: it is a device but no terminal, or more comes than is read.
    """
    try:
        kind = os.fstat(stream.fileno())
        device = stat.S_ISCHR(kind.st_mode) and not stream.isatty()
        if device and not os.path.samestat(kind, os.stat(os.devnull)):
            raise OSError(errno.EINVAL, "a device, not a file")
    except io.UnsupportedOperation:  # it is no file of the system, but a part of this program
        pass
    return _whole(iter(lambda: stream.read(CHUNK_BYTES), b""), "-", DATA_BYTES)


def read_text(path: str | Path) -> str:
    """Return the text of a file written by hand: UTF-8, with or without a byte order mark.

    Raises:
        OSError: as for `read_bytes`.
        UnicodeDecodeError: it is not UTF-8.
    """
    text = read_bytes(path, TEXT_BYTES).decode("utf-8-sig")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def refuse_odd(path: str | Path) -> None:
    """Refuse what a reader of others, which is given the name alone, would hang on.

    Raises:
        OSError: it cannot be opened, or is no plain file, or is too large.
    """
    if Path(path).is_file():
        size = Path(path).stat().st_size
        if size > DATA_BYTES:
            raise _too_large(path, size, DATA_BYTES)
        os.close(os.open(path, os.O_RDONLY))
    else:
        read_bytes(path, 0)
        raise OSError(errno.EINVAL, "not a plain file", str(path))


def _piped(path: str | Path, handle: int, limit: int) -> bytes:
    """Everything that comes through a pipe."""

    def next_chunk() -> bytes:
        if not select.select([handle], [], [], PIPE_S)[0]:
            raise OSError(errno.EINVAL, f"nothing came through this pipe for {PIPE_S} s", str(path))
        return os.read(handle, CHUNK_BYTES)

    return _whole(iter(next_chunk, b""), path, limit)


def _whole(chunks: Iterable[bytes], path: str | Path, limit: int) -> bytes:
    """Chunks in one, while they are not too many."""
    whole = bytearray()
    for chunk in chunks:
        whole += chunk
        if len(whole) > limit:
            raise _too_large(path, len(whole), limit)
    return bytes(whole)


def _too_large(path: str | Path, size: int, limit: int) -> OSError:
    text = f"{size:,} bytes, and {limit:,} are read at most"
    return OSError(errno.EFBIG, text, str(path))
