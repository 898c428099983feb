"""What a tools file may hold: pydantic models, whose descriptions are the manual.

Lengths mm, angles degrees.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from gcodesim.machine.schema import FileName, MeshSpec, ProfilePoints, Unit
from gcodesim.machine.sections import FileNumber, NotNegative, Positive, Section

ToolType = Literal[
    "mill", "ball", "face", "slot", "dovetail", "lollipop", "radius", "chamfer", "thread",
    "drill", "countersink", "tap", "reamer", "boring", "form", "probe",
]  # fmt: skip


class TurnedSpec(MeshSpec):
    """A turned part of a tool: points `[r, z]`, or a mesh."""

    profile: ProfilePoints | None = Field(
        default=None, description="points [r, z], z from the gauge face TOWARDS the tip [mm]"
    )
    mesh: FileName | None = Field(
        default=None, description="mesh file, gauge point at its origin, +Z towards the spindle"
    )

    @model_validator(mode="before")
    @classmethod
    def _short(cls, data: Any) -> Any:
        return {"profile": data} if isinstance(data, list) else data

    @model_validator(mode="after")
    def _one_shape(self) -> TurnedSpec:
        if (self.profile is None) == (self.mesh is None):
            raise PydanticCustomError("shape", "give a list of [r, z] points or `mesh: file`")
        return self


class FluteSpec(MeshSpec):
    """The cutting part of a tool, from the tip upwards, as numbers, as points or as a mesh."""

    diameter: Positive | None = Field(
        default=None,
        description="where the side, drawn down, meets the plane of the tip; with `point_angle`: "
        "above the point [mm]",
    )
    length: Positive | None = Field(
        default=None, description="height of the cutting part from the tip [mm]"
    )
    corner_radius: NotNegative = Field(
        default=0.0, description="[mm]; half the diameter makes a ball; `radius`: of the hollow arc"
    )
    taper: Annotated[float, Field(strict=True, gt=-80, lt=80)] = Field(
        default=0.0, description="between axis and side, positive when it widens upwards [deg]"
    )
    point_angle: Annotated[float, Field(strict=True, gt=0, lt=180)] | None = Field(
        default=None,
        description="full angle of the point of a drill, 118, of a chamfer mill, 90, ... [deg]",
    )
    tip_diameter: NotNegative = Field(
        default=0.0, description="flat of the tip below `point_angle` [mm]"
    )
    tip_length: NotNegative = Field(
        default=0.0, description="`radius`: height of the tip below the hollow arc [mm]"
    )
    upper_radius: NotNegative = Field(
        default=0.0, description="of the upper corner, of a `slot` cutter [mm]"
    )
    pitch: Positive | None = Field(
        default=None, description="of a `tap` or `thread` mill: what cuts is known to its root [mm]"
    )
    profile: ProfilePoints | None = Field(
        default=None, description="points [r, z], z upwards from the tip, never inside the true one"
    )
    inscribed: ProfilePoints | None = Field(
        default=None,
        description="points [r, z] never outside the true shape: what surely cuts; left out: "
        "what the numbers make, or `profile`",
    )
    mesh: FileName | None = Field(
        default=None, description="mesh file, gauge point at its origin, +Z towards the spindle"
    )

    @model_validator(mode="after")
    def _one_shape(self) -> FluteSpec:
        if self.mesh is None and self.profile is None and not (self.diameter and self.length):
            raise PydanticCustomError(
                "shape", "give `diameter` and `length`, or `profile`, or `mesh: file`"
            )
        return self


class ToolOffsetSpec(Section):
    """What the control's table holds; letters left out: 0, Z: the length."""

    X: FileNumber = Field(default=0.0, description="[mm]")
    Y: FileNumber = Field(default=0.0, description="[mm]")
    Z: FileNumber | None = Field(default=None, description="[mm]; left out: `length`")
    A: FileNumber = Field(default=0.0, description="[deg]")
    B: FileNumber = Field(default=0.0, description="[deg]")
    C: FileNumber = Field(default=0.0, description="[deg]")


class ToolSpec(Section):
    """One tool of the tools file."""

    number: Annotated[int, Field(strict=True, ge=0)] = Field(description="the T number")
    name: str = Field("", description="for people")
    type: ToolType = Field("mill", description="what its numbers mean; see `gcodesim tool new`")
    length: NotNegative = Field(description="gauge point to tip [mm]; 0: unknown, so no shape")
    offset: ToolOffsetSpec = Field(
        default_factory=ToolOffsetSpec, description="where the control's table differs"
    )
    diameter: Positive | None = Field(
        default=None, description="in the control's table [mm]; left out: that of the flute"
    )
    flute: FluteSpec | None = None
    shank: TurnedSpec | None = None
    holder: TurnedSpec | None = None

    @model_validator(mode="after")
    def _length_of_shapes(self) -> ToolSpec:
        if self.length == 0.0 and (self.flute or self.shank or self.holder):
            raise PydanticCustomError("shape", "a tool with a shape needs a `length` above 0")
        return self


class ToolsFile(Section):
    """A tools.yaml."""

    units: Unit = Field(default="mm", description="of the mesh files")
    tools: list[ToolSpec]
