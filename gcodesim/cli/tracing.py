"""The command `trace`: axis positions over time."""

from __future__ import annotations

import sys
from typing import Any

import click

from gcodesim.cli.arguments import (
    exit_with,
    language_of,
    language_options,
    machine_option,
    machine_path_of,
    options_named,
    period,
    read_text,
)
from gcodesim.cli.outputs import claim, model_files, writing
from gcodesim.errors import UsageError


@click.command()
@click.argument("program")
@machine_option(left_out="the one that the setup names.")
@options_named("setup", "tools")
@language_options
@click.option(
    "--every",
    type=period,
    default="1ms",
    show_default=True,
    metavar="TIME",
    help="Time between rows, with its unit.",
)
@click.option(
    "--real",
    is_flag=True,
    help="Where the lagging drives are (`servo` of the machine file), not what is commanded.",
)
@click.option("--npz", metavar="FILE", help="Write NumPy columns instead of CSV on stdout.")
def trace(program: str, machine_path: str | None, **given: Any) -> None:
    """Print the axis positions of PROGRAM over time, as CSV: time_s, line, every axis."""
    from gcodesim.checking.trace import Trace, write_csv, write_npz
    from gcodesim.machine.control_data import control_for
    from gcodesim.machine.loading import load_machine
    from gcodesim.motion.planner import plan
    from gcodesim.nc.interpret import interpret

    npz = given["npz"] and given["npz"].removesuffix(".npz") + ".npz"  # as NumPy will call it
    model = machine_path_of(machine_path, given["setup"]), given["setup"], given["tools"]
    claim([(f"--npz {npz}", npz)] if npz else [], [(program, "the program"), *model_files(*model)])
    machine = load_machine(model[0], setup=model[1], tools=model[2])
    if given["real"] and not any(joint.servo for joint in machine.joints):
        raise UsageError(f"--real: no joint of {machine.name} has a `servo`")
    name, text = read_text(program)
    meaning = interpret(text, control_for(machine, *language_of(given)), name)
    path, planned = plan(meaning.program, machine)
    made = Trace(path, machine, given["every"], given["real"])
    if npz:
        with writing(f"--npz {npz}"):
            write_npz(made, npz)
    else:
        write_csv(made, sys.stdout)
    # What follows a block that could not be followed, or the end of the clock, is not in the trace.
    exit_with(name, (*meaning.findings, *planned))
