"""The seed paper's method (Siao et al. 2021, sections 3 and 4), kept for comparison.

Triangles outside the machine's operating range are removed beforehand. Per sample and pair: two
sub-boxes per body, their overlaps interchanged into smaller regions, then one thread per triangle
pair: blocks of 32 x 32 threads, (N/32+1) x (M/32+1) blocks, consecutive threads fetching
consecutive triangles; six axes where the triangles lie in one plane, eleven otherwise; one
collision flag per sample. Axes are certified (predicates.py), so this method misses nothing
either; with fewer axes it would call degenerate and nearly coplanar triangles a contact, so what
its axes cannot separate is confirmed by the full test. The compiler unrolls the loops.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from gcodesim.collision.bodies.reach import reachable
from gcodesim.collision.bodies.regions import build_regions
from gcodesim.collision.bodies.scene import Scene
from gcodesim.collision.geometry.boxes import aabbs_overlap, posed_triangle, triangle_box
from gcodesim.collision.geometry.device import BIT_EQUAL
from gcodesim.collision.geometry.poses import ChainArrays, PathArrays, pair_pose
from gcodesim.collision.geometry.predicates import GUARD, abs_vec, edge, separates, triangles_touch
from gcodesim.collision.instants.touches import InstantArrays, instant_arrays
from gcodesim.collision.instants.work import WorkCounts
from gcodesim.machine.model import Joint
from gcodesim.motion.samples import Instants

wp.set_module_options(BIT_EQUAL)

TILE = wp.constant(32)
IN_PLANE = wp.constant(wp.float64(1.0e-12))
"""Sine of the angle between two normals below which triangles count as lying in one plane."""

BATCH = 64
"""Samples per launch: bounds the memory for posed triangles, amortises the launch."""


@dataclass(frozen=True)
class PaperPair:
    """Triangles of one pair that are within reach, on the device, with their two sub-regions."""

    pair: int
    triangles_a: Any
    triangles_b: Any
    half_a: int
    half_b: int


@wp.kernel
def pose_at_instants(
    path: PathArrays,
    chains: ChainArrays,
    pair: wp.int32,
    instants: InstantArrays,
    triangles: wp.array[wp.mat33d],
    posed_out: wp.array2d[wp.mat33d],
):
    """One thread per (instant, triangle of b)."""
    i, j = wp.tid()
    pose = pair_pose(path, chains, pair, instants.piece[i], instants.time_ps[i])
    posed_out[i, j] = posed_triangle(pose, triangles[j])


@wp.func
def union_box(triangles: wp.array[wp.mat33d], first: wp.int32, end: wp.int32):
    """Exact box of a run of triangles."""
    box = triangle_box(triangles[first])
    for j in range(first + 1, end):
        other = triangle_box(triangles[j])
        box.low = wp.min(box.low, other.low)
        box.high = wp.max(box.high, other.high)
    return box


@wp.func
def interchange(
    own: wp.array[wp.mat33d],
    own_half: wp.int32,
    other: wp.array[wp.mat33d],
    other_half: wp.int32,
    kept_out: wp.array[wp.int32],
):
    """Keep what each sub-region has inside an overlapping sub-region of the other body."""
    own_count = own.shape[0]
    other_count = other.shape[0]
    for s in range(2):
        first = wp.where(s == 0, 0, own_half)
        end = wp.where(s == 0, own_half, own_count)
        if first == end:
            continue
        region = union_box(own, first, end)
        for o in range(2):
            other_first = wp.where(o == 0, 0, other_half)
            other_end = wp.where(o == 0, other_half, other_count)
            if other_first == other_end:
                continue
            partner = union_box(other, other_first, other_end)
            if aabbs_overlap(region, partner.low, partner.high):
                for j in range(first, end):
                    if aabbs_overlap(triangle_box(own[j]), partner.low, partner.high):
                        kept_out[j] = 1


@wp.kernel
def detect_roughly(
    triangles_a: wp.array[wp.mat33d],
    half_a: wp.int32,
    posed_b: wp.array2d[wp.mat33d],
    half_b: wp.int32,
    kept_a_out: wp.array2d[wp.int32],
    kept_b_out: wp.array2d[wp.int32],
):
    """One thread per instant: two-level boxes and interchange of regions."""
    i = wp.tid()
    interchange(triangles_a, half_a, posed_b[i], half_b, kept_a_out[i])
    interchange(posed_b[i], half_b, triangles_a, half_a, kept_b_out[i])


@wp.func
def touch_6_or_11(a: wp.mat33d, b: wp.mat33d):
    """Contact by 6 axes in one plane, 11 otherwise."""
    a1 = a[1] - a[0]
    a2 = a[2] - a[0]
    b0 = b[0] - a[0]
    b1 = b[1] - a[0]
    b2 = b[2] - a[0]
    reach = wp.max(abs_vec(a1), abs_vec(a2))
    reach = wp.max(reach, wp.max(abs_vec(b0), wp.max(abs_vec(b1), abs_vec(b2))))
    if not (reach[0] + reach[1] + reach[2] < GUARD):
        return True
    na = wp.cross(a1, a2)
    nb = wp.cross(b1 - b0, b2 - b0)
    if separates(na, a1, a2, b0, b1, b2, reach):
        return False
    if separates(nb, a1, a2, b0, b1, b2, reach):
        return False
    if wp.length(wp.cross(na, nb)) <= IN_PLANE * wp.length(na) * wp.length(nb):
        for k in range(3):
            if separates(wp.cross(na, edge(a, k)), a1, a2, b0, b1, b2, reach):
                return False
            if separates(wp.cross(nb, edge(b, k)), a1, a2, b0, b1, b2, reach):
                return False
        return True
    for k in range(3):
        for m in range(3):
            if separates(wp.cross(edge(a, k), edge(b, m)), a1, a2, b0, b1, b2, reach):
                return False
    return True


@wp.kernel
def detect_in_detail(
    triangles_a: wp.array[wp.mat33d],
    posed_b: wp.array2d[wp.mat33d],
    kept_a: wp.array2d[wp.int32],
    kept_b: wp.array2d[wp.int32],
    flag_out: wp.array[wp.int32],
    work_out: wp.array[wp.int64],
):
    """One thread per (instant, triangle pair), 32 x 32 threads per block."""
    i, linear = wp.tid()
    columns = posed_b.shape[1] / TILE + 1
    block = linear / (TILE * TILE)
    thread = linear % (TILE * TILE)
    row = (block / columns) * TILE + thread / TILE
    column = (block % columns) * TILE + thread % TILE
    if row >= triangles_a.shape[0] or column >= posed_b.shape[1]:
        return
    if kept_a[i, row] == 0 or kept_b[i, column] == 0:
        return
    wp.atomic_add(work_out, 0, wp.int64(1))
    a = triangles_a[row]
    b = posed_b[i, column]
    if touch_6_or_11(a, b) and triangles_touch(a, b):
        flag_out[i] = 1


def prepare_paper(scene: Scene, joints: tuple[Joint, ...]) -> list[PaperPair]:
    """Remove what is out of reach and split every body into two sub-regions."""
    prepared = []
    for index, ((a, b), links) in enumerate(zip(scene.shapes, scene.links, strict=True)):
        near_a, near_b = reachable(joints, links, a.regions.triangles, b.regions.triangles)
        if near_a.any() and near_b.any():
            (ta, half_a), (tb, half_b) = (
                _halves(a.regions.triangles[near_a]),
                _halves(b.regions.triangles[near_b]),
            )
            on_device = [wp.array(t, dtype=wp.mat33d, device=scene.device) for t in (ta, tb)]
            prepared.append(PaperPair(index, *on_device, half_a, half_b))
    return prepared


def _halves(triangles: NDArray[np.float64]) -> tuple[NDArray[np.float64], int]:
    regions = build_regions(triangles, size=(len(triangles) + 1) // 2)
    return regions.triangles, int(regions.first[1])


def first_contact_paper(
    scene: Scene, prepared: list[PaperPair], path: PathArrays, instants: Instants, work: WorkCounts
) -> tuple[int, int] | None:
    """First (sample, pair index) in contact among the instants, None when all are free."""
    for start in range(0, len(instants), BATCH):
        part = slice(start, start + BATCH)
        batch = Instants(instants.time_ps[part], instants.piece[part], instants.sample[part])
        hits = []
        for pair in prepared:
            flags = detect_pair(scene, pair, path, instant_arrays(batch, scene.device), work)
            hits += [(int(batch.sample[i]), pair.pair) for i in np.flatnonzero(flags)[:1]]
        if hits:
            return min(hits)
    return None


def detect_pair(
    scene: Scene, pair: PaperPair, path: PathArrays, instants: InstantArrays, work: WorkCounts
) -> NDArray[np.int32]:
    """Collision flag of one pair at each instant, shape (instants,)."""
    device = scene.device
    count, n, m = len(instants.time_ps), len(pair.triangles_a), len(pair.triangles_b)
    posed = wp.zeros((count, m), dtype=wp.mat33d, device=device)
    kept_a = wp.zeros((count, n), dtype=wp.int32, device=device)
    kept_b = wp.zeros((count, m), dtype=wp.int32, device=device)
    flags = wp.zeros(count, dtype=wp.int32, device=device)
    tests = wp.zeros(1, dtype=wp.int64, device=device)
    wp.launch(
        pose_at_instants,
        dim=(count, m),
        inputs=[path, scene.chains, pair.pair, instants, pair.triangles_b],
        outputs=[posed],
        device=device,
    )
    wp.launch(
        detect_roughly,
        dim=count,
        inputs=[pair.triangles_a, pair.half_a, posed, pair.half_b],
        outputs=[kept_a, kept_b],
        device=device,
    )
    threads = 1024 * (n // 32 + 1) * (m // 32 + 1)
    wp.launch(
        detect_in_detail,
        dim=(count, threads),
        inputs=[pair.triangles_a, posed, kept_a, kept_b],
        outputs=[flags, tests],
        device=device,
        block_dim=1024,
    )
    work.counts += np.array([count, 0, tests.numpy()[0]])
    result: NDArray[np.int32] = flags.numpy()
    return result
