"""Joints that no program moves: those not named X Y Z A B C stand where `start` puts them.

For whatever asks how X Y Z A B C move the tool, such a joint is a part of the frame: the joints
that it carries are moved with it, and it is left out.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gcodesim.machine.kinematics import poses_of, transform
from gcodesim.machine.model import Joint, Machine, ToolMount
from gcodesim.nc.program import AXES

Array = NDArray[np.float64]


def standing_joints(machine: Machine) -> tuple[Joint, ...]:
    """The joints that no word of a program moves."""
    return tuple(joint for joint in machine.joints if joint.name not in AXES)


def standing_lines(joints: tuple[Joint, ...], start: dict[str, float]) -> tuple[str, ...]:
    """A line of the report for each joint that no word of a program moves."""
    return tuple(
        f"{joint.name}: programs move {' '.join(AXES)} only; it stands at {start[joint.name]:g} "
        f"{'deg' if joint.rotary else 'mm'} (`start`)"
        for joint in joints
        if joint.name not in AXES
    )


def joint_positions(machine: Machine, axes: Array) -> Array:
    """Positions of all joints (n, joints) at X Y Z A B C (n, 6) [mm, deg]."""
    columns = [AXES.find(name) if len(name) == 1 else -1 for name in machine.axes]
    at = axes[:, columns]
    for column, name in enumerate(machine.axes):
        if columns[column] < 0:
            at[:, column] = machine.start[name]
    return np.asarray(at)


def commanded(machine: Machine) -> Machine:
    """The machine of the axes that programs move, with the others standing at `start`."""
    still = standing_joints(machine)
    if not still:
        return machine
    position = [
        0.0 if joint.name in AXES else machine.start[joint.name] for joint in machine.joints
    ]
    poses = poses_of(machine.links, machine.joints, position)
    carried_by = {joint.child: joint.parent for joint in still}

    def moving(link: str) -> str:
        while link in carried_by:
            link = carried_by[link]
        return link

    joints = tuple(
        replace(
            joint,
            parent=moving(joint.parent),
            axis=poses[joint.parent][:3, :3] @ joint.axis,
            point=transform(poses[joint.parent], joint.point),
        )
        for joint in machine.joints
        if joint not in still
    )
    tool = machine.tool and _moved(
        machine.tool, poses[machine.tool.link], moving(machine.tool.link)
    )
    work = machine.work_link and moving(machine.work_link)
    return replace(machine, joints=joints, tool=tool, work_link=work)


def _moved(tool: ToolMount, pose: Array, link: str) -> ToolMount:
    gauge = transform(pose, tool.gauge_point)
    return replace(tool, link=link, gauge_point=gauge, axis=pose[:3, :3] @ tool.axis)
