"""What every section of a machine, tools or setup file keeps: known keys, sane numbers."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from gcodesim.machine.yaml_lines import suggest

LARGEST = 1e9
"""Largest number of a file, in any unit: beyond it squares of lengths lose the micrometre."""

Number = Annotated[float, Field(strict=True, ge=-LARGEST, le=LARGEST)]
NotNegative = Annotated[float, Field(strict=True, ge=0, le=LARGEST)]
Positive = Annotated[float, Field(strict=True, gt=0, le=LARGEST)]


class Section(BaseModel):
    """A mapping of the file: unknown keys are refused, and an empty one may be left blank."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    elsewhere: ClassVar[frozenset[str]] = frozenset()
    """Keys that stand in `control` and may be looked for here."""

    @model_validator(mode="before")
    @classmethod
    def _known_keys(cls, data: Any) -> Any:
        if data is None:
            return {}
        if isinstance(data, dict):
            valid = [f.alias or name for name, f in cls.model_fields.items()]
            for key in data:
                if key not in valid:
                    moved = key in cls.elsewhere
                    hint = f"it stands in `control`: write `control: {{{key}: ...}}`"
                    context = {"hint": hint if moved else suggest(key, valid), "below": (str(key),)}
                    raise PydanticCustomError("unknown_key", "unknown key; {hint}", context)
        return data
