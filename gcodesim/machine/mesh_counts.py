"""What a mesh file announces is what it must hold: a file cut off in transfer is no mesh."""

from __future__ import annotations

import bz2
import gzip
import io
import zipfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gcodesim.errors import ModelError

READABLE = (".stl", ".obj", ".ply", ".off", ".glb", ".gltf")
ARCHIVES = (".zip", ".gz", ".bz2")

MOST_UNPACKED = 1 << 30
"""Bytes that an archive may unpack to: a mesh of twenty million triangles."""

_CLEAN = "export only what belongs to the mesh"

SIZES = {
    **dict.fromkeys(("char", "uchar", "int8", "uint8"), "i1"),
    **dict.fromkeys(("short", "ushort", "int16", "uint16"), "i2"),
    **dict.fromkeys(("int", "uint", "int32", "uint32", "float", "float32"), "i4"),
    **dict.fromkeys(("double", "float64"), "i8"),
}
"""Types of PLY files, as integers of the same size: counts of a list are integers."""


def refuse_unreadable(path: Path) -> None:
    """Refuse formats without a reader, archives that are too large, and files that are cut off.

    Raises:
        ModelError: names what the file announces and what it holds, or what to do.
        OSError: the file cannot be read.
    """
    suffix = path.suffix.lower()
    if suffix in ARCHIVES:
        _refuse_large_archive(path, suffix)
    elif suffix not in READABLE:
        raise ModelError(
            f"there is no reader for {suffix or 'a file without ending'}: export the mesh as "
            "binary STL, or as OBJ, PLY, OFF or GLB",
            str(path),
        )
    elif suffix in COUNTS:
        COUNTS[suffix](path, path.read_bytes())


def _refuse_large_archive(path: Path, suffix: str) -> None:
    try:
        size = _unpacked(path, suffix)
    except (OSError, EOFError, ValueError, zipfile.BadZipFile) as error:
        raise ModelError(f"the archive cannot be unpacked: {error}", str(path)) from error
    if size > MOST_UNPACKED:
        known = f"{size:,}" if suffix == ".zip" else f"more than {MOST_UNPACKED:,}"
        text = f"the archive unpacks to {known} bytes; at most {MOST_UNPACKED:,} are read"
        raise ModelError(text, str(path))


def _unpacked(path: Path, suffix: str) -> int:
    if suffix == ".zip":
        with zipfile.ZipFile(path) as archive:
            return sum(entry.file_size for entry in archive.infolist())
    size = 0
    with gzip.GzipFile(path) if suffix == ".gz" else bz2.BZ2File(path) as file:
        while size <= MOST_UNPACKED and (block := file.read(1 << 20)):
            size += len(block)
    return size


def _short(path: Path, what: str, announced: int, held: int) -> ModelError:
    text = f"the file announces {announced} {what} and holds {held}: it is cut off or damaged"
    return ModelError(text, str(path))


def _check_off(path: Path, content: bytes) -> None:
    """Header of an OFF file: points and faces, each a line of its own."""
    lines = _lines(content, b"#")
    first = next(lines, b"")
    counts = first.upper().removeprefix(b"COFF").removeprefix(b"OFF").split()
    counts = counts or next(lines, b"").split()
    points, faces = [_whole(count) for count in [*counts, b"", b""][:2]]
    if points is None or faces is None:
        return
    held = list(lines)
    if len(held) < points + faces:
        if len(held) < points:
            raise _short(path, "points", points, len(held))
        raise _short(path, "faces", faces, len(held) - points)
    _refuse_half_a_face(path, held[points : points + faces])


def _lines(content: bytes, comment: bytes) -> Iterator[bytes]:
    """Yield the lines that hold something, without comments."""
    for line in io.BytesIO(content.replace(b"\r", b"\n")):
        if text := line.partition(comment)[0].strip():
            yield text


def _refuse_half_a_face(path: Path, faces: list[bytes]) -> None:
    """A face is a count and so many points; only the last line can be cut off."""
    words = faces[-1].split() if faces else []
    announced = _whole(words[0]) if words else None
    if announced is not None and len(words) <= announced:
        raise _short(path, "points in its last face", announced, len(words) - 1)


def _check_ply(path: Path, content: bytes) -> None:
    """Elements of a PLY file, as lines or as bytes."""
    head, end, body = content.partition(b"end_header")
    body = body.partition(b"\n")[2]
    elements: list[tuple[str, int, list[list[str]]]] = []
    binary = order = ""
    for line in head.decode("latin-1").splitlines() if end else ():
        words = line.split()
        if words[:1] == ["format"] and len(words) > 1:
            binary = words[1]
            order = ">" if "big" in binary else "<"
        elif words[:1] == ["element"] and len(words) > 2:
            count = _whole(words[2].encode(errors="replace"))
            if count is not None:
                elements.append((words[1], count, []))
        elif words[:1] == ["property"] and len(words) > 1 and elements:
            elements[-1][2].append(words[1:])
    if binary == "ascii":
        rows = list(_lines(body, b"\0"))
        for name, count, _ in elements:
            if len(rows) < count:
                raise _short(path, f"elements {name!r}", count, len(rows))
            own, rows = rows[:count], rows[count:]
            if name == "face":
                _refuse_half_a_face(path, own)
        return
    place = 0
    for name, count, properties in elements:
        held, place = _ply_rows(properties, count, body, place, order)
        if held < count:
            raise _short(path, f"elements {name!r}", count, held)


def _ply_rows(
    properties: list[list[str]], count: int, body: bytes, place: int, order: str
) -> tuple[int, int]:
    """How many of `count` binary elements a PLY file holds from a place on, and where they end."""
    types = [[word for word in words[:-1] if word != "list"] for words in properties]
    if not all(0 < len(t) <= 2 and all(word in SIZES for word in t) for t in types):
        return count, place
    sizes = [[np.dtype(order + SIZES[word]) for word in t] for t in types]
    fixed = sum(kinds[0].itemsize for kinds in sizes if len(kinds) == 1)
    if all(len(kinds) == 1 for kinds in sizes):
        return min(count, (len(body) - place) // fixed if fixed else count), place + count * fixed
    for row in range(count):
        for kinds in sizes:
            many = 1
            if len(kinds) == 2:
                if place + kinds[0].itemsize > len(body):
                    return row, place
                many = int(np.frombuffer(body, kinds[0], 1, place)[0]) & 0xFFFFFFFF
                place += kinds[0].itemsize
            place += many * kinds[-1].itemsize
        if place > len(body):
            return row, place
    return count, place


def _check_obj(path: Path, content: bytes) -> None:
    """Points of an OBJ file, and the points that its faces name."""
    points, named = _obj_points(path, content)
    if not len(named):
        return
    if named[-1] > points or named[0] < 1:
        place = int(named[-1] if named[-1] > points else named[0])
        text = f"a face names point {place}, and the file holds {points} points"
        raise ModelError(f"{text}: it is cut off or damaged", str(path))
    if len(named) < points - max(points // 10, 1):
        raise ModelError(f"{_left_over(points, len(named))}: it is cut off, or {_CLEAN}", str(path))


def _obj_points(path: Path, content: bytes) -> tuple[int, NDArray[np.int64]]:
    """How many points an OBJ file holds, and the numbers of those that its faces name, sorted."""
    points = 0
    named: list[int] = []
    for line in _lines(content, b"#"):
        words = line.split()
        if words[0] == b"v":
            points += 1
            if len(words) < 4:
                raise ModelError(f"point {points} has {len(words) - 1} of 3 numbers", str(path))
        elif words[0] == b"f":
            numbers = [_whole(word.partition(b"/")[0].removeprefix(b"-")) for word in words[1:]]
            if len(numbers) < 3 or None in numbers:
                text = f"face {line.decode('latin-1')[:60]!r} does not name three points"
                raise ModelError(text, str(path))
            back = [word.startswith(b"-") for word in words[1:]]
            found = zip(numbers, back, strict=True)
            named += [points + 1 - (n or 0) if from_end else (n or 0) for n, from_end in found]
    return points, np.unique(np.array(named, dtype=np.int64))


def _left_over(points: int, named: int) -> str:
    return f"the file holds {points} points, and its faces name {named} of them"


def refuse_cut_off(path: Path) -> None:
    """Refuse a mesh that is not closed where its file looks as if its end were missing.

    Raises:
        ModelError: says by what, and what to do.
        OSError: the file cannot be read.
    """
    suffix = path.suffix.lower()
    if suffix not in COUNTS:
        return
    content = path.read_bytes()
    if suffix == ".ply" and b"format ascii" not in content[:200]:
        return
    why = "" if content.endswith((b"\n", b"\r")) else "its last line has no end"
    if suffix == ".obj" and not why:
        points, named = _obj_points(path, content)
        why = _left_over(points, len(named)) if 0 < len(named) < points else ""
    if why:
        text = f"the mesh is not closed, and {why}: the file is cut off; if it is whole, {_CLEAN}"
        raise ModelError(f"{text}, or write `shell: true` at the mesh", str(path))


def _whole(word: bytes) -> int | None:
    """A number without sign, None where the word is none or too long to count anything."""
    return int(word) if word.isdigit() and len(word) < 19 else None


COUNTS = {".off": _check_off, ".ply": _check_ply, ".obj": _check_obj}
"""Endings whose files announce what they hold; STL is read by gcodesim itself."""
