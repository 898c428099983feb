"""The machine as data: a tree of links and joints, the bodies they carry, and the checked pairs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import STOCK_INSET_MM
from gcodesim.findings.codes import Finding
from gcodesim.nc.control.readings import Readings, choose_readings


@dataclass(frozen=True)
class Servo:
    """How a drive follows its command: first or second order; see motion/servo.py.

    Attributes:
        order: 1 | 2.
        time_constant: [s]; order 2: 1 / (2 pi frequency).
        damping: damping ratio of order 2.
    """

    order: int
    time_constant: float
    damping: float = 1.0


@dataclass(frozen=True)
class Joint:
    """A moving pair of the mechanism; its name is the programmed axis letter.

    Attributes:
        axis: unit vector in which the child link physically moves or turns when the command grows,
            world coordinates at the zero pose, shape (3,).
        point: a point on a rotary axis [mm], world coordinates at the zero pose, shape (3,).
        lower, upper: travel [mm or deg]; -inf and inf when unlimited.
        rapid: rapid rate [mm/s or deg/s].
        max_acceleration: [mm/s^2 or deg/s^2], None when not given.
        max_jerk: [mm/s^3 or deg/s^3], None when not given.
        servo: lag of the drive, None when it follows at once.
        wrap: reading of rotary words: none | shortest | sign.
    """

    name: str
    rotary: bool
    parent: str
    child: str
    axis: NDArray[np.float64]
    point: NDArray[np.float64]
    lower: float
    upper: float
    rapid: float
    max_acceleration: float | None = None
    wrap: str = "none"
    max_jerk: float | None = None
    servo: Servo | None = None


@dataclass(frozen=True)
class Turned:
    """A solid of revolution as two outlines of points (r, z) [mm], z upwards.

    Attributes:
        outer: nowhere inside the true shape, which collisions need.
        inner: nowhere outside it, which cutting needs.
        ball: centre height and radius of the full ball at its tip, None where there is none.
    """

    outer: tuple[tuple[float, float], ...]
    inner: tuple[tuple[float, float], ...]
    ball: tuple[float, float] | None = None

    def moved(self, shift: float) -> Turned:
        """The same, higher by `shift` [mm]."""
        outer, inner = (tuple((r, z + shift) for r, z in ps) for ps in (self.outer, self.inner))
        ball = (self.ball[0] + shift, self.ball[1]) if self.ball else None
        return Turned(outer, inner, ball)


@dataclass(frozen=True, eq=False)
class Part:
    """One closed shape of a body, equal to itself only: what is made of it can be kept for it.

    Attributes:
        name: unique within its body (flute, shank, holder; table, cradle, ...).
        triangles: (n, 3, 3) float64 [mm], world coordinates at the zero pose, outward oriented.
        closed: the mesh is watertight, so inside and outside are defined.
        role: machine | flute | shank | holder | fixture | part | stock.
        source: file or primitive it was made from.
        shell: only its surface is checked: nothing can be inside.
        turned: its outlines where a part of a tool is turned, from the gauge point along the axis
            of the tool, upwards to the spindle; None: a mesh.
    """

    name: str
    triangles: NDArray[np.float64]
    closed: bool = True
    role: str = "machine"
    source: str = ""
    shell: bool = False
    turned: Turned | None = None


@dataclass(frozen=True)
class Body:
    """What moves with one link: the link's own shape, a mounted tool, or a fixture of the setup."""

    name: str
    link: str
    parts: tuple[Part, ...]


@dataclass(frozen=True)
class Pair:
    """Two bodies that must not touch, in the order in which they are reported.

    Attributes:
        a, b: names of bodies.
        parts_a, parts_b: names of the parts that count; None = all.
        clearance: distance that must stay free [mm].
        severity: severity of a finding about the clearance: warning | error.
    """

    a: str
    b: str
    parts_a: tuple[str, ...] | None = None
    parts_b: tuple[str, ...] | None = None
    clearance: float = 0.0
    severity: str = "warning"

    @property
    def name(self) -> str:
        """The pair as people write it: ``cutter-C``."""
        return f"{self.a}-{self.b}"


@dataclass(frozen=True)
class Tool:
    """A tool of the tools file.

    Attributes:
        length: gauge point to tip [mm].
        offset: length and axis offsets as the control's table holds them, shape (6,): mm and deg.
        diameter: [mm].
        type: what its numbers meant, as in a tools file: mill, ball, drill, probe, ...
        parts: flute, shank, holder with the gauge point at the origin, tool axis +Z from the tip
            towards the spindle; empty when the file gives no shape.
        unchecked: names of parts the file gives no shape for ("holder").
    """

    number: int
    name: str
    length: float
    diameter: float
    offset: tuple[float, float, float, float, float, float]
    parts: tuple[Part, ...] = ()
    unchecked: tuple[str, ...] = ()
    type: str = "mill"


@dataclass(frozen=True)
class ToolMount:
    """Where tools are carried.

    Attributes:
        name: body name that stands for whatever tool is mounted ("cutter").
        link: link that carries it.
        gauge_point: spindle face centre [mm], world coordinates at the zero pose, shape (3,).
        axis: unit vector from the tip towards the spindle, shape (3,).
        mounted: parts of the tool mounted at the start, world coordinates; empty = none.
        length: length of the mounted tool [mm], 0 when none.
        for_all: the mounted tool stands for every T number.
        flute: where the flute of a mounted tool of one shape ends, from the tip [mm]; 0: unknown.
    """

    name: str
    link: str
    gauge_point: NDArray[np.float64]
    axis: NDArray[np.float64]
    mounted: tuple[Part, ...] = ()
    length: float = 0.0
    for_all: bool = False
    flute: float = 0.0

    @property
    def one_shape(self) -> Part | None:
        """The shape that is flute, shank and holder of the mounted tool at once, if any."""
        whole = self.mounted[0] if len(self.mounted) == 1 else None
        return whole if whole and whole.name == self.name and whole.role == "flute" else None


@dataclass(frozen=True)
class ZeroPoint:
    """A work offset: X Y Z A B C [mm, deg] and the XY rotation [deg]."""

    value: tuple[float, float, float, float, float, float] = (0.0,) * 6
    rotation: float = 0.0


@dataclass(frozen=True)
class Machine:
    """A machine, its setup and its tools, ready to be checked.

    Attributes:
        links: names, parents before children; the first is the root, others without a joint stand
            fixed.
        joints: parents before children. No link is the child of two joints.
        bodies: by name; every link with a shape has one of the same name, setup bodies follow.
        tool: the tool mount, None for a machine without one.
        tools: tool table by number; None when no tools file was supplied.
        pairs: the pairs to check, in alphabetical order (casefolded); index = tie order.
        cutting: pairs of the flute with part and stock, which may touch while it cuts.
        allowed: pairs excused, with the reason.
        unchecked_by_rule: lines for the report: what is not checked by rule, and why.
        offsets: work offsets by number (1 = G54 ... 9 = G59.3; 101.. = G54.1 P1..).
        reference: "G28" and "G30" -> axis letter -> machine position.
        start: axis letter -> machine position at program start.
        variables: number -> value: what the control's memory holds before the program.
        readings: how its control reads programs.
        given: those of them that the machine file gives; they hold under every dialect.
        is_dialect_told: the file says `dialect: auto`: the text of each program tells its dialect.
        unit: of lengths in its files, mm | inch | m, None where the machine file leaves it out.
        path_tolerance: "G64" and "rapid" -> distance from the path [mm], None: unknown.
        time: how speeds change: constant | acceleration | jerk; see motion/profiles.py.
        stock_inset: nothing may be deeper in the stock of its moment than this [mm].
        findings: GC5xx about the model.
    """

    name: str
    path: str
    verified: bool
    links: tuple[str, ...]
    joints: tuple[Joint, ...]
    bodies: Mapping[str, Body]
    pairs: tuple[Pair, ...]
    tool: ToolMount | None
    tools: Mapping[int, Tool] | None
    work_link: str | None
    offsets: Mapping[int, ZeroPoint]
    reference: Mapping[str, Mapping[str, float]]
    start: Mapping[str, float]
    readings: Readings
    variables: Mapping[int, float] = field(default_factory=dict)
    given: Mapping[str, Any] = field(default_factory=dict)
    is_dialect_told: bool = False
    unit: str | None = None
    path_tolerance: Mapping[str, float | None] = field(default_factory=dict)
    time: str = "constant"
    cutting: tuple[Pair, ...] = ()
    allowed: tuple[tuple[str, str, str], ...] = ()
    unchecked_by_rule: tuple[str, ...] = ()
    stock_inset: float = STOCK_INSET_MM
    findings: tuple[Finding, ...] = ()

    @property
    def axes(self) -> tuple[str, ...]:
        """Axis letters, in joint order."""
        return tuple(joint.name for joint in self.joints)

    @property
    def has_stock(self) -> bool:
        """Something on it is there to be cut away."""
        return any(p.role == "stock" for body in self.bodies.values() for p in body.parts)

    def with_readings(self, **keys: Any) -> Machine:
        """The machine as if its file gave these readings; None: as it is."""
        given = {**self.given, **{name: value for name, value in keys.items() if value is not None}}
        readings = choose_readings(self.readings.dialect, given)
        return replace(self, given=given, readings=readings)
