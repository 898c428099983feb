"""The commands `machine show` and `machine schema`."""

from __future__ import annotations

import json

import click


@click.group()
def machine() -> None:
    """Look at machine files."""


@machine.command()
@click.argument("path", metavar="M.yaml")
@click.option("--setup", metavar="FILE", help="Setup file.")
@click.option("--tools", metavar="FILE", help="Tools file or LinuxCNC tool table.")
@click.option("--allow-outside", is_flag=True, help="Mesh files may lie outside the folder.")
def show(path: str, setup: str | None, tools: str | None, allow_outside: bool) -> None:
    """Print the kinematic tree, bodies, pairs and tools of a machine."""
    from gcodesim.machine.describe import describe
    from gcodesim.machine.loading import load_machine

    click.echo(describe(load_machine(path, setup=setup, tools=tools, allow_outside=allow_outside)))


@machine.command()
@click.argument("kind", type=click.Choice(["machine", "tools", "setup"]), default="machine")
def schema(kind: str) -> None:
    """Print the JSON Schema of machine, tools or setup files."""
    from gcodesim.machine.describe import schema_json

    click.echo(json.dumps(schema_json(kind), indent=2))
