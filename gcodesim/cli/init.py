"""The command `init`: a project to begin with."""

from __future__ import annotations

import click


@click.command()
@click.argument("folder", metavar="DIR")
def init(folder: str) -> None:
    """Write a project into DIR: machine, setup, program, settings and CI files."""
    from gcodesim.starter import write_project

    for name in write_project(folder):
        click.echo(name)
    click.echo(f"next: cd {folder} && gcodesim check programs/part.nc --setup setup.yaml", err=True)
