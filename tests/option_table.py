"""The table of options in README, made from the commands themselves.

Run from the repository root to write it into README: python tests/option_table.py
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import click

from gcodesim.checking.options import Scope
from gcodesim.cli import main
from gcodesim.cli.run_options import MODEL

README = Path(__file__).parents[1] / "README.md"
HEAD = "| option | what it does | in a settings file |\n|---|---|---|\n"
PLACES = {
    Scope.JOB: "top, jobs",
    Scope.RUN: "top",
    Scope.COMMAND_LINE: "",
}


def commands(
    command: click.Command = main, path: tuple[str, ...] = ()
) -> Iterator[tuple[tuple[str, ...], click.Command]]:
    """Yield every command with its path; groups only when they have options of their own."""
    if options(command) or not isinstance(command, click.Group):
        yield path, command
    if isinstance(command, click.Group):
        for name, below in command.commands.items():
            yield from commands(below, (*path, name))


def options(command: click.Command) -> dict[str, click.Option]:
    """Options of a command by their long names."""
    given = [(name, p) for p in command.params if isinstance(p, click.Option) for name in p.opts]
    return {name: option for name, option in given if name.startswith("--")}


def option_table() -> str:
    """One row for every option: of commands that mean the same by it, the text stands once."""
    texts: dict[str, dict[str, list[str]]] = {}
    usages: dict[str, str] = {}
    for path, command in commands():
        for name, option in options(command).items():
            usages.setdefault(name, _usage(name, option))
            texts.setdefault(name, {}).setdefault(_text(option), []).append(" ".join(path))
    places = {f"--{each.option.name}": PLACES[each.option.scope] for each in MODEL}
    rows = (
        f"| `{usage}` | {_joined(texts[name])} | {places.get(name, '')} |\n"
        for name, usage in usages.items()
    )
    return (HEAD + "".join(rows)).replace("|  |\n", "| |\n")


def _usage(name: str, option: click.Option) -> str:
    usage = "/".join([name, *option.secondary_opts])
    if option.is_flag:
        return usage
    return f"{usage} {option.metavar or 'NAME'}"


def _text(option: click.Option) -> str:
    """What an option does, its values and its default."""
    text = (option.help or "").strip()
    default = option.default if option.show_default else None
    if isinstance(option.type, click.Choice):
        values = (f"`{v}`{' (default)' * (v == default)}" for v in option.type.choices)
        return f"{text} Values: {', '.join(values)}."
    if default is None or option.is_flag:
        return text
    return f"{text} Default: `{default}`."


def _joined(texts: dict[str, list[str]]) -> str:
    """The texts with the commands they are of; one text that is that of `check` needs none."""
    if len(texts) == 1 and {"", "check"} & set(*texts.values()):
        return next(iter(texts))
    named = (f"{', '.join(f'`{c}`' for c in names)}: {text}" for text, names in texts.items())
    return " ".join(named)


def with_table(readme: str) -> str:
    """A README with the table in the place of the one it has."""
    begin = readme.index(HEAD[:30])
    return readme[:begin] + option_table() + readme[readme.index("\n\n", begin) + 1 :]


if __name__ == "__main__":
    README.write_text(with_table(README.read_text(encoding="utf-8")), encoding="utf-8")
