"""From program text to canonical commands, block by block, in numbered steps.

Step 1 reads characters into words, step 2 words into codes and values, step 3 checks the block as
a whole, step 4 executes it in the order of the table of codes. A block is accepted whole or not at
all: an error takes back what the block has recorded, and nothing behind it is interpreted.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from gcodesim.constants import MAX_BLOCKS, MAX_REPEATED_BLOCKS
from gcodesim.errors import OrientationError, ProgramError
from gcodesim.findings.codes import Finding
from gcodesim.nc.control.program_flow import AllLines, Flow, FlowError, Source
from gcodesim.nc.control.runs import Runs
from gcodesim.nc.control.state import LIMIT, State
from gcodesim.nc.control.supply import Control
from gcodesim.nc.iso import motion as moves
from gcodesim.nc.iso.block import Block
from gcodesim.nc.iso.calls import ARGUMENTS
from gcodesim.nc.iso.calls_ahead import missing_call
from gcodesim.nc.iso.lexer import explain, lex
from gcodesim.nc.iso.macros import Macros
from gcodesim.nc.iso.parameters import Parameters
from gcodesim.nc.iso.structure import StructureError
from gcodesim.nc.iso.words import WORDS, Group, Order, Row, codes_for, unknown_m
from gcodesim.nc.program import CanonicalProgram, Kind

END_OF_MOTION = 800
AXIS_LETTERS = frozenset("XYZABCUVW")
ALWAYS_USED = frozenset("NOFST")
CENTRE_WORDS = frozenset("IJKR")
VECTOR_WORDS = frozenset("IJK")
MACRO_CALL = 650
ARGUMENT_LETTERS = ARGUMENTS.keys() | set("IJK")
CYCLE_WORDS = frozenset("RQPIJKL")
NO_MOTION = Row("G", END_OF_MOTION, Group.MOTION, Order.MOTION, "", "No motion mode")
PERCENT = [("", "", "%")]

KEPT_BLOCKS = 1 << 14
"""Blocks whose words are kept, for loops and subprograms."""


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
        stopped: a finding ended interpretation before the program's end.
        lines: the lines of all texts, one behind the other; line n is lines[n - 1].
        files: name of every text, and the number of lines before it; the main program first.
    """

    program: CanonicalProgram
    findings: tuple[Finding, ...]
    blocks: int
    last_line: int
    ignored: tuple[str, ...]
    unsupported: tuple[str, ...]
    stopped: bool
    lines: Sequence[str]
    files: tuple[tuple[str, int], ...]

    @property
    def line_count(self) -> int:
        """Number of lines of all program texts."""
        return len(self.lines)

    def place(self, line: int) -> tuple[str, int]:
        """Return the file that a line of `lines` stands in, and its number there."""
        file, before = next(entry for entry in reversed(self.files) if entry[1] < max(line, 1))
        return file, line - before


def interpret(
    text: str,
    control: Control,
    file: str = "",
    progress: Callable[[float], None] = lambda fraction: None,
) -> Interpretation:
    """Interpret a program.

    Args:
        text: program text (reader.read_program).
        control: what the control knows before the program starts.
        file: name for findings; subprograms are read from the folder it stands in.
        progress: called now and then with the fraction of the lines that is behind.

    Returns:
        The canonical program and what there is to say about it. Never raises for bad programs.
    """
    return Interpreter(control, file, progress).run(text)


class Interpreter:
    """Takes one program through the steps.

    Attributes:
        state: where the control stands.
        blocks, last_line: blocks interpreted, and the line of the last.
    """

    def __init__(self, control: Control, file: str, progress: Callable[[float], None]) -> None:
        self.control, self.file, self._progress = control, file, progress
        self.state = State(control)
        self.blocks = self.last_line = 0
        parameters = Parameters(self.state)
        self._flow = Flow(parameters)
        self._macros = Macros(self.state, parameters, self._flow)
        self._runs = Runs(self.state)
        self._codes = codes_for(control)
        self._kept: dict[int, Block] = {}
        self._has_jumped = False
        self._rows: dict[tuple[str, str | float], Row] = {}
        self._known: dict[tuple[object, ...], tuple[list[Row], bool]] = {}

    def run(self, text: str) -> Interpretation:
        """Interpret all lines up to the program's end or the first refused block."""
        state, sources = self.state, self._flow.sources
        state.emit(Kind.G5X, Block(self.file, 0, ""), state.frames.g5x, aux=1)
        state.emit(Kind.G92, Block(self.file, 0, ""), state.frames.g92)
        stopped = not self._open(text) or not self._run_lines()
        if not stopped and not state.ended:
            lines = sources[0].lines
            block = Block(self.file, max(len(lines), 1), lines[-1] if lines else "")
            state.report(block.finding("program_end_missing", "the program has no end"))
        return Interpretation(
            program=state.recorder.program(state.start),
            findings=state.findings,
            blocks=self.blocks,
            last_line=self.last_line,
            ignored=tuple(
                f"{what} ({count} time{'s' * (count > 1)})" for what, count in state.ignored.items()
            ),
            unsupported=tuple(state.unsupported),
            stopped=stopped,
            lines=AllLines(sources) if len(sources) > 1 else sources[0].lines,
            files=tuple((source.file, source.first) for source in sources),
        )

    def _open(self, text: str) -> bool:
        """Read the program's structure; return False when it cannot run: blocks, calls."""
        try:
            self._flow.open(text, self.file)
        except StructureError as error:
            line = self._flow.sources[0].lines[error.line]
            block = Block(self.file, error.line + 1, line)
            self.state.report(block.finding("block_structure", str(error)))
            return False
        missing = missing_call(self._flow, self.control.readings)
        if missing is None:
            return True
        index, code, why = missing
        block = self._block(self._flow.sources[0], index)
        try:
            lex(block)
        except ProgramError:
            # Something else is wrong with the block, which it will say when it runs.
            return True
        self.state.report(block.finding(why.meaning, str(why), code))
        return False

    def _run_lines(self) -> bool:
        """Run blocks; return False when one of them ended interpretation."""
        state, flow = self.state, self._flow
        most = self._most_blocks()
        while not state.ended:
            source, number = flow.source, flow.index
            if number >= source.structure.end:
                return self._text_ended(source, number)
            left = most - self.blocks - state.holes
            if taken := self._runs.take(source, number, left):
                flow.index = number + taken
                self.blocks += self._runs.blocks
                self.last_line = self._runs.last_line or self.last_line
                self._progress(flow.index / len(source.lines))
                continue
            block = self._block(source, number)
            flow.index = number + 1
            mark = len(state.recorder)
            if left <= 0:
                # Texts that were called meanwhile have lines of their own.
                most = self._most_blocks()
                if self.blocks + state.holes >= most:
                    state.report(block.finding("max_blocks", self._limit_reached()))
                    return False
            try:
                self._run_block(block)
            except ProgramError as error:
                state.recorder.truncate(mark)
                state.report(error.finding)
                return False
            except OrientationError as error:
                state.recorder.truncate(mark)
                state.report(block.finding(error.meaning, str(error)))
                return False
            self._has_jumped = self._has_jumped or flow.index != number + 1
        return True

    def _most_blocks(self) -> int:
        """Return after how many blocks interpretation ends, by the texts read so far."""
        repeated = self._flow.line_count + MAX_REPEATED_BLOCKS
        return self.control.max_blocks or min(MAX_BLOCKS, repeated)

    def _limit_reached(self) -> str:
        """Say which limit of blocks was reached, and how to raise it."""
        if self.control.max_blocks:
            return f"limit of {self.control.max_blocks} blocks, given with --max-blocks"
        what = f"{MAX_BLOCKS:,} blocks"
        if self._most_blocks() < MAX_BLOCKS:
            what = f"{MAX_REPEATED_BLOCKS:,} blocks that repeat"
        return f"limit of {what}; --max-blocks N allows more"

    def _text_ended(self, source: Source, number: int) -> bool:
        """Tell whether the main program may end here, behind its text; a subprogram may not."""
        self.state.ended = number < len(source.lines)
        if self._flow.is_main:
            return True
        block = self._block(source, max(number - 1, 0))
        what = "the subprogram ends without M99 or endsub"
        self.state.report(block.finding("block_structure", what))
        return False

    def _block(self, source: Source, number: int) -> Block:
        """Return the block of a line; one that has run before knows its words already.

        Blocks are kept from the first jump on: before it, none can run again.
        """
        row = source.first + number + 1
        if block := self._kept.get(row):
            return block
        block = Block(source.file, number + 1, source.lines[number], row)
        if self._has_jumped:
            if len(self._kept) == KEPT_BLOCKS:
                self._kept.clear()
            self._kept[row] = block
        return block

    def _run_block(self, block: Block) -> None:
        # Step 1: characters to words.
        if not block.is_lexed:
            lex(block)
        if not block.compact and not block.messages:
            return
        if block.deleted and self.control.block_delete:
            return
        statement = self._macros.read(block) if block.is_macro else None
        for kind, text in block.messages:
            shown = text if kind == "MSG" else self._macros.message(text)
            self.state.recorder.message(block.row, shown)
        self.blocks += 1
        self.last_line = block.row
        if block.tokens or statement is None:
            self._run_words(block)
        if statement is not None:
            self._macros.go_on(block, statement)

    def _run_words(self, block: Block) -> None:
        # Step 2: words to codes and values; those of macro text may be others every time.
        if not block.is_read or block.is_macro or block.ignored:
            self._read(block)
        # Steps 3 and 4.
        waiting = self.state.corner
        for row in self._checked(block):
            if row.action is not None:
                row.action(self.state, block, row.number)
        if waiting is not None or block.corner[0]:
            self._check_corner(block, waiting)
        if self.state.request is not None:
            request, self.state.request = self.state.request, None
            try:
                request(self._flow)
            except FlowError as error:
                raise block.error(error.meaning, str(error), block.call) from None

    def _read(self, block: Block) -> None:
        """Step 2: find the row of every code, and keep the value of every other word."""
        block.is_read = True
        block.arguments, called = [], False
        rows: list[Row] = []
        values: dict[str, float] = {}
        block.rows, block.values = rows, values
        codes, ignore = self._rows, self.control.readings.ignore_words
        block.corner, behind_comma = ("", 0.0), -1
        for index, (letter, number, _) in enumerate(block.tokens):
            if index == behind_comma:
                continue
            if letter == "G" or (letter == "M" and not called):
                row = codes.get((letter, number)) or self._row(block, letter, number, index)
                rows.append(row)
                called = called or (row.number == MACRO_CALL and letter == "G")
            elif not letter and self._corner(block, index):
                behind_comma = index + 1
            elif not letter:
                raise self._stray(block, index)
            elif called and letter in ARGUMENT_LETTERS:
                self._argument(block, letter, number, index)
            elif letter in ignore:
                block.ignored = True
                self.state.ignored[f"word {letter}"] += 1
            elif letter in values:
                raise block.error("duplicate_word", f"{letter} twice", index)
            else:
                value = values[letter] = float(number)
                if not -LIMIT <= value <= LIMIT and letter != "N":
                    raise block.error("number_too_large", f"{letter}{number}", index)

    def _argument(self, block: Block, letter: str, number: str | float, index: int) -> None:
        """Keep a word behind G65; only I J K may be repeated."""
        if letter not in "IJK" and any(letter == other for other, _ in block.arguments):
            raise block.error("duplicate_word", f"{letter} twice", index)
        block.arguments.append((letter, float(number)))

    def _corner(self, block: Block, index: int) -> bool:
        """Tell whether a comma begins a corner word of Fanuc; keep the word, and take it away."""
        tokens = block.tokens
        if tokens[index][2] != "," or not self.control.readings.comma_corners:
            return False
        letter, number, _ = tokens[index + 1] if index + 1 < len(tokens) else ("", "", "")
        if letter not in ("R", "C") or block.corner[0]:
            raise block.error("corner_not_followed", f"a comma before {letter or 'no word'}", index)
        block.corner = letter, float(number)
        return True

    def _check_corner(self, block: Block, waiting: object) -> None:
        """Check that a corner met a straight block, and that a corner word began another one."""
        if waiting is not None and self.state.corner is waiting:
            raise block.error("corner_not_followed", "no straight block behind a corner")
        if block.corner[0] and self.state.corner is None:
            raise block.error("corner_not_followed", "a corner without a straight block", ",")

    def _stray(self, block: Block, index: int) -> ProgramError:
        if block.tokens == PERCENT and not self._flow.source.opened:
            return block.error("stray_percent", "% without an opening one", index)
        return explain(block, index)

    def _row(self, block: Block, letter: str, number: str | float, index: int) -> Row:
        """Return the row of a code; rows are kept by the text of the number."""
        tenths = round(min(max(float(number), -LIMIT), LIMIT) * 10)
        row = self._codes.get((letter, tenths))
        if row is None and letter == "G":
            self.state.unsupported.append(f"G{number} line {block.line}")
            raise block.error("unknown_g", f"unknown code G{number}", index)
        row = row or unknown_m(tenths)
        self._rows[letter, number] = row
        return row

    def _checked(self, block: Block) -> list[Row]:
        """Step 3, once for all blocks of the same codes and letters in the same motion mode."""
        values, modal = block.values, self.state.modal
        key = (*block.rows, *values, modal.motion, modal.cycle, modal.tcp, block.ignored)
        known = self._known.get(key)
        if known is None:
            rows = self._check(block)
            if "O" not in values:
                self._known[key] = rows, block.moves
            return rows
        rows, block.moves = known
        if "N" in values and not _is_block_number(values["N"]):
            raise block.error("integer_expected", f"N{values['N']:g}", "N")
        return rows

    def _check(self, block: Block) -> list[Row]:
        """Step 3: check the block as a whole; return the rows to execute, in their order.

        Raises:
            ProgramError: codes or words of the block do not go together.
        """
        rows = self._agreeing_rows(block)
        motion = next((row for row in rows if row.order is Order.MOTION), None)
        others = [row for row in rows if row is not motion]
        axis_words = block.values.keys() & AXIS_LETTERS
        if block.ignored and not axis_words:
            # Every word was ignored: G92 E0 sets nothing, G28 E0 goes nowhere.
            others = [row for row in others if not row.takes_axes]
        # Axis words belong to the code that takes them, and only else to motion.
        takers = [
            row
            for row in others
            if (row.takes_axes or axis_words & set(row.words)) and not (row.optional and motion)
        ]
        if len(takers) > 1:
            what = f"{takers[0].name} and {takers[1].name} both take axis words"
            raise block.error("modal_conflict", what, takers[1].name)
        active = motion or self._active(rows)
        vectors = active.action is moves.straight and self._takes_vectors(block)
        if not takers:
            free = block.values.keys() - set("".join(row.words for row in others))
            centred = motion is not None or free & CENTRE_WORDS
            turns = active.action is moves.arc and centred
            block.moves = bool(axis_words or turns or (vectors and free & VECTOR_WORDS))
            kept = active.group is Group.CYCLE and bool(free & CYCLE_WORDS)
            others += [active] if block.moves or motion or kept else []
        unclaimed = "unused_word" if takers else "axis_without_motion"
        self._check_words(block, others, unclaimed, VECTOR_WORDS if vectors else frozenset())
        others += [motion] if takers and motion else []
        others += [row for letter, row in WORDS.items() if letter in block.values]
        return sorted(others, key=lambda row: row.order)

    def _active(self, rows: list[Row]) -> Row:
        """Return the row of the motion code in force, of a block with these rows of its own."""
        modal = self.state.modal
        ended = any(row.group is Group.CYCLE for row in rows)
        if ended and self.control.readings.g80 == "motion":
            return NO_MOTION
        if modal.cycle and not ended:
            return self._codes["G", modal.cycle]
        return self._codes["G", modal.motion] if modal.motion != END_OF_MOTION else NO_MOTION

    def _agreeing_rows(self, block: Block) -> list[Row]:
        """Return the rows less a G80 that does nothing; refuse conflicts and refused codes."""
        rows = block.rows
        if any(row.order is Order.MOTION for row in rows):
            # G80 beside another motion code: the other code ends the cycle, or begins one.
            rows = [row for row in rows if row.number != END_OF_MOTION or row.letter != "G"]
        groups: dict[Group, Row] = {}
        for row in rows:
            group = Group.MOTION if row.group is Group.CYCLE else row.group
            first = groups.setdefault(group, row)
            if first is not row and group is not Group.NONE:
                what = f"{first.name} and {row.name} are of one group"
                raise block.error("modal_conflict", what, row.name)
        for row in rows:
            if row.refused:
                self.state.unsupported.append(f"{row.name} line {block.line}")
                raise block.error("unknown_g", f"{row.name} ({row.refused})", row.name)
        return rows

    def _takes_vectors(self, block: Block) -> bool:
        """Tell whether a straight move takes I J K as the direction of the tool (G43.5)."""
        length = [row.number for row in block.rows if row.group is Group.LENGTH]
        return (length or [self.state.modal.tcp])[-1] == moves.VECTORS

    def _check_words(
        self, block: Block, rows: list[Row], unclaimed: str, more: frozenset[str]
    ) -> None:
        """Check that a code uses every letter, and that the machine has every axis.

        Args:
            block: the block.
            rows: rows whose words may be used.
            unclaimed: meaning of an axis word that none of them uses.
            more: further letters that are used.
        """
        used = ALWAYS_USED.union(more, *(row.words for row in rows))
        other_use = frozenset("".join(row.words for row in rows if not row.takes_axes))
        for letter, value in block.values.items():
            is_axis = letter in AXIS_LETTERS
            if is_axis and letter not in self.control.axes and letter not in other_use:
                self.state.unsupported.append(f"word {letter} line {block.line}")
                raise block.error("unknown_word", f"{letter} is no axis here", letter)
            if letter not in used or (letter == "O" and block.tokens[0][0] != "O"):
                meaning = unclaimed if is_axis else "unused_word"
                raise block.error(meaning, f"{letter}{value:g}", letter)
            if letter == "N" and not _is_block_number(value):
                raise block.error("integer_expected", f"N{value:g}", "N")


def _is_block_number(value: float) -> bool:
    return value >= 0 and value == value // 1
