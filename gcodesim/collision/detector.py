"""The detector: from a path and a machine to the first contact, tool by tool."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from types import ModuleType

import numpy as np
import warp as wp
from numpy.typing import NDArray

from gcodesim.collision.baseline.exhaustive import (
    InstantTest,
    exhaustive_test,
    first_sampled_contact,
)
from gcodesim.collision.bodies import tree_kernel
from gcodesim.collision.bodies.scene import Scene, build_scene, is_present
from gcodesim.collision.bounds import chords
from gcodesim.collision.bounds.departure import SampleStep, largest_step
from gcodesim.collision.bounds.motion_bounds import travelled
from gcodesim.collision.forbidden import Touches, TouchOrder, forbidden_touches
from gcodesim.collision.geometry import kernel_cache
from gcodesim.collision.geometry.poses import PathArrays, path_arrays
from gcodesim.collision.instants import touches
from gcodesim.collision.instants.contact import touching_triangles
from gcodesim.collision.instants.containment import Containment, find_containments
from gcodesim.collision.instants.work import WorkCounts
from gcodesim.collision.search import depths, lasting, search_kernel
from gcodesim.collision.search.events import Contact, SpanContext
from gcodesim.collision.search.span_search import Aims, SpanFindings, search_span
from gcodesim.errors import UsageError
from gcodesim.machine.flutes import above_flute, smaller_flute
from gcodesim.machine.kinematics import world_from_link
from gcodesim.machine.model import Body, Joint, Machine, Pair
from gcodesim.machine.spindle import bodies_in_place, table_entry, tool_body
from gcodesim.motion.overtravel import position_ranges
from gcodesim.motion.path import Path
from gcodesim.motion.samples import Span, tool_spans, window


@dataclass
class Detection:
    """What the detector found and what it cost.

    Attributes:
        contact: first contact, None when all is free.
        checked: pairs looked at.
        travels: the joints with what the path travels as their limits; none without a path.
        spans: stretches of program time looked at, each with its tool.
        missing: stretches of time in which the tool has no shape.
        contained: with --stop all, bodies inside another where they appear.
        undecided: containments that an open mesh leaves open, with their pair.
        findings: what the search found per span besides the first contact.
        in_stock: the first touch of the raw part by tool parts, per pair: it keeps its shape here.
        endless: pairs of a tool whose flute ends nobody knows where, with the span it cuts in.
        probed: the first touch of part, stock and fixture in skip moves, per pair.
        unmeasured: pairs whose clearance was not looked at, for a skip move may touch.
        not_smaller: flutes that cannot be made smaller, with the pairs that stay unchecked.
        steps: per span the largest step of a pair from sample to sample, and the pair.
    """

    contact: Contact | None = None
    checked: set[Pair] = field(default_factory=set)
    travels: tuple[Joint, ...] = ()
    spans: list[Span] = field(default_factory=list)
    missing: list[Span] = field(default_factory=list)
    contained: list[Contact] = field(default_factory=list)
    undecided: list[tuple[Pair, Containment]] = field(default_factory=list)
    findings: list[SpanFindings] = field(default_factory=list)
    in_stock: list[Contact] = field(default_factory=list)
    endless: dict[Pair, Span] = field(default_factory=dict)
    probed: list[Contact] = field(default_factory=list)
    unmeasured: set[Pair] = field(default_factory=set)
    not_smaller: dict[tuple[Pair, str], Span] = field(default_factory=dict)
    steps: list[tuple[Pair, SampleStep]] = field(default_factory=list)
    work: WorkCounts = field(default_factory=WorkCounts)


@dataclass(frozen=True)
class Task:
    """One path to be checked on one machine.

    Attributes:
        period_ps: sample period [ps].
        device: resolved device name.
        method: search | exhaustive | paper.
        aims: what the method search is asked for.
        progress: called with the fraction of program time done.
        decided: stocks whose pairs with the tool are decided elsewhere, as they are cut away.
        known: sample of a contact found there: clearances count up to it.
    """

    path: Path
    machine: Machine
    period_ps: int
    device: str
    method: str
    aims: Aims
    progress: Callable[[float], None]
    decided: frozenset[str] = frozenset()
    known: int | None = None


def load_kernels(method: str, device: str, stop_all: bool = False) -> tuple[str, ...]:
    """Compile what a method needs, or load it from Warp's cache, so that it is timed apart.

    Args:
        method: search | exhaustive | paper.
        device: resolved device name.
        stop_all: all contacts are listed, not only the first.

    Returns:
        The modules, by their names in this package.
    """
    if method == "paper":
        from gcodesim.collision.baseline import paper  # no other check has a use for it

        _load(paper, device)
        return ("paper",)
    _load(touches, device)
    if method != "search":
        return ("touches",)
    _load(chords, device)
    _load(search_kernel, device)
    _load(tree_kernel, "cpu")
    names = ("touches", "chords", "search_kernel", "tree_kernel")
    if not stop_all:
        return names
    _load(lasting, device)
    _load(depths, device)
    return (*names, "lasting", "depths")


def _load(module: ModuleType, device: str) -> None:
    """Load the kernels of a module; what Warp cannot load from its cache is built again, once."""
    try:
        wp.load_module(module, device=device)
    except Exception as error:  # of whatever LLVM or CUDA met
        kernel_cache.start_anew(error)
        wp.get_module(module.__name__).unload()
        try:
            wp.load_module(module, device=device)
        except Exception as second:
            why = " ".join(str(second).split())
            raise UsageError(f"the kernels of gcodesim cannot be compiled: {why}") from second
    kernel_cache.seal()


def detect(task: Task) -> Detection:
    """Find the first contact of the path, tool by tool.

    Nothing is checked where the path has no pieces.
    """
    detection = Detection()
    if not len(task.path):
        return detection
    arrays = path_arrays(task.path, task.device)
    travels = detection.travels = travelled(task.machine.joints, task.path)
    for span in _spans_by_body(task):
        detection.spans.append(span)
        bodies = bodies_in_place(task.machine, span.tool)
        present = [p for p in task.machine.pairs if is_present(p, bodies)]
        soft = tuple(p for p in present if _in_stock(p, task.machine))
        probed = _probed_pairs(task, span, present, bodies)
        pairs = tuple(p for p in present if p not in soft and p not in probed)
        bare = any(name not in bodies for p in task.machine.pairs for name in (p.a, p.b))
        if bare and span.end_ps > span.start_ps:
            # An empty spindle that nothing moves before the first tool change is no gap.
            detection.missing.append(span)
        detection.checked.update(present)
        looked = _Forbidden(task, arrays, span, travels, detection)
        early = min_contact(looked.flute_in_part(), looked.tool_while_probing(probed, bodies))
        looked.tool_in_stock(tuple(p for p in soft if not _is_decided(p, task, span)), bodies)
        if not pairs:
            detection.contact = early or detection.contact
            if early and not task.aims.stop_all:
                break
            continue
        scene = build_scene(pairs, bodies, task.machine.joints, task.device)
        context = SpanContext(task.machine, task.path, scene, span, task.period_ps, travels)
        step = largest_step(scene, travels, task.path, _pieces(task.path, span), task.period_ps)
        if step:
            detection.steps.append((scene.pairs[step.pair], step))
        if task.method == "search":
            contact, findings = search_span(
                context,
                arrays,
                task.aims,
                detection.work,
                task.progress,
                _known(early, task),
            )
            detection.findings.append(findings)
        else:
            contact = _sample(task, context, arrays, detection)
        inside = _contain(context, detection)
        if task.aims.stop_all:
            inside = [context.with_depth(contact, arrays) for contact in inside]
            detection.contained += inside
        found = [c for c in (*inside, contact, early, detection.contact) if c]
        detection.contact = min(found, key=_order) if found else None
        if (detection.contact or _is_over(task, span)) and not task.aims.stop_all:
            break
    return detection


def min_contact(*found: Contact | None) -> Contact | None:
    """The first of some contacts."""
    return min((contact for contact in found if contact), key=_order, default=None)


def _probed_pairs(
    task: Task, span: Span, pairs: list[Pair], bodies: dict[str, Body]
) -> tuple[Pair, ...]:
    """The pairs of the tool and a fixture, where a skip move of the span may touch."""
    path, tool = task.path, task.machine.tool
    if path.touching is None or tool is None or not path.touching[_pieces(path, span)].any():
        return ()
    return tuple(p for p in pairs if tool.name in (p.a, p.b) and _is_fixture(p, tool.name, bodies))


def _is_fixture(pair: Pair, tool: str, bodies: dict[str, Body]) -> bool:
    other = bodies[pair.b if pair.a == tool else pair.a]
    return any(part.role == "fixture" for part in other.parts)


def _known(early: Contact | None, task: Task) -> int | None:
    """The sample of a contact that is known before the search of a span."""
    known = [early.sample] if early else []
    return min([*known, *([] if task.known is None else [task.known])], default=None)


def _is_over(task: Task, span: Span) -> bool:
    """Whether a contact that is known ends the check in a span."""
    return task.known is not None and task.known * task.period_ps <= span.end_ps


def _is_decided(pair: Pair, task: Task, span: Span) -> bool:
    """Whether a pair of tool and stock is decided elsewhere; a tool that never moves is not."""
    pieces = _pieces(task.path, span)
    return bool({pair.a, pair.b} & task.decided) and pieces.start < pieces.stop


def _pieces(path: Path, span: Span) -> slice:
    first, end = np.searchsorted(path.bounds_ps, [span.start_ps, span.end_ps]).tolist()
    return slice(first, end)


def _order(contact: Contact) -> tuple[int, bool, str, str]:
    """Earlier first; of one sample, surfaces before containments, then by the alphabet."""
    names = contact.pair.a.casefold(), contact.pair.b.casefold()
    return contact.sample, contact.triangles is None, *names


def _in_stock(pair: Pair, machine: Machine) -> bool:
    """Whether a pair is one of the tool and the raw part, which keeps its shape here."""
    tool = machine.tool.name if machine.tool else ""
    other = {pair.a, pair.b} - {tool}
    if len(other) != 1:
        return False
    parts = machine.bodies[other.pop()].parts
    return any(part.role == "stock" for part in parts)


@dataclass(frozen=True)
class _Forbidden:
    """What the tool may not do at some times: the flute in the part, and the tool in the stock."""

    task: Task
    arrays: PathArrays
    span: Span
    travels: tuple[Joint, ...]
    detection: Detection

    def flute_in_part(self) -> Contact | None:
        """The first touch of part by flute where it does not cut."""
        task, detection = self.task, self.detection
        cuts, machine = task.path.cuts, task.machine
        if cuts is None or not machine.cutting:
            return None
        flute, odd = smaller_flute(machine, self.span.tool)
        bodies = {**machine.bodies, **({flute.name: flute} if flute else {})}
        first = self._above_flute(cuts)
        for pair in machine.cutting:
            if _is_decided(pair, task, self.span):
                detection.checked.add(pair)
                if flute is not None and is_present(pair, bodies):
                    self._note(pair, bodies)
                continue
            for name in odd:
                if name in (*(pair.parts_a or ()), *(pair.parts_b or ())):
                    detection.not_smaller.setdefault((pair, name), self.span)
            if flute is None or not is_present(pair, bodies):
                continue
            detection.checked.add(pair)
            first += self._kept(pair, self._touches(pair, bodies, ~cuts))
            self._note(pair, bodies)
        return min(first, key=_order, default=None)

    def tool_while_probing(
        self, pairs: tuple[Pair, ...], bodies: dict[str, Body]
    ) -> Contact | None:
        """The first touch of a fixture by the tool, whose flute may touch it in skip moves."""
        task, first = self.task, list[Contact]()
        touching, tool = task.path.touching, task.machine.tool
        if touching is None or tool is None:
            return None
        flute, rest = self._split(bodies[tool.name])
        for pair in pairs:
            self.detection.unmeasured.add(pair)
            first += self._kept(pair, self._touches(pair, bodies, ~touching))
            if rest and is_present(pair, others := {**bodies, rest.name: rest}):
                first += self._kept(pair, self._touches(pair, others, touching))
            if flute:
                self._note(pair, {**bodies, flute.name: flute})
        return min(first, key=_order, default=None)

    def _split(self, tool: Body) -> tuple[Body | None, Body | None]:
        """The flute of a tool, and what else it has."""
        flutes = tuple(part for part in tool.parts if part.role == "flute")
        others = tuple(part for part in tool.parts if part.role != "flute")
        machine = self.task.machine
        if not others and machine.tool and flutes == (machine.tool.one_shape,):
            return tool, above_flute(machine)
        return (
            replace(tool, parts=flutes) if flutes else None,
            replace(tool, parts=others) if others else None,
        )

    def _note(self, pair: Pair, bodies: dict[str, Body]) -> None:
        """Keep what the flute touches first in skip moves."""
        touching, span = self.task.path.touching, self.span
        if touching is None or not touching[_pieces(self.task.path, span)].any():
            return
        found = self._touches(pair, bodies, touching).contacts
        self.detection.probed += [c for c in found[:1] if not c.appears]

    def _above_flute(self, cuts: NDArray[np.bool_]) -> list[Contact]:
        """Touches of the part, while it is cut, by what of a tool of one shape is no flute."""
        machine, span, path = self.task.machine, self.span, self.task.path
        if machine.tool is None or not cuts[_pieces(path, span)].any():
            return []
        if machine.tool.one_shape is None or tool_body(machine, span.tool) is None:
            return []
        if table_entry(machine, span.tool) is not None:
            return []
        rest, first = above_flute(machine), []
        for pair in machine.cutting:
            if _is_decided(pair, self.task, span):
                continue
            if rest is None:
                self.detection.endless.setdefault(pair, span)
                continue
            bodies = {**machine.bodies, rest.name: rest}
            if is_present(pair, bodies):
                first += self._kept(pair, self._touches(pair, bodies, cuts))
        return first

    def _kept(self, pair: Pair, found: Touches) -> list[Contact]:
        """Keep what was found of a pair, and return its first contact if that counts."""
        detection = self.detection
        if _in_stock(pair, self.task.machine):
            detection.in_stock += found.contacts[:1]
            return []
        if self.task.aims.stop_all:
            detection.contained += [c for c in found.contacts if c.triangles is None]
            detection.findings.append(SpanFindings(intervals=found.intervals))
        return found.contacts[:1]

    def tool_in_stock(self, pairs: tuple[Pair, ...], bodies: dict[str, Body]) -> None:
        """The first touch of the stock by parts of the tool that never cut, per pair."""
        everywhere = np.ones(len(self.task.path), np.bool_)
        for pair in pairs:
            found = self._touches(pair, bodies, everywhere)
            self.detection.in_stock += found.contacts[:1]

    def _touches(self, pair: Pair, bodies: dict[str, Body], wanted: NDArray[np.bool_]) -> Touches:
        task, detection = self.task, self.detection
        scene = build_scene((pair,), bodies, task.machine.joints, task.device)
        context = SpanContext(
            task.machine, task.path, scene, self.span, task.period_ps, self.travels
        )
        in_stock = _in_stock(pair, task.machine)
        order = TouchOrder(
            task.method == "search",
            task.aims.between,
            task.aims.stop_all and not in_stock,
            task.aims.threads,
        )
        found = forbidden_touches(context, self.arrays, wanted, order, detection.work)
        detection.undecided += [(pair, item) for item in found.undecided]
        if found.overflows:
            detection.findings.append(SpanFindings(overflows=found.overflows))
        return found


def _spans_by_body(task: Task) -> list[Span]:
    """SomePieces of time with the same tool body; a change for the same one changes nothing."""
    merged: list[Span] = []
    mounted: int | None = None
    for span in tool_spans(task.path):
        entry = table_entry(task.machine, span.tool)
        number = entry.number if entry else _shapeless_number(task.machine, span.tool)
        if merged and number == mounted:
            merged[-1] = replace(merged[-1], end_ps=span.end_ps)
        else:
            merged.append(span)
        mounted = number
    return merged


def _shapeless_number(machine: Machine, number: int | None) -> int | None:
    """A number for a tool without a table entry; None = the mounted tool is used for all."""
    stands_for_all = machine.tool is not None and machine.tool.for_all
    return None if stands_for_all else number


def _sample(
    task: Task, context: SpanContext, arrays: PathArrays, detection: Detection
) -> Contact | None:
    """First contact within one span, looking at every sample and every block end."""
    scene, span = context.scene, context.span
    test = _instant_test(task, scene, arrays, detection.work)
    hit = first_sampled_contact(task.path, span, task.period_ps, test, task.progress)
    if hit is None:
        return None
    # The instants that count for the sample: block ends before it, then the sample itself.
    instants = window(task.path, span, hit[0], 1, task.period_ps)
    return context.touch(*hit, touching_triangles(scene, arrays, instants, hit[1]))


def _instant_test(task: Task, scene: Scene, arrays: PathArrays, work: WorkCounts) -> InstantTest:
    """How a method that samples finds the first contact among some instants."""
    if task.method == "exhaustive":
        return exhaustive_test(scene, arrays, work)
    from gcodesim.collision.baseline.paper import first_contact_paper, prepare_paper

    prepared = prepare_paper(scene, _travelled(task))
    return partial(first_contact_paper, scene, prepared, arrays, work=work)


def _travelled(task: Task) -> tuple[Joint, ...]:
    """The joints with their travel as far as the path exceeds it; the path's own if unlimited."""
    joints = []
    for column, joint in enumerate(task.machine.joints):
        lows, highs = position_ranges(task.path, column)
        low, high = float(lows.min()), float(highs.max())
        lower = min(low, joint.lower) if np.isfinite(joint.lower) else low
        upper = max(high, joint.upper) if np.isfinite(joint.upper) else high
        joints.append(replace(joint, lower=lower, upper=upper))
    return tuple(joints)


def _contain(context: SpanContext, detection: Detection) -> list[Contact]:
    """Bodies inside another at the start of a span: contacts that surfaces do not show."""
    q = context.path.positions(np.array([context.span.start_ps]))[0]
    world = world_from_link(context.machine, q)
    scene = context.scene
    relative = [np.linalg.inv(world[a]) @ world[b] for a, b in scene.links]
    found = find_containments(scene, relative)
    detection.undecided += [(scene.pairs[c.pair], c) for c in found if not c.decided]
    return [context.containment(c) for c in found if c.decided]
