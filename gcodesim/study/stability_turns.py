"""Rotary axes at their extremes: many turns, wraps, poles, and half a turn within one sample."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gcodesim.collision.detector import Task, detect
from gcodesim.collision.search.span_search import Aims
from gcodesim.constants import DEFAULT_PERIOD_PS, TCP_DEVIATION_MM
from gcodesim.machine.kinematics import sincosd
from gcodesim.machine.tool_centre import ToolCentre, tool_centre
from gcodesim.motion.path import Path
from gcodesim.nc.program import AXES
from gcodesim.study.exact_motion import exact_sincosd
from gcodesim.study.scenes import flip_within_a_sample
from gcodesim.study.stability_case import Case
from gcodesim.study.stability_motion import DT, SEED, free_machine, path_of

Floats = NDArray[np.float64]
LEVER = 300.0
"""Distance of a point from the axis it turns about [mm]."""


def right_angles(quick: bool) -> Iterator[Case]:
    """Sines and cosines of right angles, and of any angle after a million turns."""
    quarters = np.concatenate([np.arange(-9, 10), 400_001 + np.arange(-8, 9), [4 * 10**12 + 3]])
    expected = np.array([[(0, 1), (1, 0), (0, -1), (-1, 0)][q % 4] for q in quarters]).T
    ours, naive = (np.abs(found - expected).max() for found in _both(90.0 * quarters))
    yield Case(
        "turns", "multiples of 90 deg, 36000090 too", "sine and cosine", "radians",
        float(naive), float(ours), 0.0, "",
    )  # fmt: skip
    rng = np.random.default_rng([SEED, 8])
    degrees = rng.uniform(0, 360, 50 if quick else 1000) + 360e6
    exact = np.array([[float(x) for x in exact_sincosd(float(d))] for d in degrees]).T
    ours, naive = (LEVER * np.abs(found - exact).max() for found in _both(degrees))
    yield Case(
        "turns", "1e6 turns and a part", f"place {LEVER:.0f} mm from the axis", "radians",
        float(naive), float(ours), 2e-13, "mm",
    )  # fmt: skip


def _both(degrees: Floats) -> tuple[Floats, Floats]:
    """Sine and cosine, (2, n): ours and by radians."""
    radians = np.radians(degrees)
    return np.stack(sincosd(degrees)), np.stack([np.sin(radians), np.cos(radians)])


def wraps(quick: bool) -> Iterator[Case]:
    """C from 359.9 to 0.1, read both ways: neither is right for every control."""
    machine = free_machine()
    readings = {"none": (-359.8, "always the short way"), "shortest": (0.2, "as written")}
    for wrap, (way, usual) in readings.items():
        joints = tuple(replace(j, wrap=wrap if j.name == "C" else j.wrap) for j in machine.joints)
        path, _ = path_of("G0 C359.9\nC0.1", replace(machine, joints=joints))
        moved = (path.q1 - path.q0)[-1, path.joints.index("C")]
        other = 0.2 if wrap == "none" else -359.8
        yield Case(
            "turns", f"C359.9 to C0.1, wrap: {wrap}", "way of C", usual,
            abs(other - way), abs(float(moved) - way), 1e-11, "deg",
        )  # fmt: skip


# --- tool centre point control --------------------------------------------------------------------


def pole(quick: bool) -> Iterator[Case]:
    """The tool axis passes the pole at 1e-5 deg in 0.2 s: C turns half round in one sample."""
    tilt, azimuth = np.radians([10.0, 179.9999])
    free = free_machine()
    joints = (replace(j, lower=-120.0, upper=0.0) if j.name == "A" else j for j in free.joints)
    machine = replace(free, joints=tuple(joints)).with_readings(orientation="great_circle")
    ends = np.array([_leaning(tilt, 0.0), _leaning(tilt, float(azimuth))])
    words = ["I{:.15f} J{:.15f} K{:.15f}".format(*end) for end in ends]
    path, _ = path_of(
        f"T1 M6\nG43.5 H1\nG0 X0 Y0 Z50. {words[0]}\nG1 Y50. {words[1]} F15000.", machine
    )
    times = np.arange(0, path.duration_ps, DEFAULT_PERIOD_PS)
    turned = np.abs(np.diff(path.positions(times)[:, path.joints.index("C")])).max()
    angle = np.arccos(ends[0] @ ends[1])
    share = np.arange(0.0, 1.0, DT / 0.2)[:, None]
    seen = np.sin((1 - share) * angle) * ends[0] + np.sin(share * angle) * ends[1]
    azimuths = np.degrees(np.arctan2(seen[:, 0], -seen[:, 1]))
    jumps = np.abs((np.diff(azimuths) + 180.0) % 360.0 - 180.0).max()
    rapid = next(j.rapid for j in free.joints if j.name == "C") * DT
    case, usual = "tool axis 1e-5 deg past the pole", "inverse at every sample"
    yield Case(
        "TCP", case, "turn of C in a sample", usual, float(jumps), float(turned),
        rapid * (1 + 1e-6), "deg",
    )  # fmt: skip
    moves = [2 * LEVER * np.sin(np.radians(min(x, 180.0)) / 2) for x in (jumps, turned)]
    yield Case(
        "TCP", case, f"move in a sample, {LEVER:.0f} mm from C", usual, float(moves[0]),
        float(moves[1]), LEVER * np.radians(rapid) * (1 + 1e-6), "mm",
    )  # fmt: skip


def _leaning(tilt: float, azimuth: float) -> Floats:
    sine = np.sin(tilt)
    return np.array([sine * np.sin(azimuth), -sine * np.cos(azimuth), np.cos(tilt)])


def tip_paths(quick: bool) -> Iterator[Case]:
    """A straight tip while A tilts and C turns half round."""
    machine = free_machine()
    path, _ = path_of(
        "T1 M6\nG43.4 H1\nG0 X40. Y-30. Z20. A0 C0\nG1 X-60. Y50. Z40. A-40. C170. F3000.", machine
    )
    centre = tool_centre(machine)
    assert centre is not None
    pieces = np.flatnonzero(path.line == path.line[-1])
    s = np.linspace(0.0, 1.0, 9)
    q = path.positions_on(np.repeat(pieces, len(s)), np.tile(s, len(pieces)))
    begin, end = path.q0[pieces[0]], path.q1[pieces[-1]]
    straight = begin + np.linspace(0.0, 1.0, 1001)[:, None] * (end - begin)
    naive, ours = (_off_line(centre, path, joints) for joints in (straight, q))
    yield Case(
        "TCP", "A-40 C170 in one block", "tip off its line", "joints straight to the end",
        naive, ours, TCP_DEVIATION_MM, "mm",
    )  # fmt: skip


def _off_line(centre: ToolCentre, path: Path, joints: Floats) -> float:
    """Largest distance [mm] of the tip from the line between its first and last place."""
    axes = np.zeros((len(joints), 6))
    axes[:, [AXES.index(name) for name in path.joints]] = joints
    tips = centre.tips(axes, np.array([0.0, 0.0, 160.0]))
    along = (tips[-1] - tips[0]) / np.linalg.norm(tips[-1] - tips[0])
    return float(np.linalg.norm(np.cross(tips - tips[0], along), axis=1).max())


def flip(quick: bool) -> Iterator[Case]:
    """Half a turn between two samples, a block passing a pin: a pole without a rate limit."""
    scene = flip_within_a_sample()
    missed = []
    for between in (False, True):
        aims = Aims(between=between)
        task = Task(
            scene.path, scene.machine, DEFAULT_PERIOD_PS, "cpu", "search", aims, lambda done: None
        )
        missed.append(float(detect(task).contact is None))
    yield Case(
        "TCP", "C turns 180 deg within one sample", "contacts missed", "samples alone",
        missed[0], missed[1], 0.0, "contacts",
    )  # fmt: skip


TURNS = (right_angles, wraps, pole, tip_paths, flip)
