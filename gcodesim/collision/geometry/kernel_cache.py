"""The folder of compiled kernels: what is damaged is built again, another replaces a locked one.

Warp loads whatever lies there under the right name. Beside each object file lies its checksum.
"""

from __future__ import annotations

import atexit
import hashlib
import json
import os
import shutil
import stat
import tempfile
from contextlib import suppress
from pathlib import Path

import warp as wp

from gcodesim.errors import UsageError
from gcodesim.output_file import write_text

OURS = "wp_gcodesim.*"
"""Folders of our modules."""

OBJECTS = (".o", ".ptx", ".cubin")

_remarks: list[str] = []


def start_warp() -> None:
    """Start Warp with a folder that can be written and holds nothing damaged.

    Raises:
        UsageError: there is no such folder, or too little memory for Warp.
    """
    try:
        wp.init()
    except OSError as error:
        wp.config.kernel_cache_dir = str(_spare_folder(error))
        wp.init()
    except RuntimeError as error:  # its libraries cannot be loaded
        why = error.__cause__ or error
        raise UsageError(f"Warp cannot be started: {why}: is there enough memory?") from error
    folder = Path(wp.config.kernel_cache_dir)
    damaged = [module for module in folder.glob(OURS) if not _is_sound(module)]
    try:
        for module in damaged:
            shutil.rmtree(module)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        _move_to(_spare_folder(error) / folder.name, damaged)
    if damaged:
        _remarks.append(f"kernel cache {folder}: {len(damaged)} damaged: built again")
    seal()
    atexit.register(seal)


def start_anew(error: Exception) -> None:
    """Go on with an empty folder: what Warp found or wrote in the other could not be loaded.

    Raises:
        UsageError: there is no other folder.
    """
    spare = _spare_folder(error) / wp.config.version
    shutil.rmtree(spare, ignore_errors=True)
    _move_to(spare, list(Path(wp.config.kernel_cache_dir).glob(OURS)))


def remarks() -> list[str]:
    """Return what is to be said about the folder, each once."""
    said, _remarks[:] = list(_remarks), []
    return said


def seal() -> None:
    """Write the checksums of what was compiled since."""
    with suppress(OSError):
        for module in Path(wp.config.kernel_cache_dir).glob(OURS):
            for file in _objects(module):
                if not _seal_of(file).exists():
                    write_text(_seal_of(file), _checksum(file))


def _is_sound(module: Path) -> bool:
    """Whether the files of a module are what was once compiled."""
    try:
        for file in _objects(module):
            seal = _seal_of(file)
            if not file.stat().st_size or (seal.exists() and seal.read_text() != _checksum(file)):
                return False
        for file in module.glob("*.meta"):
            json.loads(file.read_text())
    except (OSError, ValueError):
        return False
    return True


def _objects(module: Path) -> list[Path]:
    return [file for file in module.iterdir() if file.suffix in OBJECTS]


def _seal_of(file: Path) -> Path:
    return file.with_name(f"{file.name}.sha256")


def _checksum(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()


def _move_to(folder: Path, left: list[Path]) -> None:
    """Keep kernels in another folder from now on, with those of the old one that are not left."""
    old = Path(wp.config.kernel_cache_dir)
    folder.mkdir(parents=True, exist_ok=True)
    for module in set(old.glob(OURS)) - set(left):
        if not (folder / module.name).exists():
            shutil.copytree(module, folder / module.name)
    for module in [module for module in folder.glob(OURS) if not _is_sound(module)]:
        shutil.rmtree(module)
    wp.config.kernel_cache_dir = str(folder)


def _spare_folder(error: Exception) -> Path:
    """A folder of this user alone, for kernels that cannot be kept where they belong; UsageError.

    What lies in a folder that others may write to would be run as it is.
    """
    wanted = os.environ.get("WARP_CACHE_PATH", "of this user")
    why = getattr(error, "strerror", None) or " ".join(str(error).split())
    try:
        folder = Path(tempfile.gettempdir()) / f"gcodesim-kernels-{_user()}"
        folder.mkdir(mode=0o700, exist_ok=True)
        there = folder.lstat()
        others = stat.S_IMODE(there.st_mode) & 0o077
        if not stat.S_ISDIR(there.st_mode) or (os.name != "nt" and others) or not _is_own(there):
            folder = Path(tempfile.mkdtemp(prefix="gcodesim-kernels-"))
    except OSError as second:
        text = f"kernels can be kept neither in the cache {wanted} ({why}) nor elsewhere ({second})"
        raise UsageError(f"{text}: set WARP_CACHE_PATH to a folder that can be written") from error
    _remarks.append(f"kernel cache {wanted} cannot be used ({why}): {folder} is")
    return folder


def _user() -> str:
    return str(os.getuid()) if hasattr(os, "getuid") else "user"


def _is_own(there: os.stat_result) -> bool:
    return not hasattr(os, "getuid") or there.st_uid == os.getuid()
