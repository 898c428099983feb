"""A block: one line of a program, its words, and what to say when it is refused."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gcodesim.errors import ProgramError
from gcodesim.findings.codes import Finding
from gcodesim.findings.meanings import MEANINGS

if TYPE_CHECKING:
    from gcodesim.nc.iso.statements import Statement
    from gcodesim.nc.iso.words import Row

CALLS = ("M97", "M98", "M99", "G65")

Token = tuple[str, str | float, str]
"""Letter and number of a word, or "", "" and a character that belongs to no word.

The number is the text in the program, or what its expression is worth.
"""


class Block:
    """One line of a program on its way from text to meaning.

    Attributes:
        file, line, text: where it stands and what stands there.
        row: its line among those of all sources.
        compact: the code without blanks and delete mark, in capitals.
        places: where each token stands in `compact`; None = one behind the other.
        arguments: words of a macro call, in the order written.
        corner: letter and size of ,R or ,C; no letter without it.
        code: the text with comments blanked, so that columns stay.
        tokens: words in the order written, numbers as text.
        messages: MSG, DEBUG or PRINT, and text, of such comments.
        deleted: begins with a block delete mark.
        is_lexed, is_macro, is_read: step 1 is behind; it found macro text; step 2 is behind.
        statement: what the macro text says, once it was parsed.
        rows: rows of the table of codes that its G and M words name, in the order written.
        values: values of the other words, without ignored ones.
        ignored: at least one word was dropped because its letter is ignored.
        moves: its axis or centre words belong to the motion code.
    """

    __slots__ = (
        "arguments",
        "code",
        "compact",
        "corner",
        "deleted",
        "file",
        "ignored",
        "is_lexed",
        "is_macro",
        "is_read",
        "line",
        "messages",
        "moves",
        "places",
        "row",
        "rows",
        "statement",
        "text",
        "tokens",
        "values",
    )

    def __init__(self, file: str, line: int, text: str, row: int = 0) -> None:
        self.file, self.line, self.text, self.row = file, line, text, row or line
        self.code = self.compact = text
        self.places: list[int] | None = None
        self.arguments: list[tuple[str, float]] = []
        self.corner = ("", 0.0)
        self.tokens: list[Token] = []
        self.messages: tuple[tuple[str, str], ...] = ()
        self.deleted = self.is_lexed = self.is_macro = self.is_read = False
        self.statement: Statement | None = None
        self.rows: list[Row] = []
        self.values: dict[str, float] = {}
        self.ignored = self.moves = False

    def has(self, letter: str, number: int) -> bool:
        """Tell whether the block holds this code, number in tenths."""
        for row in self.rows:  # noqa: SIM110 - asked for every move, and any() is twice as slow
            if row.number == number and row.letter == letter:
                return True
        return False

    @property
    def call(self) -> str:
        """The code of this block that calls or returns."""
        return next((row.name for row in self.rows if row.name in CALLS), "")

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
        index = at if isinstance(at, int) else self._index(at)
        return self._finding(meaning, what, self._column(index))

    def error_at(self, place: int, meaning: str, what: str) -> ProgramError:
        """Return the error that refuses this block, at an index of `compact`."""
        return ProgramError(self._finding(meaning, what, self._column_of(place)))

    def _finding(self, meaning: str, what: str, column: int) -> Finding:
        code, right = MEANINGS[meaning]
        return Finding(
            code,
            f"{what}: {right}",
            meaning=meaning,
            file=self.file,
            line=self.line,
            column=column,
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
        if self.places is not None:
            return self._column_of(self.places[index] if index < len(self.places) else 0)
        behind = sum(sum(map(len, map(str, token))) for token in self.tokens[index:])
        return self._column_of(len(self.compact) - behind)

    def _column_of(self, place: int) -> int:
        """Return the 1-based column of an index of `compact`."""
        columns = [i for i, character in enumerate(self.code) if character not in " \t"]
        # Both end together; a delete mark may be missing in front.
        place += len(columns) - len(self.compact)
        return columns[place] + 1 if 0 <= place < len(columns) else 1
