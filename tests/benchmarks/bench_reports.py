"""Time to write every report of 10,000 findings: `python tests/benchmarks/bench_reports.py`."""

from __future__ import annotations

import tempfile
import time
from dataclasses import replace
from pathlib import Path

from gcodesim.checking.verdict import CheckResult, Coverage
from gcodesim.findings.codes import Finding, Ignored
from gcodesim.policy.baseline import read_baseline
from gcodesim.policy.policy import Policy
from gcodesim.report import github
from gcodesim.report.formats import RENDER
from gcodesim.report.outcome import RunOutcome

COUNT = 10_000
GOAL_S = 2.0
CODES = ("GC102", "GC201", "GC301", "GC303", "GC430")


def made() -> CheckResult:
    """A result with 10,000 findings of five codes; every tenth clearance is ignored."""
    findings = [
        Finding(
            CODES[i % len(CODES)],
            f"cutter comes to {i / 1000:.3f} mm of C; the clearance asked for is 2 mm",
            file="parts/part.nc",
            line=i + 1,
            column=7,
            block=f"N{i} G1 X{i / 100:.2f} Y{i % 97}. A-12.5 (roughing)",
            time_s=i * 0.01,
            pair=("cutter", "C"),
            tool=7,
            ignored=Ignored("--ignore GC201", "gauge") if i % 50 == 1 else None,
        )
        for i in range(COUNT)
    ]
    coverage = Coverage(pairs=(("cutter", "C"),), between_samples=True)
    names = ("parts/part.nc", "table_tilt", False, "cpu", "search", "fanuc")
    return CheckResult(*names, 1e-4, 10**6, 100.0, COUNT, None, tuple(findings), coverage)


def timed(name: str, begin: float, size: int) -> None:
    """Print one line of the table."""
    seconds = time.perf_counter() - begin
    print(f"{name:16} {seconds:7.3f} s {size / 1e6:7.2f} MB  {'' if seconds < GOAL_S else 'SLOW'}")


def main() -> None:
    """Write every format into a temporary folder."""
    run = RunOutcome((made(),))
    with tempfile.TemporaryDirectory() as folder:
        for name, render in (RENDER | {"step summary": github.summary}).items():
            begin = time.perf_counter()
            text = render(run)
            (Path(folder) / name).write_text(text, encoding="utf-8")
            timed(name, begin, len(text))
        path = str(Path(folder) / "baseline.json")
        begin = time.perf_counter()
        policy = Policy(baseline=read_baseline(path, may_be_new=True))
        raw = replace(made(), findings=tuple(replace(f, ignored=None) for f in made().findings))
        policy.baseline.updated([(raw, policy.wanted(raw, ""), True)]).write()
        timed("baseline made", begin, Path(path).stat().st_size)
        begin = time.perf_counter()
        Policy(baseline=read_baseline(path)).apply(raw, "", stop_all=True)
        timed("baseline applied", begin, 0)


if __name__ == "__main__":
    main()
