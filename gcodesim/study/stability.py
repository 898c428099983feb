"""The study of stability: every stiff or extreme case, by the usual formulation and by ours."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, field
from math import isfinite
from typing import Any

from gcodesim.study.bench import environment
from gcodesim.study.stability_case import Case
from gcodesim.study.stability_drives import DRIVES
from gcodesim.study.stability_motion import MOTION
from gcodesim.study.stability_scenes import SCENES
from gcodesim.study.stability_triangles import TRIANGLES
from gcodesim.study.stability_turns import TURNS

SCHEMA = "gcodesim.stability/1"

TABLE: tuple[Callable[[bool], Iterable[Case]], ...] = (
    *MOTION,
    *DRIVES,
    *TURNS,
    *TRIANGLES,
    *SCENES,
)
"""What computes the cases, in the order of the table; each takes whether to be quick."""


@dataclass(frozen=True)
class StabilityStudy:
    """All cases of the table."""

    cases: list[Case] = field(default_factory=list)

    @property
    def ok(self) -> bool:
        """Every case keeps its tolerance."""
        return all(case.ok for case in self.cases)

    def as_report(self) -> dict[str, Any]:
        """The study, ready for JSON: one dictionary per case, None for what is not finite."""
        rows = []
        for case in self.cases:
            row = asdict(case) | {"naive_ok": case.naive_ok, "ok": case.ok}
            rows.append({k: v if _is_writable(v) else None for k, v in row.items()})
        return {"schema": SCHEMA, **environment(), "device": "cpu", "ok": self.ok, "cases": rows}


def _is_writable(value: Any) -> bool:
    return not isinstance(value, float) or isfinite(value)


def stability_study(quick: bool, progress: Callable[[float], None]) -> StabilityStudy:
    """Compute every case of the table.

    Args:
        quick: fewer samples, blocks, pairs and scenes.
        progress: called with the fraction done.
    """
    cases: list[Case] = []
    for number, compute in enumerate(TABLE):
        cases += compute(quick)
        progress((number + 1) / len(TABLE))
    return StabilityStudy(cases)
