"""The settings file: gcodesim.toml, or [tool.gcodesim] of pyproject.toml, and its jobs."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gcodesim.errors import UsageError

OWN_FILE, PROJECT_FILE = "gcodesim.toml", "pyproject.toml"


@dataclass(frozen=True)
class Job:
    """Programs that belong together with a machine.

    Attributes:
        place: file and key, for errors.
        patterns: of program files, counted from the folder of the settings.
        values: option -> value; they replace those at the top of the file.
    """

    place: str
    patterns: tuple[str, ...]
    values: dict[str, Any]


@dataclass(frozen=True)
class Settings:
    """What a settings file says; without a path it says nothing.

    Attributes:
        path: the file, as a path from here; None: there is none.
        values: option -> value.
        jobs: in the order of the file.
    """

    path: str | None = None
    values: dict[str, Any] = field(default_factory=dict)
    jobs: tuple[Job, ...] = ()

    @property
    def folder(self) -> Path:
        """Folder from which the paths in the file are counted."""
        return Path(self.path or ".").parent

    def programs(self, job: Job) -> list[str]:
        """Files of a job in alphabetical order, pattern by pattern.

        Raises:
            UsageError: a pattern matches no file, for nothing must be left out in silence.
        """
        found: dict[str, None] = {}
        for pattern in job.patterns:
            files = self._files(job, pattern)
            if not files:
                text = f"no file matches {pattern!r} in folder {str(self.folder)!r}"
                raise UsageError(f"{job.place}.programs: {text}")
            found |= dict.fromkeys(files)
        return list(found)

    def chosen(self, job: Job, programs: Iterable[str]) -> list[str]:
        """Those of some programs that belong to a job."""
        files = {Path(f).resolve() for p in job.patterns for f in self._files(job, p)}
        return [program for program in programs if Path(program).resolve() in files]

    def _files(self, job: Job, pattern: str) -> list[str]:
        try:
            return sorted(str(file) for file in self.folder.glob(pattern) if file.is_file())
        except (ValueError, NotImplementedError) as error:
            raise UsageError(f"{job.place}.programs: {pattern!r}: {error}") from error


def find_settings(programs: Iterable[str]) -> str | None:
    """The settings file that is nearest above the programs, or above here without programs.

    Raises:
        UsageError: programs lie under different settings.
    """
    folders = {Path(program).absolute().parent for program in programs if program != "-"}
    found = {_nearest(folder) for folder in folders or {Path.cwd()}}
    if len(found) > 1:
        names = ", ".join(sorted(str(file) if file else "none" for file in found))
        text = f"the programs lie under different settings ({names})"
        raise UsageError(f"{text}: check them in several runs, or give --settings FILE")
    file = found.pop()
    return None if file is None else _from_here(file)


def read_settings(path: str | None) -> Settings:
    """Read a settings file; None is no settings at all.

    Raises:
        UsageError: it is missing or wrong; names file and key, or line.
    """
    if path is None:
        return Settings()
    table = _read_table(Path(path))
    if table is None:
        raise UsageError(f"{path}: tool.gcodesim: this table is missing")
    jobs = table.pop("jobs", [])
    if not isinstance(jobs, list):
        raise UsageError(f"{path}: jobs: expected [[jobs]], a list of tables")
    read = [_job(job, f"{path}: jobs[{i}]") for i, job in enumerate(jobs)]
    return Settings(path, table, tuple(read))


def _job(table: Any, place: str) -> Job:
    if not isinstance(table, dict):
        raise UsageError(f"{place}: expected a table, such as [[jobs]] with programs and machine")
    patterns = table.pop("programs", None)
    texts = isinstance(patterns, list) and all(isinstance(p, str) and p for p in patterns)
    if not patterns or not texts:
        raise UsageError(f'{place}.programs: expected a list of patterns, such as ["parts/*.nc"]')
    return Job(place, tuple(patterns), table)


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
        data = tomllib.loads(file.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise UsageError(f"{file}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise UsageError(f"{file}: not UTF-8 text: byte {error.start}") from error
    except tomllib.TOMLDecodeError as error:
        raise UsageError(f"{file}: no valid TOML: {error}") from error
    if file.name != PROJECT_FILE:
        return data
    table = data.get("tool", {}).get("gcodesim")
    if table is not None and not isinstance(table, dict):
        raise UsageError(f"{file}: tool.gcodesim: expected a table")
    return table


def _from_here(file: Path) -> str:
    """A path from the working folder, where that is short; else as it is."""
    relative = os.path.relpath(file)
    return str(file) if relative.count("..") > 3 else relative
