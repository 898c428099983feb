r"""From a line of text to words; what the words mean is decided elsewhere.

line    = [ "/" [digit] ] [ ":" number ] { word | comment }  |  "%"  |  "<" name ">"
word    = letter number            blanks mean nothing, case means nothing; @ ^ $ are letters
number  = [ sign ] digits [ "." digits ] | [ sign ] "." digits
comment = "(" text ")" | ";" text to the end of the line

Text as from a tape (Readings.tape) may hold "/" [digit] between words too.
"""

from __future__ import annotations

import re
from operator import itemgetter

from gcodesim.nc.control.place import ProgramError
from gcodesim.nc.iso.block import TOKEN, Block
from gcodesim.nc.iso.tape import NAMED
from gcodesim.nc.lines import TAPE_CHARACTERS

MAX_LINE_LENGTH = 4096

COMMENT = re.compile(r"\([^()]*\)|;.*", re.DOTALL)
MACRO = re.compile(r"[#\[<]|[A-Z](?=[A-Z])|^(?:N[0-9.]+)?O<")
"""What only macro text holds: parameters, brackets, words of more than one letter."""

MARKS_16 = ("\xff\xfe", "\xfe\xff")
"""Byte order marks of UTF-16, read as Latin-1."""

LETTER = itemgetter(0)
DELETE = re.compile(r"/[1-9]?")
DELETE_AFTER_N = re.compile(r"(N[0-9]+)/[1-9]?")
DELETE_INSIDE = re.compile(r"/[1-9]?(?=[A-Z](?![A-Z]))")
"""A / before a word; before anything else it divides."""

NAME = re.compile(r"<[^<>]*>")
NAMED_PROGRAM = re.compile(r"O<[^<>]*>")
TAPE = str.maketrans(dict.fromkeys(map(ord, TAPE_CHARACTERS), " "))
MESSAGE = re.compile(r"\(\s*(MSG|DEBUG|PRINT)\s*,(.*)\)", re.IGNORECASE | re.DOTALL)


def lex(block: Block, *, tape: bool, delete: bool) -> None:
    """Fill in tokens, messages and marks of a block from its text.

    Args:
        block: takes them.
        tape: see Readings.
        delete: what stands after a / inside the block is left out.

    Raises:
        ProgramError: a comment is not closed, or the line is too long.
    """
    text = block.text
    if len(text) > MAX_LINE_LENGTH:
        raise block.error("line_too_long", f"{len(text)} characters")
    if "(" in text or ";" in text:
        _blank_comments(block)
    if tape and not block.code.isprintable() and not _is_wide(block.code):
        block.code = block.code.translate(TAPE)
    compact = _compacted(block.code)
    if tape and "/" in compact[1:]:
        compact = _without_delete_mark(block, compact, delete)
    if tape and compact[:1] == "%" and NAMED.fullmatch(compact):
        compact = compact[1:]
    if tape and compact[:1] == "<" and NAME.fullmatch(compact):
        # The name of a program, as 30i and 0i-F write it.
        compact = ""
    if not tape and NAMED_PROGRAM.fullmatch(compact):
        # It heads the file; a call names the file.
        compact = ""
    if compact[:1] == "/":
        block.deleted = True
        compact = DELETE.sub("", compact, count=1)
    elif compact[:1] == ":":
        compact = "O" + compact[1:]
    block.compact = compact
    block.is_lexed = True
    if "#" in compact or "[" in compact:
        # The words of macro text are found with their values.
        block.is_macro = True
        return
    block.tokens = TOKEN.findall(compact)
    # Macro text is never made of words alone.
    strays = "" in map(LETTER, block.tokens)
    block.is_macro = strays and MACRO.search(compact) is not None


def _compacted(code: str) -> str:
    compact = code.replace(" ", "").replace("\t", "")
    # Letters beyond ASCII stay as they are: upper() may turn them into words (U+017F into S).
    return compact.upper() if compact.isascii() else compact


def _without_delete_mark(block: Block, compact: str, delete: bool) -> str:
    """Blank a delete mark inside a block, and what it leaves out; return what is left, compact."""
    match = DELETE_AFTER_N.match(compact)
    if match:
        begin, end = match.end(1), match.end()
    else:
        found = DELETE_INSIDE.finditer(compact, 1)
        marks = [m for m in found if _is_between_words(compact, m)]
        if not marks:
            return compact
        begin, end = marks[0].span()
    columns = [i for i, character in enumerate(block.code) if character not in " \t"]
    first, last = columns[begin], columns[-1] if delete else columns[end - 1]
    code = block.code
    block.code = code[:first] + " " * (last + 1 - first) + code[last + 1 :]
    return _compacted(block.code)


def _is_between_words(compact: str, mark: re.Match[str]) -> bool:
    """Tell whether a / stands outside of brackets, and does not divide in an assignment."""
    before = compact[: mark.start()]
    divides = "=" in before and len(mark[0]) > 1
    return before.count("[") == before.count("]") and not divides


def _blank_comments(block: Block) -> None:
    """Turn comments into blanks and keep their messages."""
    block.code = COMMENT.sub(_blanks, block.text)
    if "," in block.text:
        found = map(MESSAGE.fullmatch, COMMENT.findall(block.text))
        block.messages = tuple((match[1].upper(), match[2]) for match in found if match)
    if (place := block.code.find("(")) >= 0:
        block.tokens = [("", "", character) for character in block.code if character not in " \t"]
        index = block.tokens.index(("", "", "("))
        block.compact = "".join(token[2] for token in block.tokens)
        if ")" in block.text[place:]:
            raise block.error("comment_nested", "( inside a comment", index)
        raise block.error("comment_unclosed", "( without )", index)


def _blanks(match: re.Match[str]) -> str:
    return " " * len(match[0])


def not_a_word(block: Block, index: int) -> ProgramError:
    """Return the error for token `index`, which is no word."""
    character = block.tokens[index][2]
    if character.isalpha() and character.isascii():
        return block.error("number_expected", f"{character} without a number", index)
    what = repr(character)
    if _is_wide(block.text):
        what += " (the file looks like UTF-16; NC programs are ASCII or UTF-8)"
    return block.error("bad_character", what, index)


def _is_wide(text: str) -> bool:
    """Tell whether a text looks like UTF-16: every other character of it is NUL."""
    halves = text[::2], text[1::2]
    pairs = zip(halves, halves[::-1], strict=True)
    padded = any(set(half) == {"\0"} and "\0" not in other for half, other in pairs)
    return text.startswith(MARKS_16) or (padded and len(text) > 2)
