"""What is said about a pair that is too near: numbers that show why it is said."""

from __future__ import annotations

import pytest

from gcodesim.checking.flow import check_program
from gcodesim.checking.options import Options
from gcodesim.study.scenes import box, joint, machine


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
