"""Plain blocks read by the thousand: from bytes to columns of words, not character by character.

A block is plain when it holds nothing but blanks, one of CODES, a code of COOLANT, N, F, S, T, Q,
axis and arc words, each once, with numbers of up to 15 digits. Such numbers are an exact mantissa
over an exact power of ten, whose quotient is correctly rounded, so they equal those that float()
makes. Whatever is not plain for any reason is left to the reader, block by block, which knows what
to say about it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gcodesim.nc.control.columns import MOTION, Bools, Columns, Floats, Ints
from gcodesim.nc.iso.lexer import MAX_LINE_LENGTH
from gcodesim.nc.lines import Lines

DIGIT, POINT, SIGN, LETTER, END, OTHER = range(6)
"""Kinds of characters; all but digits are marks, between which the digits stand."""

DIGITS = 8
"""Digits before or after the point that one 64-bit word holds."""

CODES = np.array([0.0, 1.0, 2.0, 3.0, 73.0, 74.0, 81.0, 82.0, 83.0, 84.0, 85.0, 86.0, 89.0])
"""G codes of plain blocks: lines, arcs, and cycles that a run of holes may repeat."""

COOLANT = np.array([7.0, 8.0, 9.0])
"""M codes of plain blocks: nothing here depends on them."""

PLAIN_WORDS = "GMNFSTIJKRQ"
"""Letters of plain blocks, besides axes."""

NEVER_IGNORED = frozenset("GM")
"""Letters of codes: a code is looked up before its letter could be dropped."""

MANTISSA = 15
"""Digits up to which a whole number is exact in float64."""


def _kinds() -> bytes:
    kinds = bytearray([OTHER] * 256)
    kinds[ord("0") : ord("9") + 1] = bytes([DIGIT] * 10)
    kinds[ord("A") : ord("Z") + 1] = bytes([LETTER] * 26)
    kinds[ord(".")], kinds[ord("\n")] = POINT, END
    kinds[ord("+")] = kinds[ord("-")] = SIGN
    return bytes(kinds)


KINDS = _kinds()
CAPITALS = bytes(range(256)).upper()
BLANKS = b" \t"


def _allowed() -> Bools:
    """Return which mark may follow which, without and with digits between."""
    allowed = np.zeros((6, 6, 2), bool)
    for mark in (LETTER, SIGN):
        allowed[mark, [LETTER, END], 1] = True
        allowed[mark, POINT] = True
    allowed[LETTER, SIGN, 0] = True
    allowed[POINT, [LETTER, END]] = True
    allowed[END, [LETTER, END], 0] = True
    return allowed.reshape(-1)


ALLOWED = _allowed()
ENDS = np.array([END, END], np.uint8)
# The last n characters of eight, as digits; the units stand in the highest byte.
LAST = np.array([(0x0F0F0F0F0F0F0F0F >> 8 * (8 - n)) << 8 * (8 - n) for n in range(9)], np.uint64)
POWERS = 10.0 ** np.arange(DIGITS + 1)


def scan(
    lines: Lines,
    first: int,
    last: int,
    axes: str,
    ignored: frozenset[str],
    shortest: int = 1,
    points: frozenset[str] = frozenset(),
) -> Columns:
    """Read lines first to last (excluded) into columns.

    Args:
        lines: the text.
        first: index of the first line.
        last: index after the last.
        axes: axis letters of the machine.
        ignored: letters that are dropped and counted.
        shortest: lines of the shortest run.
        points: letters for which it matters whether their numbers have a decimal point.
    """
    data = lines.data[lines.bounds[first] : lines.bounds[last] - 1] + b"\n"
    # Eight characters in front let every number be read as a whole word.
    text = b"0" * DIGITS + data.translate(CAPITALS, BLANKS)
    kinds = np.frombuffer(text.translate(KINDS), np.uint8)
    # A line end before the first line and two after the last spare all special cases.
    marks = np.concatenate(
        ([DIGITS - 1], np.flatnonzero(kinds != DIGIT), [len(text), len(text) + 1])
    )
    kind = np.concatenate((ENDS[:1], kinds[marks[1:-2]], ENDS))
    gap = np.diff(marks) - 1
    line = np.cumsum(kind == END) - 1
    pair = kind[:-1] * np.uint8(12) + kind[1:] * np.uint8(2) + (gap > 0)
    bad = ~ALLOWED[pair]
    lonely = (kind[1:-1] == POINT) & (gap[:-1] == 0) & (gap[1:] == 0)
    bad[1:] |= lonely
    count = last - first
    # After the last line end stand the two marks that were added.
    plain = np.ones(count + 3, bool)
    plain[line[:-1][bad]] = False

    letter = np.flatnonzero(kind == LETTER)
    value, exact, bare = _values(text, marks, kind, letter)
    word_line, name = line[letter], np.frombuffer(text, np.uint8)[marks[letter]]
    plain[word_line[~exact]] = False
    words = Columns(first, plain[:count], np.ones(count, bool), {}, {})
    words.blank[word_line[word_line < count]] = False
    _into_columns(words, word_line, name, value, axes, ignored)
    if points:
        _note_bare(words, word_line, name, bare & (value != 0.0), points - ignored)
    _check(words)
    words.plain &= np.diff(lines.bounds[first : last + 1]) <= MAX_LINE_LENGTH + 1
    words.find_runs(shortest)
    return words


def _values(
    text: bytes, marks: Ints, kind: NDArray[np.uint8], letter: Ints
) -> tuple[Floats, Bools, Bools]:
    """Return the numbers after the letters, and two properties of each.

    Returns:
        the numbers; whether they are short enough to be exact; whether they have no decimal point.
    """
    before = letter + (kind[letter + 1] == SIGN)
    point = kind[before + 1] == POINT
    begin, middle, end = marks[before], marks[before + 1], marks[before + point + 1]
    whole_count, length = middle - begin - 1, end - begin - 1
    part_count = length - whole_count - point
    exact = (whole_count <= DIGITS) & (part_count <= DIGITS) & (length - point <= MANTISSA)
    eights = np.ndarray((len(text) - 7,), "<u8", text, strides=(1,))
    # Most numbers fit into one word of eight characters, with the point pushed out of it.
    part = LAST[np.minimum(part_count, DIGITS)]
    word = eights[np.minimum(end, len(text)) - DIGITS]
    word = ((word << (point * np.uint64(DIGITS))) & ~part) | (word & part)
    value = _digits(word & LAST[np.minimum(length - point, DIGITS)])
    value /= POWERS[np.minimum(part_count, DIGITS)]
    long = np.flatnonzero(exact & (length > DIGITS))
    if len(long):
        scale = POWERS[part_count[long]]
        whole = _digits(eights[middle[long] - DIGITS] & LAST[whole_count[long]])
        decimals = _digits(eights[end[long] - DIGITS] & LAST[part_count[long]])
        value[long] = (whole * scale + decimals) / scale
    # The character after the letter is a minus only where there is a sign.
    negative = np.frombuffer(text, np.uint8)[marks[letter] + 1] == ord("-")
    np.negative(value, out=value, where=negative)
    return value, exact, ~point


def _digits(digits: NDArray[np.uint64]) -> Floats:
    """Return the numbers of eight digits each.

    Neighbouring digits are joined to pairs, pairs to fours, fours to eights.
    """
    digits = (digits * np.uint64(10) + (digits >> np.uint64(8))) & np.uint64(0x00FF00FF00FF00FF)
    digits = (digits * np.uint64(100) + (digits >> np.uint64(16))) & np.uint64(0x0000FFFF0000FFFF)
    digits = (digits * np.uint64(10_000) + (digits >> np.uint64(32))) & np.uint64(0xFFFFFFFF)
    return digits.astype(np.float64)


def _into_columns(
    words: Columns,
    line: Ints,
    name: NDArray[np.uint8],
    value: Floats,
    axes: str,
    ignored: frozenset[str],
) -> None:
    """Sort the words by letter; a letter that is not plain, or comes twice, spoils its line."""
    count = len(words.plain)
    known, met = np.zeros(256, bool), np.bincount(name, minlength=256)
    for letter in {*PLAIN_WORDS, *axes} | ignored:
        known[ord(letter)] = True
    words.plain[line[~known[name]]] = False
    for letter in (*PLAIN_WORDS, *axes):
        if letter in ignored - NEVER_IGNORED or not met[ord(letter)]:
            continue
        found = np.flatnonzero(name == ord(letter))
        where = line[found]
        words.plain[where[1:][where[1:] == where[:-1]]] = False
        words.has[letter] = np.zeros(count, bool)
        words.value[letter] = np.zeros(count)
        words.has[letter][where] = True
        words.value[letter][where] = value[found]
    first_met = {letter: np.flatnonzero(name == ord(letter)) for letter in ignored - NEVER_IGNORED}
    for letter, found in sorted(first_met.items(), key=lambda item: item[1][:1].tolist()):
        if len(found):
            words.ignored[letter] = np.bincount(line[found], minlength=count)


def _note_bare(
    words: Columns,
    line: Ints,
    name: NDArray[np.uint8],
    bare: NDArray[np.bool_],
    letters: frozenset[str],
) -> None:
    """Keep which lines hold which of the letters, among words without a decimal point."""
    wanted = np.zeros(256, bool)
    wanted[[ord(letter) for letter in letters]] = True
    at = np.flatnonzero(bare & wanted[name])
    if not len(at):
        return
    line, name = line[at], name[at]
    for code in np.flatnonzero(np.bincount(name, minlength=256)):
        column = words.bare[chr(code)] = np.zeros(len(words.plain), bool)
        column[line[name == code]] = True


def _check(words: Columns) -> None:
    """Take out what the reader may refuse: other codes, F0, S-1, broken N and T."""
    if "G" in words.has:
        g = words.value[MOTION] = words.value.pop("G")
        words.has[MOTION] = words.has.pop("G")
        words.plain &= np.isin(g, CODES) & ~np.signbit(g)
    if "F" in words.has:
        words.plain &= ~words.has["F"] | (words.value["F"] > 0.0)
    if "M" in words.has:
        m, has = words.value.pop("M"), words.has.pop("M")
        words.plain &= ~has | np.isin(m, COOLANT)
    if "S" in words.has:
        words.plain &= ~np.signbit(words.value["S"])
    if "N" in words.has:
        words.plain &= _is_whole(words.value.pop("N"))
        del words.has["N"]
    if "T" in words.has:
        words.plain &= _is_whole(words.value["T"])


def _is_whole(value: Floats) -> Bools:
    return (value >= 0.0) & (value == np.floor(value))
