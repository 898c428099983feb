"""Where the control stands between two blocks: modal state, frames, position, and what it said."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from gcodesim.errors import ProgramError
from gcodesim.findings.codes import Finding
from gcodesim.nc.control.frames import Frames
from gcodesim.nc.control.modal import TABLE_OFFSET_OFF, Modal
from gcodesim.nc.control.supply import ZERO, Control, Kinematics, WorkOffset, WorkOffsetLike
from gcodesim.nc.control.tips import axis_positions, carried_point, tip_position, work_placement
from gcodesim.nc.iso.block import Block
from gcodesim.nc.program import AXES, Frame, Kind
from gcodesim.nc.recorder import Recorder

INCH = 25.4
"""Millimetres per inch, exact by definition."""

LIMIT = 1e12
"""Largest value taken from a program; beyond it float64 cannot hold thousandths of a mm."""


class State:
    """What a block finds and leaves behind.

    Attributes:
        point: current position as the program counts it, X Y Z [mm], A B C [deg].
        position: the same as moves are recorded: axis positions, or the tip and the rotary axes.
        frame: which of the two, see program.Frame.
        tcp_rotary: rotary positions at which program axes are those of the machine under tool
            centre point control; None = those of the work offset.
        on_plane: the tool stands square on the tilted plane; None = nobody has looked.
        wraps: rotary letters whose words are read modulo 360, and how.
        recorder: canonical commands so far.
        ignored: what was dropped or listed as doing nothing -> times.
        unsupported: what was not followed, with its line.
        work_offset: number of the active work offset, 1 = G54, 101.. = G54.1 P1..
        offsets, tools, reference: tables of the control, as the program has changed them.
        ended: M2, M30 or the closing % was reached.
        corner: a corner that waits for the block behind it: a corners.Corner, or None.
        holes: holes and pecks of cycles so far; they count as blocks where blocks are limited.
        unfollowed: what is switched on that needs kinematics nobody has given -> its code and why.
        request: what the block asks of the flow: a calls.Request, or None.
        stop_request: number and value of a system parameter that stops the program.
    """

    def __init__(self, control: Control) -> None:
        self.control = control
        self.modal = Modal(
            cycle_return=980 if control.readings.cycle_return == "G98" else 990,
            unit=200 if control.readings.program_unit == "inch" else 210,
        )
        first = control.offsets.get(1, WorkOffset())
        self.frames = Frames(g5x=list(first.value), rotation=first.rotation)
        self.frames.update()
        self.start = [control.start.get(letter, 0.0) for letter in AXES]
        self.position = list(self.start)
        self.point = self.frames.program(self.position)
        self.frame = Frame.MACHINE
        self._stood = self.position, self.position
        self.tcp_rotary: list[float] | None = None
        self.on_plane: bool | None = None
        self.wraps = {letter: how for letter, how in control.wrap.items() if how != "none"}
        self.recorder = Recorder()
        self.ignored: Counter[str] = Counter()
        self.unsupported: list[str] = []
        self.offsets: dict[int, WorkOffsetLike] = dict(control.offsets)
        self.work_offset = 1
        self.tools = None if control.tools is None else dict(control.tools)
        self.reference = {code: dict(place) for code, place in control.reference.items()}
        self.corner: Any = None
        self.holes = 0
        self.unfollowed: dict[str, str] = {}
        self.ended = False
        self.request: Any = None
        self.stop_request: tuple[int, float] | None = None
        self._findings: dict[tuple[str, str], tuple[Finding, int]] = {}

    @property
    def scale(self) -> float:
        """Millimetres per programmed length unit."""
        return INCH if self.modal.unit == 200 else 1.0

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Findings in the order met; the first of a kind stands for all, with their count."""
        return tuple(
            replace(finding, message=f"{finding.message} ({count} times)") if count > 1 else finding
            for finding, count in self._findings.values()
        )

    def report(self, finding: Finding, subject: str = "") -> None:
        """Keep a finding; the same meaning about the same subject is only counted."""
        key = (finding.meaning, subject)
        first, count = self._findings.get(key, (finding, 0))
        self._findings[key] = (first, count + 1)

    def has_reported(self, meaning: str) -> bool:
        """Tell whether a finding with this meaning and no subject was kept."""
        return (meaning, "") in self._findings

    @property
    def axes(self) -> list[float]:
        """Where the axes stand [mm, deg]."""
        return self.axes_of(self.position)

    def axes_of(self, position: list[float]) -> list[float]:
        """Return the axis positions of a position that is counted as moves are recorded."""
        kinematics = self.control.kinematics
        if self.frame is Frame.MACHINE or kinematics is None:
            return position
        if position == self._stood[0]:
            # Switching on and off again changes not even the last bit.
            return self._stood[1]
        return axis_positions(kinematics, position, self.frames.tool)

    def stand(self, axes: list[float]) -> None:
        """Count the axis positions anew, after a change of what moves are counted in."""
        kinematics, modal, frames = self.control.kinematics, self.modal, self.frames
        self.frame, self.position = Frame.MACHINE, axes
        if kinematics is not None and (modal.tcp or frames.tilt is not None):
            circle = modal.tcp == 435 and self.control.readings.orientation == "great_circle"
            self.frame = Frame.GREAT_CIRCLE if circle else Frame.WORK
            self.position = tip_position(kinematics, axes, frames.tool)
        self._stood = self.position, axes
        frames.tips = self.frame is not Frame.MACHINE
        self.on_plane = None
        self.recorder.switch(self.frame)
        self.reframe()

    def reframe(self) -> None:
        """Count the position anew after a change of frames: offsets never move the machine."""
        if self.control.kinematics is not None:
            self._place_work(self.control.kinematics)
        self.frames.update()
        self.point = self.frames.program(self.position)

    def _place_work(self, kinematics: Kinematics) -> None:
        """Let the work link stand where the frames need it."""
        frames, modal = self.frames, self.modal
        frames.work = frames.carried = None
        if frames.tips:
            rotary = self.tcp_rotary if modal.tcp else None
            rotary = frames.g5x[3:] if rotary is None else rotary
            frames.work = work_placement(kinematics, rotary) if any(rotary) else None
        elif modal.table_offset != TABLE_OFFSET_OFF:
            self.carry_offset(self.position[3:])

    def carry_offset(self, rotary: list[float]) -> None:
        """Let the table carry the work offset to where it stands at rotary positions (G254)."""
        assert self.control.kinematics is not None
        frames = self.frames
        frames.carried = carried_point(self.control.kinematics, frames.g5x[:3], rotary)

    def reach(self, point: list[float]) -> list[float]:
        """Return the machine position of a program point.

        An axis that is not told to move keeps its very number: noise of 1e-14 mm in X would turn a
        rotary move, whose feed is in deg/min, into a linear one.
        """
        position = self.frames.machine(point)
        # Axes that the frame turns into each other are computed together.
        joined = 2 if self.frames.is_plain else 3
        turned = not self.frames.is_plain or self.frames.rotation
        turned = turned and point[:joined] != self.point[:joined]
        for i in range(joined if turned else 0, 6):
            if point[i] == self.point[i]:
                position[i] = self.position[i]
        return position

    def refusal(self, block: Block) -> ProgramError:
        """Return the error of a move under what needs kinematics nobody has given."""
        what = next(iter(self.unfollowed.values()))
        self.unsupported.append(f"{what.partition(' ')[0]} line {block.line}")
        return block.error("unknown_g", what)

    def emit(
        self, kind: Kind, block: Block, value: Sequence[float] = ZERO, *, aux: int = 0
    ) -> None:
        """Record a command that is no move."""
        self.recorder.add(kind, block.row, value, aux=aux)
