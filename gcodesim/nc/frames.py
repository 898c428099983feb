"""From program points to machine positions: work offset, rotation, G92 and tool offset."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from gcodesim.nc.control import ZERO


@dataclass(slots=True)
class Frames:
    """The offsets in force: m = Rz(rotation) (p + g92) + g5x + tool (nc-language section 5).

    All vectors are X Y Z [mm], A B C [deg]; call `update` after a change of any field.

    Attributes:
        g5x, rotation: active work offset, and its rotation of X and Y about Z [deg].
        g92: offset in force; g92_kept: what G92.2 laid aside for G92.3.
        tool: tool offset.
    """

    g5x: list[float] = field(default_factory=lambda: list(ZERO))
    rotation: float = 0.0
    g92: list[float] = field(default_factory=lambda: list(ZERO))
    g92_kept: list[float] = field(default_factory=lambda: list(ZERO))
    tool: list[float] = field(default_factory=lambda: list(ZERO))
    _shift: list[float] = field(default_factory=lambda: list(ZERO))
    _cos: float = 1.0
    _sin: float = 0.0

    def update(self) -> None:
        """Work out the one sum and the one rotation that a point needs."""
        angle = math.radians(self.rotation)
        self._cos, self._sin = math.cos(angle), math.sin(angle)
        turned = self.turn(self.g92)
        self._shift = [t + g + n for t, g, n in zip(turned, self.g5x, self.tool, strict=True)]

    def turn(self, vector: list[float]) -> list[float]:
        """Return a vector of the program frame in directions of the machine frame."""
        x, y, *rest = vector
        return [self._cos * x - self._sin * y, self._sin * x + self._cos * y, *rest]

    def machine(self, point: list[float]) -> list[float]:
        """Return the machine position of a program point."""
        x, y, z, a, b, c = point
        dx, dy, dz, da, db, dc = self._shift
        if self._sin:
            x, y = self._cos * x - self._sin * y, self._sin * x + self._cos * y
        return [x + dx, y + dy, z + dz, a + da, b + db, c + dc]

    def program(self, position: list[float]) -> list[float]:
        """Return the program point of a machine position."""
        x, y, *rest = (m - s for m, s in zip(position, self._shift, strict=True))
        return [self._cos * x + self._sin * y, self._cos * y - self._sin * x, *rest]
