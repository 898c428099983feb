"""Programs of a batch: which files are meant; quick to import, for the workers wait for it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
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
    programs: list[str] = []
    for pattern in patterns:
        found = matching(pattern)
        if not found:
            raise UsageError(f"{pattern}: no program there (*{', *'.join(sorted(SUFFIXES))})")
        programs += found
    return each_once(programs)


def matching(pattern: str, folder: Path = Path()) -> list[str]:
    """Programs of a file, glob pattern or folder, counted from `folder`, in alphabetical order.

    A file that is missing is named all the same: that is an answer of its own program.
    """
    path = folder / pattern
    if path.is_dir():
        files = [file for file in path.rglob("*") if is_program(file)]
    elif has_magic(pattern) and not path.exists():
        files = [folder / name for name in glob(pattern, root_dir=folder, recursive=True)]
    else:
        return [str(path)]
    # A link that leads nowhere is named too: silence about a program would be taken for a PASS.
    return sorted(str(file) for file in files if file.is_file() or is_dangling(file))


def is_program(file: Path) -> bool:
    """Whether a file of a folder is taken as a program, by its ending."""
    return file.suffix.lower() in SUFFIXES


def is_dangling(file: Path) -> bool:
    """Whether a file is a link to what is not there."""
    return file.is_symlink() and not file.exists()


def skipped(patterns: Iterable[str], folder: Path = Path()) -> str:
    """Which files of the folders among the patterns are no programs, for people; "" if none.

    Files and folders with a dot in front are hidden, and not spoken of.
    """
    files = {
        file.resolve(): file.suffix.lower() or "without ending"
        for path in (folder / pattern for pattern in patterns)
        if path.is_dir()
        for file in path.rglob("*")
        if not any(part.startswith(".") for part in file.relative_to(path).parts)
        and file.is_file()
        and not is_program(file)
    }
    if not files:
        return ""
    counts = sorted(Counter(files.values()).items())
    endings = ", ".join(f"{count} {ending}" for ending, count in counts)
    many = "files that are no programs" if len(files) > 1 else "file that is no program"
    return f"skipped: {len(files)} {many} by ending ({endings})"


def each_once(names: Iterable[str], file_of: Callable[[str], Path] = Path) -> list[str]:
    """Names of files without those that lead to a file that was named before.

    A link to a file with another name is another program: reports and baselines go by names.
    """
    first: dict[Path, str] = {}
    for name in names:
        file = file_of(name)
        first.setdefault(file.parent.resolve() / file.name, name)
    return list(first.values())
