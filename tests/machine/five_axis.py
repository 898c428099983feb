"""Five-axis machines of every type as plain data, without shapes."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gcodesim.machine.kinematics import world_from_link
from gcodesim.machine.model import Joint, Machine, ToolMount
from gcodesim.machine.tool_centre import ToolCentre, tool_centre
from gcodesim.nc.control.readings import ROWS

Array = NDArray[np.float64]
SKEW = (0.0, math.sqrt(0.5), math.sqrt(0.5))
GAUGE = (12.0, -35.0, 410.0)


def joint(
    name: str,
    parent: str,
    axis: ArrayLike,
    point: ArrayLike = (0, 0, 0),
    travel: tuple[float, float] = (-math.inf, math.inf),
    rapid: float = 100.0,
) -> Joint:
    unit = np.asarray(axis, np.float64)
    unit = unit / np.linalg.norm(unit)
    where = np.asarray(point, np.float64)
    return Joint(name, name in "ABC", parent, f"l{name}", unit, where, *travel, rapid)


def machine(
    work: str, tool: str, axes: dict[str, ArrayLike], points: dict[str, ArrayLike] | None = None
) -> Machine:
    """Branches as letters from the root: work "YXAC" and tool "Z"."""
    joints = []
    for branch in (work, tool):
        parent = "bed"
        for name in branch:
            joints.append(joint(name, parent, axes[name], (points or {}).get(name, (0, 0, 0))))
            parent = f"l{name}"
    ends = [f"l{branch[-1]}" if branch else "bed" for branch in (work, tool)]
    mount = ToolMount("cutter", ends[1], np.array(GAUGE), np.array([0.0, 0.0, 1.0]))
    links = ("bed", *(j.child for j in joints))
    return Machine(
        "test",
        "",
        True,
        links,
        tuple(joints),
        {},
        (),
        mount,
        None,
        ends[0],
        {},
        {},
        {},
        ROWS["fanuc"],
    )


def solved(m: Machine) -> ToolCentre:
    centre = tool_centre(m)
    assert centre is not None
    assert not centre.refusal, centre.refusal
    return centre


def rotary_solutions(centre: ToolCentre, direction: ArrayLike) -> list[Array]:
    """A B C [deg] within +-180 that point the tool along (3,): two, one or none."""
    axes = centre.rotary
    assert axes is not None
    wanted = centre.frame @ np.asarray(direction, np.float64)
    both, apart = axes.solutions(wanted[None, :] / np.linalg.norm(wanted))
    found = []
    for solution in both[0] if apart[0] > 0.0 else both[0, :1]:
        if np.isfinite(solution).all():
            found.append(np.zeros(3))
            found[-1][["ABC".index(joint.name) for joint in axes.joints]] = solution
    return found


HEAD_SLIDES = {"X": (1, 0, 0), "Y": (0, 1, 0), "Z": (0, 0, 1)}
TABLE_SLIDES = {"X": (-1, 0, 0), "Y": (0, -1, 0), "Z": (0, 0, 1)}
POINTS = {"A": (3, -6, 7), "B": (17, 2, 41), "C": (5, -7, 11)}
ISO_AC = {**TABLE_SLIDES, "A": (-1, 0, 0), "C": (0, 0, -1)}
TYPES = {
    "AC table, ISO": ("YXAC", "Z", ISO_AC),
    "AC table, both turned round": ("YXAC", "Z", {**TABLE_SLIDES, "A": (1, 0, 0), "C": (0, 0, 1)}),
    "BC table, ISO": ("XBC", "YZ", {**HEAD_SLIDES, "X": (-1, 0, 0), "B": (0, -1, 0),
                                    "C": (0, 0, -1)}),
    "CB head": ("", "XZYCB", {**HEAD_SLIDES, "C": (0, 0, 1), "B": (0, 1, 0)}),
    "B head, C table": ("XC", "YZB", {**HEAD_SLIDES, "X": (-1, 0, 0), "B": (0, 1, 0),
                                      "C": (0, 0, -1)}),
    "nutating table": ("YXBC", "Z", {**TABLE_SLIDES, "B": [-x for x in SKEW], "C": (0, 0, -1)}),
    "nutating head": ("", "XYZCB", {**HEAD_SLIDES, "C": (0, 0, 1), "B": SKEW}),
    "nutating head, C table": ("XC", "YZB", {**HEAD_SLIDES, "X": (-1, 0, 0), "C": (0, 0, -1),
                                             "B": SKEW}),
    "A table alone": ("XA", "YZ", {**HEAD_SLIDES, "X": (-1, 0, 0), "A": (-1, 0, 0)}),
    "slide on the table": ("AX", "YZ", {**HEAD_SLIDES, "X": (-1, 0, 0), "A": (-1, 0, 0)}),
    "quill in the head": ("", "XYBZ", {**HEAD_SLIDES, "B": (0, 1, 0)}),
    "quill in the head, C table": ("YC", "XBZ", {**HEAD_SLIDES, "Y": (0, -1, 0), "B": (0, 1, 0),
                                                 "C": (0, 0, -1)}),
    "both between the slides": ("", "XAYBZ", {**HEAD_SLIDES, "A": (1, 0, 0), "B": (0, 1, 0)}),
}  # fmt: skip
"""Type -> branches of the work and the tool, and the directions of the joints."""


def random_machine(rng: np.random.Generator) -> Machine:
    """Three slides and one or two rotary joints in any order on any branch, oblique axes."""
    while True:
        letters = rng.permutation(list("XYZ" + rng.choice(["AC", "AB", "BC", "A", "C"])))
        cut = rng.integers(0, len(letters) + 1)
        axes = {letter: rng.normal(size=3) for letter in letters}
        points = {letter: rng.uniform(-300, 300, 3) for letter in letters}
        m = machine("".join(letters[:cut]), "".join(letters[cut:]), axes, points)
        centre = tool_centre(m)
        if centre and not centre.refusal and abs(np.linalg.det(centre.frame)) > 0.1:
            return m


def tip_position(machine: Machine, q: ArrayLike, tool_length: float) -> Array:
    """Tool tip in world coordinates, (..., 3) [mm].

    Args:
        machine: a machine with a tool mount.
        q: joint positions in joint order, shape (..., nj) [mm or deg].
        tool_length: gauge point to tip [mm].
    """
    assert machine.tool is not None
    tip = machine.tool.gauge_point - tool_length * machine.tool.axis
    pose = world_from_link(machine, q)[machine.tool.link]
    return np.asarray(pose[..., :3, :3] @ tip + pose[..., :3, 3])
