"""Completion in shells: the command that prints its script, and the words that it knows."""

from __future__ import annotations

import click
from click.shell_completion import CompletionItem, get_completion_class

SHELLS = ("bash", "zsh", "fish")
VARIABLE = "_GCODESIM_COMPLETE"


@click.command()
@click.argument("shell", type=click.Choice(SHELLS))
def completion(shell: str) -> None:
    """Print the script that completes commands, options, machines and codes in SHELL.

    bash: `eval "$(gcodesim completion bash)"` in ~/.bashrc; zsh: the same with zsh in ~/.zshrc;
    fish: `gcodesim completion fish > ~/.config/fish/completions/gcodesim.fish`.
    """
    found = get_completion_class(shell)
    assert found is not None
    root = click.get_current_context().find_root()
    click.echo(found(root.command, {}, "gcodesim", VARIABLE).source())


def machines(
    context: click.Context, parameter: click.Parameter, begun: str
) -> list[CompletionItem]:
    """The shipped machines, and files."""
    from gcodesim.machine.files import shipped_machines

    names = [CompletionItem(name) for name in shipped_machines() if name.startswith(begun)]
    return [*names, CompletionItem(begun, type="file")]


def codes(context: click.Context, parameter: click.Parameter, begun: str) -> list[CompletionItem]:
    """The codes of findings."""
    from gcodesim.findings.codes import CODES

    rows = CODES.items()
    return [CompletionItem(c, help=row.title) for c, row in rows if c.startswith(begun.upper())]


def codes_and_meanings(
    context: click.Context, parameter: click.Parameter, begun: str
) -> list[CompletionItem]:
    """The codes of findings, and their meanings."""
    from gcodesim.findings.meanings import MEANINGS

    meanings = [CompletionItem(name) for name in MEANINGS if begun and name.startswith(begun)]
    return [*codes(context, parameter, begun), *meanings]
