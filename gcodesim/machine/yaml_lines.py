"""Reads YAML safely, remembers the line of every key, and turns every mistake into a ModelError."""

from __future__ import annotations

import difflib
import re
import reprlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import yaml

from gcodesim.errors import ModelError, UsageError
from gcodesim.input_file import read_text

if TYPE_CHECKING:
    from pydantic import BaseModel

ParsedModel = TypeVar("ParsedModel", bound="BaseModel")
KeyPath = tuple[str, ...]

NODE_LIMIT = 100_000
"""Largest number of values in a file, aliases written out: a few lines could stand for billions."""

DEPTH_LIMIT = 32
"""Deepest nesting of a file; an alias that contains itself ends here."""


_TAGS: dict[type[yaml.Node], frozenset[str]] = {
    kind: frozenset(f"tag:yaml.org,2002:{name}" for name in names.split())
    for kind, names in {
        yaml.MappingNode: "map",
        yaml.SequenceNode: "seq",
        yaml.ScalarNode: "str int float bool null",
    }.items()
}
"""The tags that a node may have: those of plain values, which need not be written."""


class _Loader(yaml.SafeLoader):
    """SafeLoader with the plain scalars of YAML 1.2: 1e3 is a number, `on` and 1:30 are words."""

    yaml_implicit_resolvers = {}  # noqa: RUF012 (declared so by PyYAML)
    composed = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        """Read one node; a file of millions would take minutes before it is looked at."""
        self.composed += 1
        if self.composed > NODE_LIMIT:
            text = f"more than {NODE_LIMIT} values"
            raise yaml.MarkedYAMLError(problem=text, problem_mark=parent.start_mark)
        return super().compose_node(parent, index)


for _tag, _pattern, _first in (
    ("null", r"~|null|Null|NULL|", ["~", "n", "N", ""]),
    ("bool", r"true|True|TRUE|false|False|FALSE", list("tTfF")),
    ("int", r"[-+]?(0|[1-9][0-9]*)", list("-+0123456789")),
    ("float", r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?", list("-+.0123456789")),
):
    _Loader.add_implicit_resolver(
        f"tag:yaml.org,2002:{_tag}", re.compile(f"(?:{_pattern})$"), _first
    )


@dataclass(frozen=True)
class YamlFile:
    """A YAML file as plain data, with the place of every key.

    Attributes:
        path: the file, as the user named it.
        data: what it holds: dict, list, str, int, float, bool, None.
        lines: key path (list positions as digits) -> 1-based line.
    """

    path: Path
    data: Any
    lines: Mapping[KeyPath, int] = field(default_factory=dict)

    def error(self, message: str, *key: str | int) -> ModelError:
        """A ModelError at a key, or at the nearest key above it that stands in the file."""
        place = tuple(str(part) for part in key)
        return ModelError(message, str(self.path), self.line(place), ".".join(place))

    def line(self, key: KeyPath) -> int | None:
        """Line of a key or of the nearest key above it; None for the file as a whole."""
        while key and key not in self.lines:
            key = key[:-1]
        return self.lines.get(key)

    def parse(self, model: type[ParsedModel]) -> ParsedModel:
        """The data as a pydantic model; ModelError at the first line that is wrong."""
        from pydantic import ValidationError  # slow to import, and many files are only looked at

        try:
            return model.model_validate(self.data)
        except ValidationError as error:
            details = error.errors(include_url=False)
        found = sorted((self._explain(detail) for detail in details), key=lambda e: e.line or 0)
        if len(found) > 1:
            more = ", ".join(f"line {e.line} {e.key}" for e in found[1:4])
            raise self.error(f"{found[0].message} (also wrong: {more})", *found[0].place)
        raise self.error(found[0].message, *found[0].place)

    def _explain(self, detail: Mapping[str, Any]) -> _Fault:
        """One entry of pydantic's list in our words."""
        place = tuple(str(part) for part in detail["loc"] if part != "[key]")
        place += tuple(detail.get("ctx", {}).get("below", ()))
        given = detail["input"]
        match detail["type"]:
            case "missing":
                message = "this key is required and missing"
            case kind if isinstance(given, dict | list) or kind in ("unknown_key", "shape"):
                message = str(detail["msg"])
            case _:
                message = f"{str(detail['msg']).removeprefix('Value error, ')}, not {given!r}"
        return _Fault(message, place, self.line(place))


@dataclass(frozen=True)
class _Fault:
    """A mistake in a file before it is raised."""

    message: str
    place: KeyPath
    line: int | None

    @property
    def key(self) -> str:
        """The dotted key."""
        return ".".join(self.place)


def suggest(word: object, valid: Iterable[str]) -> str:
    """The sentence after an unknown word: ``did you mean 'axis'? valid: axis, child, ...``."""
    names = list(valid)
    near = difflib.get_close_matches(str(word), names, n=1)
    guess = f"did you mean {near[0]!r}? " if near else ""
    return f"{guess}valid: {', '.join(names) if names else 'none'}"


def read_yaml(path: Path) -> YamlFile:
    """Read one YAML document.

    Raises:
        UsageError: the file cannot be read.
        ModelError: it is no YAML, or repeats a key, or is nested or aliased beyond the limits.
    """
    try:
        text = read_text(path)
    except OSError as error:
        raise UsageError(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise ModelError(f"not UTF-8 text: byte {error.start}", str(path)) from error
    walk = _Walk(path)
    try:
        loader = _Loader(text)
        node = loader.get_single_node()
        data = None if node is None else walk.value(loader, node, ())
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = None if mark is None else mark.line + 1
        problem = error.problem or "no valid YAML"
        raise ModelError(f"no valid YAML: {problem}", str(path), line) from error
    except (yaml.YAMLError, ValueError) as error:
        raise ModelError(f"no valid YAML: {' '.join(str(error).split())}", str(path)) from error
    except RecursionError:
        raise ModelError(f"nested deeper than {DEPTH_LIMIT}", str(path)) from None
    if not isinstance(data, dict):
        raise ModelError("the file must be a mapping of keys to values", str(path), 1)
    return YamlFile(path, data, walk.lines)


@dataclass
class _Walk:
    """Turns nodes into values and notes the line of every key on the way."""

    path: Path
    lines: dict[KeyPath, int] = field(default_factory=dict)
    count: int = 0

    def value(self, loader: _Loader, node: yaml.Node, key: KeyPath) -> Any:
        """The value of a node; aliases are written out."""
        self.count += 1
        if self.count > NODE_LIMIT:
            raise self._error(
                f"more than {NODE_LIMIT} values (aliases counted each time)", node, ()
            )
        if len(key) > DEPTH_LIMIT:
            raise self._error(f"nested deeper than {DEPTH_LIMIT}", node, key[:3])
        if node.tag not in _TAGS[type(node)]:
            raise self._error(f"unknown tag {node.tag}", node, key)
        if isinstance(node, yaml.MappingNode):
            return self._mapping(loader, node, key)
        if isinstance(node, yaml.SequenceNode):
            return [self._item(loader, item, (*key, str(i))) for i, item in enumerate(node.value)]
        return self._scalar(loader, node, key)

    def _mapping(self, loader: _Loader, node: yaml.MappingNode, key: KeyPath) -> dict[Any, Any]:
        values: dict[Any, Any] = {}
        for name_node, item in node.value:
            if not isinstance(name_node, yaml.ScalarNode):
                raise self._error("a key must be a plain word or number", name_node, key)
            name = self._scalar(loader, name_node, key)
            place = (*key, str(name))
            if name in values:
                first = self.lines.get(place, "an earlier one")
                raise self._error(f"given twice, the first is in line {first}", name_node, place)
            self.lines[place] = name_node.start_mark.line + 1
            values[name] = self.value(loader, item, place)
        return values

    def _scalar(self, loader: _Loader, node: yaml.Node, key: KeyPath) -> Any:
        if node.tag not in _TAGS[yaml.ScalarNode]:
            raise self._error(f"unknown tag {node.tag}", node, key)
        try:
            return loader.construct_object(node)
        except (LookupError, ValueError):  # `!!bool perhaps`, `!!int ""`, 5000 digits
            kind, text = node.tag.rpartition(":")[2], reprlib.repr(node.value)
            raise self._error(f"no {kind}: {text}", node, key) from None

    def _item(self, loader: _Loader, node: yaml.Node, key: KeyPath) -> Any:
        self.lines[key] = node.start_mark.line + 1
        return self.value(loader, node, key)

    def _error(self, message: str, node: yaml.Node, key: KeyPath) -> ModelError:
        return ModelError(message, str(self.path), node.start_mark.line + 1, ".".join(key))
