"""Machines to begin with, of any layout: which slides and rotary axes carry the work, how far.

Shapes are boxes and cylinders around the axes. At the zero pose the surface of the table is at
Z 0 below the spindle, X and Y are in the middle of their travel, Z is up.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import pairwise

from gcodesim.errors import UsageError
from gcodesim.machine.generic import GenericMachine

DIRECTIONS = {"X": (1, 0, 0), "Y": (0, 1, 0), "Z": (0, 0, 1),
              "A": (1, 0, 0), "B": (0, 1, 0), "C": (0, 0, 1)}  # fmt: skip
SLIDES, TURNS = "XYZ", "ABC"

PLATE, GAP = 50, 10
"""Thickness of slides, and the room between two that pass each other [mm]."""

ABOVE = 150
"""Height of the spindle face above the table at the lower end of Z [mm]."""

PIVOT, FORK = 200, 340
"""Heights above the spindle face: of the axis of a spindle that tilts, and of what carries it."""


@dataclass(frozen=True)
class Layout:
    """What a machine is to be.

    Attributes:
        table: slides that carry the work, the lowest first: "YX".
        rotary: rotary axes of the table, the lower one first: "AC".
        head: rotary axes of the head, the upper one first: "CB".
        travel: of X, Y and Z [mm].
        tilt: limits of the axes that tilt [deg].
    """

    table: str = "YX"
    rotary: str = ""
    head: str = ""
    travel: tuple[float, float, float] = (500.0, 400.0, 400.0)
    tilt: tuple[float, float] = (-110.0, 110.0)

    def __post_init__(self) -> None:
        turns = self.rotary + self.head
        if set(self.table) - set(SLIDES) or len(set(self.table)) < len(self.table):
            raise UsageError(f"--table {self.table}: expected slides, each once: YX, X or Y")
        if "Z" in self.table:
            raise UsageError(f"--table {self.table}: Z carries the spindle here; name X and Y")
        if set(turns) - set(TURNS) or len(set(turns)) < len(turns) or len(turns) > 2:
            raise UsageError(f"rotary axes {turns}: expected up to two of A, B and C, each once")
        if self.rotary[:1] == "C" and len(self.rotary) == 2:
            raise UsageError(f"--rotary {self.rotary}: the axis that tilts comes first: AC or BC")
        if self.head[-1:] == "C":
            raise UsageError(f"--head {self.head}: C turns about the spindle: name A or B last")
        if min(self.travel) <= 0.0 or self.tilt[0] >= self.tilt[1]:
            raise UsageError("--travel needs lengths above 0, --tilt two angles, the lower first")


@dataclass
class _Tree:
    """Links and joints in the making, as lines of YAML."""

    layout: Layout
    links: list[str] = field(default_factory=list)
    joints: list[str] = field(default_factory=list)

    def link(self, name: str, *parts: str) -> None:
        """Add a link of some shapes."""
        named = ", ".join(f"{{name: part{i}, {part}}}" for i, part in enumerate(parts, start=1))
        shape = f"{{{parts[0]}}}" if len(parts) == 1 else f"{{parts: [{named}]}}"
        self.links.append(f"  {name}: {shape}")

    def joint(self, name: str, parent: str, work: bool, height: float = 0.0) -> None:
        """Add a joint; one that carries the work goes against its axis."""
        axis = ", ".join(str(-v if work and v else v) for v in DIRECTIONS[name])
        entry = f"parent: {parent}, child: {name}, axis: [{axis}]"
        if name in SLIDES:
            travel = self.layout.travel[SLIDES.index(name)]
            low, high = (-travel, 0.0) if name == "Z" else (-travel / 2.0, travel / 2.0)
            rates = "rapid: 24000, max_acceleration: 4000"
            self.joints.append(f"  {name}: {{type: linear, {entry}, limits: [{low:g}, {high:g}], "
                               f"{rates}}}")  # fmt: skip
            return
        tilts = not (work and (name == "C" or self.layout.rotary == name))
        limits = (-360.0, 360.0) if name == "C" else self.layout.tilt
        range_ = f"limits: [{limits[0]:g}, {limits[1]:g}]" if tilts else "wrap: shortest"
        self.joints.append(f"  {name}: {{type: rotary, {entry}, point: [0, 0, {height:g}], "
                           f"{range_}, rapid: 9000, max_acceleration: 600}}")  # fmt: skip


def layout_text(layout: Layout, name: str) -> str:
    """A machine file of that layout."""
    tree = _Tree(layout)
    radius = max(round(0.25 * min(layout.travel[:2]) / 5.0) * 5.0, 40.0)
    bottom = _work_side(tree, radius)
    gauge = layout.travel[2] + ABOVE
    _tool_side(tree, gauge)
    _bed(tree, gauge, bottom, radius)
    work = [*layout.table, *layout.rotary]
    axes = "XYZ" + "".join(sorted(layout.rotary + layout.head))
    carried = ", ".join(work) or "the bed"
    title = (
        f"{len(axes)} axes: {carried} carries the work, {', '.join(_head_chain(layout))} the tool"
    )
    lines = ["links:                       # the origin lies on the spindle axis, on the table",
             *tree.links, "", "joints:", *tree.joints, ""]  # fmt: skip
    return GenericMachine(
        title, "\n".join(lines), axes=axes, spindle=_head_chain(layout)[-1],
        work=work[-1] if work else "bed", gauge=round(gauge), surface=0, holder=60, flute=60,
        radius=5,
    ).text(name)  # fmt: skip


def _head_chain(layout: Layout) -> list[str]:
    slides = [letter for letter in "XY" if letter not in layout.table]
    return [*slides, "Z", *layout.head]


def _work_side(tree: _Tree, radius: float) -> float:
    """Table, cradle and slides from the top down; the height below the lowest of them."""
    layout = tree.layout
    chain = ["bed", *layout.table, *layout.rotary]
    for parent, name in pairwise(chain):
        tree.joint(name, parent, work=True)
    below = 0.0
    if len(layout.rotary) == 2:
        across = DIRECTIONS[layout.rotary[0]]
        tree.link(layout.rotary[1], _cylinder(radius, 40.0, -20.0))
        cheek = 1.2 * radius
        sides = [_box(_sized(across, 20.0, radius, 105.0), _at(across, s * cheek, -32.5))
                 for s in (-1, 1)]  # fmt: skip
        tree.link(layout.rotary[0], _box(_sized(across, 2.4 * radius, radius, 40.0), (0, 0, -65.0)),
                  *sides)  # fmt: skip
        below = -math.hypot(85.0, radius / 2.0) - 2.0 * GAP
    elif layout.rotary == "C":
        tree.link("C", _cylinder(radius, 40.0, -20.0))
        below = -40.0 - GAP
    elif layout.rotary:
        axis = ", ".join(map(str, DIRECTIONS[layout.rotary]))
        shape = f"cylinder: {{radius: {radius:g}, height: 60, center: [0, 0, -{radius:g}]"
        tree.link(layout.rotary, f"{shape}, axis: [{axis}]}}")
        tree.joints[-1] = tree.joints[-1].replace("point: [0, 0, 0]", f"point: [0, 0, -{radius:g}]")
        below = -2.0 * radius - GAP
    for number, name in enumerate(reversed(layout.table)):
        size = (2.6 * radius + 100.0 * number, 2.6 * radius + 60.0 * number, PLATE)
        tree.link(name, _box(size, (0, 0, below - PLATE / 2.0)))
        below -= PLATE + GAP
    return below


def _tool_side(tree: _Tree, gauge: float) -> None:
    """Slides above the spindle, the head, and what tilts in it."""
    layout = tree.layout
    chain = ["bed", *_head_chain(layout)]
    for parent, name in pairwise(chain):
        tree.joint(name, parent, work=False, height=gauge + PIVOT)
    foot = gauge + (FORK + 80.0 * (len(layout.head) - 1) if layout.head else 60.0)
    slides = chain[1 : chain.index("Z")]
    for number, name in enumerate(slides):
        height = foot + 300.0 + GAP + (len(slides) - 1 - number) * (PLATE + GAP) + PLATE / 2.0
        tree.link(name, _box((220.0, 220.0, PLATE), (0, 0, height)))
    nose = [] if layout.head else [_cylinder(50.0, 60.0, gauge + 30.0)]
    tree.link("Z", _box((160.0, 160.0, 300.0), (0, 0, foot + 150.0)), *nose)
    if len(layout.head) == 2:
        tree.link(layout.head[0], _cylinder(70.0, 70.0, gauge + FORK + 40.0))
    if layout.head:
        tree.link(layout.head[-1], _box((100.0, 100.0, 180.0), (0, 0, gauge + 150.0)),
                  _cylinder(45.0, 60.0, gauge + 30.0))  # fmt: skip


def _bed(tree: _Tree, gauge: float, bottom: float, radius: float) -> None:
    """A base below the slides, and where slides hang above, a column behind with an arm."""
    layout = tree.layout
    x, y = (1.3 * radius + travel for travel in layout.travel[:2])
    base = _box((2.0 * x, 2.0 * y, PLATE), (0, 0, bottom - PLATE / 2.0))
    back = y + 100.0
    top = gauge + 1000.0
    column = _box((300.0, 160.0, top - bottom), (0, back, (top + bottom) / 2.0))
    tree.links.insert(0, "")
    tree.link("bed", base, column)
    tree.links[0] = tree.links.pop()


def _sized(across: tuple[int, int, int], along: float, other: float, height: float) -> list[float]:
    return [along, other, height] if across[0] else [other, along, height]


def _at(across: tuple[int, int, int], offset: float, height: float) -> list[float]:
    return [offset, 0.0, height] if across[0] else [0.0, offset, height]


def _box(size: tuple[float, ...] | list[float], center: tuple[float, ...] | list[float]) -> str:
    return f"box: {{size: [{_numbers(size)}], center: [{_numbers(center)}]}}"


def _cylinder(radius: float, height: float, middle: float) -> str:
    return f"cylinder: {{radius: {radius:g}, height: {height:g}, center: [0, 0, {middle:g}]}}"


def _numbers(values: tuple[float, ...] | list[float]) -> str:
    return ", ".join(f"{value:g}" for value in values)
