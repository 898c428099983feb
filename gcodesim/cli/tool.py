"""The commands `tool`: import, new and show."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from gcodesim.cli.outputs import claim, write_new, writing
from gcodesim.errors import UsageError
from gcodesim.output_file import write_bytes


@click.group()
def tool() -> None:
    """Take over tool libraries, begin a tools file, and look at tools."""


@tool.command("import")
@click.argument("path", metavar="LIB")
@click.option("--out", metavar="TOOLS.yaml", help="Write this file instead of standard output.")
@click.option(
    "--number-from",
    type=click.IntRange(min=1),
    metavar="N",
    help="Number the tools anew from N on: those of a catalogue often have one number.",
)
@click.option(
    "--units",
    type=click.Choice(["mm", "inch"]),
    help="Unit of a LinuxCNC tool table, which does not tell it. Default: mm.",
)
def import_(path: str, out: str | None, number_from: int | None, units: str | None) -> None:
    """Turn a library of tools into a tools file.

    LIB: a Fusion library (.json, .tools), FreeCAD bits (.fctl, .fctb), a LinuxCNC tool table
    (.tbl), a Heidenhain TOOL.T, or G10 blocks or $TC_ data that a control has written.

    What could not be carried over is listed at the head of the file, and on stderr. A check reads
    LIB itself, too: --tools LIB.
    """
    from gcodesim.machine.tool_files import OWN, read_library

    if Path(path).suffix.lower() in OWN:
        raise UsageError(f"{path}: a tools file already; `gcodesim tool show` prints what it holds")
    library = read_library(Path(path), units)
    if number_from is not None:
        library.renumber(number_from)
    if out:
        write_new(out, library.text, "tools")
    else:
        click.echo(library.text, nl=False)
    for line in library.all_remarks:
        click.echo(f"gcodesim: {path}: {line}", err=True)


@tool.command()
@click.argument("path", metavar="FILE.yaml")
def new(path: str) -> None:
    """Write a tools file with a tool of every type; its comments say what to change.

    Nothing is overwritten.
    """
    from gcodesim.machine.generic_tools import TOOLS_TEXT

    write_new(path, TOOLS_TEXT, "tools")


@tool.command()
@click.argument("path", metavar="TOOLS")
@click.option("--out", metavar="PICTURE.png", help="Draw the tools from the side into this PNG.")
@click.option(
    "--tool",
    "numbers",
    type=int,
    multiple=True,
    metavar="N",
    help="Only this one; again for more.",
)
@click.option(
    "--allow-outside",
    is_flag=True,
    help="Mesh files may lie outside the folder of the file that names them.",
)
def show(path: str, out: str | None, numbers: Sequence[int], allow_outside: bool) -> None:
    """Print the tools of a tools file or library, and draw them: flute, shank, holder, lengths."""
    from gcodesim.machine.describe import tool_line
    from gcodesim.machine.tools import read_tools

    tools = read_tools(path, allow_outside=allow_outside)
    for number in numbers:
        if number not in tools:
            known = ", ".join(str(n) for n in sorted(tools)) or "none"
            raise UsageError(f"{path}: no tool {number}; it has {known}")
    chosen = [tools[number] for number in sorted(numbers or tools)]
    for each in chosen:
        click.echo(tool_line(each))
    if out and not chosen:
        raise UsageError(f"{path}: no tools to draw")
    if out:
        from gcodesim.report.tool_sheet import tool_sheet

        claim([("--out", out)], [(path, "the file of the tools")])
        with writing(f"--out {out}"):
            write_bytes(out, tool_sheet(chosen))
