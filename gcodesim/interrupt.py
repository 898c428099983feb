"""Ends the program at Ctrl-C with one line and exit code 130, imports and native code included.

It is the first thing that is imported, and imports next to nothing: what comes before hears of no
handler.
"""

from __future__ import annotations

import _signal as signal  # type: ignore[import-not-found] # `signal` imports ten times as long
import os
import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from types import FrameType, TracebackType

EXIT = 130
MESSAGE = "gcodesim: interrupted; what has no report is not decided"

PATIENCE_S = 3.0
"""A command has so long to tidy up [s]: compilers and kernels hear of no signal, and libraries
swallow exceptions that are raised inside of them."""


class _Watch:
    """What is known of Ctrl-C in this process.

    Attributes:
        heard: Ctrl-C has come.
        armed: this is a command of its own, not a library in another program.
        tidying: the command catches KeyboardInterrupt, and tidies up then.
        said: the message is out.
        last: what is done before the process ends at once.
    """

    armed = tidying = said = heard = False
    last: list[Callable[[], None]] = []  # noqa: RUF012 (there is one)


def arm() -> None:
    """Take over Ctrl-C, as early as possible: until `caught`, it ends the process at once."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # started by `nohup` or with `&`
        return
    _Watch.armed = True
    signal.signal(signal.SIGINT, _on_signal)


def watch() -> None:
    """End the process too when the main thread is busy elsewhere; opens files: call it late."""
    if _Watch.armed and hasattr(os, "set_blocking"):
        import threading

        heard, told = os.pipe()
        os.set_blocking(told, False)
        signal.set_wakeup_fd(told, warn_on_full_buffer=False)
        threading.Thread(target=_wait, args=(heard,), daemon=True).start()


def disarm() -> None:
    """Let Ctrl-C change nothing any more: the verdict is out."""
    if _Watch.armed:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.set_wakeup_fd(-1)


class Caught:
    """Raises KeyboardInterrupt at Ctrl-C while the enclosed block runs."""

    def __enter__(self) -> None:
        _Watch.tidying = True

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        _Watch.tidying = False


def was_heard() -> bool:
    """Whether Ctrl-C has come."""
    return _Watch.heard


def before_end(action: Callable[[], None]) -> None:
    """Have something done before the process ends at once; it must not raise."""
    _Watch.last.append(action)


def say() -> None:
    """Print the message, once."""
    if not _Watch.said:
        _Watch.said = _Watch.armed
        print(MESSAGE, file=sys.stderr, flush=True)


def _on_signal(number: int, frame: FrameType | None) -> None:
    _Watch.heard = True
    if _Watch.tidying:
        _Watch.tidying = False  # a second Ctrl-C does not wait
        raise KeyboardInterrupt
    _end()


def _wait(heard: int) -> None:
    """End the process when the main thread does not, a while after a signal was heard."""
    import time

    os.read(heard, 1)
    time.sleep(PATIENCE_S)
    _end()


def _end() -> None:
    for action in _Watch.last:
        action()
    if not _Watch.said:
        _Watch.said = True
        try:  # noqa: SIM105 (contextlib may be half imported)
            os.write(2, f"{MESSAGE}\n".encode())  # sys.stderr may be in the middle of a write
        except OSError:
            pass
    os._exit(EXIT)
