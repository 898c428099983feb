"""The smaller flute lies inside the real one, the inset away from floors and walls."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from gcodesim.constants import FLUTE_INSET_MM
from gcodesim.machine import shapes
from gcodesim.machine.flutes import above_flute, round_profile, shrunk, smaller_flute
from gcodesim.machine.loading import load_machine
from gcodesim.machine.model import Body


def stands(body: Body, machine: object) -> np.ndarray:
    """Corners of a body of a machine with a vertical spindle, from the gauge point."""
    points = np.concatenate([part.triangles for part in body.parts]).reshape(-1, 3)
    return points - machine.tool.gauge_point  # type: ignore[attr-defined]


def test_the_profile_of_a_turned_shape_is_found_again() -> None:
    profile = round_profile(
        shapes.revolve([(2.0, 0.0), (5.0, 3.0), (5.0, 10.0), (8.0, 10.0), (8.0, 12.0)])
    )
    assert profile is not None
    wanted = [(2, 0), (5, 3), (5, 3), (5, 10), (8, 10), (8, 12)]
    assert np.allclose(profile, wanted, atol=1e-9)


def test_a_box_is_not_round() -> None:
    assert round_profile(shapes.box([10, 10, 10])) is None


@pytest.mark.parametrize(
    ("profile", "wanted"),
    [
        ([(5, 0), (5, 9)], [(4, 1), (4, 8)]),  # a floor and a wall are one inset away
        ([(5, 0), (5, 4), (9, 4), (9, 8)], [(4, 1), (4, 5), (8, 5), (8, 7)]),
        ([(9, 0), (9, 4), (5, 4), (5, 8)], [(8, 1), (8, 3), (4, 3), (4, 7)]),
        ([(1, 0), (1, 9)], []),
        ([(5, 0), (5, 2)], []),
    ],
)
def test_a_profile_shrinks_along_radius_and_axis(profile: list, wanted: list) -> None:
    found = shrunk([(float(r), float(z)) for r, z in profile], 1.0)
    kept = [p for i, p in enumerate(found) if p in {tuple(map(float, w)) for w in wanted}]
    assert sorted(set(kept)) == sorted(tuple(map(float, w)) for w in wanted)
    assert max((r for r, _ in found), default=0.0) == max((w[0] for w in wanted), default=0)


def test_a_point_of_the_smaller_profile_is_the_inset_inside_the_real_one() -> None:
    rng = np.random.default_rng(4)
    for _ in range(50):
        heights = np.sort(rng.uniform(0, 20, 6))
        corners = [(float(r), float(z)) for r, z in zip(rng.uniform(1, 9, 6), heights, strict=True)]
        profile = [p for pair in pairwise(corners) for p in pair]
        small = shrunk(profile, 0.5)
        radii, levels = (np.array(v) for v in zip(*corners, strict=True))
        for (r0, z0), (r1, z1) in zip(small[::2], small[1::2], strict=False):
            for part in (0.01, 0.5, 0.99):
                r, z = r0 + part * (r1 - r0), z0 + part * (z1 - z0)
                near = z + np.linspace(-0.5, 0.5, 41)
                if r > 0.0:
                    assert r <= np.interp(near, levels, radii).min() - 0.5 + 1e-9


@pytest.mark.parametrize("name", ["table_tilt", "table_head", "head_tilt", "nutating_head"])
def test_the_flute_of_a_shipped_machine_can_be_made_smaller(name: str) -> None:
    machine = load_machine(name)
    body, odd = smaller_flute(machine, None)
    assert body is not None
    assert not odd
    points = stands(body, machine)
    assert points[:, 2].min() == pytest.approx(FLUTE_INSET_MM - machine.tool.length, abs=0.06)
    side = np.hypot(points[:, 0], points[:, 1])[points[:, 2] < 20 - machine.tool.length]
    assert side.max() == pytest.approx(6 - FLUTE_INSET_MM, abs=1e-4)


@pytest.mark.parametrize("name", ["table_tilt", "table_head", "head_tilt", "nutating_head"])
def test_what_lies_above_the_flute_is_a_shank_of_its_own(name: str) -> None:
    machine = load_machine(name)
    rest = above_flute(machine)
    assert rest is not None
    assert rest.parts[0].role == "shank"
    points = stands(rest, machine)
    assert points[:, 2].min() == pytest.approx(26 - machine.tool.length, abs=1e-9)
    assert points[:, 2].max() == pytest.approx(0.0, abs=1e-4)
