"""Blocks of macro text: their values, their assignments, and where they make the program go on."""

from __future__ import annotations

import re

from gcodesim.nc.control.program_flow import FlowError
from gcodesim.nc.control.state import LIMIT
from gcodesim.nc.iso.block import Block, Token
from gcodesim.nc.iso.expressions import Evaluate
from gcodesim.nc.iso.jumps import Jumps
from gcodesim.nc.iso.memory import IsoState
from gcodesim.nc.iso.parameters import ALARM, ExpressionError, Parameters
from gcodesim.nc.iso.statements import Shapes, Statement, assign, parse
from gcodesim.nc.iso.tape import compact
from gcodesim.nc.program import Kind

ALONE = frozenset({"CALL", "RETURN", "ELSEIF", "ELSE"})
"""O-words that open and close nothing."""

IN_MESSAGE = re.compile(r"#(?:[0-9]+|<[^<>]*>)")


class Macros:
    """Evaluates macro text against the parameters, and moves the flow.

    Attributes:
        state, parameters, jumps: what it works on.
    """

    def __init__(self, state: IsoState, parameters: Parameters, jumps: Jumps) -> None:
        self.state, self.parameters, self.jumps = state, parameters, jumps
        self.flow = jumps.flow
        self._shapes = Shapes(parameters.rules)
        self._branches: dict[int, Statement] = {}
        parameters.undefined = self._undefined

    def read(self, block: Block) -> Statement:
        """Evaluate the words of a block, then carry out its assignments.

        Raises:
            ProgramError: the text cannot be read, or a value does not exist.
        """
        try:
            statement = block.statement
            if statement is None:
                statement, block.numbers, block.known = self._shapes.read(block.compact)
                block.statement = statement
            self.parameters.numbers = block.known
            self._evaluate(block, statement)
            if statement.assignments and (statement.control != "THEN" or self._holds(statement)):
                assign(statement, self.parameters)
        except ExpressionError as error:
            raise block.error_at(error.place, error.meaning, str(error)) from None
        if self.state.stop_request is not None:
            self._stop_request(block, *self.state.stop_request)
        return statement

    def _evaluate(self, block: Block, statement: Statement) -> None:
        """Give a block its words; one whose value is a vacant parameter drops out."""
        parameters, numbers = self.parameters, block.numbers
        tokens: list[Token] = []
        places = statement.places
        for letter, number, value_of, place in statement.words:
            if value_of is None:
                tokens.append((letter, number, ""))
            elif isinstance(value_of, int):
                tokens.append((letter, number + numbers[value_of], ""))
            elif (value := value_of(parameters)) is not None:
                if value != value:
                    raise ExpressionError("value_unknown", f"the value of {letter}", place)
                if not -LIMIT <= value <= LIMIT:
                    raise ExpressionError("number_too_large", f"{letter}{value:g}", place)
                tokens.append((letter, value, ""))
            else:
                what = f"{letter} without a value is left out"
                self.state.report("parameter_undefined", what, subject=letter)
                places = [*places[: len(tokens)], *places[len(tokens) + 1 :]]
        block.tokens, block.places = tokens, places

    def _undefined(self, number: int) -> None:
        what = f"#{number} is used as 0"
        self.state.report("parameter_undefined", what, subject=f"{number}")

    def _stop_request(self, block: Block, number: int, value: float) -> None:
        """#3000 raises an alarm, #3006 stops the program."""
        self.state.stop_request = None
        if number == ALARM:
            text = block.text[block.text.find("(") :] if "(" in block.text else f"{value:g}"
            raise block.error("macro_alarm", f"alarm {text.strip()}")
        self.state.emit(Kind.STOP)

    def message(self, text: str) -> str:
        """Return the text of a message with the values of its parameters."""

        def value(match: re.Match[str]) -> str:
            name = match[0][1:].upper()
            try:
                if name.startswith("<"):
                    return f"{self.parameters.named(name[1:-1], 0) or 0.0:g}"
                return f"{self.parameters.get(float(name), 0) or 0.0:g}"
            except ExpressionError:
                return match[0]

        return IN_MESSAGE.sub(value, text) if "#" in text else text

    def go_on(self, block: Block, statement: Statement) -> None:
        """Carry out GOTO, WHILE, DO, END or an O-word.

        Raises:
            ProgramError: it leads nowhere, or a value does not exist.
        """
        if statement.control == "THEN":
            return
        try:
            if statement.control.startswith("O-"):
                self._o_word(block, statement)
            elif statement.control == "GOTO":
                if self._holds(statement):
                    number = statement.to(self.parameters) if statement.to else None
                    self.jumps.go_to_number(self._whole(number))
            else:
                self._loop(statement)
        except ExpressionError as error:
            raise block.error_at(error.place, error.meaning, str(error)) from None
        except FlowError as error:
            raise block.error(error.meaning, str(error)) from None

    def _loop(self, statement: Statement) -> None:
        flow, line = self.flow, self.flow.index - 1
        partner = self.jumps.structures[flow.source.first].partner.get(line)
        if partner is None:
            raise FlowError("block_structure", f"{statement.control} {statement.label} alone")
        if statement.control == "END":
            flow.index = partner
        elif not self._holds(statement):
            flow.index = partner + 1

    def _o_word(self, block: Block, statement: Statement) -> None:
        flow, line = self.flow, self.flow.index - 1
        structure, word = self.jumps.structures[flow.source.first], statement.control[2:]
        partner = structure.partner.get(line, -1)
        if partner < 0 and line not in structure.loop_of and word not in ALONE:
            raise FlowError("block_structure", f"O{statement.label} {word} alone")
        if word in ("CALL", "SUB", "ENDSUB", "RETURN"):
            self._sub(block, statement, word, partner)
        elif word in ("IF", "ELSEIF", "ELSE"):
            # ELSEIF and ELSE are met from above, after the branch that ran.
            at = self._branch(line) if word == "IF" else self._end_of_if(line)
            flow.index = at + 1
        elif word == "WHILE" and partner > line:
            flow.index = line + 1 if self._holds(statement) else partner + 1
        elif word == "WHILE":
            flow.index = partner + 1 if self._holds(statement) else line + 1
        elif word == "ENDWHILE":
            flow.index = partner
        elif word == "REPEAT":
            times = self._whole(round(self._value(statement.condition), 6) + 0.0)
            flow.index = line + 1 if flow.count_down(line, times) else partner + 1
        elif word == "ENDREPEAT":
            flow.index = partner + 1 if flow.count_down(partner) else line + 1
        elif word in ("BREAK", "CONTINUE"):
            opening = structure.loop_of[line]
            closing = structure.partner[opening]
            again = opening if self._opens_by_test(opening) else closing
            flow.index = closing + 1 if word == "BREAK" else again

    def _opens_by_test(self, opening: int) -> bool:
        """Tell whether a loop begins with WHILE."""
        source = self.flow.source
        lines, closing = source.lines, self.jumps.structures[source.first].partner[opening]
        return "WHILE" in lines[opening].upper().replace(" ", "") and closing > opening

    def _sub(self, block: Block, statement: Statement, word: str, partner: int) -> None:
        flow = self.flow
        if word == "CALL":
            values = [value(self.parameters) for value in statement.arguments]
            label = statement.label
            if statement.to is not None:
                label = str(self._whole(statement.to(self.parameters)))
            self.jumps.call_sub(label, values)
        elif word == "SUB":
            flow.index = partner + 1
        elif flow.is_main:
            raise FlowError("block_structure", f"{word} outside a call")
        else:
            value = [value(self.parameters) for value in statement.arguments[:1]]
            self.jumps.leave(block)
            self.parameters.set_named("_VALUE", value[0] if value else 0.0)
            self.parameters.set_named("_VALUE_RETURNED", float(bool(value)))

    def _branch(self, line: int) -> int:
        """Return the line of the branch whose condition holds, or of ENDIF."""
        branches = self.jumps.structures[self.flow.source.first].next_branch
        at: int | None = line
        while at is not None:
            statement = self._statement_of(at)
            if statement.control in ("O-ELSE", "O-ENDIF") or self._holds(statement):
                return at
            at = branches.get(at)
        raise FlowError("block_structure", "IF without ENDIF")

    def _statement_of(self, line: int) -> Statement:
        row = self.flow.source.first + line
        if row not in self._branches:
            text = compact(self.flow.source.lines[line]).lstrip("/")
            self._branches[row] = parse(text, self.parameters.rules)
        return self._branches[row]

    def _end_of_if(self, line: int) -> int:
        branches = self.jumps.structures[self.flow.source.first].next_branch
        while line in branches:
            line = branches[line]
        return line

    def _holds(self, statement: Statement) -> bool:
        if statement.condition is None:
            return True
        value = self._value(statement.condition)
        if value != value:
            raise ExpressionError("value_unknown", f"the condition of {statement.control}", 0)
        return bool(value)

    def _value(self, value: Evaluate | None) -> float:
        return (value(self.parameters) if value else None) or 0.0

    def _whole(self, number: float | None) -> int:
        if number is not None and number != number:
            raise FlowError("value_unknown", "a number")
        if number is None or not 0 <= number <= LIMIT or not number.is_integer():
            raise FlowError("integer_expected", f"{number}")
        return int(number)
