"""Reads XML files with the line of every element, and refuses what a machine file never needs."""

from __future__ import annotations

from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

from gcodesim.errors import ModelError, UsageError
from gcodesim.input_file import TEXT_BYTES, read_bytes


def read_xml(path: str) -> tuple[Element, dict[Element, int]]:
    """The outermost element of a file, and the line of every element.

    Raises:
        UsageError: the file cannot be read.
        ModelError: it is no XML, or declares a document type or entities; names the line.
    """
    try:
        data = read_bytes(path, TEXT_BYTES)
    except OSError as error:
        raise UsageError(f"{path}: cannot be read: {error.strerror}") from error
    builder, lines, parser = TreeBuilder(), {}, expat.ParserCreate()

    def start(tag: str, attributes: dict[str, str]) -> None:
        lines[builder.start(tag, attributes)] = parser.CurrentLineNumber

    def refuse(*declaration: object) -> None:
        text = "a document type or entity is refused: machine descriptions need none"
        raise ModelError(text, path, parser.CurrentLineNumber)

    parser.StartElementHandler = start
    parser.EndElementHandler = builder.end
    parser.CharacterDataHandler = builder.data
    parser.StartDoctypeDeclHandler = refuse
    parser.EntityDeclHandler = refuse
    try:
        parser.Parse(data, True)
        root = builder.close()
    except expat.ExpatError as error:
        raise ModelError(f"no valid XML: {expat.ErrorString(error.code)}", path, error.lineno) \
            from None  # fmt: skip
    except (LookupError, ValueError) as error:  # of an encoding that Python does not know
        raise ModelError(f"no valid XML: {error}", path, 1) from None
    return root, lines
