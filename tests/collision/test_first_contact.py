"""First contacts against closed forms: the found sample is ceil(contact / period), exactly."""

from __future__ import annotations

from math import ceil

import numpy as np
import pytest
from collision.detecting import detected

from gcodesim.collision.detector import Detection
from gcodesim.constants import DEFAULT_PERIOD_PS
from gcodesim.study.scenes import (
    SAMPLED,
    KnownScene,
    arc_grazes_face,
    blade_through_sheet,
    cube_on_slab,
    delayed,
    flip_within_a_sample,
)

PHASES = 5
FRACTION_MARGIN = 1e-5  # of a period: nearer to a sample, rounding would decide


def run(
    scene: KnownScene,
    period_ps: int = DEFAULT_PERIOD_PS,
    device: str = "cpu",
    method: str = "exhaustive",
) -> Detection:
    return detected(scene.machine, scene.path, period_ps, device, method)


def found_sample(*args: object, **kwargs: object) -> int | None:
    contact = run(*args, **kwargs).contact  # type: ignore[arg-type]
    return contact.sample if contact else None


def expected_sample(scene: KnownScene, period_ps: int) -> int:
    assert scene.contact_s is not None
    exact = scene.contact_s * 1e12 / period_ps
    assert abs(exact - round(exact)) > FRACTION_MARGIN
    return ceil(exact)


@pytest.mark.parametrize("name", SAMPLED)
def test_scenes_have_their_published_instants(name: str) -> None:
    scene = SAMPLED[name]()
    if scene.published_s is not None:
        assert scene.contact_s == pytest.approx(scene.published_s, abs=2e-12)


@pytest.mark.parametrize("name", SAMPLED)
@pytest.mark.parametrize("period_ps", [DEFAULT_PERIOD_PS, 10 * DEFAULT_PERIOD_PS])
def test_first_sample_is_the_ceiling(name: str, period_ps: int, device: str) -> None:
    for j in range(PHASES):
        scene = delayed(SAMPLED[name](), j * period_ps // PHASES)
        contact = run(scene, period_ps, device).contact
        assert contact is not None
        assert contact.sample == expected_sample(scene, period_ps)
        assert contact.time_ps == contact.sample * period_ps
        assert not contact.appears


@pytest.mark.parametrize("name", SAMPLED)
def test_the_paper_finds_the_same_sample(name: str, device: str) -> None:
    period_ps = 10 * DEFAULT_PERIOD_PS
    scene = delayed(SAMPLED[name](), period_ps // 3)
    assert found_sample(scene, period_ps, device, "paper") == expected_sample(scene, period_ps)


def test_deepest_dip_of_a_grazing_arc_is_all_there_is(device: str) -> None:
    scene = arc_grazes_face()
    contact = run(scene, DEFAULT_PERIOD_PS, device).contact
    assert contact is not None
    assert contact.time_ps / 1e12 < scene.leaves_s
    assert found_sample(arc_grazes_face(-1e-6), DEFAULT_PERIOD_PS, device) is None


def test_thin_blade_is_missed_exactly_where_no_sample_falls(device: str) -> None:
    period_ps, hits = DEFAULT_PERIOD_PS, 0
    for j in range(20):
        scene = delayed(blade_through_sheet(), j * period_ps // 20)
        first = expected_sample(scene, period_ps)
        seen = first * period_ps / 1e12 <= scene.leaves_s
        assert found_sample(scene, period_ps, device) == (first if seen else None)
        hits += seen
    assert hits == 4


def test_touching_is_contact_and_a_micrometre_is_not(device: str) -> None:
    contact = run(cube_on_slab(0.0), device=device).contact
    assert contact is not None
    assert (contact.sample, contact.time_ps, contact.appears) == (0, 0, True)
    assert contact.triangles is not None
    assert contact.point is not None
    assert contact.point[2] == pytest.approx(0.0, abs=1e-9)
    assert found_sample(cube_on_slab(2.0**-20), device=device) is None


def test_half_turn_within_a_sample_is_seen_by_finer_samples_only(device: str) -> None:
    scene = flip_within_a_sample()
    assert found_sample(scene, DEFAULT_PERIOD_PS, device) is None
    fine = DEFAULT_PERIOD_PS // 10_007
    assert found_sample(scene, fine, device) == expected_sample(scene, fine)


def test_point_of_contact_is_where_the_vertex_is(device: str) -> None:
    scene = SAMPLED["S1"]()
    contact = run(scene, device=device).contact
    assert contact is not None
    assert contact.point is not None
    lowest = scene.machine.bodies["mover"].parts[0].triangles.reshape(-1, 3)
    vertex = lowest[np.argmin(lowest[:, 2])]
    # The vertex is up to 0.02 mm deep at the sample; its triangle cuts the face around it.
    np.testing.assert_allclose(contact.point, [vertex[0], vertex[1], 0.0], atol=0.1)
