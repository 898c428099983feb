"""The snapshot: a picture of the first contact, all of the machine and the place itself."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gcodesim.replay import posed
from gcodesim.report.raster import CELL, Color, Pixels, draw_box, draw_ring, draw_text, png_bytes

if TYPE_CHECKING:
    from gcodesim.collision.rays import Grid, Hits
    from gcodesim.machine.model import Machine
    from gcodesim.verdict import FirstContact

Floats = NDArray[np.float64]

SIZE = 640
"""Width and height of either half [pixels]."""

BACKGROUND, GREY, INK, MARK = (250, 250, 248), (150, 155, 160), (30, 30, 35), (255, 190, 0)
PAIR: tuple[Color, Color] = ((214, 50, 44), (38, 100, 210))
"""Colours of the two bodies in contact, as in the replay."""

GHOST = 0.35
"""How much of its colour a body keeps that stands before, or around, the two."""

AZIMUTHS = (-60, -120, -30, -150, -90, 60, 120, 0, 180)
ELEVATIONS = (30, 10, 55, -15)
"""Directions to look from [deg], the more usual first: the operator stands at -90 degrees."""

CLOSE_PART = 0.25
"""Half the width of the close-up, as a part of the size of the smaller body."""

LIGHT = np.array([0.35, 0.5, 0.79])
"""Where the light comes from: right, above, from the eye; a unit vector."""

EDGE = 0.9
"""Cosine between the normals of neighbouring rays below which an edge is drawn."""

OCTANTS = np.array(list(product((0, 1), repeat=3)))
"""Which of the lowest and highest coordinates make the corners of a box, shape (8, 3)."""

SKETCH = 32
"""Width of the sketches by which the direction is chosen [pixels]."""


@dataclass(frozen=True)
class View:
    """Where a picture is taken from: parallel rays, so that sizes can be compared.

    Attributes:
        center: in the middle of the picture [mm].
        axes: rows: to the right, upwards, towards the eye; unit vectors.
        half: half the width of the picture [mm].
        reach: from the eye to the far end of the scene [mm].
        size: width and height [pixels].
    """

    center: Floats
    axes: Floats
    half: float
    reach: float
    size: int

    def rays(self) -> Grid:
        """The rays through the middles of the pixels."""
        from gcodesim.collision.rays import Grid

        right, up, towards = self.axes
        step = 2.0 * self.half / self.size
        corner = self.center + 0.5 * self.reach * towards + (self.half - step / 2.0) * (up - right)
        return Grid(corner, step * right, -step * up, -towards, self.reach, self.size)

    def place(self, point: Floats) -> tuple[float, float]:
        """Column and row of a point."""
        x, y, _ = self.axes @ (point - self.center) / self.half
        return float(x + 1.0) * self.size / 2.0, float(1.0 - y) * self.size / 2.0


class Surfaces:
    """Bodies of one colour each, laid out as one list of triangles."""

    def __init__(self, bodies: list[tuple[Floats, Color]], device: str) -> None:
        from gcodesim.collision.rays import Target

        self.triangles = np.concatenate([np.zeros((0, 3, 3)), *(t for t, _ in bodies)])
        rows = [np.full((len(t), 3), color, np.float32) for t, color in bodies]
        self.colors = np.concatenate([np.zeros((0, 3), np.float32), *rows])
        edges = self.triangles[:, 1:] - self.triangles[:, :1]
        normals = np.cross(edges[:, 0], edges[:, 1])
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        self.normals = (normals / np.maximum(lengths, np.finfo(float).tiny)).astype(np.float32)
        self.target = Target(self.triangles, device)

    def seen(self, view: View) -> Hits:
        """What the rays of a view meet."""
        return self.target.first_hits(view.rays())

    def shaded(self, hits: Hits, axes: Floats) -> NDArray[np.float32]:
        """Colour of every ray, darker where the surface turns away and where it breaks."""
        if not len(self.triangles):
            return np.zeros((*hits.triangle.shape, 3), np.float32)
        towards = self.normals * np.where(self.normals @ axes[2] < 0.0, -1, 1)[:, None]
        light = np.clip(towards @ (LIGHT @ axes), 0.0, 1.0)
        # Row -1, where nothing is met, is painted over.
        shaded = (self.colors * (0.45 + 0.55 * light)[:, None]).astype(np.float32)[hits.triangle]
        normal = towards.astype(np.float32)[hits.triangle]
        breaks = np.zeros(hits.triangle.shape, bool)
        breaks[1:] |= np.einsum("ijk,ijk->ij", normal[1:], normal[:-1]) < EDGE
        breaks[:, 1:] |= np.einsum("ijk,ijk->ij", normal[:, 1:], normal[:, :-1]) < EDGE
        shaded[breaks] *= 0.6
        return shaded


@dataclass(frozen=True)
class Stage:
    """The machine at the moment of the contact.

    Attributes:
        solid: the two bodies; where one is inside the other, only the inner one.
        ghosts: all others, drawn as if of glass.
        firsts: number of triangles of the first body in `solid`.
        corners: of boxes around the bodies, shape (n, 3) [mm].
        point: where they touch [mm].
        close: half the width of the close-up [mm].
    """

    solid: Surfaces
    ghosts: Surfaces
    firsts: int
    corners: Floats
    point: Floats
    close: float

    def whole(self, axes: Floats) -> View:
        """The view of everything."""
        seen = self.corners @ axes.T
        low, high = seen.min(axis=0), seen.max(axis=0)
        half = 0.55 * float((high - low)[:2].max())
        reach = 2.5 * float(np.linalg.norm(high - low))
        return View((low + high) / 2.0 @ axes, axes, half, reach, SIZE)

    def near(self, axes: Floats) -> View:
        """The view of the place of contact."""
        view = self.whole(axes)
        return replace(view, center=self.point, half=min(self.close, view.half))


def snapshot(machine: Machine, contact: FirstContact, device: str, size: int = SIZE) -> bytes:
    """The picture of a contact as PNG: left the machine, right the place of contact.

    Args:
        machine: the machine.
        contact: what is shown.
        device: resolved device name.
        size: height, half of the width [pixels].
    """
    stage = _stage(machine, contact, device)
    axes = _direction(stage)
    views = [replace(view, size=size) for view in (stage.whole(axes), stage.near(axes))]
    pixels = np.concatenate([_drawn(stage, view) for view in views], axis=1)
    draw_box(pixels, (size - 1, 0), (2, size), INK)
    _caption(pixels, contact)
    return png_bytes(pixels)


def _stage(machine: Machine, contact: FirstContact, device: str) -> Stage:
    bodies = posed(machine, contact.axes, contact.tool)
    boxes = {name: _box(triangles) for name, triangles in bodies.items()}
    corners = np.concatenate([box[OCTANTS, np.arange(3)] for box in boxes.values()])
    sizes = [float(np.linalg.norm(boxes[name][1] - boxes[name][0])) for name in contact.pair]
    inner = int(np.argmin(sizes))
    pair = [(bodies.pop(name), color) for name, color in zip(contact.pair, PAIR, strict=True)]
    firsts = len(pair[0][0])
    ghosts = [(triangles, GREY) for triangles in bodies.values()]
    if contact.point_mm is None:
        ghosts.append(pair.pop(1 - inner))
        point, firsts = boxes[contact.pair[inner]].mean(axis=0), 0
    else:
        point = np.array(contact.point_mm)
    close = CLOSE_PART * min(sizes)
    return Stage(Surfaces(pair, device), Surfaces(ghosts, device), firsts, corners, point, close)


def _box(triangles: Floats) -> Floats:
    """Lowest and highest corner, shape (2, 3)."""
    corners = triangles.reshape(-1, 3)
    return np.stack([corners.min(axis=0), corners.max(axis=0)])


def _direction(stage: Stage) -> Floats:
    """Axes of the view that shows most of both bodies around the point, and the point itself."""
    best, chosen = -1.0, np.eye(3)
    for elevation in ELEVATIONS:
        for azimuth in AZIMUTHS:
            axes = _axes(math.radians(azimuth), math.radians(elevation))
            view = replace(stage.near(axes), size=SKETCH)
            hits = stage.solid.seen(view)
            met = hits.triangle >= 0
            is_first = met & (hits.triangle < stage.firsts)
            shares = [float(np.mean(is_first)), float(np.mean(met & ~is_first))]
            middle = hits.distance[SKETCH // 2, SKETCH // 2]
            hidden = middle < 0.5 * view.reach - 0.1 * view.half
            score = min(shares) + 0.2 * max(shares) - 0.5 * float(hidden)
            # A direction that people know wins unless another shows clearly more.
            if score > best + 0.02:
                best, chosen = score, axes
    return chosen


def _axes(azimuth: float, elevation: float) -> Floats:
    """Rows: to the right, upwards, towards the eye; Z is up."""
    flat = np.array([math.cos(azimuth), math.sin(azimuth), 0.0])
    towards = math.cos(elevation) * flat + math.sin(elevation) * np.array([0.0, 0.0, 1.0])
    right = np.cross([0.0, 0.0, 1.0], flat)
    return np.stack([right, np.cross(towards, right), towards])


def _drawn(stage: Stage, view: View) -> Pixels:
    """One half of the picture: surfaces, the point, a scale."""
    fine = replace(view, size=2 * view.size)
    solid, ghost = stage.solid.seen(fine), stage.ghosts.seen(fine)
    image = np.full((fine.size, fine.size, 3), BACKGROUND, np.float32)
    met = solid.triangle >= 0
    image[met] = stage.solid.shaded(solid, view.axes)[met]
    before = (ghost.triangle >= 0) & (ghost.distance < solid.distance)
    image[before] += GHOST * (stage.ghosts.shaded(ghost, view.axes)[before] - image[before])
    # The mean of four rays a pixel makes the edges smooth.
    mean = image.reshape(view.size, 2, view.size, 2, 3).mean(axis=(1, 3))
    pixels: Pixels = np.rint(mean).astype(np.uint8)
    for radius, color in ((0.022, INK), (0.028, MARK), (0.034, INK)):
        draw_ring(pixels, view.place(stage.point), radius * view.size, color, 0.006 * view.size)
    _scale_bar(pixels, view)
    return pixels


def _scale_bar(pixels: Pixels, view: View) -> None:
    """A bar of a round length at the lower left, up to a quarter of the width."""
    unit = 10.0 ** math.floor(math.log10(view.half / 2.0))
    length = next(n * unit for n in (5, 2, 1) if n * unit <= view.half / 2.0)
    edge, scale = _edge_and_scale(view.size)
    width = round(length / view.half * view.size / 2.0)
    _label(pixels, (edge, view.size - edge - 9 * scale), f"{length:g} mm", INK)
    draw_box(pixels, (edge, view.size - edge), (width, 2 * scale), INK)


def _caption(pixels: Pixels, contact: FirstContact) -> None:
    """When and where in the program, on the left; who touches whom, in which colour, on the right.

    A part that is not the whole body is named after it.
    """
    height = len(pixels)
    edge, scale = _edge_and_scale(height)
    room = (height - 2 * edge) // (CELL * scale)
    between = " between samples" if contact.between_samples else ""
    where = f"line {contact.line}" if contact.line else "start"
    when = f"{where}   {contact.time_s:.4f} s{between}"
    both = zip(contact.pair, contact.parts, strict=True)
    first, second = (body if body == part else f"{body} ({part})" for body, part in both)
    for left, texts, colors in (
        (edge, (when, contact.block), (INK, INK)),
        (height + edge, (first, second), PAIR),
    ):
        for row, (text, color) in enumerate(zip(texts, colors, strict=True)):
            _label(pixels, (left, edge + 12 * scale * row), text[:room], color)


def _label(pixels: Pixels, corner: tuple[int, int], text: str, color: Color) -> None:
    """A line of text on paper of its own."""
    _, scale = _edge_and_scale(len(pixels))
    left, top = corner
    paper = ((CELL * len(text) + 1) * scale, 11 * scale)
    if text:
        draw_box(pixels, (left - scale, top - 2 * scale), paper, BACKGROUND)
    draw_text(pixels, corner, text, color, scale)


def _edge_and_scale(height: int) -> tuple[int, int]:
    """Width of the margin, and pixels per dot of a letter."""
    return height // 40, max(height // 320, 1)
