"""The commands `machine`: show, lint, schema, new and import."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import click

from gcodesim.cli.arguments import options_named
from gcodesim.cli.completion import machines
from gcodesim.cli.outputs import write_new
from gcodesim.errors import UsageError

KINDS = ("table-table", "head-table", "head-head", "three-axis")
"""Keys of machine.generic.MACHINES: that module is imported only where it is needed."""


with_files = options_named("setup", "tools", "allow_outside")
"""The options that name the files beside a machine file."""


@click.group()
def machine() -> None:
    """Look at machine files, find what is wrong with them, and begin new ones."""


@machine.command()
@click.argument("path", metavar="M.yaml", shell_complete=machines)
@with_files
def show(path: str, **files: Any) -> None:
    """Print the kinematic tree, bodies, pairs and tools of a machine."""
    from gcodesim.machine.describe import describe
    from gcodesim.machine.loading import load_machine

    click.echo(describe(load_machine(path, **files)))


@machine.command()
@click.argument("path", metavar="M.yaml", shell_complete=machines)
@with_files
@click.option(
    "--format",
    "report_format",
    type=click.Choice(["text", "json"]),
    default="text",
    show_default=True,
    help="Format of the findings.",
)
def lint(path: str, report_format: str, **files: Any) -> None:
    """Find what is wrong with a machine before a program runs on it.

    Exit codes: 0 nothing worse than notes, 3 warnings (a question may stay undecided), 1 errors
    (programs fail on this model), 2 the file cannot be loaded at all.
    """
    from gcodesim.checking.lint import lint as find
    from gcodesim.machine.loading import load_machine
    from gcodesim.report.lint_report import lint_dict, lint_lines

    findings = find(load_machine(path, **files))
    if report_format == "json":
        click.echo(json.dumps(lint_dict(path, findings), indent=2))
    else:
        click.echo("\n".join(lint_lines(path, findings)))
    severities = {finding.severity for finding in findings}
    sys.exit(1 if "error" in severities else 3 if "warning" in severities else 0)


@machine.command()
@click.argument("kind", type=click.Choice(["machine", "tools", "setup"]), default="machine")
def schema(kind: str) -> None:
    """Print the JSON Schema of machine, tools or setup files."""
    from gcodesim.machine.describe import schema_json

    click.echo(json.dumps(schema_json(kind), indent=2))


@machine.command()
@click.argument(
    "names",
    metavar="[KIND] FILE.yaml",
    nargs=-1,
    required=True,
    shell_complete=lambda context, parameter, begun: [k for k in KINDS if k.startswith(begun)],
)
@click.option("--table", metavar="YX", help="Slides that carry the work, the lowest first.")
@click.option("--rotary", metavar="AC", help="Rotary axes of the table, the one that tilts first.")
@click.option("--head", metavar="CB", help="Rotary axes of the head, the one that tilts last.")
@click.option("--travel", metavar="X Y Z", nargs=3, type=float, help="Travel of the slides [mm].")
@click.option("--tilt", metavar="LOW HIGH", nargs=2, type=float, help="Limits of the tilt [deg].")
def new(names: tuple[str, ...], **layout: Any) -> None:
    """Write a machine of boxes and cylinders to begin with.

    KIND is table-table, head-table, head-head or three-axis: what carries the rotary axes. Left
    out, the options say it: --table YX --rotary BC --travel 500 450 400 --tilt -110 110 is a
    machine whose table moves along X, on Y, with a cradle B and a rotary table C.

    The comments in the file say what to change. Nothing is overwritten.
    """
    from gcodesim.machine.generic import machine_text
    from gcodesim.machine.generic_layout import Layout, layout_text

    kind, path = names if len(names) == 2 else ("", names[0])
    given = {key: value for key, value in layout.items() if value is not None}
    if len(names) > 2 or (kind and kind not in KINDS):
        raise UsageError(f"expected [KIND] FILE.yaml, KIND one of {', '.join(KINDS)}")
    if kind and given:
        raise UsageError(f"--{min(given)} describes a machine of your own: leave out {kind}")
    if kind:
        write_new(path, machine_text(kind, Path(path).stem), "machine")
        return
    letters: dict[str, Any] = {k: v.upper() if isinstance(v, str) else v for k, v in given.items()}
    write_new(path, layout_text(Layout(**letters), Path(path).stem), "machine")


@machine.command("import")
@click.argument("path", metavar="FILE")
@click.option("--out", metavar="M.yaml", help="Write this file instead of standard output.")
def import_(path: str, out: str | None) -> None:
    """Turn a LinuxCNC INI file, a URDF robot or a VERICUT machine (.mch) into a machine file.

    What could not be carried over is listed at the head of the file, and on stderr.
    """
    from gcodesim.machine.formats.linuxcnc_ini import import_ini
    from gcodesim.machine.formats.urdf import import_urdf
    from gcodesim.machine.formats.vericut_mch import import_mch

    suffix, folder = Path(path).suffix.lower(), str(Path(out or path).parent)
    if suffix == ".ini":
        found = import_ini(path)
    elif suffix == ".mch":
        found = import_mch(path, folder)
    elif suffix in (".urdf", ".xml"):
        found = import_urdf(path, folder)
    else:
        text = "expected a LinuxCNC .ini file, a .urdf file (or .xml), or a VERICUT .mch file"
        raise UsageError(f"{path}: {text}")
    if out:
        write_new(out, found.text, "machine")
    else:
        click.echo(found.text, nl=False)
    for line in found.remarks:
        click.echo(f"gcodesim: {path}: {line}", err=True)
