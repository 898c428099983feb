"""Canned cycles: every hole expanded into the moves the control makes (nc-language section 7)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from gcodesim.constants import SAME_LEVEL_MM
from gcodesim.nc.control.arcs import CENTRE_WORDS
from gcodesim.nc.control.state import State
from gcodesim.nc.iso.block import Block
from gcodesim.nc.iso.modes import dwell_seconds
from gcodesim.nc.iso.motion import feed_of, move, plane_target
from gcodesim.nc.program import AXES, PLANES, Kind

END_OF_MOTION = 800
MACHINE_COORDINATES = 530

MAX_STEPS = 100_000
"""Holes of a block, or pecks of a hole, above which a block is refused: it would fill memory."""

NEEDED = {
    **dict.fromkeys((730, 830), "Q"),
    **dict.fromkeys((740, 760, 810, 820, 840, 850, 860, 870, 880, 890), ""),
}
"""Cycle -> words it cannot do without, besides R and the depth."""

KEPT = "RQPIJ"
"""Words a cycle keeps for its next holes, besides the depth; K and L count holes of one block."""


SHIFTS = {"+X": (1.0, 0.0), "-X": (-1.0, 0.0), "+Y": (0.0, 1.0), "-Y": (0.0, -1.0)}
"""Control.bore_shift -> way along the two axes of the plane."""


@dataclass(slots=True)
class Hole:
    """One hole being made; levels are program values of the depth axis [mm].

    Attributes:
        w: index of the depth axis.
        r, z: R level and bottom.
        initial: depth-axis value when the cycle became modal.
        q: peck depth or shift [mm], 0 when not given.
        seconds: dwell at the bottom.
    """

    state: State
    block: Block
    w: int
    r: float
    z: float
    initial: float
    q: float
    seconds: float

    @property
    def out(self) -> float:
        """Level the hole is left to: G98 the initial one, G99 R."""
        return max(self.initial, self.r) if self.state.modal.cycle_return == 980 else self.r

    def rapid(self, level: float) -> None:
        """Rapid the depth axis to a level."""
        self._go(Kind.RAPID, level)

    def feed(self, level: float) -> None:
        """Feed the depth axis to a level."""
        self._go(Kind.FEED, level)

    def shift(self, u: float, v: float) -> None:
        """Rapid sideways in the plane by (u, v) [mm]."""
        state = self.state
        i, j, _ = PLANES[state.modal.plane]
        point = state.point.copy()
        point[i], point[j] = point[i] + u, point[j] + v
        _rapid(state, self.block, point)

    def dwell(self) -> None:
        """Stand still at the bottom."""
        if self.seconds:
            self.state.recorder.add(Kind.DWELL, self.block.row, f=self.seconds)

    def _go(self, kind: Kind, level: float) -> None:
        state = self.state
        point = state.point.copy()
        point[self.w] = level
        f = feed_of(state, self.block) if kind == Kind.FEED else 0.0
        move(state, self.block, kind, state.reach(point), f)
        state.point = point


AnyHole = TypeVar("AnyHole", bound=Hole)


def run_cycle(state: State, block: Block, number: int) -> None:
    """G73 G74 G76 G81-G89: keep the words, and make a hole at every position of the block."""
    if block.has("G", MACHINE_COORDINATES):
        raise block.error("axis_without_motion", "G53 in a cycle", "G53")
    modal = state.modal
    if not modal.cycle:
        modal.cycle_words = {}
        modal.initial = state.point[PLANES[modal.plane][2]]
    if modal.cycle != number:
        modal.cycle_words = {k: v for k, v in modal.cycle_words.items() if k in "RZ"}
    modal.cycle = number
    if state.control.dialect.g80 == "motion":
        modal.motion = END_OF_MOTION
    _keep_words(state, block)
    repeats = _repeats(state, block, number)
    if not block.moves or not repeats:
        return
    check_words(state, block, number)
    state.holes += repeats
    for _ in range(repeats):
        _make_hole(state, block, number)


def _keep_words(state: State, block: Block) -> None:
    """Keep lengths in mm and the dwell in seconds, as they were meant when they were read."""
    modal, values = state.modal, block.values
    depth = AXES[PLANES[modal.plane][2]]
    if rotary := next((letter for letter in "ABC" if letter in values), ""):
        raise block.error("rotary_in_cycle", f"{rotary} in a cycle block", rotary)
    for letter in KEPT:
        if letter in values:
            modal.cycle_words[letter] = values[letter] * state.scale
    if "P" in values:
        modal.cycle_words["P"] = dwell_seconds(state, block, "P")
    if depth in values:
        modal.cycle_words["Z"] = values[depth] * state.scale
    if modal.cycle == 870 and state.control.dialect.g87 == "centre" and "K" in values:
        modal.cycle_words["K"] = values["K"] * state.scale


def _repeats(state: State, block: Block, number: int) -> int:
    """Return how many holes L or K of this block asks for."""
    centred = number == 870 and state.control.dialect.g87 == "centre"
    letter = "L" if "L" in block.values else "K" if "K" in block.values and not centred else ""
    repeats = block.whole(letter) if letter else 1
    if repeats > MAX_STEPS:
        raise block.error("cycle_too_long", f"{repeats} holes", letter)
    return repeats


def check_words(state: State, block: Block, number: int) -> None:
    """Check that the cycle has what it needs for a hole.

    Raises:
        ProgramError: it has not.
    """
    modal = state.modal
    words, code = modal.cycle_words, f"G{number // 10}"
    depth = AXES[PLANES[modal.plane][2]]
    centred = number == 870 and state.control.dialect.g87 == "centre"
    needed = "ZR" + NEEDED[number] + ("Q" if number in (760, 870) and not centred else "")
    for letter in needed + (CENTRE_WORDS[PLANES[modal.plane][2]] if centred else ""):
        if letter not in words:
            name = depth if letter == "Z" else letter
            raise block.error("cycle_word_missing", f"{code} without {name}", code)
    if words.get("Q", 1.0) <= 0 and (number in (730, 830) or "Q" in needed):
        raise block.error("cycle_q_not_positive", f"{code} with Q{words['Q']:g}", "Q")
    if number == 820 and "P" not in words:
        state.report(block.finding("cycle_dwell_missing", "G82 without P", "G82"))
    if number in (740, 840) and modal.spindle not in (30, 40) and not modal.rigid_tapping:
        raise block.error("tapping_no_spindle", f"{code} with the spindle off", code)
    if number == 870 and not centred and modal.cycle_return == 990:
        raise block.error("cycle_return_unusable", "G87 under G99", code)


def _make_hole(state: State, block: Block, number: int) -> None:
    """Go to the hole above the work, then through the steps of the cycle."""
    hole = new_hole(Hole, state, block, number)
    back_boring = _is_shifted(state, number)
    if not back_boring and state.point[hole.w] < hole.r:
        hole.rapid(hole.r)
    _rapid(state, block, plane_target(state, block))
    if not back_boring:
        hole.rapid(hole.r)
    STEPS[number](hole)


def new_hole(make: type[AnyHole], state: State, block: Block, number: int) -> AnyHole:
    """Return the hole that the words of the active cycle describe.

    Raises:
        ProgramError: its bottom lies above its R level.
    """
    modal, words = state.modal, state.modal.cycle_words
    incremental = modal.distance == 910
    r = modal.initial + words["R"] if incremental else words["R"]
    z = r + words["Z"] if incremental else words["Z"]
    if z > r and not _is_shifted(state, number):
        raise block.error("cycle_r_below_z", f"bottom {z:g} mm, R level {r:g} mm", "R")
    w, q, seconds = PLANES[modal.plane][2], words.get("Q", 0.0), words.get("P", 0.0)
    return make(state, block, w, r, z, modal.initial, q, seconds)


def _is_shifted(state: State, number: int) -> bool:
    """Tell whether this is back boring with a shift: down beside the hole, and up."""
    return number == 870 and state.control.dialect.g87 != "centre"


def _rapid(state: State, block: Block, point: list[float]) -> None:
    move(state, block, Kind.RAPID, state.reach(point), 0.0)
    state.point = point


def _drill(hole: Hole) -> None:
    """G81, G82."""
    hole.feed(hole.z)
    hole.dwell()
    hole.rapid(hole.out)


def _peck_depths(hole: Hole) -> list[float]:
    """Return the levels of the pecks, the last one the bottom."""
    if not hole.q:
        return [hole.z]
    holes = _repeats(hole.state, hole.block, hole.state.modal.cycle)
    count = holes * (hole.r - hole.z) / hole.q
    hole.state.holes += int(min(count, MAX_STEPS)) // holes
    if hole.q < 0 or count > MAX_STEPS:
        raise hole.block.error("cycle_too_long", f"{count:.3g} pecks", "Q")
    depths = []
    depth = hole.r - hole.q
    while depth > hole.z + SAME_LEVEL_MM:
        depths.append(depth)
        depth -= hole.q
    return [*depths, hole.z]


def _peck(hole: Hole) -> None:
    """G83: out to R between pecks."""
    depths = _peck_depths(hole)
    back_off = hole.state.control.peck_backoff
    for depth in depths[:-1]:
        hole.feed(depth)
        hole.rapid(hole.r)
        hole.rapid(min(depth + back_off, hole.r))
    hole.feed(depths[-1])
    hole.dwell()
    hole.rapid(hole.out)


def _break_chips(hole: Hole) -> None:
    """G73: up by the back-off between pecks."""
    depths = _peck_depths(hole)
    for depth in depths[:-1]:
        hole.feed(depth)
        hole.rapid(depth + hole.state.control.peck_backoff)
    hole.feed(depths[-1])
    hole.dwell()
    hole.rapid(hole.out)


def _tap(hole: Hole) -> None:
    """G84, G74: in and out at the feed, with Q in pecks."""
    for depth in _peck_depths(hole):
        hole.feed(depth)
        hole.dwell()
        hole.feed(hole.r)
    hole.rapid(hole.out)


def _bore(hole: Hole) -> None:
    """G85, G89: out at the feed."""
    hole.feed(hole.z)
    hole.dwell()
    hole.feed(hole.r)
    hole.rapid(hole.out)


def _bore_and_stop(hole: Hole) -> None:
    """G88: the operator retracts the tool, so nobody knows where it goes."""
    hole.feed(hole.z)
    hole.dwell()
    hole.state.emit(Kind.STOP, hole.block)
    hole.state.report(hole.block.finding("manual_retract", "G88", "G88"), "G88")


def _fine_bore(hole: Hole) -> None:
    """G76: out with the tool shifted off the wall."""
    u, v = SHIFTS[hole.state.control.bore_shift]
    hole.feed(hole.z)
    hole.dwell()
    hole.shift(hole.q * u, hole.q * v)
    hole.rapid(hole.out)
    hole.shift(-hole.q * u, -hole.q * v)


def _back_bore(hole: Hole) -> None:
    """G87: down beside the hole, in, and bore upwards."""
    state = hole.state
    if state.control.dialect.g87 == "centre":
        words = state.modal.cycle_words
        letters = [CENTRE_WORDS[i] for i in PLANES[state.modal.plane]]
        u, v, top = (words.get(letter, 0.0) for letter in letters)
        top += hole.z if state.modal.distance == 910 else 0.0
        ends = (hole.z, top, hole.z, hole.out)
    else:
        u, v = (hole.q * way for way in SHIFTS[state.control.bore_shift])
        ends = (hole.r, hole.z, hole.z, hole.initial)
    below, top, free, last = ends
    hole.shift(u, v)
    hole.rapid(below)
    hole.shift(-u, -v)
    hole.feed(top)
    hole.dwell()
    hole.feed(free)
    hole.shift(u, v)
    hole.rapid(last)
    hole.shift(-u, -v)
    hole.rapid(hole.out)


STEPS: dict[int, Callable[[Hole], None]] = {
    730: _break_chips,
    740: _tap,
    760: _fine_bore,
    810: _drill,
    820: _drill,
    830: _peck,
    840: _tap,
    850: _bore,
    860: _drill,
    870: _back_bore,
    880: _bore_and_stop,
    890: _bore,
}
"""Cycle -> what it does after the approach; G86 moves as G82 does."""

assert STEPS.keys() == NEEDED.keys()


def end_cycle(state: State, block: Block, number: int) -> None:
    """G80: no cycle from here on; where the dialect says so, no motion mode either."""
    state.modal.cycle = 0
    if state.control.dialect.g80 == "motion":
        state.modal.motion = number
