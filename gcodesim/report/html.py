"""The replay page: one file without network that shows the machine moving as it was checked."""

from __future__ import annotations

import base64
import html
import json
import re
import zlib
from importlib.resources import files
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gcodesim.checking.replay import Replay, indexed
from gcodesim.checking.verdict import CONTRACT
from gcodesim.constants import PS_PER_S
from gcodesim.report.json_report import report_dict

if TYPE_CHECKING:
    from gcodesim.checking.verdict import CheckResult
    from gcodesim.machine.model import Part
    from gcodesim.motion.knots import Knots

MODULES = {
    "three": "three.module.min.js",
    "three/addons/controls/OrbitControls.js": "OrbitControls.js",
    "gcodesim/data": "data.js",
    "gcodesim/distances": "distances.js",
    "gcodesim/program": "program.js",
    "gcodesim/scene": "scene.js",
}
"""Name under which a script of the page imports another -> file in viewer/."""

SHOWN_OF_REPORT = (
    *("verdict", "program", "machine", "verified_model", "first_contact", "contacts"),
    *("clearances", "findings", "suppressed", "coverage"),
)
"""Keys of the JSON report that the page reads."""

MOST_LINES = 500_000
"""Lines of a program, or changes of the line over time, up to which the text is in the page: more
would make it larger than some 20 MB."""

MOST_TIMES = 200
"""Times of findings at which distances are given besides those at equal steps."""


def page(result: CheckResult, replay: Replay) -> str:
    """The page of one check, complete."""
    knots = replay.knots()
    data = _data(result, replay, knots) | {"distances": _distances(result, replay)}
    parts = {
        "title": html.escape(f"{result.title} on {result.machine}: {result.verdict}"),
        "style": _asset("viewer.css"),
        "modules": _json({"imports": {name: _url(file) for name, file in MODULES.items()}}),
        "data": _json(data),
        "viewer": _asset("viewer.js"),
    }
    # In one pass: nothing that is filled in is looked at again.
    return re.sub("@([a-z]+)@", lambda match: parts[match[1]], _asset("page.html"))


def _asset(file: str) -> str:
    return files("gcodesim.report").joinpath("viewer", file).read_text(encoding="utf-8")


def _url(file: str) -> str:
    """A script as an address that holds it."""
    return f"data:text/javascript;charset=utf-8;base64,{_base64(_asset(file).encode())}"


def _json(value: Any) -> str:
    """JSON that cannot end the element it stands in, whatever a program's text holds."""
    return json.dumps(value, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def _base64(data: bytes) -> str:
    return base64.b64encode(data).decode("ascii")


def _packed(array: NDArray[Any] | bytes) -> str:
    """Little-endian numbers row by row, or text, deflated, as base64; unpacked by data.js."""
    data = array if isinstance(array, bytes) else np.ascontiguousarray(array).tobytes()
    return _base64(zlib.compress(data))


def _data(result: CheckResult, replay: Replay, knots: Knots) -> dict[str, Any]:
    """What the page knows: data.js unpacks it, scene.js and program.js show it."""
    machine, report = replay.machine, report_dict(result)
    parents = {joint.child: joint.parent for joint in machine.joints}
    number = {name: i for i, name in enumerate(machine.links)}
    meshes: dict[tuple[str, str], int] = {}
    bodies = [
        {
            "name": shown.body.name,
            "title": shown.title,
            "link": number[shown.body.link],
            "spans": shown.spans,
            "parts": [_part(part, meshes) for part in shown.body.parts],
        }
        for shown in replay.bodies()
    ]
    program = _program(replay)
    note = f"joints drawn within {knots.tolerance:g} mm or deg of the checked path"
    if program is None:
        note += f"; the program's text is left out: more than {MOST_LINES:,} lines"
    return {
        "report": {key: report[key] for key in SHOWN_OF_REPORT if key in report},
        "contract": CONTRACT,
        "note": note,
        "links": [{"name": n, "parent": number.get(parents.get(n, ""), -1)} for n in machine.links],
        "joints": [
            {
                "name": joint.name,
                "child": number[joint.child],
                "rotary": joint.rotary,
                "axis": joint.axis.tolist(),
                "point": joint.point.tolist(),
            }
            for joint in machine.joints
        ],
        "bodies": bodies,
        "meshes": [{"vertices": vertices, "faces": faces} for vertices, faces in meshes],
        "knots": {
            "time": _packed(knots.time_s.astype("<f8")),
            "positions": _packed(knots.positions.astype("<f8")),
        },
        "program": program,
    }


def _part(part: Part, meshes: dict[tuple[str, str], int]) -> dict[str, Any]:
    """A part, its mesh entered in the table unless an equal one is there."""
    vertices, faces = indexed(part.triangles)
    mesh = meshes.setdefault((_packed(vertices), _packed(faces)), len(meshes))
    return {"name": part.name, "role": part.role, "mesh": mesh}


def _distances(result: CheckResult, replay: Replay) -> dict[str, Any]:
    """How far apart every pair is at frames along the timeline, and where the nearest points are.

    The times that the report tells are frames too.
    """
    from gcodesim.collision.views.distances import distances

    first = result.first_contact
    times = [
        *([first.time_s] if first else []),
        *(near.time_s for near in result.clearances),
        *(touch.deepest_at_s for touch in result.contacts),
        *(finding.time_s for finding in result.findings if finding.time_s is not None),
    ]
    found_ps = np.rint(np.array(times[:MOST_TIMES]) * PS_PER_S).astype(np.int64)
    found = distances(replay.machine, replay.path, result.device, found_ps)
    points = np.array([link.points for link in found.links])
    return {
        "pairs": [[pair.a, pair.b] for pair in replay.machine.pairs],
        "clearance": [replay.clearance_of(pair) for pair in replay.machine.pairs],
        "time": _packed((found.time_ps / PS_PER_S).astype("<f8")),
        "distance": _packed(found.distance.astype("<f8")),
        "link": _packed(np.array([(k.frame, k.pair) for k in found.links]).astype("<i4")),
        "points": _packed(points.astype("<f4")),
    }


def _program(replay: Replay) -> dict[str, Any] | None:
    """Text and the line over time; None where that would be too much."""
    times, lines = replay.line_starts()
    if max(len(replay.lines), len(times)) > MOST_LINES:
        return None
    return {
        "text": _packed("\n".join(replay.lines).encode("utf-8", "replace")),
        "files": replay.files,
        "time": _packed(times.astype("<f8")),
        "line": _packed(lines.astype("<i4")),
    }
