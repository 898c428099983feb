"""Reads JSON whose mistakes are reported with their line, and lists of objects in it."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gcodesim.constants import LARGEST_NUMBER
from gcodesim.errors import ModelError


@dataclass(frozen=True)
class JsonItem:
    """An object of a JSON file, with its place.

    Attributes:
        path: the file.
        value: what it holds.
        text: of the file from the object on.
        line: 1-based line of its beginning.
    """

    path: Path
    value: dict[str, Any]
    text: str
    line: int

    def error(self, message: str, *keys: str) -> ModelError:
        """A ModelError at a key below, at the nearest one above it that stands in the file."""
        place = 0
        for key in keys:
            found = self.text.find(json.dumps(key), place)
            place = found if found >= 0 else place
        line = self.line + self.text.count("\n", 0, place)
        return ModelError(message, str(self.path), line, ".".join(keys))

    def section(self, *keys: str) -> dict[str, Any]:
        """An object below, empty where there is none; ModelError where it is no object."""
        value: Any = self.value
        for i, key in enumerate(keys):
            value = value.get(key)
            if value is None:
                return {}
            if not isinstance(value, dict):
                raise self.error("expected an object {...}", *keys[: i + 1])
        return dict(value)

    def number(self, *keys: str) -> float:
        """A number below, 0 where there is none; ModelError where it is none or far too large."""
        value = self.section(*keys[:-1]).get(keys[-1])
        if value is None or value == "":
            return 0.0
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.error(f"expected a number, not {value!r}", *keys)
        return self.in_range(value, *keys)

    def in_range(self, value: int | float, *keys: str) -> float:
        """A number that stands at a place; ModelError where it is none or far too large."""
        if abs(value) <= LARGEST_NUMBER:
            return float(value)
        given = f"{value!r}"[:40]
        raise self.error(f"expected a number up to {LARGEST_NUMBER:g}, not {given}", *keys)

    def text_at(self, *keys: str) -> str:
        """A text below, "" where there is none."""
        value = self.section(*keys[:-1]).get(keys[-1])
        return value.strip() if isinstance(value, str) else ""

    def objects(self, *keys: str) -> list[dict[str, Any]]:
        """A list of objects below, empty where there is none."""
        value = self.section(*keys[:-1]).get(keys[-1])
        if value is None:
            return []
        if not isinstance(value, list) or not all(isinstance(each, dict) for each in value):
            raise self.error("expected a list of objects [{...}, ...]", *keys)
        return value


def read_json(path: Path, text: str) -> JsonItem:
    """The object that a JSON text holds; ModelError where it holds none."""
    try:
        data = json.loads(text)
    except json.JSONDecodeError as error:
        raise ModelError(f"no valid JSON: {error.msg}", str(path), error.lineno) from None
    except ValueError as error:  # a number of 5000 digits
        raise ModelError(f"no valid JSON: {error}", str(path)) from None
    except RecursionError:
        raise ModelError("no valid JSON: nested too deep", str(path)) from None
    if not isinstance(data, dict):
        raise ModelError("expected an object {...} at the top", str(path), 1)
    return JsonItem(path, data, text, 1)


def items_of(whole: JsonItem, key: str) -> Iterator[JsonItem]:
    """Yield the objects of a list at the top of a file, each with its line."""
    decoder = json.JSONDecoder()
    opening = re.search(rf"{re.escape(json.dumps(key))}\s*:\s*\[", whole.text)
    place = opening.end() if opening else 0
    line, counted = 1, 0
    for value in whole.objects(key):
        start = whole.text.find("{", place)
        line, counted = line + whole.text.count("\n", counted, start), start
        _, place = decoder.raw_decode(whole.text, start)
        yield JsonItem(whole.path, value, whole.text[start:place], line)
