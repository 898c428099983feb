"""One stock on its way through a program: where something that may not cut meets what is left."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from gcodesim.machine.model import Body, Machine, Part
from gcodesim.machine.spindle import table_entry, tool_body
from gcodesim.motion.path import Path
from gcodesim.motion.samples import sample_count, tool_spans
from gcodesim.stock.later_cuts import first_cut
from gcodesim.stock.race import RaceArrays
from gcodesim.stock.raw_stock import solid_arrays
from gcodesim.stock.rounds import RaceAim, RoundsAnswer, Witness, run_rounds
from gcodesim.stock.shapes_of_tools import ToolShape, tool_shape
from gcodesim.stock.time_tree import box_tree, race_arrays
from gcodesim.stock.tool_frames import ToolWay
from gcodesim.stock.tool_items import Items, Near, tool_items

Array = NDArray[np.float64]

SHARES = ((1.0, 4.0), (4.0, 8.0), (16.0, 16.0))
"""The inset is so many times what an item may leave its chord, and half the diagonal of the
smallest beams, in each try. The first decides where bodies keep away; the second, what only
touches; the third, a body that stands anywhere between 0 and the inset deep, too. Where nothing
turns or bends there is nothing to try before the second."""

EVERYWHERE_MM = 1.0e6
"""With nothing left out, what is this far from the stock still counts as near."""

MOST_EVENTS = 100
"""Events of one stock that are listed with --stop all."""

DEPTH_STEPS = 6
"""Halvings between the last depth with a witness and the first without."""


@dataclass(frozen=True)
class StockEvent:
    """A part of a tool in what is left of a stock.

    Attributes:
        sample, time_ps: of the first contact.
        piece: path piece.
        part, tool: what of which tool.
        point: in the frame of the stock's link [mm].
        depth: largest depth in the same block of the program, to a twentieth of it [mm].
        removed: time [ps] and piece at which the point is cut away later; None: never.
    """

    sample: int
    time_ps: int
    piece: int
    part: Part
    tool: int | None
    point: tuple[float, float, float]
    depth: float
    removed: tuple[int, int] | None


@dataclass
class StockAnswer:
    """What the race says about one stock.

    Attributes:
        stock: name of the body.
        inset: tolerance [mm].
        events: in the order of time.
        undecided: beams left open, and their width [mm].
        items, beams: looked at.
        left_out: pieces in which no part of a tool comes near the stock.
        too_many: the inset is too small for this program.
        more_events: there are more than were listed.
    """

    stock: str
    inset: float
    events: list[StockEvent] = field(default_factory=list)
    undecided: int = 0
    width: float = 0.0
    items: int = 0
    beams: int = 0
    left_out: int = 0
    too_many: bool = False
    more_events: bool = False


@dataclass(frozen=True)
class StockTask:
    """How stocks are raced.

    Attributes:
        period_ps: sample period [ps].
        threads: launches side by side on the CPU, 0 for one per core.
        stop_all: list an event of every body and block, not only the first.
        leave_out: leave out what comes nowhere near.
    """

    machine: Machine
    path: Path
    period_ps: int
    device: str
    threads: int = 0
    stop_all: bool = False
    leave_out: bool = True

    @property
    def samples(self) -> int:
        """Number of samples of the path."""
        return sample_count(self.path, self.period_ps)


def race_stock(stock: Body, task: StockTask) -> StockAnswer:
    """Race one stock.

    Raises:
        NotTurnedError: a tool that the race cannot follow.
    """
    return StockRace.of(stock, task).answer()


@dataclass(frozen=True)
class StockRace:
    """A stock with the tools that come to it."""

    stock: Body
    task: StockTask
    way: ToolWay
    tools: NDArray[np.int32]
    shapes: Mapping[int, ToolShape]
    numbers: tuple[int | None, ...]
    near: Near

    @classmethod
    def of(cls, stock: Body, task: StockTask, along: int | None = None) -> StockRace:
        """The race of a stock, by beams along an axis of its link, or along most tools.

        Raises:
            NotTurnedError: a tool that the race cannot follow.
        """
        machine, path = task.machine, task.path
        tools = np.full(len(path), -1, np.int32)
        shapes: dict[int, ToolShape] = {}
        numbers: list[int | None] = []
        for span in tool_spans(path):
            first, end = np.searchsorted(path.bounds_ps, [span.start_ps, span.end_ps]).tolist()
            body = tool_body(machine, span.tool)
            if body is None or first == end:
                continue
            entry = table_entry(machine, span.tool)
            number = entry.number if entry else None
            if number not in numbers:
                shapes[len(numbers)] = tool_shape(body, machine)
                numbers.append(number)
            tools[first:end] = numbers.index(number)
        way = ToolWay(machine, path, stock.link)
        third = _main_axis(way, tools) if along is None else along
        order = (third + 1) % 3, (third + 2) % 3, third
        corners = np.concatenate([part.triangles for part in stock.parts]).reshape(-1, 3)
        box = corners.min(axis=0)[list(order)], corners.max(axis=0)[list(order)]
        if not task.leave_out:
            box = box[0] - EVERYWHERE_MM, box[1] + EVERYWHERE_MM
        near = Near(*box, order, machine.stock_inset)
        return cls(stock, task, way, tools, shapes, tuple(numbers), near)

    @property
    def threads(self) -> int:
        """Launches side by side on the CPU."""
        return self.task.threads or os.cpu_count() or 1

    def answer(self) -> StockAnswer:
        """What is found, first coarsely, then as finely as it needs."""
        inset, device = self.task.machine.stock_inset, self.task.device
        out = StockAnswer(self.stock.name, inset)
        if not self.shapes:
            return out
        last, since = self.task.samples, 0
        # What a try has found stands, whether or not a finer one finds something before it.
        best: tuple[Witness, Items, RaceArrays, RaceAim] | None = None
        for chord, beam in SHARES:
            items, job = self.job(inset / chord)
            out.items, out.left_out = len(items), items.left_out
            if not items.doubt.any() and chord == SHARES[0][0]:
                continue
            aim = RaceAim(inset, inset / 2.0, inset / beam, last)
            # What the try before has proved needs no other.
            late = items.clock[:, 1] > (since - 1) * self.task.period_ps
            job.body_box = self.body_boxes(items, job, late)
            found = run_rounds(job, aim, device, self.threads)
            self._count(out, found)
            since = max(since, min(found.proved, last))
            if found.witness:
                last = min(last, found.witness.sample)
                best = found.witness, items, job, aim
            if not found.undecided or (found.too_many and not found.witness):
                break
        if best:
            self._list_events(out, *best)
        return out

    def _list_events(
        self, out: StockAnswer, witness: Witness | None, items: Items, job: RaceArrays, aim: RaceAim
    ) -> None:
        """Add the event of a witness, and with --stop all what is found after it."""
        job.body_box = self.body_boxes(items, job, np.ones(len(items), np.bool_))
        events = _Events(self, items, job, aim)
        while witness:
            out.events.append(events.made(witness))
            out.more_events = len(out.events) >= MOST_EVENTS
            if not self.task.stop_all or out.more_events:
                break
            events.mute(witness)
            aim = replace(aim, last=self.task.samples)
            found = run_rounds(job, aim, self.task.device, self.threads)
            self._count(out, found)
            witness = found.witness

    def job(self, doubt: float) -> tuple[Items, RaceArrays]:
        """The items and the race, each item off by no more than `doubt` [mm]."""
        task = self.task
        items = tool_items(self.way, self.tools, self.shapes, replace(self.near, doubt=doubt))
        self._mute_unasked(items)
        solid = solid_arrays(self.stock, self.near.order, task.device)
        return items, race_arrays(items, self.shapes, solid, task.path, task.period_ps, task.device)

    def body_boxes(self, items: Items, job: RaceArrays, some: NDArray[np.bool_]) -> Any:
        """The tree of what bodies sweep in some items alone."""
        boxes = items.body_box.copy()
        boxes[~some] = np.tile([np.inf, -np.inf], 3)
        return box_tree(boxes, job.leaves, self.task.device)

    def _mute_unasked(self, items: Items) -> None:
        """Let parts of tools be no bodies where no pair asks for them."""
        machine, name = self.task.machine, self.stock.name
        assert machine.tool is not None
        tool, stock = machine.tool.name, name
        pairs = [p for p in (*machine.pairs, *machine.cutting) if {p.a, p.b} == {tool, stock}]
        asked = [p.parts_a if p.a == tool else p.parts_b for p in pairs]
        if any(parts is None for parts in asked):
            return
        names = {part for parts in asked for part in parts or ()}
        for number, shape in self.shapes.items():
            for i, part in enumerate(shape.parts):
                if part.name not in names and part.role not in names:
                    items.muted[items.tool == number] |= 1 << i

    @staticmethod
    def _count(out: StockAnswer, found: RoundsAnswer) -> None:
        out.beams += found.beams
        out.undecided, out.width, out.too_many = found.undecided, found.width, found.too_many


def _main_axis(way: ToolWay, tools: NDArray[np.int32]) -> int:
    """The axis of the link that most tools stand along."""
    used = np.flatnonzero(tools >= 0)
    _, axes = way.placed(way.path.q1[used])
    return int(np.abs(axes).sum(axis=0).argmax()) if len(used) else 2


@dataclass(frozen=True)
class _Events:
    """Turns witnesses into events: how deep, and what would have removed the point."""

    race: StockRace
    items: Items
    job: RaceArrays
    aim: RaceAim

    def made(self, witness: Witness) -> StockEvent:
        race, items = self.race, self.items
        task, k = race.task, witness.item
        bounds = task.path.bounds_ps
        piece = int(items.piece[k])
        time = min(witness.sample * task.period_ps, int(items.clock[k, 1]))
        shape = race.shapes[int(items.tool[k])]
        later = first_cut(self.job, k, witness.point, task.device)
        removed = None
        if later is not None:
            at, item = later
            removed = at, int(items.piece[item])
        point = np.empty(3)
        point[list(race.near.order)] = witness.point
        return StockEvent(
            witness.sample,
            max(time, int(bounds[piece])),
            piece,
            shape.parts[witness.part],
            race.numbers[int(items.tool[k])],
            (float(point[0]), float(point[1]), float(point[2])),
            self.depth(witness),
            removed,
        )

    def block(self, item: int) -> NDArray[np.bool_]:
        """The items of the same block and tool, around an item."""
        path, items = self.race.task.path, self.items
        line = path.line[items.piece]
        same = (line == line[item]) & (items.tool == items.tool[item])
        others = np.flatnonzero(~same)
        place = np.searchsorted(others, item)
        first = others[place - 1] + 1 if place else 0
        end = others[place] if place < len(others) else len(items)
        inside = np.zeros(len(items), np.bool_)
        inside[first:end] = True
        return inside

    def mute(self, witness: Witness) -> None:
        """Let a part be no body in the block in which it was found."""
        self.items.muted[self.block(witness.item)] |= 1 << witness.part
        self._set_muted(self.items.muted)

    def _set_muted(self, muted: NDArray[np.int32]) -> None:
        self.job.items.muted = wp.array(muted, dtype=wp.int32, device=self.race.task.device)

    def depth(self, witness: Witness) -> float:
        """A depth that the part has in the block, and not a twentieth more [mm]."""
        alone = np.full(len(self.items), -1, np.int32)
        here = self.block(witness.item)
        alone[here] = ~(1 << witness.part)
        self._set_muted(alone)
        everywhere = self.job.body_box
        self.job.body_box = self.race.body_boxes(self.items, self.job, here)
        known = self.aim.witness
        deeper = 2.0 * known
        while self._is_deeper(deeper):
            known, deeper = deeper, 2.0 * deeper
        for _ in range(DEPTH_STEPS):
            middle = (known + deeper) / 2.0
            known, deeper = (middle, deeper) if self._is_deeper(middle) else (known, middle)
        self._set_muted(self.items.muted)
        self.job.body_box = everywhere
        return known

    def _is_deeper(self, depth: float) -> bool:
        race = self.race
        aim = RaceAim(1.05 * depth, depth, depth / 64.0, race.task.samples)
        found = run_rounds(self.job, aim, race.task.device, race.threads)
        return found.witness is not None
