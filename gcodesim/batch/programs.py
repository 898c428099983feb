"""Programs of a batch: which files are meant; quick to import, for the workers wait for it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from glob import glob, has_magic
from pathlib import Path

from gcodesim.errors import UsageError

SUFFIXES = {".nc", ".ngc", ".cnc", ".tap", ".mpf", ".min", ".eia", ".gcode"}
"""Endings of the files that count as programs when a folder is given."""


def find_programs(patterns: Sequence[str]) -> list[str]:
    """Programs named by files, glob patterns (`**` too) and folders, each once, in order.

    Raises:
        UsageError: a pattern or folder holds no program.
    """
    programs: dict[str, None] = {}
    for pattern in patterns:
        found = sorted(_programs(pattern))
        if not found:
            raise UsageError(f"{pattern}: no program there (*{', *'.join(sorted(SUFFIXES))})")
        programs |= dict.fromkeys(found)
    return list(programs)


def _programs(pattern: str) -> Iterator[str]:
    if has_magic(pattern) and not Path(pattern).exists():
        yield from (name for name in glob(pattern, recursive=True) if Path(name).is_file())
    elif Path(pattern).is_dir():
        files = (path for path in Path(pattern).rglob("*") if path.suffix.lower() in SUFFIXES)
        yield from (str(path) for path in files if path.is_file())
    else:
        yield pattern  # a missing file is an answer of its own program
