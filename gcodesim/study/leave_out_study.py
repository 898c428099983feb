"""What leaving out saves: the same checks with everything and with only what the program needs."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

import numpy as np

import gcodesim.collision
from gcodesim.checking.audit import audit
from gcodesim.collision.detector import Task, detect, load_kernels
from gcodesim.collision.search.span_search import Aims
from gcodesim.constants import DEFAULT_PERIOD_PS
from gcodesim.errors import UsageError
from gcodesim.machine.control_data import control_for
from gcodesim.machine.loading import load_machine
from gcodesim.machine.model import Machine
from gcodesim.machine.spindle import bodies_in_place
from gcodesim.motion.planner import plan
from gcodesim.motion.samples import sample_count
from gcodesim.nc.interpret import interpret
from gcodesim.nc.lines import read_program
from gcodesim.study.bench import environment
from gcodesim.study.clock import time_runs
from gcodesim.study.refining import refined

SCHEMA = "gcodesim.leave-out/1"
BLOCKS = 200
RUNS = 3

KINDS = {
    "3 axes": (0.0, 0.0),
    "3+2 axes": (0.0, 60.0),
    "5 axes": (3.0, 20.0),
}
"""Kind of program -> change of A and C [deg]: from block to block, or once in 40 blocks for 3+2."""

WATCHED = (
    "trimesh",
    "scipy",
    "matplotlib",
    "dask",
    "gcodesim.study",
    "gcodesim.collision.baseline.paper",
)
"""Packages and modules that a plain check has no use for."""


@dataclass(frozen=True)
class Saving:
    """One program, checked with everything (`full`) and with only what it needs (`kept`).

    Attributes:
        kind: of a generated program, "program" for a file.
        agrees: same first contact, and every margin holds.
        axes, pairs, bodies, triangles: all of them, and `pairs_out`, ... of them left out.
        tests: samples times pairs, what testing every sample would take.
        items, items_full: stretches of time that the search looked at.
        seconds, seconds_full: median time of the detector [s].
    """

    program: str
    kind: str
    verdict: str
    agrees: bool
    axes: int
    axes_out: int
    pairs: int
    pairs_out: int
    bodies: int
    bodies_out: int
    triangles: int
    triangles_out: int
    tests: int
    items: int
    items_full: int
    seconds: float
    seconds_full: float


@dataclass(frozen=True)
class LeaveOutStudy:
    """All savings on a machine, which modules a check of the first program imports, and kernels.

    `kernels` are the kernel modules that a check compiles, `kernels_out` those that it does not.
    """

    machine: str
    savings: list[Saving] = field(default_factory=list)
    imported: list[str] = field(default_factory=list)
    not_imported: list[str] = field(default_factory=list)
    kernels: list[str] = field(default_factory=list)
    kernels_out: list[str] = field(default_factory=list)

    def as_report(self) -> dict[str, object]:
        """The study, ready for JSON."""
        return {"schema": SCHEMA, **environment(), "device": "cpu", **asdict(self)}


def leave_out_study(
    programs: list[str],
    machine_path: str,
    generated: int,
    seed: int,
    refine: int,
    progress: Callable[[float], None],
) -> LeaveOutStudy:
    """Check programs twice each, and compare.

    Args:
        programs: files.
        machine_path: machine file or name of a shipped machine.
        generated: random programs of each kind besides.
        seed: of the random programs.
        refine: times that every triangle is cut into four.
        progress: called with the fraction done.

    Raises:
        UsageError: a file cannot be read, or there is nothing to check.
    """
    machine = refined(load_machine(machine_path), refine)
    texts = [(name, "program", read_program(name)) for name in programs]
    texts += list(_generated(generated, seed))
    if not texts:
        raise UsageError("nothing to check: give programs, or --generated above 0")
    savings = []
    for number, (name, kind, text) in enumerate(texts):
        savings.append(_saving(name, kind, text, machine))
        progress((number + 1) / (len(texts) + 1))
    imported = _imported(texts[0][2], machine_path)
    others = [name for name in WATCHED if name not in imported]
    kernels = list(load_kernels("search", "cpu"))
    idle = [name for name in _kernel_modules() if name not in kernels]
    return LeaveOutStudy(machine.name, savings, imported, others, kernels, idle)


def _kernel_modules() -> list[str]:
    """Modules of the collision package that hold kernels."""
    folder = Path(gcodesim.collision.__file__).parent
    return sorted(f.stem for f in folder.rglob("*.py") if "\n@wp.kernel\n" in f.read_text("utf-8"))


def _saving(name: str, kind: str, text: str, machine: Machine) -> Saving:
    meaning = interpret(text, control_for(machine, None, None, False), name)
    path, _ = plan(meaning.program, machine)
    aims = Aims()
    kept_task = Task(path, machine, DEFAULT_PERIOD_PS, "cpu", "search", aims, lambda done: None)
    full_task = replace(kept_task, aims=replace(aims, leave_out=False))
    kept_time, kept = time_runs(lambda: detect(kept_task), RUNS)
    full_time, full = time_runs(lambda: detect(full_task), RUNS)
    findings = audit(kept_task, kept)
    dropped = {item.what: item for span in kept.findings for item in span.left_out}
    checked = {pair.name for pair in kept.checked}
    needed = [pair for pair in kept.checked if pair.name not in dropped]
    bodies = bodies_in_place(machine, kept.spans[-1].tool if kept.spans else None)
    still = np.all(path.q0 == path.q0[:1], axis=0) & np.all(path.q1 == path.q0[:1], axis=0)
    return Saving(
        program=name,
        kind=kind,
        verdict="contact" if kept.contact else "free",
        agrees=not any(f.severity == "error" for f in findings),
        axes=len(machine.joints),
        axes_out=int(still.sum()),
        pairs=len(checked),
        pairs_out=len(checked & set(dropped)),
        bodies=len(bodies),
        bodies_out=len(set(bodies) - {body for pair in needed for body in (pair.a, pair.b)}),
        triangles=sum(len(p.triangles) for body in bodies.values() for p in body.parts),
        triangles_out=sum(item.triangles for item in dropped.values()),
        tests=sample_count(path, DEFAULT_PERIOD_PS) * len(checked),
        items=kept.work.as_report["gap_tests"],
        items_full=full.work.as_report["gap_tests"],
        seconds=kept_time.median,
        seconds_full=full_time.median,
    )


def _generated(count: int, seed: int) -> Iterator[tuple[str, str, str]]:
    """Yield name, kind and text of random programs."""
    for kind, turns in KINDS.items():
        rng = np.random.default_rng([seed, len(kind), int(sum(turns))])
        for number in range(count):
            yield f"{kind} {number + 1}", kind, _program(rng, *turns)


def _program(rng: np.random.Generator, tilt: float, turn: float) -> str:
    """A random walk above the table; A and C turn by normal steps, for 3+2 axes now and then."""
    steps = rng.normal(size=(BLOCKS, 5)) * (6.0, 6.0, 3.0, tilt, turn)
    if turn and not tilt:
        now_and_then = np.arange(BLOCKS) % 40 == 20
        steps[:, 3] = rng.normal(size=BLOCKS) * 15.0 * now_and_then
        steps[:, 4] *= now_and_then
    q = np.cumsum(steps, axis=0) + (0.0, 0.0, rng.uniform(120.0, 260.0), -10.0 * bool(turn), 0.0)
    q = np.clip(q, (-200, -150, 60, -90, -9000), (200, 150, 400, 20, 9000))
    letters = "XYZAC" if turn else "XYZ"
    moves = [
        "G1 " + " ".join(f"{a}{v:.3f}" for a, v in zip(letters, row, strict=False)) + " F6000."
        for row in q
    ]
    return "\n".join(["G21 G90 G94", "T1 M6", "G0 Z300.", *moves, "M30", ""])


def _imported(text: str, machine_path: str) -> list[str]:
    """Which of the watched modules a plain check of a program imports, in a process of its own."""
    code = (
        "import sys\n"
        "from gcodesim.checking.flow import check_program\n"
        "from gcodesim.machine.loading import load_machine\n"
        "from gcodesim.checking.options import Options\n"
        "check_program(sys.stdin.read(), 'program', load_machine(sys.argv[1]), Options())\n"
        "print(*sys.modules)\n"
    )
    command = [sys.executable, "-c", code, machine_path]
    done = subprocess.run(command, input=text, check=True, capture_output=True, text=True)
    modules = set(done.stdout.split())
    return [name for name in WATCHED if name in modules]
