"""Every format of the report, by its name."""

from __future__ import annotations

from collections.abc import Callable

from gcodesim.report import github, gitlab, json_report, jsonl, junit, sarif, text
from gcodesim.report.outcome import FORMATS, RunOutcome

RENDER: dict[str, Callable[[RunOutcome], str]] = dict(
    zip(
        FORMATS,
        (text.render, json_report.render, jsonl.render, junit.render, sarif.render,
         github.render, gitlab.render),
        strict=True,
    )
)  # fmt: skip
"""Name -> what writes it."""
