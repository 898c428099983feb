"""What a control knows between two lines: modal state, frames, position, and what it reported."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from gcodesim.findings.codes import Finding
from gcodesim.nc.control.frames import WORK, Frames, Level
from gcodesim.nc.control.modal import Modal, Spindle, TipControl
from gcodesim.nc.control.place import Place, ProgramError
from gcodesim.nc.control.readings import BOTH, ReadingMet, ways_of
from gcodesim.nc.control.skips import Skipped
from gcodesim.nc.control.supply import Control, Kinematics, WorkOffset, WorkOffsetLike
from gcodesim.nc.control.tips import (
    axis_positions,
    carried_point,
    tip_position,
    work_placement,
)
from gcodesim.nc.program import AXES, ZERO, FeedMode, Frame, Kind, Turning
from gcodesim.nc.recorder import Recorder

INCH = 25.4
"""Millimetres per inch, exact by definition."""

LIMIT = 1e12
"""Largest value taken from a program; beyond it float64 cannot hold thousandths of a mm."""


@dataclass(frozen=True, slots=True)
class Edge:
    """What is to become of the corner at the end of a straight move.

    Attributes:
        is_round: an arc is put in, else a chamfer.
        size: radius, or length cut off both moves [mm].
        text: the words as written; at: the letter at fault.
    """

    is_round: bool
    size: float
    text: str = ""
    at: str = ""


@dataclass(frozen=True, slots=True)
class Corner:
    """A corner that waits for the move after it.

    Attributes:
        row: row of the move to the corner; line, f, mode, speed: columns of that move.
        start: program point the move comes from, shape (6,).
        edge: what the corner becomes.
    """

    row: int
    line: int
    f: float
    mode: FeedMode
    speed: float
    start: list[float]
    edge: Edge


class State:
    """What a line finds and leaves behind, whatever the language.

    Attributes:
        place: the line that is carried out.
        point: current position as the program counts it, X Y Z [mm], A B C [deg].
        position: the same as moves are recorded: axis positions, or the tip and the rotary axes.
        frame: which of the two, see program.Frame.
        tcp_rotary: rotary positions at which program axes are those of the machine under tool
            centre point control; None = those of the work offset.
        on_plane: the tool stands square on the tilted plane; None = not checked yet.
        wraps: rotary letters whose words are read modulo 360, and how.
        line_feed: F of the line that is carried out, None without one; counts under inverse time.
        recorder: canonical commands so far.
        ignored: what was dropped or listed as doing nothing -> times.
        unsupported: what was not followed, with its line.
        offsets, tools, reference: tables of the control, as the program has changed them.
        blocks, last_line: lines that count as blocks, and the row of the last; see Language.run.
        met: keys of the readings that are not known and matter here, in the order met.
        is_unit_told: program, or machine file, has said in which unit programs are.
        ended: the program has come to its end.
        corner: a corner that waits for the move after it.
        path: code in tenths and tolerance [mm] of path control, None before the first.
        holes: holes and pecks of cycles so far; they count as blocks where blocks are limited.
        passed: kind of lines that were left out or done in one of two ways -> how many of them,
            and the row of the first.
        clamped_by: code that may have clamped a rotary axis, "" once one has let it go.
        skipped: where the axes may stand after a skip move; None where that is known.
        unfollowed: what is switched on that needs kinematics the machine file lacks -> its code
            and why.
    """

    def __init__(self, control: Control, levels: Iterable[str] = (WORK,)) -> None:
        self.control = control
        self.place = Place("", 0, "")
        unit = control.readings.program_unit
        self.modal = Modal(inch=(unit or control.unit) == "inch")
        self.is_unit_told = unit is not None
        self.frames = Frames(levels)
        self.start = [control.start.get(letter, 0.0) for letter in AXES]
        self.position = list(self.start)
        self.point = list(self.start)
        self.frame = Frame.MACHINE
        self._stood = self.position, self.position
        self.tcp_rotary: list[float] | None = None
        self.on_plane: bool | None = None
        self.wraps = {letter: how for letter, how in control.wrap.items() if how != "none"}
        self.line_feed: float | None = None
        self.recorder = Recorder()
        self.ignored: Counter[str] = Counter()
        self.unsupported: list[str] = []
        self.offsets: dict[int, WorkOffsetLike] = dict(control.offsets)
        self.tools = None if control.tools is None else dict(control.tools)
        self.reference = {code: dict(place) for code, place in control.reference.items()}
        self.corner: Corner | None = None
        self.path: tuple[int, float] | None = None
        self.holes = 0
        self.clamped_by = ""
        self.skipped: Skipped | None = None
        self.unfollowed: dict[str, str] = {}
        self.passed: dict[str, tuple[int, int]] = {}
        self.blocks = self.last_line = 0
        self.met: dict[str, ReadingMet] = {}
        self.ended = False
        self._findings: dict[tuple[str, str], tuple[Finding, int]] = {}

    @property
    def scale(self) -> float:
        """Millimetres per programmed length unit."""
        return INCH if self.modal.inch else 1.0

    def increment(self, *, is_angle: bool) -> float:
        """Return what a number without a decimal point counts, in programmed units."""
        readings = self.control.readings
        if is_angle:
            return readings.increment_deg
        return readings.increment_inch if self.modal.inch else readings.increment_mm

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Findings in the order met; the first of a kind is used for all, with their count."""
        return tuple(
            replace(finding, message=f"{finding.message} ({count} times)") if count > 1 else finding
            for finding, count in self._findings.values()
        )

    def report(self, meaning: str, what: str, at: str | int = "", *, subject: str = "") -> None:
        """Keep a finding about the line; the same about the same subject is only counted.

        Args:
            meaning: key of MEANINGS.
            what: what is wrong.
            at: the word at fault, see Place.column.
            subject: what the finding is about, where there may be several.
        """
        known = self._findings.get((meaning, subject))
        if known is None:
            self._findings[meaning, subject] = self.place.finding(meaning, what, at), 1
        else:
            self._findings[meaning, subject] = known[0], known[1] + 1

    def count_again(self, meaning: str, times: int) -> None:
        """Count a finding without a subject further times."""
        first, count = self._findings[meaning, ""]
        self._findings[meaning, ""] = first, count + times

    def pass_by(self, what: str) -> None:
        """Count a line that the control may also take in another way."""
        count, first = self.passed.get(what, (0, self.place.row))
        self.passed[what] = count + 1, first

    def keep(self, finding: Finding) -> None:
        """Keep a finding that stopped the program."""
        key = (finding.meaning, "")
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
        kinematics, frames = self.control.kinematics, self.frames
        tips = self.modal.tip_control
        self.frame, self.position = Frame.MACHINE, axes
        if kinematics is not None and (tips is not TipControl.OFF or frames.tilted):
            great = self.control.readings.orientation == "great_circle"
            circle = tips is TipControl.VECTORS and great
            self.frame = Frame.GREAT_CIRCLE if circle else Frame.WORK
            self.position = tip_position(kinematics, axes, frames.tool)
        self._stood = self.position, axes
        frames.tips = self.frame is not Frame.MACHINE
        self.on_plane = None
        self.recorder.switch(self.frame)
        self.reframe()

    def set_frame(self, level: str, what: Level) -> None:
        """Let a level of the frames turn and shift points from here on; nothing moves."""
        self.frames.levels[level] = what
        self.reframe()

    def reframe(self) -> None:
        """Count the position anew after a change of frames: they never move the machine."""
        if self.control.kinematics is not None:
            self._place_work(self.control.kinematics)
        self.frames.update()
        self.point = self.frames.program(self.position)

    def _place_work(self, kinematics: Kinematics) -> None:
        """Let the work link stand where the frames need it."""
        frames, modal = self.frames, self.modal
        frames.work = frames.carried = None
        if frames.tips:
            rotary = self.tcp_rotary if modal.tip_control is not TipControl.OFF else None
            rotary = list(frames.levels[WORK].shift[3:]) if rotary is None else rotary
            frames.work = work_placement(kinematics, rotary) if any(rotary) else None
        elif modal.table_offset:
            self.carry_offset(self.position[3:])

    def carry_offset(self, rotary: list[float]) -> None:
        """Let the table carry the work offset to where it stands at rotary positions."""
        assert self.control.kinematics is not None
        shift = list(self.frames.levels[WORK].shift[:3])
        self.frames.carried = carried_point(self.control.kinematics, shift, rotary)

    def reach(self, point: list[float]) -> list[float]:
        """Return the machine position of a program point.

        An axis that is not told to move keeps its very number: noise of 1e-14 mm in X would turn a
        rotary move, whose feed is in deg/min, into a linear one.
        """
        frames, before, held = self.frames, self.point, self.position
        if frames.matrix is None:
            # Written out: a loop over the six takes four times as long, and every move comes here.
            (x, y, z, a, b, c), (x0, y0, z0, a0, b0, c0) = point, before
            (dx, dy, dz, da, db, dc), (mx, my, mz, ma, mb, mc) = frames.shift, held
            return [
                mx if x == x0 else x + dx,
                my if y == y0 else y + dy,
                mz if z == z0 else z + dz,
                ma if a == a0 else a + da,
                mb if b == b0 else b + db,
                mc if c == c0 else c + dc,
            ]
        position = frames.machine(point)
        # Axes that the frame turns into each other are computed together.
        first = frames.joined if point[: frames.joined] != before[: frames.joined] else 0
        for i in range(first, 6):
            if point[i] == before[i]:
                position[i] = held[i]
        return position

    def refusal(self) -> ProgramError:
        """Return the error of a move under what needs kinematics that the machine file lacks."""
        what = next(iter(self.unfollowed.values()))
        self.unsupported.append(f"{what.partition(' ')[0]} line {self.place.line}")
        return self.place.error("unknown_g", what)

    def reading(self, key: str) -> str:
        """Return how a key is read where the program depends on it; the first way if not known."""
        value: str = getattr(self.control.readings, key)
        if value != BOTH:
            return value
        self.meet(key, self.place.row)
        return ways_of(key)[0]

    def meet(self, key: str, row: int, times: int = 1) -> None:
        """Count that the program depends on a key that is not known, first in a row."""
        self.met.setdefault(key, ReadingMet(key, row, 0)).count += times

    def tell(self, axes: Iterable[int]) -> None:
        """Remember that the line gives axes, by their indices, a position of their own."""
        if self.skipped is not None:
            self.skipped.told.update(axes)

    def turn_spindle(self, spindle: Spindle) -> None:
        """Let the spindle turn, or stand, from here on."""
        self.modal.spindle = spindle
        turns = self.modal.spindle_turns
        self.recorder.turn(Turning.MAY_TURN if turns else Turning.STANDS)

    def emit(self, kind: Kind, value: Sequence[float] = ZERO, *, aux: int = 0) -> None:
        """Record a command that is no move."""
        self.recorder.add(kind, self.place.row, value, aux=aux)

    def seen(self) -> tuple[object, ...]:
        """Return all that decides what the same lines do when they run again."""
        frames = self.frames
        return (
            *(self.modal, self._within_a_turn(self.position), self._within_a_turn(self.point)),
            *(self.frame, self.skipped, self.path),
            *(frames.levels, frames.tool, frames.tilted, frames.tips, frames.carried),
            *(self.tcp_rotary, self.on_plane, self.line_feed, self.unfollowed, self.clamped_by),
            *(self.offsets, self.tools, self.reference, self.recorder.turning),
        )

    @property
    def is_outside(self) -> bool:
        """An axis stands outside its travel."""
        travel = self.control.travel
        stands = zip(AXES, self.axes, strict=True)
        return any(not travel[a][0] <= at <= travel[a][1] for a, at in stands if a in travel)

    def _within_a_turn(self, place: list[float]) -> list[float]:
        """Return a position without the full turns of axes whose words are read modulo 360."""
        endless = {letter for letter in self.wraps if math.isinf(self._travel(letter))}
        return [
            round(v % 360.0, 9) if letter in endless else v
            for letter, v in zip(AXES, place, strict=True)
        ]

    def _travel(self, letter: str) -> float:
        """Return how far an axis can turn [deg]."""
        lower, upper = self.control.travel.get(letter, (-math.inf, math.inf))
        return upper - lower

    def first_offset(self) -> WorkOffsetLike:
        """Return the work offset that is in force when a program starts."""
        return self.offsets.get(1, WorkOffset())
