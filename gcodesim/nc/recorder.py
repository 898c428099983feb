"""Collects canonical commands one by one and turns them into columns once."""

from __future__ import annotations

from array import array
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gcodesim.nc.control import ZERO
from gcodesim.nc.program import ARC_DTYPE, CanonicalProgram, Kind

ArcRow = tuple[tuple[float, ...], tuple[float, ...], int]


class Recorder:
    """Grows the columns of a CanonicalProgram."""

    def __init__(self) -> None:
        self._kind, self._line, self._aux = array("B"), array("i"), array("i")
        self._to, self._f = array("d"), array("d")
        self._mode, self._speed = array("B"), array("f")
        self._arcs: list[ArcRow] = []
        self._texts: list[str] = []

    def __len__(self) -> int:
        return len(self._kind)

    def add(
        self,
        kind: int,
        line: int,
        to: Sequence[float] = ZERO,
        *,
        f: float = 0.0,
        mode: int = 94,
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
        *,
        mode: int,
        speed: float,
    ) -> None:
        """Append straight moves; mode and speed are the same for all."""
        count = len(kind)
        self._kind.frombytes(kind.tobytes())
        self._line.frombytes(line.astype(np.int32).tobytes())
        self._to.frombytes(to.tobytes())
        self._f.frombytes(f.tobytes())
        self._mode.frombytes(bytes([mode]) * count)
        self._speed.frombytes(np.full(count, speed, np.float32).tobytes())
        self._aux.frombytes(bytes(4 * count))

    def add_arc_row(self, row: ArcRow) -> int:
        """Append centre, normal and turns of an arc and return the row's number for `aux`."""
        self._arcs.append(row)
        return len(self._arcs) - 1

    def message(self, line: int, text: str) -> None:
        """Append a message."""
        self._texts.append(text)
        self.add(Kind.MESSAGE, line, aux=len(self._texts) - 1)

    def truncate(self, count: int) -> None:
        """Take back every command after the first `count`: their block was refused."""
        for column in (self._kind, self._line, self._f, self._mode, self._speed, self._aux):
            del column[count:]
        del self._to[6 * count :]

    def program(self, start: list[float]) -> CanonicalProgram:
        """Return the columns; `start` is the machine position before the first command."""
        # The columns are handed over and not copied: a program may fill half the memory.
        return CanonicalProgram(
            kind=np.frombuffer(self._kind, np.uint8),
            line=np.frombuffer(self._line, np.int32),
            frame=np.zeros(len(self), np.uint8),
            to=np.frombuffer(self._to, np.float64).reshape(-1, 6),
            f=np.frombuffer(self._f, np.float64),
            feed_mode=np.frombuffer(self._mode, np.uint8),
            speed=np.frombuffer(self._speed, np.float32),
            aux=np.frombuffer(self._aux, np.int32),
            arcs=np.array(self._arcs, ARC_DTYPE),
            start=np.array(start, np.float64),
            texts=self._texts,
        )
