"""Which bodies must not touch: the pairs a machine file names, or the default set."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

from gcodesim.constants import FLUTE_INSET_MM
from gcodesim.machine.model import Joint, Pair
from gcodesim.machine.schema import AllowedSpec, PairSpec
from gcodesim.machine.yaml_lines import YamlFile, suggest

LINK, TOOL = "link", "tool"
CUT = ("part", "stock")

PartsOfBody = tuple[str, tuple[str, ...] | None]
"""A body, and the parts of it that are meant; None: all."""


@dataclass(frozen=True)
class Member:
    """A body as far as pairs are concerned.

    Attributes:
        name: of the body.
        link: link that carries it.
        role: link | tool | fixture | part | stock.
        parts: names of its parts, or of those it may get (a tool); empty: it can have no shape.
        uncut: parts of a tool that may never touch part or stock: all but the flute.
        flutes: its flutes.
    """

    name: str
    link: str
    role: str
    parts: tuple[str, ...] = ()
    uncut: tuple[str, ...] = ()
    flutes: tuple[str, ...] = ()


@dataclass(frozen=True)
class PairSet:
    """The pairs to check, in alphabetical order.

    Attributes:
        pairs: those that may never touch.
        cutting: pairs of the flute with part and stock: they may touch while it cuts.
        unchecked_by_rule: what is left out by rule, as lines.
    """

    pairs: tuple[Pair, ...]
    cutting: tuple[Pair, ...]
    unchecked_by_rule: tuple[str, ...]


def choose_pairs(
    members: Sequence[Member],
    joints: Sequence[Joint],
    named: Sequence[PairSpec] | None,
    allowed: Sequence[AllowedSpec],
    source: YamlFile,
) -> PairSet:
    """The pairs of a machine with its tool and setup.

    Args:
        members: all links and setup bodies with a shape, and the tool.
        joints: of the machine.
        named: `pairs:` of the machine file; it replaces the default set except for setup bodies.
        allowed: `allow:` of the machine file; takes pairs out of either.
        source: the machine file, for errors.

    Raises:
        ModelError: an unknown body or part, a pair of a body with itself, or a pair named twice.
    """
    bodies = {member.name: member for member in members}
    default = default_pairs(members, joints)
    if named is None:
        pairs = default
    else:
        of_setup = [p for p in default if {bodies[p.a].role, bodies[p.b].role} - {LINK, TOOL}]
        written = _named_pairs(named, bodies, source)
        pairs = written + [p for p in of_setup if not _is_in(p, written)]
    for i, spec in enumerate(allowed):
        first, second = (_side(name, bodies, "allow", i, source) for name in spec.links)
        pairs = [rest for pair in pairs for rest in _without(pair, first, second, bodies)]
    kept, lines = [], []
    for pair in pairs:
        rest, line = _by_rule(pair, bodies)
        kept += [rest] if rest else []
        lines += [line] if line else []
    cutting = [flute for pair in pairs if (flute := _cutting(pair, bodies))]
    return PairSet(
        tuple(sorted(kept, key=_alphabetical)),
        tuple(sorted(cutting, key=_alphabetical)),
        tuple(sorted(set(lines))),
    )


def default_pairs(members: Sequence[Member], joints: Sequence[Joint]) -> list[Pair]:
    """Every two bodies with a joint between them, less neighbours: links joined by one joint.

    Neighbouring links overlap in their guideways and bearings. A tool or a setup body has none of
    those, so that a fixture is checked against the link below its table too.
    """
    parent = {joint.child: joint.parent for joint in joints}
    pairs = []
    for a, b in combinations(sorted(members, key=lambda m: (m.role != TOOL, m.name.casefold())), 2):
        moving = _ancestry(a.link, parent) != _ancestry(b.link, parent)
        joined = parent.get(a.link) == b.link or parent.get(b.link) == a.link
        if moving and not (joined and a.role == b.role == LINK):
            pairs.append(Pair(a.name, b.name))
    return pairs


def _ancestry(link: str, parent: Mapping[str, str]) -> set[str]:
    """The link and its ancestors, the root left out: one per joint above it."""
    chain = set()
    while link in parent:
        chain.add(link)
        link = parent[link]
    return chain


def _alphabetical(pair: Pair) -> tuple[str, ...]:
    return (pair.a.casefold(), pair.b.casefold(), pair.a, pair.b,
            *(pair.parts_a or ()), "|", *(pair.parts_b or ()))  # fmt: skip


def _is_in(pair: Pair, others: Sequence[Pair]) -> bool:
    return any({pair.a, pair.b} == {other.a, other.b} for other in others)


def _named_pairs(
    named: Sequence[PairSpec], bodies: Mapping[str, Member], source: YamlFile
) -> list[Pair]:
    """The pairs as written."""
    pairs: list[Pair] = []
    seen: dict[frozenset[str], int] = {}
    for i, spec in enumerate(named):
        (a, parts_a), (b, parts_b) = (
            _side(name, bodies, "pairs", i, source) for name in spec.links
        )
        if a == b:
            raise source.error(f"{a} is paired with itself: name two bodies", "pairs", i)
        first = seen.setdefault(frozenset(spec.links), i)
        if first != i:
            line = source.line(("pairs", str(first)))
            raise source.error(f"{a} and {b} are paired twice, first in line {line}", "pairs", i)
        pairs.append(Pair(a, b, parts_a, parts_b, spec.clearance, spec.severity))
    return pairs


def _side(
    name: str, bodies: Mapping[str, Member], key: str, index: int, source: YamlFile
) -> PartsOfBody:
    """Body and parts that one side of a pair of the file means: `C` or `C.table`."""
    body, _, part = name.partition(".")
    if body not in bodies:
        text = f"no body named {body!r} has a shape; {suggest(body, bodies)}"
        raise source.error(text, key, index)
    if part and part not in bodies[body].parts:
        text = f"{body} has no part {part!r}; {suggest(part, bodies[body].parts)}"
        raise source.error(text, key, index)
    return body, (part,) if part else None


def _without(
    pair: Pair, first: PartsOfBody, second: PartsOfBody, bodies: Mapping[str, Member]
) -> Iterator[Pair]:
    """Yield what is left of a pair without some parts of the one body against some of the other."""
    if {pair.a, pair.b} != {first[0], second[0]}:
        yield pair
        return
    (_, gone_a), (_, gone_b) = (first, second) if pair.a == first[0] else (second, first)
    # A tool may get any of its parts later; all of a body that has none is allowed at once.
    all_a, all_b = pair.parts_a or bodies[pair.a].parts, pair.parts_b or bodies[pair.b].parts
    kept_a = tuple(part for part in all_a if gone_a and part not in gone_a)
    kept_b = tuple(part for part in all_b if gone_b and part not in gone_b)
    if kept_a:
        yield replace(pair, parts_a=kept_a)
    if kept_b:
        rest = tuple(part for part in all_a if part not in kept_a)
        yield replace(pair, parts_a=rest if gone_a else pair.parts_a, parts_b=kept_b)


def _by_rule(pair: Pair, bodies: Mapping[str, Member]) -> tuple[Pair | None, str]:
    """What is left of a pair by rule, and the line that says what is not checked, "" for none."""
    a, b = bodies[pair.a], bodies[pair.b]
    for body in (a, b):
        if not body.parts:
            return None, f"{pair.name}: {body.name} has no shape (no mounted tool, no tools file)"
    tool, other = (a, b) if a.role == TOOL else (b, a)
    if tool.role != TOOL or other.role not in CUT:
        return pair, ""
    wanted = (pair.parts_a if tool is a else pair.parts_b) or tool.uncut
    rest = tuple(part for part in tool.uncut if part in wanted)
    what = "flute" if rest else "the tool, one shape or flute only,"
    line = f"{pair.name}: {what} against {other.role} is cutting, not collision, while it is fed "
    line += f"and turns; else the flute is checked, {FLUTE_INSET_MM:g} mm smaller"
    if not rest:
        return None, line
    return replace(pair, parts_a=rest) if tool is a else replace(pair, parts_b=rest), line


def _cutting(pair: Pair, bodies: Mapping[str, Member]) -> Pair | None:
    """What a pair says of the flute against part or stock, None where it says nothing."""
    a, b = bodies[pair.a], bodies[pair.b]
    tool, other = (a, b) if a.role == TOOL else (b, a)
    if tool.role != TOOL or other.role not in CUT:
        return None
    wanted = (pair.parts_a if tool is a else pair.parts_b) or tool.flutes
    flutes = tuple(part for part in tool.flutes if part in wanted)
    if not flutes or not other.parts:
        return None
    return replace(pair, parts_a=flutes) if tool is a else replace(pair, parts_b=flutes)
