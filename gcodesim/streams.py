"""Standard streams that may be closed, full, or left by their reader: the verdict still counts."""

from __future__ import annotations

import io
import os
import sys
from typing import Any


class Sink(io.FileIO):
    """A standard stream whose reader may go away, as that of `| head`: the verdict still counts."""

    forgiven: type[OSError] = BrokenPipeError

    def write(self, data: Any) -> int:
        """Write, or drop what nobody reads."""
        try:
            return super().write(data)
        except self.forgiven:
            _drop(self.fileno())
            return len(data)


class LastSink(Sink):
    """Standard error: where it cannot be written, there is nobody left to tell."""

    forgiven = OSError


def open_streams() -> None:
    """Open what was closed, so that no other file gets its number; forgive lost readers."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # the lowest number that is free
    sys.stdout = _forgiving(sys.stdout, 1, Sink)
    sys.stderr = _forgiving(sys.stderr, 2, LastSink)


def _forgiving(stream: Any, number: int, kind: type[Sink]) -> io.TextIOWrapper:
    """A standard stream, made anew; one that is closed leads nowhere."""
    raw = kind(number, "wb", closefd=False)
    if stream is None:
        return io.TextIOWrapper(io.BufferedWriter(raw), encoding="utf-8", errors="replace")
    return io.TextIOWrapper(
        io.BufferedWriter(raw),
        encoding=stream.encoding,
        errors=stream.errors,
        line_buffering=stream.line_buffering or stream.write_through,
    )


def flush() -> str:
    """Write what is still to be written; return why standard output cannot be, or nothing."""
    why = ""
    try:
        sys.stdout.flush()
    except OSError as error:
        _drop(1)
        why = error.strerror or str(error)
    sys.stderr.flush()
    return why


def _drop(number: int) -> None:
    """Let a stream lead nowhere from now on."""
    void = os.open(os.devnull, os.O_WRONLY)
    os.dup2(void, number)
    os.close(void)
