"""The control that the programs of this folder run on."""

import pytest
from nc.controls import make_control

from gcodesim.nc.control.supply import ToolEntry, WorkOffset
from gcodesim.nc.program import ZERO

TOOLS = {
    1: ToolEntry(1, (0.0, 0.0, 50.0, 0.0, 0.0, 0.0), 10.0),
    2: ToolEntry(2, (1.0, 2.0, 75.5, 0.0, 0.0, 0.0), 6.0),
    3: ToolEntry(3, (0.0, 0.0, 100.0, 0.0, 0.0, 0.0), 8.0),
}

OFFSETS = {
    1: WorkOffset(ZERO),
    2: WorkOffset((100.0, 50.0, 10.0, 0.0, 0.0, 0.0)),
    3: WorkOffset((10.0, 0.0, 0.0, 0.0, 0.0, 0.0), rotation=90.0),
    101: WorkOffset((7.0, 8.0, 9.0, 0.0, 0.0, 0.0)),
}

REFERENCE = {"G28": dict.fromkeys("XYABC", 0.0) | {"Z": 100.0}, "G30": {"Z": 50.0}}


@pytest.fixture
def control():
    """Return a function that makes a control of a dialect, with any key or field replaced."""

    def make(dialect="fanuc", **fields):
        defaults = {"tools": TOOLS, "offsets": OFFSETS, "reference": REFERENCE}
        return make_control(dialect, **(defaults | fields))

    return make
