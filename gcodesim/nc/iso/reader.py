"""Reads ISO programs, block by block, in numbered steps.

Step 1 reads characters into words, step 2 words into codes and values, step 3 checks the block as
a whole, step 4 carries it out in the order of the table of codes. A block is accepted whole or not
at all.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from gcodesim.findings.left_out import NotRun
from gcodesim.nc.control.columns import Columns
from gcodesim.nc.control.drilling import Hole
from gcodesim.nc.control.language_base import Language
from gcodesim.nc.control.modal import Motion
from gcodesim.nc.control.place import ProgramError
from gcodesim.nc.control.program_flow import FlowError, ProgramFlow, Source
from gcodesim.nc.control.state import LIMIT, Corner
from gcodesim.nc.control.supply import Control
from gcodesim.nc.iso.block import CORNER, Block
from gcodesim.nc.iso.calls import ARGUMENTS
from gcodesim.nc.iso.calls_ahead import missing_call
from gcodesim.nc.iso.checks import Checks
from gcodesim.nc.iso.code_rows import Row
from gcodesim.nc.iso.cycles import next_hole
from gcodesim.nc.iso.g_codes import G
from gcodesim.nc.iso.jumps import Jumps
from gcodesim.nc.iso.lengths import LETTERS, report_bare, report_unit, settle_bare
from gcodesim.nc.iso.lexer import lex, not_a_word
from gcodesim.nc.iso.macros import Macros
from gcodesim.nc.iso.memory import IsoState
from gcodesim.nc.iso.parameters import Parameters
from gcodesim.nc.iso.scan import scan
from gcodesim.nc.iso.words import codes_for, unlisted_m
from gcodesim.nc.lines import Lines

ARGUMENT_LETTERS = ARGUMENTS.keys() | set("IJK")
PERCENT = [("", "", "%")]

KEPT_BLOCKS = 1 << 14
"""Blocks whose words are kept, for loops and subprograms."""


START_MOTION = {"G0": Motion.RAPID, "G1": Motion.FEED}
"""Readings.start_motion -> motion code in force before the first block."""

DOLLAR_MOVES = re.compile(r"\$(?:H|J=)", re.IGNORECASE)
"""Orders to Grbl that move axes: homing, and jogging."""


class IsoReader(Language[Block]):
    """Takes the blocks of one program through the steps."""

    state: IsoState

    def __init__(self, control: Control) -> None:
        state = IsoState(control)
        super().__init__(state, ProgramFlow(control.max_blocks))
        self.state, self.control = state, control
        readings = control.readings
        parameters = Parameters(state)
        self._jumps = Jumps(state, self.flow, parameters)
        self._macros = Macros(state, parameters, self._jumps)
        state.modal.motion = START_MOTION.get(readings.start_motion, Motion.NONE)
        self._codes = codes_for(readings.dialect, readings.g_codes, readings.m_codes)
        self._checked = Checks(state, self._codes).checked
        self._ignored = frozenset(readings.ignore_words)
        self._points = frozenset() if readings.no_point == "units" else LETTERS
        self._kept: dict[int, Block] = {}
        self._has_jumped = False
        self._rows: dict[tuple[str, str | float], Row] = {}

    def open(self, text: str, file: str) -> None:
        """Record what is in force, and read the program's structure: blocks, calls.

        Raises:
            ProgramError: it cannot run.
        """
        self.state.begin(file)
        self._jumps.open(text, file)
        missing = missing_call(self._jumps, self.control.readings.m98_p)
        if missing is None:
            return
        index, code, why = missing
        block = self.place(self.flow.sources[0], index)
        try:
            self._lex(block)
        except ProgramError:
            # Something else is wrong with the block, which it will say when it runs.
            return
        raise block.error(why.meaning, str(why), code)

    def place(self, source: Source, index: int) -> Block:
        """Return the block of a line; one that has run before knows its words already.

        Blocks are kept from the first jump on: before it, none can run again.
        """
        row = source.first + index + 1
        if block := self._kept.get(row):
            return block
        block = Block(source.file, index + 1, source.lines[index], row)
        if self._has_jumped:
            if len(self._kept) == KEPT_BLOCKS:
                self._kept.clear()
            self._kept[row] = block
        return block

    def scan(self, lines: Lines, first: int, last: int, shortest: int) -> Columns:
        """Read lines first to last (excluded) into columns."""
        axes, ignored, points = self.control.axes, self._ignored, self._points
        return scan(lines, first, last, axes, ignored, shortest, points)

    def is_plain(self) -> bool:
        """Tell whether axis words are points, in a known unit, with the tool length in force."""
        state = self.state
        return not state.codes.polar and not state.is_length_doubtful and state.is_unit_told

    def next_hole(self) -> Hole | None:
        """Return what the cycle in force does at the next point."""
        try:
            return next_hole(self.state)
        except ProgramError:
            return None

    def not_run(self, ran: NDArray[np.int32]) -> Iterator[NotRun]:
        """Yield the blocks after the last one, and the programs that nothing called."""
        yield from self._jumps.not_run(ran)

    def other_programs(self) -> list[tuple[str, int]]:
        """Return the main programs of the file that nothing has called, with their lines."""
        return self._jumps.other_programs()

    def unfinished(self) -> str:
        """Return what to report when the text of a subprogram ends without a return."""
        return "the subprogram ends without M99 or endsub"

    def run(self, line: Block) -> None:
        """Carry out a block.

        Raises:
            ProgramError: it is refused.
            OrientationError: no rotary positions hold the tool as it says.
        """
        block = line
        if self._is_order(block):
            return
        # Step 1: characters to words.
        if not block.is_lexed:
            self._lex(block)
        if not block.compact and not block.messages:
            return
        if block.deleted:
            left_out = self.control.block_delete and self.control.readings.slash_deletes
            self.state.pass_by(f"blocks marked /, {'left out' if left_out else 'run'}")
            if left_out:
                return
        if block.is_macro and self.control.readings.macros == "none":
            raise block.error("macro_unsupported", "macro text on a control without macros")
        statement = self._macros.read(block) if block.is_macro else None
        for kind, text in block.messages:
            shown = text if kind == "MSG" else self._macros.message(text)
            self.state.recorder.message(block.row, shown)
        self.state.blocks += 1
        self.state.last_line = block.row
        if block.tokens or statement is None:
            self._run_words(block)
        if statement is not None and statement.control:
            after = self.flow.index
            self._macros.go_on(block, statement)
            self._has_jumped = self._has_jumped or self.flow.index != after

    def _is_order(self, block: Block) -> bool:
        """Tell whether a line is a setting of the control, or an order to it, and no block."""
        text = block.text.lstrip()
        if not text.startswith("$") or not self.control.readings.dollar_lines:
            return False
        if DOLLAR_MOVES.match(text):
            self.state.unsupported.append(f"{text.strip()} line {block.line}")
            raise block.error("unknown_g", f"{text.strip()}: the control moves by itself", "$")
        return True

    def _lex(self, block: Block) -> None:
        lex(block, tape=self.control.readings.tape, delete=self.control.block_delete)

    def _run_words(self, block: Block) -> None:
        # Step 2: words to codes and values; those of macro text may be others every time.
        if not block.is_read or block.is_macro or block.ignored or block.bare:
            self._read(block)
        # Steps 3 and 4.
        state = self.state
        waiting, state.line_feed = state.corner, None
        for action, number in self._checked(block):
            action(state, block, number)
        if not state.is_unit_told:
            report_unit(state, block)
        if block.bare:
            report_bare(state, block)
        if waiting is not None or block.corner[0]:
            self._check_corner(block, waiting)
        if state.request is not None:
            request, state.request = state.request, None
            self._has_jumped = True
            try:
                self._jumps.carry_out(request, block)
            except FlowError as error:
                raise block.error(error.meaning, str(error), block.call) from None

    def _read(self, block: Block) -> None:
        """Step 2: find the row of every code, and keep the value of every other word."""
        block.is_read = True
        block.arguments, block.bare, called = [], [], False
        rows: list[Row] = []
        values: dict[str, float] = {}
        block.rows, block.values = rows, values
        codes, ignore, points = self._rows, self._ignored, self._points
        block.corner, after_comma = ("", 0.0), -1
        for index, (letter, number, _) in enumerate(block.tokens):
            if index == after_comma:
                continue
            if letter == "G" or (letter == "M" and not called):
                row = codes.get((letter, number)) or self._row(block, letter, number, index)
                rows.append(row)
                called = called or (row.number == G.MACRO_CALL and letter == "G")
            elif not letter and self._corner(block, index):
                after_comma = index + 1
            elif not letter:
                raise self._stray(block, index)
            elif called and letter in ARGUMENT_LETTERS:
                self._argument(block, letter, number, index)
            elif letter in ignore:
                block.ignored = True
                self.state.ignored[f"word {letter}"] += 1
            elif letter in values and self.state.reading("same_letter") == "alarm":
                raise block.error("duplicate_word", f"{letter} twice", index)
            else:
                value = values[letter] = float(number)
                if not -LIMIT <= value <= LIMIT and letter != "N":
                    raise block.error("number_too_large", f"{letter}{number}", index)
                if value and letter in points and _is_bare(number):
                    block.bare.append(letter)
        if block.bare:
            settle_bare(self.state, block)

    def _argument(self, block: Block, letter: str, number: str | float, index: int) -> None:
        """Keep a word after G65; only I J K may be repeated."""
        if letter not in "IJK" and any(letter == other for other, _ in block.arguments):
            raise block.error("duplicate_word", f"{letter} twice", index)
        if letter in self._points and float(number) and _is_bare(number):
            block.bare.append(len(block.arguments))
        block.arguments.append((letter, float(number)))

    def _corner(self, block: Block, index: int) -> bool:
        """Tell whether a comma begins a corner word; keep the word, and take it away."""
        tokens = block.tokens
        if tokens[index][2] != "," or not self.control.readings.comma_corners:
            return False
        letter, number, _ = tokens[index + 1] if index + 1 < len(tokens) else ("", "", "")
        if letter not in ("R", "C") or block.corner[0]:
            raise block.error("corner_not_followed", f"a comma before {letter or 'no word'}", index)
        block.corner = letter, float(number)
        if self._points and float(number) and _is_bare(number):
            block.bare.append(CORNER)
        return True

    def _check_corner(self, block: Block, waiting: Corner | None) -> None:
        """Check that a corner met a straight block, and that a corner word began another one."""
        if waiting is not None and self.state.corner is waiting:
            raise block.error("corner_not_followed", "no straight block after a corner")
        if block.corner[0] and self.state.corner is None:
            raise block.error("corner_not_followed", "a corner without a straight block", ",")

    def _stray(self, block: Block, index: int) -> ProgramError:
        if block.tokens == PERCENT and not self._jumps.is_opened(self.flow.source):
            return block.error("stray_percent", "% without an opening one", index)
        return not_a_word(block, index)

    def _row(self, block: Block, letter: str, number: str | float, index: int) -> Row:
        """Return the row of a code; rows are kept by the text of the number."""
        tenths = round(min(max(float(number), -LIMIT), LIMIT) * 10)
        row = self._codes.get((letter, tenths))
        if row is None and letter == "G":
            self.state.unsupported.append(f"G{number} line {block.line}")
            raise block.error("unknown_g", f"unknown code G{number}", index)
        row = row or unlisted_m(tenths)
        self._rows[letter, number] = row
        return row


def _is_bare(number: str | float) -> bool:
    """Tell whether a number is written without a decimal point; one that is worked out is not."""
    return isinstance(number, str) and "." not in number
