"""The setup of a job: what is clamped where, work offsets, tools and the start position."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from gcodesim.machine.bodies import PartReader
from gcodesim.machine.files import beside
from gcodesim.machine.model import Body
from gcodesim.machine.schema import SetupFile
from gcodesim.machine.yaml_lines import YamlFile, read_yaml, suggest


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

    def bodies(
        self, links: Sequence[str], taken: Sequence[str], reader: PartReader
    ) -> dict[str, tuple[Body, str]]:
        """Bodies of the setup by name, each with its role.

        Args:
            links: of the machine.
            taken: names of the bodies of the machine.
            reader: reads the shapes of this file.

        Raises:
            ModelError: an unknown link, a name used twice, or a body without a shape.
        """
        bodies: dict[str, tuple[Body, str]] = {}
        for name, spec in self.file.bodies.items():
            if spec.link not in links:
                text = f"unknown link {spec.link!r}; {suggest(spec.link, links)}"
                raise self.source.error(text, "bodies", name, "link")
            if name in taken:
                text = f"the machine already has a body named {name}: choose another name"
                raise self.source.error(text, "bodies", name)
            parts = reader.parts(spec, name, spec.role, "bodies", name)
            if not parts:
                text = "a body of the setup needs a shape: mesh, box, cylinder, ... or parts"
                raise self.source.error(text, "bodies", name)
            bodies[name] = (Body(name, spec.link, parts), spec.role)
        return bodies


def read_setup(path: str | None) -> Setup:
    """A setup file, or the empty setup for None.

    Raises:
        UsageError: the file is missing.
        ModelError: it is wrong; names file, line and key.
    """
    source = YamlFile(Path("setup"), {}) if path is None else read_yaml(Path(path))
    return Setup(source, source.parse(SetupFile))
