"""The exhaustive method: every sample and every block end of a span, window by window.

Nothing is proved of the time between. The paper's method walks the same instants and has a test of
its own for them.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from gcodesim.collision.bodies.scene import Scene
from gcodesim.collision.geometry.poses import PathArrays
from gcodesim.collision.instants.touches import first_touch
from gcodesim.collision.instants.work import WorkCounts
from gcodesim.motion.path import Path
from gcodesim.motion.samples import Instants, Span, window, windows

WINDOW = 16_384
"""Samples per window: long enough to amortise a launch, short enough for progress and Ctrl-C."""

InstantTest = Callable[[Instants], tuple[int, int] | None]
"""Finds the first contact (sample, pair) among some instants."""


def exhaustive_test(scene: Scene, arrays: PathArrays, work: WorkCounts) -> InstantTest:
    """The test of every pair at every instant."""
    return partial(first_touch, scene, arrays, work=work)


def first_sampled_contact(
    path: Path,
    span: Span,
    period_ps: int,
    test: InstantTest,
    progress: Callable[[float], None] = lambda done: None,
) -> tuple[int, int] | None:
    """First (sample, pair index) in contact within a span, None when all instants are free.

    Args:
        path: the path.
        span: the stretch of program time to look at.
        period_ps: sample period [ps].
        test: what looks at the instants of a window.
        progress: called with the fraction of program time done.
    """
    for first in windows(path, span, WINDOW, period_ps):
        hit = test(window(path, span, first, WINDOW, period_ps))
        if hit:
            return hit
        progress(min(1.0, (first + WINDOW) * period_ps / path.duration_ps))
    return None
