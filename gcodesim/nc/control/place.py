"""A place in a program: the line that is carried out, and what is said about it."""

from __future__ import annotations

from gcodesim.errors import GcodesimError
from gcodesim.findings.codes import Finding
from gcodesim.findings.meanings import MEANINGS


class ProgramError(GcodesimError):
    """A block is refused as a whole; ``finding`` says where and why."""

    def __init__(self, finding: Finding) -> None:
        self.finding = finding
        super().__init__(f"{finding.file}:{finding.line}: {finding.code} {finding.message}")


class Place:
    """One line of a program text.

    A language derives its blocks from it, and says in which column a word stands.

    Attributes:
        file, line, text: where it stands and what stands there.
        row: its line among those of all texts of the program.
    """

    __slots__ = ("file", "line", "row", "text")

    def __init__(self, file: str, line: int, text: str, row: int = 0) -> None:
        self.file, self.line, self.text, self.row = file, line, text, row or line

    def column(self, at: str | int) -> int:
        """Return the 1-based column of a word: a letter, a code such as "G43.4", or its index."""
        return 1

    def finding(self, meaning: str, what: str, at: str | int = "") -> Finding:
        """Return a finding about this line.

        Args:
            meaning: key of MEANINGS.
            what: what is wrong; the table adds what would be right.
            at: the word at fault, see `column`.
        """
        return self.finding_in(meaning, what, self.column(at))

    def finding_in(self, meaning: str, what: str, column: int) -> Finding:
        """Return a finding about a column of this line."""
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

    def error(self, meaning: str, what: str, at: str | int = "") -> ProgramError:
        """Return the error that refuses this line; arguments as for `finding`."""
        return ProgramError(self.finding(meaning, what, at))
