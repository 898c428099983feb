"""Reads mesh files and judges them: whole, closed, turned outwards.

Binary STL, the usual case, is read with NumPy: trimesh takes a quarter of a second to import.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import LARGEST_NUMBER, THIN_TRIANGLE
from gcodesim.errors import ModelError
from gcodesim.findings.codes import Finding
from gcodesim.input_file import read_bytes, refuse_odd
from gcodesim.machine.mesh_counts import refuse_cut_off, refuse_unreadable
from gcodesim.machine.vericut_model import is_vericut_model, read_vericut_model

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
        findings: GC501, GC504.
    """

    triangles: Array
    closed: bool
    findings: tuple[Finding, ...]


def read_mesh(path: Path, unit: str = "mm", *, shell: bool = False) -> Mesh:
    """Read a mesh file; ModelError when it is missing, cut off, unreadable, empty or not finite.

    Args:
        path: the file; its suffix names the format.
        unit: mm | inch | m.
        shell: it is meant as a surface without an inside, so that it may be open.
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
    if not np.ptp(drawn.reshape(-1, 3), axis=0).any():
        text = f"all corners of its {len(drawn)} triangles are one point: export the mesh again"
        raise ModelError(text, str(path))
    corners = merge_corners(drawn)
    open_edges = open_edge_count(corners)
    if open_edges and not shell:
        refuse_cut_off(path)
    findings = [] if shell or not open_edges else [_open_finding(path, open_edges)]
    findings += _repeated(path, corners) if open_edges else []
    if not open_edges and signed_volume(triangles) < 0.0:
        triangles = triangles[:, [0, 2, 1]]
        text = "all triangles face inwards; they were turned round for the check"
        findings.append(Finding("GC504", text, meaning="mesh_inward", file=str(path)))
    findings += _degenerate_findings(path, triangles, corners)
    return Mesh(triangles, open_edges == 0, tuple(findings))


def _read_triangles(path: Path) -> Array:
    """Triangles as drawn, (n, 3, 3) in the unit of the file."""
    try:
        refuse_odd(path)
        if path.suffix.lower() == ".stl":
            return _read_stl(path, read_bytes(path))
        if is_vericut_model(path):
            return read_vericut_model(path)
        refuse_unreadable(path)
    except OSError as error:
        raise ModelError(f"the mesh cannot be read: {error.strerror}", str(path)) from error
    return _read_with_trimesh(path)


def _read_stl(path: Path, content: bytes) -> Array:
    """Triangles of an STL file, binary or as text; its normals are left to others."""
    count = int.from_bytes(content[80:_STL_HEADER], "little")
    held, rest = divmod(len(content) - _STL_HEADER, _STL.itemsize)
    if len(content) >= _STL_HEADER and (held, rest) == (count, 0):
        table = np.frombuffer(content, dtype=_STL, offset=_STL_HEADER)
        with np.errstate(invalid="ignore"):  # what is no number `read_mesh` refuses
            return table["corners"].astype(np.float64)
    words = content.split() if content.lstrip()[:5].lower() == b"solid" else []
    if b"facet" in words or b"endsolid" in words:
        return _stl_text(path, words)
    if len(content) < _STL_HEADER:
        text = f"an STL file has {_STL_HEADER} bytes before its triangles, and this has only"
        raise ModelError(f"{text} {len(content)}: it is cut off or damaged", str(path))
    more = f" and {rest} bytes" if rest else ""
    raise ModelError(
        f"the file announces {count} triangles and holds {held}{more}: it is cut off or damaged",
        str(path),
    )


def _stl_text(path: Path, words: list[bytes]) -> Array:
    """Triangles of an STL file that is text."""
    begun, ended = words.count(b"facet"), words.count(b"endfacet")
    corners = [i for i, word in enumerate(words) if word == b"vertex"]
    if ended < begun or len(corners) != 3 * begun or b"endsolid" not in words:
        raise ModelError(
            f"the file begins {begun} triangles and holds {min(ended, len(corners) // 3)} up to "
            "its end, where `endsolid` belongs: it is cut off or damaged",
            str(path),
        )
    try:
        numbers = [float(word) for i in corners for word in words[i + 1 : i + 4]]
        return np.array(numbers).reshape(-1, 3, 3)
    except ValueError as error:
        raise ModelError(f"cannot be read as a mesh: {error}", str(path)) from error


def _read_with_trimesh(path: Path) -> Array:
    """Any other format that trimesh reads without extras, in file order."""
    import trimesh  # 0.25 s, and most machines need none of it

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            mesh = trimesh.load_mesh(path, process=False)
        corners = np.asarray(mesh.vertices, dtype=np.float64)
        if corners.ndim != 2 or corners.shape[1] != 3:
            # Lines of more or fewer numbers than three: trimesh puts them side by side.
            raise ValueError(f"its points have {corners.shape[-1]} coordinates, not 3")
        return corners[np.asarray(mesh.faces, dtype=np.int64).reshape(-1, 3)]
    except ImportError as error:
        text = "there is no reader for it here: export the mesh as binary STL"
        raise ModelError(text, str(path)) from error
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
