"""JSON Lines: one object per finding and program, the same bytes for the same inputs."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

from gcodesim.report.json_report import report_dict
from gcodesim.report.outcome import RunOutcome

VARYING = ("device", "pictures", "work", "timing_s", "findings", "suppressed")
"""What depends on where and how a check ran; and the findings, which have lines of their own."""


def render(run: RunOutcome) -> str:
    """One line per object, keys sorted, no blanks, ASCII: `type` is finding, program or failure.

    The findings of a program stand before it, in the order of the JSON report, each with its
    program and machine.
    """
    encoder = json.JSONEncoder(sort_keys=True, separators=(",", ":"))
    return "".join(f"{encoder.encode(row)}\n" for row in _objects(run))


def _objects(run: RunOutcome) -> Iterator[dict[str, Any]]:
    for result in run.results:
        place = {"program": result.program, "machine": result.machine}
        report = report_dict(result)
        if result.main_program:
            place["main_program"] = result.main_program
        for row in (*report["findings"], *report["suppressed"]):
            yield {"type": "finding", **place, **row}
        yield {"type": "program"} | {k: v for k, v in report.items() if k not in VARYING}
    for failure in run.failures:
        yield {"type": "failure", "program": failure.program, "message": failure.message}
