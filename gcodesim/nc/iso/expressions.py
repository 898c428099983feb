r"""Expressions of macros: parsed once from text, then evaluated as often as the block runs.

value    = number | parameter | "[" expression "]" | function | ("+" | "-") value
parameter = "#" ( number | "<" name ">" | parameter | "[" expression "]" )
function = NAME "[" expression "]", ATAN [y] "/" [x], EXISTS "[" parameter "]"

Operators by strength: MacroRules.levels. A sign belongs to its number, so [-2**2] is 4. Angles are
in degrees.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping

from gcodesim.nc.iso.functions import FUNCTIONS, OPERATORS, atan2_degrees, equals
from gcodesim.nc.iso.macro_rules import MacroRules
from gcodesim.nc.iso.parameters import UNKNOWN, ExpressionError, Parameters

Evaluate = Callable[[Parameters], float | None]
"""Returns None for a vacant parameter."""

ALWAYS: dict[str, Callable[[Evaluate, Evaluate], Evaluate]] = {
    "+": lambda a, b: lambda p: (a(p) or 0.0) + (b(p) or 0.0),
    "-": lambda a, b: lambda p: (a(p) or 0.0) - (b(p) or 0.0),
    "*": lambda a, b: lambda p: (a(p) or 0.0) * (b(p) or 0.0),
}
"""Operators that always have a value, without the calls that the others need: most are these."""

Join = Callable[[float | None, float | None], float]

NUMBER = re.compile(r"[0-9]+(?:\.[0-9]*)?|\.[0-9]+")
NAME = re.compile(r"<([^<>]*)>")
FUNCTION = re.compile(r"(" + "|".join(FUNCTIONS) + r")(?=\[)")
MAX_DEPTH = 50
"""Brackets, signs and # may nest this deep; a control allows five."""


class Parser:
    """Reads values from a text without blanks, in capitals.

    Attributes:
        text, at: the text and how far it is read.
        rules: of the language of the macros.
        slots: where a number begins -> its index in Parameters.numbers, for values that are to
            hold for all texts that differ in their numbers only; none = the numbers are kept.
        met: numbers found where a slot is, in the order written.
    """

    def __init__(
        self, text: str, at: int, rules: MacroRules, slots: Mapping[int, int] | None = None
    ) -> None:
        self.text, self.at, self.rules = text, at, rules
        self.slots, self.met = slots or {}, 0
        self._depth = 0

    def slot(self, place: int) -> int | None:
        """Return the index of the number that begins at a place, None where numbers are kept."""
        slot = self.slots.get(place)
        self.met += slot is not None
        return slot

    def error(self, meaning: str, what: str) -> ExpressionError:
        """Return the error that reading stops with, here."""
        return ExpressionError(meaning, what, self.at)

    def value(self) -> Evaluate:
        """Read one value: what may follow a letter, or stand in an expression."""
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise self.error("expression_unclosed", f"more than {MAX_DEPTH} levels")
        try:
            return self._value()
        finally:
            self._depth -= 1

    def _value(self) -> Evaluate:
        text = self.text
        sign = text[self.at : self.at + 1]
        if match := NUMBER.match(text, self.at):
            self.at = match.end()
            number, slot = float(match[0]), self.slot(match.start())
            return (lambda p: number) if slot is None else (lambda p: p.numbers[slot])
        if sign in ("+", "-"):
            self.at += 1
            inner = self.value()
            return inner if sign == "+" else lambda p: -(inner(p) or 0.0)
        if sign == "#":
            return self.parameter()
        if sign == "[":
            return self.bracket()
        if match := FUNCTION.match(text, self.at):
            return self._function(match)
        raise self.error("number_expected", "no number, parameter or [")

    def parameter(self) -> Evaluate:
        """Read # and what names the parameter."""
        place = self.at
        self.at += 1
        if match := NAME.match(self.text, self.at):
            self.at = match.end()
            name = match[1]
            return lambda p: p.named(name, place)
        if match := NUMBER.match(self.text, self.at):
            self.at = match.end()
            known, slot = float(match[0]), self.slot(match.start())
            if slot is not None:
                return lambda p: p.get(p.numbers[slot], place)
            return lambda p: p.get(known, place)
        number = self.value()
        return lambda p: p.get(number(p) or 0.0, place)

    def bracket(self) -> Evaluate:
        """Read [ expression ]."""
        place = self.at
        if self.text[place : place + 1] != "[":
            raise self.error("expression_unclosed", "no [")
        self.at += 1
        inner = self.operation()
        if self.text[self.at : self.at + 1] != "]":
            raise ExpressionError("expression_unclosed", "[ without ]", place)
        self.at += 1
        return inner

    def operation(self) -> Evaluate:
        """Read an expression without brackets around it."""
        return self._operation(len(self.rules.levels) - 1)

    def _operation(self, level: int) -> Evaluate:
        """Read operands joined by operators of this strength or stronger ones."""
        if level < 0:
            return self.value()
        first = self._operation(level - 1)
        others: list[tuple[Join, Evaluate]] = []
        operator = ""
        while match := self.rules.levels[level].match(self.text, self.at):
            self.at, operator = match.end(), match[0]
            join = _join(operator, match.start(), self.rules)
            others.append((join, self._operation(level - 1)))
        if not others:
            return first
        if len(others) == 1:
            only, second = others[0]
            if operator in ALWAYS:
                return ALWAYS[operator](first, second)
            return lambda p: only(first(p), second(p))

        def evaluate(p: Parameters) -> float | None:
            value = first(p)
            for join, other in others:
                value = join(value, other(p))
            return value

        return evaluate

    def _function(self, match: re.Match[str]) -> Evaluate:
        name, place = match[1], self.at
        self.at = match.end()
        if name == "EXISTS":
            return self._exists(place)
        inner = self.bracket()
        if name == "ATAN" and self.text.startswith("/[", self.at):
            self.at += 1
            return _atan(inner, self.bracket(), self.rules)
        function = FUNCTIONS[name]

        def evaluate(p: Parameters) -> float:
            value = inner(p) or 0.0
            if value != value:
                return value
            try:
                return function(value, self.rules)
            except (ValueError, OverflowError):
                what = f"{name}[{inner(p) or 0.0:g}]"
                raise ExpressionError("function_domain", what, place) from None

        return evaluate

    def _exists(self, place: int) -> Evaluate:
        """Read [ parameter ], and tell whether there is one."""
        if not self.text.startswith("[#", self.at):
            raise self.error("number_expected", "EXISTS takes [#<name>]")
        self.at += 2
        evaluate: Evaluate
        if match := NAME.match(self.text, self.at):
            self.at, known = match.end(), match[1]
            evaluate = lambda p: float(p.has_name(known, place))  # noqa: E731 (as all of these)
        else:
            # Numbered parameters exist, every one of them.
            number, first, last = self.value(), self.rules.lowest, self.rules.last
            evaluate = lambda p: float(first <= (number(p) or 0.0) <= last)  # noqa: E731
        if not self.text.startswith("]", self.at):
            raise self.error("expression_unclosed", "no ]")
        self.at += 1
        return evaluate


def _atan(y: Evaluate, x: Evaluate, rules: MacroRules) -> Evaluate:
    return lambda p: atan2_degrees(y(p) or 0.0, x(p) or 0.0, rules)


def _join(operator: str, place: int, rules: MacroRules) -> Join:
    """Return the operation; a vacant operand counts as 0, and equals only another vacant one."""
    if operator in ("EQ", "NE"):
        wanted, vacant = operator == "EQ", rules.vacant

        def compare(left: float | None, right: float | None) -> float:
            if left != left or right != right:
                return UNKNOWN
            return float(equals(left, right, vacant) == wanted)

        return compare
    function = OPERATORS[operator]

    def join(left: float | None, right: float | None) -> float:
        a, b = left or 0.0, right or 0.0
        if a != a or b != b:
            return UNKNOWN
        try:
            return function(a, b, rules)
        except ZeroDivisionError:
            raise ExpressionError("division_by_zero", f"{a:g} {operator} 0", place) from None
        except (ValueError, OverflowError):
            what = f"{a:g} {operator} {b:g}"
            raise ExpressionError("function_domain", what, place) from None

    return join
