"""Comments in a program that ignore findings of their block: ``(gcodesim: ignore GC201)``."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from gcodesim.errors import UsageError
from gcodesim.findings.codes import Ignored
from gcodesim.policy.rules import Rule, parse_prefix

COMMENT = re.compile(r"[(;][ \t]*gcodesim:([^()\n]*)", re.IGNORECASE)
REASON = re.compile(r"\breason\s*=", re.IGNORECASE)
DEPTH = re.compile(r"\bdepth\s*=\s*(\d+(?:\.\d*)?|\.\d+)(?![\d.])", re.IGNORECASE)
RIGHT = "write (gcodesim: ignore GC201 reason=why), or ignore GC102 depth=0.05 reason=why"


MOST_SHOWN = 200
"""Characters of a wrong comment that are shown."""


@dataclass(frozen=True)
class Comment:
    """A comment for gcodesim.

    Attributes:
        line: 1-based line it stands in.
        rules: what it ignores; empty where it cannot be read.
        wrong: what is wrong with it; empty where it can be read.
    """

    line: int
    rules: tuple[Rule, ...] = ()
    wrong: str = ""


def comments_in(text: str) -> Iterator[Comment]:
    """Yield the comments for gcodesim of a program, or of one block."""
    # Few programs hold any, and some have ten million blocks: the cheap question comes first.
    if not any(word in text for word in ("gcodesim:", "GCODESIM:", "Gcodesim:")):
        return
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    line, place = 1, 0
    for match in COMMENT.finditer(text):
        line += text.count("\n", place, match.start())
        place = match.start()
        yield _comment(match[1], line)


def _comment(text: str, line: int) -> Comment:
    wish, *rest = REASON.split(text, maxsplit=1)
    reason = rest[0].strip() if rest else ""
    limit = DEPTH.search(wish)
    first, *codes = DEPTH.sub(" ", wish, count=1).replace(",", " ").split() or [""]
    if first.lower() != "ignore" or not codes or (rest and not reason):
        return Comment(line, wrong=f"{text.strip()[:MOST_SHOWN]!r} cannot be read: {RIGHT}")
    mark, depth = Ignored("comment", reason), float(limit[1]) if limit else None
    try:
        rules = tuple(Rule(parse_prefix(code, "ignore"), mark, depth) for code in codes)
    except UsageError as error:
        return Comment(line, wrong=str(error))
    return Comment(line, rules)
