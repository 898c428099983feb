"""The whole check, in order: interpret, plan, detect, decide."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from gcodesim.checking.open_offsets import open_offsets
from gcodesim.checking.options import Options
from gcodesim.checking.replay import Replay
from gcodesim.checking.variation import varied
from gcodesim.checking.verdict import CheckResult
from gcodesim.constants import PS_PER_S, TOLERANCE_MM
from gcodesim.findings.codes import Finding
from gcodesim.machine.control_data import control_for
from gcodesim.machine.model import Machine
from gcodesim.motion.off_path import OffPath, off_path
from gcodesim.motion.overtravel import overtravels
from gcodesim.motion.path import Path
from gcodesim.motion.planner import plan
from gcodesim.motion.samples import sample_count, tool_times
from gcodesim.nc.control.interpreter import Interpretation
from gcodesim.nc.control.readings import is_varied
from gcodesim.nc.interpret import interpret, settled

if TYPE_CHECKING:
    from gcodesim.collision.detector import Detection, Task


COMPILING_S = 2.0
"""Kernels that are still not loaded after this time [s] are being compiled: from the cache of an
earlier run they come in a twentieth of a second."""


@dataclass
class Stopwatch:
    """Seconds spent in each stage."""

    seconds: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def time(self, stage: str) -> Iterator[None]:
        """Add the time of the enclosed block to a stage."""
        start = time.perf_counter()
        yield
        self.seconds[stage] = self.seconds.get(stage, 0.0) + time.perf_counter() - start


def check_program(
    text: str,
    name: str,
    machine: Machine,
    options: Options,
    progress: Callable[[float], None] = lambda fraction: None,
    notice: Callable[[str], None] = lambda line: None,
) -> CheckResult:
    """Check one program on one machine, in every way in which its control may read it.

    Args:
        text: the NC program.
        name: its file name, for findings.
        machine: machine with setup and tools.
        options: see Options.
        progress: called with the fraction of the lines read, then of the program time proved.
        notice: called, from another thread, with a line that says why nothing else happens yet.

    Raises:
        UsageError: the dialect or the device is not known.
    """
    result = check_once(text, name, machine, options, progress, notice)
    if not any(is_varied(reading.key) for reading in result.coverage.readings):
        return result
    # Another way of reading only has to show whether it hits something, and how deep.
    quick = replace(options, minimum=False, nearest=False, audit=False)

    def again(keys: Mapping[str, str]) -> CheckResult:
        return check_once(text, name, machine.with_readings(**keys), quick)

    return varied(result, again)


def check_once(
    text: str,
    name: str,
    machine: Machine,
    options: Options,
    progress: Callable[[float], None] = lambda fraction: None,
    notice: Callable[[str], None] = lambda line: None,
) -> CheckResult:
    """Check one program with the first way of every reading; arguments as for check_program."""
    watch = Stopwatch()
    with watch.time("interpret"):
        control = control_for(machine, *options.language)
        control = settled(text, replace(control, main_program=options.main_program or ""))
        meaning = interpret(text, control, name, progress)
        # Rapids run as in the dialect that the text or an option has told.
        machine = replace(machine, readings=control.readings)
    with watch.time("plan"):
        path, findings = plan(meaning.program, machine)
        findings += overtravels(path, machine.joints)
        findings += open_offsets(meaning, machine)
        off = off_path(meaning.program, path, machine)
    with watch.time("compile"):
        task = _task(path, machine, options, off, progress, notice)
        # Imported late, as in _task.
        from gcodesim.checking.audit import audit
        from gcodesim.checking.evidence import other_programs
        from gcodesim.collision.detector import detect
    stocks = None
    if machine.has_stock:
        with watch.time("stock"):
            from gcodesim.checking.stocks import raced

            stocks = raced(task)
            task = stocks.told(task)
    with watch.time("search"):
        detection = detect(task)
    if options.audit:
        with watch.time("audit"):
            findings += audit(task, detection)
    if stocks:
        findings += stocks.settle(task, detection, options.audit)
    dialect, seconds = control.readings.dialect, watch.seconds
    if options.main_program is None:
        findings += other_programs(meaning)
    result = _result(name, dialect, meaning, off, task, detection, findings, seconds)
    result = stocks.shown(result) if stocks else result
    return replace(result, main_program=control.main_program)


def _result(
    name: str,
    dialect: str,
    meaning: Interpretation,
    off: OffPath,
    task: Task,
    detection: Detection,
    findings: Sequence[Finding],
    seconds: dict[str, float],
) -> CheckResult:
    """What interpreter, planner and detector found, as the answer of the check.

    Args:
        name: file name of the program.
        dialect: in which it was read.
        meaning: what the interpreter made of it.
        off: how far the machine may be from the path.
        task: of the detector.
        detection: its answer.
        findings: of planner and audit.
        seconds: that each stage took.
    """
    from gcodesim.checking import evidence

    path, machine, contact = task.path, task.machine, detection.contact
    between, searches = task.aims.between, task.method == "search"
    off_path_lines = evidence.off_path_lines(off, path, machine, between, searches)
    return CheckResult(
        program=name,
        machine=machine.name,
        verified_model=machine.verified,
        device=task.device,
        method=task.method,
        dialect=dialect,
        sample_period_s=task.period_ps / PS_PER_S,
        samples=sample_count(path, task.period_ps) if len(path) else 0,
        duration_s=path.duration_s,
        tool_times=tool_times(path),
        tolerance_mm=TOLERANCE_MM + path.deviation_mm,
        blocks=meaning.blocks,
        first_contact=evidence.first_contact(contact, path, meaning.lines) if contact else None,
        findings=_all_findings(name, meaning, task, detection, findings),
        coverage=evidence.coverage(detection, machine, meaning, between, searches, off_path_lines),
        largest_step=evidence.largest_step(detection, path),
        contacts=evidence.contacts(detection),
        clearances=evidence.clearances(detection, path),
        left_out=evidence.left_out(detection, machine) if searches else (),
        work=detection.work.as_report,
        timing_s=seconds,
        replay=Replay(machine, path, meaning.lines, meaning.files, task.aims.clearance),
        looked_up=meaning.looked_up,
    )


def _all_findings(
    name: str,
    meaning: Interpretation,
    task: Task,
    detection: Detection,
    findings: Sequence[Finding],
) -> tuple[Finding, ...]:
    """What program, machine, path and detector have to say, with file and block."""
    from gcodesim.checking import evidence

    found = [
        *findings,
        *evidence.all_contact_findings(detection, task.path),
        *evidence.detection_findings(detection, task.machine, task.path),
    ]
    if not len(task.path):
        found.append(Finding("GC430", "the program moves no axis", "no_motion"))
    placed = (evidence.placed(finding, name, meaning) for finding in found)
    return (*meaning.findings, *task.machine.findings, *placed)


def _task(
    path: Path,
    machine: Machine,
    options: Options,
    off: OffPath,
    progress: Callable[[float], None],
    notice: Callable[[str], None],
) -> Task:
    """What the detector is to do, with its kernels loaded.

    Warp takes a while to start, and a wrong option must not wait for it: it is imported here.
    """
    from gcodesim.collision.detector import Task, load_kernels
    from gcodesim.collision.geometry.device import resolve_device
    from gcodesim.collision.geometry.kernel_cache import remarks
    from gcodesim.collision.search.span_search import Aims

    device = resolve_device(options.device)
    slow = threading.Timer(COMPILING_S, notice, ["compiling kernels, once: about 20 s"])
    slow.daemon = True
    slow.start()
    try:
        load_kernels(options.method, device, options.stop_all)
    finally:
        slow.cancel()
        for remark in remarks():
            notice(remark)
    aims = Aims(
        between=options.between and options.method == "search",
        clearance=options.clearance,
        minimum=options.minimum,
        nearest=options.nearest and options.method == "search",
        stop_all=options.stop_all,
        off_path=off,
        threads=options.threads,
    )
    return Task(path, machine, options.period_ps, device, options.method, aims, progress)
