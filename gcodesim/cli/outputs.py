"""Files that a run writes: none of them is one that it reads, and no two of them are one."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from gcodesim.batch.programs import is_program
from gcodesim.errors import UsageError
from gcodesim.output_file import write_text

Output = tuple[str, str]
"""What asks for a file, as it was given, `--report junit=a.xml`, and the file."""

Input = tuple[str, str]
"""A file that is read, and what it is."""


def claim(outputs: Iterable[Output], inputs: Iterable[Input]) -> None:
    """Refuse outputs that would destroy something; then make the folders that are missing.

    Raises:
        UsageError: an output is an input, or another output, by whatever name or link; it is
            called like a program, for programs call others; or its folder cannot be made.
    """
    outputs = list(outputs)
    # What is read has to be looked up in machine files: only where something is written.
    taken = {_identity(file): what for file, what in inputs} if outputs else {}
    for asked, path in outputs:
        # A link, or a way through a folder that is about to be made, leads to the same file.
        real = Path(os.path.realpath(path))
        destroys = real.is_file() and is_program(real)
        if what := taken.get(_identity(path)) or ("an NC program" if destroys else ""):
            raise UsageError(f"{asked}: {path} is {what}: choose another file")
        if not _is_device(path):
            taken[_identity(path)] = f"what {asked} writes"
    for asked, path in outputs:
        folder = Path(path).parent
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            why = f"folder {str(folder)!r} cannot be made: {error.strerror}"
            raise UsageError(f"{asked}: {why}") from error


@contextmanager
def writing(asked: str) -> Iterator[None]:
    """Errors of the system while a file is written say what asked for it."""
    try:
        yield
    except OSError as error:
        raise UsageError(f"{asked}: cannot be written: {error.strerror or error}") from error


def model_files(machine: str, setup: str | None, tools: str | None = None) -> Iterator[Input]:
    """Yield what a machine, its setup and its tools are read from, as far as that can be told."""
    from gcodesim.machine.files import files_of

    what = "a file of machine, setup or tools"
    yield from ((file, what) for file in (machine, setup, tools) if file and Path(file).exists())
    with suppress(UsageError, OSError):  # the error is reported where the files are used
        yield from ((str(file), what) for file in files_of(machine, setup, tools))


def _identity(path: str) -> object:
    """What two names of one file have in common, hard links too; it need not be there yet."""
    real = os.path.realpath(path)
    try:
        status = os.stat(real)
    except OSError:
        return real
    return status.st_dev, status.st_ino


def _is_device(path: str) -> bool:
    """Whether what is written there is kept nowhere, such as in /dev/null."""
    return Path(path).exists() and not Path(path).is_file()


def write_new(path: str, text: str, kind: str) -> None:
    """Write a new machine, tools or setup file, and its schema for editors beside it.

    Raises:
        UsageError: there is such a file, or it cannot be written.
    """
    from gcodesim.machine.schema_files import schema_name, schema_text, with_schema

    try:
        if os.path.lexists(path):
            raise UsageError(f"{path}: there is such a file already; name another")
        write_text(path, with_schema(kind, text))
        schema = Path(path).with_name(schema_name(kind))
        if not os.path.lexists(schema):
            write_text(str(schema), schema_text(kind))
    except OSError as error:
        raise UsageError(f"{path}: cannot be written: {error.strerror}") from error
