"""What findings of pairs say: the code of a contact, and numbers that show why one is too near."""

from __future__ import annotations

from itertools import product

import pytest

from gcodesim.checking.evidence import contact_finding, first_contact
from gcodesim.checking.flow import check_program
from gcodesim.checking.options import Options
from gcodesim.collision.search.events import Contact
from gcodesim.findings.codes import Finding
from gcodesim.machine.loading import load_machine
from gcodesim.machine.model import Pair
from gcodesim.motion.samples import tool_spans
from gcodesim.study.scenes import box, joint, machine, path


@pytest.mark.parametrize(
    ("clearance", "said"),
    [
        (0.75, "comes to 0.5 mm of X; the clearance asked for is 0.75 mm"),
        (0.5 + 2e-6, "comes to 0.5 mm of X; the clearance asked for is 0.500002 mm"),
        (0.5 + 5e-7, None),
        (0.5, None),
    ],
)
def test_a_clearance_that_is_just_reached_is_told_so(clearance: float, said: str | None) -> None:
    """A cube passes another one half a millimetre apart, all the time."""
    shapes = {"bed": box([10, 10, 10]) + [0, 10.5, 0], "X": box([10, 10, 10])}
    model = machine([joint("X", [1, 0, 0], "bed", "X")], shapes, [("bed", "X")])
    options = Options(device="cpu", clearance=clearance)
    result = check_program("G21 G90 G94\nG1 X100. F6000.\nM30\n", "a.nc", model, options)
    messages = [finding.message for finding in result.findings if finding.code == "GC201"]
    assert len(messages) == (said is not None)
    assert all(message.endswith(said or "") for message in messages)


TOOL, CUT = ("flute", "shank", "holder"), ("part", "stock")
CODES_OF_ROLES = [
    ("GC101", ("machine",), ("machine",)),
    ("GC102", TOOL, ("machine",)),
    ("GC103", ("shank", "holder"), CUT),
    ("GC105", ("flute",), CUT),
    ("GC104", TOOL, ("fixture",)),
    ("GC108", ("machine", "fixture"), (*CUT, "fixture")),
]


@pytest.mark.parametrize(
    ("code", "roles"),
    [(code, roles) for code, a, b in CODES_OF_ROLES for roles in product(a, b)],
)
def test_the_code_of_a_contact_does_not_depend_on_the_order_of_the_pair(
    code: str, roles: tuple[str, str]
) -> None:
    found = [_contact(roles), _contact((roles[1], roles[0]))]
    assert [_finding(contact).code for contact in found] == [code, code]


def test_what_touches_between_two_samples_is_inside_nothing() -> None:
    """The interval of such a contact knows no triangles, but surfaces meet in it."""
    finding = _finding(_contact(("machine", "part"), between=True))
    assert (finding.code, finding.meaning) == ("GC107", "contact")
    assert finding.message == "a touches b between two samples"


def _contact(roles: tuple[str, str], *, between: bool = False) -> Contact:
    triangles = None if between else (0, 0)
    (span,) = tool_spans(PATH)
    return Contact(
        10, 10**9, Pair("a", "b"), ("a", "b"), roles, span, False, triangles, between=between
    )


def _finding(contact: Contact) -> Finding:
    return contact_finding(contact, first_contact(contact, PATH, ()))


PATH = path([joint("X", [1, 0, 0])], [0.0], [(1.0, [10.0])])


@pytest.mark.parametrize(
    ("blocks", "code", "bare"),
    [
        ("G0 Z-400.", "GC102", True),
        ("G43 H1 Z-20.", "GC102", False),
        ("G43 H1 Z100.\nG49\nG0 Z-400.", "GC102", True),
        ("G43 H1 Z100.\nH0\nG0 Z-400.", "GC102", True),
        ("G0 X900.", "GC301", True),
        ("G43 H1 Z100.\nX900.", "GC301", False),
    ],
)
def test_a_contact_or_overtravel_says_that_no_tool_length_is_active(
    blocks: str, code: str, bare: bool
) -> None:
    model = load_machine("table_tilt")
    text = f"G21 G90 G94 G54\nT1 M6\nG0 X0. Y0.\n{blocks}\nM30\n"
    result = check_program(text, "a.nc", model, Options(device="cpu", dialect="fanuc"))
    found = [finding for finding in result.findings if finding.code == code]
    assert found
    assert all(f.message.endswith("; no tool length is active") is bare for f in found)


def test_an_overtravel_says_when_and_at_which_positions_travel_is_left() -> None:
    """At 100 mm/s X leaves its travel of 250 mm after 2.5 s; A turns for 0.2 s before."""
    text = "G21 G90 G94 G54\nG0 A-30.\nG1 X310. F6000.\nM30\n"
    result = check_program(text, "a.nc", load_machine("table_tilt"), Options(device="cpu"))
    (finding,) = (f for f in result.findings if f.code == "GC301")
    assert (finding.line, finding.time_s) == (3, pytest.approx(2.7, abs=1e-6))
    assert finding.message.startswith(
        "X reaches 310 mm, 60 mm beyond its travel of -250 to 250; it leaves it at 2.700000 s, "
        "at X 250.0000 Y 0.0000 Z 0.0000 A -30.0000 C 0.0000 (machine coordinates)"
    )
