"""Checks a block as a whole: whether its codes and words go together, and what it does in order."""

from __future__ import annotations

from collections.abc import Mapping

from gcodesim.nc.control.modal import Motion, TipControl
from gcodesim.nc.iso.actions import ACTIONS, Action
from gcodesim.nc.iso.block import Block
from gcodesim.nc.iso.code_rows import Group, Order, Row
from gcodesim.nc.iso.g_codes import G, motion_code
from gcodesim.nc.iso.memory import IsoState
from gcodesim.nc.iso.words import OFFSET_WORDS, WORDS

AXIS_LETTERS = frozenset("XYZABCUVW")
ALWAYS_USED = frozenset("NOFST")
POLAR_LETTERS = frozenset("@^")
ARC_WORDS = frozenset("IJKR")
VECTOR_WORDS = frozenset("IJK")
CYCLE_WORDS = frozenset("RQPIJKL")
TOOL_CHANGE = 60
MOST_M_CODES = 3
"""Most M codes of a block on Fanuc."""

LAST = Order.MOTION + 0.5
"""Place of a tool change that waits for the motion of its block, before the stops."""

NO_MOTION = Row("G", G.CYCLE_OFF, Group.MOTION, Order.MOTION, "", "No motion mode")

Todo = tuple[Action, int]
"""An action, and the code it is called for."""


class Checks:
    """Step 3: codes and words of a block against the table and the modes in force.

    Attributes:
        state: of the control.
        codes: rows of the dialect and the machine file, by letter and number in tenths.
    """

    def __init__(self, state: IsoState, codes: Mapping[tuple[str, int], Row]) -> None:
        self.state, self.codes = state, codes
        self._has_polar_words = state.control.readings.polar_words
        self._known: dict[tuple[object, ...], tuple[list[Todo], bool]] = {}

    def checked(self, block: Block) -> list[Todo]:
        """Return what a block does, in order; found once for all blocks of one kind.

        Those have the same codes and letters, in the same motion mode.

        Raises:
            ProgramError: codes or words of the block do not go together.
        """
        values, modal, codes = block.values, self.state.modal, self.state.codes
        key = (*block.rows, *values, modal.motion, codes.cycle, codes.tip, block.ignored)
        known = self._known.get(key)
        if known is None:
            rows = self._check(block)
            todo = [(ACTIONS[row.action], row.number) for row in rows if row.action]
            if "O" not in values and "$" not in values and not self._is_told_each_time(block):
                self._known[key] = todo, block.moves
            return todo
        todo, block.moves = known
        if "N" in values:
            self._check_block_number(block, values["N"])
        return todo

    def _check(self, block: Block) -> list[Row]:
        """Check the block as a whole; return the rows to carry out, in their order."""
        rows = self._agreeing_rows(block)
        self._check_m_codes(block)
        motion = next((row for row in rows if row.order is Order.MOTION), None)
        others = [row for row in rows if row is not motion]
        axis_words = block.values.keys() & AXIS_LETTERS
        if self._has_polar_words:
            axis_words |= block.values.keys() & POLAR_LETTERS
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
        if axis_words and not takers and not motion:
            self._begin_motion()
        active = motion or self._active(rows)
        vectors = active.action == "straight" and self._takes_vectors(block)
        if not takers:
            free = block.values.keys() - set("".join(row.words for row in others))
            centred = motion is not None or free & ARC_WORDS
            turns = active.action == "arc" and centred
            block.moves = bool(axis_words or turns or (vectors and free & VECTOR_WORDS))
            kept = active.group is Group.CYCLE and bool(free & CYCLE_WORDS)
            others += [active] if block.moves or motion or kept else []
        others += self._offset_words(block, others)
        unclaimed = "unused_word" if takers else "axis_without_motion"
        self._check_words(block, others, unclaimed, VECTOR_WORDS if vectors else frozenset())
        others += [motion] if takers and motion else []
        others += [row for letter, row in WORDS.items() if letter in block.values]
        return self._in_order(block, others)

    def _is_told_each_time(self, block: Block) -> bool:
        """Tell whether a reading that is not known is counted for every block of this kind."""
        return sum(row.letter == "M" for row in block.rows) > 1 or block.has("M", TOOL_CHANGE)

    def _in_order(self, block: Block, rows: list[Row]) -> list[Row]:
        """Return the rows of a block in the order in which they are carried out."""
        rows = sorted(rows, key=lambda row: row.order)
        goes = any(row.order is Order.MOTION or row.action == "return_to_reference" for row in rows)
        if not block.has("M", TOOL_CHANGE) or not goes or not block.values.keys() & AXIS_LETTERS:
            return rows
        if self.state.reading("m6_order") == "last":
            rows = sorted(rows, key=lambda row: LAST if row.order is Order.CHANGE else row.order)
        return rows

    def _check_m_codes(self, block: Block) -> None:
        """Refuse, or report, more M codes than a block may hold."""
        reading = self.state.control.readings.m_per_block
        codes = [row for row in block.rows if row.letter == "M"]
        if len(codes) < 2 or reading == "any":
            return
        what = f"{codes[0].name} and {codes[1].name} in one block"
        if reading == "open":
            self.state.report("m_per_block_open", what, codes[1].name)
        elif reading == "one" or len(codes) > MOST_M_CODES:
            raise block.error("too_many_m", f"{len(codes)} M codes in one block", codes[-1].name)

    def _offset_words(self, block: Block, rows: list[Row]) -> list[Row]:
        """Return the rows of H and D that no code takes, where they may stand in any block."""
        if not self.state.control.readings.h_in_any_block:
            return []
        taken = "".join(row.words for row in rows)
        return [
            row
            for letter, row in OFFSET_WORDS.items()
            if letter in block.values and letter not in taken
        ]

    def _active(self, rows: list[Row]) -> Row:
        """Return the row of the motion code in force, of a block with these rows of its own."""
        state = self.state
        ended = any(row.group is Group.CYCLE for row in rows)
        if ended and state.control.readings.g80 == "motion":
            return NO_MOTION
        if state.codes.cycle and not ended:
            return self.codes["G", state.codes.cycle]
        motion = state.modal.motion
        return NO_MOTION if motion is Motion.NONE else self.codes["G", motion_code(motion)]

    def _begin_motion(self) -> None:
        """Put a motion code into force where none is and the control has one from the start."""
        state, readings = self.state, self.state.control.readings
        if state.modal.motion is not Motion.NONE or state.codes.cycle:
            return
        if readings.start_motion == "none" or readings.g80 == "motion":
            return
        feeds = state.reading("start_motion") == "G1"
        state.modal.motion = Motion.FEED if feeds else Motion.RAPID

    def _agreeing_rows(self, block: Block) -> list[Row]:
        """Return the rows less a G80 that does nothing; refuse conflicts and refused codes."""
        rows = block.rows
        if any(row.order is Order.MOTION for row in rows):
            # G80 beside another motion code: the other code ends the cycle, or begins one.
            rows = [row for row in rows if row.number != G.CYCLE_OFF or row.letter != "G"]
        for row in rows:
            if row.refused:
                self.state.unsupported.append(f"{row.name} line {block.line}")
                raise block.error("unknown_g", f"{row.name} ({row.refused})", row.name)
        return self._one_of_each_group(block, rows)

    def _one_of_each_group(self, block: Block, rows: list[Row]) -> list[Row]:
        """Return the rows that count where several are of one group."""
        groups: dict[Group, Row] = {}
        for row in rows:
            group = Group.MOTION if row.group is Group.CYCLE else row.group
            first = groups.get(group)
            if first is not None and group is not Group.NONE and first is not row:
                self._settle(block, first, row)
                rows = [other for other in rows if other is not first]
            groups[group] = row
        return rows

    def _settle(self, block: Block, first: Row, second: Row) -> None:
        """Say which of two codes of one group counts, or refuse them.

        A code that acts in its block alone has no mode that a later one could replace.
        """
        reading = self.state.control.readings.same_group
        what = f"{first.name} and {second.name} are of one group"
        if reading == "alarm" or second.letter != "G" or second.group is Group.ONE_SHOT:
            raise block.error("modal_conflict", what, second.name)
        if reading == "open":
            raise block.error("same_group_open", what, second.name)
        self.state.report("same_group_last", what, second.name, subject=what)

    def _takes_vectors(self, block: Block) -> bool:
        """Tell whether a straight move takes I J K as the direction of the tool (G43.5)."""
        length = [row.number for row in block.rows if row.group is Group.LENGTH]
        if length:
            return length[-1] == G.TIP_BY_VECTORS
        return self.state.modal.tip_control is TipControl.VECTORS

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
        if self._has_polar_words:
            moves = any(row.order is Order.MOTION for row in rows)
            used |= POLAR_LETTERS if moves else frozenset()
            used |= {"$"} if block.values.get("$", 1.0) in (0.0, -1.0) else frozenset()
        is_open = self.state.control.readings.unused_word == "open"
        other_use = frozenset("".join(row.words for row in rows if not row.takes_axes))
        for letter, value in block.values.items():
            is_axis = letter in AXIS_LETTERS
            if is_axis and letter not in self.state.control.axes and letter not in other_use:
                self.state.unsupported.append(f"word {letter} line {block.line}")
                what = f"{letter} is no axis here"
                if letter in self.state.control.standing:
                    what = f"{letter} stands at its `start`: the axes that move are X Y Z A B C"
                raise block.error("unknown_word", what, letter)
            if letter not in used or (letter == "O" and block.tokens[0][0] != "O"):
                meaning = unclaimed if is_axis else "unused_word"
                if meaning == "unused_word" and is_open and letter.isalpha():
                    meaning, what = "unused_word_open", f"no code of this block uses {letter}"
                    raise block.error(meaning, what, letter)
                raise block.error(meaning, f"{letter}{value:g}", letter)
            if letter == "N":
                self._check_block_number(block, value)

    def _check_block_number(self, block: Block, value: float) -> None:
        """Refuse a negative number, and a fraction where o-words do not replace block numbers."""
        whole = value == value // 1 or self.state.control.readings.polar_words
        if value < 0 or not whole:
            raise block.error("integer_expected", f"N{value:g}", "N")
