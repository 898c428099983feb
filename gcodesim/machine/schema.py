"""What machine, tools and setup files may hold: pydantic models, whose descriptions are the manual.

Lengths mm, angles degrees, speeds mm/min and deg/min, accelerations mm/s^2 and deg/s^2,
jerks mm/s^3 and deg/s^3.
"""

from __future__ import annotations

import re
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from gcodesim.constants import LEAST_INSET_MM, STOCK_INSET_MM
from gcodesim.machine.control_keys import CONTROL_KEYS, ControlKeys
from gcodesim.machine.sections import FileNumber, NotNegative, Positive, Section
from gcodesim.nc.control.readings import Dialect

FileName = Annotated[str, Field(pattern=r"^[^\x00-\x1f]+$")]
Natural = Annotated[int, Field(strict=True, ge=1)]
Triple = tuple[FileNumber, FileNumber, FileNumber]
Size = tuple[Positive, Positive, Positive]
Name = Annotated[str, Field(pattern=r"^[A-Za-z0-9_-]+$")]
PartName = Annotated[str, Field(pattern=r"^[A-Za-z0-9_-]+(\.[A-Za-z0-9_-]+)?$")]
Axis = Annotated[str, Field(pattern=r"^[XYZABC]$")]
JointName = Annotated[str, Field(pattern=r"^([XYZABCUVW]|[A-Za-z][A-Za-z0-9_]+)$")]
ProfilePoints = Annotated[list[tuple[FileNumber, FileNumber]], Field(min_length=2)]
Unit = Literal["mm", "inch", "m"]
Position = dict[JointName, FileNumber]
Severity = Literal["warning", "error"]

ORIGIN = (0.0, 0.0, 0.0)
UP = (0.0, 0.0, 1.0)


class PlacementSpec(Section):
    """Where a shape is put: turned about fixed X, then Y, then Z, then shifted."""

    translate: Triple = Field(default=ORIGIN, description="shift [mm]")
    rotate: Triple = Field(
        default=ORIGIN, description="turns about fixed X, Y, Z in this order [deg]"
    )


class BoxSpec(Section):
    """An axis-parallel box."""

    size: Size = Field(description="edge lengths along X, Y, Z [mm]")
    center: Triple = Field(default=ORIGIN, description="middle of the box [mm]")


class CylinderSpec(Section):
    """A cylinder, drawn around: never smaller than the ideal one."""

    radius: Positive = Field(description="[mm]")
    height: Positive = Field(description="[mm]")
    center: Triple = Field(default=ORIGIN, description="middle of the cylinder [mm]")
    axis: Triple = Field(default=UP, description="direction; any length but 0")


class ConeSpec(CylinderSpec):
    """A cone or frustum, drawn around: never smaller than the ideal one."""

    top_radius: NotNegative = Field(
        default=0.0,
        description="radius at the end the axis points to; `radius` is at the other [mm]",
    )


class ExtrudeSpec(Section):
    """A prism over a polygon, standing on z = 0."""

    polygon: Annotated[list[tuple[FileNumber, FileNumber]], Field(min_length=3)] = Field(
        description="corners [x, y] of a simple polygon [mm]"
    )
    height: Positive = Field(description="[mm]")


SHAPE_KEYS = ("mesh", "box", "cylinder", "cone", "revolve", "extrude")


class MeshSpec(Section):
    """A mesh file, its unit, and whether it has an inside."""

    mesh: FileName | None = Field(default=None, description="mesh file, relative to this file")
    units: Literal["mm", "inch", "m"] | None = Field(
        default=None, description="of the mesh file; left out: `units` of the machine file"
    )
    shell: bool | None = Field(
        default=None,
        strict=True,
        description="only the surface of the mesh is checked, it has no inside: an open mesh that "
        "is meant so",
    )

    @model_validator(mode="after")
    def _of_a_mesh(self) -> MeshSpec:
        given = [key for key in ("units", "shell") if getattr(self, key) is not None]
        if given and self.mesh is None:
            text = "{key} belongs to `mesh`: other shapes are in mm and closed"
            raise PydanticCustomError("shape", text, {"key": f"`{given[0]}`"})
        return self


class ShapeSpec(MeshSpec):
    """One closed shape: a mesh file or a primitive."""

    box: BoxSpec | None = None
    cylinder: CylinderSpec | None = None
    cone: ConeSpec | None = None
    revolve: ProfilePoints | None = Field(
        default=None,
        description="solid of revolution about Z: points [r, z], z never turning back [mm]",
    )
    extrude: ExtrudeSpec | None = None
    placement: PlacementSpec | None = Field(
        default=None, description="left out: where it was drawn"
    )

    @property
    def kind(self) -> str:
        """The key that gives the shape, "" when there is none."""
        return next((key for key in SHAPE_KEYS if getattr(self, key) is not None), "")

    @model_validator(mode="after")
    def _one_shape(self) -> ShapeSpec:
        given = [key for key in SHAPE_KEYS if getattr(self, key) is not None]
        if len(given) > 1:
            raise PydanticCustomError("shape", "{n} given: one shape only, or a list under `parts`",
                                      {"n": " and ".join(given)})  # fmt: skip
        return self


class PartSpec(ShapeSpec):
    """A shape of a body that has several."""

    name: Name = Field(description="unique within the body; appears in findings")

    @model_validator(mode="after")
    def _has_shape(self) -> PartSpec:
        if not self.kind:
            raise PydanticCustomError("shape", f"a part needs one of {', '.join(SHAPE_KEYS)}")
        return self


class BodySpec(ShapeSpec):
    """The shape of a body: one shape, several under `parts`, or none."""

    parts: list[PartSpec] | None = Field(
        default=None, description="several shapes, each with a name"
    )

    @model_validator(mode="after")
    def _shape_or_parts(self) -> BodySpec:
        if self.parts is None:
            return self
        if self.kind:
            raise PydanticCustomError("shape", f"give `{self.kind}` or `parts`, not both")
        names = [part.name for part in self.parts]
        if len(set(names)) < len(names) or not names:
            raise PydanticCustomError("shape", "parts need at least one entry and different names")
        return self


class LinkSpec(BodySpec):
    """A link; geometry in world coordinates at the zero pose of all joints."""

    side: Literal["work", "tool"] | None = Field(
        default=None,
        description="of the link that a joint moves: `work` lets the `axis` of the joint be that "
        "of the part program, for a table goes the other way; `tool`, or left out: as the link "
        "goes",
    )


class ServoSpec(Section):
    """How a drive lags behind its command; the bound of the lag is added to every clearance."""

    order: Literal[1, 2] = Field(default=1, description="of the lag")
    time_constant: Positive = Field(description="[s]; order 2: 1 / (2 pi frequency)")
    damping: Annotated[float, Field(strict=True, ge=0.01, le=100.0)] | None = Field(
        default=None, description="damping ratio of order 2; left out: 1"
    )

    @model_validator(mode="after")
    def _damping_of_order_two(self) -> ServoSpec:
        if self.damping is not None and self.order == 1:
            raise PydanticCustomError("servo", "`damping` belongs to `order: 2`")
        return self


class JointSpec(Section):
    """A moving pair; its key is the axis letter of the program.

    Programs move X Y Z A B C. An axis of another name, such as U, W, X2 or door, stands where
    `start` puts it, and each report says so.
    """

    type: Literal["linear", "rotary"]
    parent: Name = Field(description="link nearer to the root")
    child: Name = Field(description="link that the joint moves")
    axis: Triple = Field(
        description="direction in which the CHILD physically moves or turns (right hand) when the "
        "command grows, world coordinates at the zero pose; normalised"
    )
    point: Triple | None = Field(
        default=None, description="a point on the axis of a rotary joint [mm]"
    )
    limits: tuple[FileNumber, FileNumber] | None = Field(
        default=None, description="travel, lower and upper [mm or deg]; left out: unlimited"
    )
    rapid: Positive = Field(description="rapid rate [mm/min or deg/min]")
    max_acceleration: Positive | None = Field(default=None, description="[mm/s^2 or deg/s^2]")
    max_jerk: Positive | None = Field(default=None, description="[mm/s^3 or deg/s^3]")
    servo: ServoSpec | None = Field(default=None, description="left out: follows its command")
    wrap: Literal["none", "shortest", "sign"] = Field(
        default="none",
        description="reading of rotary words: unwound, modulo 360 the nearer way, by sign",
    )


class MountedSpec(BodySpec):
    """The tool in the spindle at the start; geometry in world coordinates at the zero pose."""

    name: Name = Field(default="tool", description="name of the body in pairs and findings")
    length: Positive = Field(description="gauge point to tip [mm]")
    flute: Positive | None = Field(
        default=None,
        description="height of the cutting part from the tip [mm], where one shape is all there is",
    )
    for_: Literal["all"] | None = Field(
        default=None, alias="for", description="`all`: it stands for every T number"
    )


class ToolMountSpec(Section):
    """Where tools are carried."""

    link: Name = Field(description="the link that carries the tool")
    gauge_point: Triple = Field(description="spindle face centre at the zero pose [mm]")
    axis: Triple = Field(default=UP, description="from the tip towards the spindle; normalised")
    mounted: MountedSpec | None = None


class OffsetSpec(Section):
    """A work offset."""

    X: FileNumber = Field(default=0.0, description="[mm]")
    Y: FileNumber = Field(default=0.0, description="[mm]")
    Z: FileNumber = Field(default=0.0, description="[mm]")
    A: FileNumber = Field(default=0.0, description="[deg]")
    B: FileNumber = Field(default=0.0, description="[deg]")
    C: FileNumber = Field(default=0.0, description="[deg]")
    R: FileNumber = Field(default=0.0, description="rotation in the XY plane [deg]")


PLAIN_OFFSETS = ("G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3")


def offset_number(name: str) -> int:
    """Number of a work offset: G54 = 1 ... G59.3 = 9, G54.1 P1 = 101 ...; 0 for no such name."""
    additional = re.fullmatch(r"G54\.1 ?P([1-9]\d{0,2})", name)
    if additional:
        return 100 + int(additional[1])
    return PLAIN_OFFSETS.index(name) + 1 if name in PLAIN_OFFSETS else 0


def offset_name(number: int) -> str:
    """Name of a work offset by its number."""
    return f"G54.1 P{number - 100}" if number > 100 else PLAIN_OFFSETS[number - 1]


def _known_offset(name: str) -> str:
    if not offset_number(name):
        raise PydanticCustomError("offset", "write G54 ... G59, G59.1 ... G59.3 or G54.1 P1 ...")
    return name


OffsetName = Annotated[str, AfterValidator(_known_offset)]
Offsets = dict[OffsetName, OffsetSpec]


class WorkSpec(Section):
    """The work piece: what carries it and where its zero points are."""

    link: Name = Field(description="the link that carries the work piece")
    offsets: Offsets = Field(
        default_factory=dict, description="by name: G54 ... G59, G59.1 ... G59.3, G54.1 P1 ..."
    )


class PairSpec(Section):
    """Two bodies that must not touch; `[a, b]` for short."""

    model_config = ConfigDict(
        json_schema_extra=lambda schema: _allow_short_pair(schema),  # noqa: PLW0108 (defined below)
    )
    links: tuple[PartName, PartName] = Field(
        description="names of links, of the tool, or of one part: `C.table`"
    )
    clearance: NotNegative = Field(default=0.0, description="distance that must stay free [mm]")
    severity: Severity = Field(default="warning", description="of a finding about the clearance")

    @model_validator(mode="before")
    @classmethod
    def _short(cls, data: Any) -> Any:
        if isinstance(data, str):
            raise PydanticCustomError("shape", "write a pair as [a, b]")
        return {"links": data} if isinstance(data, list) else data


def _allow_short_pair(schema: dict[str, Any]) -> None:
    """JSON Schema: a pair is the mapping or a list of two names."""
    mapping = dict(schema)
    schema.clear()
    names = {"type": "array", "items": {"type": "string"}, "minItems": 2, "maxItems": 2}
    schema["anyOf"] = [names, mapping]


class AllowedSpec(Section):
    """A pair that may touch."""

    links: tuple[PartName, PartName] = Field(
        description="the two bodies, or parts of them: `C.table`"
    )
    reason: Annotated[str, Field(min_length=1)] = Field(description="why, for the report")


class PathToleranceSpec(Section):
    """How far the control may leave the programmed path; null: unknown, so reports say so."""

    G64: NotNegative | None = Field(default=None, description="[mm]")
    rapid: NotNegative | None = Field(default=None, description="[mm]")


class MachineFile(Section):
    """A machine.yaml."""

    elsewhere = CONTROL_KEYS

    name: Name
    verified: bool = Field(default=False, description="someone has measured the real machine")
    units: Unit = Field(
        default="mm",
        description="of the mesh files; and of programs without G20 and G21, where `control` has "
        "no `program_unit`",
    )
    dialect: Dialect | Literal["auto"] = Field(
        default="fanuc",
        description="row of values for what `control` leaves out; auto: the program tells it",
    )
    control: ControlKeys = Field(
        default_factory=ControlKeys, description="how the control reads what is left open"
    )
    links: Annotated[dict[Name, LinkSpec], Field(min_length=1)]
    joints: Annotated[dict[JointName, JointSpec], Field(min_length=1)]
    tool: ToolMountSpec | None = None
    work: WorkSpec | None = None
    reference: dict[Annotated[str, Field(pattern="^G(28|30)$")], Position] = Field(
        default_factory=dict, description="machine positions [mm, deg]"
    )
    start: Position = Field(
        default_factory=dict, description="machine position at program start [mm, deg]; else 0"
    )
    pairs: list[PairSpec] | None = Field(
        default=None,
        description="left out: every two links with a moving joint between them, less neighbours",
    )
    allow: list[AllowedSpec] = Field(
        default_factory=list, description="pairs taken out, with a reason"
    )
    path_tolerance: PathToleranceSpec = Field(default_factory=PathToleranceSpec)
    time: Literal["constant", "acceleration", "jerk", "auto"] = Field(
        default="constant",
        description="speed within a block: as programmed, or within `max_acceleration`, or within "
        "`max_jerk` too, with look-ahead; auto: as far as every joint has those limits, and each "
        "report says what is missing",
    )


def _frame_name(name: str) -> str:
    if name not in ("world", "table") and not offset_number(name):
        raise PydanticCustomError("frame", "write world, table, or a work offset such as G54")
    return name


class SetupBodySpec(BodySpec):
    """A fixture, the part or the stock, where people know it to be."""

    link: Name | None = Field(
        default=None,
        description="the link it is clamped to; left out: that of what it stands on, or that of "
        "`work`",
    )
    role: Literal["fixture", "part", "stock"] = Field(
        description="flute against part or stock is cutting, not collision"
    )
    frame: Annotated[str, AfterValidator(_frame_name)] | None = Field(
        default=None,
        description="coordinates of its shape: `world` at the zero pose; `table`: program "
        "directions, from the middle of the mount face of its link (its part `table`, if it has "
        "one); `G54`, ...: from that zero point. Left out: `world`, or `table` where it stands "
        "`on` something",
    )
    on: PartName | None = Field(
        default=None,
        description="what it stands on: `table`, the mount face of its link, or a body, or a part "
        "of one (`vise.base`); only its height follows from it",
    )


class StockCheckSpec(Section):
    """How the stock is checked as it is cut away."""

    inset: Annotated[float, Field(strict=True, ge=LEAST_INSET_MM, le=5.0)] = Field(
        default=STOCK_INSET_MM,
        description="nothing may be deeper in what is left of the stock [mm]; half of it at least "
        "is what a finding shows",
    )


class SetupFile(Section):
    """A setup.yaml."""

    machine: FileName | None = Field(
        default=None, description="machine file or name of a shipped machine"
    )
    tools: FileName | None = Field(default=None, description="tools file, relative to this file")
    units: Unit = Field(default="mm", description="of the mesh files")
    offsets: Offsets = Field(
        default_factory=dict,
        description="replace those of the machine file; axes that are not named keep its values",
    )
    start: Position = Field(default_factory=dict, description="replaces that of the machine file")
    variables: dict[Natural, FileNumber] = Field(
        default_factory=dict,
        description="number -> value: macro variables that the control keeps; others are not known",
    )
    bodies: dict[Name, SetupBodySpec] = Field(default_factory=dict)
    stock_check: StockCheckSpec = Field(default_factory=StockCheckSpec)
