"""Runs the detector on a machine and a path: the one place where tests make a task."""

from __future__ import annotations

from gcodesim.collision.detector import Detection, Task, detect
from gcodesim.collision.search.span_search import Aims
from gcodesim.constants import DEFAULT_PERIOD_PS
from gcodesim.machine.model import Machine
from gcodesim.motion.path import Path


def detected(
    m: Machine,
    p: Path,
    period_ps: int = DEFAULT_PERIOD_PS,
    device: str = "cpu",
    method: str = "exhaustive",
) -> Detection:
    """What the detector finds at samples and block ends, never between them."""
    aims = Aims(between=False)
    return detect(Task(p, m, period_ps, device, method, aims, lambda done: None))
