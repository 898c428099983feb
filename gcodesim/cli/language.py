"""The commands `canon` and `explain`: what a program and a finding mean."""

from __future__ import annotations

import sys
from typing import Any

import click

from gcodesim.cli.arguments import (
    exit_with,
    language_of,
    language_options,
    machine_option,
    options_named,
    progress_bar,
    read_text,
)
from gcodesim.cli.completion import codes_and_meanings


@click.command()
@click.argument("program")
@machine_option(left_out="a control with everything at zero.")
@options_named("tools")
@language_options
def canon(program: str, machine_path: str | None, tools: str | None, **given: Any) -> None:
    """Print PROGRAM as canonical commands, JSON Lines in machine millimetres and degrees."""
    from gcodesim.machine.control_data import bare_control, control_for
    from gcodesim.machine.loading import load_machine
    from gcodesim.nc.canon import write_canon
    from gcodesim.nc.interpret import interpret

    choices = language_of(given)
    if machine_path:
        control = control_for(load_machine(machine_path, tools=tools), *choices)
    else:
        control = bare_control(tools, *choices)
    name, text = read_text(program)
    with progress_bar(name, False) as progress:
        meaning = interpret(text, control, name, progress)
    write_canon(meaning, sys.stdout)
    exit_with(name, meaning.findings)


@click.command()
@click.argument("code", default="", shell_complete=codes_and_meanings)
def explain(code: str) -> None:
    """Say what CODE means and what to do: a code (GC405) or a meaning (feed_missing).

    Without CODE all codes are listed, and of GC2 those of GC2xx.
    """
    from gcodesim.findings.explain import explain as explained

    click.echo(explained(code))
