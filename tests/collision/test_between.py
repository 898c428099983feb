"""Between the samples: what no sample shows is found, and what is only near is no contact."""

from __future__ import annotations

from dataclasses import replace
from math import ceil, sqrt

import numpy as np
import pytest
from collision.random_programs import Answer, Trial, answer, run

from gcodesim.checking.evidence import contact_finding, first_contact
from gcodesim.constants import DEFAULT_PERIOD_PS, TOLERANCE_MM
from gcodesim.machine.model import Part, Tool, ToolMount
from gcodesim.motion.path import ToolChange
from gcodesim.study.scenes import (
    BED_MOVER,
    Array,
    KnownScene,
    arc_grazes_face,
    blade_through_sheet,
    box,
    delayed,
    flip_within_a_sample,
    joint,
    machine,
    path,
)

PHASES = 20
PERIOD_PS = DEFAULT_PERIOD_PS


def trial(scene: KnownScene) -> Trial:
    return Trial(0, scene.machine, scene.path, PERIOD_PS)


# --- closed forms ---------------------------------------------------------------------------------


@pytest.mark.parametrize("scene", [blade_through_sheet, flip_within_a_sample])
def test_what_no_sample_shows_is_found(scene: object, device: str) -> None:
    """S7 and S12: before the contact, at a clearance below the tolerance, in every phase."""
    unseen = 0
    for j in range(PHASES):
        s = delayed(scene(), j * PERIOD_PS // PHASES)  # type: ignore[operator]
        assert s.contact_s is not None
        found = run(trial(s), between=True, device=device).contact
        assert found is not None
        sample = ceil(s.contact_s * 1e12 / PERIOD_PS)
        assert found.sample == sample
        at_samples = answer(run(trial(s), device=device))
        assert found.between == (at_samples is None)
        if not found.between:
            assert answer(run(trial(s), between=True, device=device)) == at_samples
            continue
        unseen += 1
        finding = contact_finding(found, first_contact(found, s.path, [""] * 10))
        assert finding.code == "GC107"
        assert found.distance == 0.0
        assert found.time_ps / 1e12 <= s.contact_s + 1e-12
        near = s.clearance_at(found.time_ps)
        assert near <= TOLERANCE_MM + 1e-6
        # No earlier than needed, too.
        before = found.time_ps - PERIOD_PS // 100_000
        assert s.clearance_at(before) > TOLERANCE_MM * 0.99
    assert unseen == (16 if scene is blade_through_sheet else 19)


@pytest.mark.parametrize("c", [0.5e-3, 0.9e-3, 0.999e-3, 1.001e-3, 2e-3])
def test_near_miss_against_the_tolerance(c: float, device: str) -> None:
    for j in range(0, PHASES, 3):
        s = delayed(arc_grazes_face(-c), j * PERIOD_PS // PHASES)
        found = run(trial(s), between=True, device=device).contact
        assert (found is not None) == (c < TOLERANCE_MM)
        assert answer(run(trial(s), device=device)) is None
        if found is not None:
            assert found.between
            assert found.distance == pytest.approx(c, abs=1e-6)
            near = s.clearance_at(found.time_ps)
            assert near == pytest.approx(TOLERANCE_MM, abs=1e-6)
            lift_s = sqrt(2 * 100 * (TOLERANCE_MM - c)) / (10000 / 60)
            middle_s = 0.2 + j * PERIOD_PS // PHASES / 1e12
            assert found.time_ps / 1e12 == pytest.approx(middle_s - lift_s, abs=1e-6)


# --- near stretches -------------------------------------------------------------------------------


def between_walls(
    *pieces: tuple[float, float, float], start: tuple[float, float] = (0, 0)
) -> Trial:
    """A cube over a floor 1 mm below, and a wall 1 mm from its side: (seconds, Z, X) pieces.

    Z moves the cube, X moves the wall: at -1 each touches, names in the order floor, wall.
    """
    joints = [joint("Z", [0, 0, 1], "bed", "cube"), joint("X", [1, 0, 0], "bed", "wall")]
    floor, wall = box([100, 100, 10], [0, 0, -11]), box([10, 10, 10], [11, 0, 0])
    m = machine(
        joints,
        {"bed": floor, "cube": box([10, 10, 10]), "wall": wall},
        [("bed", "cube"), ("cube", "wall")],
    )
    ends = [(seconds, [z, x]) for seconds, z, x in pieces]
    return Trial(0, m, path(joints, [*start], ends), PERIOD_PS)


def found_in(t: Trial, device: str) -> Answer | None:
    return answer(run(t, between=True, device=device))


def test_a_slow_approach_is_the_contact_it_leads_to(device: str) -> None:
    """1 mm/min: 600 samples within the tolerance before the touch."""
    t = between_walls((0.1, -0.99, 0), (0.6 + 0.00321, -0.99 - 0.01 * 1.00535, 0))
    found = found_in(t, device)
    assert found is not None
    assert found == answer(run(t, "exhaustive", device=device))
    assert found[:2] == (
        ceil((0.1 + 0.6 * 1.00321 / 1.00535 / 1.00321 * 1.00535) / 1e-4),
        "bed-cube",
    )


def test_near_at_a_block_end(device: str) -> None:
    t = between_walls((0.01, -0.9995, 0), (0.01, 0, 0))
    found = found_in(t, device)
    assert found is not None
    assert found[1] == "bed-cube"
    assert found[5]
    assert found[6] == pytest.approx(0.0005, abs=1e-6)
    assert found[4] / 1e12 == pytest.approx(0.01 * 0.999 / 0.9995, abs=1e-8)
    assert found_in(between_walls((0.01, -0.99899, 0), (0.01, 0, 0)), device) is None
    # The same with the end of the block away from every sample.
    odd = found_in(between_walls((0.01003, -0.9995, 0), (0.01, 0, 0)), device)
    assert odd is not None
    assert odd[5]
    assert odd[6] == pytest.approx(0.0005, abs=1e-6)


def test_standing_near_takes_no_time(device: str) -> None:
    """An hour within the tolerance: 36 million samples, too many to walk."""
    t = between_walls((0.01, -0.9995, 0), (3600.0, -0.9995, 0), (0.01, 0, 0))
    found = found_in(t, device)
    assert found is not None
    assert found[5]
    assert found[6] == pytest.approx(0.0005, abs=1e-6)
    touching = between_walls((0.01, -0.9995, 0), (3600.0, -0.9995, 0), (0.01, -1.1, 0))
    found = found_in(touching, device)
    assert found is not None
    assert not found[5]
    assert found == answer(run(touching, "exhaustive", device=device))


def test_near_until_another_pair_touches(device: str) -> None:
    # The wall touches while the cube is near the floor; then the cube goes down: first the wall.
    down = between_walls((0.01, -0.9995, 0), (0.01, -0.9996, -1.1), (0.01, -1.2, -1.1))
    found = found_in(down, device)
    assert found is not None
    assert found[1] == "cube-wall"
    assert found == answer(run(down, "exhaustive", device=device))
    # Then it goes up: the floor was near without a touch to come, and earlier.
    up = between_walls((0.01, -0.9995, 0), (0.01, -0.9996, -1.1), (0.01, 0, -1.1))
    found = found_in(up, device)
    assert found is not None
    assert found[1] == "bed-cube"
    assert found[5]
    assert found[6] == pytest.approx(0.0004, abs=1e-6)
    assert found[4] < 0.01 * 1e12


def test_near_in_the_sample_in_which_another_pair_touches(device: str) -> None:
    # Down and up again within sample 101 (floor), while the wall touches at sample 101.
    floor_first = ((0.01, -0.5, -0.9), (5e-5, -0.9995, -0.95), (5e-5, -0.5, -1.0), (0.01, 0, 0))
    found = found_in(between_walls(*floor_first), device)
    assert found is not None
    assert (found[:2], found[5]) == ((101, "bed-cube"), True)
    # The other way round the wall is the near one, and the floor's pair comes first in order.
    wall_first = tuple((s, x, z) for s, z, x in floor_first)
    found = found_in(between_walls(*wall_first), device)
    assert found is not None
    assert (found[:2], found[5]) == ((101, "bed-cube"), False)


def test_a_near_stretch_ends_before_a_touch_in_the_same_sample(device: str) -> None:
    # Near at 0.01, away from the floor at a block end, and down on it by the end of the sample.
    t = between_walls((0.01, -0.9995, 0), (2e-5, -0.5, 0), (2e-5, -0.5, 0), (6e-5, -1.0, 0))
    found = found_in(t, device)
    assert found is not None
    assert found[5]
    assert found[:2] == (100, "bed-cube")
    assert found[6] == pytest.approx(0.0005, abs=1e-6)


# --- tool changes ---------------------------------------------------------------------------------


def drilling(stops: list[float], changes: list[tuple[int, int]]) -> Trial:
    """Tools of 20, 45 and 30 mm below a gauge point at Z50 over a table; 10 ms per stop."""
    joints = [joint("Z", [0, 0, 1])]
    m = machine(joints, {"bed": box([100, 100, 20], [0, 0, -10])}, [*BED_MOVER, ("bed", "tool")])

    def shape(length: float) -> Array:
        return box([4, 4, length], [0, 0, -length / 2])

    tools = {
        number: Tool(number, "", length, 4.0, (0.0,) * 6, (Part("flute", shape(length)),))
        for number, length in ((1, 20.0), (2, 45.0), (3, 30.0))
    }
    mount = ToolMount("tool", "mover", np.array([0, 0, 50.0]), np.array([0, 0, 1.0]))
    m = replace(m, pairs=m.pairs[1:], tool=mount, tools=tools)
    p = path(joints, [0.0], [(0.01, [z]) for z in stops])
    lined = tuple(ToolChange(piece, number, number) for piece, number in changes)
    return Trial(0, m, replace(p, tool_changes=lined), PERIOD_PS)


def test_near_when_the_tool_is_changed(device: str) -> None:
    # Tool 1 ends its work 0.0005 mm above the table; tool 3 then stands in it, or is not there.
    near = drilling([-29.9995, 0], [(0, 1), (1, 9)])
    found = found_in(near, device)
    assert found is not None
    assert found[5]
    assert found[6] == pytest.approx(0.0005, abs=1e-6)
    assert found[4] < 10**10
    swapped = drilling([-29.9995, 0], [(0, 1), (1, 3)])
    assert found_in(swapped, device) == found
    above = drilling([-29.9985, 0], [(0, 1), (1, 9)])
    assert found_in(above, device) is None
    appears = drilling([-29.9985, 0], [(0, 1), (1, 3)])
    found = found_in(appears, device)
    assert found is not None
    assert found[0] == 100
    assert not found[5]


def test_near_at_the_very_end_and_at_the_start(device: str) -> None:
    end = found_in(between_walls((0.01, -0.9995, 0)), device)
    assert end is not None
    assert end[5]
    assert end[6] == pytest.approx(0.0005, abs=1e-6)
    start = found_in(between_walls((0.01, 0, 0), start=(-0.9995, 0)), device)
    assert start is not None
    assert start[5]
    assert start[0] <= 1
    assert start[6] == pytest.approx(0.0005, abs=1e-6)
