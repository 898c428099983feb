"""Programs of a batch: which files are meant; quick to import, for the workers wait for it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from glob import glob, has_magic
from pathlib import Path

from gcodesim.errors import UsageError

SUFFIXES = {".nc", ".ngc", ".cnc", ".tap", ".mpf", ".min", ".eia", ".gcode"}
"""Endings of the files that count as programs when a folder is given."""

SHARED_SUFFIXES = {".anc", ".din", ".gc", ".h", ".i", ".iso", ".ptp", ".spf", ".txt"}
"""Endings that programs share with other files: those count that read like a program."""

HEAD_BYTES = 1 << 14
"""Bytes of a file that are looked at, to tell whether it reads like a program."""


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
    """Whether a file of a folder is taken as a program: by its ending, or by its text too."""
    suffix = file.suffix.lower()
    if suffix in SHARED_SUFFIXES:
        return file.is_file() and _reads_like_program(file)
    return suffix in SUFFIXES


def _reads_like_program(file: Path) -> bool:
    """Whether the first lines of a file are mostly blocks, or tell a language of machines."""
    # Imported late: most files are told by their ending, and the workers wait for this module.
    from gcodesim.nc.detect import reads_like_program
    from gcodesim.nc.lines import decode

    try:
        with file.open("rb") as opened:
            head = opened.read(HEAD_BYTES)
    except OSError:
        return False
    lines = decode(head).splitlines()
    # The last line may be cut off.
    return reads_like_program(lines[:-1] if len(head) == HEAD_BYTES else lines)


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
    return f"skipped: {len(files)} {many} by ending or text ({endings})"


def each_once(names: Iterable[str], file_of: Callable[[str], Path] = Path) -> list[str]:
    """Names of files without those that lead to a file that was named before.

    A link to a file with another name is another program: reports and baselines go by names.
    """
    first: dict[Path, str] = {}
    for name in names:
        file = file_of(name)
        first.setdefault(file.parent.resolve() / file.name, name)
    return list(first.values())
