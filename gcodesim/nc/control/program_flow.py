"""Which line runs next: the texts of a program, the subprograms that run, and the limits."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, overload

from gcodesim.constants import MAX_BLOCKS, MAX_REPEATED_BLOCKS
from gcodesim.errors import GcodesimError, UsageError
from gcodesim.input_file import file_mark
from gcodesim.nc.lines import Lines, read_program, split_lines

MAX_CALLS = 10
"""Calls may nest this deep, as on LinuxCNC; Fanuc allows fewer."""


class FlowError(GcodesimError):
    """A jump or call that leads nowhere.

    Attributes:
        meaning: key of MEANINGS.
    """

    def __init__(self, meaning: str, what: str) -> None:
        self.meaning = meaning
        super().__init__(what)


@dataclass(slots=True)
class Source:
    """One program text.

    Attributes:
        file: name for findings.
        lines: its lines.
        first: number of its line 1 among the lines of all sources, less 1.
        begin: index of the first line that runs.
        end: index of the line that closes the text, or the number of lines.
    """

    file: str
    lines: Lines
    first: int
    begin: int
    end: int


@dataclass(slots=True)
class Call:
    """A running subprogram: where it returns to, and where it begins again.

    Attributes:
        source, back: where the caller goes on.
        start: line index at which the subprogram begins.
        again: how often it still runs after this time.
        on_return: called when it has returned for good.
        repeats: counts of the caller's loops.
    """

    source: Source
    back: int
    start: int
    again: int
    on_return: Callable[[], None]
    repeats: dict[int, int]


class AllLines(Sequence[str]):
    """The lines of all sources, one after the other."""

    def __init__(self, sources: list[Source]) -> None:
        self._sources = sources

    def __len__(self) -> int:
        return sum(len(source.lines) for source in self._sources)

    @overload
    def __getitem__(self, index: int) -> str: ...
    @overload
    def __getitem__(self, index: slice) -> list[str]: ...
    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        index += len(self) if index < 0 else 0
        for source in self._sources:
            if 0 <= index - source.first < len(source.lines):
                return source.lines[index - source.first]
        raise IndexError(index)


def _nothing() -> None:
    """Do nothing when a subprogram returns."""


@dataclass(slots=True)
class ProgramFlow:
    """Where interpretation stands.

    Attributes:
        max_blocks: limit of blocks that the user gave, None for the usual one.
        sources: texts read so far, the main program first.
        source, index: the line to run next.
        calls: running subprograms, the innermost last.
        line_count: lines of all sources.
        entered: lines, counted through all sources, at which subprograms have begun.
        looked_up: files that were looked for -> mark of their content, "" where there is none.
    """

    max_blocks: int | None = None
    sources: list[Source] = field(default_factory=list)
    source: Source = field(init=False)
    index: int = 0
    calls: list[Call] = field(default_factory=list)
    line_count: int = 0
    entered: set[int] = field(default_factory=set)
    looked_up: dict[str, str] = field(default_factory=dict)
    _repeats: dict[int, int] = field(default_factory=dict)

    def add(self, text: str, file: str) -> Source:
        """Take in a program text; the first one is the main program, which runs next."""
        lines = split_lines(text)
        source = Source(file, lines, self.line_count, 0, len(lines))
        self.line_count += len(lines)
        self.sources.append(source)
        if len(self.sources) == 1:
            self.source = source
        return source

    def add_beside(
        self, names: Iterable[str], what: str, library: str = "", *, equal: bool = False
    ) -> tuple[Source, bool]:
        """Return a text that stands in the folder of the main program, and whether it is new.

        Args:
            names: of files, the first one found is taken.
            what: is looked for.
            library: another folder, looked through after that one.
            equal: no name goes before another: files of several names must hold the same.

        Raises:
            FlowError: there is none, or there are several, or it cannot be read.
        """
        names, main = list(names), Path(self.sources[0].file)
        folders = [main.parent] if main.is_file() else []
        for folder in [*folders, *([Path(library)] if library else [])]:
            found = self._found(folder, names)
            if equal and len({self.looked_up[str(path)] for path in found}) > 1:
                raise FlowError("subprogram_twice", f"{what} in {found[0]} and in {found[1]}")
            if found:
                return self.add_file(found[0])
        where = f" (no {names[0]} beside the program)" if folders else ""
        raise FlowError("subprogram_not_found", what + where)

    def _found(self, folder: Path, names: Iterable[str]) -> list[Path]:
        """Return the files of some names in a folder, and not elsewhere by a link."""
        paths = [folder / name for name in names]
        for path in paths:
            self._look_up(path)
        return [p for p in paths if p.is_file() and p.resolve().parent == folder.resolve()]

    def add_file(self, path: Path) -> tuple[Source, bool]:
        """Return the text of a file, and whether it is new.

        Raises:
            FlowError: it cannot be read.
        """
        if known := next((s for s in self.sources if s.file == str(path)), None):
            return known, False
        self._look_up(path)
        try:
            return self.add(read_program(path), str(path)), True
        except UsageError as error:
            raise FlowError("subprogram_not_found", str(error)) from None

    def _look_up(self, path: Path) -> None:
        self.looked_up.setdefault(str(path), file_mark(path))

    @property
    def is_main(self) -> bool:
        """No subprogram runs."""
        return not self.calls

    def enter(
        self, source: Source, line: int, repeats: int, on_return: Callable[[], None] = _nothing
    ) -> bool:
        """Run a subprogram from a line; tell whether it runs at all.

        Args:
            source: its text.
            line: index of its first line.
            repeats: how often it runs.
            on_return: called when it has returned for good.

        Raises:
            FlowError: calls nest too deep.
        """
        if len(self.calls) == MAX_CALLS:
            raise FlowError("call_too_deep", f"call number {MAX_CALLS + 1} inside the others")
        if repeats < 1:
            return False
        call = Call(self.source, self.index, line, repeats - 1, on_return, self._repeats)
        self.calls.append(call)
        self.entered.add(source.first + line)
        self.source, self.index, self._repeats = source, line, {}
        return True

    def leave(self, *, for_good: bool = False) -> None:
        """Return from the running subprogram, or run it once more.

        Args:
            for_good: it returns, however often it should still run.
        """
        call = self.calls[-1]
        if call.again and not for_good:
            call.again -= 1
            self.index = call.start
            return
        self.calls.pop()
        self.source, self.index, self._repeats = call.source, call.back, call.repeats
        call.on_return()

    def count_down(self, line: int, times: int | None = None) -> bool:
        """Count the loop that opens at a line down; tell whether it runs once more."""
        left = self._repeats.get(line, 0) - 1 if times is None else times
        self._repeats[line] = left
        return left > 0

    @property
    def most_blocks(self) -> int:
        """After how many blocks interpretation ends, by the texts read so far."""
        return self.max_blocks or min(MAX_BLOCKS, self.line_count + MAX_REPEATED_BLOCKS)

    @property
    def limit_reached(self) -> str:
        """Which limit of blocks was reached, and how to raise it."""
        if self.max_blocks:
            return f"limit of {self.max_blocks} blocks, given with --max-blocks"
        what = f"{MAX_BLOCKS:,} blocks"
        if self.most_blocks < MAX_BLOCKS:
            what = f"{MAX_REPEATED_BLOCKS:,} blocks that repeat"
        return f"limit of {what}; --max-blocks N allows more"
