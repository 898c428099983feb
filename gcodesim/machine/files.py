"""Names and finds the files that a machine, its setup and its tools are read from."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import suppress
from importlib.resources import files
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from gcodesim.errors import UsageError
from gcodesim.machine.yaml_lines import YamlFile, read_yaml, suggest


def find_machine(path: str) -> Path:
    """The machine file of that path, or else the shipped machine of that name; UsageError."""
    if Path(path).is_file():
        return Path(path)
    shipped = shipped_machines()
    name = path.removesuffix(".yaml")
    if name not in shipped:
        raise UsageError(
            f"no machine file {path!r}, and no machine of that name is shipped; "
            f"{suggest(name, shipped)}"
        )
    return shipped[name]


def shipped_machines() -> dict[str, Path]:
    """The machines that come with gcodesim, by name."""
    package = Path(str(files("gcodesim")))
    # in a wheel machines/ lies in the package, in a source checkout beside it
    folders = [package / "machines", package.parent / "machines"]
    return {file.stem: file for folder in folders for file in sorted(folder.glob("*.yaml"))}


def beside(file: Path, name: str) -> str:
    """A file named in another, relative to it; as it stands when there is no such file."""
    near = file.parent / name
    return str(near) if near.is_file() else name


def inside(source: YamlFile, name: str, allow_outside: bool, *key: str | int) -> Path:
    """A path that a file names at a key, relative to it.

    Raises:
        ModelError: it leaves the folder of the file.
    """
    folder = source.path.parent
    path = folder / name
    within = not Path(name).is_absolute() and path.resolve().is_relative_to(folder.resolve())
    if not within and not allow_outside:
        text = f"{name} lies outside the folder of this file: copy it there, or --allow-outside"
        raise source.error(text, *key)
    return path


def files_of(machine: str, setup: str | None, tools: str | None) -> list[Path]:
    """The files that `load_machine` reads for these three, meshes and programs too.

    Raises:
        UsageError: a file is missing or is no text.
        ModelError: a file is no YAML.
    """
    tools = tools or (_tools_of(Path(setup)) if setup else None)
    given = [find_machine(machine), *(Path(name) for name in (setup, tools) if name)]
    foreign = Path(tools) if tools and Path(tools).suffix.lower() not in (".yaml", ".yml") else None
    named = [mesh for file in given if file != foreign for mesh in _meshes(file)]
    if foreign and foreign.suffix.lower() == ".fctl":
        named += _bits(foreign)
    return [*given, *dict.fromkeys(named), *_programs(given[0])]


def _programs(machine: Path) -> Iterator[Path]:
    """Yield the program files of the control that a machine file names."""
    control = read_yaml(machine).data.get("control")
    control = control if isinstance(control, dict) else {}
    listed = control.get("programs")
    for name in listed.values() if isinstance(listed, dict) else ():
        if isinstance(name, str) and (machine.parent / name).is_file():
            yield machine.parent / name
    library = control.get("library")
    if isinstance(library, str) and library:
        yield from sorted(path for path in (machine.parent / library).glob("*") if path.is_file())


def _tools_of(setup: Path) -> str | None:
    """The tools file that a setup names. Its schema would take longer to import than all else."""
    name = read_yaml(setup).data.get("tools")
    return beside(setup, name) if isinstance(name, str) else None


def _bits(library: Path) -> list[Path]:
    """The files of the tool bits of a FreeCAD library, whose reader is slow to import."""
    from gcodesim.machine.tool_files import bit_files

    return list(bit_files(library))


def _meshes(file: Path) -> Iterator[Path]:
    """Yield the mesh files that a YAML file names."""
    pending: list[Any] = [read_yaml(file).data]
    while pending:
        value = pending.pop()
        if isinstance(value, dict):
            if isinstance(value.get("mesh"), str):
                mesh = file.parent / value["mesh"]
                yield from (mesh, *_buffers(mesh))
            pending += value.values()
        elif isinstance(value, list):
            pending += value


def _buffers(mesh: Path) -> Iterator[Path]:
    """Yield the files beside a glTF mesh that hold its points."""
    if mesh.suffix.lower() != ".gltf":
        return
    with suppress(OSError, ValueError, AttributeError):  # what is wrong is told by its reader
        buffers = json.loads(mesh.read_bytes()).get("buffers", [])
        names = [buffer.get("uri") for buffer in buffers]
        texts = [name for name in names if isinstance(name, str) and not name.startswith("data:")]
        for name in dict.fromkeys([*texts, *map(unquote, texts)]):
            if (mesh.parent / name).is_file():
                yield mesh.parent / name
