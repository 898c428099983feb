"""The commands `init` and `setup new`: a project and a setup to begin with."""

from __future__ import annotations

import os
import shlex
from pathlib import Path

import click

from gcodesim.cli.completion import machines
from gcodesim.cli.outputs import write_new
from gcodesim.errors import UsageError


@click.command()
@click.argument("folder", metavar="DIR")
@click.option(
    "--machine",
    metavar="M.yaml",
    help="Begin with this machine file and its meshes.",
    shell_complete=machines,
)
@click.option("--tools", metavar="LIB", help="Begin with the tools of this file or library.")
def init(folder: str, machine: str | None, tools: str | None) -> None:
    """Write a project into DIR: machine, setup, program, settings and CI files.

    With a machine or tools of your own the setup is one to begin with, a vise and a part on the
    table, and the programs are yours to copy.
    """
    from gcodesim.starter import write_project

    try:
        names = write_project(folder, machine, tools)
    except OSError as error:
        raise UsageError(f"{folder}: cannot be written as a folder: {error.strerror}") from error
    for name in names:
        click.echo(name)
    place = shlex.quote(folder)
    if machine is None and tools is None:
        click.echo(f"next: cd {place} && gcodesim batch", err=True)
    else:
        click.echo(f"next: copy programs into {place}/programs; change setup.yaml;", err=True)
        click.echo(f"then: cd {place} && gcodesim batch", err=True)
    click.echo("in CI: say where pip gets gcodesim, in the line GCODESIM of the CI files", err=True)


@click.group()
def setup() -> None:
    """Begin the file that says what is clamped on a machine."""


@setup.command()
@click.argument("path", metavar="FILE.yaml")
@click.option(
    "--machine",
    default="table_tilt",
    show_default=True,
    metavar="M.yaml",
    help="Machine file, or the name of a shipped machine, that the setup is for.",
    shell_complete=machines,
)
@click.option("--tools", metavar="FILE", help="Tools file or library that it names.")
def new(path: str, machine: str, tools: str | None) -> None:
    """Write a setup for a machine: a vise on its table, a part in it, a zero point on top.

    Its comments say what to change. Nothing is overwritten.
    """
    from gcodesim.machine.generic_setup import setup_text
    from gcodesim.machine.loading import load_machine

    folder = Path(path).parent
    loaded = load_machine(machine, tools=tools)
    name = _from(folder, machine) if Path(machine).is_file() else machine
    write_new(path, setup_text(loaded, name, _from(folder, tools) if tools else None), "setup")


def _from(folder: Path, file: str) -> str:
    """A file as the setup in a folder names it."""
    return Path(os.path.relpath(file, folder)).as_posix()
