"""Canonical programs written down directly, and a machine of plain axes to plan them on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gcodesim.machine.model import Machine
from gcodesim.motion.path import Path
from gcodesim.motion.planner import plan
from gcodesim.nc.program import ARC_DTYPE, CanonicalProgram, FeedMode, Kind
from gcodesim.study.scenes import joint, machine

RAPID_MM_S, RAPID_DEG_S = 500.0, 100.0
PLANES = {"G17": (0, 0, 1), "G18": (0, 1, 0), "G19": (1, 0, 0)}


def axes_machine(**travel: tuple[float, float]) -> Machine:
    """X, Y, Z at 500 mm/s and A, C at 100 deg/s in one chain, without shapes."""
    joints, parent = [], "bed"
    for name, axis in zip("XYZAC", np.vstack([np.eye(3), np.eye(3)[[0, 2]]]), strict=True):
        rapid = RAPID_DEG_S if name in "AC" else RAPID_MM_S
        ends = travel.get(name, (-1e9, 1e9))
        joints.append(joint(name, axis, parent, f"link {name}", travel=ends, rapid=rapid))
        parent = f"link {name}"
    return machine(joints, {}, [])


def limited_machine(time: str, a: float = 5000.0, j: float = 5e4, **travel: Any) -> Machine:
    """The same with limits of acceleration and jerk: a and j of the slides, a fifth when rotary."""
    plain = axes_machine(**travel)
    joints = tuple(
        replace(q, max_acceleration=a / 5 if q.rotary else a, max_jerk=j / 5 if q.rotary else j)
        for q in plain.joints
    )
    return replace(plain, joints=joints, time=time)


def program(rows: Sequence[dict[str, Any]], start: ArrayLike = (0.0,) * 6) -> CanonicalProgram:
    """One row per command; `to` lacking at the end means: where it was. Lines count from 1."""
    n, position = len(rows), np.array(start, np.float64)
    to, arcs, aux = np.zeros((n, 6)), [], np.zeros(n, np.int32)
    for i, row in enumerate(rows):
        target = np.array(row.get("to", ()), np.float64)
        if row["kind"] <= Kind.ARC:
            position = np.concatenate([target, position[len(target) :]])
            to[i] = position
        elif row["kind"] == Kind.TOOL_OFFSET:
            to[i, : len(target)] = target
        aux[i] = row.get("aux", 0)
        if row["kind"] == Kind.ARC:
            aux[i] = len(arcs)
            arcs.append((row["center"], row.get("normal", (0, 0, 1)), row.get("turns", 1)))
    return CanonicalProgram(
        kind=np.array([row["kind"] for row in rows], np.uint8),
        line=np.arange(1, n + 1, dtype=np.int32),
        frame=np.array([row.get("frame", 0) for row in rows], np.uint8),
        to=to,
        f=np.array([row.get("f", 0.0) for row in rows], np.float64),
        feed_mode=np.array([row.get("mode", FeedMode.PER_MINUTE) for row in rows], np.uint8),
        speed=np.array([row.get("speed", 0.0) for row in rows], np.float32),
        aux=aux,
        arcs=np.array(arcs, ARC_DTYPE).reshape(-1),
        start=np.array(start, np.float64),
    )


def straight_program(to: NDArray[np.float64], feed: ArrayLike) -> CanonicalProgram:
    """Feeds [mm/min] from zero to every row of `to` (n, 6)."""
    n = len(to)
    return CanonicalProgram(
        kind=np.full(n, Kind.FEED, np.uint8),
        line=np.arange(1, n + 1, dtype=np.int32),
        frame=np.zeros(n, np.uint8),
        to=to,
        f=np.broadcast_to(np.asarray(feed, np.float64), n),
        feed_mode=np.full(n, FeedMode.PER_MINUTE, np.uint8),
        speed=np.zeros(n, np.float32),
        aux=np.zeros(n, np.int32),
        arcs=np.zeros(0, ARC_DTYPE),
        start=np.zeros(6),
    )


def planned(*rows: dict[str, Any], **travel: tuple[float, float]) -> Path:
    """The path of a program on `axes_machine`."""
    return plan(program(rows), axes_machine(**travel))[0]
