"""A project to begin with: machine, setup, program, settings and CI files, ready to pass."""

from __future__ import annotations

from pathlib import Path

from gcodesim import __version__
from gcodesim.errors import UsageError
from gcodesim.machine.files import files_of, find_machine
from gcodesim.machine.schema_files import schema_name, schema_text, with_schema
from gcodesim.output_file import write_bytes

MACHINE = "table_tilt"

TEMPLATES = {
    "gcodesim.toml": "gcodesim.toml",
    "setup.yaml": "setup.yaml",
    ".gitignore": "gitignore",
    ".github/workflows/gcodesim.yml": "github.yml",
    ".gitlab-ci.yml": "gitlab.yml",
}
"""File of the project -> file beside this one; @VERSION@ in it stands for that of gcodesim."""


def write_project(folder: str, machine: str | None = None, tools: str | None = None) -> list[str]:
    """Write a project; the files written, counted from the folder.

    Args:
        folder: where it begins.
        machine: machine file, or name of a shipped machine, with which the project begins; left
            out: a project with a program whose first check passes.
        tools: tools file or library of it.

    Raises:
        UsageError: one of the files is there already; then nothing is written. Or machine or tools
            cannot be used.
        OSError: the folder cannot be written.
    """
    contents = _contents() if machine is None and tools is None else _own(machine, tools)
    contents = _with_schemas(contents)
    there = [name for name in contents if (Path(folder) / name).exists()]
    if there:
        raise UsageError(f"{folder}: {', '.join(there)} there already: choose an empty folder")
    for name, content in contents.items():
        path = Path(folder) / name
        path.parent.mkdir(parents=True, exist_ok=True)
        write_bytes(path, content)
    return list(contents)


def _with_schemas(contents: dict[str, bytes]) -> dict[str, bytes]:
    """The same, with the schemas of setup and tools for editors."""
    made = {}
    for kind in ("setup", "tools"):
        if (name := f"{kind}.yaml") in contents:
            made[name] = with_schema(kind, contents[name].decode()).encode()
            made[schema_name(kind)] = schema_text(kind).encode()
    return contents | made


def _contents() -> dict[str, bytes]:
    """What every file of the project holds."""
    here = Path(__file__).parent
    # in a wheel the program lies beside this file, in a source checkout among the samples
    places = [here / "part.nc", here.parents[1] / "samples" / "part.nc"]
    program = next(place for place in places if place.is_file())
    copied = _copied("machines", find_machine(MACHINE), files_of(MACHINE, None, None))
    return _templates() | copied | {"programs/part.nc": program.read_bytes()}


def _own(machine: str | None, tools: str | None) -> dict[str, bytes]:
    """The same with a machine and tools of one's own, and a setup made for them."""
    from gcodesim.machine.generic_setup import setup_text
    from gcodesim.machine.loading import load_machine
    from gcodesim.machine.tool_files import OWN, read_library

    path = find_machine(machine or MACHINE)
    contents = _templates() | _copied("machines", path, files_of(str(path), None, None))
    place = None
    if tools and Path(tools).suffix.lower() in OWN:
        place = f"tools/{Path(tools).name}"
        contents |= _copied("tools", Path(tools), files_of(str(path), None, tools)[1:])
    elif tools:
        place = "tools.yaml"
        contents[place] = read_library(Path(tools)).text.encode()
    loaded = load_machine(str(path), tools=tools)
    contents["setup.yaml"] = setup_text(loaded, f"machines/{path.name}", place).encode()
    return contents


def _templates() -> dict[str, bytes]:
    here = Path(__file__).parent
    return {
        name: (here / template).read_text("utf-8").replace("@VERSION@", __version__).encode()
        for name, template in TEMPLATES.items()
    }


def _copied(folder: str, file: Path, files: list[Path]) -> dict[str, bytes]:
    """A file with the meshes that it names, from its own folder into one of the project."""
    contents = {}
    for each in files:
        if not each.is_relative_to(file.parent):
            continue  # of another file
        name = each.relative_to(file.parent)
        if ".." in name.parts:
            raise UsageError(f"{file}: {name} lies outside its folder: copy it there first")
        contents[f"{folder}/{name.as_posix()}"] = each.read_bytes()
    return contents
