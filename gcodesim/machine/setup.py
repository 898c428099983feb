"""The setup of a job: what is clamped where, work offsets, tools and the start position."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gcodesim.errors import ModelError
from gcodesim.machine.bodies import PartReader
from gcodesim.machine.files import beside
from gcodesim.machine.model import Body, Part
from gcodesim.machine.placing import PlaceError, WorkFrames, foot_of, top_of
from gcodesim.machine.schema import OffsetSpec, SetupBodySpec, SetupFile, offset_number
from gcodesim.machine.shapes import place
from gcodesim.machine.yaml_lines import YamlFile, read_yaml, suggest

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Setup:
    """A setup file; without a source it is empty."""

    source: YamlFile
    file: SetupFile

    @property
    def machine(self) -> str | None:
        """The machine it names: a path from here, or the name of a shipped machine."""
        return self._beside(self.file.machine)

    @property
    def tools(self) -> str | None:
        """The tools file it names, as a path from here."""
        return self._beside(self.file.tools)

    def _beside(self, name: str | None) -> str | None:
        return None if name is None else beside(self.source.path, name)

    def offsets(self, own: Mapping[str, OffsetSpec]) -> dict[str, OffsetSpec]:
        """Work offsets of the machine file, with the axes that the setup names replaced."""
        found = dict(own)
        for name, spec in self.file.offsets.items():
            named = {letter: getattr(spec, letter) for letter in spec.model_fields_set}
            found[name] = found[name].model_copy(update=named) if name in found else spec
        return found

    def bodies(
        self, work: str | None, frames: WorkFrames, reader: PartReader
    ) -> dict[str, tuple[Body, str]]:
        """Bodies of the setup by name, each with its role, in world coordinates at the zero pose.

        Args:
            work: the link that carries the work, None where the machine file names none.
            frames: of the machine; its bodies can be stood on.
            reader: reads the shapes of this file.

        Raises:
            ModelError: an unknown link, a name used twice, a body without a shape, or a place that
                does not exist.
        """
        clamping = _Clamping(self, work, frames, reader)
        for name in self.file.bodies:
            clamping.place(name)
        return {name: (clamping.placed[name], s.role) for name, s in self.file.bodies.items()}


@dataclass
class _Clamping:
    """Bodies of a setup that are placed one after the other, what carries another one first."""

    setup: Setup
    work: str | None
    frames: WorkFrames
    reader: PartReader
    placed: dict[str, Body] = field(default_factory=dict)
    pending: list[str] = field(default_factory=list)

    def place(self, name: str) -> Body:
        """The body of that name, placed; those below it are placed before."""
        if name in self.placed:
            return self.placed[name]
        if name in self.pending:
            ring = " on ".join([*self.pending[self.pending.index(name) :], name])
            raise self._error(f"nothing carries them all: {ring}", name, "on")
        self.pending.append(name)
        spec = self.setup.file.bodies[name]
        below = self._below(name, spec)
        link = self._link(name, spec, below)
        parts = self.reader.parts(spec, name, spec.role, "bodies", name)
        if not parts:
            text = "a body of the setup needs a shape: mesh, box, cylinder, ... or parts"
            raise self._error(text, name)
        try:
            moved = self._moved(parts, spec, link, below)
        except PlaceError as error:
            raise self._error(str(error), name, "frame" if spec.frame else "on") from None
        self.pending.pop()
        self.placed[name] = Body(name, link, moved)
        return self.placed[name]

    def _below(self, name: str, spec: SetupBodySpec) -> Body | None:
        """What a body stands on, where that is another body or a part of one."""
        if spec.on is None or spec.on == "table":
            return None
        whole, _, part = spec.on.partition(".")
        names = [*self.setup.file.bodies, *self.frames.bodies]
        if whole not in names:
            text = f"there is no body {whole!r}; {suggest(whole, ['table', *names])}"
            raise self._error(text, name, "on")
        body = self.place(whole) if whole in self.setup.file.bodies else self.frames.bodies[whole]
        parts = tuple(p for p in body.parts if p.name == part) if part else body.parts
        if not parts:
            text = f"{whole} has no part {part!r}; {suggest(part, [p.name for p in body.parts])}"
            raise self._error(text, name, "on")
        return Body(body.name, body.link, parts)

    def _link(self, name: str, spec: SetupBodySpec, below: Body | None) -> str:
        """The link that carries a body."""
        link = spec.link or (below.link if below else self.work)
        if link is None:
            text = "name the `link` it is clamped to: the machine file has no `work` that says it"
            raise self._error(text, name)
        if link not in self.frames.links:
            text = f"unknown link {link!r}; {suggest(link, self.frames.links)}"
            raise self._error(text, name, "link")
        if below is not None and below.link != link:
            text = f"{below.name} is on link {below.link}: what stands on it moves with it"
            raise self._error(text, name, "link")
        return link

    def _moved(
        self, parts: tuple[Part, ...], spec: SetupBodySpec, link: str, below: Body | None
    ) -> tuple[Part, ...]:
        frame = spec.frame or ("table" if spec.on else "world")
        if frame == "table":
            parts = _put(parts, self.frames.table(link))
        elif frame != "world":
            number = offset_number(frame)
            if number not in self.frames.offsets:
                raise PlaceError(f"no offset {frame} is given: write it under `offsets`")
            parts = _put(parts, self.frames.zero_point(number, link))
        if spec.on is None:
            return parts
        up = self.frames.up(link)
        carrying = below.parts if below else self.frames.mounting(link)
        rise = top_of(carrying, up) - foot_of(parts, up)
        shift = np.eye(4)
        shift[:3, 3] = rise * up
        return _put(parts, shift)

    def _error(self, text: str, *key: str) -> ModelError:
        return self.setup.source.error(text, "bodies", *key)


def _put(parts: tuple[Part, ...], pose: Array) -> tuple[Part, ...]:
    """Parts moved by a pose (4, 4)."""
    return tuple(replace(p, triangles=place(p.triangles, pose[:3, :3], pose[:3, 3])) for p in parts)


def read_setup(path: str | None) -> Setup:
    """A setup file, or the empty setup for None.

    Raises:
        UsageError: the file is missing.
        ModelError: it is wrong; names file, line and key.
    """
    source = YamlFile(Path("setup"), {}) if path is None else read_yaml(Path(path))
    return Setup(source, source.parse(SetupFile))
