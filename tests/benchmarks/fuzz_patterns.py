"""Looks for regular expressions of the package that take more than linear time, and shows a text.

From every pattern, texts are made that match it; a piece of such a text is repeated many times, and
something is put after it that does not match. Run from the repository root:
python tests/benchmarks/fuzz_patterns.py [--seed S]; ends with 1 where a pattern is slow.
"""

from __future__ import annotations

import argparse
import ast
import random
import re
import signal
import sys
import time
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]

SIZE = 2000
"""Characters of a text; one twice as long tells linear from quadratic."""

SLOW_S, GROWTH = 0.002, 3.0
"""A text is looked at again from this time on [s]; twice the text in less than GROWTH times the
time is linear."""

HANGS_S = 0.5
"""A text that takes longer is not waited for [s]."""

EXAMPLES, PIECES = 6, 25
"""Texts that match each pattern, and pieces of each that are repeated."""

ENDINGS = ("", "\0", "!", "(", "x\n")
BLANKS = (" ", "\t", "1", "A", "(", "#", " 1", "A1")

Use = tuple[str, "re.Pattern[str]", str]
"""Where a pattern stands, the pattern, and the method that it is used with."""


def patterns() -> Iterator[Use]:
    """Yield every pattern of the package with every method that it is used with."""
    files = sorted((ROOT / "gcodesim").rglob("*.py"))
    everything = "\n".join(file.read_text() for file in files)
    for file in files:
        name = ".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
        source = file.read_text()
        if "import re\n" not in source or "kernels" in name:
            continue
        module = import_module(name)
        for node in ast.walk(ast.parse(source)):
            if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)):
                continue
            of, method = node.func.value, node.func.attr
            inline = isinstance(of, ast.Name) and of.id == "re" and method != "compile"
            if inline and isinstance(node.args[0], ast.Constant):
                yield f"{name}:{node.lineno}", re.compile(node.args[0].value), method
        for variable, value in vars(module).items():
            for number, pattern in enumerate(_within(value)):
                yield f"{name}.{variable}[{number}]", pattern, "match"
                yield f"{name}.{variable}[{number}]", pattern, "fullmatch"
                if re.search(rf"\b{variable}\.(search|find|sub|split)", everything):
                    yield f"{name}.{variable}[{number}]", pattern, "search"


def _within(value: Any) -> list[re.Pattern[str]]:
    if isinstance(value, re.Pattern):
        return [value] if isinstance(value.pattern, str) else []
    if isinstance(value, dict):
        value = list(value.values())
    return [found for item in value for found in _within(item)] if isinstance(value, list) else []


def example(pattern: re.Pattern[str], rng: random.Random) -> str:
    """Return a text that matches, or nearly: what looks around is left out."""
    return _text(re._parser.parse(pattern.pattern, pattern.flags & ~re.UNICODE), rng)  # type: ignore[attr-defined]


def _text(parsed: Any, rng: random.Random) -> str:
    text = ""
    for kind, value in parsed:
        match str(kind):
            case "LITERAL":
                text += chr(value)
            case "NOT_LITERAL":
                text += "a" if value != ord("a") else "b"
            case "ANY":
                text += rng.choice("a 1")
            case "IN":
                text += _one_of(value, rng)
            case "BRANCH":
                text += _text(rng.choice(value[1]), rng)
            case "SUBPATTERN":
                text += _text(value[3], rng)
            case "ATOMIC_GROUP":
                text += _text(value, rng)
            case "MAX_REPEAT" | "MIN_REPEAT" | "POSSESSIVE_REPEAT":
                low, high, below = value
                count = rng.randint(low, min(int(high), low + 3))
                text += "".join(_text(below, rng) for _ in range(count))
    return text


def _one_of(choices: Any, rng: random.Random) -> str:
    negated = str(choices[0][0]) == "NEGATE"
    pattern = re._compiler.compile(_as_parsed(choices))  # type: ignore[attr-defined]
    usual = [c for c in map(chr, range(32, 127)) if pattern.fullmatch(c)]
    return rng.choice([c for c in usual if c in " A1"] or usual) if negated else rng.choice(usual)


def _as_parsed(choices: Any) -> Any:
    state = re._parser.State()  # type: ignore[attr-defined]
    state.str = ""
    return re._parser.SubPattern(state, [(re._constants.IN, choices)])  # type: ignore[attr-defined]


def texts(pattern: re.Pattern[str], rng: random.Random) -> Iterator[tuple[str, str, str]]:
    """Yield what stands before a piece that is repeated, the piece, and what stands after it."""
    for _ in range(EXAMPLES):
        whole = example(pattern, rng)
        for _ in range(PIECES):
            begin, end = sorted(rng.choices(range(len(whole) + 1), k=2))
            piece = whole[begin:end] or rng.choice(BLANKS)
            for ending in rng.sample(ENDINGS, 2):
                yield whole[:begin], piece, ending
        yield "", whole or " ", "\0"


def seconds(use: Use, parts: tuple[str, str, str], size: int) -> float:
    """Return the time that a text of about `size` characters takes."""
    before, piece, after = parts
    text = before + piece * (size // len(piece)) + after
    method = getattr(use[1], use[2] if use[2] in ("match", "fullmatch") else "search")
    begin = time.perf_counter()
    signal.setitimer(signal.ITIMER_REAL, HANGS_S)
    try:
        method(text)
    except TimeoutError:
        return HANGS_S * size
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
    return time.perf_counter() - begin


def _too_long(number: int, frame: object) -> None:
    raise TimeoutError


def slowest(use: Use, rng: random.Random) -> str:
    """Return what makes a pattern slow, or nothing."""
    for parts in texts(use[1], rng):
        if seconds(use, parts, SIZE) < SLOW_S:
            continue
        short = min(seconds(use, parts, SIZE) for _ in range(2))
        long = min(seconds(use, parts, 2 * SIZE) for _ in range(2))
        if short > SLOW_S and long > GROWTH * short:
            return f"{use[0]} {use[2]} {parts}: {short * 1e3:.1f} ms, {long * 1e3:.1f} ms"
    return ""


def main() -> int:
    """Run as told on the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    signal.signal(signal.SIGALRM, _too_long)
    rng, uses = random.Random(parser.parse_args().seed), list(dict.fromkeys(patterns()))
    slow = [found for use in uses if (found := slowest(use, rng)) and not print(found)]
    print(f"{len({use[1] for use in uses})} patterns, {len(uses)} uses, {len(slow)} slow")
    return int(bool(slow))


if __name__ == "__main__":
    sys.exit(main())
