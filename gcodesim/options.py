"""What a user may choose for a check; a module of its own, because it is quick to import."""

from __future__ import annotations

from dataclasses import dataclass

from gcodesim.constants import DEFAULT_PERIOD_PS, MAX_BLOCKS


@dataclass(frozen=True)
class Options:
    """What a user may choose for a check.

    Attributes:
        dialect: replaces the dialect of the machine file.
        feed: feed until the first F word [mm/min].
        period_ps: sample period [ps].
        device: auto | cpu | cuda | cuda:N.
        method: search | exhaustive | paper.
        between: prove the time between samples too (method search).
        clearance: replaces the clearance of every pair [mm] (method search).
        minimum: find the smallest distance of every pair (method search).
        nearest: find the pair that comes nearest, and its distance (method search).
        stop_all: list every contact, not only the first (method search).
        audit: check again with nothing left out, and compare (method search).
        block_delete: leave out blocks that begin with /.
        max_blocks: interpretation ends after this many blocks.
        threads: searches side by side on the CPU, 0 for one per core.
    """

    dialect: str | None = None
    feed: float | None = None
    period_ps: int = DEFAULT_PERIOD_PS
    device: str = "auto"
    method: str = "search"
    between: bool = True
    clearance: float | None = None
    minimum: bool = False
    nearest: bool = False
    stop_all: bool = False
    audit: bool = False
    block_delete: bool = False
    max_blocks: int = MAX_BLOCKS
    threads: int = 0

    @property
    def language(self) -> tuple[str | None, float | None, bool, int]:
        """What control_for takes, besides the machine."""
        return self.dialect, self.feed, self.block_delete, self.max_blocks
