"""Units of meshes: a file that does not say its unit is doubted where only another would do."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gcodesim.constants import UNIT_RATIO
from gcodesim.findings.codes import Finding
from gcodesim.machine.mesh import MM_PER_UNIT
from gcodesim.machine.model import Body, Part


@dataclass(frozen=True)
class MeshRead:
    """A mesh file that was read without a `units` of its own: its part, file and unit."""

    part: Part
    path: Path
    unit: str


def unit_findings(
    read: Sequence[MeshRead], bodies: Sequence[Body], tool: Sequence[Part], travel: float
) -> Iterator[Finding]:
    """Yield GC503 for every mesh that is right in another unit only.

    That is so where it is absurd beside the travel and beside the bodies of its link and the tool
    (all others, where these have none), and another unit makes it right for both. Meshes that are
    as doubtful themselves do not count as bodies to compare with.

    Args:
        read: meshes whose unit nobody stated.
        bodies: of links and setup.
        tool: parts of the mounted tool.
        travel: longest linear travel of the machine [mm]; 0: no linear travel is known.
    """
    doubtful = [mesh.part for mesh in read if travel and not _fits(_size(mesh.part), [travel])]
    sound = [(b.link, p) for b in bodies for p in b.parts if not _among(p, doubtful)]
    of_tool = [part for part in tool if not _among(part, doubtful)]
    told: set[Path] = set()
    for mesh in read:
        link = next((b.link for b in bodies if _among(mesh.part, b.parts)), "")
        near = [*(part for where, part in sound if where == link), *of_tool]
        beside = [part for part in near or [part for _, part in sound] if part is not mesh.part]
        finding = _finding(mesh, [_size(part) for part in beside], travel)
        if finding and mesh.path not in told:
            told.add(mesh.path)
            yield finding


def _among(part: Part, parts: Sequence[Part]) -> bool:
    return any(part is other for other in parts)


def _size(part: Part) -> float:
    """Longest side of its box [mm]."""
    return float(np.ptp(part.triangles.reshape(-1, 3), axis=0).max())


def _finding(mesh: MeshRead, beside: Sequence[float], travel: float) -> Finding | None:
    size = _size(mesh.part)
    if not np.ptp(mesh.part.triangles.reshape(-1, 3), axis=0).all():
        return None  # what is flat is no body in any unit
    compared = [sizes for sizes in ([travel] if travel else [], beside) if sizes]
    if not compared or any(_fits(size, sizes) for sizes in compared):
        return None
    drawn = size / MM_PER_UNIT[mesh.unit]
    right = [
        unit
        for unit, mm in MM_PER_UNIT.items()
        if unit != mesh.unit and all(_fits(drawn * mm, sizes) for sizes in compared)
    ]
    if not right:
        return None
    places = [f"{travel:.4g} mm of travel"] if travel else []
    places += [f"bodies of {min(beside):.4g} to {max(beside):.4g} mm"] if beside else []
    would = " or ".join(f"`units: {u}` makes it {drawn * MM_PER_UNIT[u]:.4g} mm" for u in right)
    text = (
        f"read in {mesh.unit}, the mesh is {size:.4g} mm long beside {' and '.join(places)}; "
        f"{would}: write `units` at this mesh, `units: {mesh.unit}` if it is right"
    )
    return Finding("GC503", text, meaning="mesh_unit", file=str(mesh.path))


def _fits(size: float, others: Sequence[float]) -> bool:
    return min(others) / UNIT_RATIO <= size <= max(others) * UNIT_RATIO
