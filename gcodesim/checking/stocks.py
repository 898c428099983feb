"""Stocks as they are cut away: races each of them, and says the answer as contacts and findings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from gcodesim.checking.verdict import CheckResult, StockCoverage
from gcodesim.collision.detector import Detection, Task
from gcodesim.collision.search.events import Contact
from gcodesim.constants import LEAST_INSET_MM, PS_PER_S
from gcodesim.findings.codes import Finding
from gcodesim.findings.left_out import LeftOut
from gcodesim.machine.kinematics import transform, world_from_link
from gcodesim.machine.model import Body, Machine, Pair
from gcodesim.motion.path import Path
from gcodesim.motion.samples import Span, sample_of, tool_spans
from gcodesim.stock.shapes_of_tools import NotTurnedError
from gcodesim.stock.workpiece import StockAnswer, StockEvent, StockTask, race_stock


@dataclass
class Stocks:
    """What the races found.

    Attributes:
        answers: of the stocks that were raced.
        contacts: in the order of time.
        refused: names of stocks that cannot be raced, with the reason.
    """

    answers: list[StockAnswer] = field(default_factory=list)
    contacts: list[Contact] = field(default_factory=list)
    refused: dict[str, str] = field(default_factory=dict)

    @property
    def decided(self) -> frozenset[str]:
        """Names of the stocks that are decided here."""
        return frozenset(answer.stock for answer in self.answers)

    @property
    def first(self) -> Contact | None:
        """The first contact."""
        return self.contacts[0] if self.contacts else None

    def told(self, task: Task) -> Task:
        """The task of the detector, which need not look at what is decided here."""
        known = self.first.sample if self.first else None
        return replace(task, decided=self.decided, known=known)

    def settle(self, task: Task, detection: Detection, audit: bool) -> list[Finding]:
        """Let a contact with a stock be the first one, if it is, and say what is not decided."""
        first = detection.contact
        if self.first and (first is None or _order(self.first) < _order(first)):
            detection.contact = self.first
            # What comes later would not have been looked at.
            detection.contained += [first] if first and task.aims.stop_all else []
        if task.aims.stop_all:
            detection.contained += [c for c in self.contacts if c is not detection.contact]
        findings = _undecided(self.answers) + _not_followed(self.refused, detection.in_stock)
        return findings + (_audited(task, self) if audit else [])

    def shown(self, result: CheckResult) -> CheckResult:
        """The result with how each stock was looked at."""
        coverage = tuple(
            StockCoverage(a.stock, a.inset, a.undecided, a.width, a.beams, a.items)
            for a in self.answers
        )
        left_out = tuple(
            LeftOut(f"{a.left_out} moves at {a.stock}", "no part of a tool comes near the stock")
            for a in self.answers
            if a.left_out
        )
        return replace(
            result,
            coverage=replace(result.coverage, stocks=coverage),
            left_out=(*result.left_out, *left_out),
        )


def _order(contact: Contact) -> tuple[int, str, str]:
    return contact.sample, contact.pair.a.casefold(), contact.pair.b.casefold()


def stocks_of(machine: Machine) -> list[Body]:
    """The bodies that are cut away, as far as the tool is checked against them."""
    if machine.tool is None:
        return []
    paired = {name for p in (*machine.pairs, *machine.cutting) for name in (p.a, p.b)}
    bodies = [body for name, body in machine.bodies.items() if name in paired]
    return [b for b in bodies if any(part.role == "stock" for part in b.parts)]


def raced(task: Task) -> Stocks:
    """Race every stock of a check."""
    found = Stocks()
    for stock in stocks_of(task.machine) if len(task.path) else []:
        asked = StockTask(
            task.machine,
            task.path,
            task.period_ps,
            task.device,
            task.aims.threads,
            task.aims.stop_all,
            task.aims.leave_out,
        )
        if not all(part.closed and not part.shell for part in stock.parts):
            found.refused[stock.name] = "its mesh is open, or only its surface counts"
            continue
        try:
            answer = race_stock(stock, asked)
        except NotTurnedError as error:
            found.refused[stock.name] = str(error)
            continue
        found.answers.append(answer)
        found.contacts += [_contact(event, stock, task) for event in answer.events]
    found.contacts.sort(key=lambda c: (c.sample, c.pair.name))
    return found


def _contact(event: StockEvent, stock: Body, task: Task) -> Contact:
    """An event as a contact of the tool and the stock."""
    machine, path = task.machine, task.path
    pair = _pair(machine, stock.name, event.part.role)
    tool_first = machine.tool is not None and pair.a == machine.tool.name
    sides = [(event.part.name, event.part.role), (stock.parts[0].name, "stock")]
    (name_a, role_a), (name_b, role_b) = sides if tool_first else sides[::-1]
    span = _span(path, event.piece)
    world = world_from_link(machine, path.positions(np.array([event.time_ps]))[0])[stock.link]
    return Contact(
        sample=event.sample,
        time_ps=event.time_ps,
        pair=pair,
        parts=(name_a, name_b),
        roles=(role_a, role_b),
        span=span,
        appears=event.sample <= sample_of(span.start_ps, task.period_ps),
        point=transform(world, np.array(event.point)),
        in_stock=_said(event, path),
    )


def _pair(machine: Machine, stock: str, role: str) -> Pair:
    """The pair of the tool and a stock, of the flute or of all else."""
    assert machine.tool is not None
    pairs = machine.cutting if role == "flute" else machine.pairs
    names = {machine.tool.name, stock}
    found = (p for p in (*pairs, *machine.cutting, *machine.pairs) if {p.a, p.b} == names)
    return next(found)


def _span(path: Path, piece: int) -> Span:
    start = int(path.bounds_ps[piece])
    return next(s for s in tool_spans(path) if s.start_ps <= start < s.end_ps)


def _said(event: StockEvent, path: Path) -> str:
    """How deep, and what would have taken the point away."""
    text = f"at least {event.depth:.2g} mm deep in this block; "
    if event.removed is None:
        return text + "no later cut takes that away"
    time, piece = event.removed
    later = (time - event.time_ps) / PS_PER_S
    return text + f"cut away by line {int(path.line[piece])}, {later:.3g} s later"


def _undecided(answers: Sequence[StockAnswer]) -> list[Finding]:
    """What a race leaves open."""
    findings = []
    for answer in answers:
        if answer.too_many and answer.events:
            text = (
                f"{answer.stock}: a touch before the one told, up to {answer.inset:g} mm, is not "
                f"excluded: {answer.undecided} beams of {answer.width:.3g} mm stay open"
            )
            findings.append(Finding("GC426", text, "stock_undecided"))
        elif answer.too_many:
            text = (
                f"the inset of {answer.inset:g} mm is too small for {answer.stock}: beams of "
                f"{answer.width:.3g} mm leave {answer.undecided} open; give a larger one in the "
                f"setup (stock_check: {{inset: {max(4 * answer.inset, LEAST_INSET_MM):g}}})"
            )
            findings.append(Finding("GC426", text, "stock_inset_too_small"))
        elif answer.undecided:
            text = (
                f"{answer.undecided} beams of {answer.width:.3g} mm of {answer.stock} stay "
                "undecided: something thin may stand where a body comes"
            )
            findings.append(Finding("GC426", text, "stock_undecided"))
        if answer.more_events:
            text = f"more than {len(answer.events)} contacts with {answer.stock}: not all are told"
            findings.append(Finding("GC430", text, "stock_more_contacts"))
    return findings


def _not_followed(refused: Mapping[str, str], touches: Sequence[Contact]) -> list[Finding]:
    """Why stocks keep their shape that a tool touches."""
    touched = {name for contact in touches for name in (contact.pair.a, contact.pair.b)}
    return [
        Finding("GC430", f"{name} keeps its shape in this check: {why}", "stock_not_followed")
        for name, why in refused.items()
        if name in touched
    ]


def _audited(task: Task, found: Stocks) -> list[Finding]:
    """Race again with nothing left out: GC901 where the answer differs."""
    if not found.answers:
        return []
    again = raced(replace(task, aims=replace(task.aims, leave_out=False, stop_all=False)))
    first, other = (s.first and (s.first.sample, s.first.pair.name) for s in (found, again))
    if first == other:
        return []
    text = f"audit disagrees: first contact with a stock {other} instead of {first}"
    return [Finding("GC901", text, "audit_disagrees")]
