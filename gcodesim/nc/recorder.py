"""Collects canonical commands one by one and turns them into columns once."""

from __future__ import annotations

from array import array
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gcodesim.nc.program import (
    ARC_DTYPE,
    ZERO,
    CanonicalProgram,
    FeedMode,
    Frame,
    Kind,
    StockCorners,
    Turning,
)

ArcRow = tuple[tuple[float, ...], tuple[float, ...], int]


class Recorder:
    """Grows the columns of a CanonicalProgram."""

    def __init__(self) -> None:
        self._kind, self._line, self._aux = array("B"), array("i"), array("i")
        self._to, self._f = array("d"), array("d")
        self._mode, self._speed = array("B"), array("f")
        self._arcs, self._turns = array("d"), array("i")
        self._texts: list[str] = []
        self._switches: list[tuple[int, int]] = [(0, Frame.MACHINE)]
        self._spindle: list[tuple[int, int]] = [(0, Turning.STANDS)]
        self._touching: list[int] = []
        self._stock: StockCorners | None = None

    def __len__(self) -> int:
        return len(self._kind)

    def add(
        self,
        kind: int,
        line: int,
        to: Sequence[float] = ZERO,
        *,
        f: float = 0.0,
        mode: int = FeedMode.PER_MINUTE,
        speed: float = 0.0,
        aux: int = 0,
    ) -> None:
        """Append one command; arguments are the columns of CanonicalProgram."""
        self._kind.append(kind)
        self._line.append(line)
        self._to.extend(to)
        self._f.append(f)
        self._mode.append(mode)
        self._speed.append(speed)
        self._aux.append(aux)

    def extend(
        self,
        kind: NDArray[np.uint8],
        line: NDArray[np.int64],
        to: NDArray[np.float64],
        f: NDArray[np.float64],
        aux: NDArray[np.int64],
        *,
        mode: int | NDArray[np.uint8],
        speed: float | NDArray[np.float32],
    ) -> None:
        """Append many commands; mode and speed may be the same for all."""
        count = len(kind)
        self._kind.frombytes(kind.tobytes())
        self._line.frombytes(line.astype(np.int32).tobytes())
        self._to.frombytes(to.tobytes())
        self._f.frombytes(f.tobytes())
        self._mode.frombytes(np.broadcast_to(np.uint8(mode), count).tobytes())
        self._speed.frombytes(np.broadcast_to(np.float32(speed), count).tobytes())
        self._aux.frombytes(aux.astype(np.int32).tobytes())

    def switch(self, frame: int) -> None:
        """Count what follows in another frame."""
        if frame != self._switches[-1][1]:
            self._switches.append((len(self), frame))

    @property
    def frame(self) -> int:
        """What moves are counted in now."""
        return self._switches[-1][1]

    def may_touch(self) -> None:
        """Let the next move be one in which the flute may touch: a skip move, or its way back."""
        self._touching.append(len(self))

    @property
    def turning(self) -> int:
        """What is known of the spindle now."""
        return self._spindle[-1][1]

    def turn(self, turning: int) -> None:
        """Let what follows run with the spindle in another state."""
        if turning != self.turning:
            self._spindle.append((len(self), turning))

    def add_arc_row(self, row: ArcRow) -> int:
        """Append centre, normal and turns of an arc and return the row's number for `aux`."""
        centre, normal, turns = row
        self._arcs.extend(centre)
        self._arcs.extend(normal)
        self._turns.append(turns)
        return len(self._turns) - 1

    def extend_arcs(
        self, centre: NDArray[np.float64], normal: Sequence[float], turns: NDArray[np.int64]
    ) -> int:
        """Append many arcs of one normal; return the number of the first row."""
        first, rows = len(self._turns), np.zeros((len(turns), 6))
        rows[:, :3], rows[:, 3:] = centre, normal
        self._arcs.frombytes(rows.tobytes())
        self._turns.frombytes(turns.astype(np.int32).tobytes())
        return first

    def message(self, line: int, text: str) -> None:
        """Append a message."""
        self._texts.append(text)
        self.add(Kind.MESSAGE, line, aux=len(self._texts) - 1)

    def set_stock(self, corners: StockCorners) -> None:
        """Keep the stock; a later one replaces it."""
        self._stock = corners

    def truncate(self, count: int) -> None:
        """Take back every command after the first `count`: their block was refused."""
        for column in (self._kind, self._line, self._f, self._mode, self._speed, self._aux):
            del column[count:]
        del self._to[6 * count :]
        while self._touching and self._touching[-1] >= count:
            self._touching.pop()

    def program(self, start: list[float]) -> CanonicalProgram:
        """Return the columns; `start` is the machine position before the first command."""
        # The columns are handed over and not copied: a program may fill half the memory.
        return CanonicalProgram(
            kind=np.frombuffer(self._kind, np.uint8),
            line=np.frombuffer(self._line, np.int32),
            frame=self._spread(self._switches),
            to=np.frombuffer(self._to, np.float64).reshape(-1, 6),
            f=np.frombuffer(self._f, np.float64),
            feed_mode=np.frombuffer(self._mode, np.uint8),
            speed=np.frombuffer(self._speed, np.float32),
            aux=np.frombuffer(self._aux, np.int32),
            arcs=self._arc_rows(),
            start=np.array(start, np.float64),
            texts=self._texts,
            stock=self._stock,
            turning=self._spread(self._spindle),
            touching=np.array(self._touching, np.int64),
        )

    def _arc_rows(self) -> NDArray[np.void]:
        rows = np.zeros(len(self._turns), ARC_DTYPE)
        values = np.frombuffer(self._arcs, np.float64).reshape(-1, 6)
        rows["center"], rows["normal"] = values[:, :3], values[:, 3:]
        rows["turns"] = np.frombuffer(self._turns, np.int32)
        return rows

    def _spread(self, switches: list[tuple[int, int]]) -> NDArray[np.uint8]:
        """Return what is in force at every command; switches after the last one do not count."""
        rows, values = zip(*switches, strict=True)
        bounds = np.minimum([*rows, len(self)], len(self))
        return np.repeat(np.array(values, np.uint8), np.diff(bounds))
