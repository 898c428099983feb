"""Motion bounds: nothing leaves its chord by more than proved, on thousands of random chains."""

from __future__ import annotations

from unittest.mock import patch

import numpy as np
import pytest
from collision import chord_bounds
from collision.chord_bounds import PIECES, SLACK_MM, Chords, compare, random_chords
from collision.random_programs import Setup, answer, random_trial, run
from collision.scenes import displacement, random_arc, random_joints, random_path

from gcodesim.collision.bodies.trees import build_tree
from gcodesim.collision.bounds import forest
from gcodesim.collision.bounds.motion_bounds import (
    common_frame,
    dyadic_motion,
    levers,
    travelled,
)
from gcodesim.collision.geometry.poses import joints_between
from gcodesim.machine.kinematics import joint_displacement
from gcodesim.machine.model import Joint
from gcodesim.motion.path import ARC_PIECE, Path
from gcodesim.study.scenes import Array, joint, path

MACHINES = 390
CHAINS = 5_000
ROUNDING = 1e-9  # mm or rad


@pytest.fixture(scope="module")
def chords() -> list[Chords]:
    return [random_chords(np.random.default_rng([5, i])) for i in range(MACHINES)]


def joint_scale(joints: tuple[Joint, ...]) -> Array:
    return np.array([np.pi / 180 if j.rotary else 1.0 for j in joints])


def test_no_gap_falls_below_the_chord_bound(chords: list[Chords], rng: np.random.Generator) -> None:
    chains, sharpest = 0, 0.0
    for c in chords:
        frames = [common_frame(c.machine.joints, *links) for links in c.scene.links]
        found = compare(c, rng, frames)
        assert found.excess.max() <= SLACK_MM
        sharpest = max(sharpest, found.sharpness.max())
        chains += len(frames)
    assert chains >= CHAINS
    assert 0.8 < sharpest <= 1.0  # a bound that nothing comes near would prove nothing here


@pytest.mark.parametrize("side", [0, 1])
def test_any_frame_on_the_chain_bounds_as_well(side: int, rng: np.random.Generator) -> None:
    with patch.object(forest, "common_frame", lambda joints, *links: links[side]):
        for i in range(20):
            c = random_chords(np.random.default_rng([6, i]))
            assert compare(c, rng, [links[side] for links in c.scene.links]).excess.max() <= 1e-9


def test_the_choice_of_the_frame_changes_no_answer() -> None:
    trials = [random_trial(seed) for seed in range(8)]
    expected = [answer(run(t, between=True)) for t in trials]
    assert {a is None for a in expected} == {True, False}
    for side in (0, 1):
        with patch.object(forest, "common_frame", lambda joints, *links, k=side: links[k]):
            assert [answer(run(t, between=True, setup=Setup())) for t in trials] == expected


def test_joints_stay_within_their_deviation_from_the_chord(chords: list[Chords]) -> None:
    """Some point of the chord is near enough to every instant, in all joints at once."""
    for c in chords:
        q = c.path.positions(c.times.ravel()).reshape(*c.times.shape, -1)
        q = q * joint_scale(c.machine.joints)
        assert_near_chord(q, c.deviation)
        assert (np.abs(q[:, -1] - q[:, 0]) <= c.moved + ROUNDING).all()


def assert_near_chord(q: Array, deviation: Array) -> None:
    """Positions (stretches, instants, joints) against the chords from first to last."""
    moved = q[:, -1:] - q[:, :1]
    slack = deviation[:, None] + ROUNDING
    still = np.abs(moved) < ROUNDING
    assert (np.abs(q - q[:, :1]) <= slack + np.abs(moved))[np.broadcast_to(still, q.shape)].all()
    along = np.where(still, 1.0, moved)
    ends = (q - q[:, :1] + np.array([-1, 1])[:, None, None, None] * slack) / along
    low = np.where(still, 0.0, np.min(ends, axis=0)).max(axis=2)
    high = np.where(still, 1.0, np.max(ends, axis=0)).min(axis=2)
    assert (np.maximum(low, 0.0) <= np.minimum(high, 1.0) + 1e-9).all()


def test_dyadic_runs_contain_the_path(rng: np.random.Generator) -> None:
    joints = (*[joint(n, np.eye(3)[i]) for i, n in enumerate("XYZ")], joint("C", [0, 0, 1]))
    for _ in range(20):
        p = random_path(rng, joints, 21)
        motion = dyadic_motion(p, joints, 2, 19, 5)
        for level in range(6):
            for run_ in range(-(-17 >> level)):
                first, last = 2 + (run_ << level), min(2 + ((run_ + 1) << level), 19)
                times = np.linspace(*p.bounds_ps[[first, last]], 40).astype(np.int64)
                row = motion.level_first[level] + run_
                q = (p.positions(times) * joint_scale(joints))[None]
                assert_near_chord(q, motion.deviation[[row]])
                assert np.allclose(np.abs(q[0, -1] - q[0, 0]), motion.moved[row], atol=1e-9)


def helices_on_a_table(joints: list[Joint], count: int) -> Path:
    """Oblique helices whose rise cancels their turns in X, so that X ends where it began."""
    tilt, radius = np.radians(20.0), 10.0
    normal = np.array([np.sin(tilt), 0, np.cos(tilt)])
    u = np.array([np.cos(tilt), 0, -np.sin(tilt)])
    lift = 2 * radius * normal / np.tan(tilt)
    arc = np.array((u, np.cross(normal, u), lift, radius, radius, 540.0), ARC_PIECE)
    step = np.concatenate([[20.0], displacement(arc)])
    assert abs(step[1]) < 1e-9
    ends = [(0.01, (i + 1) * step) for i in range(count)]
    return path(joints, np.zeros(4), ends, arcs=dict.fromkeys(range(count), arc))


def test_parts_of_an_arc_may_move_farther_than_the_whole(rng: np.random.Generator) -> None:
    joints = [joint("C", [0, 0, 1], "bed", "table")]
    joints += [joint(n, np.eye(3)[i], "table", f"link {n}") for i, n in enumerate("XYZ")]
    with (
        patch.object(chord_bounds, "random_joints", lambda *args, **kwargs: joints),
        patch.object(
            chord_bounds, "random_path", lambda *args, **kw: helices_on_a_table(joints, PIECES)
        ),
    ):
        found = [random_chords(np.random.default_rng(seed)) for seed in range(5)]
    for c in found:
        q = c.path.positions(c.times.ravel()).reshape(*c.times.shape, -1)
        moved = np.abs(q[:, -1] - q[:, 0]) * joint_scale(c.machine.joints)
        assert (moved <= c.moved + ROUNDING).all()
        frames = [common_frame(c.machine.joints, *links) for links in c.scene.links]
        assert compare(c, rng, frames).excess.max() <= SLACK_MM


@pytest.mark.parametrize("seed", range(12))
def test_levers_bound_the_distance_from_every_axis(seed: int) -> None:
    rng = np.random.default_rng([8, seed])
    joints = tuple(random_joints(rng, 6, reach=rng.choice([1.0, 300.0])))
    p = random_path(rng, joints, 12, rotary=float(rng.choice([30.0, 400.0])))
    moving = travelled(joints, p)
    triangles = rng.uniform(-80, 80, (7, 3, 3)) + rng.uniform(-100, 100, 3)
    tree = build_tree(triangles)
    for link in [j.child for j in joints]:
        chain = joints_between(joints, "bed", link)
        bound = levers(moving, chain, triangles, tree).max(axis=0)
        times = np.linspace(0, p.duration_ps, 500).astype(np.int64)
        within = [rng.uniform(j.lower, j.upper, 500) for j in moving]
        for q in (p.positions(times), np.stack(within, axis=1)):
            assert_within(joints, chain, triangles.reshape(-1, 3), q, bound)


def assert_within(
    joints: tuple[Joint, ...],
    chain: list[tuple[int, int]],
    points: Array,
    q: Array,
    bound: Array,
) -> None:
    """Distances of the points from each rotary axis, the joints beyond it at positions q."""
    rotary = [step for step, (column, _) in enumerate(chain) if joints[column].rotary]
    for step, most in zip(rotary, bound, strict=True):
        axis = joints[chain[step][0]]
        posed = np.broadcast_to(points, (len(q), *points.shape))
        for column, sign in reversed(chain[step + 1 :]):
            pose = joint_displacement(joints[column], sign * q[:, column])
            posed = posed @ pose[:, :3, :3].transpose(0, 2, 1) + pose[:, None, :3, 3]
        distance = np.linalg.norm(np.cross(posed - axis.point, axis.axis), axis=-1)
        assert distance.max() <= most + ROUNDING


def test_arcs_in_every_plane_stay_within_their_sagitta(rng: np.random.Generator) -> None:
    joints = tuple(joint(n, np.eye(3)[i]) for i, n in enumerate("XYZ"))
    for _ in range(200):
        arc = random_arc(rng, 100.0)
        end = displacement(arc)
        p = path(joints, np.zeros(3), [(0.01, end)], arcs={0: arc})
        motion = dyadic_motion(p, joints, 0, 1, 0)
        q = p.positions(np.linspace(0, p.duration_ps, 200).astype(np.int64))
        assert_near_chord(q[None], motion.deviation)
