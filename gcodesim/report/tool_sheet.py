"""Draws tools from the side: flute, shank, holder, the gauge line and the lengths, as one PNG."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gcodesim.report.raster import CELL, Color, Pixels, draw_box, draw_text, png_bytes

if TYPE_CHECKING:
    from gcodesim.machine.model import Part, Tool

Floats = NDArray[np.float64]

WIDTH, HEIGHT = 300, 480
"""Of the field of one tool [pixels]."""

TOP, BOTTOM, SIDE = 64, 40, 80
"""Room for the name above, the diameter below, and the lengths at the right [pixels]."""

MOST_IN_A_ROW = 6
BACKGROUND, INK, GREY = (250, 250, 248), (30, 30, 35), (150, 155, 160)
FLUTE, SHANK, HOLDER = (214, 120, 44), (120, 130, 140), (70, 80, 92)
COLORS: dict[str, Color] = {"flute": FLUTE, "shank": SHANK, "holder": HOLDER}
GAUGE: Color = (38, 100, 210)

EDGE_SAMPLES = 33
"""Points looked at along an edge of a mesh."""


def tool_sheet(tools: Sequence[Tool]) -> bytes:
    """A PNG with a field for every tool, each to its own scale.

    Args:
        tools: at least one.
    """
    columns = min(len(tools), MOST_IN_A_ROW)
    rows = math.ceil(len(tools) / columns)
    pixels = np.full((rows * HEIGHT, columns * WIDTH, 3), BACKGROUND, np.uint8)
    for place, tool in enumerate(tools):
        row, column = divmod(place, columns)
        field = pixels[row * HEIGHT : (row + 1) * HEIGHT, column * WIDTH : (column + 1) * WIDTH]
        _draw_tool(field, tool)
    return png_bytes(pixels)


def _draw_tool(field: Pixels, tool: Tool) -> None:
    draw_text(field, (8, 8), f"T{tool.number} {tool.type}"[: WIDTH // (2 * CELL)], INK)
    draw_text(field, (8, 32), tool.name[: WIDTH // CELL - 2], GREY, scale=1)
    if not tool.parts:
        draw_text(field, (8, HEIGHT // 2), "no shape", INK)
        return
    points = np.concatenate([part.triangles.reshape(-1, 3) for part in tool.parts])
    widest = float(np.hypot(points[:, 0], points[:, 1]).max())
    top, tip = max(float(points[:, 2].max()), 0.0), -tool.length
    high = max(top - min(tip, float(points[:, 2].min())), 1e-9)
    scale = min((HEIGHT - TOP - BOTTOM) / high, (WIDTH - SIDE - 16) / 2.0 / max(widest, 1e-9))
    centre = (WIDTH - SIDE) // 2

    def row(z: float) -> int:
        return round(TOP + (top - z) * scale)

    for part in tool.parts:
        _fill(field, part, centre, scale, top)
    for y in range(row(top), row(top - high), 8):
        draw_box(field, (centre, y), (1, 4), BACKGROUND)
    draw_box(field, (4, row(0.0)), (WIDTH - SIDE, 2), GAUGE)
    draw_text(field, (6, row(0.0) - 12), "gauge line", GAUGE, scale=1)
    _measure(field, (row(0.0), row(tip)), WIDTH - SIDE + 4, f"{tool.length:.4g}")
    flute = next((part for part in tool.parts if part.name == "flute"), None)
    if flute is not None:
        height = float(flute.triangles[..., 2].max()) - tip
        _measure(field, (row(tip + height), row(tip)), WIDTH - SIDE + 40, f"{height:.4g}")
    diameter = f"D{tool.diameter:.4g}" if tool.diameter else ""
    missing = f" no {', no '.join(tool.unchecked)}" if tool.unchecked else ""
    draw_text(field, (8, HEIGHT - 24), diameter, INK)
    draw_text(field, (8 + 2 * CELL * len(diameter), HEIGHT - 18), missing, COLORS["flute"], scale=1)


def _fill(field: Pixels, part: Part, centre: int, scale: float, top: float) -> None:
    """Paint the side of a part, row by row."""
    z = np.asarray(top - (np.arange(HEIGHT) - TOP + 0.5) / scale, np.float64)
    radii = _radii(part, z)
    low, high = float(part.triangles[..., 2].min()), float(part.triangles[..., 2].max())
    columns = np.arange(WIDTH)
    inside = (z >= low) & (z <= high)
    across = np.maximum(radii * scale, 0.5)[:, None]
    painted = inside[:, None] & (np.abs(columns + 0.5 - centre) <= across)
    field[painted] = COLORS.get(part.name, GREY)


def _radii(part: Part, z: Floats) -> Floats:
    """Radius of a part at heights: of its outline, or the largest of its mesh."""
    if part.turned is not None:
        outline = np.array(part.turned.outer)
        return np.interp(z, outline[:, 1], outline[:, 0])
    start, end = part.triangles, np.roll(part.triangles, -1, axis=1)
    share = np.linspace(0.0, 1.0, EDGE_SAMPLES)[:, None]
    points = (start[:, :, None] + share * (end - start)[:, :, None]).reshape(-1, 3)
    step = abs(float(z[1] - z[0]))
    rows = np.clip(np.rint((z[0] - points[:, 2]) / step).astype(int), 0, len(z) - 1)
    radii = np.full(len(z), -1.0)
    np.maximum.at(radii, rows, np.hypot(points[:, 0], points[:, 1]))
    seen = np.flatnonzero(radii >= 0.0)
    return np.interp(np.arange(len(z)), seen, radii[seen])


def _measure(field: Pixels, rows: tuple[int, int], column: int, text: str) -> None:
    """Draw a length between two rows, with its number beside it."""
    top, bottom = rows
    draw_box(field, (column, top), (1, max(bottom - top, 1)), INK)
    for end in rows:
        draw_box(field, (column - 3, end), (7, 1), INK)
    draw_text(field, (column + 4, (top + bottom) // 2 - 4), text, INK, scale=1)
