"""Levels of the pecks of a hole: one depth Q, or on Haas I first, J less each time, K least."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from gcodesim.constants import SAME_LEVEL_MM
from gcodesim.nc.iso.block import Block

MAX_STEPS = 100_000
"""Holes of a block, or pecks of a hole, above which a block is refused: it would fill memory."""


def peck_depths(
    block: Block, r: float, z: float, words: Mapping[str, float], repeats: int
) -> list[float]:
    """Return the levels of the pecks, the last one the bottom.

    Args:
        block: the block that is refused where there are too many.
        r: R level [mm].
        z: bottom [mm].
        words: Q, or I J K [mm]; none of them is one stroke.
        repeats: holes of the block.

    Raises:
        ProgramError: a hole has more than MAX_STEPS pecks.
    """
    first, least = words.get("I", words.get("Q", 0.0)), _least(words)
    if not first:
        return [z]
    smallest = min(first, least)
    if smallest <= 0 or repeats * (r - z) / smallest > MAX_STEPS:
        raise block.error("cycle_too_long", f"{(r - z) / (smallest or 1):.3g} pecks", "Q")
    depths, depth = [], r
    for size in _sizes(first, words.get("J", 0.0) if "I" in words else 0.0, least):
        depth -= size
        if depth <= z + SAME_LEVEL_MM:
            break
        depths.append(depth)
    return [*depths, z]


def _least(words: Mapping[str, float]) -> float:
    """Return the smallest peck [mm]."""
    if "I" not in words:
        return words.get("Q", 0.0)
    return words.get("K", 0.0) or (words["I"] if not words.get("J") else 0.0)


def _sizes(first: float, less: float, least: float) -> Iterator[float]:
    """Yield the sizes of pecks without end."""
    size = first
    while True:
        yield size
        size = max(size - less, least)
