"""The check of a program with a stock: codes, sentences, coverage, and what stays open."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import pytest
from stock.milling import MILL, Program, boss, end_mill, last_pass, mill, slot

from gcodesim.checking.flow import check_program
from gcodesim.checking.options import Options
from gcodesim.checking.verdict import CheckResult
from gcodesim.errors import ModelError
from gcodesim.machine.model import Machine

OPTIONS = Options(device="cpu", threads=2)


def checked(program: Program, machine: Machine, options: Options = OPTIONS) -> CheckResult:
    return check_program(program.text, "p.nc", machine, options)


def codes(result: CheckResult) -> list[str]:
    return [f.code for f in result.findings if f.severity != "note"]


def test_a_slot_is_cut_and_left_without_a_finding() -> None:
    result = checked(slot().move(20, 50, -5).move(20, 50, 5), mill(end_mill()))
    assert result.verdict == "pass"
    (stock,) = result.coverage.stocks
    assert (stock.stock, stock.inset_mm, stock.undecided) == ("blank", 0.05, 0)
    assert stock.moves < 10 < stock.beams
    assert ("tool", "blank") in result.coverage.pairs


def test_a_rapid_through_what_is_cut_later_names_the_line_that_cuts_it() -> None:
    program = boss(cut_before=False)
    result = checked(program, mill(end_mill()))
    assert codes(result) == ["GC105"]
    finding = next(f for f in result.findings if f.code == "GC105")
    later = program.blocks.index("G1 F1000 X50.0000 Y50.0000 Z-5.0000") + 1
    assert f"cut away by line {later}, 2.17 s later" in finding.message
    assert "at least 2.9 mm deep in this block" in finding.message
    assert finding.block == "G0 X50.0000 Y50.0000 Z-3.0000"
    assert result.first_contact is not None
    assert result.first_contact.parts == ("flute", "blank")
    assert result.first_contact.point_mm is not None


def test_a_holder_in_the_stock_is_told_with_what_would_help() -> None:
    result = checked(last_pass(24.5), mill(end_mill(shank=4.0, stick=24.0)))
    assert codes(result) == ["GC103"]
    assert "no later cut takes that away" in next(
        f.message for f in result.findings if f.code == "GC103"
    )


def test_a_larger_inset_is_a_larger_tolerance() -> None:
    program, tool = last_pass(24.5), end_mill(shank=4.0, stick=24.0)
    assert checked(program, mill(tool, inset=1.1)).verdict == "pass"


def test_with_stop_all_every_event_is_a_finding() -> None:
    program = Program().move(20, 50, 5).move(20, 50, -5).move(40, 50, -5).move(40, 50, 5)
    result = checked(program, mill(end_mill()), replace(OPTIONS, stop_all=True))
    assert codes(result) == ["GC105"] * 3


def test_the_audit_races_with_nothing_left_out() -> None:
    for program in (boss(cut_before=True), boss(cut_before=False)):
        result = checked(program, mill(end_mill()), replace(OPTIONS, audit=True))
        assert not [f for f in result.findings if f.code == "GC901"]
        assert [f for f in result.findings if f.meaning == "audit_agrees"]


def test_what_comes_nowhere_near_is_left_out_and_said() -> None:
    result = checked(slot(), mill(end_mill()))
    assert any("moves at blank" in item.what for item in result.left_out)


def test_a_tool_of_one_shape_whose_flute_ends_nowhere_leaves_the_stock_as_it_is() -> None:
    mounted = (
        "mounted: {name: tool1, length: 100, for: all, cylinder: {radius: 5, height: 100, "
        "center: [0, 0, -50]}}"
    )
    text = MILL.replace("axis: [0, 0, 1]}\nwork", f"axis: [0, 0, 1], {mounted}}}\nwork")
    machine = replace(mill(end_mill(), machine=text), tools=None)
    result = checked(Program().move(50, 50, 5).move(50, 50, -5), machine)
    assert result.verdict == "inconclusive"
    assert "GC426" in codes(result)
    assert any(f.meaning == "stock_not_followed" for f in result.findings)


def test_a_flute_end_that_is_known_cuts_below_it_and_not_above() -> None:
    mounted = (
        "mounted: {name: tool1, length: 100, flute: 20, for: all, cylinder: {radius: 5, "
        "height: 100, center: [0, 0, -50]}}"
    )
    text = MILL.replace("axis: [0, 0, 1]}\nwork", f"axis: [0, 0, 1], {mounted}}}\nwork")
    machine = replace(mill(end_mill(), machine=text), tools=None)
    program = Program(["G21 G90 G94 G17", "T1 M6", "S5000 M3"])
    program.move(50, 50, 5 + 100).move(50, 50, 85, feed=300).move(80, 50, 85, feed=900)
    assert checked(program.move(80, 50, 105), machine).verdict == "pass"
    program.move(50, 50, 105).move(50, 50, 75, feed=300).move(50, 80, 75, feed=900)
    assert codes(checked(program, machine)) == ["GC103"]


@pytest.mark.parametrize("inset", ["0", "0.001", "-1", "x"])
def test_an_inset_that_cannot_be_is_refused(inset: str) -> None:
    with pytest.raises(ModelError, match="inset"):
        mill(end_mill(), inset=inset)  # type: ignore[arg-type]


def test_without_a_stock_nothing_of_the_race_is_loaded() -> None:
    program = (
        "import sys\n"
        "from gcodesim import check, Options\n"
        "check('samples/clear.nc', machine='table_tilt', options=Options(device='cpu'))\n"
        "assert not [name for name in sys.modules if name.startswith('gcodesim.stock')]\n"
    )
    subprocess.run([sys.executable, "-c", program], check=True)
