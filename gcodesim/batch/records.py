"""Records: what became of each job, as one line of JSON, and what a lost job gets."""

from __future__ import annotations

from typing import Any

from gcodesim.batch.jobs import Job
from gcodesim.checking.verdict import EXIT_CODES, USAGE_EXIT, CheckResult, Coverage
from gcodesim.constants import PS_PER_S
from gcodesim.findings.codes import Finding
from gcodesim.input_file import file_mark
from gcodesim.report.json_report import report_dict

Record = dict[str, Any]
"""The label of a job, the `seconds` its check took, and `report` or, with exit code 2, `error`.

`unwritten` says why its picture is not there. `files` are the program and those it called, or for
which it was looked, with a mark of what was in them.
"""

WORKER_LOST, OVERDUE = "worker_lost", "overdue"
"""Meanings of GC901 where a worker process ended, or was ended at the time limit."""


def lost(job: Job, meaning: str, why: str, seconds: float = 0.0) -> Record:
    """The record of a job that was not finished: INCONCLUSIVE (GC901)."""
    options = job.options
    result = CheckResult(
        program=job.program,
        machine=job.machine,
        verified_model=False,
        device=options.device,
        method=options.method,
        dialect=options.dialect or "",
        sample_period_s=options.period_ps / PS_PER_S,
        samples=0,
        duration_s=0.0,
        blocks=0,
        first_contact=None,
        findings=(Finding("GC901", why, meaning, file=job.program),),
        coverage=Coverage(),
        setup=job.setup,
    )
    return {**job.label, "seconds": seconds, "report": report_dict(result)}


def exit_code(record: Record) -> int:
    """What `gcodesim check` would have ended with."""
    return USAGE_EXIT if "error" in record else EXIT_CODES[record["report"]["verdict"]]


def is_done(record: Record) -> bool:
    """Whether the answer stands: a lost job, or one whose files have changed, is tried again."""
    if "error" in record or "unwritten" in record or not record["key"] or "files" not in record:
        return False
    meanings = {finding.get("meaning") for finding in record["report"]["findings"]}
    if meanings & {WORKER_LOST, OVERDUE}:
        return False
    return all(file_mark(file) == mark for file, mark in record["files"].items())
