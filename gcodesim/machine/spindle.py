"""The spindle: which bodies the machine carries while a given tool is in it."""

from __future__ import annotations

from gcodesim.machine.model import Body, Machine, Tool
from gcodesim.machine.tools import mount


def table_entry(machine: Machine, number: int | None) -> Tool | None:
    """The tool of the tools file in the spindle, None when the mounted tool stands for it."""
    if number is None or machine.tools is None:
        return None
    return machine.tools.get(number)


def tool_body(machine: Machine, number: int | None) -> Body | None:
    """The body of tool `number` (None: the tool at program start); None when it has no shape."""
    if machine.tool is None:
        return None
    entry = table_entry(machine, number)
    if entry is not None:
        parts = mount(entry.parts, machine.tool)
    elif number is None or machine.tool.for_all:
        parts = machine.tool.mounted
    else:
        parts = ()
    return Body(machine.tool.name, machine.tool.link, parts) if parts else None


def bodies_in_place(machine: Machine, number: int | None) -> dict[str, Body]:
    """All bodies by name, the tool in the spindle among them if it has a shape."""
    bodies = dict(machine.bodies)
    body = tool_body(machine, number)
    if body is not None:
        bodies[body.name] = body
    return bodies
