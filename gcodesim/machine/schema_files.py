"""Lets editors know generated files: their first line names a JSON Schema that lies beside them."""

from __future__ import annotations

import json


def schema_name(kind: str) -> str:
    """Name of the schema file of machine, tools or setup files."""
    return f"{kind}.schema.json"


def with_schema(kind: str, text: str) -> str:
    """The text of a file, after the line by which editors find its schema."""
    return f"# yaml-language-server: $schema={schema_name(kind)}\n{text}"


def schema_text(kind: str) -> str:
    """What the schema file holds."""
    from gcodesim.machine.describe import schema_json

    return json.dumps(schema_json(kind), indent=2) + "\n"
