"""The command `init`: a project to begin with."""

from __future__ import annotations

import shlex

import click

from gcodesim.errors import UsageError


@click.command()
@click.argument("folder", metavar="DIR")
def init(folder: str) -> None:
    """Write a project into DIR: machine, setup, program, settings and CI files."""
    from gcodesim.starter import write_project

    try:
        names = write_project(folder)
    except OSError as error:
        raise UsageError(f"{folder}: cannot be written as a folder: {error.strerror}") from error
    for name in names:
        click.echo(name)
    click.echo(f"next: cd {shlex.quote(folder)} && gcodesim batch", err=True)
    click.echo("in CI: say where pip gets gcodesim, in the line GCODESIM of the CI files", err=True)
