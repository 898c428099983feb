"""Where a program goes on: blocks by number, subprograms by number or label, and their texts."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gcodesim.findings.left_out import NotRun
from gcodesim.nc.control.program_flow import FlowError, ProgramFlow, Source
from gcodesim.nc.control.readings import STANDS_FOR
from gcodesim.nc.detect import contradiction
from gcodesim.nc.iso.block import Block
from gcodesim.nc.iso.listed_programs import stand_for
from gcodesim.nc.iso.memory import IsoState
from gcodesim.nc.iso.parameters import Locals, Parameters
from gcodesim.nc.iso.requests import CallBlock, CallProgram, Request
from gcodesim.nc.iso.saved_modes import end_call
from gcodesim.nc.iso.structure import (
    Structure,
    StructureError,
    block_numbers,
    read_structure,
    returns,
)
from gcodesim.nc.iso.tape import compact, opening

FILE_NAME = re.compile(r"[A-Z0-9_-]{1,64}")


class Jumps:
    """Moves the program flow as the text says.

    Attributes:
        state, flow, parameters: what it works on.
        structures: Source.first -> where that text may jump to.
    """

    def __init__(self, state: IsoState, flow: ProgramFlow, parameters: Parameters) -> None:
        self.state, self.flow, self.parameters = state, flow, parameters
        self.structures: dict[int, Structure] = {}
        self._opened: set[int] = set()
        self._numbers: dict[int, dict[int, list[int]]] = {}
        self._begun: set[bytes] = set()
        self._passes = 0

    def open(self, text: str, file: str) -> None:
        """Begin with the main program.

        Raises:
            ProgramError: it is in another language, or its blocks do not close each other.
        """
        source = self.flow.add(text, file)
        if other := contradiction(source.lines, self.state.control.readings):
            mark, what = other
            raise Block(file, mark.line + 1, mark.text).error("other_language", what)
        try:
            self._read(source)
        except StructureError as error:
            block = Block(file, error.line + 1, source.lines[error.line])
            raise block.error("block_structure", str(error)) from None
        if named := self.state.control.main_program:
            line = next((i for name, i in self._programs(source) if name == named), None)
            if line is None:
                block = Block(file, 1, source.lines[0] if len(source.lines) else "")
                raise block.error("subprogram_not_found", f"{named} in the file")
            source.begin = line
        self.flow.index = source.begin
        self._has_begun_so()

    def _read(self, source: Source) -> None:
        """Find the structure of a text."""
        source.begin, opened = opening(source.lines, tape=self.state.control.readings.tape)
        if opened:
            self._opened.add(source.first)
        self.structures[source.first] = Structure(len(source.lines))
        o_words = self.parameters.rules.o_words
        structure = read_structure(source.lines, source.begin, opened, o_words)
        self.structures[source.first] = structure
        source.end = structure.end

    def is_opened(self, source: Source) -> bool:
        """Tell whether a % ends a text."""
        return source.first in self._opened

    def carry_out(self, request: Request, block: Block) -> None:
        """Do what a block has asked for.

        Raises:
            FlowError: it leads nowhere.
        """
        if isinstance(request, CallProgram):
            self.call_program(request)
        elif isinstance(request, CallBlock):
            flow = self.flow
            line = self._numbered(flow.source, request.number, flow.index)
            self._into(flow.source, line, request.repeats)
        else:
            self._return(request.target, block)

    def _return(self, target: int | None, block: Block) -> None:
        """Return; the main program begins again, until a pass begins as an earlier one did."""
        flow = self.flow
        if not flow.is_main:
            self.leave(block, target)
        elif target is None and self.state.control.readings.m99 == "end":
            self.state.report(
                "main_program_repeats", "M99 in the main program, passes checked: 1", "M99"
            )
            self.state.ended = True
        else:
            self._begin_again(target)

    def _begin_again(self, target: int | None) -> None:
        """Run the main program from its beginning, or from block N, unless that is nothing new.

        What begins in the same state does the same, so that no later pass is another one. A pass
        that ends outside the travel, at which the machine has stopped, is the last one too.
        """
        flow = self.flow
        after, begin = flow.index, flow.source.begin
        if target is not None:
            self.go_to_number(target)
        elif self.parameters.rules.o_words:
            # Where there are o-words, the program is the file, whatever O-numbers stand in it.
            flow.index = begin
        else:
            flow.index = max(self.structures[flow.source.first].span(after - 1)[0], begin)
        self._passes += 1
        if self._has_begun_so() or self.state.is_outside:
            flow.index, self.state.ended = after, True
            what = f"M99 in the main program, passes checked: {self._passes}"
            self.state.report("main_program_repeats", what, "M99")

    def _has_begun_so(self) -> bool:
        """Tell whether a pass has begun at the next line in this very state, and remember it."""
        begun = repr((self.flow.index, self.state.seen(), self.parameters.seen()))
        digest = hashlib.sha256(begun.encode()).digest()
        known = digest in self._begun
        self._begun.add(digest)
        return known

    def leave(self, block: Block, block_number: int | None = None) -> None:
        """Return from the running subprogram, or run it once more.

        Args:
            block: that returns.
            block_number: the block of the caller to go on at; None = after the call.
        """
        calls = len(self.flow.calls)
        self.flow.leave(for_good=block_number is not None)
        if len(self.flow.calls) < calls:
            end_call(self.state, block)
        if block_number is not None:
            self.go_to_number(block_number)

    def go_to_number(self, number: int) -> None:
        """Go on at block N of the running program: the next one after, else from its beginning.

        Raises:
            FlowError: there is none.
        """
        self.flow.index = self._numbered(self.flow.source, number, self.flow.index)

    def _numbered(self, source: Source, number: int, index: int) -> int:
        if source.first not in self._numbers:
            self._numbers[source.first] = block_numbers(source.lines)
        begin, end = self.structures[source.first].span(max(index - 1, 0))
        places = [i for i in self._numbers[source.first].get(number, []) if begin <= i < end]
        if not places:
            raise FlowError("block_not_found", f"N{number}")
        return next((i for i in places if i >= index), places[0])

    def call_program(self, call: CallProgram) -> None:
        """Run subprogram O, or do what the machine file says that it does.

        Raises:
            FlowError: there is none, it cannot be read, or calls nest too deep.
            ProgramError: what it stands for cannot be done.
        """
        found = self.find_program(call.number)
        if isinstance(found, str):
            stand_for(self.state, found, call)
        elif call.arguments is None:
            self._into(*found, call.repeats)
        else:
            self._enter(*found, call.repeats, Locals(call.arguments))

    def find_program(self, number: int) -> tuple[Source, int] | str:
        """Return the text and the line at which subprogram O begins, or a word of STANDS_FOR.

        It is looked for in this text, the main program, a file beside it, and the machine file.

        Raises:
            FlowError: there is none, or it cannot be read.
        """
        for source in (self.flow.source, *self.flow.sources):
            structure = self.structures[source.first]
            line = structure.programs.get(number)
            if number in structure.twice:
                places = f"lines {structure.programs[number] + 1} and {structure.twice[number] + 1}"
                raise FlowError("subprogram_twice", f"O{number} in {places} of {source.file}")
            if line is not None:
                return source, line
        readings = self.state.control.readings
        listed = readings.programs.get(str(number), "")
        names = (f"O{number:04d}.nc", f"O{number}.nc", f"o{number:04d}.nc", f"o{number}.nc")
        try:
            library = "" if listed else readings.library
            source = self._beside(names, f"O{number}", library, equal=True)
        except FlowError as error:
            if error.meaning != "subprogram_not_found" or not listed:
                raise
            if listed in STANDS_FOR:
                return listed
            source = self._added(*self.flow.add_file(Path(listed)))
        inside = self.structures[source.first].programs
        if inside and number not in inside and not listed:
            says = f"{source.file} says O{next(iter(inside))} inside, not O{number}"
            raise FlowError("subprogram_other_number", says)
        return source, inside.get(number, source.begin)

    def call_sub(self, label: str, arguments: list[float | None]) -> None:
        """Run an o-word subprogram of this text, of the main program, or of a file beside it."""
        for source in (self.flow.source, *self.flow.sources):
            if label in self.structures[source.first].subs:
                break
        else:
            if not FILE_NAME.fullmatch(label):
                raise FlowError("subprogram_not_found", f"o<{label.lower()}>")
            name = label.lower()
            library = self.state.control.readings.library
            source = self._beside((f"{name}.ngc", f"{name}.nc"), f"o<{name}>", library)
            if label not in self.structures[source.first].subs:
                raise FlowError("subprogram_not_found", f"o<{name}> in {source.file}")
        numbers: dict[float, float | None] = dict.fromkeys(range(1, 31), 0.0)
        numbers.update(enumerate(arguments[:30], start=1))
        self._enter(source, self.structures[source.first].subs[label] + 1, 1, Locals(numbers))

    def _into(
        self, source: Source, line: int, repeats: int, on_return: Callable[[], None] | None = None
    ) -> bool:
        """Run a subprogram from a line; tell whether it runs at all."""
        entered = self.flow.enter(source, line, repeats, on_return or (lambda: None))
        if entered:
            self.state.saved.append(None)
        return entered

    def _enter(self, source: Source, line: int, repeats: int, own: Locals) -> None:
        """Run a subprogram with local parameters of its own."""
        parameters, before = self.parameters, self.parameters.local

        def take_back() -> None:
            parameters.local = before

        if self._into(source, line, repeats, take_back):
            parameters.local = own

    def _programs(self, source: Source) -> Iterator[tuple[str, int]]:
        """Yield the programs of a text, O-number or <NAME>, with their first lines."""
        for name, line in self.structures[source.first].programs.items():
            yield name if isinstance(name, str) else f"O{name}", line

    def other_programs(self) -> list[tuple[str, int]]:
        """Return what an operator may start in the same file, and nothing has called: with lines.

        Where there are o-words, the program is the file.
        """
        source = self.flow.sources[0]
        structure = self.structures.get(source.first)
        if structure is None or self.parameters.rules.o_words:
            return []
        known = self._run_programs(source, structure)
        return [
            (name, line)
            for name, line in self._programs(source)
            if line not in known and not returns(source.lines, *structure.span(line))
        ]

    def not_run(self, ran: NDArray[np.int32]) -> Iterator[NotRun]:
        """Yield the blocks after the last one of the main program, and programs never called."""
        flow = self.flow
        source = flow.sources[0]
        structure = self.structures.get(source.first)
        if structure is None:
            # The text is in another language, which its finding says: none of it was read.
            return
        main, end = structure.span(source.begin)
        if flow.is_main and main <= flow.index <= end:
            called = [row for row in flow.entered if flow.index <= row < end]
            last = min([end, *called])
            later = ran[(ran > flow.index) & (ran <= last)]
            begin = int(later.max()) if len(later) else flow.index
            yield from self._blocks(source, begin, last)
        others = sorted(set(structure.programs.values()) - self._run_programs(source, structure))
        if others:
            yield NotRun("programs of the file that were not called", len(others), others[0] + 1)

    def _run_programs(self, source: Source, structure: Structure) -> set[int]:
        """Return the first lines of the programs of a text that have run."""
        flow, main = self.flow, structure.span(source.begin)[0]
        # A program without an end goes on in the next one.
        until = flow.index if flow.is_main else 0
        after = {line for line in structure.programs.values() if main < line < until}
        return flow.entered | after | {main, source.begin}

    def _blocks(self, source: Source, begin: int, end: int) -> Iterator[NotRun]:
        lines = (i for i in range(begin, end) if compact(source.lines[i]) not in ("", "%"))
        if found := list(lines):
            ended = (
                "the program's end" if self.state.ended else "the one at which the check stopped"
            )
            yield NotRun(f"blocks after {ended}", len(found), source.first + found[0] + 1)

    def _beside(
        self, names: tuple[str, ...], what: str, library: str, *, equal: bool = False
    ) -> Source:
        """Return a text of the folder of the main program, or of the library, and no other."""
        return self._added(*self.flow.add_beside(names, what, library, equal=equal))

    def _added(self, source: Source, is_new: bool) -> Source:
        """Return a text of another file, whose structure is known."""
        if is_new:
            if other := contradiction(source.lines, self.state.control.readings):
                raise FlowError("other_language", f"{source.file} {other[1]}")
            try:
                self._read(source)
            except StructureError as error:
                place = f"{source.file}:{error.line + 1}"
                raise FlowError("block_structure", f"{place}: {error}") from None
        return source
