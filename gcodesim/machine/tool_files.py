"""Tells kinds of tool files apart, and reads each as if it were a tools file."""

from __future__ import annotations

import io
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path

from gcodesim.errors import ModelError, UsageError
from gcodesim.input_file import read_bytes
from gcodesim.machine.formats.libraries.freecad import bits_of, read_freecad
from gcodesim.machine.formats.libraries.fusion import read_fusion
from gcodesim.machine.formats.libraries.json_items import read_json
from gcodesim.machine.formats.libraries.library import Library
from gcodesim.machine.formats.libraries.offset_dump import is_dump, read_dump
from gcodesim.machine.formats.libraries.tool_t import read_tool_t
from gcodesim.machine.formats.libraries.tool_tbl import read_tool_tbl
from gcodesim.machine.mesh import MM_PER_UNIT
from gcodesim.machine.yaml_lines import YamlFile, read_yaml

OWN = (".yaml", ".yml")
KINDS = (
    "a tools file (.yaml), a Fusion library (.json, .tools), FreeCAD bits (.fctl, .fctb), a "
    "LinuxCNC tool table (.tbl), a Heidenhain TOOL.T, or G10 blocks or $TC_ data of a control"
)

MOST_BYTES = 512_000_000
"""Largest library, of a .tools file unpacked too: beyond it a zip is taken for a bomb."""


def read_tool_source(path: Path) -> YamlFile:
    """The data of a tools file, own or foreign, with the lines of the file that was read.

    Raises:
        UsageError: the file cannot be read.
        ModelError: it is wrong, or of no kind that is known; names file and line.
    """
    return read_yaml(path) if path.suffix.lower() in OWN else read_library(path).source


def read_library(path: Path, unit: str | None = None) -> Library:
    """A foreign library of tools.

    Args:
        path: the file.
        unit: mm | inch, of a LinuxCNC tool table, which does not tell it; None: mm.

    Raises:
        UsageError: the file cannot be read.
        ModelError: it is wrong, or of no kind that is known; names file and line.
    """
    text = _text_of(path)
    if path.suffix.lower() == ".tbl":
        return read_tool_tbl(path, text, MM_PER_UNIT[unit or "mm"])
    if unit is not None:
        raise UsageError(f"{path}: --units is for a LinuxCNC tool table (.tbl); others tell theirs")
    if text.lstrip().startswith("{"):
        whole = read_json(path, text)
        if isinstance(whole.value.get("data"), list):
            return read_fusion(path, whole)
        if isinstance(whole.value.get("tools"), list) or "parameter" in whole.value:
            return read_freecad(path, whole)
        what = "neither a Fusion library (`data`) nor FreeCAD's (`tools`, `parameter`)"
        raise ModelError(f"this JSON is {what}", str(path), 1)
    if text.lstrip()[:6].upper() == "BEGIN ":
        return read_tool_t(path, text)
    if is_dump(text):
        return read_dump(path, text)
    raise ModelError(f"no file of tools: expected {KINDS}", str(path), 1)


def bit_files(path: Path) -> Iterator[Path]:
    """Yield the files beside a library that it is read from too."""
    if path.suffix.lower() == ".fctl":
        yield from bits_of(path, read_json(path, _text_of(path)))


def _text_of(path: Path) -> str:
    """The text of a file, unpacked from a .tools file."""
    try:
        content = read_bytes(path, MOST_BYTES)
    except OSError as error:
        raise UsageError(f"{path}: cannot be read: {error.strerror}") from error
    if content.startswith(b"PK"):
        content = _unpacked(path, content)
    try:
        text = content.decode("utf-8-sig")
        return text.replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as error:
        if path.suffix.lower() in (".t", ".h"):  # controls write their own letters in comments
            return content.decode("latin-1")
        raise ModelError(f"not UTF-8 text: byte {error.start}", str(path)) from error


def _unpacked(path: Path, content: bytes) -> bytes:
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            names = [each for each in archive.infolist() if each.filename.endswith(".json")]
            if len(names) != 1:
                raise ModelError(f"expected one .json in it, found {len(names)}", str(path))
            if names[0].file_size > MOST_BYTES:
                raise ModelError(f"its library is larger than {MOST_BYTES:,} bytes", str(path))
            return archive.read(names[0])
    except (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, EOFError) as error:
        raise ModelError(f"no valid .tools file: {error}", str(path)) from error
