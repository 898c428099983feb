"""A block: one line of a program, its words, and what to say when it is refused."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gcodesim.errors import ProgramError
from gcodesim.findings import Finding
from gcodesim.nc.meanings import MEANINGS

if TYPE_CHECKING:
    from gcodesim.nc.codes import Row

Token = tuple[str, str, str]
"""Letter and number of a word, or "", "" and a character that belongs to no word."""


class Block:
    """One line of a program on its way from text to meaning.

    Attributes:
        file, line, text: where it stands and what stands there.
        code: the text with comments blanked, so that columns stay.
        tokens: words in the order written, numbers as text.
        messages: texts of (MSG, ...) comments.
        deleted: begins with a block delete mark.
        rows: rows of the table of codes that its G and M words name, in the order written.
        values: values of the other words, without ignored ones.
        ignored: at least one word was dropped because its letter is ignored.
        moves: its axis or centre words belong to the motion code.
    """

    __slots__ = (
        "code",
        "deleted",
        "file",
        "ignored",
        "line",
        "messages",
        "moves",
        "rows",
        "text",
        "tokens",
        "values",
    )

    def __init__(self, file: str, line: int, text: str) -> None:
        self.file, self.line, self.text = file, line, text
        self.code = text
        self.tokens: list[Token] = []
        self.messages: tuple[str, ...] = ()
        self.deleted = False
        self.rows: list[Row] = []
        self.values: dict[str, float] = {}
        self.ignored = self.moves = False

    def has(self, letter: str, number: int) -> bool:
        """Tell whether the block holds this code, number in tenths."""
        for row in self.rows:  # noqa: SIM110 - asked for every move, and any() is twice as slow
            if row.number == number and row.letter == letter:
                return True
        return False

    def whole(self, letter: str) -> int:
        """Return the value of a word that must be a whole number, 0 or more.

        Raises:
            ProgramError: it is not.
        """
        value = self.values[letter]
        if value < 0:
            raise self.error("negative_word", f"{letter}{value:g}", letter)
        if not value.is_integer():
            raise self.error("integer_expected", f"{letter}{value:g}", letter)
        return int(value)

    def not_negative(self, letter: str) -> float:
        """Return the value of a word that must be 0 or more.

        Raises:
            ProgramError: it is not.
        """
        value = self.values[letter]
        if value < 0:
            raise self.error("negative_word", f"{letter}{value:g}", letter)
        return value

    def error(self, meaning: str, what: str, at: str | int = "") -> ProgramError:
        """Return the error that refuses this block; arguments as for `finding`."""
        return ProgramError(self.finding(meaning, what, at))

    def finding(self, meaning: str, what: str, at: str | int = "") -> Finding:
        """Return a finding about this block.

        Args:
            meaning: key of MEANINGS.
            what: what is wrong; the table adds what would be right.
            at: the word at fault: a letter, a code such as "G43.4", or the index of a token.
        """
        code, right = MEANINGS[meaning]
        index = at if isinstance(at, int) else self._index(at)
        return Finding(
            code,
            f"{what}: {right}",
            meaning=meaning,
            file=self.file,
            line=self.line,
            column=self._column(index),
            block=self.text,
        )

    def _index(self, word: str) -> int:
        """Return the index of the first token that is the letter or code `word`, else 0."""
        letter, number = word[:1], word[1:]
        for index, token in enumerate(self.tokens):
            if token[0] == letter and (not number or float(token[1]) == float(number)):
                return index
        return 0

    def _column(self, index: int) -> int:
        """Return the 1-based column at which token `index` begins.

        Words are read from a copy of the line without blanks; only a finding needs the place in
        the line itself, so it is looked up here and not carried along.
        """
        places = [i for i, character in enumerate(self.code) if character not in " \t"]
        lengths = [sum(map(len, token)) for token in self.tokens]
        place = len(places) - sum(lengths[index:])
        return places[place] + 1 if place < len(places) else 1
