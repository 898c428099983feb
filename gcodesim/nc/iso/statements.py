"""What a block with macro text says: words with values, assignments, and one control word."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

from gcodesim.nc.iso.expressions import NAME, Evaluate, Parser
from gcodesim.nc.iso.macro_rules import MacroRules
from gcodesim.nc.iso.parameters import ExpressionError, Parameters

WORD = re.compile(r"([A-Z@^$])([+-]?([0-9]+(?:\.[0-9]*)?|\.[0-9]+))?")
NUMBERS = re.compile(r"([0-9.]++)")
"""Numbers, and what only looks like one: 1.2.3."""

KEPT_SHAPES = 1 << 12
"""Shapes of text that are kept."""

MAX_VALUE = 1e300
"""Largest value a parameter takes: results of expressions stay finite."""

LABEL = re.compile(r"O(?:([0-9]+)|<([^<>]*)>)")
O_KEYWORD = re.compile(
    r"SUB|ENDSUB|CALL|RETURN|IF|ELSEIF|ELSE|ENDIF|WHILE|ENDWHILE|DO|REPEAT|ENDREPEAT|BREAK|CONTINUE"
)
LOOP = re.compile(r"(DO|END)([0-9]+)$")
OUTPUT = re.compile(r"POPEN|PCLOS|[BD]PRNT\[.*\]$")
"""Output to a printer or file, which moves nothing."""

VALUED = frozenset({"IF", "ELSEIF", "WHILE", "REPEAT"})
"""O-words that take one value."""

Word = tuple[str, str, Evaluate | int | None, int]
"""Letter, number as text, value or None, index in the text without blanks.

An index in Statement.numbers as the value says that the text is only the sign of that number.
"""

Assigned = tuple[str, Evaluate | None]
"""A name and None, or an empty name and what gives the number."""


@dataclass(slots=True)
class Statement:
    """One block of macro text.

    Attributes:
        words: the words of letters, see Word; places: where each of them begins.
        assignments: target, value and index, in the order written.
        control: GOTO, WHILE, DO, END, an O-word such as O-CALL, or empty.
        condition: of IF or WHILE, or the value of an O-word.
        label: number of DO and END, label of an O-word.
        to: block number GOTO goes to, or number of the subprogram that O-CALL runs.
        arguments: of O-CALL.
        numbers: place and length of every number, of a statement for all texts of one shape.
    """

    words: list[Word] = field(default_factory=list)
    places: list[int] = field(default_factory=list)
    assignments: list[tuple[Assigned, Evaluate, int]] = field(default_factory=list)
    control: str = ""
    condition: Evaluate | None = None
    label: str = ""
    to: Evaluate | None = None
    arguments: list[Evaluate] = field(default_factory=list)
    numbers: list[tuple[int, int]] = field(default_factory=list)

    def place_in(self, numbers: Sequence[str], place: int) -> int:
        """Return where a place of this statement stands in a text with other numbers."""
        pairs = zip(self.numbers, numbers, strict=False)
        return place + sum(len(mine) - length for (at, length), mine in pairs if at < place)


class Shapes:
    """Statements by the shape of their text: texts that differ in numbers only are read once.

    Attributes:
        rules: of the language of the macros.
    """

    def __init__(self, rules: MacroRules) -> None:
        self.rules = rules
        self._known: dict[tuple[str, ...], Statement | None] = {}

    def read(self, text: str) -> tuple[Statement, Sequence[str], Sequence[float]]:
        """Return what a block says, and the numbers it says it with, as text and as values.

        Raises:
            ExpressionError: it is no block.
        """
        pieces = NUMBERS.split(text)
        shape, numbers = tuple(pieces[::2]), pieces[1::2]
        try:
            values = list(map(float, numbers))
        except ValueError:
            return parse(text, self.rules), (), ()
        if shape not in self._known:
            if len(self._known) == KEPT_SHAPES:
                self._known.clear()
            self._known[shape] = parse_shape(text, self.rules)
        statement = self._known[shape]
        return (
            (parse(text, self.rules), (), ()) if statement is None else (statement, numbers, values)
        )


def parse_shape(text: str, rules: MacroRules) -> Statement | None:
    """Read a block for all texts of its shape; None where a number is more than a value.

    Labels and names are such numbers.

    Raises:
        ExpressionError: it is no block.
    """
    spans = [match.span() for match in NUMBERS.finditer(text)]
    slots = {begin: index for index, (begin, _) in enumerate(spans)}
    parser = Parser(text, 0, rules, slots)
    statement = _parse(parser)
    statement.numbers = [(begin, end - begin) for begin, end in spans]
    return statement if parser.met == len(spans) else None


def parse(text: str, rules: MacroRules) -> Statement:
    """Read a block without blanks, in capitals.

    Raises:
        ExpressionError: it is none.
    """
    return _parse(Parser(text, 0, rules))


def _parse(parser: Parser) -> Statement:
    text, statement = parser.text, Statement()
    while parser.at < len(text):
        at = parser.at
        if statement.control and statement.control != "IF":
            raise parser.error("bad_character", repr(text[at]))
        if text[at] == "#":
            _assignment(parser, statement)
        elif text[at] == "O" and _is_first(statement) and _o_word(parser, statement):
            pass
        elif text.startswith(("IF[", "WHILE["), at):
            _condition(parser, statement)
        elif text.startswith("GOTO", at):
            parser.at += 4
            statement.control, statement.to = "GOTO", parser.value()
        elif not parser.rules.o_words and (match := OUTPUT.match(text, at)):
            parser.at = match.end()
        elif match := LOOP.match(text, at):
            parser.at = match.end()
            statement.control, statement.label = match[1], match[2]
        else:
            _word(parser, statement)
    if statement.control == "IF":
        raise parser.error("block_structure", "IF without GOTO or THEN")
    statement.places = [word[3] for word in statement.words]
    return statement


def _is_first(statement: Statement) -> bool:
    """Tell whether only a block number stands before: an O-word begins its block."""
    return not statement.assignments and all(word[0] == "N" for word in statement.words)


def _assignment(parser: Parser, statement: Statement) -> None:
    at = parser.at
    target: Assigned
    if match := NAME.match(parser.text, at + 1):
        target = match[1], None
        parser.at = match.end()
    else:
        parser.at += 1
        target = "", parser.value()
    if parser.text[parser.at : parser.at + 1] != "=":
        raise parser.error("bad_character", "no = after the parameter")
    parser.at += 1
    # Macro B writes #1=#2+1 without brackets; beside o-words a value is all there is.
    value = parser.value() if parser.rules.o_words else parser.operation()
    statement.assignments.append((target, value, at))


def _condition(parser: Parser, statement: Statement) -> None:
    """Read IF[c]GOTOn, IF[c]THEN#i=v, or WHILE[c]DOm."""
    text = parser.text
    is_loop = text[parser.at] == "W"
    parser.at += 5 if is_loop else 2
    statement.condition = parser.bracket()
    if is_loop:
        match = LOOP.match(text, parser.at)
        if not match or match[1] != "DO":
            raise parser.error("block_structure", "WHILE without DO1, DO2 or DO3")
        parser.at = match.end()
        statement.control, statement.label = "WHILE", match[2]
    elif text.startswith("GOTO", parser.at):
        parser.at += 4
        statement.control, statement.to = "GOTO", parser.value()
    elif text.startswith("THEN#", parser.at):
        parser.at += 4
        statement.control = "IF"
        while parser.at < len(text):
            _assignment(parser, statement)
        statement.control = "THEN"
    else:
        raise parser.error("block_structure", "IF without GOTO or THEN")


def _o_word(parser: Parser, statement: Statement) -> bool:
    """Read an O-word; return False for the O of a program number."""
    if parser.rules.o_words and parser.text[parser.at + 1 : parser.at + 2] in ("#", "["):
        return _computed_call(parser, statement)
    label = LABEL.match(parser.text, parser.at)
    keyword = O_KEYWORD.match(parser.text, label.end()) if label else None
    if not label or not keyword:
        return False
    # ELSE is the beginning of ELSEIF, DO of nothing else.
    name = "ELSEIF" if parser.text.startswith("ELSEIF", keyword.start()) else keyword[0]
    if not parser.rules.o_words:
        raise parser.error("macro_unsupported", "o-word")
    parser.at = keyword.start() + len(name)
    statement.control = f"O-{name}"
    statement.label = str(int(label[1])) if label[1] else label[2]
    if name in VALUED:
        statement.condition = parser.bracket()
    while parser.text.startswith("[", parser.at):
        statement.arguments.append(parser.bracket())
    return True


def _computed_call(parser: Parser, statement: Statement) -> bool:
    """Read O[expression] CALL or O#parameter CALL."""
    parser.at += 1
    statement.to = parser.value()
    if not parser.text.startswith("CALL", parser.at):
        raise parser.error("macro_unsupported", "an O-word with a computed number")
    parser.at += 4
    statement.control = "O-CALL"
    while parser.text.startswith("[", parser.at):
        statement.arguments.append(parser.bracket())
    return True


def _word(parser: Parser, statement: Statement) -> None:
    at = parser.at
    match = WORD.match(parser.text, at)
    if not match and not parser.rules.o_words and (name := NAME.match(parser.text, at)):
        raise parser.error("unknown_g", f"the call of a program by its name {name[0]}")
    if not match:
        raise parser.error("bad_character", repr(parser.text[at]))
    parser.at = match.end()
    if match[2]:
        slot = parser.slot(match.start(3))
        number = match[2] if slot is None else match[2][: match.start(3) - match.start(2)]
        statement.words.append((match[1], number, slot, at))
        return
    try:
        value = parser.value()
    except ExpressionError as error:
        if error.meaning == "number_expected" and error.place == match.end():
            what = f"{match[1]} without a number"
            raise ExpressionError("number_expected", what, at) from None
        raise
    statement.words.append((match[1], "", value, at))


def assign(statement: Statement, parameters: Parameters) -> None:
    """Give the parameters their values, all of them worked out before the first is written.

    Raises:
        ExpressionError: a value or a target has none.
    """
    values = [(target, value(parameters), at) for target, value, at in statement.assignments]
    for (name, number), value, at in values:
        if value is not None and abs(value) > MAX_VALUE:
            raise ExpressionError("number_too_large", f"{value:g}", at)
        if number is None:
            parameters.set_named(name, value)
        else:
            parameters.set(number(parameters) or 0.0, value, at)
