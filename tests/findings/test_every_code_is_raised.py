"""Every code of the table is raised: by a check of a program, or by lint of a model (GC50x)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from machine.stl import stl_bytes

import gcodesim
from gcodesim.checking.lint import lint
from gcodesim.findings.codes import CODES
from gcodesim.machine import shapes
from gcodesim.machine.loading import load_machine

MACHINE = """\
name: small
units: mm
verified: true
links:
  bed: {box: {size: [400, 100, 20], center: [0, 0, -60]}}
  X: {box: {size: [100, 100, 20], center: [0, 0, -10]}}      # table, surface at z = 0
  A: {}
  Z: {box: {size: [40, 40, 40], center: [0, 0, 150]}}        # head, down to z = 130
joints:
  X: {type: linear, parent: bed, child: X, axis: [-1, 0, 0], limits: [-300, 300], rapid: 60000}
  A: {type: rotary, parent: X, child: A, axis: [-1, 0, 0], point: [0, 0, 50], limits: [-90, 90], rapid: 3600}
  Z: {type: linear, parent: bed, child: Z, axis: [0, 0, 1], limits: [-200, 50], rapid: 60000}
tool:
  link: Z
  gauge_point: [0, 0, 130]
  mounted:                                                   # holder down to z = 110, flute to 70
    {name: cutter, length: 60, for: all, parts: [
      {name: holder, cylinder: {radius: 15, height: 20, center: [0, 0, 120]}},
      {name: flute, cylinder: {radius: 3, height: 40, center: [0, 0, 90]}}]}
work: {link: X, offsets: {G54: {}}}
control: {no_point: units}
path_tolerance: {G64: 0, rapid: 0}
"""  # noqa: E501 (one line per joint)
ONCE, ALL = gcodesim.Options(device="cpu"), gcodesim.Options(device="cpu", stop_all=True)


@dataclass(frozen=True)
class Case:
    """What raises a code: a program on the small machine, or the machine itself.

    Attributes:
        code: the code.
        program: blocks between the start and M30.
        unit: code that the start begins with.
        machine: texts of the machine file that are replaced.
        bodies: what the setup clamps, as YAML.
        options: of the check.
    """

    code: str
    program: str = ""
    machine: tuple[tuple[str, str], ...] = ()
    bodies: str = ""
    options: gcodesim.Options = ALL
    unit: str = "G21"


def block(role: str, x: float = 0.0, size: str = "20, 20", top: float = 50.0) -> str:
    """A body of the setup on the table."""
    box = f"{{size: [{size}, {top}], center: [{x}, 0, {top / 2}]}}"
    return f"block: {{link: X, role: {role}, box: {box}}}"


PAIR = ("work:", "pairs: [[Z, X]]\nwork:")
SQUARE = ("cylinder: {radius: 3, height: 40, center", "box: {size: [6, 6, 40], center")
NO_TOOL = (", for: all", "")
MESH = ("X: {box: {size: [100, 100, 20], center: [0, 0, -10]}}", "X: {mesh: table.stl}")
CONTACTS = [
    Case("GC101", "G0 Z-140", machine=(PAIR,)),
    Case("GC102", "G0 Z-80"),
    Case("GC103", "S1 M3\nG1 Z-65 F9000", bodies=block("part")),
    Case("GC104", "G0 Z-65", bodies=block("fixture")),
    Case("GC105", "G0 Z-25", bodies=block("part")),
    Case("GC106", "G0 Z-60", machine=(("work:", "start: {Z: -65}\nwork:"),), bodies=block("part")),
    Case(
        "GC107",
        "G0 X-100\nZ-65\nX100",
        bodies=block("fixture", size="2, 20"),
        options=gcodesim.Options(device="cpu", period_ps=10**12),
    ),
    *(Case("GC108", "G0 Z-12", bodies=block(role, 18.0, "2, 20", 120.0))
      for role in ("part", "stock", "fixture")),
]  # fmt: skip
DISTANCES_AND_LIMITS = [
    Case("GC201", "G0 Z-65", options=gcodesim.Options(device="cpu", clearance=10.0)),
    Case("GC202", "G0 Z-65\nX10", machine=(("G64: 0, rapid: 0", "G64: 8, rapid: 8"),)),
    Case("GC301", "G0 X400"),
    Case("GC302", "G0 A100"),
    Case("GC303", "G1 X100 F90000"),
]
LANGUAGE = [
    Case("GC401", "G0 X"),
    Case("GC402", "G123"),
    Case("GC403", "TRAORI"),
    Case("GC404", "G2 X10 Z5 R1 F100"),
    Case("GC405", "G1 X10"),
    Case("GC406", "#1=1/0"),
    Case("GC407", "GOTO 5"),
    Case("GC408", "G81 X10 F100"),
    Case("GC409", "G55"),
    Case("GC410", "G4 P-1"),
    Case("GC412", "M98 P77"),
    Case("GC420", "M123"),
    Case("GC421", "T5 M6", machine=(NO_TOOL,)),
    Case("GC422", "G41 D1 G1 X1 F100"),
    Case("GC423", "S1 M3\nG88 X1 Z-1 R1 P1 F100\nG80"),
    Case("GC424", "G0 X1\nX2\nX3", options=gcodesim.Options(device="cpu", max_blocks=3)),
    Case("GC425", "G0 X#7"),
    Case(
        "GC427",
        "G0 X-60\nG0 X60 Z-30",
        machine=(("no_point: units", "no_point: units, rapids: both"),),
        bodies=block("fixture"),
    ),
    Case("GC426", "G0 Z-65", machine=(SQUARE,), bodies=block("stock")),
    Case("GC430", "G1 X10 F100"),
    Case("GC431", "T1 M6\nG43 H2"),
    Case("GC432", "G0 X1.", unit=""),
]
POLICY = [
    Case("GC601", "G0 X1 (gcodesim: ignore nothing)"),
    Case("GC602", "G0 X1 (gcodesim: ignore GC201)"),
    Case("GC901", "G0 Z-80 (gcodesim: ignore GC102 reason=dummy)", options=ONCE),
]
MODELS = [
    Case("GC501", machine=(MESH,)),
    Case("GC502", machine=(("work:", "start: {Z: -80}\nwork:"),)),
    Case("GC503", machine=(MESH, ("units: mm", "units: m"))),
    Case("GC504", machine=(MESH,)),
]
POLE = """\
G21 G90 G94 G54
G43.4 H1
G1 X0 Y0 Z50 A-0.1 C0 F1000
X1 C180 F600
M30
"""
"""For the machine table_tilt: its table turns half round over a millimetre of the tip (GC304)."""


@pytest.fixture
def model(tmp_path: Path) -> Path:
    """The file of the small machine, beside an open mesh with a triangle without area."""
    table = shapes.box([100, 100, 20]) + [0, 0, -10]
    table = np.concatenate([table[1:], table[:1, [0, 0, 1]]])
    (tmp_path / "table.stl").write_bytes(stl_bytes(table))
    (tmp_path / "small.yaml").write_text(MACHINE)
    return tmp_path / "small.yaml"


def changed(case: Case, model: Path) -> Path:
    """The machine file of a case."""
    text = MACHINE
    for old, new in case.machine:
        assert text.count(old) == 1
        text = text.replace(old, new)
    model.write_text(text)
    return model


def raised(case: Case, model: Path) -> list[str]:
    """Codes of the findings of a program."""
    (model.parent / "a.nc").write_text(f"{case.unit} G90 G94 G54\n{case.program}\nM30\n")
    setup = model.parent / "setup.yaml"
    setup.write_text(f"machine: small.yaml\nbodies: {{{case.bodies}}}\n")
    machine = changed(case, model)
    result = gcodesim.check(model.parent / "a.nc", machine, setup=setup, options=case.options)
    return [finding.code for finding in result.findings]


@pytest.mark.parametrize("case", [*CONTACTS, *DISTANCES_AND_LIMITS, *LANGUAGE, *POLICY],
                         ids=lambda case: case.code)  # fmt: skip
def test_a_program_raises_the_code(case: Case, model: Path) -> None:
    assert case.code in raised(case, model)


@pytest.mark.parametrize("case", CONTACTS, ids=lambda case: case.code)
def test_a_contact_has_one_code(case: Case, model: Path) -> None:
    assert {code for code in raised(case, model) if code.startswith("GC1")} == {case.code}


@pytest.mark.parametrize("case", MODELS, ids=lambda case: case.code)
def test_a_model_raises_the_code(case: Case, model: Path) -> None:
    assert case.code in {f.code for f in lint(load_machine(str(changed(case, model))))}


def test_a_turn_near_the_pole_raises_its_code(tmp_path: Path) -> None:
    (tmp_path / "pole.nc").write_text(POLE)
    result = gcodesim.check(tmp_path / "pole.nc", "table_tilt", options=ONCE)
    assert "GC304" in [finding.code for finding in result.findings]


def test_the_table_holds_what_is_raised_and_nothing_else() -> None:
    cases = [*CONTACTS, *DISTANCES_AND_LIMITS, *LANGUAGE, *POLICY, *MODELS]
    assert {*(case.code for case in cases), "GC304"} == CODES.keys()
