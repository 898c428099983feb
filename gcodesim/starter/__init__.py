"""A project to begin with: machine, setup, program, settings and CI files, ready to pass."""

from __future__ import annotations

from pathlib import Path

from gcodesim import __version__
from gcodesim.errors import UsageError
from gcodesim.machine.files import files_of, find_machine
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


def write_project(folder: str) -> list[str]:
    """Write a project whose first check passes; the files written, counted from the folder.

    Raises:
        UsageError: one of the files is there already; then nothing is written.
        OSError: the folder cannot be written.
    """
    contents = _contents()
    there = [name for name in contents if (Path(folder) / name).exists()]
    if there:
        raise UsageError(f"{folder}: {', '.join(there)} there already: choose an empty folder")
    for name, content in contents.items():
        path = Path(folder) / name
        path.parent.mkdir(parents=True, exist_ok=True)
        write_bytes(path, content)
    return list(contents)


def _contents() -> dict[str, bytes]:
    """What every file of the project holds."""
    here = Path(__file__).parent
    contents = {
        name: (here / template).read_text("utf-8").replace("@VERSION@", __version__).encode()
        for name, template in TEMPLATES.items()
    }
    machine = find_machine(MACHINE)
    for file in files_of(MACHINE, None, None):
        name = Path("machines") / file.relative_to(machine.parent)
        contents[name.as_posix()] = file.read_bytes()
    # in a wheel the program lies beside this file, in a source checkout among the samples
    places = [here / "part.nc", here.parents[1] / "samples" / "part.nc"]
    program = next(place for place in places if place.is_file())
    return contents | {"programs/part.nc": program.read_bytes()}
