"""The tool tip seen from the part, and back: any tree of three slides and one or two rotary joints.

All joints between the work and the tool form one chain, part first: a joint that carries the work
stands in it with its direction turned round. Seen from the part, the tip of a tool is then

    S_1(q_1) S_2(q_2) ... S_n(q_n) (gauge point - tool offset)

whatever the type of the machine: the joints before the branches cancel. With the rotary joints
given, the chain is affine in the slides: a 3x3 system.

The frame of the part has the directions of the slides and its origin in the gauge point, both at
the zero pose: as long as the rotary joints are at zero, a point is its own axis position. Slides
need not be square: docs/derivations/skew-slides.md.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gcodesim.constants import SINGULAR_VOLUME
from gcodesim.errors import OrientationError
from gcodesim.machine.kinematics import turned
from gcodesim.machine.model import Joint, Machine
from gcodesim.machine.orientation import RotaryAxes, columns_of
from gcodesim.machine.standing import commanded

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ChainJoint:
    """One joint of the chain: its direction seen from the part, and its column in X Y Z A B C."""

    joint: Joint
    column: int
    axis: Array

    def moved(self, points: Array, position: Array) -> Array:
        """Points (n, 3) after the joint has gone to `position` (n,) [mm or deg]."""
        if self.joint.rotary:
            return turned(points - self.joint.point, self.axis, position) + self.joint.point
        return np.asarray(points + position[:, None] * self.axis)


@dataclass(frozen=True)
class ToolCentre:
    """Kinematics between part and tool tip.

    Arrays batch: axes (n, 6) = X Y Z A B C [mm, deg], rotary (n, 3) = A B C [deg], offset (3,) or
    (n, 3) = tool offset [mm]. Joints that are not between work and tool are passed through.

    Attributes:
        chain: the joints from the part to the tool.
        slides: the steps from the first to the last slide.
        gauge: gauge point at the zero pose, world coordinates, shape (3,).
        frame: columns are the directions of X, Y, Z in world coordinates, shape (3, 3).
        rotary: the rotary joints of the chain.
        work_chain: rotary joints that carry the work, root first, with their own direction.
        refusal: why tool centre point control cannot run on this machine; empty when it can.
    """

    chain: tuple[ChainJoint, ...]
    slides: slice
    gauge: Array
    frame: Array
    rotary: RotaryAxes
    work_chain: tuple[ChainJoint, ...]
    refusal: str

    def tips(self, axes: ArrayLike, offset: ArrayLike) -> Array:
        """Tip in the frame of the part, (n, 3); zero for zero axes and offset."""
        self._require()
        q = np.atleast_2d(np.asarray(axes, np.float64))
        points = np.broadcast_to(self.tool_points(offset), (len(q), 3))
        return self._from_world(self._moved(self.chain, points, q))

    def axes_at(self, tips: ArrayLike, rotary: ArrayLike, offset: ArrayLike) -> Array:
        """Axis positions (n, 6) at which the tip is at `tips` (n, 3): the slides solved.

        Raises:
            OrientationError: the slides stand in one plane there.
        """
        self._require()
        axes = self._turned_only(rotary)
        target = self._to_world(np.atleast_2d(np.asarray(tips, np.float64)))
        for step in self.chain[: self.slides.start]:
            target = step.moved(target, -axes[:, step.column])
        turns = tuple(step for step in self.chain[self.slides.start :] if step.joint.rotary)
        tool = self._moved(turns, self.tool_points(offset), axes)
        axes[:, :3] = self._slid(target - tool, axes)
        return axes

    def axis_directions(self, vectors: ArrayLike, rotary: ArrayLike) -> Array:
        """How X Y Z move (n, 3) while the tip moves by `vectors` (n, 3) in the part."""
        self._require()
        axes = self._turned_only(rotary)
        target = np.atleast_2d(np.asarray(vectors, np.float64)) @ self.frame.T
        for step in self.chain[: self.slides.start]:
            target = turned(target, step.axis, -axes[:, step.column])
        return self._slid(target, axes)

    @property
    def between(self) -> tuple[ChainJoint, ...]:
        """The rotary joints between the slides: those turn the directions of other slides."""
        return tuple(step for step in self.chain[self.slides] if step.joint.rotary)

    @property
    def tilted(self) -> list[int]:
        """Columns of the slides whose directions those joints turn."""
        steps = self.chain[self.slides]
        first = next((i for i, step in enumerate(steps) if step.joint.rotary), len(steps))
        return [step.column for step in steps[first:] if not step.joint.rotary]

    def volumes(self, rotary: ArrayLike) -> Array:
        """Volume, 0 to 1, that the directions of the slides span at A B C (n, 3), shape (n,)."""
        self._require()
        axes = self._turned_only(rotary)
        a, b, c = self._slide_directions(axes)
        return np.broadcast_to(np.abs(np.sum(a * np.cross(b, c), axis=1)), (len(axes),))

    def _slid(self, way: Array, axes: Array) -> Array:
        """Positions X Y Z (n, 3) that move by `way` (n, 3), seen from the first slide."""
        return _solve(self._slide_directions(axes), way)

    def _slide_directions(self, axes: Array) -> list[Array]:
        """Directions of X, Y and Z seen from the first slide, each (n, 3) or (1, 3)."""
        columns = [np.zeros((1, 3))] * 3
        for step in reversed(self.chain[self.slides]):
            if step.joint.rotary:
                columns = [turned(c, step.axis, axes[:, step.column]) for c in columns]
            else:
                columns[step.column] = step.axis[None, :]
        return columns

    def tool_points(self, offset: ArrayLike) -> Array:
        """Tips at the zero pose (n, 3), in the world, of tools with these offsets (n, 3) [mm].

        The length stands on the tool, whatever way the slide Z goes.
        """
        directions = np.column_stack([self.frame[:, :2], self.rotary.tool_axis])
        return self.gauge - np.atleast_2d(np.asarray(offset, np.float64)) @ directions.T

    def directions(self, rotary: ArrayLike) -> Array:
        """Tool axis seen from the part, (n, 3), from the tip towards the spindle."""
        solver = self._orientation()
        q = np.atleast_2d(np.asarray(rotary, np.float64))
        seen = solver.directions(q[:, [c - 3 for c in columns_of(solver.joints)]])
        return _unit(seen @ np.linalg.inv(self.frame).T)

    def rotary_at(self, direction: ArrayLike, previous: ArrayLike, prefer: int = 0) -> Array:
        """A B C [deg] that a control takes for one direction (3,), see RotaryAxes.chosen.

        Raises:
            OrientationError: the direction cannot be reached, or not within the travel.
        """
        solver = self._orientation()
        columns = [c - 3 for c in columns_of(solver.joints)]
        found = np.array(previous, np.float64)
        found[columns] = solver.chosen(self._in_world(direction), found[columns], prefer)
        return found

    def carried(self, points: ArrayLike, rotary: ArrayLike) -> Array:
        """Where the work link carries points (n, 3) of its frame, as positions of the slides."""
        self._require()
        q = np.zeros((len(np.atleast_2d(rotary)), 6))
        q[:, 3:] = rotary
        world = self._to_world(np.atleast_2d(np.asarray(points, np.float64)))
        return self._from_world(self._moved(self.work_chain, world, q))

    def _require(self) -> None:
        if self.refusal:
            raise OrientationError("kinematics_unsolved", self.refusal)

    def _orientation(self) -> RotaryAxes:
        self._require()
        return self.rotary

    @staticmethod
    def _turned_only(rotary: ArrayLike) -> Array:
        """Axes (n, 6) with the slides at zero."""
        turns = np.atleast_2d(np.asarray(rotary, np.float64))
        return np.concatenate([np.zeros_like(turns), turns], axis=1)

    def _to_world(self, points: Array) -> Array:
        return np.asarray(points @ self.frame.T + self.gauge)

    def _from_world(self, points: Array) -> Array:
        return np.asarray((points - self.gauge) @ np.linalg.inv(self.frame).T)

    def _in_world(self, direction: ArrayLike) -> Array:
        vector = np.asarray(direction, np.float64) @ self.frame.T
        length = np.linalg.norm(vector)
        if not length > 0.0:
            raise OrientationError("direction_zero", "the direction of the tool has no length")
        return np.asarray(vector / length)

    @staticmethod
    def _moved(chain: tuple[ChainJoint, ...], points: Array, axes: Array) -> Array:
        for step in reversed(chain):
            points = step.moved(points, axes[:, step.column])
        return points


def tool_centre(machine: Machine) -> ToolCentre | None:
    """The kinematics of a machine; None without a rotary joint between work and tool.

    A machine that cannot be solved gives a ToolCentre whose `refusal` says why, and whose methods
    raise OrientationError: it can still run programs that do not ask for the tool's centre.
    """
    machine = commanded(machine)
    if machine.tool is None or machine.work_link is None:
        return None
    work, tool = _branch(machine, machine.work_link), _branch(machine, machine.tool.link)
    shared = sum(1 for a, b in zip(work, tool, strict=False) if a is b)
    between = [(j, -1.0) for j in reversed(work[shared:])] + [(j, 1.0) for j in tool[shared:]]
    chain = tuple(ChainJoint(j, columns_of((j,))[0], sign * j.axis) for j, sign in between)
    turns = [step for step in chain if step.joint.rotary]
    if not turns:
        return None
    slides = [index for index, step in enumerate(chain) if not step.joint.rotary]
    refusal = _refusal(chain, turns, machine.tool.axis)
    frame = np.eye(3)
    if not refusal:
        for index in slides:
            frame[:, chain[index].column] = chain[index].axis
    axes = np.array([step.axis for step in turns])
    return ToolCentre(
        chain=chain,
        slides=slice(slides[0], slides[-1] + 1) if slides else slice(0, 0),
        gauge=machine.tool.gauge_point,
        frame=frame,
        rotary=RotaryAxes(tuple(step.joint for step in turns), axes, machine.tool.axis),
        work_chain=tuple(ChainJoint(j, columns_of((j,))[0], j.axis) for j in work if j.rotary),
        refusal=refusal,
    )


def _branch(machine: Machine, link: str) -> list[Joint]:
    """Joints from the root to a link."""
    of_child = {joint.child: joint for joint in machine.joints}
    branch: list[Joint] = []
    while link in of_child:
        branch.insert(0, of_child[link])
        link = of_child[link].parent
    return branch


def _refusal(chain: tuple[ChainJoint, ...], turns: list[ChainJoint], tool_axis: Array) -> str:
    """Why the chain cannot be solved, empty when it can."""
    slides = [step.axis for step in chain if not step.joint.rotary]
    if len(slides) != 3 or len(turns) > 2:
        return (
            f"tool centre point control takes three linear and one or two rotary axes between work "
            f"and tool; this machine has {len(slides)} and {len(turns)}"
        )
    if abs(float(np.linalg.det(np.array(slides)))) < SINGULAR_VOLUME:
        return "X, Y and Z of this machine lie in one plane, so they cannot place the tool's tip"
    if len(turns) == 1:
        return ""
    first, second = turns
    if np.linalg.norm(np.cross(first.axis, second.axis)) < SINGULAR_VOLUME:
        names = f"{first.joint.name} and {second.joint.name}"
        return f"{names} turn about parallel axes, so they cannot point the tool"
    if np.linalg.norm(np.cross(second.axis, tool_axis)) < SINGULAR_VOLUME:
        return f"{second.joint.name} turns the tool about its own axis, so it cannot point it"
    return ""


def _unit(vectors: Array) -> Array:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1)[:, None])


def _solve(columns: list[Array], right: Array) -> Array:
    """Solve a 3x3 system by cofactors; columns are (n, 3) or (1, 3), right is (n, 3)."""
    a, b, c = columns
    rows = np.cross(b, c), np.cross(c, a), np.cross(a, b)
    volume = np.einsum("ij,ij->i", a, rows[0])
    if np.abs(volume).min(initial=np.inf) < SINGULAR_VOLUME:
        message = "X, Y and Z lie in one plane at these rotary positions"
        raise OrientationError("orientation_out_of_travel", message)
    return np.stack([np.einsum("ij,ij->i", right, row) / volume for row in rows], axis=1)
