"""What the canonical program tells of the spindle: whether it stands while a command runs."""

from __future__ import annotations

import pytest

from gcodesim.machine.control_data import control_for
from gcodesim.machine.loading import load_machine
from gcodesim.motion.planner import plan
from gcodesim.nc.control.interpreter import Interpretation
from gcodesim.nc.interpret import interpret


def read(program: str, dialect: str | None = None) -> Interpretation:
    """What the program means on a shipped machine."""
    control = control_for(load_machine("table_tilt"), dialect, None, False)
    return interpret(program, control, "a.nc")


def cuts(program: str, dialect: str | None = None) -> dict[int, bool]:
    """Line -> whether the flute may touch the part in its (last) move."""
    path, _ = plan(read(program, dialect).program, load_machine("table_tilt"))
    assert path.cuts is not None
    return dict(zip(path.line.tolist(), path.cuts.tolist(), strict=True))


@pytest.mark.parametrize(
    ("before", "cut"),
    [
        ("", False),
        ("M3 S100", True),
        ("M3 S100\nM5", False),
        ("M3 S100\nM19", False),
        ("M3 S100\nT1 M6", False),
        ("M5\nM77", True),
    ],
)
def test_a_feed_cuts_unless_the_spindle_is_known_to_stand(before: str, cut: bool) -> None:
    lines = before.count("\n") + 2
    assert cuts(f"{before}\nG21 G90 G94 G1 X5 F100\n", "fanuc")[lines] is cut


@pytest.mark.parametrize("code", ["M0", "M1"])
@pytest.mark.parametrize(
    ("dialect", "cut", "met"),
    [("linuxcnc", True, False), ("fanuc", False, True), ("haas", False, True)],
)
def test_a_stop_halts_the_spindle_as_the_control_says(
    code: str, dialect: str, cut: bool, met: bool
) -> None:
    """LinuxCNC lets it turn on; elsewhere it is a reading, of which the first way is taken."""
    text = f"M3 S100\n{code}\nG21 G90 G94 G1 X5 F100\nX9\nM30\n"
    assert cuts(text, dialect)[3] is cut
    readings = [(r.key, r.line, r.count) for r in read(text, dialect).readings]
    assert (("spindle_at_stop", 3, 2) in readings) is met


@pytest.mark.parametrize(
    "text",
    [
        "M3 S100\nM5\nM0\nM3\nG1 X5 F100\nM30",  # it stood already
        "M3 S100\nG1 X5 F100\nM0\nG0 X0\nM3\nG1 X5\nM30",  # no feed before M3
        "M0\nG1 X5 F100\nM30",  # never started
        "M3 S100\nM1\nT2 M6\nG1 X5 F100\nM30",  # M6 stops it
    ],
)
def test_a_stop_that_leaves_no_doubt_is_no_reading(text: str) -> None:
    readings = [r.key for r in read(f"G21 G90 G94\n{text}\n", "fanuc").readings]
    assert "spindle_at_stop" not in readings


def test_no_rapid_cuts() -> None:
    assert cuts("M3 S100\nG21 G90 G0 X5\nG1 Y5 F100\nG28 Z0\n") == {2: False, 3: True, 4: False}


def test_many_plain_blocks_keep_the_state_of_the_spindle() -> None:
    feeds = "".join(f"X{i}\n" for i in range(1, 400))
    found = cuts(f"M3 S100\nG21 G90 G94 G1 F100\n{feeds}M5\n{feeds}")
    assert all(found[line] for line in range(3, 402))
    assert not any(found[line] for line in range(404, 802) if line in found)


def test_the_tool_of_fine_boring_is_turned_away_from_the_wall() -> None:
    found = cuts(
        "M3 S100\nG21 G90 G94 G0 Z-5\nG98 G76 X5 Z-20 R-6 Q1 F100\nG80\nG1 X9 F100\nG0 X0\n"
    )
    assert found[5]
    assert not found[6]
