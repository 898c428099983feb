"""Machines with finer meshes, whose surfaces are the same: what more triangles cost."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gcodesim.machine.model import Body, Machine, Part

Floats = NDArray[np.float64]


def refine(triangles: Floats) -> Floats:
    """Every triangle cut into four at the midpoints of its edges, shape (4 n, 3, 3)."""
    a, b, c = triangles.swapaxes(0, 1)
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    cut = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.concatenate([np.stack(corners, axis=1) for corners in cut])


def with_parts(machine: Machine, change: Callable[[Floats], Floats]) -> Machine:
    """The machine with the triangles of every part changed."""

    def parts(given: tuple[Part, ...]) -> tuple[Part, ...]:
        return tuple(replace(part, triangles=change(part.triangles)) for part in given)

    bodies = {n: Body(b.name, b.link, parts(b.parts)) for n, b in machine.bodies.items()}
    tool = machine.tool and replace(machine.tool, mounted=parts(machine.tool.mounted))
    return replace(machine, bodies=bodies, tool=tool)


def refined(machine: Machine, times: int) -> Machine:
    """The machine with every triangle cut into four, `times` times over."""
    for _ in range(times):
        machine = with_parts(machine, refine)
    return machine
