"""What the control of a machine knows before a program starts, as plain data for nc/."""

from __future__ import annotations

from collections.abc import Mapping

from gcodesim.machine.model import Machine, Tool, ZeroPoint
from gcodesim.machine.standing import standing_joints
from gcodesim.machine.tool_centre import tool_centre
from gcodesim.machine.tools import read_tools
from gcodesim.nc.control.readings import choose_readings
from gcodesim.nc.control.supply import Control, ToolEntry
from gcodesim.nc.program import AXES


def control_for(
    machine: Machine,
    dialect: str | None,
    feed: float | None,
    block_delete: bool,
    max_blocks: int | None = None,
) -> Control:
    """The control of `machine`.

    Args:
        machine: with setup and tools.
        dialect: replaces the dialect of the machine file; None: as that says, or the program.
        feed: feed until the first F word [mm/min].
        block_delete: blocks that begin with / are left out.
        max_blocks: interpretation ends after this many blocks; None = see Control.

    Raises:
        UsageError: the dialect is not known.
    """
    mount = machine.tool
    return Control(
        readings=choose_readings(dialect, machine.given) if dialect else machine.readings,
        given=machine.given if machine.is_dialect_told and not dialect else None,
        axes="".join(name for name in machine.axes if name in AXES),
        standing=tuple(joint.name for joint in standing_joints(machine)),
        start=machine.start,
        tools=_tool_table(machine.tools),
        tool_for_all=mount is not None and mount.for_all,
        mounted_length=mount.length if mount else 0.0,
        offsets=machine.offsets,
        reference=machine.reference,
        variables=machine.variables,
        feed=feed,
        unit=machine.unit,
        wrap={joint.name: joint.wrap for joint in machine.joints if joint.rotary},
        travel={joint.name: (joint.lower, joint.upper) for joint in machine.joints},
        block_delete=block_delete,
        max_blocks=max_blocks,
        kinematics=tool_centre(machine),
    )


def bare_control(
    tools: str | None,
    dialect: str | None,
    feed: float | None,
    block_delete: bool,
    max_blocks: int | None = None,
) -> Control:
    """A control with every offset and reference at zero, for reading a program without a machine.

    Raises:
        UsageError: the dialect is not known, or the tools file is missing.
        ModelError: the tools file is wrong.
    """
    return Control(
        readings=choose_readings(dialect or "fanuc"),
        tools=_tool_table(read_tools(tools)) if tools else None,
        offsets={number: ZeroPoint() for number in range(1, 10)},
        feed=feed,
        unit="mm",
        block_delete=block_delete,
        max_blocks=max_blocks,
    )


def _tool_table(tools: Mapping[int, Tool] | None) -> dict[int, ToolEntry] | None:
    if tools is None:
        return None
    return {
        number: ToolEntry(number, tool.offset, tool.diameter, tool.name)
        for number, tool in tools.items()
    }
