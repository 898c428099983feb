"""A small table-tilting machine of primitives and one binary STL, written into tmp_path."""

from collections.abc import Callable
from pathlib import Path

import pytest
from machine.stl import stl_bytes

from gcodesim.machine import shapes

TINY = """\
name: tiny
links:
  bed: {}
  Y: {box: {size: [400, 300, 50], center: [0, 0, -200]}}
  X: {mesh: meshes/X.stl}
  A: {parts: [{name: cradle, box: {size: [200, 100, 20]}}]}
  C: {cylinder: {radius: 75, height: 20, center: [0, 0, 30]}}
  Z: {revolve: [[40, 300], [60, 400]]}
joints:
  Y: {type: linear, parent: bed, child: Y, axis: [0, -1, 0], limits: [-200, 200], rapid: 24000}
  X: {type: linear, parent: Y, child: X, axis: [-3, 0, 0], limits: [-250, 250], rapid: 12000}
  A: {type: rotary, parent: X, child: A, axis: [-1, 0, 0], point: [0, 5, 7], limits: [-120, 30], rapid: 9000}
  C: {type: rotary, parent: A, child: C, axis: [0, 0, -1], point: [1, 2, 0], rapid: 18000, wrap: shortest}
  Z: {type: linear, parent: bed, child: Z, axis: [0, 0, 1], limits: [-400, 100], rapid: 24000}
tool:
  link: Z
  gauge_point: [0, 0, 300]
  mounted: {name: cutter, revolve: [[5, 200], [5, 300]], length: 100, for: all}
work: {link: C, offsets: {G54: {Z: 40, R: 10}, G54.1 P7: {X: 1}}}
reference: {G28: {Z: 100}}
start: {Z: 100}
"""  # noqa: E501 (one line per joint)


@pytest.fixture
def tiny(tmp_path: Path) -> Path:
    """The folder with tiny.yaml and its mesh."""
    (tmp_path / "meshes").mkdir()
    saddle = shapes.box([300, 200, 40], [0, 0, -100])
    (tmp_path / "meshes" / "X.stl").write_bytes(stl_bytes(saddle))
    (tmp_path / "tiny.yaml").write_text(TINY)
    return tmp_path


@pytest.fixture
def changed(tiny: Path) -> Callable[[str, str], str]:
    """Function that replaces one text of tiny.yaml and returns the path of the file."""

    def change(old: str, new: str) -> str:
        text = (tiny / "tiny.yaml").read_text()
        assert text.count(old) == 1, f"{old!r} must occur once"
        (tiny / "tiny.yaml").write_text(text.replace(old, new))
        return str(tiny / "tiny.yaml")

    return change
