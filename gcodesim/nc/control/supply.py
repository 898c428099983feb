"""What the control knows before a program starts: offsets, tools, reference points, readings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from gcodesim.nc.control.readings import Readings
from gcodesim.nc.program import ZERO, Floats, Vector


class WorkOffsetLike(Protocol):
    """A work offset: X Y Z A B C [mm, deg] and the XY rotation [deg]."""

    @property
    def value(self) -> Vector:
        """Offset of the work frame in the machine frame."""

    @property
    def rotation(self) -> float:
        """Rotation of X and Y about Z [deg]."""


class Kinematics(Protocol):
    """Where a machine with rotary joints holds the tip of its tool and where its tool points.

    All arrays batch: axes (n, 6) X Y Z [mm] A B C [deg], rotary (n, 3) A B C [deg], tips and
    offsets of tools (n, 3) [mm]. Tips are counted as in Frame.WORK. Every method may raise
    OrientationError.
    """

    def tips(self, axes: Floats, offset: Floats) -> Floats:
        """Tips of the tool (n, 3) at axis positions."""

    def axes_at(self, tips: Floats, rotary: Floats, offset: Floats) -> Floats:
        """Axis positions (n, 6) that hold the tips, with the rotary axes as given."""

    def directions(self, rotary: Floats) -> Floats:
        """Tool axes (n, 3), from the tip towards the spindle, as seen from the part."""

    def axis_directions(self, vectors: Floats, rotary: Floats) -> Floats:
        """How X Y Z move (n, 3) while the tip moves by vectors (n, 3) as seen from the part."""

    def rotary_at(self, direction: Floats, previous: Floats, prefer: int = 0) -> Floats:
        """Rotary positions (3,) for a direction of the tool; prefer: sign of the tilting joint."""

    def carried(self, points: Floats, rotary: Floats) -> Floats:
        """Where the work link has carried points (n, 3) that stood so at rotary zero."""


@dataclass(frozen=True)
class WorkOffset:
    """A work offset of one's own, for callers without a machine."""

    value: Vector = ZERO
    rotation: float = 0.0


@dataclass(frozen=True)
class ToolEntry:
    """A row of the control's tool table: offset [mm, deg] and diameter [mm]."""

    number: int
    offset: Vector
    diameter: float
    name: str = ""


def _machine_zero() -> dict[str, dict[str, float]]:
    return {code: dict.fromkeys("XYZABC", 0.0) for code in ("G28", "G30")}


@dataclass(frozen=True)
class Control:
    """Everything a program may refer to without defining it.

    Attributes:
        readings: how it reads what the standard leaves open.
        axes: letters the machine has, out of XYZABC.
        standing: names of axes of the machine that no word moves.
        start: axis letter -> machine position at program start [mm, deg]; left out = 0.
        tools: tool table; None = no table was supplied.
        tool_for_all: the mounted tool is used for every T number.
        mounted_length: length of the mounted tool [mm], the offset of G43 without a table.
        offsets: 1 = G54 .. 9 = G59.3, 101.. = G54.1 P1..; G54 is zero when left out.
        reference: "G28" and "G30" -> axis letter -> machine position [mm, deg].
        wrap: rotary axis letter -> none | shortest | sign, see wrap.unwound; left out = none.
        travel: axis letter -> lower and upper machine limit [mm, deg]; left out = none.
        retract: axis letter -> machine position it is retracted to before a swivel [mm, deg].
        variables: what the control's memory holds by number of the variable; others: not known.
        feed: feed until the first F word [mm/min]; None = a feed move before it is an error.
        unit: of lengths until the program names one, where no reading does: mm | inch; None =
            nothing gives it, and mm is taken.
        given: readings that hold under every dialect, where the text tells the dialect; None =
            the dialect is that of `readings`.
        dialect_told: how the text told the dialect; empty where it was known.
        block_delete: blocks that begin with / are left out.
        kinematics: None = no machine is known, or it has no rotary joints.
        main_program: O-number or <NAME> of the program of the file that runs; empty = the first.
        max_blocks: interpretation ends after this many blocks; None = after MAX_BLOCKS, or after
            MAX_REPEATED_BLOCKS more than all texts have lines.
    """

    readings: Readings
    axes: str = "XYZABC"
    standing: tuple[str, ...] = ()
    start: Mapping[str, float] = field(default_factory=dict)
    tools: Mapping[int, ToolEntry] | None = None
    tool_for_all: bool = False
    mounted_length: float = 0.0
    offsets: Mapping[int, WorkOffsetLike] = field(default_factory=dict)
    reference: Mapping[str, Mapping[str, float]] = field(default_factory=_machine_zero)
    wrap: Mapping[str, str] = field(default_factory=dict)
    travel: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    retract: Mapping[str, float] = field(default_factory=dict)
    variables: Mapping[int, float] = field(default_factory=dict)
    feed: float | None = None
    unit: str | None = None
    given: Mapping[str, Any] | None = None
    dialect_told: str = ""
    block_delete: bool = False
    kinematics: Kinematics | None = None
    max_blocks: int | None = None
    main_program: str = ""
