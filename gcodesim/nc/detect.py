"""Recognises the language a program is written in by marks in its first lines."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice

from gcodesim.nc.control.readings import Readings

LINES = 200
"""Lines that are looked at."""

LANGUAGES = {
    "heidenhain": "Klartext of Heidenhain",
    "din_iso": "DIN/ISO of Heidenhain",
    "siemens": "the language of Siemens",
    "okuma": "the language of Okuma",
    "linuxcnc": "o-words of LinuxCNC",
}
"""Language -> what it is called in findings."""

COMMENT = re.compile(r"\([^()]*\)|;.*")

KLARTEXT = re.compile(
    r"^\d*\s*(?:BEGIN PGM \S+ (?:MM|INCH)\b|BLK FORM 0\.1\b|TOOL CALL\b)", re.IGNORECASE
)
DIN_ISO = re.compile(r"^%\S+ +G7[01]\b|^[^(\[#;]*[0-9.]\s*\*\s*$", re.IGNORECASE)
SIEMENS_FILE = re.compile(r"^%_N_\w+_(?:MPF|SPF)\b|^;\$PATH=/_N_", re.IGNORECASE)
SIEMENS_CALL = re.compile(
    r"(?:\bCYCLE[0-9]{2,4}|\bWORKPIECE|\bMSG|=\s*[IAD]C)\s*\($", re.IGNORECASE
)
SIEMENS_WORD = re.compile(
    r"\b(?:TRAORI|TRAFOOF|SUPA|MCALL|GOTOF|G710|[ABC]SPLINE|DEF +REAL)\b"
    r"|\bT=\"|\bCR=|^(?:N[0-9]+ *)?R[0-9]+ *=",
    re.IGNORECASE,
)
OKUMA = re.compile(r"^\$\S+\.MIN%|\bVC[0-9]+\s*=|\bCALL +O[A-Z0-9]+|\bNLAP[0-9]", re.IGNORECASE)
O_WORD = re.compile(
    r"^/?\s*(?:N\s*[0-9.]+\s*)?O\s*(?:[0-9]+|<[^<>]*>|#<[^<>]*>|\[[^;]*\])\s*"
    r"(?:SUB|CALL|IF|WHILE|DO|REPEAT)\b|#\s*<[^<>]*>",
    re.IGNORECASE,
)

BRACKETS = r"\[(?:[^\[\]]|\[(?:[^\[\]]|\[(?:[^\[\]]|\[[^\[\]]*+\])*+\])*+\])*+\]"
"""An expression with brackets in it; `.*` between them would try out every pair of a line."""

BLOCK = re.compile(
    r"[/%:]?(?:[A-Z@^][+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+|#[0-9]+|" + BRACKETS + r"))*"
    r"|#[0-9]+=.*",
    re.IGNORECASE,
)
"""A block of words, without comments and blanks."""

HINTS = {
    "haas": re.compile(r"(?<![A-Z0-9.])(?:G(?:234|254|187|154)|M97)(?![0-9.])", re.IGNORECASE),
    "fanuc": re.compile(r"(?<![A-Z0-9.])G(?:43\.4|68\.2|54\.1)(?![0-9])", re.IGNORECASE),
    "linuxcnc": re.compile(r"(?<![A-Z0-9.])M42[89](?![0-9.])", re.IGNORECASE),
    "grbl": re.compile(r"^\s*\$(?:[HXCIGN$#]\s*$|J=|[0-9]+=)", re.IGNORECASE),
}
"""Dialect -> codes that it has and its neighbours rather not."""

NEIGHBOUR = re.compile(
    r"\b(?:MITSUBISHI|MELDAS|MAZAK|MAZATROL|BROTHER|SPEEDIO|HURCO|WINMAX|ISNC|MAKINO|DOOSAN|"
    r"HYUNDAI|MORI|FADAL|CENTROID|MACH3|UCCNC)\b",
    re.IGNORECASE,
)
"""Controls near to a dialect, which comments name; they are read as what nothing else tells."""


@dataclass(frozen=True)
class Mark:
    """What tells the language of a text.

    Attributes:
        language: key of LANGUAGES, or a dialect.
        line: index of its line.
        text: the line.
    """

    language: str
    line: int
    text: str

    @property
    def quoted(self) -> str:
        """Where the mark stands, and its line."""
        text = self.text.strip()
        return f"line {self.line + 1}: {text[:60]}{'...' * (len(text) > 60)}"


def marks_of(lines: Sequence[str]) -> dict[str, Mark]:
    """Return the first exclusive mark of each language in the first lines of a text."""
    first = list(islice(lines, LINES))
    head = "\n".join(first).upper()
    found = {}
    for language, parts in PARTS.items():
        # Most texts hold no part of a mark: their lines need not be looked at.
        if any(part in head for part in parts):
            is_mark = TESTS[language]
            index = next((i for i, line in enumerate(first) if is_mark(line.strip())), None)
            if index is not None:
                found[language] = Mark(language, index, first[index])
    return found


def _is_klartext(line: str) -> bool:
    return KLARTEXT.search(line) is not None


def _is_din_iso(line: str) -> bool:
    return DIN_ISO.search(line) is not None


def _is_siemens(line: str) -> bool:
    before, opened, after = line.partition("(")
    call = SIEMENS_CALL.search(before.partition(";")[0] + opened)
    # A message of LinuxCNC is a comment, one of Siemens has quotes.
    if call and (after[:1] == '"' or not before.upper().endswith("MSG")):
        return True
    file = SIEMENS_FILE.search(line)
    return bool(file or SIEMENS_WORD.search(COMMENT.sub(" ", line)))


def _is_okuma(line: str) -> bool:
    return OKUMA.search(COMMENT.sub(" ", line)) is not None


def _is_o_word(line: str) -> bool:
    return O_WORD.search(COMMENT.sub(" ", line)) is not None


TESTS: dict[str, Callable[[str], bool]] = {
    "heidenhain": _is_klartext,
    "din_iso": _is_din_iso,
    "siemens": _is_siemens,
    "okuma": _is_okuma,
    "linuxcnc": _is_o_word,
}
"""Language -> whether a line, without blanks around it, belongs to it and to no other one."""

PARTS = {
    "heidenhain": ("PGM", "BLK", "TOOL"),
    "din_iso": ("G70", "G71", "*"),
    "siemens": (
        *("_N_", "CYCLE", "WORKPIECE", "MSG", "C(", "C (", "TRA", "SUPA", "MCALL", "GOTOF"),
        *("G710", "SPLINE", "DEF", "="),
    ),
    "okuma": ("$", "VC", "CALL", "NLAP"),
    "linuxcnc": ("<", "SUB", "CALL", "IF", "WHILE", "DO", "REPEAT"),
}
"""Language -> texts of which every mark holds one."""


def contradiction(lines: Sequence[str], readings: Readings) -> tuple[Mark, str] | None:
    """Return the mark of another language than the one that is read, and what to say about it."""
    marks = marks_of(lines)
    own = marks.pop("linuxcnc", None) if readings.macros == "o_words" else None
    if not marks:
        return None
    other = min(marks.values(), key=lambda mark: mark.line)
    what = f"reads like {LANGUAGES[other.language]} ({other.quoted})"
    if own is not None:
        return other, f"{what} and like {LANGUAGES[own.language]} ({own.quoted})"
    return other, f"{what}, the dialect is {readings.dialect}"


def reads_like_program(lines: Sequence[str]) -> bool:
    """Tell whether the lines are mostly blocks with words, or hold the mark of a language."""
    texts = ["".join(COMMENT.sub("", line).split()) for line in islice(lines, LINES)]
    texts = [text for text in texts if text.strip("%")]
    blocks = sum(BLOCK.fullmatch(text) is not None for text in texts)
    codes = any(re.search(r"[GM][0-9]", text, re.IGNORECASE) for text in texts)
    return (codes and 2 * blocks > len(texts)) or bool(marks_of(lines))


def dialect_of(lines: Sequence[str], rows: Mapping[str, Readings]) -> tuple[str, Mark | None]:
    """Return the dialect that a text is written in, and what tells it; fanuc where nothing does.

    Args:
        lines: the text.
        rows: the dialects that can be read.
    """
    told = [mark for language, mark in marks_of(lines).items() if language in rows]
    if told:
        return told[0].language, told[0]
    hints: dict[str, Mark] = {}
    for index, line in enumerate(islice(lines, LINES)):
        text = COMMENT.sub(" ", line)
        for dialect, pattern in HINTS.items():
            if dialect not in hints and pattern.search(text):
                hints[dialect] = Mark(dialect, index, line)
    if len(hints) == 1:
        ((dialect, mark),) = hints.items()
        return dialect, mark
    return "fanuc", None


def neighbour_of(lines: Sequence[str]) -> str:
    """Return the control near to Fanuc that the comments of a text name, or an empty string."""
    for line in islice(lines, LINES):
        for comment in COMMENT.findall(line):
            if found := NEIGHBOUR.search(comment):
                return found[0]
    return ""
