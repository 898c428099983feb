"""The moment that a picture shows: the first contact, or a pair where it is nearest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gcodesim.checking.verdict import FirstContact
from gcodesim.constants import PS_PER_S

if TYPE_CHECKING:
    from gcodesim.checking.replay import Replay
    from gcodesim.findings.codes import Finding


@dataclass(frozen=True)
class Moment:
    """Two bodies at one instant.

    Attributes:
        pair: their names.
        parts: what the caption calls them.
        axes: axis letter -> position [mm or deg].
        tool: number of the tool in the spindle, None before the first change.
        when: where in the program, for the caption.
        block: its text.
        points: where they touch, or the nearest points of the first and the second, (n, 3) [mm];
            none where one is inside the other.
    """

    pair: tuple[str, str]
    parts: tuple[str, str]
    axes: dict[str, float]
    tool: int | None
    when: str
    block: str
    points: NDArray[np.float64]


def touching(contact: FirstContact) -> Moment:
    """The moment of a contact."""
    first, second = zip(contact.pair, contact.parts, strict=True)
    point = contact.point_mm
    when = _when(contact.line, contact.time_s) + " between samples" * contact.between_samples
    return Moment(
        contact.pair,
        (_part_name(*first), _part_name(*second)),
        contact.axes,
        contact.tool,
        when,
        contact.block,
        np.array([] if point is None else [point]).reshape(-1, 3),
    )


def nearest(finding: Finding, replay: Replay, device: str) -> Moment:
    """The moment at which the pair of a finding about a clearance is nearest."""
    from gcodesim.collision.views.distances import nearest_moment

    pair, time_s = finding.pair, finding.time_s
    if pair is None or time_s is None:
        raise ValueError(f"{finding.code} names no pair and time")
    begin_ps = round(time_s * PS_PER_S)
    found = nearest_moment(replay.machine, replay.path, device, pair, begin_ps)
    axes, tool, line = replay.stand(found.time_ps)
    when = f"{_when(line, found.time_ps / PS_PER_S)}   {found.distance:.4g} mm apart"
    block = replay.lines[line - 1].strip() if line else ""
    return Moment(pair, pair, axes, tool, when, block, found.points)


def _when(line: int, time_s: float) -> str:
    return f"{f'line {line}' if line else 'start'}   {time_s:.4f} s"


def _part_name(body: str, part: str) -> str:
    """A part that is not the whole body is named after it."""
    return body if body == part else f"{body} ({part})"
