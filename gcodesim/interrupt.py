"""Ends the program at Ctrl-C with one line and exit code 130, imports and native code included."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import FrameType

EXIT = 130
MESSAGE = "gcodesim: interrupted; what has no report is not decided"

PATIENCE_S = 3.0
"""A command has so long to tidy up [s]: compilers and kernels hear of no signal, and libraries
swallow exceptions that are raised inside of them."""


class _Watch:
    """What is known of Ctrl-C in this process.

    Attributes:
        armed: this is a command of its own, not a library in another program.
        tidying: the command catches KeyboardInterrupt, and tidies up then.
        said: the message is out.
    """

    armed = tidying = said = False


def arm() -> None:
    """Take over Ctrl-C, as early as possible: until `caught`, it ends the process at once."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # started by `nohup` or with `&`
        return
    _Watch.armed = True
    signal.signal(signal.SIGINT, _on_signal)
    if hasattr(os, "set_blocking"):
        heard, told = os.pipe()
        os.set_blocking(told, False)
        signal.set_wakeup_fd(told, warn_on_full_buffer=False)
        threading.Thread(target=_wait, args=(heard,), daemon=True).start()


def disarm() -> None:
    """Let Ctrl-C change nothing any more: the verdict is out."""
    if _Watch.armed:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.set_wakeup_fd(-1)


@contextmanager
def caught() -> Iterator[None]:
    """Raise KeyboardInterrupt at Ctrl-C while the enclosed block runs."""
    _Watch.tidying = True
    try:
        yield
    finally:
        _Watch.tidying = False


def say() -> None:
    """Print the message, once."""
    if not _Watch.said:
        _Watch.said = _Watch.armed
        with suppress(OSError):
            print(MESSAGE, file=sys.stderr, flush=True)


def _on_signal(number: int, frame: FrameType | None) -> None:
    if _Watch.tidying:
        _Watch.tidying = False  # a second Ctrl-C does not wait
        raise KeyboardInterrupt
    _end()


def _wait(heard: int) -> None:
    """End the process when the main thread does not, a while after a signal was heard."""
    os.read(heard, 1)
    time.sleep(PATIENCE_S)
    _end()


def _end() -> None:
    from gcodesim.output_file import discard_unfinished

    discard_unfinished()
    if not _Watch.said:
        _Watch.said = True
        with suppress(OSError):  # sys.stderr may be in the middle of a write
            os.write(2, f"{MESSAGE}\n".encode())
    os._exit(EXIT)
