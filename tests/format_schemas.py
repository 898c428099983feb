"""What the report formats allow, written from their standards: only what gcodesim may write.

SARIF 2.1.0 (OASIS): sections 3.13 log, 3.14 run, 3.18 tool, 3.20 invocation, 3.27 result, 3.28
location, 3.49 reporting descriptor, 3.58 notification. GitLab: the table of the code quality report
format. JUnit: the elements and attributes that Jenkins and GitLab read. Everything is closed: a
property that is misspelt or that the standard does not have is an error.
"""

from __future__ import annotations

from typing import Any
from xml.etree.ElementTree import Element

Schema = dict[str, Any]

TEXT: Schema = {"type": "string", "minLength": 1}
COUNT: Schema = {"type": "integer", "minimum": 0}
FROM_ONE: Schema = {"type": "integer", "minimum": 1}
LEVEL: Schema = {"enum": ["none", "note", "warning", "error"]}
BAG: Schema = {"type": "object"}


def record(required: dict[str, Schema], **optional: Schema) -> Schema:
    """An object with these properties and no others."""
    return {
        "type": "object",
        "properties": required | optional,
        "required": list(required),
        "additionalProperties": False,
    }


def several(items: Schema, least: int = 0) -> Schema:
    """An array."""
    return {"type": "array", "items": items, "minItems": least}


MESSAGE = record({"text": TEXT})
ARTIFACT = record({"uri": {"type": "string", "pattern": r"^(?![./])[^ \\]+$"}})
REGION = record({"startLine": FROM_ONE}, startColumn=FROM_ONE, snippet=MESSAGE)
PLACE = record({"artifactLocation": ARTIFACT}, region=REGION)
LOCATION = record({"physicalLocation": PLACE})
RULE = record(
    {"id": TEXT},
    shortDescription=MESSAGE,
    fullDescription=MESSAGE,
    help=MESSAGE,
    defaultConfiguration=record({"level": LEVEL}),
)
RESULT = record(
    {"message": MESSAGE, "ruleId": TEXT, "level": LEVEL},
    ruleIndex=COUNT,
    locations=several(LOCATION),
    partialFingerprints={"type": "object", "additionalProperties": TEXT},
    properties=BAG,
)
NOTE = record({"message": MESSAGE}, level=LEVEL, locations=several(LOCATION))
DRIVER = record({"name": TEXT}, version=TEXT, semanticVersion=TEXT, rules=several(RULE))
RUN = record(
    {"tool": record({"driver": DRIVER})},
    columnKind={"enum": ["utf16CodeUnits", "unicodeCodePoints"]},
    invocations=several(
        record(
            {"executionSuccessful": {"type": "boolean"}}, toolExecutionNotifications=several(NOTE)
        )
    ),
    results=several(RESULT),
    properties=BAG,
)
SARIF = record(
    {"version": {"const": "2.1.0"}, "runs": several(RUN, 1)},
    **{"$schema": {"type": "string", "pattern": "^https://.*/sarif-schema-2\\.1\\.0\\.json$"}},
)

GITLAB = record(
    {
        "description": TEXT,
        "check_name": TEXT,
        "fingerprint": TEXT,
        "severity": {"enum": ["info", "minor", "major", "critical", "blocker"]},
        "location": record({"path": TEXT, "lines": record({"begin": FROM_ONE})}),
    }
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
