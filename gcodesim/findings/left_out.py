"""What a check left out: what was not needed, with the margin that proves it; what did not run."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class LeftOut:
    """Something that was not looked at, and why that is sound; see the report schema.

    Attributes:
        what: pair, axis or body.
        why: one short sentence.
        bound_mm: distance that had to be proved [mm].
        margin_mm: distance proved beyond it [mm]; 0 where no distance is involved.
        saved_tests: tests at samples that were not needed.
        triangles: triangles of a body that were left out, it and its pairs staying.
    """

    what: str
    why: str
    bound_mm: float = 0.0
    margin_mm: float = 0.0
    saved_tests: int = 0
    triangles: int = 0


@dataclass(frozen=True, slots=True)
class NotRun:
    """Lines of a program whose effect is not in the check, or not the only one they may have.

    Attributes:
        what: they are.
        count, line: how many; the first one, among the lines of all texts.
    """

    what: str
    count: int
    line: int
