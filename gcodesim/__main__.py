"""Runs the command line as `gcodesim` or `python -m gcodesim`, whatever its streams are."""

from __future__ import annotations

import io
import os
import sys
from contextlib import suppress
from typing import Any, NoReturn

from gcodesim import interrupt


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


def run() -> NoReturn:
    """Run the command of the command line, and exit with its code."""
    _open_streams()
    interrupt.arm()
    from gcodesim.cli import main  # after the signal: it takes a while

    code = 0
    try:
        main(prog_name="gcodesim")
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else int(bool(end.code))
    interrupt.disarm()
    sys.exit(_flushed(code))


def _open_streams() -> None:
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


def _flushed(code: int) -> int:
    """Write what is still to be written; the exit code, that of an error where it cannot be."""
    from gcodesim.checking.verdict import USAGE_EXIT

    try:
        sys.stdout.flush()
    except OSError as error:
        _drop(1)
        if code != interrupt.EXIT:
            with suppress(OSError):
                why = f"standard output cannot be written: {error.strerror}"
                print(f"gcodesim: {why}", file=sys.stderr)
            code = USAGE_EXIT
    sys.stderr.flush()
    return code


def _drop(number: int) -> None:
    """Let a stream lead nowhere from now on."""
    void = os.open(os.devnull, os.O_WRONLY)
    os.dup2(void, number)
    os.close(void)


if __name__ == "__main__":
    run()
