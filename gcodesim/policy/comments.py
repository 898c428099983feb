"""Comments in a program that ignore findings of their block: ``(gcodesim: ignore GC201)``."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from gcodesim.errors import UsageError
from gcodesim.findings.codes import Ignored
from gcodesim.policy.rules import Rule, parse_prefix

COMMENT = re.compile(r"[(;][ \t]*gcodesim:([^()\n]*)", re.IGNORECASE)
WISH = re.compile(
    r"\s*ignore\s+(?P<codes>GC\d{1,3}(?:[\s,]+GC\d{1,3})*)\s*(?:\breason\s*=\s*(?P<reason>.*\S))?\s*",
    re.IGNORECASE,
)
RIGHT = "write (gcodesim: ignore GC201 reason=why)"


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
    wish = WISH.fullmatch(text)
    if not wish:
        return Comment(line, wrong=f"{text.strip()!r} cannot be read: {RIGHT}")
    mark = Ignored("comment", wish["reason"] or "")
    try:
        codes = re.split(r"[\s,]+", wish["codes"])
        return Comment(line, tuple(Rule(parse_prefix(code, "ignore"), mark) for code in codes))
    except UsageError as error:
        return Comment(line, wrong=str(error))
