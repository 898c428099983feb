"""Controls for the programs of this folder: a dialect's row with single keys replaced."""

from dataclasses import fields
from typing import Any

from gcodesim.nc.control.readings import Readings, choose_readings
from gcodesim.nc.control.supply import Control

SAID = {"no_point": "units", "program_unit": "mm"}
"""What the programs of this folder mean, which are short: a tested control may say otherwise."""

KEYS = {field.name for field in fields(Readings)}


def make_control(dialect: str = "fanuc", **given: Any) -> Control:
    """A control of a dialect; what is no field of Control replaces a key of its readings."""
    keys = SAID | {name: value for name, value in given.items() if name in KEYS}
    others = {name: value for name, value in given.items() if name not in KEYS}
    return Control(choose_readings(dialect, keys), **others)
