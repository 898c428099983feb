"""The exhaustive method against a brute-force twin, and what must not change its answer."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from collision.detecting import detected
from collision.scenes import random_joints, random_mesh, random_scene
from numpy.typing import NDArray

from gcodesim.collision.baseline import exhaustive
from gcodesim.collision.bodies import scene as scene_module
from gcodesim.collision.bodies.regions import build_regions, snapped
from gcodesim.collision.search.events import Contact
from gcodesim.machine.kinematics import world_from_link
from gcodesim.machine.model import Machine
from gcodesim.motion.path import Path
from gcodesim.study.exact import label
from gcodesim.study.families import generate
from gcodesim.study.scenes import BED_MOVER, Array, KnownScene, box, joint, machine, path

PERIOD_PS = 1_000_000_000
SEEDS = range(24)
Answer = tuple[int, tuple[str, str], tuple[int, int], int]


def first(
    m: Machine, p: Path, device: str, method: str = "exhaustive", period_ps: int = PERIOD_PS
) -> Contact | None:
    return detected(m, p, period_ps, device, method).contact


def sample_and_pair(contact: Contact | None) -> tuple[int, tuple[str, str]] | None:
    return (contact.sample, (contact.pair.a, contact.pair.b)) if contact else None


def whole(m: Machine, body: str) -> Array:
    return snapped(np.concatenate([part.triangles for part in m.bodies[body].parts]))


def lowest_touching(a: Array, b: Array) -> tuple[int, int] | None:
    """Lowest (number in a, number in b) of triangles that share a point, by the exact oracle."""
    low_a, high_a, low_b, high_b = a.min(1), a.max(1), b.min(1), b.max(1)
    near = (low_a[:, None] <= high_b[None]) & (low_b[None] <= high_a[:, None])
    i, j = np.nonzero(near.all(axis=2))
    hits = np.flatnonzero(label(a[i], b[j]))
    return (int(i[hits[0]]), int(j[hits[0]])) if len(hits) else None


def brute_force(m: Machine, p: Path, period_ps: int) -> Answer | None:
    """First contact by posing every triangle at every sample and block end, dwells included.

    Poses are rounded otherwise than on the device, by about 1e-13 mm: of no consequence unless two
    triangles come nearer than that, which random positions do not.
    """
    times = np.union1d(np.arange(0, p.duration_ps + 1, period_ps), p.bounds_ps)
    samples = -(-times // period_ps)
    world = world_from_link(m, p.positions(times))
    for sample in np.unique(samples):
        for pair in m.pairs:
            a, b = whole(m, pair.a), whole(m, pair.b)
            for k in np.flatnonzero(samples == sample):
                pose = np.linalg.inv(world[pair.a][k]) @ world[pair.b][k]
                posed = snapped(b @ pose[:3, :3].T + pose[:3, 3])
                numbers = lowest_touching(a, posed)
                if numbers:
                    return int(sample), (pair.a, pair.b), numbers, int(times[k])
    return None


def as_answer(m: Machine, contact: Contact | None) -> Answer | None:
    if contact is None:
        return None
    assert contact.triangles is not None
    numbers = []
    for body, part, number in zip(
        (contact.pair.a, contact.pair.b), contact.parts, contact.triangles, strict=True
    ):
        names = [q.name for q in m.bodies[body].parts]
        before = m.bodies[body].parts[: names.index(part)]
        numbers.append(number + sum(len(q.triangles) for q in before))
    pair = (contact.pair.a, contact.pair.b)
    return contact.sample, pair, (numbers[0], numbers[1]), contact.time_ps


def scenes() -> list[KnownScene]:
    return [random_scene(np.random.default_rng(seed)) for seed in SEEDS]


def test_answer_equals_brute_force(device: str) -> None:
    found = []
    for s in scenes():
        for period_ps in (PERIOD_PS, 7 * PERIOD_PS):
            contact = first(s.machine, s.path, device, period_ps=period_ps)
            found.append(contact)
            assert as_answer(s.machine, contact) == brute_force(s.machine, s.path, period_ps)
    assert sum(c is not None and c.sample > 1 for c in found) >= 10
    assert sum(c is not None and c.time_ps % PERIOD_PS > 0 for c in found) >= 3
    assert found.count(None) >= 10


@pytest.mark.parametrize("count", [1, 3, 7, 64])
def test_windows_change_nothing(count: int, device: str, monkeypatch: pytest.MonkeyPatch) -> None:
    whole_run = [as_answer(s.machine, first(s.machine, s.path, device)) for s in scenes()]
    monkeypatch.setattr(exhaustive, "WINDOW", count)
    split = [as_answer(s.machine, first(s.machine, s.path, device)) for s in scenes()]
    assert split == whole_run


@pytest.mark.parametrize("size", [1, 4, 15])
def test_region_sizes_change_nothing(
    size: int, device: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    usual = [as_answer(s.machine, first(s.machine, s.path, device)) for s in scenes()]
    monkeypatch.setattr(scene_module, "build_regions", partial(build_regions, size=size))
    other = [as_answer(s.machine, first(s.machine, s.path, device)) for s in scenes()]
    assert other == usual


def test_order_of_triangles_changes_no_sample_and_no_pair(
    device: str, rng: np.random.Generator
) -> None:
    for s in scenes():
        bodies = {
            name: replace(
                body,
                parts=tuple(
                    replace(
                        q, triangles=np.roll(rng.permutation(q.triangles), rng.integers(3), axis=1)
                    )
                    for q in body.parts
                ),
            )
            for name, body in s.machine.bodies.items()
        }
        other = first(replace(s.machine, bodies=bodies), s.path, device)
        assert sample_and_pair(other) == sample_and_pair(first(s.machine, s.path, device))


def test_the_paper_finds_the_same_sample_and_pair(device: str) -> None:
    for s in scenes():
        paper = first(s.machine, s.path, device, "paper")
        assert as_answer(s.machine, paper) == as_answer(s.machine, first(s.machine, s.path, device))


@pytest.mark.parametrize("method", ["exhaustive", "paper"])
def test_point_of_contact_lies_in_both_triangles(method: str, device: str) -> None:
    checked = 0
    for s in scenes():
        contact = first(s.machine, s.path, device, method)
        if contact is None or contact.triangles is None or contact.point is None:
            continue
        world = world_from_link(s.machine, s.path.positions(np.array([contact.time_ps]))[0])
        for body, part, number in zip(
            (contact.pair.a, contact.pair.b), contact.parts, contact.triangles, strict=True
        ):
            shape = s.machine.bodies[body]
            chosen = next(q for q in shape.parts if q.name == part)
            pose = world[shape.link]
            corners = chosen.triangles[number] @ pose[:3, :3].T + pose[:3, 3]
            assert distance_to_triangle(contact.point, corners) < 1e-8
            checked += 1
    assert checked >= 20


def distance_to_triangle(point: Array, corners: Array) -> float:
    """Distance [mm] by least squares in barycentric coordinates; points outside count as 1 mm."""
    system = np.vstack([corners.T, np.ones(3)])
    weights, *_ = np.linalg.lstsq(system, np.append(point, 1.0), rcond=None)
    if weights.min() < -1e-7:
        return 1.0
    return float(np.linalg.norm(weights @ corners - point))


# --- instants -------------------------------------------------------------------------------------

SLIDE = [joint("X", [1, 0, 0])]


def slide(*pieces: tuple[float, float]) -> Path:
    """A path of (samples, end) pieces from X0."""
    return path(SLIDE, [0.0], [(count * 1e-3, [end]) for count, end in pieces])


def slider() -> Machine:
    """A 2 mm cube at X0 between walls whose faces stand at X-4 and X4."""
    walls = {"left": box([2, 2, 2], [-5, 0, 0]), "right": box([2, 2, 2], [5, 0, 0])}
    joints = [*SLIDE, joint("Y", [0, 1, 0], "bed", "left"), joint("Z", [0, 0, 1], "bed", "right")]
    shapes = {"mover": box([2, 2, 2]), **walls}
    return machine(joints, shapes, [("left", "mover"), ("mover", "right")])


def slider_path(*pieces: tuple[float, float]) -> Path:
    p = slide(*pieces)
    still: NDArray[np.float64] = np.zeros((len(p), 2))
    q0, q1 = np.hstack([p.q0, still]), np.hstack([p.q1, still])
    return replace(p, joints=("X", "Y", "Z"), q0=q0, q1=q1, xyz=(0, 1, 2))


@pytest.mark.parametrize("count", [1, 2, 7, 64, 16384])
@pytest.mark.parametrize("dwell", [0.3, 1.0, 50.0])
def test_block_ends_between_samples_are_looked_at(
    count: int, dwell: float, device: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(exhaustive, "WINDOW", count)
    # In and out between samples 6 and 7, then standing still beyond the end of any short window.
    p = slider_path((6.2, 1.0), (0.2, 4.0), (0.2, 1.0), (dwell, 1.0), (1.0, 1.5))
    contact = first(slider(), p, device)
    assert sample_and_pair(contact) == (7, ("mover", "right"))
    assert contact is not None
    assert contact.time_ps == 6_400_000_000
    # Standing still in contact: found where it began, not where the dwell ends.
    stays = slider_path((6.2, 1.0), (0.2, 4.0), (dwell, 4.0), (1.0, 1.5))
    assert sample_and_pair(first(slider(), stays, device)) == (7, ("mover", "right"))


def test_ties_within_a_sample_go_to_the_alphabetically_first_pair(device: str) -> None:
    p = slider_path((6.2, 0.0), (0.2, 4.0), (0.2, -4.0), (9.0, 0.0))
    for method in ("exhaustive", "paper"):
        contact = first(slider(), p, device, method)
        assert sample_and_pair(contact) == (7, ("left", "mover"))
        assert contact is not None
        assert contact.time_ps == 6_600_000_000


def test_contact_at_the_very_end_is_seen(device: str) -> None:
    touching, short = slider_path((6.0, 2.9), (0.2, 3.0)), slider_path((6.0, 2.9), (0.2, 2.999))
    assert sample_and_pair(first(slider(), touching, device)) == (7, ("mover", "right"))
    assert first(slider(), short, device) is None


def test_a_path_without_pieces_is_not_checked(device: str) -> None:
    found = detected(slider(), slider_path(), device=device)
    assert found.contact is None
    assert not found.checked


@pytest.mark.parametrize("method", ["exhaustive", "paper"])
def test_contact_beyond_the_travel_is_found(method: str, device: str) -> None:
    for travel in ((-1.0, 1.0), (-np.inf, np.inf), (0.0, np.inf)):
        joints = [joint("X", [1, 0, 0], travel=travel), joint("C", [0, 0, 1], "bed", "table")]
        shapes = {"table": box([2, 2, 2], [5, 0, 0]), "mover": box([2, 2, 2])}
        for pair in (("mover", "table"), ("table", "mover")):
            m = machine(joints, shapes, [pair])
            p = path(joints, [0.0, 0.0], [(1e-2, [4.5, 20.0])])
            contact = first(m, p, device, method)
            assert contact is not None
            assert contact.sample == brute_force(m, p, PERIOD_PS)[0]  # type: ignore[index]


@pytest.mark.parametrize("method", ["exhaustive", "paper"])
def test_triangles_without_area_raise_no_alarm(method: str, device: str) -> None:
    rest = slide((1.0, 0.0))
    # Two bodies of one triangle each, at least one of them a line or a point.
    a, b = (snapped(t) for t in generate("F07", 60, seed=21))
    answers = [
        first(machine(SLIDE, {"bed": p[None], "mover": q[None]}, BED_MOVER), rest, device, method)
        for p, q in zip(a, b, strict=True)
    ]
    assert [contact is not None for contact in answers] == label(a, b).tolist()


def test_a_program_run_backwards_collides_if_and_only_if_it_does_forwards(
    device: str, rng: np.random.Generator
) -> None:
    seen = set()
    for _ in range(12):
        joints = random_joints(rng, 4, reach=60)
        shapes = {j.child: random_mesh(rng, 12.0, rng.uniform(-60, 60, 3)) for j in joints}
        names = sorted(shapes)
        m = machine(joints, shapes, [(a, b) for a in names for b in names if a < b])
        step = [30.0 if j.rotary else 20.0 for j in joints]
        stops = np.cumsum(rng.uniform(-1, 1, (6, 4)) * step, axis=0)
        seconds = rng.integers(1, 9, 5) * 1e-3
        there = path(joints, stops[0], list(zip(seconds, stops[1:], strict=True)))
        back = path(joints, stops[-1], list(zip(seconds[::-1], stops[-2::-1], strict=True)))
        hit = first(m, there, device) is not None
        assert (first(m, back, device) is not None) is hit
        seen.add(hit)
    assert seen == {True, False}
