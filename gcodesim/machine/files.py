"""Names every file that a machine, its setup and its tools are read from."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from gcodesim.machine.loading import find_machine
from gcodesim.machine.setup import read_setup
from gcodesim.machine.yaml_lines import read_yaml


def files_of(machine: str, setup: str | None, tools: str | None) -> list[Path]:
    """The files that `load_machine` reads for these three, meshes too.

    Raises:
        UsageError: a file is missing or is no text.
        ModelError: a file is no YAML.
    """
    tools = tools or read_setup(setup).tools
    given = [find_machine(machine), *(Path(name) for name in (setup, tools) if name)]
    meshes = [mesh for file in given if file.suffix.lower() != ".tbl" for mesh in _meshes(file)]
    return [*given, *dict.fromkeys(meshes)]


def _meshes(file: Path) -> Iterator[Path]:
    """Yield the mesh files that a YAML file names."""
    pending: list[Any] = [read_yaml(file).data]
    while pending:
        value = pending.pop()
        if isinstance(value, dict):
            if isinstance(value.get("mesh"), str):
                yield file.parent / value["mesh"]
            pending += value.values()
        elif isinstance(value, list):
            pending += value
