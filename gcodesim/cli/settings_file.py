"""The settings file: gcodesim.toml, or [tool.gcodesim] of pyproject.toml, and its jobs."""

from __future__ import annotations

import os
import re
import tomllib
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from functools import cached_property
from pathlib import Path
from typing import Any

from gcodesim.errors import UsageError
from gcodesim.input_file import read_text

OWN_FILE, PROJECT_FILE = "gcodesim.toml", "pyproject.toml"
TABLE = ("tool", "gcodesim")
"""Where the settings stand in a project file."""

TOKENS = re.compile(
    r'"""(?:\\.|[^\\])*?"{3,5}|"(?:\\.|[^"\\])*"'  # texts with escapes, over lines or not
    r"|'''.*?'{3,5}|'[^']*'"  # and without
    r"|#[^\n]*|[][{}]|\n",
    re.DOTALL,
)
"""What decides where a statement ends; everything between is of no weight for that."""
OPENING, CLOSING = ("[", "{"), ("]", "}")

Keys = tuple[str | int, ...]
"""Way to a value: ``("jobs", 0, "feed")``."""


@dataclass(frozen=True)
class JobTable:
    """Programs that belong together with a machine.

    Attributes:
        keys: where it stands in the file.
        patterns: of program files, counted from the folder of the settings.
        values: option -> value; they replace those at the top of the file.
    """

    keys: Keys
    patterns: tuple[str, ...]
    values: dict[str, Any]


@dataclass(frozen=True)
class SettingsFile:
    """What a settings file says; without a path it says nothing.

    Attributes:
        path: the file, as a path from here; None: there is none.
        values: option -> value.
        jobs: in the order of the file.
    """

    path: str | None = None
    values: dict[str, Any] = field(default_factory=dict)
    jobs: tuple[JobTable, ...] = ()

    @property
    def folder(self) -> Path:
        """Folder from which the paths in the file are counted."""
        return Path(self.path or ".").parent

    @cached_property
    def lines(self) -> dict[Keys, int]:
        """Line in which each key of the file begins."""
        return {} if self.path is None else _lines(Path(self.path))

    def place(self, *keys: str | int) -> str:
        """File, line and keys, as an error begins: `gcodesim.toml:7: jobs[0].feed`.

        The line is that of the table where the key itself is missing.
        """
        known = (keys[:end] for end in range(len(keys), 0, -1) if keys[:end] in self.lines)
        line = next((f":{self.lines[found]}" for found in known), "")
        named = "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in keys)
        return f"{self.path}{line}: {named.removeprefix('.')}"


def find_settings(programs: Iterable[str]) -> str | None:
    """The settings file that is nearest above the programs, or above here without programs.

    Raises:
        UsageError: programs lie under different settings.
    """
    folders = {Path(os.path.abspath(name)).parent for name in programs if name != "-"}
    found = {_nearest(folder) for folder in folders or {Path.cwd()}}
    if len(found) > 1:
        names = ", ".join(sorted(str(file) if file else "none" for file in found))
        text = f"the programs lie under different settings ({names})"
        raise UsageError(f"{text}: check them in several runs, or give --settings FILE")
    file = found.pop()
    return None if file is None else _from_here(file)


def read_settings(path: str | None) -> SettingsFile:
    """Read a settings file; None is no settings at all.

    Raises:
        UsageError: it is missing or wrong; names file and key, or line.
    """
    if path is None:
        return SettingsFile()
    table = _read_table(Path(path))
    if table is None:
        raise UsageError(f"{path}: tool.gcodesim: this table is missing")
    jobs = table.pop("jobs", [])
    settings = SettingsFile(path, table)
    if not isinstance(jobs, list):
        raise UsageError(f"{settings.place('jobs')}: expected [[jobs]], a list of tables")
    read = tuple(_job(settings, ("jobs", i), job) for i, job in enumerate(jobs))
    return replace(settings, jobs=read)


def _job(settings: SettingsFile, keys: Keys, table: Any) -> JobTable:
    if not isinstance(table, dict):
        text = "expected a table, such as [[jobs]] with programs and machine"
        raise UsageError(f"{settings.place(*keys)}: {text}")
    if "programs" not in table and (near := get_close_matches("programs", table, n=1)):
        place = settings.place(*keys, near[0])
        raise UsageError(f"{place}: unknown key; did you mean 'programs'?")
    patterns = table.pop("programs", None)
    texts = isinstance(patterns, list) and all(isinstance(p, str) and p for p in patterns)
    if not patterns or not texts:
        text = 'expected a list of patterns, such as ["parts/*.nc"]'
        raise UsageError(f"{settings.place(*keys, 'programs')}: {text}")
    return JobTable(keys, tuple(patterns), table)


def _nearest(folder: Path) -> Path | None:
    for above in (folder, *folder.parents):
        if (above / OWN_FILE).is_file():
            return above / OWN_FILE
        project = above / PROJECT_FILE
        if project.is_file() and _read_table(project) is not None:
            return project
    return None


def _read_table(file: Path) -> dict[str, Any] | None:
    """The settings of a file; None for a project file without any."""
    try:
        data = tomllib.loads(read_text(file))
    except OSError as error:
        raise UsageError(f"{file}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise UsageError(f"{file}: not UTF-8 text: byte {error.start}") from error
    except (ValueError, RecursionError) as error:
        raise UsageError(f"{file}: no valid TOML: {error}") from error
    if file.name != PROJECT_FILE:
        return data
    table = data.get("tool", {}).get("gcodesim")
    if table is not None and not isinstance(table, dict):
        raise UsageError(f"{file}: tool.gcodesim: expected a table")
    return table


def _lines(file: Path) -> dict[Keys, int]:
    """Line in which each key of the settings begins: tomllib does not tell."""
    top = TABLE if file.name == PROJECT_FILE else ()
    lines: dict[Keys, int] = {}
    counts: Counter[Keys] = Counter()
    table: Keys = ()
    for line, text, values in _statements(read_text(file)):
        if text.startswith("["):
            table = keys = _table(values, counts)
        else:
            keys = (*table, next(iter(values)))
        if keys[: len(top)] == top:
            own = keys[len(top) :]
            lines[own] = line
            lines.setdefault(own[:-1], line)  # a list of tables begins with its first one
    return lines


def _statements(text: str) -> Iterator[tuple[int, str, dict[str, Any]]]:
    """Yield every statement of a valid file: its first line, its text, and its values read alone.

    A statement ends with the first line that ends outside of texts and brackets.
    """
    begin = depth = 0
    number = 1
    for token in TOKENS.finditer(f"{text}\n"):
        mark = token[0]
        depth += (mark in OPENING) - (mark in CLOSING)
        if mark == "\n" and depth == 0:
            statement = text[begin : token.start()].lstrip()
            if values := tomllib.loads(statement):
                yield number, statement, values
            number += text.count("\n", begin, token.end())
            begin = token.end()


def _table(values: dict[str, Any], counts: Counter[Keys]) -> Keys:
    """Keys of the table that a header opens; `counts` says how long each list of tables is."""
    keys: Keys = ()
    while values:
        ((key, below),) = values.items()
        keys = (*keys, key)
        if isinstance(below, list):
            counts[keys] += 1
            (below,) = below
        if counts[keys]:
            keys = (*keys, counts[keys] - 1)
        values = below
    return keys


def _from_here(file: Path) -> str:
    """A path from the working folder, where that is short; else as it is."""
    relative = os.path.relpath(file)
    return str(file) if relative.count("..") > 3 else relative
