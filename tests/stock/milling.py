"""Small machines with a stock, tools of any profile, and programs for them."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path as File

import numpy as np

from gcodesim.constants import DEFAULT_PERIOD_PS
from gcodesim.machine import shapes
from gcodesim.machine.control_data import control_for
from gcodesim.machine.loading import load_machine
from gcodesim.machine.model import Machine, Part, Tool, Turned
from gcodesim.motion.path import Path
from gcodesim.motion.planner import plan
from gcodesim.nc.interpret import interpret
from gcodesim.stock.workpiece import StockAnswer, StockTask, race_stock

MILL = """\
name: mill
verified: true
links: {bed: {}, X: {}, Y: {}, C: {}, Z: {}, B: {}}
joints:
  X: {type: linear, parent: bed, child: X, axis: [-1, 0, 0], limits: [-2000, 2000], rapid: 24000}
  Y: {type: linear, parent: X, child: Y, axis: [0, -1, 0], limits: [-2000, 2000], rapid: 24000}
  C: {type: rotary, parent: Y, child: C, axis: [0, 0, 1], point: [50, 50, 0], rapid: 7200}
  Z: {type: linear, parent: bed, child: Z, axis: [0, 0, 1], limits: [-2000, 2000], rapid: 24000}
  B: {type: rotary, parent: Z, child: B, axis: [0, 1, 0], point: [0, 0, 30], rapid: 7200}
tool: {link: B, gauge_point: [0, 0, 0], axis: [0, 0, 1]}
work: {link: C, offsets: {G54: {}}}
start: {Z: 400}
path_tolerance: {G64: 0, rapid: 0}
"""
"""The table goes by X, Y and turns by C, about (50, 50); the head goes by Z and tilts by B, about a
point 30 above the gauge point."""

BLANK = "box: {size: [100, 100, 50], center: [50, 50, -25]}"
Points = Sequence[tuple[float, float]]


def turned_part(role: str, profile: Points, ball: tuple[float, float] | None = None) -> Part:
    """A part of a tool by points (r, z), z from the gauge point down to the tip, negative."""
    points = [(float(r), float(z)) for r, z in profile]
    points = points if points[0][1] <= points[-1][1] else points[::-1]
    if ball:
        angles = np.radians(np.arange(-90, 0, 5))
        arc = zip(ball[1] * np.cos(angles), ball[0] + ball[1] * np.sin(angles), strict=True)
        points = [*((float(r), float(z)) for r, z in arc), *points]
    shape = Turned(tuple(points), tuple(points), ball)
    return Part(role, shapes.revolve(points), True, role, "test", turned=shape)


def cutter(number: int, length: float, *parts: tuple[str, Points]) -> Tool:
    """A tool of turned parts, whose points (r, z) count z from the tip up."""
    made = tuple(turned_part(role, [(r, z - length) for r, z in p]) for role, p in parts)
    return Tool(number, "", length, 0.0, (0.0, 0.0, length, 0.0, 0.0, 0.0), made)


def end_mill(
    radius: float = 5.0, flute: float = 20.0, shank: float = 5.0, stick: float = 60.0,
    holder: float = 20.0, number: int = 1,
) -> Tool:  # fmt: skip
    """An end mill: its holder begins `stick` above the tip."""
    return cutter(
        number,
        stick + 40.0,
        ("flute", [(radius, 0.0), (radius, flute)]),
        ("shank", [(shank, flute), (shank, stick)]),
        ("holder", [(holder, stick), (holder, stick + 40.0)]),
    )


def ball_mill(
    radius: float = 5.0, flute: float = 20.0, shank: float = 5.0, stick: float = 60.0,
    holder: float = 20.0, number: int = 1,
) -> Tool:  # fmt: skip
    """A ball end mill."""
    length = stick + 40.0
    points = [(radius, radius - length), (radius, flute - length)]
    flutes = turned_part("flute", points, (radius - length, radius))
    other = end_mill(radius, flute, shank, stick, holder, number)
    return replace(other, parts=(flutes, *other.parts[1:]))


def drill(radius: float = 5.0, flute: float = 40.0, stick: float = 60.0, number: int = 1) -> Tool:
    """A twist drill of 118 degrees, its shank as thick as its flute."""
    tip = radius / float(np.tan(np.radians(59.0)))
    other = end_mill(radius, flute, radius, stick, 15.0, number)
    flutes = cutter(number, stick + 40.0, ("flute", [(0.0, 0.0), (radius, tip), (radius, flute)]))
    return replace(other, parts=(flutes.parts[0], *other.parts[1:]))


def mill(*tools: Tool, blanks: str = BLANK, inset: float = 0.05, machine: str = MILL) -> Machine:
    """The mill with tools and one stock `blank`, or several by lines of YAML."""
    bodies = blanks if "link:" in blanks else f"blank: {{link: C, role: stock, {blanks}}}"
    table = "tools:\n" + "".join(
        f"  - {{number: {tool.number}, length: 100, flute: {{diameter: 1, length: 1}},"
        " holder: [[5, 0], [5, 99]]}\n"
        for tool in tools
    )
    with tempfile.TemporaryDirectory() as folder:
        for name, text in (("m", machine), ("t", table)):
            (File(folder) / f"{name}.yaml").write_text(text, encoding="utf-8")
        setup = f"tools: t.yaml\nstock_check: {{inset: {inset}}}\nbodies:\n"
        setup += "".join(f"  {line}\n" for line in bodies.splitlines())
        (File(folder) / "s.yaml").write_text(setup, encoding="utf-8")
        loaded = load_machine(f"{folder}/m.yaml", setup=f"{folder}/s.yaml")
    return replace(loaded, tools={tool.number: tool for tool in tools})


@dataclass
class Program:
    """An NC program, block by block."""

    blocks: list[str] = field(
        default_factory=lambda: ["G21 G90 G94 G17", "T1 M6", "S5000 M3", "G43 H1"]
    )
    at: tuple[float, ...] = (0.0, 0.0, 400.0)

    def move(self, *to: float, feed: float | None = None) -> Program:
        """To X Y Z (B C), as a rapid where no feed [mm/min] is given."""
        words = " ".join(f"{a}{v:.4f}" for a, v in zip("XYZBC", to, strict=False))
        return self.say(f"G0 {words}" if feed is None else f"G1 F{feed:g} {words}", to)

    def say(self, block: str, at: tuple[float, ...] | None = None) -> Program:
        """A block as it stands."""
        self.blocks.append(block)
        self.at = at or self.at
        return self

    @property
    def text(self) -> str:
        """All of it."""
        return "\n".join([*self.blocks, "M30", ""])


def path_of(program: Program, machine: Machine) -> Path:
    """The path of a program."""
    meaning = interpret(program.text, control_for(machine, None, None, False), "p.nc")
    assert not meaning.findings or all(f.code == "GC430" for f in meaning.findings)
    return plan(meaning.program, machine)[0]


def raced(
    program: Program, machine: Machine, *, stock: str = "blank", threads: int = 2,
    stop_all: bool = False, leave_out: bool = True, device: str = "cpu",
) -> StockAnswer:  # fmt: skip
    """The answer of the race for one stock."""
    path = path_of(program, machine)
    task = StockTask(machine, path, DEFAULT_PERIOD_PS, device, threads, stop_all, leave_out)
    return race_stock(machine.bodies[stock], task)


def roughing(layers: int = 16, feed: float = 2000.0) -> Program:
    """A pocket 90 x 90 in the blank: zigzag, layers of 2.5 mm, then along the wall."""
    program = Program().move(9.9, 9.9, 5)
    for layer in range(layers):
        z = -2.5 * (layer + 1)
        program.move(10, 10, 5).move(10, 10, z + 2.6).move(10, 10, z, feed=500)
        for j, y in enumerate(np.linspace(10, 90, 15).tolist()):
            if j:
                program.move(program.at[0], y, z, feed=feed)
            program.move(10 if j % 2 else 90, y, z, feed=feed)
        for x, y in ((90, 90), (10, 90), (10, 10), (90, 10)):
            program.move(x, y, z, feed=feed)
        program.move(90, 10, 5)
    return program


def boss(cut_before: bool) -> Program:
    """Two slots, and a rapid between them through a wall that is cut before, or after."""
    program = Program().move(20, 20, 5).move(20, 20, -5, feed=300).move(20, 80, -5, feed=1000)
    program.move(20, 80, 5).move(50, 20, 5).move(50, 20, -5, feed=300)
    program.move(50, 80, -5, feed=1000).move(50, 80, 5)

    def wall() -> None:
        program.move(20, 50, 5).move(20, 50, -5, feed=300).move(50, 50, -5, feed=1000)
        program.move(50, 50, 5)

    if cut_before:
        wall()
    program.move(20, 50, 5).move(20, 50, -3).move(50, 50, -3).move(50, 50, 5)
    if not cut_before:
        wall()
    return program


def last_pass(depth: float) -> Program:
    """A slot in four passes: the holder reaches over the wall only in the last one."""
    program = Program().move(50, 50, 5)
    for z in (-6, -12, -18, -depth):
        program.move(30, 50, 5).move(30, 50, z + 6.6).move(30, 50, z, feed=300)
        program.move(70, 50, z, feed=1000).move(70, 50, 5)
    return program


def slot(depth: float = 5.0) -> Program:
    """A slot from X20 to X80, and the tool at its end."""
    program = Program().move(20, 50, 5).move(20, 50, -depth, feed=300)
    return program.move(80, 50, -depth, feed=1000)
