"""The table of codes agrees with itself, and drives the checks."""

from gcodesim.findings.codes import CODES
from gcodesim.findings.meanings import MEANINGS
from gcodesim.nc.control.modal import Modal, Motion
from gcodesim.nc.control.readings import ROWS
from gcodesim.nc.interpret import interpret
from gcodesim.nc.iso.actions import ACTIONS
from gcodesim.nc.iso.code_rows import AXIS_WORDS, Group, Order
from gcodesim.nc.iso.g_codes import motion_code
from gcodesim.nc.iso.words import OFFSET_WORDS, ONLY, TABLE, WORDS, codes_for, codes_of
from gcodesim.nc.program import Plane


def test_a_dialect_has_each_code_once():
    for dialect in ROWS:
        rows = [row for row in TABLE if not row.dialects or dialect in row.dialects.split()]
        own = [row for row in rows if row.name in ONLY.get(dialect, {r.name for r in rows})]
        assert len(codes_of(dialect)) == len(own)
        assert ONLY.get(dialect, frozenset()) <= {row.name for row in own}


def test_names_are_those_people_write():
    names = {row.name for row in TABLE}
    assert {"G0", "G43.4", "G59.3", "G90.1", "G187", "M6", "M30", "M428"} <= names


def test_a_refused_code_says_why_and_does_nothing():
    refused = [row for row in TABLE if row.refused]
    assert {"G66", "G76", "G13", "G43.1", "G150", "G136"} <= {row.name for row in refused}
    assert all(not row.action for row in refused)


def test_every_refused_code_stops_naming_code_and_line(control):
    for row in TABLE:
        if row.refused:
            dialect = row.dialects.split()[0] if row.dialects else "fanuc"
            meaning = interpret(f"G21\n{row.name}\nG0 X1\nM30", control(dialect))
            (finding,) = meaning.findings
            assert (finding.code, finding.line, meaning.stopped) == ("GC402", 2, True)
            assert finding.message.startswith(f"{row.name} ({row.refused})")
            assert meaning.unsupported == (f"{row.name} line 2",)


def test_two_codes_of_one_group_never_share_a_block(control):
    by_group = {}
    for row in codes_of("linuxcnc").values():
        by_group.setdefault(row.group, []).append(row.name)
    for group, names in by_group.items():
        if group is not Group.NONE and len(names) > 1 and "G80" not in names[:2]:
            meaning = interpret(f"{names[0]} {names[1]}", control("linuxcnc"))
            assert meaning.findings[0].meaning == "modal_conflict", names


def test_codes_run_in_the_order_of_the_language():
    order = [Order.FEED_MODE, Order.FEED, Order.TOOL, Order.CHANGE, Order.PLANE, Order.UNIT]
    order += [Order.LENGTH, Order.WORK_OFFSET, Order.DISTANCE, Order.ONE_SHOT, Order.MOTION]
    assert order == sorted(order)
    assert max(Order) is Order.STOP
    takers = {row.name for row in TABLE if AXIS_WORDS in row.words and row.order < Order.MOTION}
    assert takers == {
        *(
            "G5.1",
            "G7.1",
            "G10",
            "G22",
            "G51",
            "G54.4",
            "G92.1",
            "G100",
            "G107",
            "G28",
            "G30",
            "G43.1",
            "G50.1",
            "G51.1",
            "G52",
            "G68",
            "G68.2",
            "G68.3",
            "G68.4",
            "G92",
            "G268",
        )
    }


def test_listed_codes_replace_refused_ones_only():
    rows = codes_for(
        "fanuc", dict.fromkeys((1.0, 66.0, 68.2, 500.0), "none"), {6.0: "none", 900.0: "none"}
    )
    assert rows["G", 10].action == "straight"
    assert not rows["G", 660].refused
    assert ("G", 5000) in rows
    assert (rows["M", 60].action, rows["M", 9000].action) == ("change_tool", "listed_m")


def test_every_action_of_the_table_exists_and_every_action_is_in_the_table():
    named = {row.action for row in (*TABLE, *WORDS.values(), *OFFSET_WORDS.values()) if row.action}
    assert named | {"listed_g", "listed_m", "unknown_m"} == set(ACTIONS)


def test_meanings_name_codes_that_exist():
    assert {code for code, _ in MEANINGS.values()} <= CODES.keys()
    assert all(right and "\n" not in right for _, right in MEANINGS.values())


def test_the_start_state_is_that_of_the_language():
    modal = Modal()
    assert (modal.motion, modal.plane, modal.feed_mode) == (Motion.NONE, Plane.XY, 94)
    assert not modal.incremental
    assert motion_code(modal.motion) == 800
