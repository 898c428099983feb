"""Random programs: the race misses nothing that voxels see, and every witness is one."""

from __future__ import annotations

import pytest
from stock.random_jobs import random_job, verdict


@pytest.mark.parametrize(
    "seed",
    [*range(12), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(12, 60))],
)
def test_a_random_program_agrees_with_mutable_voxels(seed: int) -> None:
    word, _ = verdict(random_job(seed))
    assert word == "agrees"
