"""The section `control` of machine files, made from the fields of Readings."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, fields, is_dataclass
from types import NoneType
from typing import TYPE_CHECKING, Annotated, Any, get_args, get_origin, get_type_hints

from pydantic import BeforeValidator, Field, create_model

from gcodesim.constants import LARGEST_NUMBER
from gcodesim.machine.sections import FileNumber, Section
from gcodesim.nc.control.readings import ROWS, Readings, ToolChangeMotion

CONTROL_KEYS = frozenset(entry.name for entry in fields(Readings) if "meaning" in entry.metadata)
"""Keys of a machine file's section `control`."""

STRICT: dict[type, dict[str, Any]] = {
    float: {"strict": True, "le": LARGEST_NUMBER},
    bool: {"strict": True},
}
"""Numbers and truths of a file are written as such: "3" and 1 are none."""


NUMBER_OR_WORD = BeforeValidator(lambda key: str(key) if type(key) is int else key)
"""A key of a mapping that is a word; numbers stand for themselves."""


class _Keys(Section):
    """A section whose keys are the fields of a dataclass."""

    elsewhere = CONTROL_KEYS


def _section_of(data: type, rows: Mapping[str, Any]) -> type[Section]:
    """Make the section whose keys replace fields of a dataclass; those left out are None.

    Args:
        data: the dataclass; its fields with a meaning are the keys.
        rows: dialect -> what the fields are for keys left out.
    """
    hints, keys = get_type_hints(data), {}
    for entry in fields(data):
        if "meaning" in entry.metadata:
            own = {name: getattr(row, entry.name) for name, row in rows.items()}
            text = entry.metadata["meaning"] + _left_out(own)
            kind = _in_file(hints[entry.name], entry.metadata["rules"], own)
            keys[entry.name] = (kind | None, Field(default=None, description=text))
    doc = (data.__doc__ or "").partition("\n")[0]
    made: dict[str, Any] = {"__base__": _Keys, "__doc__": doc, **keys}
    return create_model(f"{data.__name__}Keys", **made)


def _in_file(hint: Any, rules: Mapping[str, Any], rows: Mapping[str, Any]) -> Any:
    """The type of a field as a file gives it: numbers and words keep the field's rules."""
    if is_dataclass(hint):
        return _section_of(hint, rows)  # type: ignore[arg-type]
    inner = get_args(hint)
    if inner and is_dataclass(inner[0]):
        return _section_of(inner[0], {}) | inner[1]  # type: ignore[arg-type]
    if get_origin(hint) is tuple:
        return tuple[_in_file(inner[0], rules, rows), ...]  # type: ignore[misc]
    if get_origin(hint) is Mapping:
        key = FileNumber if inner[0] is float else Annotated[str, NUMBER_OR_WORD, Field(**rules)]
        value = FileNumber if inner[1] is float else inner[1]
        return dict[key, value]  # type: ignore[valid-type]
    if NoneType in inner:
        return _in_file(inner[0], rules, rows)
    return Annotated[hint, Field(**STRICT.get(hint, {}), **rules)]


def _left_out(rows: Mapping[str, Any]) -> str:
    """What a key is when it is left out, for the manual; by dialect where they differ."""
    words = any(isinstance(value, str | float | bool) for value in rows.values())
    values = {
        name: json.dumps(asdict(value) if isinstance(value, ToolChangeMotion) else value).replace(
            '"', ""
        )
        for name, value in rows.items()
        if words and isinstance(value, str | float | bool | ToolChangeMotion)
    }
    if len(set(values.values())) < 2:
        return "".join(f"; left out: {value}" for value in [*values.values()][:1])
    return "; left out: " + ", ".join(f"{name} {value}" for name, value in values.items())


if TYPE_CHECKING:
    # No checker follows a class made while the program runs, and no code asks this one for a key.
    ControlKeys = Section
else:
    ControlKeys = _section_of(Readings, ROWS)
