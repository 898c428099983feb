"""Checked pairs: the default set, named pairs, exceptions, and what a setup adds."""

import pytest

from gcodesim.errors import ModelError
from gcodesim.machine.loading import load_machine


def names(machine):
    return [pair.name for pair in machine.pairs]


def test_default_pairs_less_neighbours(tiny):
    # neighbours left out: Y-X, X-A, A-C (and bed, which has no shape); cutter rides on Z
    assert names(load_machine(str(tiny / "tiny.yaml"))) == [
        "A-Y", "A-Z", "C-X", "C-Y", "C-Z",
        "cutter-A", "cutter-C", "cutter-X", "cutter-Y", "X-Z", "Y-Z",
    ]  # fmt: skip


def test_a_tool_meets_the_link_below_its_own(changed):
    """Only links are neighbours: the spindle head slides on the bed, the tool does not."""
    pairs = names(load_machine(changed("bed: {}", "bed: {box: {size: [9, 9, 9]}}")))
    assert "cutter-bed" in pairs
    assert "bed-Z" not in pairs


def test_named_pairs_keep_their_order_and_are_sorted(changed):
    path = changed("name: tiny", "name: tiny\npairs:\n- [Z, X]\n- {links: [Z, C], clearance: 2, "
                   "severity: error}\n- [cutter, Y]\n- [C, cutter]\n- [Z, A.cradle]")  # fmt: skip
    machine = load_machine(path)
    assert names(machine) == ["C-cutter", "cutter-Y", "Z-A", "Z-C", "Z-X"]
    by_name = {pair.name: pair for pair in machine.pairs}
    assert (by_name["Z-C"].clearance, by_name["Z-C"].severity) == (2.0, "error")
    assert (by_name["Z-A"].parts_a, by_name["Z-A"].parts_b) == (None, ("cradle",))


def test_allow_takes_parts_out(changed):
    """Of two bodies only what both sides name is taken out; the rest stays, in one or two pairs."""
    old = "X: {mesh: meshes/X.stl}"
    new = "X: {parts: [{name: p, box: {size: [9, 9, 9]}}, {name: q, box: {size: [9, 9, 9]}}]}"
    allow = "name: tiny\nallow: [{links: [X.p, Z], reason: covers}]"
    changed(old, new)
    machine = load_machine(changed("name: tiny", allow))
    left = [(p.parts_a, p.parts_b) for p in machine.pairs if p.name == "X-Z"]
    assert left == [(("q",), None)]
    both = "C: {parts: [{name: r, box: {size: [9, 9, 9]}}, {name: s, box: {size: [9, 9, 9]}}]}"
    changed("C: {cylinder: {radius: 75, height: 20, center: [0, 0, 30]}}", both)
    machine = load_machine(changed("[X.p, Z]", "[C.s, X.p]"))
    left = [(p.parts_a, p.parts_b) for p in machine.pairs if p.name == "C-X"]
    assert left == [(("r",), None), (("s",), ("q",))]
    with pytest.raises(ModelError, match=r"X has no part 'z'; valid: p, q"):
        load_machine(changed("X.p]", "X.z]"))


def test_allow_takes_pairs_out(changed):
    path = changed("name: tiny", "name: tiny\nallow: [{links: [Z, Y], reason: way covers}]")
    machine = load_machine(path)
    assert "Y-Z" not in names(machine)
    assert machine.allowed == (("Z", "Y", "way covers"),)


@pytest.mark.parametrize(
    ("pairs", "text"),
    [
        ("[Z, W]", "no body named 'W'"),
        ("[Z, bed]", "no body named 'bed' has a shape"),
        ("[Z, Z]", "paired with itself"),
        ("[Z, X], [X, Z]", "paired twice, first in line 2"),
        ("[Z, A.W]", "A has no part 'W'; valid: cradle"),
        ("[Z]", "required"),
        ("Z", r"write a pair as \[a, b\]"),
        ("{links: [Z, X], clearence: 1}", "did you mean 'clearance'"),
    ],
)
def test_wrong_pairs(changed, pairs, text):
    path = changed("name: tiny", f"name: tiny\npairs: [{pairs}]")
    with pytest.raises(ModelError, match=text) as caught:
        load_machine(path)
    assert caught.value.line == 2


SETUP = """\
bodies:
  vise: {link: C, role: fixture, box: {size: [60, 40, 20]}}
  blank: {link: C, role: stock, box: {size: [30, 20, 10]}}
"""


def test_setup_pairs_join_named_pairs(tiny, changed):
    (tiny / "setup.yaml").write_text(SETUP)
    (tiny / "tools.yaml").write_text("tools: [{number: 1, length: 9}]")
    machine = load_machine(
        changed("name: tiny", "name: tiny\npairs: [[cutter, C]]"),
        setup=str(tiny / "setup.yaml"),
        tools=str(tiny / "tools.yaml"),
    )
    assert names(machine) == [
        "A-blank", "A-vise", "blank-X", "blank-Y", "blank-Z",
        "cutter-blank", "cutter-C", "cutter-vise", "vise-X", "vise-Y", "vise-Z",
    ]  # fmt: skip
    by_name = {pair.name: pair for pair in machine.pairs}
    assert by_name["cutter-blank"].parts_a == ("shank", "holder")
    assert by_name["cutter-vise"].parts_a is None
    assert machine.unchecked_by_rule == (
        "cutter-blank: flute against stock is cutting, not collision, while it is fed and turns; "
        "else the flute is checked, 0.05 mm smaller",
    )
    (flute,) = machine.cutting
    assert (flute.name, flute.parts_a) == ("cutter-blank", ("cutter", "flute"))


def test_a_tool_of_one_shape_is_not_checked_against_stock(tiny):
    (tiny / "setup.yaml").write_text(SETUP)
    machine = load_machine(str(tiny / "tiny.yaml"), setup=str(tiny / "setup.yaml"))
    assert "cutter-blank" not in names(machine)
    assert "one shape" in machine.unchecked_by_rule[0]


def test_a_tool_without_any_shape_makes_no_pair(tiny):
    text = (tiny / "tiny.yaml").read_text().splitlines(keepends=True)
    (tiny / "tiny.yaml").write_text("".join(line for line in text if "mounted:" not in line))
    machine = load_machine(str(tiny / "tiny.yaml"))
    assert not [pair for pair in machine.pairs if "tool" in (pair.a, pair.b)]
    assert machine.unchecked_by_rule[0].startswith("tool-A: tool has no shape")


def test_allow_takes_parts_out_and_leaves_the_others(tmp_path):
    """A vise that stands in the way of the cradle by design, on a table that must not."""
    boxes = "[{name: table, box: {size: [9, 9, 9]}}, {name: vise, box: {size: [9, 9, 9]}}]"
    text = (
        f"name: parts\nlinks: {{bed: {{parts: {boxes}}}, X: {{}}, Z: {{parts: {boxes}}}}}\n"
        "joints:\n"
        "  X: {type: linear, parent: bed, child: X, axis: [1, 0, 0], rapid: 1000}\n"
        "  Z: {type: linear, parent: X, child: Z, axis: [0, 0, 1], rapid: 1000}\n"
    )
    path = tmp_path / "m.yaml"

    def left(links):
        path.write_text(f"{text}allow: [{{links: {links}, reason: by design}}]\n")
        pairs = load_machine(str(path)).pairs
        every = ("table", "vise")
        return {(a, b) for p in pairs for a in p.parts_a or every for b in p.parts_b or every}

    both = {(a, b) for a in ("table", "vise") for b in ("table", "vise")}
    assert left("[bed, Z]") == set()
    assert left("[bed.vise, Z]") == {("table", "table"), ("table", "vise")}
    assert left("[Z.vise, bed]") == {("table", "table"), ("vise", "table")}
    assert left("[bed.vise, Z.table]") == both - {("vise", "table")}
    with pytest.raises(ModelError, match="bed has no part 'clamp'"):
        left("[bed.clamp, Z]")
