"""Tables 2 and 3 of the seed paper, and the same figures of its method on this machine.

C.-Y. Siao, J.-W. Lin, T.-H. Chien and R.-G. Chang, "Paralleling Collision Detection on Five-Axis
Machining", 2021, section 5.3: microseconds per sample and pair, average, minimum and maximum.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gcodesim.collision.baseline.paper import detect_pair, prepare_paper
from gcodesim.collision.geometry.poses import path_arrays
from gcodesim.collision.instants.touches import instant_arrays
from gcodesim.collision.instants.work import WorkCounts
from gcodesim.machine.model import Joint
from gcodesim.motion.overtravel import position_ranges
from gcodesim.motion.samples import Instants
from gcodesim.study.clock import time_runs
from gcodesim.study.job import StudyJob

Figures = tuple[float, float, float]
"""Average, minimum and maximum [us]."""

CPU_US: dict[str, Figures] = {
    "Z-Y": (8323.44, 4949.18, 18169.06),
    "Z-A": (12729.96, 6721.09, 24505.73),
    "Z-C": (39336.0, 13095.01, 48574.0),
    "Z-X": (11198.24, 6105.13, 22214.41),
    "cutter-A": (31290.0, 15576.16, 40528.0),
    "cutter-C": (89698.0, 39336.0, 108174.0),
    "cutter-Y": (22895.64, 19203.72, 33078.0),
    "cutter-X": (14562.96, 9691.56, 23376.91),
}
"""Table 2: one core of an Intel Xeon E5-2620 at 2.0 GHz."""

GPU_US: dict[str, Figures] = {
    "Z-Y": (256.29, 140.12, 537.57),
    "Z-A": (306.24, 199.27, 695.53),
    "Z-C": (1082.0, 388.16, 1407.63),
    "Z-X": (327.54, 179.68, 688.24),
    "cutter-A": (762.17, 508.21, 1165.77),
    "cutter-C": (2260.53, 1287.31, 3108.75),
    "cutter-Y": (648.92, 498.83, 986.98),
    "cutter-X": (401.46, 302.69, 781.43),
}
"""Table 3: a Tesla K20c."""

FIGURES = ("average", "minimum", "maximum")


def paper_table(job: StudyJob, device: str, sample_count: int) -> dict[str, Any]:
    """The table of one device: the paper's method at samples spread over the job.

    Each sample of each pair is looked at on its own, launches and the way back of the flag
    included; its time is the median of several runs.

    Args:
        job: motion and machine.
        device: resolved device name.
        sample_count: samples to look at.
    """
    scene, path = job.scene(device), path_arrays(job.path, device)
    published = CPU_US if device == "cpu" else GPU_US
    instants = [instant_arrays(i, device) for i in _spread(job, sample_count)]
    rows = []
    for pair in prepare_paper(scene, _with_finite_travel(job)):
        times = []
        for instant in instants:
            timing, _ = time_runs(partial(detect_pair, scene, pair, path, instant, WorkCounts()))
            times.append(timing.median * 1e6)
        name = scene.pairs[pair.pair].name
        triangles = [len(pair.triangles_a), len(pair.triangles_b)]
        rows.append(_row(name, triangles, np.array(times), published.get(name)))
    return {
        "device": device,
        "table": 2 if device == "cpu" else 3,
        "samples": sample_count,
        "pairs": rows,
    }


def _spread(job: StudyJob, count: int) -> list[Instants]:
    """Single samples spread evenly over a job."""
    samples = np.unique(np.linspace(0, job.samples - 2, count).astype(np.int64))
    times = samples * job.period_ps
    pieces = job.path.piece_at(times)
    return [Instants(times[i : i + 1], pieces[i : i + 1], samples[i : i + 1]) for i in range(count)]


def _with_finite_travel(job: StudyJob) -> tuple[Joint, ...]:
    """The joints; those without a limit have the travel of the path."""
    joints = []
    for column, joint in enumerate(job.machine.joints):
        low, high = position_ranges(job.path, column)
        lower = joint.lower if np.isfinite(joint.lower) else float(low.min())
        upper = joint.upper if np.isfinite(joint.upper) else float(high.max())
        joints.append(replace(joint, lower=lower, upper=upper))
    return tuple(joints)


def _row(
    name: str, triangles: list[int], times: NDArray[np.float64], published: Figures | None
) -> dict[str, Any]:
    """Measured and published figures of a pair, and how many times faster than published."""
    measured = (float(times.mean()), float(times.min()), float(times.max()))
    row: dict[str, Any] = {"pair": name, "triangles_within_reach": triangles}
    row |= {f"{figure}_us": us for figure, us in zip(FIGURES, measured, strict=True)}
    for figure, ours, theirs in zip(FIGURES, measured, published or (), strict=False):
        row[f"paper_{figure}_us"] = theirs
        row[f"times_faster_{figure}"] = theirs / ours
    return row
