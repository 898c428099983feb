"""Findings: what a check has to say about a program, and the table of their codes."""

from __future__ import annotations

from dataclasses import dataclass

FAIL, INCONCLUSIVE, NOTED = "fail", "inconclusive", "noted"

CONTAINMENT_UNDECIDED = "containment_undecided"
"""Meaning of GC501 where an open mesh leaves a question open; elsewhere GC501 is only noted."""


@dataclass(frozen=True)
class Code:
    """One row of the table of codes: a title, a severity and the effect on the verdict."""

    title: str
    severity: str  # error | warning | note
    effect: str  # fail | inconclusive | noted


CODES: dict[str, Code] = {
    "GC101": Code("two machine parts touch", "error", FAIL),
    "GC102": Code("tool or holder touches the machine", "error", FAIL),
    "GC103": Code("holder or shank touches stock or part", "error", FAIL),
    "GC104": Code("tool touches a fixture", "error", FAIL),
    "GC105": Code("flute touches the part where it does not cut", "error", FAIL),
    "GC106": Code("contact or containment when a body appears", "error", FAIL),
    "GC107": Code("contact between two samples", "error", FAIL),
    "GC108": Code("machine or fixture touches stock, part or fixture", "error", FAIL),
    "GC201": Code("nearer than the clearance of the pair", "warning", NOTED),
    "GC202": Code("nearer than the path tolerance", "warning", NOTED),
    "GC301": Code("overtravel of a linear axis", "error", FAIL),
    "GC302": Code("overtravel of a rotary axis", "error", FAIL),
    "GC303": Code("axis too slow for the feed", "note", NOTED),
    "GC304": Code("near a pole of the rotary axes", "warning", NOTED),
    "GC401": Code("word or syntax", "error", FAIL),
    "GC402": Code("code or letter gcodesim does not follow", "error", INCONCLUSIVE),
    "GC403": Code("another language or control", "error", INCONCLUSIVE),
    "GC404": Code("arc cannot be traced", "error", FAIL),
    "GC405": Code("feed missing or impossible", "error", FAIL),
    "GC406": Code("parameter or expression", "error", FAIL),
    "GC407": Code("subprogram or program flow", "error", FAIL),
    "GC408": Code("canned cycle", "error", FAIL),
    "GC409": Code("offset, tool, position or variable that was not given", "error", INCONCLUSIVE),
    "GC410": Code("value out of its range", "error", FAIL),
    "GC412": Code("macro or subprogram that is not there", "error", INCONCLUSIVE),
    "GC420": Code("unknown M code", "warning", INCONCLUSIVE),
    "GC421": Code("tool without a shape", "warning", INCONCLUSIVE),
    "GC422": Code("cutter compensation not applied", "warning", INCONCLUSIVE),
    "GC423": Code("position left to the operator or a probe", "warning", INCONCLUSIVE),
    "GC424": Code("limit of blocks or time reached", "warning", INCONCLUSIVE),
    "GC425": Code("vacant parameter used", "warning", INCONCLUSIVE),
    "GC426": Code("the stock of that moment is not decided", "warning", INCONCLUSIVE),
    "GC427": Code("reading that depends on the control", "warning", INCONCLUSIVE),
    "GC430": Code("worth knowing", "note", NOTED),
    "GC431": Code("length of another tool", "warning", NOTED),
    "GC432": Code("unit of lengths that the program leaves out", "warning", NOTED),
    "GC501": Code("open mesh: containment cannot be decided", "warning", NOTED),
    "GC502": Code("links touch at rest", "warning", NOTED),
    "GC503": Code("suspicious unit of a mesh", "warning", INCONCLUSIVE),
    "GC504": Code("faulty mesh", "warning", NOTED),
    "GC601": Code("ignored in a way that does not count", "error", FAIL),
    "GC602": Code("nothing left to ignore", "note", NOTED),
    "GC901": Code("the check stopped early", "error", INCONCLUSIVE),
}

CLEARANCES = ("GC201", "GC202")
"""Codes that tell of a pair that is too near."""

FORMER_CODES: dict[str, tuple[str, ...]] = {"GC108": ("GC101", "GC103")}
"""Code -> codes that the same findings had before; a baseline made then still accepts them."""


@dataclass(frozen=True)
class Ignored:
    """Why a finding does not count.

    Attributes:
        by: who says so, for example ``comment``, ``--ignore GC201`` or the name of a baseline.
        reason: what they say; empty where none is needed.
    """

    by: str
    reason: str = ""


@dataclass(frozen=True)
class Finding:
    """One statement about a program or model, with its code and its place.

    Attributes:
        code: key of CODES.
        message: what is wrong and what would be right, one sentence or two, no line breaks.
        meaning: stable id of the cause (``feed_missing``); several share a code; may be empty.
        file, line, column: place in the NC program or model file, 1-based; None or "" if unknown.
        block: text of the block, without its line end.
        time_s: program time of the event [s].
        pair: names of the two bodies.
        parts: names of their parts that touch.
        depth: how much of it there is: depth of a contact, what is missing of a clearance, how far
            a joint is beyond its travel [mm, deg]; None where that is not known.
        continues: it goes on from the finding before it: a contact that lasts into another block.
        tool: number of the tool in the spindle.
        severity: overrides the severity of the code ("error" turns a noted code into FAIL).
        ignored: why it does not count (gcodesim.policy); None: it counts.
    """

    code: str
    message: str
    meaning: str = ""
    file: str = ""
    line: int | None = None
    column: int | None = None
    block: str = ""
    time_s: float | None = None
    pair: tuple[str, str] | None = None
    parts: tuple[str, str] | None = None
    depth: float | None = None
    continues: bool = False
    tool: int | None = None
    severity: str = ""
    ignored: Ignored | None = None

    def __post_init__(self) -> None:
        if not self.severity:
            object.__setattr__(self, "severity", CODES[self.code].severity)

    @property
    def effect(self) -> str:
        """Effect on the verdict: fail, inconclusive or noted."""
        if self.meaning == CONTAINMENT_UNDECIDED:
            return INCONCLUSIVE
        effect = CODES[self.code].effect
        return FAIL if effect == NOTED and self.severity == "error" else effect

    @property
    def is_contact(self) -> bool:
        """Two bodies meet."""
        return self.code.startswith("GC1")

    @property
    def leaves_unchecked(self) -> bool:
        """Because of it something was not looked at: the rest of a refused program, a pair."""
        return self.effect == INCONCLUSIVE or (self.code.startswith("GC4") and self.effect == FAIL)
