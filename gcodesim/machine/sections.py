"""What every section of a machine, tools or setup file keeps: known keys, sane numbers."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

from pydantic import BaseModel, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from gcodesim.constants import LARGEST_NUMBER
from gcodesim.machine.yaml_lines import suggest

FileNumber = Annotated[float, Field(strict=True, ge=-LARGEST_NUMBER, le=LARGEST_NUMBER)]
NotNegative = Annotated[float, Field(strict=True, ge=0, le=LARGEST_NUMBER)]
Positive = Annotated[float, Field(strict=True, gt=0, le=LARGEST_NUMBER)]


class Section(BaseModel):
    """A mapping of the file: unknown keys are refused, and an empty one may be left blank.

    What a whole file holds is named after it (MachineFile), what a key of it holds ends in Spec:
    `BodySpec` is what the file says, `machine.model.Body` what was made of it.
    """

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
