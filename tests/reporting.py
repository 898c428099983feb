"""Results to report on: one of every verdict, and a run with them."""

from __future__ import annotations

from dataclasses import replace

from gcodesim.checking.verdict import CheckResult, Coverage
from gcodesim.findings.codes import Finding
from gcodesim.report.outcome import Failure, RunOutcome

PASSED = CheckResult(
    program="parts/part.nc",
    machine="table_tilt",
    verified_model=False,
    device="cpu",
    method="search",
    dialect="fanuc",
    sample_period_s=1e-4,
    samples=142001,
    duration_s=14.2,
    blocks=6,
    first_contact=None,
    findings=(),
    coverage=Coverage(pairs=(("cutter", "C"), ("Z", "A")), between_samples=True),
    timing_s={"interpret": 0.01, "search": 1.0},
)


def finding(code: str, line: int | None = 6, **given: object) -> Finding:
    """A finding of a code in a program, its message with marks that every format must escape."""
    values = {"file": "parts/part.nc", "block": f"N{line} G1 <&> (50%, a|b) \x1b", "column": 4}
    return Finding(code, f"{code}: 5 < 6 & 100%", line=line, **(values | given))  # type: ignore[arg-type]


TOUCH = finding("GC102", pair=("cutter", "C"), tool=7, time_s=12.4)
NEAR = finding("GC201", 8, pair=("cutter", "A"))
NOTE = finding("GC430", 2)
LIMIT = finding("GC301", 9)
UNKNOWN = finding("GC402", 12)

FAILED = replace(PASSED, program="parts/b a.nc", findings=(NOTE, NEAR, TOUCH))
UNCLEAR = replace(PASSED, program="parts/unclear.nc", findings=(UNKNOWN,))
RUN = RunOutcome((PASSED, FAILED, UNCLEAR), (Failure("missing.nc", "missing.nc: cannot be read"),))
