"""The shipped machines: closed meshes, files that agree, and a reproducible build."""

import importlib.util
import math
from pathlib import Path

import numpy as np
import pytest
import trimesh
import yaml

MACHINES = Path(__file__).parents[2] / "machines"
NAMES = ["table_tilt", "head_tilt", "nutating_head", "table_head"]
PAPER_COUNTS = {"X": 44, "Y": 136, "Z": 180, "A": 164, "C": 548, "cutter": 716}


def load_builder():
    spec = importlib.util.spec_from_file_location("build_machines", MACHINES / "build_machines.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def read_yaml(name):
    return yaml.safe_load((MACHINES / f"{name}.yaml").read_text())


def mesh_paths(machine):
    paths = [link["mesh"] for link in machine["links"].values() if link]
    return {MACHINES / path for path in [*paths, machine["tool"]["mounted"]["mesh"]]}


def load(path):
    return trimesh.load(path, process=True)


def signed_volume(triangles):
    return np.einsum("ij,ij->i", triangles[:, 0], np.cross(triangles[:, 1], triangles[:, 2])).sum()


def test_table_tilt_has_the_triangle_counts_of_the_paper():
    counts = {link: len(load(MACHINES / f"table_tilt/{link}.stl").faces) for link in PAPER_COUNTS}
    assert counts == PAPER_COUNTS


@pytest.mark.parametrize(
    "path", sorted(MACHINES.glob("*/*.stl")), ids=lambda p: f"{p.parent.name}-{p.stem}"
)
def test_mesh_is_closed_consistent_and_without_degenerate_triangles(path):
    mesh = load(path)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.area_faces.min() > 0.1
    assert np.array_equal(mesh.vertices * 1024, np.round(mesh.vertices * 1024))


@pytest.mark.parametrize("name", NAMES)
def test_every_shell_is_closed_by_itself_and_faces_outwards(name):
    for shells in getattr(load_builder(), name)().values():
        for shell in shells:
            count = len(shell)
            mesh = trimesh.Trimesh(shell.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3))
            assert mesh.is_watertight
            assert signed_volume(shell - shell.mean(axis=(0, 1))) > 0


@pytest.mark.parametrize("name", NAMES)
def test_yaml_names_exactly_the_meshes_of_its_folder(name):
    machine = read_yaml(name)
    assert machine["name"] == name
    assert machine["verified"] is False
    assert mesh_paths(machine) == set((MACHINES / name).glob("*.stl"))


@pytest.mark.parametrize("name", NAMES)
def test_joints_form_a_tree_with_unit_axes_and_signs_of_iso_841(name):
    machine = read_yaml(name)
    children = [joint["child"] for joint in machine["joints"].values()]
    assert sorted([*children, "bed"]) == sorted(machine["links"])
    parents = {joint["child"]: joint["parent"] for joint in machine["joints"].values()}
    carries_work = [machine["work"]["link"]]
    while carries_work[-1] in parents:
        carries_work.append(parents[carries_work[-1]])
    letters = {"X": 0, "Y": 1, "Z": 2, "A": 0, "B": 1, "C": 2}
    for letter, joint in machine["joints"].items():
        expected = [0, 0, 0]
        expected[letters[letter]] = -1 if joint["child"] in carries_work else 1
        if (name, letter) == ("nutating_head", "B"):
            expected = [0, 1, 1]
        assert joint["axis"] == expected


@pytest.mark.parametrize("name", NAMES)
def test_reference_and_start_lie_within_the_travel(name):
    machine = read_yaml(name)
    for position in (*machine["reference"].values(), machine["start"]):
        assert set(position) == set(machine["joints"])
        for letter, value in position.items():
            low, high = machine["joints"][letter].get("limits", [-math.inf, math.inf])
            assert low <= value <= high


@pytest.mark.parametrize(
    ("name", "centre", "tool_length_active"),
    [
        ("table_tilt", [0, 0], True),
        ("head_tilt", [0, 0], True),
        ("nutating_head", [0, 0], True),
        ("table_head", [20, -15], False),
    ],
)
def test_g54_puts_program_zero_on_the_centre_of_the_table_surface(name, centre, tool_length_active):
    machine = read_yaml(name)
    tool, offset = machine["tool"], machine["work"]["offsets"]["G54"]
    gauge, length = tool["gauge_point"], tool["mounted"]["length"]
    tip = load(MACHINES / tool["mounted"]["mesh"]).bounds[0, 2]
    assert tip == gauge[2] - length
    joint_z = offset["Z"] + (length if tool_length_active else 0)
    table = load(MACHINES / machine["links"][machine["work"]["link"]]["mesh"])
    assert tip + joint_z == table.bounds[1, 2]
    # Table slides move against their letter, head slides with it: either brings both together.
    assert [gauge[0] + offset["X"], gauge[1] + offset["Y"]] == centre


def test_the_cradle_of_table_tilt_swings_clear_of_saddle_and_bulkhead():
    shells = load_builder().table_tilt()
    axis = np.array(read_yaml("table_tilt")["joints"]["A"]["point"][1:])
    swinging = np.concatenate([*shells["A"], *shells["C"]])[:, :, 1:].reshape(-1, 2)
    # C turns: each of its vertices comes to the plane x = 0 in front of the axis and behind it.
    table = np.concatenate(shells["C"]).reshape(-1, 3)
    radius, height = np.hypot(table[:, 0], table[:, 1]), table[:, 2]
    turned = [np.column_stack([side * radius, height]) for side in (-1, 1)]
    reach = np.linalg.norm(np.concatenate([swinging, *turned]) - axis, axis=1).max()
    floor = -shells["X"][0][:, :, 2].max()
    bulkhead = shells["Y"][3].reshape(-1, 3)
    wall = bulkhead[bulkhead[:, 2] == bulkhead[:, 2].max()][:, 1].min() - axis[1]
    assert reach + 5 < min(floor, wall)


def test_the_nutating_spindle_stays_on_its_side_of_the_leaning_bearing():
    """Whatever B is, carrier and spindle are parted by the plane of the bearing."""
    shells = load_builder().nutating_head()
    joint = read_yaml("nutating_head")["joints"]["B"]
    for link, side in (("B", -1), ("C", 1)):
        height = (np.concatenate(shells[link]).reshape(-1, 3) - joint["point"]) @ joint["axis"]
        assert (side * height).min() > 2.0


def test_the_build_writes_the_committed_bytes_again(tmp_path):
    load_builder().main(tmp_path)
    committed = {p.relative_to(MACHINES): p.read_bytes() for p in MACHINES.glob("*/*.stl")}
    rebuilt = {p.relative_to(tmp_path): p.read_bytes() for p in tmp_path.glob("*/*.stl")}
    assert rebuilt == committed
    assert sum(map(len, committed.values())) < 500_000
