"""Tolerances stand in constants.py; other decimal numbers at the top of a module are listed."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FILES = sorted(path.relative_to(ROOT).as_posix() for path in ROOT.glob("gcodesim/**/*.py"))

DATA = "data, no tolerance"
ROUNDING = "covers rounding: on the safe side of a bound by more than it can be rounded"
GOAL = "what a study is asked to reach"
SCENE = "a scene or case of a study"
LOOKS = "how a picture or page looks"

ELSEWHERE: dict[str, dict[str, str]] = {
    "interrupt": {"PATIENCE_S": "how long a command may tidy up; decides no verdict"},
    "batch/worker": {"PARENT_S": "how often a process looks around; decides no verdict"},
    "checking/flow": {"COMPILING_S": "when a user is told to wait"},
    "checking/replay": {"TOLERANCE": "of what is drawn; the check knows nothing of it"},
    "collision/baseline/paper": {"IN_PLANE": "part of the published method that is compared with"},
    "collision/bodies/reach": {"ARC_DEG": "fineness of a bound: larger is looser, never wrong"},
    "collision/bodies/tree_kernel": {
        "NEEDLE": "shape of a box; any box that holds its triangles is right",
        "FAR": "more than any coordinate",
        "EDGE_COST": "choice between boxes; any box that holds its triangles is right",
    },
    "collision/bounds/chords": {"RADIAN": "unit", "CHORD_ROUNDED_UP": ROUNDING},
    "collision/geometry/boxes": {"PLANE_ERROR": "proved bound of rounding, in unit roundoffs"},
    "collision/geometry/closest": {
        "TINY": "keeps a division from 0",
        "NO_WAY": "when another direction is tried; any direction gives a right bound",
        "GOOD_ENOUGH": "when a bound is no longer refined; any direction gives a right one",
    },
    "collision/geometry/poses": {"DEGREE": "unit"},
    "collision/geometry/predicates": {
        "ERROR_FACTOR": "CERTIFICATE_ULPS in unit roundoffs",
        "SNAP_INVERSE": "SNAP_MM, the other way",
        "SPLITTER": "splits a float64 in halves",
    },
    "collision/instants/contact": {"EDGE_PART": "of the point that is shown to people"},
    "collision/instants/nearest_triangles": {
        "UNDECIDED": "a mark, no distance",
    },
    "collision/instants/posed_pair": {"FARTHEST": "more than any distance"},
    "collision/search/first_reach": {"LEFT_OUT": "a mark, no distance"},
    "collision/search/depths": {
        "GOOD_TO_MM": "what is stated beside a depth",
        "FAR": "more than any distance",
        "TINY": "keeps a division from 0",
        "RAY": "a direction",
    },
    "collision/search/lasting": {"FLAT": ROUNDING},
    "collision/search/search_kernel": {"LEAST_LENGTH": "keeps a division from 0"},
    "machine/formats/imported": {"WRITTEN_AS_ZERO": "what is written as 0 in an imported file"},
    "machine/cutters": {"SAME_MM": "rounding of numbers of a file"},
    "machine/formats/libraries/freecad": {"UNITS": "units"},
    "machine/formats/libraries/fusion": {"MM_PER": "units"},
    "machine/formats/libraries/fusion_flutes": {"SAME_MM": "rounding of inches in a library"},
    "machine/formats/libraries/tool_t": {"MM_PER": "units"},
    "machine/formats/linuxcnc_ini": {
        "SLIDES": DATA,
        "LINEAR_UNITS": "units",
        "ANGULAR_UNITS": "units",
        "UNLIMITED": "LinuxCNC's way of saying that there is no limit",
        "DEFAULT_SPEED": "LinuxCNC's own default",
        "ROTATION_POINT": "LinuxCNC's own default",
        "MODULES": "LinuxCNC's own conventions",
    },
    "machine/formats/urdf": {
        "MM_PER_M": "unit",
        "UNITS": "units",
        "DEFAULT_SPEED": "assumed where the file gives none, and remarked",
        "SPHERE_STEP": "fineness of an outline drawn around a sphere, never smaller than it",
    },
    "machine/formats/vericut_mch": {
        "UNLIMITED": "VERICUT's own way to write no limit",
        "DEFAULT_SPEED": "assumed where the file gives none, and remarked",
        "DIRECTIONS": "unit vectors",
    },
    "machine/formats/vericut_tree": {"MM": "units"},
    "machine/generic_setup": {"SMALLEST_VISE": "size of an example"},
    "machine/mesh": {"MM_PER_UNIT": "units"},
    "machine/schema": {"ORIGIN": DATA, "UP": DATA},
    "machine/outlines": {
        "AROUND_STEP": "fineness of an outline drawn around a cutter",
        "INSIDE_STEP": "fineness of an outline drawn inside a cutter",
        "STRAIGHT": "rounding of points on a line",
    },
    "machine/placing": {
        "PARALLEL": "which side of an axis is up",
    },
    "machine/tree": {"SECONDS_PER_MINUTE": "unit"},
    "motion/blocks": {
        "CENTRIPETAL_SHARE": "how a control is taken to share its acceleration",
        "SMALLEST_RADIUS": "how slow a spiral becomes in its centre",
    },
    "motion/great_circle": {
        "LIMIT_STEP": "step of a limit beside a pole",
        "FREE_TRAVEL_MM": "used for the travel of a slide that has no limits",
    },
    "motion/lag": {
        "GOLDEN": "golden section",
        "LAG_ROUNDED_UP": ROUNDING,
        "COEFFICIENT_UP": ROUNDING,
    },
    "motion/path": {"CONSTANT_SPEED": DATA},
    "motion/profiles": {
        "RAMPS_TOGETHER": "how many moves are planned together",
        "ALIKE": "how many moves are planned together",
    },
    "motion/ramps": {
        "NEARLY": "when a further step would be below rounding",
        "ROUNDING": "unit roundoff",
        "ROUNDED_UP": ROUNDING,
        "STEEPEST": "where a cube would overflow",
    },
    "motion/stretching": {"SLOWEST_PART": "which of two codes names a slow block, both NOTED"},
    "motion/stretches": {"VANISHING_S": "half a tick of program time"},
    "nc/control/frames": {"UNIT": DATA, "ROUNDING": ROUNDING},
    "nc/control/moves": {"SQUARE_RAD": "decides whether a note is worth making (GC430)"},
    "nc/control/plain_run": {
        "NEARLY_HALF": "where a run of blocks ends; the slow way reads the next block",
        "EDGE_DEG": "where a run of blocks ends; the slow way reads the next block",
    },
    "nc/control/readings": {"ROWS": "what controls prescribe"},
    "nc/control/skips": {"SAME": "which positions are one and the same"},
    "nc/control/state": {"INCH": "unit", "LIMIT": "largest word of the language (GC410)"},
    "nc/control/tips": {"NO_TOOL": DATA},
    "nc/iso/checks": {"LAST": "place in the order of a block"},
    "nc/iso/cycles": {"SHIFTS": DATA},
    "nc/iso/expressions": {"ALWAYS": "what an operand without a value counts as"},
    "nc/iso/functions": {"SAME": "LinuxCNC's own rule of EQ and NE"},
    "nc/iso/lengths": {"OFFSETS": "a word of G10"},
    "nc/iso/listed_programs": {"PROBING_FEED": "decides the time alone"},
    "nc/iso/parameters": {"MODAL": "Fanuc's own numbers"},
    "nc/iso/predefined": {"PREDEFINED": "names that LinuxCNC keeps itself"},
    "nc/iso/scan": {"CODES": "G codes", "COOLANT": "M codes", "POWERS": "powers of ten"},
    "nc/iso/statements": {"MAX_VALUE": "keeps results of expressions finite (GC406)"},
    "nc/iso/words": {"_G_OF_GRBL": "G codes"},
    "nc/program": {"ZERO": DATA},
    "report/glb": {"LARGEST_TURN": LOOKS, "COLORS": LOOKS},
    "report/snapshot": dict.fromkeys(
        ["RING", "GHOST", "CLOSE_PART", "CLOSE_GAPS", "CLOSEST_PART", "LIGHT", "EDGE"], LOOKS
    ),
    "report/study_plot": {"WIDTH": LOOKS, "HEIGHT": LOOKS, "LEAST_S": LOOKS},
    "stock/line_cuts": {
        "FAR": "more than any coordinate",
        "ACROSS": "keeps a division from 0",
        "FLAT": "keeps a division from 0",
        **dict.fromkeys(["COVERED", "FREE", "CONVEX"], "a mark, no distance"),
    },
    "stock/race": {"ROUNDING": ROUNDING},
    "stock/raw_stock": {"TRIANGLES_PER_CELL": "fineness of a grid that finds triangles"},
    "stock/shapes_of_tools": {
        **dict.fromkeys(["COVERED", "FREE", "CONVEX"], "a mark, no distance"),
        "LEAST_BEND": ROUNDING,
    },
    "stock/sweeps": {
        "BALL_GOOD_TO": "added where it must lie outside",
        "MISSED": "a mark, no distance",
    },
    "stock/time_tree": {"NOWHERE": "more than any coordinate"},
    "stock/tool_items": {
        "LEAVES_MORE": ROUNDING,
        "LARGEST_TURN": "into how many items a move is cut; each tells how far it is off",
        "LEAST_TURN": ROUNDING,
    },
    "stock/workpiece": {
        "SHARES": "how fine is looked first; what stays open is told",
        "EVERYWHERE_MM": "more than any travel",
    },
    "study/accuracy": {
        "FRACTION_MARGIN": GOAL,
        "QUICK": SCENE,
        "FULL": SCENE,
        "FINE_MS": SCENE,
        "ALARM_SLACK_MM": GOAL,
    },
    "study/accuracy_goals": dict.fromkeys(
        ["SPEED_SCENE", "SPEED_ERROR_S", "TIMES_FASTER", "POSES", "POSES_TOLERANCE_MM"]
        + ["FEWER_AT_MS", "PROVED_CLEARANCE_SLACK_MM", "MOVED_PER_TICK_MM"],
        GOAL,
    ),
    "study/families": {"_GENERATORS": SCENE},
    "study/kernels/directed_bound": {"ROUNDED_DOWN": ROUNDING},
    "study/kernels/textbook": {"COPLANAR": "part of the textbook method that is compared with"},
    "study/leave_out_study": {"KINDS": SCENE},
    "study/paper_tables": {"CPU_US": "published figures", "GPU_US": "published figures"},
    "study/representation": dict.fromkeys(
        ["POSE_MM", "RADIUS", "ARM", "FACE", "RATE", "CYCLE_S"], SCENE
    ),
    "study/scenes": dict.fromkeys(
        ["CONSTANT", "ACCELERATED", "JERKED", "FEED", "FLIP_START_S", "FLIP_S", "SCENES"], SCENE
    ),
    "study/stability_drives": dict.fromkeys(["TAUS", "FASTEST", "SPEED", "EULER"], SCENE),
    "study/stability_scenes": dict.fromkeys(["FAR_MM", "HEAD_MM", "LOW_MM"], SCENE),
    "study/stability_turns": {"LEVER": SCENE},
    "study/triangle_study": {"MM_PER_UNIT": SCENE, "FALSE_ALARM_MM": GOAL, "TIMES_NAIVE": GOAL},
}
"""Module -> name of a number that is no tolerance of the check -> why it stands there."""


def numbers(file: str) -> Iterator[str]:
    """Names that a module gives a value with a decimal number in it."""
    for node in ast.parse((ROOT / file).read_text(encoding="utf-8")).body:
        targets = node.targets if isinstance(node, ast.Assign) else []
        targets = [node.target] if isinstance(node, ast.AnnAssign) else targets
        value = getattr(node, "value", None)
        if targets and value is not None and has_decimal(value):
            yield from (n.id for t in targets for n in ast.walk(t) if isinstance(n, ast.Name))


def has_decimal(value: ast.AST) -> bool:
    return any(isinstance(n, ast.Constant) and isinstance(n.value, float) for n in ast.walk(value))


@pytest.mark.parametrize("file", FILES)
def test_a_number_outside_the_constants_has_its_reason(file: str) -> None:
    if file == "gcodesim/constants.py":
        return
    module = file.removeprefix("gcodesim/").removesuffix(".py")
    assert sorted(numbers(file)) == sorted(ELSEWHERE.get(module, {}))


def test_every_reason_is_of_a_module_that_is_there() -> None:
    assert {f"gcodesim/{module}.py" for module in ELSEWHERE} <= set(FILES)
    assert all(reason for names in ELSEWHERE.values() for reason in names.values())


def test_every_constant_says_what_it_is_and_is_used() -> None:
    body = ast.parse((ROOT / "gcodesim/constants.py").read_text(encoding="utf-8")).body
    texts = [
        (ROOT / file).read_text(encoding="utf-8")
        for file in FILES
        if file != "gcodesim/constants.py"
    ]
    for node, after in zip(body, [*body[1:], None], strict=True):
        if not isinstance(node, ast.Assign):
            continue
        documented = isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant)
        assert documented, ast.unparse(node)
        for name in (n.id for t in node.targets for n in ast.walk(t) if isinstance(n, ast.Name)):
            assert any(name in text for text in texts), name
