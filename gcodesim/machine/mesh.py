"""Reads mesh files and judges them: closed, turned outwards, in a believable unit.

Binary STL, the usual case, is read with NumPy: trimesh takes a quarter of a second to import.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import LARGEST_NUMBER, THIN_TRIANGLE, UNIT_RATIO
from gcodesim.errors import ModelError
from gcodesim.findings.codes import Finding

Array = NDArray[np.float64]

MM_PER_UNIT = {"mm": 1.0, "inch": 25.4, "m": 1000.0}

_STL = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_STL_HEADER = 84


@dataclass(frozen=True)
class Mesh:
    """A mesh file in mm.

    Attributes:
        triangles: (n, 3, 3) float64 [mm] in file order, outward oriented when closed.
        closed: every edge joins exactly two triangles that face the same way.
        findings: GC501, GC503, GC504.
    """

    triangles: Array
    closed: bool
    findings: tuple[Finding, ...]


def read_mesh(path: Path, unit: str = "mm", travel: float = 0.0) -> Mesh:
    """Read a mesh file; ModelError when it is missing, unreadable, empty or not finite.

    Args:
        path: the file; its suffix names the format.
        unit: mm | inch | m.
        travel: longest linear travel of the machine [mm] for the test of the unit; 0: no test.
    """
    drawn = _read_triangles(path)
    if not len(drawn):
        raise ModelError("the mesh holds no triangle", str(path))
    triangles = drawn * MM_PER_UNIT[unit]
    sound = (np.abs(triangles) <= LARGEST_NUMBER).all(axis=(1, 2))
    if not sound.all():
        raise ModelError(
            f"triangle {int(np.argmin(sound))} (counted from 0) has a coordinate that is not a "
            f"finite number below {LARGEST_NUMBER:g} mm: export the mesh again",
            str(path),
        )
    corners = merge_corners(drawn)
    open_edges = open_edge_count(corners)
    findings = [_open_finding(path, open_edges), *_repeated(path, corners)] if open_edges else []
    if not open_edges and signed_volume(triangles) < 0.0:
        triangles = triangles[:, [0, 2, 1]]
        text = "all triangles face inwards; they were turned round for the check"
        findings.append(Finding("GC504", text, meaning="mesh_inward", file=str(path)))
    findings += _degenerate_findings(path, triangles, corners)
    findings += _unit_findings(path, triangles, unit, travel)
    return Mesh(triangles, open_edges == 0, tuple(findings))


def _read_triangles(path: Path) -> Array:
    """Triangles as drawn, (n, 3, 3) in the unit of the file."""
    try:
        content = path.read_bytes() if path.suffix.lower() == ".stl" else b""
        path.open("rb").close()
    except OSError as error:
        raise ModelError(f"the mesh cannot be read: {error.strerror}", str(path)) from error
    count = int.from_bytes(content[80:_STL_HEADER], "little")
    if len(content) >= _STL_HEADER and len(content) == _STL_HEADER + count * _STL.itemsize:
        table = np.frombuffer(content, dtype=_STL, offset=_STL_HEADER)
        return table["corners"].astype(np.float64)
    return _read_with_trimesh(path)


def _read_with_trimesh(path: Path) -> Array:
    """Any other format that trimesh reads without extras, in file order."""
    import trimesh  # 0.25 s, and most machines need none of it

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            mesh = trimesh.load_mesh(path, process=False)
        corners = np.asarray(mesh.vertices, dtype=np.float64)
        return corners[np.asarray(mesh.faces, dtype=np.int64).reshape(-1, 3)]
    except Exception as error:  # its readers raise whatever the format's parser met
        reason = " ".join(str(error).split()) or type(error).__name__
        raise ModelError(f"cannot be read as a mesh: {reason}", str(path)) from error


def merge_corners(triangles: Array) -> NDArray[np.int64]:
    """Number of the point at each corner, (n, 3): equal coordinates, equal number."""
    numbers = np.zeros(len(triangles) * 3, dtype=np.int64)
    for column in triangles.reshape(-1, 3).T:
        values, place = np.unique(column, return_inverse=True)
        _, numbers = np.unique(numbers * len(values) + place, return_inverse=True)
    return numbers.reshape(-1, 3)


def open_edge_count(corners: NDArray[np.int64]) -> int:
    """Edges that do not join exactly two triangles facing the same way; 0 for a closed mesh."""
    repeated = (corners == np.roll(corners, 1, axis=1)).any(axis=1)
    kept = corners[~repeated]
    start, end = kept.ravel(), np.roll(kept, -1, axis=1).ravel()
    edge = np.minimum(start, end) * (int(corners.max()) + 1) + np.maximum(start, end)
    edges, number = np.unique(edge, return_inverse=True)
    uses = np.bincount(number, minlength=len(edges))
    balance = np.bincount(number, weights=np.where(start < end, 1.0, -1.0), minlength=len(edges))
    faulty = int(np.count_nonzero((uses != 2) | (balance != 0.0)))
    return faulty if len(kept) else 1  # nothing but points and lines encloses nothing


def signed_volume(triangles: Array) -> float:
    """Volume [mm^3] of a closed mesh, negative when it is turned inwards."""
    local = triangles - triangles.reshape(-1, 3).mean(axis=0)
    return float(np.sum(local[:, 0] * np.cross(local[:, 1], local[:, 2])) / 6.0)


def _open_finding(path: Path, open_edges: int) -> Finding:
    text = (
        f"the mesh is not closed: {open_edges} edges do not join exactly two triangles that face "
        "the same way; surfaces are checked, but whether a body lies inside cannot be decided"
    )
    return Finding("GC501", text, meaning="mesh_open", file=str(path))


def _repeated(path: Path, corners: NDArray[np.int64]) -> list[Finding]:
    """Triangles drawn more than once: only an open mesh has them, for their edges join too many."""
    distinct = len(np.unique(np.sort(corners, axis=1), axis=0))
    if distinct == len(corners):
        return []
    text = (
        f"{len(corners) - distinct} of {len(corners)} triangles have the same corners as another: "
        "each must be drawn once"
    )
    return [Finding("GC504", text, meaning="mesh_repeated", file=str(path))]


def _degenerate_findings(path: Path, triangles: Array, corners: NDArray[np.int64]) -> list[Finding]:
    """A note with the count of triangles that are a line or a point."""
    edges = np.roll(triangles, -1, axis=1) - triangles
    longest = np.max(np.sum(edges * edges, axis=2), axis=1)
    doubled_area = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    repeated = (corners == np.roll(corners, 1, axis=1)).any(axis=1)
    count = int(np.count_nonzero(repeated | (doubled_area <= THIN_TRIANGLE * longest)))
    if not count:
        return []
    text = f"{count} of {len(triangles)} triangles have no area; they are checked as lines"
    return [Finding("GC504", text, meaning="mesh_degenerate", file=str(path), severity="note")]


def _unit_findings(path: Path, triangles: Array, unit: str, travel: float) -> list[Finding]:
    """GC503 when the mesh is far smaller or larger than the machine's travel."""
    points = triangles.reshape(-1, 3)
    size = float(np.max(np.ptp(points, axis=0)))
    if travel == 0.0 or travel / UNIT_RATIO <= size <= travel * UNIT_RATIO:
        return []
    drawn = size / MM_PER_UNIT[unit]
    ratios = {u: abs(np.log(max(drawn, 1e-300) * mm / travel)) for u, mm in MM_PER_UNIT.items()}
    best = min(ratios, key=lambda u: ratios[u])
    fits = ratios[best] <= np.log(UNIT_RATIO)
    advice = f"`units: {best}` would make it {drawn * MM_PER_UNIT[best]:.4g} mm" if fits else (
        "no unit known here (mm, inch, m) would fit"
    )  # fmt: skip
    text = (
        f"read in {unit}, the mesh is {size:.4g} mm long beside {travel:.4g} mm of travel; {advice}"
    )
    return [Finding("GC503", text, meaning="mesh_unit", file=str(path))]
