"""Which block runs next: jumps, loops, subprograms and the files they come from."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, overload

from gcodesim.errors import UsageError
from gcodesim.nc.iso.parameters import Level, Parameters
from gcodesim.nc.iso.structure import Structure, StructureError, block_numbers, read_structure
from gcodesim.nc.lines import Lines, read_program, split_lines

MAX_CALLS = 10
"""Calls may nest this deep, as on LinuxCNC; Fanuc allows fewer."""

FILE_NAME = re.compile(r"[A-Z0-9_-]{1,64}")


class FlowError(Exception):
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
        first: number of its line 1 among the lines of all sources, less 1.
        begin: index of the first line that runs.
        opened: it began with %.
    """

    file: str
    lines: Lines
    first: int
    begin: int
    opened: bool
    structure: Structure
    numbers: dict[int, list[int]] | None = None


@dataclass(slots=True)
class Call:
    """A running subprogram: where it returns to, and where it begins again.

    Attributes:
        source, back: where the caller goes on.
        start: line index at which the subprogram begins.
        again: how often it still runs after this time.
        level: the caller's local parameters; None when they are shared.
        repeats: counts of o-word loops of the caller.
    """

    source: Source
    back: int
    start: int
    again: int
    level: Level | None
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


@dataclass(slots=True)
class Flow:
    """Where interpretation stands.

    Attributes:
        sources: texts read so far, the main program first.
        source, index: the line to run next.
        calls: running subprograms, the innermost last.
        line_count: lines of all sources.
    """

    parameters: Parameters
    sources: list[Source] = field(default_factory=list)
    source: Source = field(init=False)
    index: int = 0
    calls: list[Call] = field(default_factory=list)
    line_count: int = 0
    _repeats: dict[int, int] = field(default_factory=dict)

    def open(self, text: str, file: str) -> None:
        """Begin with the main program.

        Raises:
            StructureError: its blocks do not close each other.
        """
        self.source = self._add(text, file)
        self.index = self.source.begin

    def _add(self, text: str, file: str) -> Source:
        lines = split_lines(text)
        begin, opened = _opening_percent(lines)
        source = Source(file, lines, self.line_count, begin, opened, Structure(len(lines)))
        self.line_count += len(lines)
        self.sources.append(source)
        o_words = self.parameters.rules.o_words
        source.structure = read_structure(lines, begin, opened, o_words)
        return source

    @property
    def is_main(self) -> bool:
        """No subprogram runs."""
        return not self.calls

    def go_to_number(self, number: int) -> None:
        """Go on at block N of the running program: the next one behind, else from its beginning.

        Raises:
            FlowError: there is none.
        """
        self.index = self._numbered(self.source, number, self.index)

    def _numbered(self, source: Source, number: int, index: int) -> int:
        if source.numbers is None:
            source.numbers = block_numbers(source.lines)
        begin, end = source.structure.span(max(index - 1, 0))
        places = [i for i in source.numbers.get(number, []) if begin <= i < end]
        if not places:
            raise FlowError("block_not_found", f"N{number}")
        return next((i for i in places if i >= index), places[0])

    def call_block(self, number: int, repeats: int) -> None:
        """Run from block N of the running program to M99 (M97)."""
        self._enter(self.source, self._numbered(self.source, number, self.index), repeats, False)

    def call_program(self, number: int, repeats: int, arguments: Level | None = None) -> None:
        """Run subprogram O of this text, of the main program, or of a file beside it.

        Args:
            number: its O-number.
            repeats: how often.
            arguments: new local parameters; None = those of the caller stay.

        Raises:
            FlowError: there is none, it cannot be read, or calls nest too deep.
        """
        source, line = self.find_program(number)
        self._enter(source, line, repeats, arguments is not None)
        if arguments is not None:
            self.parameters.level = arguments

    def find_program(self, number: int) -> tuple[Source, int]:
        """Return the text and the line at which subprogram O begins.

        Raises:
            FlowError: there is none, or it cannot be read.
        """
        for source in (self.source, *self.sources):
            line = source.structure.programs.get(number)
            if line is not None:
                return source, line
        names = (f"O{number:04d}.nc", f"O{number}.nc", f"o{number:04d}.nc", f"o{number}.nc")
        source = self._beside(names, f"O{number}")
        return source, source.structure.programs.get(number, source.begin)

    def call_sub(self, label: str, arguments: list[float | None]) -> None:
        """Run an o-word subprogram of this text, of the main program, or of a file beside it."""
        for source in (self.source, *self.sources):
            if label in source.structure.subs:
                break
        else:
            if not FILE_NAME.fullmatch(label):
                raise FlowError("subprogram_not_found", f"o<{label.lower()}>")
            name = label.lower()
            source = self._beside((f"{name}.ngc", f"{name}.nc"), f"o<{name}>")
            if label not in source.structure.subs:
                raise FlowError("subprogram_not_found", f"o<{name}> in {source.file}")
        self._enter(source, source.structure.subs[label] + 1, 1, True)
        self.parameters.level = Level(
            {i: arguments[i - 1] if i <= len(arguments) else 0.0 for i in range(1, 31)}
        )

    def _enter(self, source: Source, line: int, repeats: int, own_level: bool) -> None:
        if len(self.calls) == MAX_CALLS:
            raise FlowError("call_too_deep", f"call number {MAX_CALLS + 1} inside the others")
        if repeats < 1:
            return
        level = self.parameters.level if own_level else None
        call = Call(self.source, self.index, line, repeats - 1, level, self._repeats)
        self.calls.append(call)
        self.source, self.index, self._repeats = source, line, {}

    def leave(self, block_number: int | None = None) -> None:
        """Return from the running subprogram, or run it once more.

        Args:
            block_number: the block of the caller to go on at; None = behind the call.
        """
        call = self.calls[-1]
        if call.again and block_number is None:
            call.again -= 1
            self.index = call.start
            return
        self.calls.pop()
        self.source, self.index, self._repeats = call.source, call.back, call.repeats
        if call.level is not None:
            self.parameters.level = call.level
        if block_number is not None:
            self.go_to_number(block_number)

    def restart(self) -> None:
        """Begin the running program anew."""
        self.index = self.source.structure.span(self.index - 1)[0]
        self.index = max(self.index, self.source.begin)

    def count_down(self, line: int, times: int | None = None) -> bool:
        """Count an o-word loop down; tell whether it runs once more."""
        left = self._repeats.get(line, 0) - 1 if times is None else times
        self._repeats[line] = left
        return left > 0

    def _beside(self, names: tuple[str, ...], what: str) -> Source:
        """Return a text that stands in the folder of the main program, and nowhere else."""
        main = Path(self.sources[0].file)
        if not main.is_file():
            raise FlowError("subprogram_not_found", what)
        folder = main.resolve().parent
        for name in names:
            path = folder / name
            known = next((s for s in self.sources if s.file == str(main.parent / name)), None)
            if known:
                return known
            if path.is_file() and path.resolve().parent == folder:
                try:
                    return self._add(read_program(path), str(main.parent / name))
                except UsageError as error:
                    raise FlowError("subprogram_not_found", str(error)) from None
                except StructureError as error:
                    place = f"{self.sources[-1].file}:{error.line + 1}"
                    raise FlowError("block_structure", f"{place}: {error}") from None
        raise FlowError("subprogram_not_found", f"{what} (no {names[0]} beside the program)")


def _opening_percent(lines: Lines) -> tuple[int, bool]:
    """Return the index of the first line to run, and whether a % stands before it."""
    for index, line in enumerate(lines):
        if line.strip():
            opened = line.strip() == "%"
            return index + 1 if opened else index, opened
    return len(lines), False
