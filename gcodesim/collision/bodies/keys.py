"""Keys: two numbers packed into one int64, so that a minimum finds the first of many threads.

A contact key is (sample, pair): the lowest one is the first contact. A triangle key is (number in
a, number in b). Every packing and unpacking, on the host and on the device, is here.
"""

from __future__ import annotations

from typing import TypeVar

import numpy as np
import warp as wp
from numpy.typing import NDArray

from gcodesim.collision.geometry.device import BIT_EQUAL

wp.set_module_options(BIT_EQUAL)

OneOrMany = TypeVar("OneOrMany", int, NDArray[np.int64])

PAIR_BITS = 16
"""Bits of the pair in a contact key: they allow 65,536 pairs and 1.4e14 samples."""

NO_CONTACT = 2**63 - 1
"""Larger than every key."""

NUMBER_BITS = 32
"""Bits of the number in b in a triangle key."""

NO_KEY = wp.constant(wp.int64(NO_CONTACT))
PAIR_SHIFT = wp.constant(wp.int64(PAIR_BITS))
NUMBER_SHIFT = wp.constant(wp.int64(NUMBER_BITS))


def contact_key(sample: OneOrMany, pair: OneOrMany) -> OneOrMany:
    """Key of a contact of a pair at a sample, or the keys of several."""
    return (sample << PAIR_BITS) + pair


def sample_and_pair(key: int) -> tuple[int, int]:
    """The sample and the pair of a contact key."""
    return divmod(key, 1 << PAIR_BITS)


def triangle_numbers(key: int) -> tuple[int, int]:
    """The triangle numbers in a and in b of a triangle key."""
    return divmod(key, 1 << NUMBER_BITS)


@wp.func
def pack_contact(sample: wp.int64, pair: wp.int32):
    """Key of a contact on the device."""
    return (sample << PAIR_SHIFT) + wp.int64(pair)


@wp.func
def pack_triangles(a: wp.int32, b: wp.int32):
    """Key of two triangle numbers on the device."""
    return (wp.int64(a) << NUMBER_SHIFT) + wp.int64(b)
