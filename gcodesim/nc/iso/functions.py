"""The operators and functions of macro expressions; angles in degrees."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable

from gcodesim.nc.iso.macro_rules import MacroRules

SAME = 1e-6
"""LinuxCNC: numbers nearer than this are equal in EQ and NE."""

Binary = Callable[[float, float, MacroRules], float]
Unary = Callable[[float, MacroRules], float]


def equals(a: float | None, b: float | None, vacant: bool) -> bool:
    """Compare with EQ; where vacant parameters exist, one equals only another."""
    if vacant:
        return a == b
    return abs((a or 0.0) - (b or 0.0)) < SAME


def atan2_degrees(y: float, x: float, rules: MacroRules) -> float:
    """ATAN[y]/[x]: 0 to 360, or -180 to 180."""
    angle = math.degrees(math.atan2(y, x))
    return angle % 360.0 if rules.full_turn else angle


def _power(a: float, b: float, rules: MacroRules) -> float:
    result = a**b
    if isinstance(result, complex):
        raise ValueError
    return result


def _remainder(a: float, b: float, rules: MacroRules) -> float:
    if b == 0:
        raise ZeroDivisionError
    rest = math.fmod(a, b)
    return rest + abs(b) if rest < 0 and rules.floored else rest


def _logic(bits: Callable[[int, int], int], truth: Callable[[bool, bool], bool]) -> Binary:
    """Return an operator on bits, or on what is not 0."""

    def evaluate(a: float, b: float, rules: MacroRules) -> float:
        if rules.bitwise:
            return float(bits(int(a), int(b)))
        return float(truth(a != 0, b != 0))

    return evaluate


OPERATORS: dict[str, Binary] = {
    "**": _power,
    "*": lambda a, b, _: a * b,
    "/": lambda a, b, _: a / b,
    "MOD": _remainder,
    "+": lambda a, b, _: a + b,
    "-": lambda a, b, _: a - b,
    "GT": lambda a, b, _: float(a > b),
    "GE": lambda a, b, _: float(a >= b),
    "LT": lambda a, b, _: float(a < b),
    "LE": lambda a, b, _: float(a <= b),
    "AND": _logic(operator.and_, operator.and_),
    "OR": _logic(operator.or_, operator.or_),
    "XOR": _logic(operator.xor, operator.xor),
}


def _round(x: float, rules: MacroRules) -> float:
    """ROUND: halves away from zero."""
    return math.copysign(math.floor(abs(x) + 0.5), x)


def _fix(x: float, rules: MacroRules) -> float:
    """FIX: down, or towards zero."""
    return float(math.floor(x) if rules.floored else math.trunc(x))


def _fup(x: float, rules: MacroRules) -> float:
    """FUP: up, or away from zero."""
    return float(math.ceil(x)) if rules.floored else math.copysign(math.ceil(abs(x)), x)


def _ln(x: float, rules: MacroRules) -> float:
    return math.log(x)


def _bin(x: float, rules: MacroRules) -> float:
    """BIN: from binary-coded decimal."""
    if x < 0:
        raise ValueError
    return float(int(f"{int(x):x}"))


def _bcd(x: float, rules: MacroRules) -> float:
    """BCD: to binary-coded decimal."""
    if x < 0:
        raise ValueError
    return float(int(str(int(x)), 16))


FUNCTIONS: dict[str, Unary] = {
    "ABS": lambda x, _: abs(x),
    "ACOS": lambda x, _: math.degrees(math.acos(x)),
    "ASIN": lambda x, _: math.degrees(math.asin(x)),
    "ATAN": lambda x, _: math.degrees(math.atan(x)),
    "BCD": _bcd,
    "BIN": _bin,
    "COS": lambda x, _: math.cos(math.radians(x)),
    "EXISTS": lambda x, _: x,
    "EXP": lambda x, _: math.exp(x),
    "FIX": _fix,
    "FUP": _fup,
    "LN": _ln,
    "ROUND": _round,
    "SIN": lambda x, _: math.sin(math.radians(x)),
    "SQRT": lambda x, _: math.sqrt(x),
    "TAN": lambda x, _: math.tan(math.radians(x)),
}
"""Name -> function; EXISTS is read by the parser, it takes a name."""
