"""The kinematic tree: puts links and joints in order, parents first, or says what is wrong."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from gcodesim.machine.model import Joint, Servo
from gcodesim.machine.schema import JointSpec, MachineFile, Triple
from gcodesim.machine.yaml_lines import YamlFile, suggest

SECONDS_PER_MINUTE = 60.0


def build_tree(file: MachineFile, source: YamlFile) -> tuple[tuple[str, ...], tuple[Joint, ...]]:
    """Links and joints in order, parents before children and else as in the file.

    Links without a joint stand fixed: that of the first joint leads, for it is the root.

    Raises:
        ModelError: an unknown link, two parents, a cycle, or a wrong joint.
    """
    _check_parents(file, source)
    links, joints = _fixed(file, source), []
    waiting = dict(file.joints)
    while waiting:
        name = next((n for n, spec in waiting.items() if spec.parent in links), None)
        if name is None:
            raise _cycle_error(waiting, source)
        spec = waiting.pop(name)
        links.append(spec.child)
        joints.append(_build_joint(name, spec, file.links[spec.child].side, source))
    return tuple(links), tuple(joints)


def _check_parents(file: MachineFile, source: YamlFile) -> None:
    """Every joint names known links, and no link hangs on two joints."""
    joint_of: dict[str, str] = {}
    for name, spec in file.joints.items():
        for key in ("parent", "child"):
            link = getattr(spec, key)
            if link not in file.links:
                text = f"unknown link {link!r}; {suggest(link, file.links)}"
                raise source.error(text, "joints", name, key)
        if spec.child in joint_of:
            text = (
                f"link {spec.child} already hangs on joint {joint_of[spec.child]}: one parent only"
            )
            raise source.error(text, "joints", name, "child")
        joint_of[spec.child] = name


def _fixed(file: MachineFile, source: YamlFile) -> list[str]:
    """The links that no joint moves, those first that carry others."""
    children = {spec.child for spec in file.joints.values()}
    roots = [name for name in file.links if name not in children]
    if not roots:
        raise _cycle_error(dict(file.joints), source)
    parents = {spec.parent for spec in file.joints.values()}
    return sorted(roots, key=lambda name: name not in parents)


def _cycle_error(waiting: Mapping[str, JointSpec], source: YamlFile) -> Exception:
    """The error for joints whose links lead back to themselves."""
    joint_of = {spec.child: name for name, spec in waiting.items()}
    seen: list[str] = []
    link = next(iter(waiting.values())).child
    while link not in seen:
        seen.append(link)
        link = waiting[joint_of[link]].parent
    ring = [*reversed(seen[seen.index(link) :])]
    text = f"the links form a cycle: {' -> '.join([*ring, ring[0]])}; one link must be the root"
    return source.error(text, "joints", joint_of[ring[0]], "parent")


def _build_joint(name: str, spec: JointSpec, side: str | None, source: YamlFile) -> Joint:
    """A joint in the units of the model; on the work side the child moves against the axis."""
    rotary = spec.type == "rotary"
    if name in ("XYZUVW" if rotary else "ABC"):
        right = "A, B and C are rotary; X, Y, Z, U, V and W are linear; other names are free"
        raise source.error(f"axis {name} cannot be {spec.type}: {right}", "joints", name, "type")
    if rotary and spec.point is None:
        raise source.error("a rotary joint needs `point`, a point on its axis", "joints", name)
    if not rotary and spec.point is not None:
        raise source.error("only a rotary joint has a point", "joints", name, "point")
    if not rotary and spec.wrap != "none":
        raise source.error("only a rotary joint wraps", "joints", name, "wrap")
    axis = unit_vector(spec.axis, source, "joints", name, "axis")
    lower, upper = spec.limits or (-math.inf, math.inf)
    if lower >= upper:
        text = f"lower limit {lower:g} is not below upper limit {upper:g}: write [lower, upper]"
        raise source.error(text, "joints", name, "limits")
    return Joint(
        name=name,
        rotary=rotary,
        parent=spec.parent,
        child=spec.child,
        axis=-axis + 0.0 if side == "work" else axis,
        point=np.array(spec.point or (0.0, 0.0, 0.0)),
        lower=lower,
        upper=upper,
        rapid=spec.rapid / SECONDS_PER_MINUTE,
        max_acceleration=spec.max_acceleration,
        wrap=spec.wrap,
        max_jerk=spec.max_jerk,
        servo=_servo(spec),
    )


def _servo(spec: JointSpec) -> Servo | None:
    if spec.servo is None:
        return None
    damping = 1.0 if spec.servo.damping is None else spec.servo.damping
    return Servo(spec.servo.order, spec.servo.time_constant, damping)


def unit_vector(vector: Triple, source: YamlFile, *key: str | int) -> NDArray[np.float64]:
    """A direction of the file with length 1, shape (3,); ModelError for a zero vector."""
    largest = max(abs(v) for v in vector)
    if largest == 0.0:
        raise source.error("an axis of length 0 has no direction, as [0, 0, 1] would", *key)
    scaled = np.array(vector) / largest  # first, so that squares neither vanish nor overflow
    return np.asarray(scaled / np.linalg.norm(scaled))
