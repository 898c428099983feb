"""Texts of programs and foreign files, made safe to print."""

from __future__ import annotations


def printable(text: str) -> str:
    """The text with every character that does not print replaced, so that columns stay."""
    return "".join(c if c.isprintable() else " " if c == "\t" else "\N{MIDDLE DOT}" for c in text)
