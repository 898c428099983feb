"""Goals of the benchmark scripts: one line per goal, and a JSON file beside the results."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Any

from gcodesim.study.bench import environment

ROOT = Path(__file__).resolve().parents[2]
SAMPLES = ROOT / "samples"


class Goals:
    """Collects measurements, prints each as it comes, and writes them all."""

    def __init__(self, script: str) -> None:
        self.report: dict[str, Any] = {
            "script": script,
            **environment(),
            "load": os.getloadavg(),
            "goals": [],
        }

    def at_most(self, what: str, measured: float, goal: float, unit: str, note: str = "") -> None:
        """A figure that must not exceed its goal."""
        self._add(what, measured, goal, unit, note, measured <= goal, "<=")

    def at_least(self, what: str, measured: float, goal: float, unit: str, note: str = "") -> None:
        """A figure that must not fall below its goal."""
        self._add(what, measured, goal, unit, note, measured >= goal, ">=")

    def fact(self, what: str, measured: float, unit: str, note: str = "") -> None:
        """A figure without a goal."""
        self._add(what, measured, None, unit, note, None, "")

    def _add(
        self,
        what: str,
        measured: float,
        goal: float | None,
        unit: str,
        note: str,
        reached: bool | None,
        sign: str,
    ) -> None:
        row = {"what": what, "measured": measured, "unit": unit, "goal": goal, "reached": reached}
        self.report["goals"].append(row | ({"note": note} if note else {}))
        verdict = (
            "" if reached is None else f"  (goal {sign} {goal:g}: {'ok' if reached else 'short'})"
        )
        print(
            f"{what:55} {measured:12.5g} {unit}{verdict}{'  ' + note if note else ''}", flush=True
        )

    def write(self, path: Path | None) -> None:
        """Write everything to a file, if one is wanted."""
        if path:
            path.write_text(json.dumps(self.report, indent=1) + "\n")
            print(f"written to {path}", file=sys.stderr)
