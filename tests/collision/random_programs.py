"""Random small machines with random rough programs, and the search's answer under any setting."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from unittest.mock import patch

import numpy as np
import trimesh
from collision.scenes import LAWS, random_joints
from collision.scenes import unit as random_unit
from motion.programs import PLANES, program

from gcodesim.collision.detector import Detection, Task, detect
from gcodesim.collision.search import search
from gcodesim.collision.search.span_search import Aims
from gcodesim.machine.model import Joint, Machine, Part, Tool, ToolMount
from gcodesim.motion.path import Path
from gcodesim.motion.planner import plan
from gcodesim.nc.program import FeedMode, Kind
from gcodesim.study.scenes import Array, box, joint, machine, polygon, prism, turned

PERIOD_PS = 1_000_000_000
KINDS = ("table", "head", "mixed", "any")
START = (250.0, 250.0, 250.0, 0.0, 0.0, 0.0)
"""Machine position far from all contact at which programs begin [mm, deg]."""

FARTHEST = 150.0
"""Distance [mm] by which the tool is moved away at most."""


@dataclass(frozen=True)
class Trial:
    """A machine, the path of a random program on it, and the seed that made both."""

    seed: int
    machine: Machine
    path: Path
    period_ps: int = PERIOD_PS


@dataclass(frozen=True)
class Setup:
    """How a search is cut up; nothing of it may change an answer."""

    level: int = search.LEVEL
    chunk: int = search.LAST_CHUNK
    batch: int = search.BATCH
    threads: int = 1


@contextmanager
def cut_up(setup: Setup) -> Iterator[None]:
    """Search with other windows, chunks, batches and threads."""
    with (
        patch.object(search, "LEVEL", setup.level),
        patch.object(search, "FIRST_CHUNK", min(search.FIRST_CHUNK, setup.chunk)),
        patch.object(search, "LAST_CHUNK", setup.chunk),
        patch.object(search, "BATCH", setup.batch),
        patch.object(search.os, "cpu_count", lambda: setup.threads),
    ):
        yield


def run(
    trial: Trial,
    method: str = "search",
    between: bool = False,
    setup: Setup | None = None,
    device: str = "cpu",
) -> Detection:
    """Check a trial."""
    task = Task(
        path=trial.path,
        machine=trial.machine,
        period_ps=trial.period_ps,
        device=device,
        method=method,
        aims=Aims(between=between),
        progress=lambda done: None,
    )
    with cut_up(setup or Setup()):
        return detect(task)


Answer = tuple[int, str, tuple[str, str], tuple[int, int] | None, int, bool, float]


def answer(found: Detection) -> Answer | None:
    """All that must not depend on how the search is cut up."""
    c = found.contact
    if c is None:
        return None
    return c.sample, c.pair.name, c.parts, c.triangles, c.time_ps, c.between, c.distance


# --- machines -------------------------------------------------------------------------------------


def random_trial(seed: int, away: float | None = None) -> Trial:
    """A machine of one of the KINDS and a program on it; `away` moves the tool off the work [mm].

    Without `away` it is random.
    """
    rng = np.random.default_rng([20261121, seed])
    kind = KINDS[seed % len(KINDS)]
    joints, tool_link = _joints(rng, kind)
    m = _machine(rng, joints, tool_link, rng.uniform(0, 100) if away is None else away)
    rows = random_program(rng, rng.uniform(5, 60))
    path, _ = plan(program(rows, start=START), m)
    if rng.random() < 0.3:
        path.law[:] = np.resize(rng.permutation(np.array(LAWS)), path.law.shape)
    return Trial(seed, m, path, int(rng.choice([PERIOD_PS, PERIOD_PS // 3, 7 * PERIOD_PS // 2])))


def _joints(rng: np.random.Generator, kind: str) -> tuple[list[Joint], str]:
    """Joints, and the link that carries the tool."""
    if kind == "any":
        joints = random_joints(rng, 5, reach=30.0)
        return joints, joints[-1].child
    chains = {
        "table": ["YXAC", "Z"],
        "head": ["X", "YZCA"],
        "mixed": ["YC", "XZB"],
    }[kind]
    tilt = rng.choice([0.0, 0.3])
    joints = []
    for chain in chains:
        parent = "bed"
        for name in chain:
            axis = np.eye(3)["XYZABC".index(name) % 3] + tilt * rng.uniform(-1, 1, 3)
            point = rng.uniform(-20, 20, 3)
            joints.append(joint(name, axis, parent, f"link {name}", point))
            parent = f"link {name}"
    return joints, parent


def _machine(
    rng: np.random.Generator, joints: Sequence[Joint], tool_link: str, away: float
) -> Machine:
    """Bodies around the origin on some links; tools 1 and 2, as long as different."""
    direction = random_unit(rng)
    links = ["bed", *(j.child for j in joints)]
    others = [link for link in links if link != tool_link]
    carriers = [str(link) for link in rng.permutation(others)[: rng.integers(1, 4)]]
    shapes: dict[str, Array | dict[str, Array]] = {
        link: _mesh(rng, rng.uniform(8, 20), rng.uniform(-15, 15, 3)) for link in carriers
    }
    pairs = [(*sorted((link, "tool")),) for link in carriers]
    m = machine(joints, shapes, sorted(pairs))  # type: ignore[arg-type]
    tools = {n: _tool(rng, n, direction * away, 8.0 * n) for n in (1, 2)}
    mount = ToolMount("tool", tool_link, np.zeros(3), np.array([0, 0, 1.0]), tools[1].parts, 30.0)
    return replace(m, tool=mount, tools=tools)


def _mesh(rng: np.random.Generator, size: float, center: Array) -> Array:
    made = [
        lambda: trimesh.creation.icosphere(2, radius=1.0),
        lambda: trimesh.creation.box([1.5, 1.0, 0.7]),
        lambda: trimesh.creation.torus(1.0, 0.3, major_sections=16, minor_sections=8),
        lambda: trimesh.creation.box([1.5, 1.5, 0.001]),
    ][rng.integers(4)]()
    triangles = rng.permutation(np.array(made.triangles)) * size
    return turned(triangles, random_unit(rng), rng.uniform(0, np.pi)) + center


def _tool(rng: np.random.Generator, number: int, shift: Array, radius: float) -> Tool:
    sides = int(rng.integers(3, 16))
    flute = prism(polygon(sides, radius, [0, 0], rng.uniform(0, 1)), 0, 30) + shift
    parts = (Part("flute", flute, role="flute"),)
    if number == 2:
        parts += (Part("holder", box([24, 24, 12], [0, 0, 36]) + shift, role="holder"),)
    return Tool(number, f"tool {number}", 30.0, 2 * radius, (0.0,) * 6, parts)


# --- programs -------------------------------------------------------------------------------------

Row = dict[str, object]


def random_program(rng: np.random.Generator, travel: float, phrases: int = 9) -> list[Row]:
    """Commands of some phrases around the origin, one of which changes the tool."""
    at = _somewhere(rng, travel)
    rows: list[Row] = [{"kind": Kind.RAPID, "to": at}]
    for k in range(phrases):
        if k == phrases // 2:
            rows.append({"kind": Kind.TOOL, "aux": 2})
        made = PHRASES[rng.integers(len(PHRASES))](rng, at, travel)
        rows += made
        moves = [row for row in made if "to" in row]
        at = np.array(moves[-1]["to"]) if moves else at
    return rows


def _somewhere(rng: np.random.Generator, travel: float) -> Array:
    turns = 180.0 if rng.random() < 0.8 else 1080.0
    return rng.uniform(-1, 1, 6) * [travel, travel, travel, turns, turns, turns]


def _rapid(rng: np.random.Generator, at: Array, travel: float) -> list[Row]:
    return [{"kind": Kind.RAPID, "to": _somewhere(rng, travel)}]


def _feed(rng: np.random.Generator, at: Array, travel: float) -> list[Row]:
    """One line, from fast to thousands of samples long."""
    f = 60 * 10 ** rng.uniform(1.3, 3)
    return [{"kind": Kind.FEED, "to": _somewhere(rng, travel), "f": f}]


def _in_time(rng: np.random.Generator, at: Array, travel: float) -> list[Row]:
    """G93: five axes in a given time."""
    f = 60 / 10 ** rng.uniform(-2, 0.3)
    to = at + 0.2 * (_somewhere(rng, travel) - at)
    return [{"kind": Kind.FEED, "to": to, "f": f, "mode": FeedMode.INVERSE_TIME}]


def _rough(rng: np.random.Generator, at: Array, travel: float) -> list[Row]:
    """Many pieces far shorter than a sample, jittering on their way somewhere."""
    count = int(rng.integers(5, 150))
    way = 10 ** rng.uniform(-4, -1) * (_somewhere(rng, travel) - at)
    ends = np.linspace(at, at + way, count + 1)[1:]
    ends += rng.normal(size=ends.shape) * rng.choice([0.0, 0.02])
    return [{"kind": Kind.FEED, "to": end, "f": 60 * 300.0} for end in ends]


def _stand(rng: np.random.Generator, at: Array, travel: float) -> list[Row]:
    return [{"kind": Kind.DWELL, "f": 10 ** rng.uniform(-5, -1)}]


def _arc(rng: np.random.Generator, at: Array, travel: float) -> list[Row]:
    """An arc, helix or spiral in one of the three planes or an oblique one."""
    axis = list(PLANES.values())[rng.integers(3)]
    normal = np.array(axis, np.float64) if rng.random() < 0.7 else random_unit(rng)
    side = np.cross(normal, random_unit(rng))
    side /= np.linalg.norm(side)
    radius = travel * 10 ** rng.uniform(-2, 0)
    center = at[:3] - radius * side
    angle = rng.choice([rng.uniform(0.1, 6.2), 2 * np.pi])
    arm = np.cos(angle) * side + np.sin(angle) * np.cross(normal, side)
    end = center + radius * rng.choice([1.0, 1.0, 1.2]) * arm
    end = end + normal * rng.choice([0.0, rng.uniform(-1, 1) * travel])
    turns = int(rng.choice([-1, 1, 1, 2, -4]))
    to = np.concatenate([end, at[3:] + rng.choice([0.0, 1.0]) * rng.uniform(-40, 40, 3)])
    f = 60 * 10 ** rng.uniform(1.5, 3)
    return [
        {"kind": Kind.ARC, "to": to, "center": center, "normal": normal, "turns": turns, "f": f}
    ]


PHRASES = (_rapid, _feed, _in_time, _rough, _rough, _stand, _arc, _arc)


def marginal_trial(seed: int, margin: float, halvings: int = 14) -> Trial:
    """The same with the tool just so far away that nothing collides, less `margin` [mm].

    A small positive margin makes a grazing contact, a negative one a near miss. The trial collides
    or not wherever the tool is, when something else does or nothing is in reach.
    """
    low, high = 0.0, FARTHEST
    for _ in range(halvings):
        middle = (low + high) / 2
        hit = run(random_trial(seed, middle), "exhaustive").contact
        low, high = (middle, high) if hit else (low, middle)
    return random_trial(seed, high - margin)
