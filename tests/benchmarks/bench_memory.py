"""Memory of one process that checks many different machines: flat after the first hundred checks.

Every second machine has a body from a mesh file of its own, binary STL or OBJ.
Every machine is checked twice, the second time after all others. Run from the repository root:
python tests/benchmarks/bench_memory.py [--machines N] [--json FILE]; ends with 1 where it grows.
"""

from __future__ import annotations

import argparse
import json
import platform
import random
import re
import resource
import sys
import tempfile
from pathlib import Path

import numpy as np
import trimesh

from gcodesim.api import check
from gcodesim.machine.generic import MACHINES, machine_text

WARM = 100
"""Checks until everything is loaded that stays."""

MOST_MB_PER_1000 = 5.0
"""Growth that counts as flat [MB per 1,000 checks]: an allocator scatters so much."""

PROGRAM = """G21 G90 G17 G54 G0 T1 M6
S1000 M3
G43 H1 Z{z}
G1 X{x} Y-20 F1000
G2 X{x} Y20 I0 J20
G0 Z100
M30
"""


def machine_of(number: int) -> str:
    """Return a machine unlike any other: its own name, sizes, travels and rates."""
    rng, kinds = random.Random(number), list(MACHINES)
    text = machine_text(kinds[number % len(kinds)], f"machine_{number}")

    def other(found: re.Match[str]) -> str:
        return f"{found[1]}{float(found[2]) * rng.uniform(0.95, 1.05):.3f}"

    text = re.sub(r"((?:radius|height|rapid): )([0-9.]+)", other, text)
    if not number % 2:
        return text
    return re.sub(r"(?m)^(links:.*)$", rf"\1\n  post: {{mesh: {mesh_name(number)}}}", text, count=1)


def mesh_name(number: int) -> str:
    """Return the file of the body that stands beside a machine."""
    return "post.stl" if number % 4 == 1 else "post.obj"


def mesh_of(number: int) -> bytes:
    """Return a mesh unlike any other: a ball of 1,280 triangles."""
    ball = trimesh.creation.icosphere(3, radius=random.Random(number).uniform(50.0, 100.0))
    ball.apply_translation([700.0, -400.0, 0.0])
    content = ball.export(file_type=mesh_name(number).rpartition(".")[2])
    return content if isinstance(content, bytes) else content.encode()


def resident_mb() -> float:
    """Return the memory that this process holds now [MB]."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 1e6


def measure(machines: int, report: bool = True) -> list[float]:
    """Check every machine twice; return the memory after each check [MB]."""
    held = []
    with tempfile.TemporaryDirectory() as folder:
        for number in [*range(machines)] * 2:
            model = Path(folder) / "machine.yaml"
            program = Path(folder) / "program.nc"
            model.write_text(machine_of(number))
            (Path(folder) / mesh_name(number)).write_bytes(mesh_of(number))
            program.write_text(PROGRAM.format(x=10 + number % 50, z=60 + number % 17))
            check(program, model)
            held.append(resident_mb())
            if report and len(held) % 100 == 0:
                print(f"{len(held):6d} checks {held[-1]:8.1f} MB", flush=True)
    return held


def growth(held: list[float]) -> float:
    """Return the slope of a line through what was held after the warm-up [MB per 1,000 checks]."""
    late = held[WARM:]
    return float(np.polyfit(np.arange(len(late)), late, 1)[0]) * 1000.0


def main() -> int:
    """Run as told on the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--machines", type=int, default=1000)
    parser.add_argument("--json")
    given = parser.parse_args()
    held = measure(given.machines)
    slope = growth(held)
    print(f"{len(held)} checks: {held[WARM]:.1f} to {held[-1]:.1f} MB, {slope:+.2f} MB per 1,000")
    if given.json:
        figures = {
            "benchmark": "memory",
            "machine": platform.processor() or platform.machine(),
            "checks": len(held),
            "held_mb": [round(value, 1) for value in held[99::100]],
            "growth_mb_per_1000": round(slope, 2),
        }
        Path(given.json).write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")
    return int(slope > MOST_MB_PER_1000)


if __name__ == "__main__":
    sys.exit(main())
