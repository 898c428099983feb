"""What controls leave open: one row per dialect, single keys replaced by the machine file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, is_dataclass, replace
from functools import cache
from typing import Any, Literal, get_args, get_origin, get_type_hints

from gcodesim.errors import UsageError

Dialect = Literal["fanuc", "haas", "linuxcnc", "grbl"]
"""Names of the rows."""

Effect = Literal["none", "clamp", "unclamp", "stop"]
"""What a code listed in a machine file does; a clamp holds rotary axes, the file says not which."""


STANDS_FOR = ("none", "probe", "tool_change")
"""Words of `programs` for what a program in the control does; other values are files."""


def _key(meaning: str, default: Any, **rules: Any) -> Any:
    """Return a field that is a key of `control:` in machine files.

    Args:
        meaning: one sentence for the manual.
        default: value where neither the dialect nor the machine file gives one.
        rules: what numbers and words of the file must keep: gt, ge, pattern.
    """
    factory = {"default_factory": default} if callable(default) else {"default": default}
    return field(**factory, metadata={"meaning": meaning, "rules": rules})


@dataclass(frozen=True)
class ArcTolerance:
    """When an arc closes well enough (the rules of LinuxCNC).

    The largest differences of the radii in mm are 2.54 times as large under G20.
    """

    tol_mm: float = _key("start and end radius may differ by this [mm]", 0.02828, gt=0)
    tol_rel: float = _key("above tol_mm they may differ by this share of the radius", 0.001, gt=0)
    tol_max_mm: float = _key("the largest difference of all [mm]", 2.828, gt=0)
    r_tol_mm: float = _key(
        "half the chord may exceed R by this; also the smallest radius [mm]", 0.00127, gt=0
    )


@dataclass(frozen=True)
class ToolChangeMotion:
    """Where the old tool goes at a tool change, and the new one appears: machine coordinates."""

    retract: tuple[str, ...] = _key(
        "axes that go first, together: to `position`, or else to the reference point of G28",
        (),
        pattern="^[XYZABC]$",
    )
    position: Mapping[str, float] = _key(
        "axis -> where it stands at the tool changer while the tool changes [mm, deg]; others stay",
        dict,
        pattern="^[XYZABC]$",
    )
    seconds: float = _key("time the change takes there [s]", 0.0, ge=0)


@dataclass(frozen=True, kw_only=True)
class Readings:
    """How one control reads what the standard leaves open, and what its builder has added.

    Every field but `dialect` is a key of the section `control:` of machine files; its meaning and
    its choices stand beside it, and the files' schema and manual are made from them.

    Attributes:
        dialect: the row all of this comes from; tables of codes say which dialects have a code.
    """

    dialect: Dialect
    no_point: Literal["units", "increment", "both", "open"] = _key(
        "lengths and angles written without a decimal point: millimetres, inches and degrees, or "
        "increments; open: followed as units, and INCONCLUSIVE",
        "units",
    )
    increment_mm: float = _key("increment of lengths under G21 [mm]", 0.001, gt=0)
    increment_inch: float = _key("increment of lengths under G20 [inch]", 0.0001, gt=0)
    increment_deg: float = _key("increment of angles [deg]", 0.001, gt=0)
    program_unit: Literal["mm", "inch"] | None = _key(
        "unit of lengths until G20 or G21; without one, `units` of the machine file is taken and "
        "reported",
        None,
    )
    cycle_return: Literal["G98", "G99"] = _key("return level of cycles until G98 or G99", "G98")
    rapids: Literal["linear", "dogleg", "both"] = _key(
        "way of a rapid move: straight, or every axis at its own rate; ask the builder", "linear"
    )
    dwell_p: Literal["ms", "s", "point"] = _key(
        "unit of P in G4; `point`: ms without a decimal point, s with one", "ms"
    )
    g80: Literal["motion", "cycle"] = _key("G80 ends the motion mode, or only cycles", "cycle")
    g87: Literal["shift", "centre"] = _key(
        "back boring with a shift Q, or with centre words I J and the top K", "shift"
    )
    g87_under_g99: Literal["initial", "alarm", "both"] = _key(
        "back boring with a shift under G99: out to the initial level as under G98, or an alarm",
        "both",
    )
    peck_backoff: float = _key("G73 and G83 stop this far above the last depth [mm]", 0.254, ge=0)
    bore_shift: Literal["+X", "-X", "+Y", "-Y"] = _key(
        "way off the wall of G76 and G87 with Q, in G17; +X is the first axis of another plane, "
        "+Y the second",
        "+X",
    )
    g28_no_axes: Literal["all", "none", "both"] = _key(
        "G28 and G30 without axis words: every axis goes, or none does", "all"
    )
    g28_rotary: Literal["one_turn", "unwind", "both"] = _key(
        "G28 and G30 of a rotary axis with `wrap`: at most one turn, as its words are read, or all "
        "turns back",
        "one_turn",
    )
    length_after_reference: Literal["kept", "cancelled", "both"] = _key(
        "tool length after G28, G30 or G53 has moved its axis", "kept"
    )
    length_at_tool_change: Literal["kept", "new_tool", "both"] = _key(
        "tool length in force after a tool change: as it was, or that of the new tool", "kept"
    )
    length_change: Literal["next_move", "at_once", "both"] = _key(
        "G43, G44, G49 or H without a word of the length axis: the next move brings the change, or "
        "the axis moves at once",
        "next_move",
    )
    tool_change: ToolChangeMotion | Literal["stays", "reference", "both"] = field(
        default="stays",
        metadata={
            "meaning": "motion of M6: `retract`, then the other axes of `position`; or a word: the "
            "axes stay, Z goes to the reference point of G28, or nobody knows (both are checked)",
            "rules": {},
        },
    )
    spindle_seconds: float = _key(
        "time that M3 and M4 take where the spindle stands or turns the other way, while the axes "
        "wait [s]",
        0.0,
        ge=0,
    )
    r_and_ijk: Literal["error", "r_wins"] = _key("R together with I J K", "r_wins")
    arc: ArcTolerance = field(
        default_factory=ArcTolerance, metadata={"meaning": "tolerances of arc words", "rules": {}}
    )
    arc_no_centre: Literal["line", "alarm", "both"] = _key(
        "arc with neither R nor centre words: a straight line, or an alarm", "both"
    )
    arc_radii: Literal["spiral", "alarm", "both"] = _key(
        "arc whose start and end lie farther from the centre, one than the other, than `arc` "
        "allows: a spiral, or an alarm",
        "both",
    )
    arc_r_no_end: Literal["none", "alarm", "both"] = _key(
        "arc with R that ends where it starts: no motion, or an alarm", "both"
    )
    arc_normal_word: Literal["zero", "ignored", "error"] = _key(
        "centre word along the normal of the plane: harmless where it is 0, never read, an error",
        "zero",
    )
    comma_corners: bool = _key("`,R` and `,C` round and chamfer the corner after a block", True)
    feed_forgotten: Literal["change", "always"] = _key(
        "G93 G94 G95 forget F where they change the mode, or always", "change"
    )
    h0: Literal["cancel", "spindle"] = _key(
        "length of G43 H0: none, or that of the tool in the spindle", "cancel"
    )
    h_in_any_block: bool = _key(
        "H without G43 changes the length in force, and D may stand anywhere", True
    )
    length_without_h: Literal["last", "last_or_spindle", "spindle"] = _key(
        "length of G43 without H: of the last H, where there was none of row 0 or of the tool in "
        "the spindle; or always of the tool in the spindle",
        "last",
    )
    same_letter: Literal["last", "alarm", "both"] = _key(
        "a letter but G and M twice in a block: the last counts, or an alarm", "both"
    )
    unused_word: Literal["open", "alarm"] = _key(
        "word that no code of its block uses: not known (`ignore_words` drops a letter), or an "
        "alarm",
        "open",
    )
    same_group: Literal["last", "alarm", "open"] = _key(
        "several G codes of one group in a block: the last counts, an alarm, or not known", "last"
    )
    m_per_block: Literal["any", "one", "three", "open"] = _key(
        "M codes in one block: any number, an alarm above one or three, or not known above one",
        "any",
    )
    m6_order: Literal["first", "last", "both"] = _key(
        "M6 beside motion words: the tool is changed before the motion, or after it", "first"
    )
    g53_incremental: Literal["ignored", "incremental", "absolute", "stop", "open"] = _key(
        "G53 under G91: the block does nothing, moves by its words, moves to them, is an alarm, or "
        "is not known",
        "ignored",
    )
    g10_l2_p0: Literal["external", "active"] = _key(
        "G10 L2 P0 sets what is added to every work offset, or the active one", "external"
    )
    cycle_drills: Literal["axis", "axis_or_r", "xy"] = _key(
        "blocks under a cycle that drill: with an axis word, also with R alone, or with X or Y "
        "(and the block of the cycle itself)",
        "axis_or_r",
    )
    cycle_rotary: Literal["first", "error"] = _key(
        "A, B and C in a block of a cycle: turned before the hole is drilled, or an error", "first"
    )
    cycle_repeats: Literal["L", "K", "L_or_K"] = _key(
        "letter that repeats the hole of a block", "L_or_K"
    )
    cycle_q: Literal["signed", "unsigned"] = _key(
        "Q of cycles: above 0, or a size whose sign is not read, which the next cycle keeps",
        "unsigned",
    )
    cycle_no_q: Literal["none", "alarm", "both"] = _key(
        "G73 and G83 without Q or with Q0, G76 and G87 without Q: one stroke and no shift, or an "
        "alarm",
        "both",
    )
    cycle_upward: Literal["drills", "alarm"] = _key(
        "a cycle whose bottom lies above its R level: drills from R to the bottom, or an alarm",
        "drills",
    )
    peck_words: Literal["q", "ijk"] = _key(
        "pecks: Q only; or also I first, J less each time, K least, and G73 with Q and K", "q"
    )
    spindle_at_stop: Literal["stops", "turns", "both"] = _key(
        "M0 and M1 stop the spindle until M3 or M4, or let it turn on; M1 hangs on a switch too",
        "stops",
    )
    tapping_spindle: Literal["starts", "alarm", "both"] = _key(
        "G74 and G84 with the spindle off: they start it themselves, or an alarm", "both"
    )
    g10_in_g91: Literal["adds", "replaces"] = _key("words of G10 L2 under G91", "adds")
    g10_l20: Literal["above_9", "additional", "solved"] = _key(
        "P of G10 L20 names an additional offset, which its words set: above P9, or every P; or "
        "always a work offset, with which the current point reads the words",
        "additional",
    )
    g10_tool_r: Literal["length", "ignored"] = _key(
        "R of G10 L1 L10 L11: the tool's length or wear, or nothing", "length"
    )
    m98_p: Literal["repeats", "number"] = _key(
        "P of M98 without L above 9999: repeats before the last four digits, or a number",
        "repeats",
    )
    m99: Literal["end", "restart"] = _key(
        "M99 in the main program: one pass, or pass after pass until one begins as another did",
        "restart",
    )
    macros: Literal["macro_b", "macro_b_haas", "o_words", "none"] = _key(
        "language of macros: Macro B, with the further parameters of Haas, o-words, or none",
        "macro_b",
    )
    tcp_frame: Literal["table", "work"] = _key(
        "program axes under G43.4 ride on the table as it stands at rotary zero, or stand as the "
        "machine's when it is switched on",
        "table",
    )
    tcp_rotary_feed: float | None = _key(
        "feed of blocks under G43.4 that only turn rotary axes [deg/min]; without one, F",
        None,
        gt=0,
    )
    orientation: Literal["joints", "great_circle"] = _key(
        "between two vectors of G43.5 the rotary axes run linearly, or the tool axis along the "
        "great circle",
        "joints",
    )
    tape: bool = _key(
        "text as from a tape: what stands before the first % is a leader and is not read, control "
        "characters mean nothing, a / inside a block begins what block delete leaves out, and "
        "POPEN, DPRNT and PCLOS move nothing",
        True,
    )
    polar_words: bool = _key("@ and ^ are words: radius and angle of a polar point", False)
    slash_deletes: bool = _key("blocks that begin with / are left out where that is asked", True)
    dollar_lines: bool = _key("lines that begin with $ are settings and orders, no blocks", False)
    start_motion: Literal["G0", "G1", "none", "both"] = _key(
        "motion code in force at the start, or none: axis words need one", "both"
    )
    m_codes: Mapping[float, Effect] = _key("M codes of the builder and what they do", dict)
    g_codes: Mapping[float, Effect] = _key("G codes of the builder and what they do", dict)
    programs: Mapping[str, str] = _key(
        "number of a program that lives in the control -> what it does: `none`, `probe` (a skip "
        "move to its X Y Z; not checked further), `tool_change` as M6, or a file beside this one",
        dict,
    )
    library: str = _key(
        "folder, relative to this file, of programs that are nowhere else: O1234.nc, name.ngc", ""
    )
    ignore_words: tuple[str, ...] = _key(
        "letters that are dropped, and listed in the coverage", (), pattern="^[A-Z]$"
    )


BOTH: Literal["both"] = "both"
"""Value of a key that is not known: the first way is taken, and the check varies it."""

OPEN = "open"
"""Value of a key that is not known, and no way to read anything."""

ROWS: dict[str, Readings] = {
    "fanuc": Readings(
        dialect="fanuc",
        no_point=BOTH,
        m_per_block="three",
        m6_order=BOTH,
        rapids=BOTH,
        g28_no_axes=BOTH,
        length_after_reference=BOTH,
        length_change=BOTH,
        spindle_at_stop=BOTH,
        tool_change=BOTH,
    ),
    "haas": Readings(
        dialect="haas",
        no_point=BOTH,
        m_per_block="open",
        m6_order=BOTH,
        rapids=BOTH,
        g28_rotary=BOTH,
        length_after_reference=BOTH,
        length_at_tool_change=BOTH,
        tool_change=ToolChangeMotion(retract=("Z",), position={"Z": 0.0}),
        dwell_p="point",
        r_and_ijk="error",
        arc_no_centre="alarm",
        arc_radii="alarm",
        arc_r_no_end="none",
        arc_normal_word="ignored",
        length_without_h="last_or_spindle",
        same_group="open",
        g53_incremental="open",
        cycle_drills="xy",
        cycle_repeats="L",
        peck_words="ijk",
        spindle_at_stop=BOTH,
        tapping_spindle="starts",
        m98_p="number",
        macros="macro_b_haas",
    ),
    "linuxcnc": Readings(
        dialect="linuxcnc",
        program_unit="mm",
        polar_words=True,
        cycle_return="G99",
        dwell_p="s",
        g80="motion",
        g87="centre",
        r_and_ijk="error",
        comma_corners=False,
        feed_forgotten="always",
        h0="spindle",
        arc_no_centre="alarm",
        arc_radii="alarm",
        arc_r_no_end="alarm",
        arc_normal_word="error",
        h_in_any_block=False,
        length_without_h="spindle",
        same_letter="alarm",
        unused_word="alarm",
        same_group="alarm",
        g53_incremental="stop",
        g10_l2_p0="active",
        cycle_drills="axis",
        cycle_rotary="error",
        cycle_q="signed",
        cycle_no_q="alarm",
        g87_under_g99="alarm",
        tapping_spindle="alarm",
        cycle_upward="alarm",
        spindle_at_stop="turns",
        g10_in_g91="replaces",
        g10_l20="solved",
        g10_tool_r="ignored",
        m98_p="number",
        macros="o_words",
        tape=False,
        start_motion="none",
    ),
    # Grbl 1.1: github.com/gnea/grbl, doc/markdown/commands.md, and gcode.c for what it checks.
    "grbl": Readings(
        dialect="grbl",
        program_unit="mm",
        dwell_p="s",
        g80="motion",
        r_and_ijk="error",
        arc=ArcTolerance(tol_mm=0.005, tol_rel=0.001, tol_max_mm=0.5),
        arc_no_centre="alarm",
        arc_radii="alarm",
        arc_r_no_end="alarm",
        arc_normal_word="ignored",
        comma_corners=False,
        feed_forgotten="always",
        h_in_any_block=False,
        same_letter="alarm",
        unused_word="alarm",
        same_group="alarm",
        spindle_at_stop="turns",
        g53_incremental="absolute",
        g10_l2_p0="active",
        g10_in_g91="replaces",
        g10_l20="solved",
        g10_tool_r="ignored",
        m98_p="number",
        macros="none",
        tape=False,
        slash_deletes=False,
        dollar_lines=True,
        start_motion="G0",
    ),
}


@cache
def ways_of(key: str) -> tuple[str, ...]:
    """Return the ways a key may be read, the one that is taken first in front."""
    return tuple(way for way in _words_of(key) if way not in (BOTH, OPEN))


@cache
def is_varied(key: str) -> bool:
    """Tell whether a key that is not known is read in all of its ways, one after the other."""
    return BOTH in _words_of(key)


def _words_of(key: str) -> tuple[str, ...]:
    """Return the words a key takes; it may take a section beside them."""
    hint = get_type_hints(Readings)[key]
    return get_args(hint if get_origin(hint) is Literal else get_args(hint)[-1])


@dataclass(slots=True)
class ReadingMet:
    """A key that nothing gives, and where a program depends on it.

    Attributes:
        key: field of Readings.
        line: row of the first line that depends on it.
        count: how often.
        value: how it is read, where the check does not vary it.
    """

    key: str
    line: int
    count: int = 1
    value: str = ""


def choose_readings(dialect: str, given: Mapping[str, Any] | None = None) -> Readings:
    """Return the row of a dialect with single keys replaced.

    Args:
        dialect: name of the row.
        given: keys of `control:` as the machine file gives them; of `arc` too, only what it gives.

    Raises:
        UsageError: there is no such dialect.
    """
    if dialect not in ROWS:
        raise UsageError(f"unknown dialect {dialect!r}; known are {', '.join(ROWS)}")
    return _replaced(ROWS[dialect], given or {})


def _replaced(row: Any, given: Mapping[str, Any]) -> Any:
    """Return a row with keys replaced, those of a section within it one by one."""
    values = {}
    for name, value in given.items():
        old = getattr(row, name)
        if name == "tool_change" and isinstance(value, Mapping) and not is_dataclass(old):
            old = ToolChangeMotion()
        within = is_dataclass(old) and isinstance(value, Mapping)
        values[name] = _replaced(old, value) if within else value
    return replace(row, **values)
