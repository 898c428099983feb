"""A block: one line of a program, its words, and what to say when it is refused."""

from __future__ import annotations

import re
from collections.abc import Sequence

from gcodesim.nc.control.place import Place, ProgramError
from gcodesim.nc.iso.code_rows import Row
from gcodesim.nc.iso.statements import Statement

# One pass finds words; what is no word comes out, character by character, as the third group.
TOKEN = re.compile(r"([A-Z@^$])([+-]?+(?:[0-9]++\.?+[0-9]*+|\.[0-9]++))|(.)", re.DOTALL)

CALLS = ("M97", "M98", "M99", "G65")

CORNER = ","
"""In Block.bare: the number of the corner word."""

Token = tuple[str, str | float, str]
"""Letter and number of a word, or "", "" and a character that belongs to no word.

The number is the text in the program, or the value of its expression.
"""


class Block(Place):
    """One line of a program on its way from text to meaning.

    Attributes:
        compact: the code without blanks and delete mark, in capitals.
        places: where each token stands in `compact`; None = one after the other.
        arguments: words of a macro call, in the order written.
        corner: letter and size of ,R or ,C; no letter without it.
        bare: words whose numbers have no decimal point and are not 0, where that matters: letters
            of `values`, CORNER, indices of `arguments`.
        code: the text with comments blanked, so that columns stay.
        tokens: words in the order written, numbers as text.
        messages: MSG, DEBUG or PRINT, and text, of such comments.
        deleted: begins with a block delete mark.
        is_lexed, is_macro, is_read: step 1 is done; it found macro text; step 2 is done.
        statement: what the macro text says, once it was parsed.
        numbers, known: with which numbers it says that, as text and as values.
        rows: rows of the table of codes that its G and M words name, in the order written.
        values: values of the other words, without ignored ones.
        ignored: at least one word was dropped because its letter is ignored.
        moves: its axis or centre words belong to the motion code.
    """

    __slots__ = (
        "arguments",
        "bare",
        "code",
        "compact",
        "corner",
        "deleted",
        "ignored",
        "is_lexed",
        "is_macro",
        "is_read",
        "known",
        "messages",
        "moves",
        "numbers",
        "places",
        "rows",
        "statement",
        "tokens",
        "values",
    )

    def __init__(self, file: str, line: int, text: str, row: int = 0) -> None:
        super().__init__(file, line, text, row)
        self.code = self.compact = text
        self.places: list[int] | None = None
        self.arguments: list[tuple[str, float]] = []
        self.bare: list[str | int] = []
        self.corner = ("", 0.0)
        self.tokens: list[Token] = []
        self.messages: tuple[tuple[str, str], ...] = ()
        self.deleted = self.is_lexed = self.is_macro = self.is_read = False
        self.statement: Statement | None = None
        self.numbers: Sequence[str] = ()
        self.known: Sequence[float] = ()
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

    def error_at(self, place: int, meaning: str, what: str) -> ProgramError:
        """Return the error that refuses this block, at an index of `compact`."""
        return ProgramError(self.finding_in(meaning, what, self._column_of(self._own(place))))

    def _own(self, place: int) -> int:
        """Return the index in `compact` of an index in the text the statement was read from."""
        return self.statement.place_in(self.numbers, place) if self.statement else place

    def column(self, at: str | int) -> int:
        """Return the 1-based column of a letter, a code such as "G43.4", or a token by its index.

        Words are read from a copy of the line without blanks; only a finding needs the place in
        the line itself, so it is looked up here and not carried along.
        """
        if self.is_macro and self.places is None and not self.tokens:
            self.tokens = TOKEN.findall(self.compact)
        index = at if isinstance(at, int) else self._index(at)
        if self.places is not None:
            place = self.places[index] if index < len(self.places) else 0
            return self._column_of(self._own(place))
        rest = sum(sum(map(len, map(str, token))) for token in self.tokens[index:])
        return self._column_of(len(self.compact) - rest)

    def _index(self, word: str) -> int:
        """Return the index of the first token that is the letter or code `word`, else 0."""
        letter, number = word[:1], word[1:]
        for index, token in enumerate(self.tokens):
            if token[0] == letter and (not number or float(token[1]) == float(number)):
                return index
        return 0

    def _column_of(self, place: int) -> int:
        """Return the 1-based column of an index of `compact`."""
        columns = [i for i, character in enumerate(self.code) if character not in " \t"]
        # Both end together; a delete mark may be missing in front.
        place += len(columns) - len(self.compact)
        return columns[place] + 1 if 0 <= place < len(columns) else 1
