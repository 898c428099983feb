"""Containment: a body inside another touches nothing and is a contact all the same."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from collision.detecting import detected

from gcodesim.collision.detector import Detection
from gcodesim.collision.instants.containment import contains, shell_vertices, winding_number
from gcodesim.machine.model import Part
from gcodesim.study.scenes import Array, KnownScene, box, joint, machine, path

AT_REST = np.eye(4)
HALL = box([100, 80, 60])


def resting(
    shapes: dict[str, Array | dict[str, Array]],
    at: tuple[float, float] = (0.0, 0.0),
    **kwargs: list[str],
) -> KnownScene:
    """Bodies `inner` (on X Y) and `outer` that move 1 mm along X."""
    joints = [joint("X", [1, 0, 0]), joint("Y", [0, 1, 0], "mover", "inner")]
    joints.append(joint("Z", [0, 0, 1], "bed", "outer"))
    m = machine(joints, shapes, [("inner", "outer")], **kwargs)
    return KnownScene(m, path(joints, [*at, 0.0], [(1e-3, [at[0] + 1, at[1], 0.0])]), None)


def run(scene: KnownScene, method: str = "exhaustive") -> Detection:
    return detected(scene.machine, scene.path, method=method)


def hollow(size: Array) -> Array:
    """A closed box with a cavity: the inner shell faces inwards."""
    return np.concatenate([box(size), box(np.asarray(size) - 10)[:, ::-1]])


@pytest.mark.parametrize("method", ["exhaustive", "paper"])
@pytest.mark.parametrize("swapped", [False, True])
def test_body_inside_another_at_the_start_is_a_contact(method: str, swapped: bool) -> None:
    small, large = box([4, 4, 4]), HALL
    shapes = {"inner": large, "outer": small} if swapped else {"inner": small, "outer": large}
    contact = run(resting(shapes, (1.0, 2.0)), method).contact
    assert contact is not None
    assert (contact.sample, contact.time_ps, contact.appears) == (0, 0, True)
    assert contact.triangles is None
    assert contact.parts == ("inner", "outer")


@pytest.mark.parametrize("at", [(200.0, 0.0), (0.0, -41.5), (52.5, 0.0)])
def test_body_outside_is_free(at: tuple[float, float]) -> None:
    found = run(resting({"inner": box([4, 2, 4]), "outer": HALL}, at))
    assert found.contact is None
    assert not found.undecided


def test_surfaces_that_meet_are_reported_as_touching_triangles() -> None:
    contact = run(resting({"inner": box([4, 4, 4]), "outer": HALL}, (49.0, 0.0))).contact
    assert contact is not None
    assert contact.triangles is not None


def test_body_in_a_cavity_is_free_and_inside_the_wall_is_not() -> None:
    shapes = {"inner": box([2, 2, 2]), "outer": hollow([100, 80, 60])}
    assert run(resting(shapes)).contact is None
    assert run(resting(shapes, (46.0, 0.0))).contact is not None


def test_one_of_several_shells_inside_is_enough() -> None:
    far = np.concatenate([box([4, 4, 4], [500, 0, 0]), box([4, 4, 4], [0, 300, 0])])
    assert run(resting({"inner": far, "outer": HALL})).contact is None
    near = np.concatenate([far, box([4, 4, 4], [7, 7, 7])])
    assert run(resting({"inner": near, "outer": HALL})).contact is not None
    parts = {"shank": far, "flute": box([4, 4, 4], [7, 7, 7])}
    contact = run(resting({"inner": parts, "outer": HALL})).contact
    assert contact is not None
    assert contact.parts == ("flute", "outer")


def test_open_mesh_around_another_body_is_undecided() -> None:
    lid_off = {"inner": box([4, 4, 4]), "outer": {"shell": HALL[:-1]}}
    found = run(resting(lid_off, open_parts=["shell"]))
    assert found.contact is None
    assert [(p.name, c.outer, c.inner) for p, c in found.undecided] == [
        ("inner-outer", "shell", "inner")
    ]
    apart = run(resting(lid_off, (300.0, 0.0), open_parts=["shell"]))
    assert not apart.undecided


def test_random_points_in_a_torus_against_its_formula(rng: np.random.Generator) -> None:
    torus = trimesh.creation.torus(20.0, 8.0, major_sections=64, minor_sections=48)
    triangles = np.array(torus.triangles)
    points = rng.uniform(-30, 30, (400, 3)) * [1, 1, 0.3]
    depth = 8 - np.hypot(np.hypot(points[:, 0], points[:, 1]) - 20, points[:, 2])
    clear = np.abs(depth) > 0.1  # the facets cut the tube by less
    found = [winding_number(p, triangles) for p in points[clear]]
    np.testing.assert_allclose(found, (depth > 0)[clear].astype(float), atol=1e-9)


def test_shells_are_counted_whatever_the_order_of_triangles(rng: np.random.Generator) -> None:
    ring = np.array(trimesh.creation.torus(20.0, 3.0).triangles)
    boxes = [box([1, 1, 1]), box([1, 1, 1], [5, 0, 0])]
    many = np.concatenate([ring, *boxes, np.add(ring, [0, 0, 40])])
    assert len(shell_vertices(rng.permutation(many))) == 4


def test_pose_moves_the_inner_part() -> None:
    outer, inner = Part("outer", HALL), Part("inner", box([4, 4, 4], [200, 0, 0]))
    pose = AT_REST.copy()
    assert contains(outer, inner, pose) is False
    pose[0, 3] = -200.0
    assert contains(outer, inner, pose) is True
