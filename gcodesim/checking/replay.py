"""Replay: what a picture needs of a check, the bodies, where they ride, and how they move."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import PS_PER_S
from gcodesim.machine.kinematics import transform, world_from_link
from gcodesim.machine.model import Body, Machine, Pair
from gcodesim.machine.spindle import bodies_in_place, table_entry, tool_body
from gcodesim.motion.knots import Knots, reduced
from gcodesim.motion.path import Path
from gcodesim.motion.samples import tool_spans

TOLERANCE = 0.01
"""Deviation of the drawn joints from the checked path [mm or deg]; larger: smaller files."""

MOST_KNOTS = 150_000
"""Knots of a replay: 6 axes take some 8 MB of a page; more only where the tolerance is finer."""


@dataclass(frozen=True)
class Shown:
    """A body and when it is there.

    Attributes:
        spans: stretches of program time (from, to) [s]; None: always.
        title: what people read beside its name, such as the number of a tool.
    """

    body: Body
    spans: tuple[tuple[float, float], ...] | None = None
    title: str = ""


@dataclass(frozen=True)
class Replay:
    """A checked program with its motion.

    Attributes:
        lines: the lines of all texts, one after the other.
        files: name of every text, and the number of lines before it; the main program first.
        clearance: replaced that of every pair [mm]; None: as the machine file says.
    """

    machine: Machine
    path: Path
    lines: Sequence[str] = field(repr=False)
    files: tuple[tuple[str, int], ...]
    clearance: float | None = None

    def clearance_of(self, pair: Pair) -> float:
        """Distance that a pair had to keep [mm]."""
        return pair.clearance if self.clearance is None else self.clearance

    def bodies(self) -> tuple[Shown, ...]:
        """All bodies with a shape, those of tools last."""
        shown = [Shown(body) for body in self.machine.bodies.values() if body.parts]
        return (*shown, *_tools(self.machine, self.path))

    def knots(self) -> Knots:
        """The motion, reduced; a program without motion stands at its start."""
        if len(self.path):
            return reduced(self.path, TOLERANCE, MOST_KNOTS)
        still = [self.machine.start.get(name, 0.0) for name in self.machine.axes]
        return Knots(np.zeros(1), np.array([still]), 0.0)

    def stand(self, time_ps: int) -> tuple[dict[str, float], int | None, int]:
        """How the machine stands at a time: axis letter -> position, the tool, and the line."""
        time = np.array([time_ps])
        axes = zip(self.path.joints, self.path.positions(time)[0].tolist(), strict=True)
        tool = [span.tool for span in tool_spans(self.path) if span.start_ps <= time_ps][-1]
        return dict(axes), tool, int(self.path.line[self.path.piece_at(time)[0]])

    def line_starts(self) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
        """When the source line changes [s], and the line from there on, shape (n,) each."""
        line = self.path.line
        changes = np.flatnonzero(np.diff(line, prepend=-1))
        return self.path.bounds_ps[changes] / PS_PER_S, line[changes]


def _tools(machine: Machine, path: Path) -> list[Shown]:
    """The tools that the program brings into the spindle, each once."""
    *before, last = tool_spans(path)
    stays = [span for span in before if span.end_ps > span.start_ps] + [last]
    bodies = {number: tool_body(machine, number) for number in {span.tool for span in stays}}
    spans: dict[int | None, list[tuple[float, float]]] = {}
    for span in stays:
        # Whatever number has no entry in the table is the tool that is mounted at the start.
        number = span.tool if table_entry(machine, span.tool) else None
        if bodies[span.tool] is not None:
            stretch = (span.start_ps / PS_PER_S, span.end_ps / PS_PER_S)
            spans.setdefault(number, []).append(stretch)
            bodies.setdefault(number, bodies[span.tool])
    return [
        Shown(body, tuple(times), "" if number is None else f"T{number}")
        for number, times in spans.items()
        if (body := bodies[number]) is not None
    ]


def posed(
    machine: Machine, axes: dict[str, float], tool: int | None
) -> dict[str, NDArray[np.float64]]:
    """Triangles of every body in world coordinates, shape (n, 3, 3) [mm].

    Args:
        machine: the machine.
        axes: axis letter -> position [mm or deg].
        tool: number of the tool in the spindle, None before the first change.
    """
    poses = world_from_link(machine, [axes[name] for name in machine.axes])
    return {
        name: transform(poses[body.link], np.concatenate([p.triangles for p in body.parts]))
        for name, body in bodies_in_place(machine, tool).items()
        if body.parts
    }


def indexed(
    triangles: NDArray[np.float64],
) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
    """Corners that differ, shape (m, 3), and the three numbers of every triangle, shape (n, 3)."""
    corners = np.ascontiguousarray(triangles.reshape(-1, 3), dtype="<f4") + np.float32(0.0)
    distinct, number = np.unique(corners.view("V12").ravel(), return_inverse=True)
    vertices = distinct.view("<f4").reshape(-1, 3)
    return vertices, number.reshape(-1, 3).astype("<u4")
