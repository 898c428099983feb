"""Reads models of VERICUT: files that end in .ply and are not the PLY format of Stanford.

Four lines, and then for each facet its number of corners (one byte), the corners and the normal,
three float64 each: 97 bytes a triangle.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gcodesim.errors import ModelError
from gcodesim.input_file import read_bytes

MAGIC = b"VERICUT-model"
HEADER_LINES = 4

_FACET = np.dtype([("corners", "u1"), ("points", "<f8", (3, 3)), ("normal", "<f8", 3)])


def is_vericut_model(path: Path) -> bool:
    """Whether a file that can be read begins as a model of VERICUT."""
    if path.suffix.lower() != ".ply":
        return False
    with path.open("rb") as file:
        return file.read(len(MAGIC)) == MAGIC


def read_vericut_model(path: Path) -> NDArray[np.float64]:
    """Its triangles (n, 3, 3) in the unit of the file.

    Raises:
        ModelError: it is cut off, or a facet is no triangle.
        OSError: the file cannot be read.
    """
    content, begin = read_bytes(path), 0
    for _ in range(HEADER_LINES):
        begin = content.find(b"\n", begin) + 1
        if not begin:
            text = f"a model of VERICUT has {HEADER_LINES} lines before its facets: it is cut off"
            raise ModelError(text, str(path))
    count, rest = divmod(len(content) - begin, _FACET.itemsize)
    facets = np.frombuffer(content, _FACET, count, begin)
    other = np.flatnonzero(facets["corners"] != 3)
    if len(other):
        text = f"facet {other[0]} (counted from 0) has {facets['corners'][other[0]]} corners, not 3"
        raise ModelError(f"{text}: it is damaged, or to be exported as STL", str(path))
    if rest:
        text = f"{count} triangles of {_FACET.itemsize} bytes, and {rest} bytes more"
        raise ModelError(f"the file holds {text}: it is cut off or damaged", str(path))
    return facets["points"].astype(np.float64)
