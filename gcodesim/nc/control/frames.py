"""Frames: from program points to positions, through a list of levels and the tool offset."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from gcodesim.nc.program import ZERO

Matrix = tuple[tuple[float, float, float], ...]
"""Three rows of a matrix for X Y Z."""

UNIT: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))

ROUNDING = 1e-12
"""A turn is one whose columns are of length 1 and square to within this."""

WORK = "work"
"""The level of the work offset, which every language has: a table may carry it (G254), and under
tool centre point control the table may stand at its rotary shift."""


@dataclass(frozen=True, slots=True)
class Placement:
    """A turn and a shift [mm]: x -> turn x + shift."""

    turn: Matrix
    shift: list[float]


@dataclass(frozen=True, slots=True)
class Level:
    """What one level does to points: x -> turn x + shift; A B C are only shifted.

    Attributes:
        shift: X Y Z [mm], A B C [deg].
        turn: a rotation or mirror of X Y Z, None for neither.
    """

    shift: Sequence[float] = ZERO
    turn: Matrix | None = None


NOTHING = Level()


class Frames:
    """The frames in force: position = levels(point) + tool offset.

    A point goes through the levels from the last to the first. Tips (Frame.WORK) go without the
    tool's X Y Z, and from where the work link stands when program axes are the machine's back to
    rotary zero. All vectors are X Y Z [mm], A B C [deg]; call `update` after a change.

    Attributes:
        levels: name -> what it does, the outermost first; WORK is one of them.
        tool: tool offset.
        tilted: points lie in a tilted plane, which the tool is to stand square on.
        carried: X Y Z of the work offset where the table has carried it, None when it has not.
        tips: points are tips of the tool.
        work: how far the work link has moved when program axes are the machine's; None = not.
        matrix: what turns points on their way through all levels, None when nothing does.
        shift: what is added to them.
    """

    __slots__ = (
        *("carried", "joined", "levels", "matrix", "mirrored", "shift", "tilted"),
        *("tips", "tool", "work"),
    )

    def __init__(self, names: Iterable[str] = (WORK,)) -> None:
        self.levels = dict.fromkeys(names, NOTHING)
        self.tool: list[float] = list(ZERO)
        self.tilted = self.tips = False
        self.carried: list[float] | None = None
        self.work: Placement | None = None
        self.matrix: Matrix | None = None
        self.shift: list[float] = list(ZERO)
        self.joined, self.mirrored = 0, False

    def update(self) -> None:
        """Work out the one turn and the one sum that a point needs."""
        matrix: Matrix | None = None
        total: Sequence[float] = ZERO
        for name, level in reversed(self.levels.items()):
            turn, shift = level.turn, level.shift
            if turn is not None:
                total = [*apply(turn, total[:3]), *total[3:]]
                matrix = turn if matrix is None else product(turn, matrix)
            if name == WORK and self.carried is not None:
                shift = [*self.carried, *shift[3:]]
            total = [t + s for t, s in zip(total, shift, strict=True)]
        tool = [0.0, 0.0, 0.0, *self.tool[3:]] if self.tips else self.tool
        if self.work is not None:
            back = inverse(self.work.turn)
            matrix = back if matrix is None else product(back, matrix)
            arm = [t - s for t, s in zip(total[:3], self.work.shift, strict=True)]
            total = [*apply(back, arm), *total[3:]]
        self.shift = [t + n for t, n in zip(total, tool, strict=True)]
        self._take(matrix)

    def _take(self, matrix: Matrix | None) -> None:
        """Keep the turn of points, and what it says about axes."""
        self.matrix = None if matrix == UNIT else matrix
        # Axes that the frame turns into each other move together.
        self.joined, self.mirrored = 0, False
        if self.matrix is not None:
            keeps_z = self.matrix[2] == UNIT[2]
            self.joined = 2 if keeps_z and not (self.matrix[0][2] or self.matrix[1][2]) else 3
            self.mirrored = determinant(self.matrix) < 0.0

    def turn_within(self, outer: str) -> Matrix:
        """Return what turns a direction of the program frame into one inside the level `outer`."""
        matrix = UNIT
        for name in reversed(self.levels):
            if name == outer:
                break
            turn = self.levels[name].turn
            matrix = matrix if turn is None else product(turn, matrix)
        return matrix

    def turn_outside(self, inner: str) -> Matrix:
        """Return what turns a direction outside the level `inner` into one of machine or tips."""
        matrix = UNIT if self.work is None else inverse(self.work.turn)
        for name, level in self.levels.items():
            if name == inner:
                break
            matrix = matrix if level.turn is None else product(matrix, level.turn)
        return matrix

    def turn(self, vector: Sequence[float]) -> list[float]:
        """Return a direction X Y Z of the program frame in directions of the machine frame."""
        return list(vector) if self.matrix is None else apply(self.matrix, vector)

    def machine(self, point: list[float]) -> list[float]:
        """Return the machine position of a program point."""
        x, y, z, a, b, c = point
        dx, dy, dz, da, db, dc = self.shift
        if self.matrix is not None:
            x, y, z = apply(self.matrix, point[:3])
        return [x + dx, y + dy, z + dz, a + da, b + db, c + dc]

    def program(self, position: list[float]) -> list[float]:
        """Return the program point of a machine position."""
        arm = [m - s for m, s in zip(position, self.shift, strict=True)]
        if self.matrix is None:
            return arm
        return [*apply(inverse(self.matrix), arm[:3]), *arm[3:]]


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


def turned_about(centre: Sequence[float], turn: Matrix) -> Level:
    """Return the level that turns points about a centre X Y Z [mm]."""
    arm = apply(turn, [-c for c in centre])
    return Level([*(a + c for a, c in zip(arm, centre, strict=True)), 0.0, 0.0, 0.0], turn)


def mirrored_at(planes: dict[int, float]) -> Level:
    """Return the level that mirrors points: axis index -> coordinate of the mirror [mm]."""
    rows = [[-v if i in planes else v for v in row] for i, row in enumerate(UNIT)]
    shift = [2.0 * planes.get(i, 0.0) for i in range(3)]
    return Level([*shift, 0.0, 0.0, 0.0], tuple((row[0], row[1], row[2]) for row in rows))


def transposed(matrix: Matrix) -> Matrix:
    """Return rows as columns: the inverse of a rotation."""
    return tuple(zip(*matrix, strict=True))


def inverse(matrix: Matrix) -> Matrix:
    """Return what takes back a turn; slides that are not square see turns as skew matrices."""
    back = transposed(matrix)
    if all(math.dist(a, b) < ROUNDING for a, b in zip(product(back, matrix), UNIT, strict=True)):
        return back
    (a, b, c), (d, e, f), (g, h, i) = matrix
    whole = determinant(matrix)
    rows = (
        (e * i - f * h, c * h - b * i, b * f - c * e),
        (f * g - d * i, a * i - c * g, c * d - a * f),
        (d * h - e * g, b * g - a * h, a * e - b * d),
    )
    return tuple((x / whole, y / whole, z / whole) for x, y, z in rows)


def determinant(matrix: Matrix) -> float:
    """Return the determinant: 1 for a rotation, -1 where one or three axes are mirrored."""
    (a, b, c), (d, e, f), (g, h, i) = matrix
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


def apply(matrix: Matrix, vector: Sequence[float]) -> list[float]:
    """Return the matrix times a vector of three."""
    x, y, z = vector
    return [a * x + b * y + c * z for a, b, c in matrix]


def product(left: Matrix, right: Matrix) -> Matrix:
    """Return what turns by `right`, then by `left`."""
    columns = [apply(left, list(column)) for column in zip(*right, strict=True)]
    return tuple((columns[0][i], columns[1][i], columns[2][i]) for i in range(3))
