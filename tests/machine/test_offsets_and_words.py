"""Offsets that nobody gave, programs of one number, and words that are never left out."""

from __future__ import annotations

from pathlib import Path

import pytest

from gcodesim.api import check
from gcodesim.checking.options import Options
from gcodesim.errors import ModelError
from gcodesim.machine.loading import load_machine

MACHINE = """
name: plate
dialect: fanuc
links:
  bed: {box: {size: [100, 100, 10], center: [0, 0, -5]}}
  Z: {box: {size: [40, 40, 40], center: [0, 0, 220]}}
joints:
  Z: {type: linear, parent: bed, child: Z, axis: [0, 0, 1], limits: [-200, 200], rapid: 9000}
tool: {link: Z, gauge_point: [0, 0, 200], axis: [0, 0, 1], mounted: {name: cutter, length: 100,
       for: all, cylinder: {radius: 5, height: 100, center: [0, 0, 150]}}}
work: {link: bed, offsets: {G54: {Z: -60}}}
"""
HEAD, AWAY = "G21 G90 G54\nM3 S1000\n", "G1 Z-20. F1000.\n"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "m.yaml").write_text(MACHINE)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def checked(text: str, **files: str):
    Path("p.nc").write_text(text)
    result = check("p.nc", "m.yaml", options=Options(device="cpu"), **files)
    return result.verdict, {finding.meaning for finding in result.findings}


def test_a_setup_replaces_only_the_axes_it_names() -> None:
    Path("s.yaml").write_text("offsets: {G54: {X: 5}, G55: {Z: 1}}\n")
    machine = load_machine("m.yaml", setup="s.yaml")
    assert machine.offsets[1].value == (5.0, 0.0, -60.0, 0.0, 0.0, 0.0)
    assert machine.offsets[2].value == (0.0, 0.0, 1.0, 0.0, 0.0, 0.0)


def test_g54_that_nobody_gave_is_open_where_it_is_in_use() -> None:
    assert checked(f"{HEAD}{AWAY}M30\n")[0] == "pass"
    Path("m.yaml").write_text(MACHINE.replace(", offsets: {G54: {Z: -60}}", ""))
    verdict, meanings = checked(f"{HEAD}{AWAY}M30\n")
    assert verdict == "inconclusive"
    assert "offset_assumed" in meanings
    assert checked("G21 G90\nM3 S1000\nG53 G0 Z-20.\nM30\n")[0] == "pass", "not in use"
    assert checked(f"{HEAD}G10 L2 P1 Z-1.\n{AWAY}M30\n")[0] == "pass", "the program gives it"


def test_two_programs_of_one_number_are_said_where_one_is_called() -> None:
    twice = "M98 P2\nM30\nO2\nG1 Z5. F1000.\nM99\nO2\nG1 Z-45. F1000.\nM99\n"
    verdict, meanings = checked(HEAD + twice)
    assert verdict == "inconclusive"
    assert "subprogram_twice" in meanings


def test_files_of_two_names_of_one_program_must_hold_the_same() -> None:
    up, down = f"{AWAY}M99\n", "G1 Z-45. F1000.\nM99\n"
    for second, verdict in ((up, "pass"), (down, "inconclusive")):
        Path("O2.nc").write_text(up)
        Path("O0002.nc").write_text(second)
        seen, meanings = checked(f"{HEAD}M98 P2\nM30\n")
        assert seen == verdict
        assert ("subprogram_twice" in meanings) == (second == down)


def test_a_file_that_says_another_number_inside_is_not_the_program_called() -> None:
    for inside, verdict in (("O2\n", "pass"), ("", "pass"), ("O7\n", "inconclusive")):
        Path("O2.nc").write_text(f"{inside}{AWAY}M99\n")
        seen, meanings = checked(f"{HEAD}M98 P2\nM30\n")
        assert seen == verdict
        assert ("subprogram_other_number" in meanings) == (inside == "O7\n")


@pytest.mark.parametrize(("letter", "said"), [("Z", "is an axis"), ("P", "says what is run")])
def test_words_that_move_or_call_are_never_ignored(letter: str, said: str) -> None:
    Path("m.yaml").write_text(f"{MACHINE}control: {{ignore_words: [E, {letter}]}}\n")
    with pytest.raises(ModelError, match=f"control.ignore_words: {letter} {said}"):
        load_machine("m.yaml")
