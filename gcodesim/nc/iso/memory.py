"""What a control of ISO programs knows between two blocks, besides what every control knows."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from gcodesim.nc.control.frames import WORK, Level, Matrix, mirrored_at, rotation, turned_about
from gcodesim.nc.control.modal import CutterSide, TipControl
from gcodesim.nc.control.place import Place
from gcodesim.nc.control.state import State
from gcodesim.nc.control.supply import Control, WorkOffsetLike
from gcodesim.nc.iso.g_codes import Codes, G
from gcodesim.nc.iso.requests import Request
from gcodesim.nc.program import ZERO, Kind

LOCAL, PLANE, ROTATION, MIRROR = "local", "plane", "rotation", "mirror"

FRAME_LEVELS = (WORK, LOCAL, PLANE, ROTATION, MIRROR)
"""G54 .. G59, G52 and G92, G68.2, G68, G51.1: m = offset + local + (plane rotation mirror) p."""


@dataclass(frozen=True, slots=True)
class SavedModes:
    """Modes that were laid aside.

    Attributes:
        modal, codes: values of saved_modes.MODES and CODES, in their order.
        side: of cutter radius compensation.
        offset: code of the work offset, in tenths, and its number.
        length: code of the tool length, in tenths, and the tool offset.
        path: code and tolerance of path control, None before the first.
        tips: tool centre point control.
        returns: they are put back when the call returns (M73).
    """

    modal: tuple[object, ...]
    codes: tuple[object, ...]
    side: CutterSide
    offset: tuple[int, int]
    length: tuple[int, list[float]]
    path: tuple[int, float] | None
    tips: TipControl
    returns: bool


class IsoState(State):
    """What a block finds and leaves behind.

    Attributes:
        codes: modal codes that only this language knows.
        work: the work offset in force.
        g92: offset of G92 or G52 in force; g92_kept: what G92.2 laid aside for G92.3.
        external: what is added to every work offset [mm, deg].
        mirrors: axis index -> coordinate of the mirror plane [mm].
        is_length_cancelled: the length axis has stood at the reference point or in machine
            coordinates since the tool length came into force; some controls cancel it there.
        length_of_new_tool: length of the tool that was put in under another tool's length, until
            the program gives one [mm]; some controls take it; None = there is none.
        saved: what M70 or M73 has laid aside, in the main program and in each running call.
        request: what the block asks of the program flow, carried out after it.
        stop_request: number and value of a system parameter that stops the program.
    """

    def __init__(self, control: Control) -> None:
        super().__init__(control, FRAME_LEVELS)
        to_start = control.readings.cycle_return == "G98"
        self.codes = Codes(cycle_return=G.RETURN_TO_START if to_start else G.RETURN_TO_R)
        self.g92: list[float] = list(ZERO)
        self.g92_kept: list[float] = list(ZERO)
        self.external: list[float] = list(ZERO)
        self.mirrors: dict[int, float] = {}
        self.is_length_cancelled = False
        self.length_of_new_tool: float | None = None
        self.saved: list[SavedModes | None] = [None]
        self.request: Request | None = None
        self.stop_request: tuple[int, float] | None = None
        self.work = self.first_offset()
        self.frames.levels[WORK] = level_of(self.work.value, self.work.rotation)
        self.frames.update()
        self.point = self.frames.program(self.position)

    def seen(self) -> tuple[object, ...]:
        """Return all that decides what the same lines do when they run again."""
        return (
            *(*super().seen(), self.codes, self.work, self.g92, self.g92_kept, self.external),
            *(self.mirrors, self.is_length_cancelled, self.length_of_new_tool, self.saved),
        )

    def set_work(self, offset: WorkOffsetLike) -> None:
        """Put a work offset into force; the caller records it."""
        self.work = offset
        self.set_frame(WORK, level_of(offset.value, offset.rotation))

    def set_g92(self, value: list[float]) -> None:
        """Put an offset of G92 or G52 into force, and record it."""
        self.g92 = value
        self.set_frame(LOCAL, Level(value))
        self.emit(Kind.G92, value)

    def set_mirrors(self, planes: dict[int, float]) -> None:
        """Mirror program points at these coordinates, and at no others."""
        self.mirrors = planes
        self.set_frame(MIRROR, mirrored_at(planes) if planes else Level())

    def set_rotation(self, centre: Sequence[float], normal: int, angle: float) -> None:
        """Turn program points about a centre X Y Z [mm] by an angle [deg]."""
        self.set_frame(ROTATION, turned_about(centre, rotation(normal, angle)))

    @property
    def is_length_doubtful(self) -> bool:
        """Controls differ in which tool length the next Z word counts with."""
        return self.is_length_cancelled or self.length_of_new_tool is not None

    @property
    def is_rotated(self) -> bool:
        """G68 is in force."""
        return self.frames.levels[ROTATION].turn is not None

    def begin(self, file: str) -> None:
        """Record what is in force before the first block."""
        self.place = Place(file, 0, "")
        self.emit(Kind.G5X, self.work.value, aux=1)
        self.emit(Kind.G92, self.g92)


def level_of(offset: Sequence[float], degrees: float) -> Level:
    """Return the level of a work offset, and of its rotation of X and Y about Z [deg]."""
    angle = math.radians(degrees)
    cos, sin = math.cos(angle), math.sin(angle)
    turn: Matrix = ((cos, -sin, 0.0), (sin, cos, 0.0), (0.0, 0.0, 1.0))
    return Level(offset, turn if sin else None)
