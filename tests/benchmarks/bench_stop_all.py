"""Every contact against no contact at all: `python tests/benchmarks/bench_stop_all.py`.

The same program is searched twice in one run: with the tool deep in the table (`--stop all`), and
with the table moved away. Goal: at most 10 times the second, plus 1 ms per contact listed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from gcodesim.checking.flow import check_once
from gcodesim.checking.options import Options
from gcodesim.machine.loading import load_machine
from gcodesim.machine.model import Body, Machine

MACHINE = Path(__file__).parents[2] / "machines" / "table_tilt.yaml"
HEAD = "G21 G90 G17 G54\nT1 M6\nS1000 M3\n"
TIMES, PER_CONTACT_S = 10.0, 1e-3


def deep_blocks() -> str:
    """200 straight blocks with the cutter deep in the table."""
    rows = [f"G1 X{30 * math.cos(i * 0.7):.3f} Y{30 * math.sin(i * 0.7):.3f}" for i in range(200)]
    return f"{HEAD}G1 X0 Y0 Z-60 F2000\n" + "\n".join(rows) + "\nM30\n"


def in_and_out() -> str:
    """200 pecks into the table: as many contacts."""
    rows = [f"G0 X{i % 20} Y{i // 20}\nG1 Z-5 F5000\nG0 Z30" for i in range(200)]
    return f"{HEAD}G0 X0 Y0 Z30\n" + "\n".join(rows) + "\nM30\n"


def changed(machine: Machine, change: Callable[[Body], Body]) -> Machine:
    """The machine with every body changed."""
    bodies = {name: change(body) for name, body in machine.bodies.items()}
    return replace(machine, bodies=bodies)


def finer(times: int) -> Callable[[Body], Body]:
    """Every triangle cut into four, again and again."""
    import trimesh

    def cut(body: Body) -> Body:
        parts = []
        for part in body.parts:
            mesh = trimesh.Trimesh(*trimesh.triangles.to_kwargs(part.triangles).values())
            for _ in range(times):
                mesh = mesh.subdivide()
            parts.append(replace(part, triangles=mesh.triangles.copy()))
        return replace(body, parts=tuple(parts))

    return cut


def table_away(body: Body) -> Body:
    """The table and what tilts it 600 mm lower."""
    if body.link not in ("A", "C"):
        return body
    parts = tuple(replace(p, triangles=p.triangles - [0.0, 0.0, 600.0]) for p in body.parts)
    return replace(body, parts=parts)


def search_s(text: str, machine: Machine, stop_all: bool) -> tuple[float, int]:
    """Seconds of the search, and contacts listed."""
    result = check_once(text, "part.nc", machine, Options(stop_all=stop_all))
    return result.timing_s["search"], len(result.contacts)


def main() -> None:
    """Print one line per program and machine."""
    plain = load_machine(MACHINE)
    for times in (0, 3):
        machine = changed(plain, finer(times)) if times else plain
        count = sum(len(p.triangles) for b in machine.bodies.values() for p in b.parts)
        apart = changed(machine, table_away)
        for text in (deep_blocks, in_and_out):
            search_s(text(), machine, True)
            free, listed = search_s(text(), apart, True)
            every, contacts = search_s(text(), machine, True)
            limit = TIMES * free + PER_CONTACT_S * contacts
            print(
                f"{text.__name__:12} {count:6} triangles: {every:6.2f} s for {contacts:3} "
                f"contacts, {free:6.2f} s with the table away ({listed}); "
                f"{every / limit:5.2f} of the goal"
            )


if __name__ == "__main__":
    main()
