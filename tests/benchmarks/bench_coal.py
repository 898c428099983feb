"""The strongest check a user could build from libraries, against the search, on the same motion.

coal (FCL's successor) finds the distance of two bodies; the motion bound then tells how long they
cannot meet, and that much time is skipped. The last distance plus the motion since bounds the next
distance from above, which lets coal leave out most of its trees. Windows of time advance side by
side, so that NumPy poses all of them at once. Run from the repository root:
python tests/benchmarks/bench_coal.py [--seconds S] [--out FILE]; skips when coal is not installed.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

sys.path.insert(0, str(Path(__file__).resolve().parent))

from goals import SAMPLES, Goals

from gcodesim.collision.bodies.scene import Scene
from gcodesim.collision.bodies.trees import build_tree
from gcodesim.collision.bounds.motion_bounds import levers, travelled
from gcodesim.collision.geometry.poses import joints_between
from gcodesim.constants import DEFAULT_PERIOD_PS
from gcodesim.machine.control_data import control_for
from gcodesim.machine.kinematics import world_from_link
from gcodesim.machine.loading import load_machine
from gcodesim.motion.planner import plan
from gcodesim.nc.interpret import interpret
from gcodesim.nc.lines import read_program
from gcodesim.study.clock import time_runs
from gcodesim.study.job import StudyJob, longest_job, repeated, search_job

FINISH, MACHINE = SAMPLES / "five_axis_finish.nc", "table_tilt"
WINDOWS = 64
"""Windows of time that advance side by side; more share the posing, fewer share the distances."""

RUNS = 3
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class CoalPair:
    """Two bodies of a pair for coal, and how far they can move towards each other.

    Attributes:
        travel: motion bound from the start to the end of each piece, shape (pieces + 1,) [mm].
    """

    links: tuple[str, str]
    bodies: tuple[Any, Any]
    travel: Floats


def main() -> int:
    """Measure both ways and print the ratio."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=90.0, help="least machine time")
    parser.add_argument("--out", type=Path, help="JSON file to write")
    options = parser.parse_args()
    try:
        import coal
    except ImportError:
        print("skipped: the Python package coal is not installed (pip install coal)")
        return 0
    machine, text = load_machine(MACHINE), read_program(str(FINISH))
    program = interpret(text, control_for(machine, None, None, False), FINISH.name).program
    job = longest_job(plan(program, machine)[0], machine, DEFAULT_PERIOD_PS)
    job = repeated(job, options.seconds)
    assert not (job.path.arc >= 0).any(), "the motion bound of this script knows no arcs"
    goals = Goals("bench_coal")
    goals.report["versions"]["coal"] = coal.__version__
    scene = job.scene("cpu")
    pairs = [coal_pair(coal, scene, job, index) for index in range(len(scene.pairs))]
    coal_timing, (contact, queries) = time_runs(lambda: advance(coal, pairs, job), RUNS)
    searcher = job.searcher(scene, threads=2)
    search_timing, answer = time_runs(lambda: search_job(searcher))
    assert (contact is None) == (answer.sample is None), "the two ways disagree"
    theirs, ours = (t.median / job.samples * 1e6 for t in (coal_timing, search_timing))
    note = f"best {coal_timing.least / job.samples * 1e6:.3f}, {queries} distances"
    goals.fact("coal, distance and skip, per sample", theirs, "us", note)
    note = f"best {search_timing.least / job.samples * 1e6:.4f}"
    goals.fact("search, two threads, per sample", ours, "us", note)
    goals.at_least("search faster than coal", theirs / ours, 25.0, "times")
    goals.write(options.out)
    return 0


def coal_pair(coal: Any, scene: Scene, job: StudyJob, index: int) -> CoalPair:
    """A pair of the scene for coal."""
    links = scene.links[index]
    shapes = [shape.regions.triangles for shape in scene.shapes[index]]
    return CoalPair(
        links, tuple(coal_body(coal, t) for t in shapes), travel_of(job, links, shapes[1])
    )


def coal_body(coal: Any, triangles: Floats) -> Any:
    """Triangles of shape (n, 3, 3) as a tree of coal."""
    points, ids = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    body = coal.BVHModelOBBRSS()
    body.beginModel(len(triangles), len(points))
    body.addVertices(points)
    body.addTriangles(ids.reshape(-1, 3))
    body.endModel()
    return body


def travel_of(job: StudyJob, links: tuple[str, str], triangles: Floats) -> Floats:
    """How far any point of body b moves in the frame of body a, summed up, at piece ends [mm]."""
    joints = travelled(job.machine.joints, job.path)
    chain = joints_between(joints, *links)
    radii = iter(levers(joints, chain, triangles, build_tree(triangles))[0])
    moved = np.abs(job.path.q1 - job.path.q0)
    total = np.zeros(len(job.path))
    for column, _ in chain:
        rotary = joints[column].rotary
        total += moved[:, column] * (np.radians(next(radii)) if rotary else 1.0)
    return np.concatenate([[0.0], np.cumsum(total)])


def advance(coal: Any, pairs: list[CoalPair], job: StudyJob) -> tuple[int | None, int]:
    """First sample in contact, None when all is free, and the number of distances."""
    request, bounds = coal.DistanceRequest(False), job.path.bounds_ps.astype(float)
    ends = np.linspace(0, job.samples, WINDOWS + 1).astype(np.int64)
    sample = np.tile(ends[:-1], len(pairs))
    last = np.tile(ends[1:], len(pairs))
    pair = np.repeat(np.arange(len(pairs)), WINDOWS)
    above = np.full(len(sample), np.inf)
    first, queries = job.samples, 0
    while len(sample):
        times = np.minimum(sample * job.period_ps, job.path.duration_ps)
        poses = posed(job, times)
        distance = np.array(
            [
                distance_of(coal, pairs[p], poses, row, request, bound)
                for row, (p, bound) in enumerate(zip(pair.tolist(), above.tolist(), strict=True))
            ]
        )
        queries += len(sample)
        touching = distance <= 0.0
        first = min(first, int(sample[touching].min(initial=first)))
        later = np.zeros(len(sample), np.int64)
        for index, each in enumerate(pairs):
            own = np.flatnonzero(pair == index)
            moved = np.interp(times[own], bounds, each.travel)
            reached = skipped(each.travel, bounds, moved + distance[own]) // job.period_ps
            later[own] = np.maximum(sample[own] + 1, reached)
            at_next = np.interp(later[own] * job.period_ps, bounds, each.travel)
            above[own] = distance[own] + (at_next - moved) + 1e-9
        keep = ~touching & (later < np.minimum(last, first))
        sample, last, pair, above = later[keep], last[keep], pair[keep], above[keep]
    return (first if first < job.samples else None), queries


def skipped(travel: Floats, bounds: Floats, reach: Floats) -> NDArray[np.int64]:
    """Latest times at which the motion bound is still below `reach` [ps]."""
    piece = np.searchsorted(travel, reach, side="left") - 1
    beyond = piece >= len(travel) - 1
    piece = np.clip(piece, 0, len(travel) - 2)
    step = np.maximum(travel[piece + 1] - travel[piece], 1e-300)
    part = np.clip((reach - travel[piece]) / step, 0.0, 1.0)
    time_ps = bounds[piece] + part * (bounds[piece + 1] - bounds[piece])
    return np.where(beyond, np.iinfo(np.int64).max // 2, time_ps).astype(np.int64)


def posed(job: StudyJob, times: NDArray[np.int64]) -> dict[str, Floats]:
    """Pose of every link at some times, shape (m, 4, 4) each."""
    return world_from_link(job.machine, job.path.positions(times))


def distance_of(
    coal: Any, pair: CoalPair, poses: dict[str, Floats], row: int, request: Any, above: float
) -> float:
    """Distance of a pair, known to be at most `above` [mm]."""
    result = coal.DistanceResult()
    result.min_distance = min(above, 1e30)
    transforms = [
        coal.Transform3s(poses[link][row, :3, :3], poses[link][row, :3, 3]) for link in pair.links
    ]
    return float(
        coal.distance(pair.bodies[0], transforms[0], pair.bodies[1], transforms[1], request, result)
    )


if __name__ == "__main__":
    sys.exit(main())
