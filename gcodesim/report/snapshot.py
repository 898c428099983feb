"""The snapshot: a picture of the moment that matters, all of the machine and the place itself."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gcodesim.checking.replay import posed
from gcodesim.checking.verdict import FirstContact
from gcodesim.output_file import write_bytes
from gcodesim.report.moment import Moment, nearest, touching
from gcodesim.report.raster import (
    CELL,
    Color,
    Pixels,
    draw_box,
    draw_line,
    draw_ring,
    draw_text,
    png_bytes,
)

if TYPE_CHECKING:
    from gcodesim.checking.verdict import CheckResult
    from gcodesim.collision.views.rays import Grid, Hits
    from gcodesim.machine.model import Machine

Floats = NDArray[np.float64]

SIZE = 640
"""Width and height of either half [pixels]."""

BACKGROUND, GREY, INK, MARK = (250, 250, 248), (150, 155, 160), (30, 30, 35), (255, 190, 0)
PAIR: tuple[Color, Color] = ((214, 50, 44), (38, 100, 210))
"""Colours of the two bodies, as in the replay."""

RING = 0.028
"""Radius of the ring around the place, as a part of the width of the picture."""

GHOST = 0.35
"""How much of its colour a body keeps that stands before, or around, the two."""

AZIMUTHS = (-60, -120, -30, -150, -90, 60, 120, 0, 180)
ELEVATIONS = (30, 10, 55, -15)
"""Directions to look from [deg], the more usual first: the operator stands at -90 degrees."""

CLOSE_PART = 0.25
"""Half the width of the close-up, as a part of the size of the smaller body."""

CLOSE_GAPS, CLOSEST_PART = 6.0, 0.03
"""The same of two bodies that are apart: this many times the gap, but at least this part."""

LIGHT = np.array([0.35, 0.5, 0.79])
"""Where the light comes from: right, above, from the eye; a unit vector."""

EDGE = 0.9
"""Cosine between the normals of neighbouring rays below which an edge is drawn."""

OCTANTS = np.array(list(product((0, 1), repeat=3)))
"""Which of the lowest and highest coordinates make the corners of a box, shape (8, 3)."""

SKETCH = 32
"""Width of the sketches by which the direction is chosen [pixels]."""


@dataclass(frozen=True)
class Camera:
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
        from gcodesim.collision.views.rays import Grid

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
        from gcodesim.collision.views.rays import Target

        self.triangles = np.concatenate([np.zeros((0, 3, 3)), *(t for t, _ in bodies)])
        rows = [np.full((len(t), 3), color, np.float32) for t, color in bodies]
        self.colors = np.concatenate([np.zeros((0, 3), np.float32), *rows])
        edges = self.triangles[:, 1:] - self.triangles[:, :1]
        normals = np.cross(edges[:, 0], edges[:, 1])
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        self.normals = (normals / np.maximum(lengths, np.finfo(float).tiny)).astype(np.float32)
        self.target = Target(self.triangles, device)

    def seen(self, camera: Camera) -> Hits:
        """What the rays of a camera meet."""
        return self.target.first_hits(camera.rays())

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
    """The machine at a moment.

    Attributes:
        solid: the two bodies; where one is inside the other, only the inner one.
        ghosts: all others, drawn as if of glass.
        firsts: number of triangles of the first body in `solid`.
        corners: of boxes around the bodies, shape (n, 3) [mm].
        points: where they touch, or their nearest points, shape (1 or 2, 3) [mm].
        close: half the width of the close-up [mm].
    """

    solid: Surfaces
    ghosts: Surfaces
    firsts: int
    corners: Floats
    points: Floats
    close: float

    @property
    def point(self) -> Floats:
        """The middle of the place."""
        return np.asarray(self.points.mean(axis=0))

    def whole(self, axes: Floats) -> Camera:
        """The camera that sees everything."""
        seen = self.corners @ axes.T
        low, high = seen.min(axis=0), seen.max(axis=0)
        half = 0.55 * float((high - low)[:2].max())
        reach = 2.5 * float(np.linalg.norm(high - low))
        return Camera((low + high) / 2.0 @ axes, axes, half, reach, SIZE)

    def near(self, axes: Floats) -> Camera:
        """The camera that sees the place."""
        camera = self.whole(axes)
        return replace(camera, center=self.point, half=min(self.close, camera.half))


def with_snapshot(result: CheckResult, file: str) -> CheckResult:
    """Write the picture of the first contact, or else of a pair too near; the result then names it.

    Raises:
        OSError: the file cannot be written.
    """
    shown, replay = result.shown, result.replay
    if shown is None or replay is None:
        return result
    if isinstance(shown, FirstContact):
        moment = touching(shown)
    else:
        moment = nearest(shown, replay, result.device)
    write_bytes(file, snapshot(replay.machine, moment, result.device))
    return replace(result, pictures=(*result.pictures, file))


def snapshot(machine: Machine, moment: Moment, device: str, size: int = SIZE) -> bytes:
    """The picture of a moment as PNG: left the machine, right the place.

    Args:
        machine: the machine.
        moment: what is shown.
        device: resolved device name.
        size: height, half of the width [pixels].
    """
    stage = _stage(machine, moment, device)
    axes = _direction(stage)
    cameras = [replace(camera, size=size) for camera in (stage.whole(axes), stage.near(axes))]
    pixels = np.concatenate([_drawn(stage, camera) for camera in cameras], axis=1)
    draw_box(pixels, (size - 1, 0), (2, size), INK)
    _caption(pixels, moment)
    return png_bytes(pixels)


def _stage(machine: Machine, moment: Moment, device: str) -> Stage:
    bodies = posed(machine, moment.axes, moment.tool)
    boxes = {name: _box(triangles) for name, triangles in bodies.items()}
    corners = np.concatenate([box[OCTANTS, np.arange(3)] for box in boxes.values()])
    sizes = [float(np.linalg.norm(boxes[name][1] - boxes[name][0])) for name in moment.pair]
    inner = int(np.argmin(sizes))
    pair = [(bodies.pop(name), color) for name, color in zip(moment.pair, PAIR, strict=True)]
    firsts = len(pair[0][0])
    ghosts = [(triangles, GREY) for triangles in bodies.values()]
    points, close = moment.points, CLOSE_PART * min(sizes)
    if not len(points):
        ghosts.append(pair.pop(1 - inner))
        points, firsts = boxes[moment.pair[inner]].mean(axis=0, keepdims=True), 0
    if len(points) == 2:
        gap = float(np.linalg.norm(points[1] - points[0]))
        close = float(np.clip(CLOSE_GAPS * gap, CLOSEST_PART * min(sizes), close))
    return Stage(Surfaces(pair, device), Surfaces(ghosts, device), firsts, corners, points, close)


def _box(triangles: Floats) -> Floats:
    """Lowest and highest corner, shape (2, 3)."""
    corners = triangles.reshape(-1, 3)
    return np.stack([corners.min(axis=0), corners.max(axis=0)])


def _direction(stage: Stage) -> Floats:
    """Axes of the view that shows most of both bodies around the point, and the point itself.

    A gap is best seen from its side.
    """
    best, chosen = -1.0, np.eye(3)
    gap = stage.points[-1] - stage.points[0]
    along = gap / max(float(np.linalg.norm(gap)), np.finfo(float).tiny)
    for elevation in ELEVATIONS:
        for azimuth in AZIMUTHS:
            axes = _axes(math.radians(azimuth), math.radians(elevation))
            camera = replace(stage.near(axes), size=SKETCH)
            hits = stage.solid.seen(camera)
            met = hits.triangle >= 0
            is_first = met & (hits.triangle < stage.firsts)
            shares = [float(np.mean(is_first)), float(np.mean(met & ~is_first))]
            middle = hits.distance[SKETCH // 2, SKETCH // 2]
            hidden = middle < 0.5 * camera.reach - 0.1 * camera.half
            score = min(shares) + 0.2 * max(shares) - 0.5 * float(hidden)
            score -= 0.3 * abs(float(axes[2] @ along))
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


def _drawn(stage: Stage, camera: Camera) -> Pixels:
    """One half of the picture: surfaces, the point, a scale."""
    fine = replace(camera, size=2 * camera.size)
    solid, ghost = stage.solid.seen(fine), stage.ghosts.seen(fine)
    image = np.full((fine.size, fine.size, 3), BACKGROUND, np.float32)
    met = solid.triangle >= 0
    image[met] = stage.solid.shaded(solid, camera.axes)[met]
    before = (ghost.triangle >= 0) & (ghost.distance < solid.distance)
    image[before] += GHOST * (stage.ghosts.shaded(ghost, camera.axes)[before] - image[before])
    # The mean of four rays a pixel makes the edges smooth.
    mean = image.reshape(camera.size, 2, camera.size, 2, 3).mean(axis=(1, 3))
    pixels: Pixels = np.rint(mean).astype(np.uint8)
    _mark(pixels, camera, stage)
    _scale_bar(pixels, camera)
    return pixels


def _mark(pixels: Pixels, camera: Camera, stage: Stage) -> None:
    """A ring around the place, or a line across a gap that is larger than the ring."""
    ends = [camera.place(point) for point in stage.points]
    if math.dist(ends[0], ends[-1]) < 2.0 * RING * camera.size:
        for radius, color in ((RING - 0.006, INK), (RING, MARK), (RING + 0.006, INK)):
            draw_ring(
                pixels, camera.place(stage.point), radius * camera.size, color, 0.006 * camera.size
            )
    else:
        for width, color in ((0.016, INK), (0.008, MARK)):
            draw_line(pixels, ends[0], ends[-1], color, width * camera.size)


def _scale_bar(pixels: Pixels, camera: Camera) -> None:
    """A bar of a round length at the lower left, up to a quarter of the width."""
    unit = 10.0 ** math.floor(math.log10(camera.half / 2.0))
    length = next(n * unit for n in (5, 2, 1) if n * unit <= camera.half / 2.0)
    edge, scale = _edge_and_scale(camera.size)
    width = round(length / camera.half * camera.size / 2.0)
    _label(pixels, (edge, camera.size - edge - 9 * scale), f"{length:g} mm", INK)
    draw_box(pixels, (edge, camera.size - edge), (width, 2 * scale), INK)


def _caption(pixels: Pixels, moment: Moment) -> None:
    """When and where in the program, on the left; which two, and in which colour, on the right."""
    height = len(pixels)
    edge, scale = _edge_and_scale(height)
    room = (height - 2 * edge) // (CELL * scale)
    for left, texts, colors in (
        (edge, (moment.when, moment.block), (INK, INK)),
        (height + edge, moment.parts, PAIR),
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
