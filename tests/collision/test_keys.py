"""Keys: the host and the device pack alike, and the lowest key is the first contact."""

from __future__ import annotations

import numpy as np
import warp as wp

from gcodesim.collision.bodies.keys import (
    NO_CONTACT,
    NUMBER_BITS,
    PAIR_BITS,
    contact_key,
    pack_contact,
    pack_triangles,
    sample_and_pair,
    triangle_numbers,
)

SAMPLES = [0, 1, 2**31, 2**47 - 1]
PAIRS = [0, 1, 2**PAIR_BITS - 1]
NUMBERS = [0, 1, 2**31 - 1]


@wp.kernel
def pack_all(
    high: wp.array[wp.int64],
    low: wp.array[wp.int32],
    contact_out: wp.array2d[wp.int64],
    triangles_out: wp.array2d[wp.int64],
):
    i, j = wp.tid()
    contact_out[i, j] = pack_contact(high[i], low[j])
    triangles_out[i, j] = pack_triangles(wp.int32(high[i]), low[j])


def packed(high: list[int], low: list[int], device: str) -> tuple[list[list[int]], ...]:
    shape = (len(high), len(low))
    keys = [wp.zeros(shape, dtype=wp.int64, device=device) for _ in range(2)]
    inputs = [
        wp.array(high, dtype=wp.int64, device=device),
        wp.array(low, dtype=wp.int32, device=device),
    ]
    wp.launch(pack_all, dim=shape, inputs=inputs, outputs=keys, device=device)
    return tuple(each.numpy().tolist() for each in keys)


def test_host_and_device_pack_and_unpack_contacts_alike(device: str) -> None:
    keys, _ = packed(SAMPLES, PAIRS, device)
    assert keys == [[contact_key(sample, pair) for pair in PAIRS] for sample in SAMPLES]
    assert [[sample_and_pair(key) for key in row] for row in keys] == [
        [(sample, pair) for pair in PAIRS] for sample in SAMPLES
    ]


def test_the_numbers_of_two_triangles_come_back(device: str) -> None:
    _, keys = packed(NUMBERS, NUMBERS, device)
    assert [[triangle_numbers(key) for key in row] for row in keys] == [
        [(a, b) for b in NUMBERS] for a in NUMBERS
    ]
    assert max(NUMBERS) < 2**NUMBER_BITS


def test_an_earlier_sample_comes_before_a_lower_pair_and_nothing_after_no_contact() -> None:
    keys = contact_key(np.repeat(SAMPLES, len(PAIRS)), np.tile(PAIRS, len(SAMPLES)))
    assert (np.diff(keys) > 0).all()
    assert keys.max() <= NO_CONTACT
