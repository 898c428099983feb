"""A skip move may touch part, stock and fixture with the stylus, and with nothing else."""

from dataclasses import replace

import pytest

import gcodesim
from gcodesim.checking.flow import check_program
from gcodesim.machine.loading import load_machine

OPTIONS = gcodesim.Options(device="cpu")
KNOWN = {"rapids": "linear", "length_after_reference": "kept", "length_change": "next_move"}
KNOWN |= {"no_point": "units", "spindle_at_stop": "stops"}
HEAD = "G21 G90 G17 G54\nT1 M6\nG0 X0 Y0\nG43 H1 Z100\n"
BODY = "{{link: C, role: {}, box: {{size: [40, 40, 20], center: [0, 0, -30]}}}}"
TOOL = """\
tools:
  - {number: 1, length: 120, flute: {diameter: 6, length: 50}, shank: [[8, 40], [8, 70]],
     holder: [[25, 0], [25, 40]]}
"""


@pytest.fixture(params=["one shape", "parts"])
def machine(request, tmp_path):
    def made(role):
        (tmp_path / "setup.yaml").write_text(f"bodies:\n  clamp: {BODY.format(role)}\n")
        (tmp_path / "tools.yaml").write_text(TOOL)
        tools = str(tmp_path / "tools.yaml") if request.param == "parts" else None
        machine = load_machine("table_tilt", setup=str(tmp_path / "setup.yaml"), tools=tools)
        return machine.with_readings(**KNOWN)

    return made


def check(machine, text, **options):
    return check_program(f"{HEAD}{text}M30\n", "part.nc", machine, replace(OPTIONS, **options))


@pytest.mark.parametrize("role", ["fixture", "part", "stock"])
def test_the_stylus_may_touch_what_is_clamped(machine, role):
    result = check(machine(role), "G31 Z15 F500\nG0 Z100\n")
    assert result.verdict == "pass"
    (note,) = [f for f in result.findings if f.meaning == "skip_touch"]
    assert (note.code, note.line, note.pair) == ("GC430", 5, ("cutter", "clamp"))
    assert result.first_contact is None


@pytest.mark.parametrize("options", [{}, {"method": "exhaustive"}, {"stop_all": True}])
def test_a_rapid_at_the_same_place_is_a_contact(machine, options):
    result = check(machine("fixture"), "G31 Z30 F500\nG0 Z100\nZ15\nZ100\n", **options)
    (contact,) = {f.line: f for f in result.findings if f.is_contact}.values()
    assert (result.verdict, contact.code, contact.line) == ("fail", "GC104", 7)


@pytest.mark.parametrize("role", ["fixture", "part"])
def test_holder_and_shank_still_count(machine, role):
    deep = check(machine(role), "G0 X22\nG31 Z-30 F500\nG0 Z100\n")
    codes = [f.code for f in deep.findings if f.is_contact]
    assert deep.verdict == "fail"
    assert codes[0] in {"GC102", "GC103", "GC104"}


def test_the_table_is_no_part_of_the_job(machine):
    result = check(machine("fixture"), "G0 X50 Y13\nG31 Z-5 F500\nG0 Z100\n")
    assert (result.verdict, result.findings[-1].code) == ("fail", "GC102")


def test_the_check_with_every_position_agrees(machine):
    text = "G31 Z15 F500\nG0 Z100\n"
    assert check(machine("fixture"), text, audit=True).verdict == "pass"
    assert check(machine("fixture"), text, method="exhaustive").verdict == "pass"
