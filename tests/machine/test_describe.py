"""What `machine show` and `machine schema` print."""

import json

import pytest

from gcodesim.machine.describe import SCHEMAS, describe, schema_json
from gcodesim.machine.loading import load_machine


def test_describe(tiny):
    lines = describe(load_machine(str(tiny / "tiny.yaml"))).splitlines()
    assert lines[0].startswith("tiny (unverified model, dialect fanuc), ")
    assert (
        "        A: A rotary [-1, 0, 0] through [0, 5, 7], -120 .. 30 deg, rapid 9000 deg/min"
        in lines
    )
    assert "    X: 12 triangles, 300 x 200 x 40 mm, closed, machine, meshes/X.stl" in lines
    assert "pairs (11)" in lines
    assert "  cutter on Z" in lines


@pytest.mark.parametrize("kind", SCHEMAS)
def test_schema_refuses_unknown_keys_and_knows_units(kind):
    schema = schema_json(kind)
    json.dumps(schema)
    objects = [schema, *schema["$defs"].values()]
    for section in objects:
        if "properties" in section:
            assert section["additionalProperties"] is False
    assert "[mm]" in json.dumps(schema)


def test_schema_of_pairs_and_aliases():
    schema = schema_json()
    short, full = schema["$defs"]["PairSpec"]["anyOf"]
    assert (short["type"], short["maxItems"]) == ("array", 2)
    assert "clearance" in full["properties"]
    assert "for" in schema["$defs"]["MountedSpec"]["properties"]
