"""The flute against fixture and part: exactly in every move, or where it does not cut."""

from __future__ import annotations

from pathlib import Path

import pytest

import gcodesim
from gcodesim.checking.flow import check_program
from gcodesim.machine.loading import load_machine

HEAD = "G21 G17 G40 G49 G80 G90 G94 G54\nG0 X0. Y-40.\nG43 H1 Z60.\n"
"""The mounted tool of table_tilt, 12 mm thick, beside a block from X20 on, its top at Z40."""

SETUP = """\
machine: table_tilt
bodies:
  block: {{link: C, role: {role}, box: {{size: [40, 40, 40], center: [40, 0, -20]}}}}
"""


def checked(
    folder: Path, blocks: str, role: str, dialect: str = "fanuc", **readings: str
) -> gcodesim.CheckResult:
    """Check blocks after HEAD against a block of one role on the table."""
    setup = folder / "setup.yaml"
    setup.write_text(SETUP.format(role=role))
    machine = load_machine("table_tilt", setup=str(setup))
    # What is open else, and is no matter here.
    machine = machine.with_readings(rapids="linear", length_change="next_move", **readings)
    options = gcodesim.Options(device="cpu", dialect=dialect)
    return check_program(f"{HEAD}{blocks}M30\n", "a.nc", machine, options)


def codes(result: gcodesim.CheckResult) -> list[str]:
    return [f.code for f in result.findings if f.severity != "note"]


MOVES = {
    "feed": ("S1 M3\n", "G1 Y40. F9000."),
    "feed with the spindle off": ("", "G1 Y40. F9000."),
    "rapid": ("S1 M3\n", "G0 Y40."),
    "arc": ("S1 M3\n", "G3 Y40. J40. F9000."),
}
"""Past the block: how the spindle is started, and the move."""


@pytest.mark.parametrize("move", MOVES)
@pytest.mark.parametrize(("depth", "wanted"), [(0.02, ["GC104"]), (-0.02, [])])
def test_the_flute_meets_a_fixture_exactly_in_every_move(tmp_path, move, depth, wanted):
    start, way = MOVES[move]
    reach = 40.0 if move == "arc" else 0.0
    result = checked(tmp_path, f"{start}G0 X{14 + depth - reach}\nZ30.\n{way}\n", "fixture")
    assert codes(result) == wanted


@pytest.mark.parametrize(("depth", "wanted"), [(0.02, []), (0.08, ["GC105"])])
def test_the_flute_is_smaller_against_a_part_in_a_rapid(tmp_path, depth, wanted):
    result = checked(tmp_path, f"S1 M3\nG0 X{14 + depth}\nZ30.\nY40.\n", "part")
    assert codes(result) == wanted


INTO = "G0 X0. Y0.\nZ30.\nS1 M3\n{stop}\nG1 X40. F9000.\n"
"""A stop, and a feed move into the block."""


@pytest.mark.parametrize("stop", ["M0", "M1"])
@pytest.mark.parametrize(
    ("dialect", "readings", "verdict", "wanted"),
    [
        ("linuxcnc", {}, "pass", []),
        ("fanuc", {}, "inconclusive", ["GC105", "GC427"]),
        ("haas", {}, "inconclusive", ["GC105", "GC427"]),
        ("fanuc", {"spindle_at_stop": "turns"}, "pass", []),
        ("fanuc", {"spindle_at_stop": "stops"}, "fail", ["GC105"]),
    ],
)
def test_a_feed_after_a_stop_cuts_where_the_spindle_turns_on(
    tmp_path, stop, dialect, readings, verdict, wanted
):
    result = checked(tmp_path, INTO.format(stop=stop), "part", dialect, **readings)
    assert result.verdict == verdict
    assert sorted(codes(result)) == wanted
    assert all("spindle_at_stop" in f.message for f in result.findings if f.code == "GC427")


def test_a_stop_is_no_reading_where_nothing_can_be_cut(tmp_path):
    result = checked(tmp_path, INTO.format(stop="M0").replace("X40.", "X2."), "fixture")
    assert result.verdict == "pass"
    assert result.coverage.readings == ()


@pytest.mark.parametrize("code", ["M5", "M19", "M6 T1"])
def test_what_stops_the_spindle_on_every_control_is_no_reading(tmp_path, code):
    result = checked(tmp_path, INTO.format(stop=code), "part", tool_change="stays")
    assert (result.verdict, codes(result)) == ("fail", ["GC105"])


def test_after_a_code_of_the_builders_the_spindle_may_turn(tmp_path):
    result = checked(tmp_path, INTO.format(stop="M5\nM77"), "part", m_codes={77.0: "none"})
    assert (result.verdict, codes(result)) == ("pass", [])
