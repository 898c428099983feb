r"""From a line of text to words; what the words mean is decided elsewhere.

line    = [ "/" [digit] ] [ ":" number ] { word | comment }  |  "%"
word    = letter number            blanks mean nothing, case means nothing
number  = [ sign ] digits [ "." digits ] | [ sign ] "." digits
comment = "(" text ")" | ";" text to the end of the line
"""

from __future__ import annotations

import re
from operator import itemgetter

from gcodesim.nc.control.place import ProgramError
from gcodesim.nc.iso.block import TOKEN, Block

MAX_LINE_LENGTH = 4096

COMMENT = re.compile(r"\([^()]*\)|;.*", re.DOTALL)
MACRO = re.compile(r"[#\[]|[A-Z](?=[A-Z])|^(?:N[0-9]+)?O<")
"""What only macro text holds: parameters, brackets, words of more than one letter."""

MARKS_16 = ("\xff\xfe", "\xfe\xff")
"""Byte order marks of UTF-16, read as Latin-1."""

LETTER = itemgetter(0)
DELETE = re.compile(r"/[1-9]?")
MESSAGE = re.compile(r"\(\s*(MSG|DEBUG|PRINT)\s*,(.*)\)", re.IGNORECASE | re.DOTALL)


def lex(block: Block) -> None:
    """Fill in tokens, messages and marks of a block from its text.

    Raises:
        ProgramError: a comment is not closed, or the line is too long.
    """
    text = block.text
    if len(text) > MAX_LINE_LENGTH:
        raise block.error("line_too_long", f"{len(text)} characters")
    if "(" in text or ";" in text:
        _blank_comments(block)
    compact = block.code.replace(" ", "").replace("\t", "")
    # Letters beyond ASCII stay as they are: upper() may turn them into words (U+017F into S).
    compact = compact.upper() if compact.isascii() else compact
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
    if block.text.startswith(MARKS_16) or 2 * block.text.count("\0") >= len(block.text) - 1 > 0:
        what += " (the file looks like UTF-16; NC programs are ASCII or UTF-8)"
    return block.error("bad_character", what, index)
