"""The snapshot: a valid PNG that shows both bodies, each in its colour, and marks the point."""

from __future__ import annotations

import struct
import zlib
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from report.checked import crash, near

from gcodesim.findings.codes import Finding
from gcodesim.machine.model import Machine
from gcodesim.report.moment import Moment, nearest, touching
from gcodesim.report.raster import draw_text, png_bytes
from gcodesim.report.snapshot import MARK, snapshot

SIZE = 96


def decoded(png: bytes) -> NDArray[np.uint8]:
    """Pixels of an 8-bit RGB PNG whose rows are filtered by Up; checks every chunk."""
    assert png[:8] == b"\x89PNG\r\n\x1a\n"
    chunks, place = {}, 8
    while place < len(png):
        length, kind = struct.unpack_from(">I4s", png, place)
        body = png[place + 8 : place + 8 + length]
        (check,) = struct.unpack_from(">I", png, place + 8 + length)
        assert check == zlib.crc32(kind + body)
        chunks[kind], place = body, place + 12 + length
    assert list(chunks) == [b"IHDR", b"IDAT", b"IEND"]
    width, height, *rest = struct.unpack(">IIBBBBB", chunks[b"IHDR"])
    assert rest == [8, 2, 0, 0, 0]
    rows = np.frombuffer(zlib.decompress(chunks[b"IDAT"]), np.uint8).reshape(height, -1)
    assert (rows[:, 0] == 2).all()
    return np.cumsum(rows[:, 1:], axis=0, dtype=np.uint8).reshape(height, width, 3)


def halves(**changes: object) -> NDArray[np.float64]:
    """Overview and close-up of the contact, shape (2, size, size, 3)."""
    result, replay = crash()
    assert result.first_contact is not None
    contact = replace(result.first_contact, **changes)
    return drawn(replay.machine, touching(contact))


def drawn(machine: Machine, moment: Moment) -> NDArray[np.float64]:
    """Overview and close-up of a moment, shape (2, size, size, 3)."""
    pixels = decoded(snapshot(machine, moment, "cpu", SIZE)).astype(np.float64)
    assert pixels.shape == (SIZE, 2 * SIZE, 3)
    return np.stack([pixels[:, :SIZE], pixels[:, SIZE:]])


def share(half: NDArray[np.float64], channel: int) -> float:
    """Part of the pixels in which one channel is twice as strong as the opposite one."""
    return float(np.mean(half[..., channel] > 2.0 * half[..., 2 - channel]))


def test_png_is_what_was_drawn(rng: np.random.Generator) -> None:
    pixels = rng.integers(0, 256, (7, 5, 3), dtype=np.uint8)
    assert np.array_equal(decoded(png_bytes(pixels)), pixels)


def test_letters_are_drawn_and_cut_off_at_the_edge() -> None:
    page = np.zeros((9, 10, 3), np.uint8)
    draw_text(page, (1, 1), "T\N{SNOWMAN}", (1, 2, 3), scale=1)
    rows = ["".join("#" if dot[0] else "." for dot in row[1:6]) for row in page[1:8]]
    assert rows == ["#####", *6 * ["..#.."]]
    assert (page[1:8, 7:] == [1, 2, 3]).all(axis=2).any(), "a question mark, as far as it fits"


def test_both_bodies_and_the_point_are_in_the_picture() -> None:
    overview, close = halves()
    assert 0.001 < share(overview, 0) < 0.1
    assert 0.02 < share(overview, 2) < 0.3
    assert share(close, 0) > 0.1
    assert share(close, 2) > 0.2
    middle = SIZE // 2
    ring = close[middle - 8 : middle + 8, middle - 8 : middle + 8]
    yellow = np.argwhere((ring == MARK).all(axis=2)) + 0.5 - 8.0
    assert len(yellow) > 4
    # The ring of the close-up is around its middle, where the point is: its radius is known.
    np.testing.assert_allclose(np.hypot(*yellow.T), 0.028 * SIZE, atol=1.0)


def test_of_a_containment_the_outer_body_is_glass() -> None:
    _, close = halves(point_mm=None, triangles=None)
    opaque = halves()[1]
    assert share(close, 0) > 0.1
    assert share(close, 2) < 0.5 * share(opaque, 2)


def test_a_pair_too_near_is_shown_where_it_is_nearest_with_a_line_across_the_gap() -> None:
    result, replay = near()
    assert isinstance(result.shown, Finding)
    moment = nearest(result.shown, replay, "cpu")
    smallest = next(c for c in result.clearances if c.pair == moment.pair == ("cutter", "C"))
    assert smallest.time_s > result.shown.time_s + 10
    assert np.linalg.norm(moment.points[1] - moment.points[0]) == pytest.approx(
        smallest.minimum_mm, rel=1e-3
    )
    # Both are near the same bottom of the curve, where a thousandth of the distance takes 0.1 s.
    _, line, time_s, *rest = moment.when.split()
    assert rest == ["s", "3.21", "mm", "apart"]
    assert float(time_s) == pytest.approx(smallest.time_s, abs=0.2)
    assert moment.block == replay.lines[int(line) - 1]
    overview, close = drawn(replay.machine, moment)
    assert share(close, 0) > 0.1
    assert share(close, 2) > 0.2
    yellow = np.argwhere((close == MARK).all(axis=2)) + 0.5 - SIZE / 2
    assert np.ptp(yellow, axis=0).max() > 0.05 * SIZE, "a line, not a point"
    np.testing.assert_allclose(yellow.mean(axis=0), 0.0, atol=1.0)
    assert (overview == MARK).all(axis=2).any()


@pytest.mark.parametrize("block", ["", "N10 G1 X0 \N{SNOWMAN}" * 40])
def test_any_block_can_be_written_below_the_time(block: str) -> None:
    assert np.isfinite(halves(block=block, line=0, between_samples=True)).all()
