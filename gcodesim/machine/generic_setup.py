"""A setup to begin with, for any machine: a vise on its table, a part in the vise, a zero point."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gcodesim.errors import UsageError
from gcodesim.machine.model import Machine, ZeroPoint
from gcodesim.machine.placing import PlaceError, WorkFrames, extent

SETUP = """\
# What is clamped on the machine. Lengths mm, angles degrees; put in your own numbers and shapes.
# `gcodesim machine show` with --setup and this file prints where every body stands, in machine and
# in work coordinates; `gcodesim machine schema setup` lists every key.

machine: {machine}
{tools}
offsets:                     # axis positions of program zero, as the page of the control shows them;
  G54: {{X: {x:g}, Y: {y:g}, Z: {z:g}}}    # here: the middle of the top of the part
  # G55: {{X: 0, Y: 0, Z: 0}}          # as many as there are: G59.3, G54.1 P1, ...

bodies:
  vise:
    role: fixture            # fixture | part | stock
    on: table                # stands on the mount face of the table, X and Y from its middle
    parts:
      - {{name: base, box: {{size: [{w:g}, {d:g}, {h:g}], center: [0, 0, {hc:g}]}}}}
      - {{name: fixed_jaw, box: {{size: [{w:g}, {j:g}, {jh:g}], center: [0, {jy:g}, {jz:g}]}}}}
      - {{name: moving_jaw, box: {{size: [{w:g}, {j:g}, {jh:g}], center: [0, -{jy:g}, {jz:g}]}}}}
  part:                      # the finished part: the flute may touch it only where it cuts
    role: part
    on: vise.base            # or a body: vise; without `on`, the height is that of the shape
    box: {{size: [{pw:g}, {pd:g}, {ph:g}]}}
  # A mesh that CAM exported comes out right in the zero of CAM:
  # part: {{role: part, frame: G54, mesh: part.stl}}
  # blank: {{role: stock, frame: G54, box: {{size: [{pw:g}, {pd:g}, {sh:g}], center: [0, 0, -{sc:g}]}}}}
"""  # noqa: E501 (one line per shape)

SMALLEST_VISE = 20.0
"""Width of a vise on the smallest table [mm]."""


def setup_text(machine: Machine, name: str, tools: str | None = None) -> str:
    """A commented setup file.

    Args:
        machine: it is for.
        name: how the file names the machine.
        tools: how it names the file of the tools, if there is one.

    Raises:
        UsageError: the machine file does not say what carries the work, or that has no shape.
    """
    work = machine.work_link
    if work is None:
        text = "the machine file does not say what carries the work: write `work: {link: ...}`"
        raise UsageError(f"{machine.path}: {text}")
    frames = WorkFrames.of(replace(machine, offsets={1: ZeroPoint()}))
    try:
        table, zero, up = frames.table(work), frames.zero_point(1, work), frames.up(work)
    except PlaceError as error:
        raise UsageError(f"{machine.path}: {error}") from error
    low, high = extent(frames.mounting(work), table)
    w = max(round(float(np.sort(high - low)[1]) / 20.0) * 10.0, SMALLEST_VISE)
    h, jh, j, pd, ph = 0.25 * w, 0.2 * w, 0.12 * w, 0.3 * w, 0.3 * w
    # The zero of axis positions at 0 counts them: what the control shows at a point of the part.
    top = table[:3, 3] + (h + ph) * up
    x, y, z = (np.round(zero[:3, :3].T @ (top - zero[:3, 3]), 6) + 0.0).tolist()
    numbers = {
        "w": w, "d": 0.6 * w, "h": h, "hc": h / 2.0, "j": j, "jh": jh, "jz": h + jh / 2.0,
        "jy": (pd + j) / 2.0, "pw": 0.5 * w, "pd": pd, "ph": ph, "sh": ph + 1, "sc": ph / 2 - 0.5,
    }  # fmt: skip
    line = f"tools: {tools}" if tools else "# tools: tools.yaml      # or a library: shop.json"
    return SETUP.format(machine=name, tools=line, x=x, y=y, z=z, **numbers)
