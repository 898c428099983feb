"""Pixels: what a picture needs besides its surfaces, letters, marks and the PNG file itself."""

from __future__ import annotations

import struct
import zlib

import numpy as np
from numpy.typing import NDArray

Pixels = NDArray[np.uint8]
Color = tuple[int, int, int]

FONT = bytes.fromhex(
    "000000000000005f00000007000700147f147f14242a7f2a12231308646236495522500005030000001c224100"
    "0041221c0014083e081408083e080800503000000808080808006060000020100804023e5149453e00427f4000"
    "42615149462141454b311814127f1027454545393c4a49493001710905033649494936064949291e0036360000"
    "00563600000814224100141414141400412214080201510906324979413e7e1111117e7f494949363e41414122"
    "7f4141221c7f494949417f090909013e4149497a7f0808087f00417f41002040413f017f081422417f40404040"
    "7f020c027f7f0408107f3e4141413e7f090909063e4151215e7f09192946464949493101017f01013f4040403f"
    "1f2040201f3f4038403f631408146307087008076151494543007f41410002040810200041417f000402010204"
    "4040404040000102040020545454787f484444383844444420384444487f3854545418087e0901020c5252523e"
    "7f0804047800447d40002040443d007f1028440000417f40007c041804787c0804047838444444387c14141408"
    "081414187c7c080404084854545420043f4440203c4040207c1c2040201c3c4030403c44281028440c5050503c"
    "4464544c44000836410000007f000000413608001008081008"
)
"""The characters from space to tilde: 5 columns of 7 dots each, the lowest bit on top."""

CELL = 6
"""Width of a character with the gap after it [dots]."""


def draw_text(
    pixels: Pixels, corner: tuple[int, int], text: str, color: Color, scale: int = 2
) -> None:
    """Write a line of text; what has no letter here is a question mark.

    Args:
        pixels: shape (height, width, 3), drawn on.
        corner: column and row of the upper left corner; what lies outside is cut off.
        text: printable ASCII.
        color: of the letters.
        scale: pixels per dot.
    """
    for place, character in enumerate(text):
        number = ord(character if " " <= character <= "~" else "?") - ord(" ")
        columns = np.frombuffer(FONT[5 * number : 5 * number + 5], np.uint8)
        dots = (columns >> np.arange(8)[:, None]) & 1
        rows, cells = np.nonzero(np.kron(dots, np.ones((scale, scale), np.uint8)))
        _paint(pixels, cells + corner[0] + place * CELL * scale, rows + corner[1], color)


def draw_ring(
    pixels: Pixels, center: tuple[float, float], radius: float, color: Color, width: float = 3.0
) -> None:
    """Draw a circle around a place (column, row)."""
    rows, columns = np.indices(pixels.shape[:2])
    away = np.hypot(columns + 0.5 - center[0], rows + 0.5 - center[1])
    pixels[np.abs(away - radius) < width / 2.0] = color


def draw_line(
    pixels: Pixels, a: tuple[float, float], b: tuple[float, float], color: Color, width: float
) -> None:
    """Draw a line between two places (column, row)."""
    rows, columns = np.indices(pixels.shape[:2])
    x, y = columns + 0.5 - a[0], rows + 0.5 - a[1]
    dx, dy = b[0] - a[0], b[1] - a[1]
    share = np.clip((x * dx + y * dy) / max(dx * dx + dy * dy, 1e-9), 0.0, 1.0)
    pixels[np.hypot(x - share * dx, y - share * dy) < width / 2.0] = color


def draw_box(pixels: Pixels, corner: tuple[int, int], size: tuple[int, int], color: Color) -> None:
    """Fill a rectangle: column and row of its upper left corner, width and height."""
    x, y = corner
    pixels[max(y, 0) : max(y + size[1], 0), max(x, 0) : max(x + size[0], 0)] = color


def _paint(pixels: Pixels, columns: NDArray[np.intp], rows: NDArray[np.intp], color: Color) -> None:
    height, width = pixels.shape[:2]
    inside = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
    pixels[rows[inside], columns[inside]] = color


def png_bytes(pixels: Pixels) -> bytes:
    """A PNG file of 8-bit RGB pixels, shape (height, width, 3). ISO/IEC 15948."""
    height, width, _ = pixels.shape
    # Every row begins with its filter: 2, the difference to the row above.
    rows = np.diff(pixels.reshape(height, -1), axis=0, prepend=np.zeros((1, 3 * width), np.uint8))
    filtered = np.concatenate([np.full((height, 1), 2, np.uint8), rows], axis=1)
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(filtered.tobytes())), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(kind, data) for kind, data in chunks)


def _chunk(kind: bytes, data: bytes) -> bytes:
    check = zlib.crc32(kind + data)
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", check)
