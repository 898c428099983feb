"""Skip moves: after one, nobody knows where on its way the probe has touched, and stopped it."""

from __future__ import annotations

from dataclasses import dataclass, field

SAME = 1e-6
"""Two positions this near are one [mm or deg]."""


@dataclass(slots=True)
class Skipped:
    """Where the axes may stand after a skip move: somewhere from `near` to `far`.

    Attributes:
        near, far: positions as moves are recorded: the start of the skip, and its programmed end.
        frame: what they are counted in.
        axes: indices in program.AXES of the axes that nobody knows.
        told: those of the line that is carried out which it gives a position of their own.
    """

    near: list[float]
    far: list[float]
    frame: int
    axes: set[int]
    told: set[int] = field(default_factory=set)

    def along(self, position: list[float]) -> float | None:
        """Return where a position lies on the way, 0 at `near` and 1 at `far`; None beside it."""
        way = [f - n for f, n in zip(self.far, self.near, strict=True)]
        arm = [p - n for p, n in zip(position, self.near, strict=True)]
        part = sum(a * w for a, w in zip(arm, way, strict=True)) / sum(w * w for w in way)
        beside = max(abs(a - part * w) for a, w in zip(arm, way, strict=True))
        return part if beside <= SAME else None

    def way_back(self, start: list[float], end: list[float]) -> list[list[float]]:
        """Return the ends of a move back along the way: at `near`, then beyond it.

        Args:
            start: where the move would begin after the programmed end.
            end: where it goes.

        Returns:
            Up to two positions; none where the move is no way back. How far a step by incremental
            words goes is not known either, so that it must not lead beyond `near`.
        """
        before, after = self.along(start), self.along(end)
        if before is None or after is None or after >= before:
            return []
        if after >= 0.0:
            return [end]
        return [self.near, end] if self.axes <= self.told else []

    def shift(self, start: list[float], end: list[float]) -> None:
        """Take a move into account that is no way back."""
        steps = [b - a for a, b in zip(start, end, strict=True)]
        self.near = [p + step for p, step in zip(self.near, steps, strict=True)]
        self.far = [p + step for p, step in zip(self.far, steps, strict=True)]

    def go_on(self, end: list[float], axes: set[int]) -> bool:
        """Take a further skip move into account; tell whether it runs along this one."""
        part = self.along(end)
        if part is not None and part > 1.0:
            self.far = list(end)
        self.axes |= axes
        return part is not None
