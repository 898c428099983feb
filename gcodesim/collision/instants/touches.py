"""Touches: which bodies touch at single instants, by two-level boxes and certified triangle tests.

Per instant and pair: the boxes of the bodies; then every region of one body against every region of
the other; then, with the regions interchanged (each keeps only the triangles that reach into the
other's box, Siao et al. 2021, section 4.2.4), all surviving triangle pairs by the certified test.
One thread per (instant, pair); a batch of instants per launch; the first contact is the minimum of
one 64-bit key (sample, pair).
"""

from __future__ import annotations

import warp as wp

from gcodesim.collision.bodies.keys import NO_CONTACT, pack_contact, sample_and_pair
from gcodesim.collision.bodies.regions import REGION_SIZE
from gcodesim.collision.bodies.scene import Scene, SceneArrays
from gcodesim.collision.geometry.boxes import (
    AlignedBox,
    aabbs_overlap,
    abs_rotation,
    inverse,
    plane_clears_box,
    posed_box,
    posed_triangle,
    triangle_box,
)
from gcodesim.collision.geometry.device import BIT_EQUAL
from gcodesim.collision.geometry.poses import ChainArrays, PathArrays, Pose, pair_pose
from gcodesim.collision.geometry.predicates import triangles_touch
from gcodesim.collision.instants.work import BOX_TESTS, POSES, TRIANGLE_TESTS, WorkCounts
from gcodesim.motion.samples import Instants

wp.set_module_options(BIT_EQUAL)

MAX_REGION = wp.constant(REGION_SIZE)
COUNT_POSES = wp.constant(POSES)
COUNT_BOXES = wp.constant(BOX_TESTS)
COUNT_TRIANGLES = wp.constant(TRIANGLE_TESTS)


@wp.struct
class InstantArrays:
    """Instants on the device; see motion/samples.py."""

    time_ps: wp.array[wp.int64]
    piece: wp.array[wp.int32]
    sample: wp.array[wp.int64]


@wp.struct
class RegionResult:
    """Outcome of one pair of regions, with what it cost."""

    touch: wp.bool
    box_tests: wp.int64
    triangle_tests: wp.int64


@wp.func
def regions_touch(
    scene: SceneArrays, box_a: AlignedBox, a: wp.int32, b: wp.int32, posed: wp.array[wp.mat33d]
):
    """Interchange region a with region b (posed in `posed`), then test what is left."""
    result = RegionResult()
    b_count = scene.region_first[b + 1] - scene.region_first[b]
    result.box_tests = wp.int64(b_count)
    kept = wp.int32(0)
    reach = AlignedBox()
    for j in range(b_count):
        box = triangle_box(posed[j])
        if aabbs_overlap(box, box_a.low, box_a.high) and not plane_clears_box(posed[j], box_a):
            if kept == 0:
                reach = box
            reach.low = wp.min(reach.low, box.low)
            reach.high = wp.max(reach.high, box.high)
            kept = kept | (1 << j)
    if kept == 0:
        return result
    for i in range(scene.region_first[a], scene.region_first[a + 1]):
        t = scene.triangles[i]
        own = triangle_box(t)
        result.box_tests += wp.int64(1)
        if aabbs_overlap(reach, own.low, own.high) and not plane_clears_box(t, reach):
            for j in range(b_count):
                if (kept & (1 << j)) != 0 and not result.touch:
                    other = triangle_box(posed[j])
                    if aabbs_overlap(other, own.low, own.high):
                        result.triangle_tests += wp.int64(1)
                        result.touch = triangles_touch(t, posed[j])
    return result


@wp.func
def bodies_touch(scene: SceneArrays, pair: wp.int32, pose: Pose):
    """Two-level test of one pair at one pose."""
    total = RegionResult()
    total.box_tests = wp.int64(1)
    low_a = scene.box_a[pair, 0]
    high_a = scene.box_a[pair, 1]
    size = abs_rotation(pose.R)
    whole = posed_box(pose, size, scene.box_b[pair, 0], scene.box_b[pair, 1])
    if not aabbs_overlap(whole, low_a, high_a):
        return total
    back = inverse(pose)
    back_size = wp.transpose(size)
    posed = wp.zeros(shape=(MAX_REGION,), dtype=wp.mat33d)
    of_a = scene.regions_a[pair]
    of_b = scene.regions_b[pair]
    for b in range(of_b[0], of_b[1]):
        low_b = scene.region_low[b]
        high_b = scene.region_high[b]
        box_b = posed_box(pose, size, low_b, high_b)
        total.box_tests += wp.int64(1)
        if total.touch or not aabbs_overlap(box_b, low_a, high_a):
            continue
        ready = wp.bool(False)
        for a in range(of_a[0], of_a[1]):
            box_a = AlignedBox()
            box_a.low = scene.region_low[a]
            box_a.high = scene.region_high[a]
            total.box_tests += wp.int64(1)
            if total.touch or not aabbs_overlap(box_b, box_a.low, box_a.high):
                continue
            if not aabbs_overlap(posed_box(back, back_size, box_a.low, box_a.high), low_b, high_b):
                continue
            if not ready:
                start = scene.region_first[b]
                for j in range(scene.region_first[b + 1] - start):
                    posed[j] = posed_triangle(pose, scene.triangles[start + j])
                ready = wp.bool(True)
            result = regions_touch(scene, box_a, a, b, posed)
            total.touch = result.touch
            total.box_tests += result.box_tests
            total.triangle_tests += result.triangle_tests
    return total


@wp.kernel
def find_contacts(
    path: PathArrays,
    chains: ChainArrays,
    scene: SceneArrays,
    instants: InstantArrays,
    best_out: wp.array[wp.int64],
    work_out: wp.array[wp.int64],
):
    """One thread per (instant, pair)."""
    i, pair = wp.tid()
    key = pack_contact(instants.sample[i], pair)
    if key >= best_out[0]:
        return
    pose = pair_pose(path, chains, pair, instants.piece[i], instants.time_ps[i])
    result = bodies_touch(scene, pair, pose)
    wp.atomic_add(work_out, COUNT_POSES, wp.int64(1))
    wp.atomic_add(work_out, COUNT_BOXES, result.box_tests)
    wp.atomic_add(work_out, COUNT_TRIANGLES, result.triangle_tests)
    if result.touch:
        wp.atomic_min(best_out, 0, key)


def instant_arrays(instants: Instants, device: str) -> InstantArrays:
    """Copy instants to the device."""
    arrays = InstantArrays()
    arrays.time_ps = wp.array(instants.time_ps, dtype=wp.int64, device=device)
    arrays.piece = wp.array(instants.piece, dtype=wp.int32, device=device)
    arrays.sample = wp.array(instants.sample, dtype=wp.int64, device=device)
    return arrays


def first_touch(
    scene: Scene, path: PathArrays, instants: Instants, work: WorkCounts
) -> tuple[int, int] | None:
    """First (sample, pair index) in contact among the instants, None when all are free."""
    device = scene.device
    best = wp.full(1, NO_CONTACT, dtype=wp.int64, device=device)
    counts = wp.zeros(3, dtype=wp.int64, device=device)
    wp.launch(
        find_contacts,
        dim=(len(instants), len(scene.pairs)),
        inputs=[path, scene.chains, scene.arrays, instant_arrays(instants, device)],
        outputs=[best, counts],
        device=device,
    )
    work.counts += counts.numpy()
    key = int(best.numpy()[0])
    return None if key == NO_CONTACT else sample_and_pair(key)
