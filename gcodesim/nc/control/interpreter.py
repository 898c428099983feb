"""Interprets a program: line by line through its language, and runs of plain lines at once.

A line is accepted whole or not at all: an error takes back what the line has recorded, and nothing
after it is interpreted.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Generic

import numpy as np

from gcodesim.errors import OrientationError
from gcodesim.findings.codes import Finding
from gcodesim.findings.left_out import NotRun
from gcodesim.nc.control.language_base import Language, Line
from gcodesim.nc.control.place import Place, ProgramError
from gcodesim.nc.control.program_flow import AllLines, Source
from gcodesim.nc.control.readings import ReadingMet
from gcodesim.nc.control.runs import Runs
from gcodesim.nc.program import CanonicalProgram, Kind, Turning

ENDS = (2, 30)
"""Numbers of Kind.STOP that end a program."""


@dataclass(frozen=True)
class Interpretation:
    """What a program means.

    Attributes:
        program: canonical commands up to the end, or to the block that stopped interpretation.
        findings: in the order met; repeated ones once, with their count.
        blocks: blocks interpreted.
        last_line: line of the last block interpreted, 0 when there is none.
        ignored: letters and codes dropped by the machine file: "word E (34148 times)".
        unsupported: codes that were not followed: "G41 line 12".
        readings: keys of the readings that are not known and that the program depends on.
        stopped: a finding ended interpretation before the program's end.
        lines: the lines of all texts, one after the other; line n is lines[n - 1].
        not_run: what did not run, or may run in another way.
        other_programs: main programs of the file that nothing has called, with their lines.
        files: name of every text, and the number of lines before it; the main program first.
        looked_up: files that were looked for -> mark of their content, "" where there is none.
    """

    program: CanonicalProgram
    findings: tuple[Finding, ...]
    blocks: int
    last_line: int
    ignored: tuple[str, ...]
    unsupported: tuple[str, ...]
    readings: tuple[ReadingMet, ...]
    stopped: bool
    lines: Sequence[str]
    files: tuple[tuple[str, int], ...]
    not_run: tuple[NotRun, ...] = ()
    other_programs: tuple[tuple[str, int], ...] = ()
    looked_up: Mapping[str, str] = field(default_factory=dict)

    def place(self, line: int) -> tuple[str, int]:
        """Return the file that a line of `lines` stands in, and its number there."""
        file, before = next(entry for entry in reversed(self.files) if entry[1] < max(line, 1))
        return file, line - before


class Interpreter(Generic[Line]):
    """Takes one program through its language.

    Attributes:
        language: reads the lines, and tells the control what they say.
    """

    def __init__(self, language: Language[Line], progress: Callable[[float], None]) -> None:
        self.language, self._progress = language, progress
        self.state, self._flow = language.state, language.flow
        self._runs = Runs(language)

    def run(self, text: str, file: str) -> Interpretation:
        """Interpret all lines up to the program's end or the first refused block."""
        state, sources = self.state, self._flow.sources
        stopped = not self._open(text, file) or not self._run_lines()
        if not stopped and not state.ended:
            lines = sources[0].lines
            state.place = Place(file, max(len(lines), 1), lines[-1] if lines else "")
            state.report("program_end_missing", "the program has no end")
        program = self._with_halts(state.recorder.program(state.start))
        return Interpretation(
            program=program,
            findings=state.findings,
            blocks=state.blocks,
            last_line=state.last_line,
            ignored=tuple(
                f"{what} ({count} time{'s' * (count > 1)})" for what, count in state.ignored.items()
            ),
            unsupported=tuple(state.unsupported),
            readings=tuple(state.met.values()),
            stopped=stopped,
            lines=AllLines(sources) if len(sources) > 1 else sources[0].lines,
            files=tuple((source.file, source.first) for source in sources),
            not_run=tuple(self._not_run(program)),
            other_programs=tuple(self.language.other_programs()),
            looked_up=self._flow.looked_up,
        )

    def _with_halts(self, program: CanonicalProgram) -> CanonicalProgram:
        """Let the spindle stand where M0 or M1 may have stopped it, which matters to feed moves."""
        turning = program.turning
        if turning is None or not (halted := turning == Turning.HALTED).any():
            return program
        fed = np.flatnonzero(halted & np.isin(program.kind, (Kind.FEED, Kind.ARC)))
        if len(fed):
            key = "spindle_at_stop"
            self.state.met[key] = ReadingMet(key, int(program.line[fed[0]]), len(fed))
        return replace(program, turning=np.where(halted, np.uint8(Turning.STANDS), turning))

    def _not_run(self, program: CanonicalProgram) -> Iterator[NotRun]:
        yield from self.language.not_run(program.line)
        for what, (count, first) in self.state.passed.items():
            yield NotRun(what, count, first)
        stops = np.flatnonzero((program.kind == Kind.STOP) & ~np.isin(program.aux, ENDS))
        if len(stops):
            what = "stops, at which an operator may do anything"
            yield NotRun(what, len(stops), int(program.line[stops[0]]))

    def _open(self, text: str, file: str) -> bool:
        """Read the program's structure; return False when it cannot run."""
        try:
            self.language.open(text, file)
        except ProgramError as error:
            self.state.keep(error.finding)
            return False
        return True

    def _run_lines(self) -> bool:
        """Run lines; return False when one of them ended interpretation."""
        state, flow, language = self.state, self._flow, self.language
        most, take = flow.most_blocks, self._runs.take
        while not state.ended:
            source, index = flow.source, flow.index
            if index >= source.end:
                return self._text_ended(source, index)
            left = most - state.blocks - state.holes
            if taken := take(source, index, left):
                flow.index = index + taken
                self._progress(flow.index / len(source.lines))
                continue
            state.place = place = language.place(source, index)
            flow.index = index + 1
            if left <= 0:
                # Texts that were called meanwhile have lines of their own.
                most = flow.most_blocks
                if state.blocks + state.holes >= most:
                    state.report("max_blocks", flow.limit_reached)
                    return False
            mark = len(state.recorder)
            try:
                language.run(place)
            except ProgramError as error:
                return self._refused(mark, error.finding)
            except OrientationError as error:
                return self._refused(mark, place.finding(error.meaning, str(error)))
        return True

    def _refused(self, mark: int, finding: Finding) -> bool:
        """Take back what a line has recorded, and keep why."""
        self.state.recorder.truncate(mark)
        self.state.keep(finding)
        return False

    def _text_ended(self, source: Source, index: int) -> bool:
        """Tell whether the main program may end here, after its text; a subprogram may not."""
        self.state.ended = index < len(source.lines)
        if self._flow.is_main:
            return True
        self.state.place = self.language.place(source, max(index - 1, 0))
        self.state.report("block_structure", self.language.unfinished())
        return False
