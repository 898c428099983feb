"""From program points to positions: work offset, rotation, tilted plane, G92 and tool offset."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from gcodesim.nc.control.supply import ZERO

Matrix = tuple[tuple[float, float, float], ...]
"""Three rows of a matrix for X Y Z."""

UNIT: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True, slots=True)
class Placement:
    """A turn and a shift [mm]: x -> turn x + shift."""

    turn: Matrix
    shift: list[float]


@dataclass(slots=True)
class Frames:
    """The offsets in force: m = Rz(rotation) (M p + o + g92) + g5x + tool (nc-language section 5).

    M p + o is the mirror (G51.1), the plane rotation (G68) or the tilted plane (G68.2) of the
    program, else p itself. Tips (Frame.WORK) go without the tool's X Y Z, and from where the work
    link stands when program axes are the machine's back to rotary zero. All vectors are X Y Z
    [mm], A B C [deg]; call `update` after a change of any field.

    Attributes:
        g5x, rotation: active work offset, and its rotation of X and Y about Z [deg].
        g92: offset in force; g92_kept: what G92.2 laid aside for G92.3.
        tool: tool offset.
        mirror: axis index -> coordinate of the mirror plane [mm].
        turn_about: centre [mm], normal axis index and angle [deg] of G68, None when off.
        tilt: axes and origin of the tilted plane in the work offset, None when off.
        carried: X Y Z of g5x where the table has carried it (G254), None when off.
        tips: points are tips of the tool.
        work: how far the work link has moved when program axes are the machine's; None = not.
    """

    g5x: list[float] = field(default_factory=lambda: list(ZERO))
    rotation: float = 0.0
    g92: list[float] = field(default_factory=lambda: list(ZERO))
    g92_kept: list[float] = field(default_factory=lambda: list(ZERO))
    tool: list[float] = field(default_factory=lambda: list(ZERO))
    mirror: dict[int, float] = field(default_factory=dict)
    turn_about: tuple[list[float], int, float] | None = None
    tilt: Placement | None = None
    carried: list[float] | None = None
    tips: bool = False
    work: Placement | None = None
    _shift: list[float] = field(default_factory=lambda: list(ZERO))
    _cos: float = 1.0
    _sin: float = 0.0
    _matrix: Matrix | None = None

    @property
    def is_plain(self) -> bool:
        """At most X and Y are turned about Z, and nothing is mirrored."""
        return self._matrix is None

    @property
    def matrix(self) -> Matrix | None:
        """What turns points where the frame is not plain."""
        return self._matrix

    @property
    def shift(self) -> tuple[list[float], float, float]:
        """What a plain frame adds, and cosine and sine of its turn."""
        return self._shift, self._cos, self._sin

    def update(self) -> None:
        """Work out the one sum and the one rotation that a point needs."""
        angle = math.radians(self.rotation)
        self._cos, self._sin = math.cos(angle), math.sin(angle)
        turned = about_z(self._cos, self._sin, self.g92)
        self._matrix = None
        if self.mirror or self.turn_about or self.tilt:
            matrix, origin = self._transform()
            self._matrix = product(self._about_z(), matrix)
            moved = about_z(self._cos, self._sin, [*origin, 0.0, 0.0, 0.0])
            turned = [a + b for a, b in zip(turned, moved, strict=True)]
        offset = self.g5x if self.carried is None else [*self.carried, *self.g5x[3:]]
        tool = [0.0, 0.0, 0.0, *self.tool[3:]] if self.tips else self.tool
        if self.work is not None:
            turned, offset = self._back_to_zero(turned, offset), list(ZERO)
        self._shift = [t + g + n for t, g, n in zip(turned, offset, tool, strict=True)]

    def _about_z(self) -> Matrix:
        return ((self._cos, -self._sin, 0.0), (self._sin, self._cos, 0.0), UNIT[2])

    def _back_to_zero(self, turned: list[float], offset: list[float]) -> list[float]:
        """Take back what the work link has moved: in the matrix, and in the sum of shifts."""
        assert self.work is not None
        back = transposed(self.work.turn)
        matrix = self._about_z() if self._matrix is None else self._matrix
        self._matrix = product(back, matrix)
        total = [t + g for t, g in zip(turned, offset, strict=True)]
        arm = [m - s for m, s in zip(total[:3], self.work.shift, strict=True)]
        return [*apply(back, arm), *total[3:]]

    def _transform(self) -> tuple[Matrix, list[float]]:
        """Return M and o of mirror and plane rotation."""
        signs = [-1.0 if i in self.mirror else 1.0 for i in range(3)]
        origin = [2.0 * self.mirror.get(i, 0.0) for i in range(3)]
        matrix: Matrix = tuple(
            (signs[i] * row[0], signs[i] * row[1], signs[i] * row[2]) for i, row in enumerate(UNIT)
        )
        if self.turn_about is not None:
            centre, normal, angle = self.turn_about
            turn = rotation(normal, angle)
            arm = apply(turn, [o - c for o, c in zip(origin, centre, strict=True)])
            matrix = product(turn, matrix)
            origin = [a + c for a, c in zip(arm, centre, strict=True)]
        if self.tilt is not None:
            matrix = product(self.tilt.turn, matrix)
            arm = apply(self.tilt.turn, origin)
            origin = [a + o for a, o in zip(arm, self.tilt.shift, strict=True)]
        return matrix, origin

    def inside(self, vector: list[float]) -> list[float]:
        """Return a direction of the program frame in directions of the work offset."""
        return [*apply(self._transform()[0], vector[:3]), *vector[3:]]

    @property
    def outer(self) -> Matrix:
        """Directions of the work offset in those of the machine, or of the tips."""
        rows = self._about_z()
        return rows if self.work is None else product(transposed(self.work.turn), rows)

    def turn(self, vector: list[float]) -> list[float]:
        """Return a direction of the program frame in directions of the machine frame."""
        if self._matrix is not None:
            return [*apply(self._matrix, vector[:3]), *vector[3:]]
        return about_z(self._cos, self._sin, vector)

    @property
    def mirrored(self) -> bool:
        """An odd number of axes is mirrored: arcs turn the other way round."""
        return len(self.mirror) % 2 == 1

    def machine(self, point: list[float]) -> list[float]:
        """Return the machine position of a program point."""
        x, y, z, a, b, c = point
        dx, dy, dz, da, db, dc = self._shift
        if self._matrix is not None:
            x, y, z = apply(self._matrix, point[:3])
        elif self._sin:
            x, y = self._cos * x - self._sin * y, self._sin * x + self._cos * y
        return [x + dx, y + dy, z + dz, a + da, b + db, c + dc]

    def program(self, position: list[float]) -> list[float]:
        """Return the program point of a machine position."""
        x, y, *rest = (m - s for m, s in zip(position, self._shift, strict=True))
        if self._matrix is not None:
            # The matrix is orthogonal, so its transpose takes back what it did.
            return [*apply(transposed(self._matrix), [x, y, rest[0]]), *rest[1:]]
        return [self._cos * x + self._sin * y, self._cos * y - self._sin * x, *rest]


def about_z(cos: float, sin: float, vector: list[float]) -> list[float]:
    """Return a vector turned about Z by the angle with this cosine and sine."""
    x, y, *rest = vector
    return [cos * x - sin * y, sin * x + cos * y, *rest]


def rotation(normal: int, degrees: float) -> Matrix:
    """Return the rotation about axis `normal`, counter-clockwise seen from its positive end."""
    cos, sin = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    if degrees % 90.0 == 0.0:
        cos, sin = round(cos), round(sin)
    u, v = (normal + 1) % 3, (normal + 2) % 3
    rows = [list(row) for row in UNIT]
    rows[u][u] = rows[v][v] = float(cos)
    rows[v][u] = float(sin)
    rows[u][v] = -float(sin)
    return tuple((row[0], row[1], row[2]) for row in rows)


def transposed(matrix: Matrix) -> Matrix:
    """Return rows as columns: the inverse of a rotation."""
    return tuple(zip(*matrix, strict=True))


def apply(matrix: Matrix, vector: list[float]) -> list[float]:
    """Return the matrix times a vector of three."""
    x, y, z = vector
    return [a * x + b * y + c * z for a, b, c in matrix]


def product(left: Matrix, right: Matrix) -> Matrix:
    """Return what turns by `right`, then by `left`."""
    columns = [apply(left, list(column)) for column in zip(*right, strict=True)]
    return tuple((columns[0][i], columns[1][i], columns[2][i]) for i in range(3))
