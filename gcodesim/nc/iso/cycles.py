"""Canned cycles: words kept from hole to hole, and the steps each cycle takes at one point."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

from gcodesim.constants import SAME_LEVEL_MM
from gcodesim.nc.control import moves
from gcodesim.nc.control.columns import CENTRE_WORDS, MOTION
from gcodesim.nc.control.drilling import (
    Dwell,
    FeedTo,
    Hole,
    ManualStop,
    RapidTo,
    Shift,
    Step,
    drill,
    turned_over,
)
from gcodesim.nc.control.modal import Motion, Spindle
from gcodesim.nc.iso.block import Block
from gcodesim.nc.iso.code_rows import Group
from gcodesim.nc.iso.g_codes import G
from gcodesim.nc.iso.memory import IsoState
from gcodesim.nc.iso.modes import dwell_seconds
from gcodesim.nc.iso.motion import target
from gcodesim.nc.iso.pecks import MAX_STEPS, peck_depths
from gcodesim.nc.program import AXES, PLANES, Kind, Turning

KEPT = "RQPIJ"
"""Words a cycle keeps for its next holes, besides the depth; K and L count holes of one block."""

PECKED = (G.CHIP_BREAKING, G.LEFT_TAPPING, G.PECKING, G.TAPPING)
"""Cycles that reach the bottom by pecks of Q."""

PLACE, ROTARY = frozenset("XY"), frozenset("ABC")

DRILLS = {
    "axis": frozenset("XYZABC"),
    "axis_or_r": frozenset("XYZABCR"),
    "xy": PLACE | {MOTION},
}
"""Readings.cycle_drills -> columns of which a block has one where it makes a hole."""

TAPPING = (G.LEFT_TAPPING, G.TAPPING)

SHIFTS = {"+X": (1.0, 0.0), "-X": (-1.0, 0.0), "+Y": (0.0, 1.0), "-Y": (0.0, -1.0)}
"""Readings.bore_shift -> way along the two axes of the plane."""


class HoleWords(NamedTuple):
    """What the words of the active cycle say; levels are program values of the depth axis [mm].

    Attributes:
        r, z: R level and bottom.
        initial: depth-axis value when the cycle became modal.
        out: level the hole is left to.
        depths: levels of the pecks, the last one the bottom.
        clearing: after this way of chip breaking out to R [mm], 0 = never.
        q: peck depth or shift [mm], 0 when not given.
        back_off: how far above the last depth pecks stop [mm].
        way: off the wall, along the two axes of the plane.
        dwell: at the bottom.
    """

    r: float
    z: float
    initial: float
    out: float
    depths: list[float]
    clearing: float
    q: float
    back_off: float
    way: tuple[float, float]
    dwell: Dwell

    @property
    def shift(self) -> Shift:
        """The way off the wall [mm]."""
        return Shift(self.q * self.way[0], self.q * self.way[1])


def run_cycle(state: IsoState, block: Block, number: int) -> None:
    """G73 G74 G76 G81-G89: keep the words, and make a hole at every position of the block."""
    if block.has("G", G.MACHINE_COORDINATES):
        raise block.error("axis_without_motion", "G53 in a cycle", "G53")
    codes, modal = state.codes, state.modal
    if not codes.cycle:
        codes.cycle_words = {}
        codes.initial = state.point[PLANES[modal.plane][2]]
    if codes.cycle != number:
        kept = "RZQ" if state.control.readings.cycle_q == "unsigned" else "RZ"
        codes.cycle_words = {k: v for k, v in codes.cycle_words.items() if k in kept}
    codes.cycle, modal.drilling = number, True
    if state.control.readings.g80 == "motion":
        modal.motion = Motion.NONE
    _keep_words(state, block)
    repeats = _repeats(state, block, number)
    if not repeats:
        return
    if not _drills(state, block):
        if block.values.keys() & ROTARY:
            moves.straight(state, Kind.RAPID, _beside(state, block))
        return
    _check_words(state, block, number)
    hole = _hole(state, block, number, repeats)
    state.holes += repeats * hole.counted
    for _ in range(repeats):
        drill(state, hole, target(state, block))


def _drills(state: IsoState, block: Block) -> bool:
    """Tell whether a hole is made at the place the block names."""
    reading, letters = state.control.readings.cycle_drills, block.values.keys()
    own = reading == "xy" and any(row.group is Group.CYCLE for row in block.rows)
    if reading == "xy":
        return own or bool(letters & PLACE)
    return block.moves or (reading == "axis_or_r" and "R" in letters)


def _beside(state: IsoState, block: Block) -> list[float]:
    """Return the point a block names, on the level where the tool stands."""
    point, depth = target(state, block), PLANES[state.modal.plane][2]
    point[depth] = state.point[depth]
    return point


def _keep_words(state: IsoState, block: Block) -> None:
    """Keep lengths in mm and the dwell in seconds, as they were meant when they were read."""
    codes, values = state.codes, block.values
    depth = AXES[PLANES[state.modal.plane][2]]
    readings = state.control.readings
    rotary = next((letter for letter in "ABC" if letter in values), "")
    if rotary and readings.cycle_rotary == "error":
        raise block.error("rotary_in_cycle", f"{rotary} in a cycle block", rotary)
    for letter in KEPT:
        if letter in values:
            codes.cycle_words[letter] = values[letter] * state.scale
    if "Q" in values and readings.cycle_q == "unsigned":
        codes.cycle_words["Q"] = abs(codes.cycle_words["Q"])
    if "P" in values:
        codes.cycle_words["P"] = dwell_seconds(state, block, "P")
    if depth in values:
        codes.cycle_words["Z"] = values[depth] * state.scale
    is_size = readings.peck_words == "ijk" or _is_centred(state, codes.cycle)
    if is_size and "K" in values:
        codes.cycle_words["K"] = values["K"] * state.scale


def _is_centred(state: IsoState, number: int) -> bool:
    """Tell whether this is back boring with centre words I J and the top K."""
    return number == G.BACK_BORING and state.control.readings.g87 == "centre"


def _is_shifted(state: IsoState, number: int) -> bool:
    """Tell whether this is back boring with a shift: down beside the hole, and up."""
    return number == G.BACK_BORING and state.control.readings.g87 != "centre"


def _repeats(state: IsoState, block: Block, number: int) -> int:
    """Return how many holes L or K of this block asks for."""
    centred = _is_centred(state, number)
    letters = "" if centred else state.control.readings.cycle_repeats.replace("_or_", "")
    letter = next((letter for letter in letters or "L" if letter in block.values), "")
    repeats = block.whole(letter) if letter else 1
    if repeats > MAX_STEPS:
        raise block.error("cycle_too_long", f"{repeats} holes", letter)
    return repeats


def _check_words(state: IsoState, block: Block, number: int) -> None:
    """Check that the cycle has what it needs for a hole.

    Raises:
        ProgramError: it has not.
    """
    words, normal = state.codes.cycle_words, PLANES[state.modal.plane][2]
    code = f"G{number // 10}"
    for letter in f"ZR{CENTRE_WORDS[normal]}" if _is_centred(state, number) else "ZR":
        if letter not in words:
            name = AXES[normal] if letter == "Z" else letter
            raise block.error("cycle_word_missing", f"{code} without {name}", code)
    if number in SIZED and words.get("Q", 0.0) < 0:
        raise block.error("cycle_q_not_positive", f"{code} with Q{words['Q']:g}", "Q")
    if number == G.DWELL_DRILLING and "P" not in words:
        state.report("cycle_dwell_missing", "G82 without P", "G82")
    for key in _open_keys(state, number):
        if state.reading(key) == "alarm":
            if key == "cycle_no_q" and "Q" in words:
                raise block.error("cycle_q_not_positive", f"{code} with Q0", "Q")
            meaning, what = ALARMS[key]
            raise block.error(meaning, f"{code} {what}", code)
    if number in TAPPING:
        if not state.modal.spindle_turns and not state.codes.rigid_tapping:
            right = number == G.TAPPING
            state.modal.spindle = Spindle.CLOCKWISE if right else Spindle.COUNTER_CLOCKWISE
        state.recorder.turn(Turning.MAY_TURN)


def _open_keys(state: IsoState, number: int) -> Iterator[str]:
    """Yield the readings on which a hole of the active cycle depends."""
    words, ijk = state.codes.cycle_words, state.control.readings.peck_words == "ijk"
    if number in (G.CHIP_BREAKING, G.PECKING):
        lacks_q = not (words.get("Q") or (ijk and words.get("I")))
    else:
        shifts = _is_shifted(state, number) or (number == G.FINE_BORING and not ijk)
        lacks_q = shifts and "Q" not in words
    if lacks_q:
        yield "cycle_no_q"
    if number in TAPPING and not state.modal.spindle_turns and not state.codes.rigid_tapping:
        yield "tapping_spindle"
    if _is_shifted(state, number) and state.codes.cycle_return == G.RETURN_TO_R:
        yield "g87_under_g99"


def next_hole(state: IsoState) -> Hole | None:
    """Return what every next hole of the active cycle does, None where each needs a finding.

    Raises:
        ProgramError: the hole would be refused.
    """
    codes = state.codes
    # G82 without P is reported for every hole, and what is not known is counted.
    if codes.cycle == G.DWELL_DRILLING and "P" not in codes.cycle_words:
        return None
    if any(_open_keys(state, codes.cycle)):
        return None
    block = Block("", 0, "")
    _check_words(state, block, codes.cycle)
    hole = _hole(state, block, codes.cycle, 1)
    drills = DRILLS[state.control.readings.cycle_drills]
    return hole._replace(kept=_kept_in_columns(state, codes.cycle), drills=drills)


def _hole(state: IsoState, block: Block, number: int, repeats: int) -> Hole:
    """Return what the active cycle does at a point.

    Raises:
        ProgramError: its bottom lies above its R level, or it takes too many pecks.
    """
    codes = state.codes
    kept, initial = codes.cycle_words, codes.initial
    r, z = kept["R"], kept["Z"]
    if state.modal.incremental:
        r += initial
        z += r
    q, readings = kept.get("Q", 0.0), state.control.readings
    shifted = _is_shifted(state, number)
    upward = z > r and not shifted
    if upward and readings.cycle_upward == "alarm":
        raise block.error("cycle_r_below_z", f"bottom {z:g} mm, R level {r:g} mm", "R")
    level = r
    if upward:
        # Worked out downwards, and turned over at the end.
        r, z, initial = -r, -z, -initial
    to_initial = shifted or codes.cycle_return == G.RETURN_TO_START
    out = max(initial, r) if to_initial else r
    pecks = kept if readings.peck_words == "ijk" else {"Q": q}
    pecks = pecks if number in (G.CHIP_BREAKING, G.PECKING) else {"Q": q}
    depths = peck_depths(block, r, z, pecks, repeats) if number in PECKED else [z]
    clears = number == G.CHIP_BREAKING and readings.peck_words == "ijk" and "I" not in kept
    clearing = kept.get("K", 0.0) if clears else 0.0
    way, dwell = SHIFTS[readings.bore_shift], Dwell(kept.get("P", 0.0))
    words = HoleWords(r, z, initial, out, depths, clearing, q, readings.peck_backoff, way, dwell)
    steps = _back_bore_centred(state, words) if _is_centred(state, number) else STEPS[number](words)
    counted = (
        len(depths) if "I" in pecks else 1 + (int((r - z) / q) if number in PECKED and q else 0)
    )
    if upward:
        steps = [turned_over(step) for step in steps]
    return Hole(steps, None if shifted else level, counted, is_upward=upward)


def _kept_in_columns(state: IsoState, number: int) -> dict[str, float]:
    """Return the words that change nothing when they are written again."""
    words, depth = state.codes.cycle_words, AXES[PLANES[state.modal.plane][2]]
    kept = {letter: words[letter] for letter in "QR" if letter in words}
    return {**kept, depth: words["Z"], MOTION: number / 10}


def _drill(words: HoleWords) -> list[Step]:
    """G81, G82, G86."""
    return [FeedTo(words.z), words.dwell, RapidTo(words.out)]


def _peck(words: HoleWords) -> list[Step]:
    """G83: out to R between pecks."""
    steps: list[Step] = []
    for depth in words.depths[:-1]:
        back = min(depth + words.back_off, words.r)
        steps += [FeedTo(depth), RapidTo(words.r), RapidTo(back)]
    return [*steps, FeedTo(words.depths[-1]), words.dwell, RapidTo(words.out)]


def _break_chips(words: HoleWords) -> list[Step]:
    """G73: up by the back-off between pecks."""
    steps: list[Step] = []
    cleared = words.r
    for depth in words.depths[:-1]:
        steps.append(FeedTo(depth))
        if words.clearing and cleared - depth >= words.clearing - SAME_LEVEL_MM:
            cleared = depth
            steps += [RapidTo(words.r), RapidTo(min(depth + words.back_off, words.r))]
        else:
            steps.append(RapidTo(depth + words.back_off))
    return [*steps, FeedTo(words.depths[-1]), words.dwell, RapidTo(words.out)]


def _tap(words: HoleWords) -> list[Step]:
    """G84, G74: in and out at the feed, with Q in pecks."""
    steps: list[Step] = []
    for depth in words.depths:
        steps += [FeedTo(depth), words.dwell, FeedTo(words.r)]
    return [*steps, RapidTo(words.out)]


def _bore(words: HoleWords) -> list[Step]:
    """G85, G89: out at the feed."""
    return [FeedTo(words.z), words.dwell, FeedTo(words.r), RapidTo(words.out)]


def _bore_and_stop(words: HoleWords) -> list[Step]:
    """G88: the operator retracts the tool, and where to is unknown."""
    return [FeedTo(words.z), words.dwell, ManualStop("G88")]


def _fine_bore(words: HoleWords) -> list[Step]:
    """G76: out with the tool shifted off the wall."""
    shift = words.shift
    back = Shift(-shift.u, -shift.v)
    return [FeedTo(words.z), words.dwell, shift, RapidTo(words.out), back]


def _back_bore(words: HoleWords) -> list[Step]:
    """G87 with a shift: down beside the hole, in, and bore upwards."""
    ends = words.r, words.z, words.z, words.initial
    return _back_bored(words, words.shift, ends)


def _back_bore_centred(state: IsoState, words: HoleWords) -> list[Step]:
    """G87 with centre words I J and the top K."""
    kept = state.codes.cycle_words
    letters = [CENTRE_WORDS[i] for i in PLANES[state.modal.plane]]
    u, v, top = (kept.get(letter, 0.0) for letter in letters)
    top += words.z if state.modal.incremental else 0.0
    return _back_bored(words, Shift(u, v), (words.z, top, words.z, words.out))


def _back_bored(
    words: HoleWords, shift: Shift, ends: tuple[float, float, float, float]
) -> list[Step]:
    below, top, free, last = ends
    back = Shift(-shift.u, -shift.v)
    return [
        *(shift, RapidTo(below), back, FeedTo(top), words.dwell),
        *(FeedTo(free), shift, RapidTo(last), back, RapidTo(words.out)),
    ]


STEPS: dict[int, Callable[[HoleWords], list[Step]]] = {
    G.CHIP_BREAKING: _break_chips,
    G.LEFT_TAPPING: _tap,
    G.FINE_BORING: _fine_bore,
    G.DRILLING: _drill,
    G.DWELL_DRILLING: _drill,
    G.PECKING: _peck,
    G.TAPPING: _tap,
    G.BORING: _bore,
    G.STOP_BORING: _drill,
    G.BACK_BORING: _back_bore,
    G.MANUAL_BORING: _bore_and_stop,
    G.DWELL_BORING: _bore,
}
"""Cycle -> what it does after the approach; G86 moves as G82 does."""

SIZED = (G.CHIP_BREAKING, G.PECKING, G.FINE_BORING, G.BACK_BORING)
"""Cycles with pecks or a shift of the size Q."""

ALARMS = {
    "cycle_no_q": ("cycle_word_missing", "without Q"),
    "tapping_spindle": ("tapping_no_spindle", "with the spindle off"),
    "g87_under_g99": ("cycle_return_unusable", "under G99"),
}
"""Key of the readings -> meaning and text of the alarm."""


def end_cycle(state: IsoState, block: Block, number: int) -> None:
    """G80: no cycle from here on; where the dialect says so, no motion mode either."""
    state.codes.cycle, state.modal.drilling = 0, False
    if state.control.readings.g80 == "motion":
        state.modal.motion = Motion.NONE
