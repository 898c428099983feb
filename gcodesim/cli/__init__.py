"""The command line: what every command shares here, one file per family of commands beside it."""

from __future__ import annotations

import functools
import io
import sys
import traceback
from collections.abc import Callable
from typing import Any

import click

from gcodesim import __version__, interrupt
from gcodesim.checking.verdict import CONTRACT, INTERRUPT_EXIT, USAGE_EXIT
from gcodesim.cli.batch import batch, merge
from gcodesim.cli.check import check
from gcodesim.cli.completion import completion
from gcodesim.cli.init import init, setup
from gcodesim.cli.language import canon, explain
from gcodesim.cli.machine import machine
from gcodesim.cli.measure import bench, study
from gcodesim.cli.pictures import view
from gcodesim.cli.tool import tool
from gcodesim.cli.tracing import trace
from gcodesim.errors import UsageError

NO_MEMORY = "there is not enough memory for this: check shorter programs, or fewer at a time"
NO_LETTERS = "this locale knows no such characters: set PYTHONUTF8=1"

SHORT_OF_MEMORY = ("failed to map segment", "can't start new thread")
"""What libraries and threads for which there is no memory end with."""


def exits_cleanly(command: Callable[..., Any]) -> Callable[..., Any]:
    """Turn errors and Ctrl-C into their exit codes: a crash must not look like FAIL, which is 1."""

    @functools.wraps(command)
    def run(*args: Any, **kwargs: Any) -> Any:
        try:
            with interrupt.Caught():
                return command(*args, **kwargs)
        except (click.ClickException, click.exceptions.Exit, click.Abort):
            raise
        except KeyboardInterrupt:
            interrupt.say()
            sys.exit(INTERRUPT_EXIT)
        except Exception as error:
            if interrupt.was_heard():  # libraries turn it into errors of their own
                interrupt.say()
                sys.exit(INTERRUPT_EXIT)
            why = _explained(error)
            if not why:
                traceback.print_exc()
            click.echo(f"gcodesim: {why or 'a defect of gcodesim, please report it'}", err=True)
            sys.exit(USAGE_EXIT)

    return run


def _explained(error: Exception) -> str:
    """Return what to tell of an error; nothing where it is a defect."""
    if isinstance(error, UsageError | OSError):
        return str(error)
    if isinstance(error, UnicodeEncodeError) and sys.getfilesystemencoding() != "utf-8":
        return f"{error.object!a}: {NO_LETTERS}"
    short = any(words in str(error) for words in SHORT_OF_MEMORY)
    return NO_MEMORY if short or isinstance(error, MemoryError) else ""


class CommandGroup(click.Group):
    """A group whose commands end with the exit codes of the contract."""

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command."""
        # A terminal of few characters gets the rest as question marks, never a traceback.
        refusing = ("strict", "surrogateescape")
        if isinstance(sys.stdout, io.TextIOWrapper) and sys.stdout.errors in refusing:
            sys.stdout.reconfigure(errors="replace")
        return exits_cleanly(super().invoke)(ctx)


CONTEXT = {"help_option_names": ["-h", "--help"]}


@click.group(cls=CommandGroup, epilog=CONTRACT, context_settings=CONTEXT)
@click.version_option(__version__, prog_name="gcodesim")
def main() -> None:
    """Find the first collision of a five-axis machine tool running an NC program.

    Exit codes: 0 PASS, 1 FAIL, 3 INCONCLUSIVE, 2 the command could not be carried out,
    130 interrupted.
    """


for command in (
    check,
    batch,
    merge,
    init,
    trace,
    canon,
    explain,
    machine,
    setup,
    tool,
    bench,
    study,
    view,
    completion,
):
    main.add_command(command)
