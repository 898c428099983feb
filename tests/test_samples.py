"""Every sample earns what its first comment declares; the five-axis ones are what they claim."""

import importlib.util
import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from machine.five_axis import tip_position

from gcodesim.checking.flow import check_program
from gcodesim.checking.options import Options
from gcodesim.findings.codes import FAIL, INCONCLUSIVE
from gcodesim.machine.control_data import control_for
from gcodesim.machine.kinematics import world_from_link
from gcodesim.machine.loading import load_machine
from gcodesim.motion.planner import plan
from gcodesim.nc.interpret import interpret
from gcodesim.nc.lines import read_program

SAMPLES = Path(__file__).parents[1] / "samples"
PROGRAMS = sorted(SAMPLES.glob("*.nc"))
SHOWN = {
    "GC101",
    "GC102",
    "GC103",
    "GC104",
    "GC105",
    "GC106",
    "GC301",
    "GC302",
    "GC402",
    "GC405",
    "GC420",
    "GC427",
}
EXPECT = re.compile(r"\(expect: (PASS|FAIL|INCONCLUSIVE)((?: [\w-]+)*)\)")
PS_PER_MS = 1_000_000_000


@dataclass(frozen=True)
class Declaration:
    """What a sample declares; see samples/README.md."""

    verdict: str
    code: str | None
    pair: str | None
    block: str | None
    options: dict


def declaration(path):
    """The declaration of a sample; fails with what is wrong with it."""
    text = path.read_text(encoding="ascii")
    first = re.search(r"\([^()]*\)", text)
    match = EXPECT.fullmatch(first[0]) if first else None
    assert match, (
        f"{path.name}: the first comment must read like (expect: FAIL GC102 cutter-A N130)"
    )
    kinds = {"code": r"GC\d{3}", "block": r"N\d+", "pair": r"\w+-\w+"}
    given = dict.fromkeys(kinds)
    for word in match[2].split():
        kind = next((k for k, pattern in kinds.items() if re.fullmatch(pattern, word)), None)
        assert kind, f"{path.name}: {word!r} is no code, pair or block in {match[0]}"
        assert not given[kind], f"{path.name}: a second {kind} in {match[0]}"
        given[kind] = word
    assert bool(given["code"]) == (match[1] != "PASS"), f"{path.name}: a code, except with PASS"
    head = "".join(text.splitlines()[:3])
    options = dict(re.findall(r"\((machine|setup|tools|period|rapids): ([\w.]+)\)", head))
    return Declaration(match[1], options=options, **given)


def check(path, **chosen):
    """The result of a sample, checked with the options it declares."""
    declared = declaration(path)
    files = {k: str(SAMPLES / v) for k, v in declared.options.items() if k in ("setup", "tools")}
    machine = load_machine(declared.options.get("machine", "table_tilt"), **files)
    period_ms = float(declared.options.get("period", "0.1ms").removesuffix("ms"))
    machine = machine.with_readings(rapids=declared.options.get("rapids"))
    options = Options(**{"period_ps": round(period_ms * PS_PER_MS)} | chosen)
    return check_program(read_program(str(path)), path.name, machine, options)


def place(finding):
    """Code, pair and block of a finding, as a declaration writes them."""
    block = re.match(r"N\d+", finding.block)
    return finding.code, finding.pair and "-".join(finding.pair), block and block[0]


@pytest.mark.parametrize("path", PROGRAMS, ids=lambda path: path.stem)
def test_sample_earns_what_it_declares(path):
    declared, result = declaration(path), check(path)
    assert result.verdict == declared.verdict.lower(), result.findings
    if declared.verdict == "PASS":
        assert result.coverage.between_samples
        return
    effect = FAIL if declared.verdict == "FAIL" else INCONCLUSIVE
    finding, *later = (f for f in result.findings if f.effect == effect)
    assert all(f.continues for f in later)
    assert place(finding) == (declared.code, declared.pair, declared.block)
    if declared.code != "GC427":
        assert (result.first_contact is None) == (declared.pair is None or effect != FAIL)


def test_samples_show_every_phenomenon():
    declared = [declaration(path) for path in PROGRAMS]
    assert {d.code for d in declared} >= SHOWN
    assert {d.options.get("machine", "table_tilt") for d in declared} >= {
        "table_tilt",
        "head_tilt",
        "table_head",
        "nutating_head",
    }
    assert sum(d.verdict == "PASS" for d in declared) >= 4
    assert len(declared) >= 12


def test_samples_alone_step_over_the_shim_unless_they_are_finer():
    path = SAMPLES / "shim_between_samples.nc"
    coarse = check(path, method="exhaustive")
    assert (coarse.verdict, coarse.coverage.between_samples) == ("pass", False)
    finer = check(path, method="exhaustive", period_ps=PS_PER_MS // 100)
    (finding,) = (f for f in finer.findings if f.effect == FAIL)
    assert place(finding) == ("GC104", "cutter-shim", "N100")


@pytest.mark.parametrize(
    ("passes", "fails", "other"),
    [
        ("long_drill_shorter", "long_drill", []),
        ("five_axis_finish", "five_axis_crash", ["N1714 G0 Z15.0"]),
        ("rapid_straight", "rapid_dogleg", []),
    ],
)
def test_twins_differ_where_they_say(passes, fails, other):
    blocks = [
        [line for line in (SAMPLES / f"{name}.nc").read_text().splitlines() if line[0] == "N"]
        for name in (passes, fails)
    ]
    assert len(blocks[0]) == len(blocks[1])
    assert [b for a, b in zip(*blocks, strict=True) if a != b] == other


@pytest.mark.parametrize("name", ["tcp_follows_table", "tcp_spindle_into_table"])
def test_tool_centre_point_control_decides(name, tmp_path):
    """Read as a plain tool length, G43.4 gives the other verdict."""
    path = SAMPLES / f"{name}.nc"
    plain = tmp_path / path.name
    plain.write_text(path.read_text().replace("G43.4 H", "G43 H"))
    verdicts = {check(path).verdict, check(plain).verdict}
    assert verdicts == {"pass", "fail"}


@pytest.mark.parametrize("name", ["tilt_into_holder", "arc_into_trunnion"])
@pytest.mark.parametrize("time", ["acceleration", "jerk"])
def test_speed_profiles_move_the_contact_in_time_and_not_in_place(name, time):
    path = SAMPLES / f"{name}.nc"
    plain = check(path).first_contact
    machine = load_machine("table_tilt")
    joints = [replace(j, max_jerk=20 * j.max_acceleration) for j in machine.joints]
    machine = replace(machine, joints=tuple(joints), time=time)
    text = read_program(str(path))
    found, twin = (
        check_program(text, path.name, machine, Options(method=method)).first_contact
        for method in ("search", "exhaustive")
    )
    assert (found.sample, found.pair, found.triangles) == (twin.sample, twin.pair, twin.triangles)
    assert found.time_s > plain.time_s
    assert (found.pair, found.line) == (plain.pair, plain.line)
    for axis, position in plain.axes.items():
        assert found.axes[axis] == pytest.approx(position, abs=0.02)  # what a sample moves


@pytest.fixture(scope="module")
def generator():
    path = SAMPLES / "make_five_axis.py"
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_generator_writes_the_committed_bytes(generator, tmp_path):
    generator.main(tmp_path)
    written = sorted(path.name for path in tmp_path.iterdir())
    assert written == ["five_axis_crash.nc", "five_axis_finish.nc", "part.nc"]
    for name in written:
        assert (tmp_path / name).read_bytes() == (SAMPLES / name).read_bytes()


@pytest.fixture(scope="module")
def finishing():
    """Machine table_tilt, and the path and the interpretation of the finishing program."""
    machine = load_machine("table_tilt")
    text = read_program(str(SAMPLES / "five_axis_finish.nc"))
    meaning = interpret(text, control_for(machine, None, None, False))
    path, findings = plan(meaning.program, machine)
    assert findings == [], "no block asks an axis for more than its rapid rate"
    return machine, path, meaning


def test_finishing_program_is_of_real_size(finishing):
    machine, path, meaning = finishing
    simultaneous = np.ptp(np.stack([path.q0, path.q1]), axis=0) > 0.0
    assert meaning.blocks >= 3000
    assert np.count_nonzero(simultaneous.all(axis=1)) >= 3000
    swept = dict(zip(machine.axes, np.ptp(path.q1, axis=0), strict=True))
    assert swept["A"] > 60.0
    assert swept["C"] > 60.0
    assert 60.0 < path.duration_s < 120.0


@pytest.mark.parametrize("name", ["wall", "rim"])
def test_tip_and_tool_axis_land_where_the_part_wants_them(finishing, generator, name):
    """The post against the program's own kinematics: read back through interpreter and planner."""
    machine, path, meaning = finishing
    tips, tilt, azimuth = (values[1:] for values in getattr(generator, name)())
    begins = [number for number, line in enumerate(meaning.lines, 1) if "G93" in line]
    line = begins[("wall", "rim").index(name)]
    pieces = np.flatnonzero((path.line >= line) & (path.line < line + len(tips)))
    assert len(pieces) == len(tips)
    q = path.q1[pieces]
    part = np.linalg.inv(world_from_link(machine, q)["C"])
    tip = tip_position(machine, q, machine.tool.length)
    surface = np.array([0.0, 0.0, -40.0])  # the part frame begins on the table
    reached = np.einsum("nij,nj->ni", part[:, :3, :3], tip) + part[:, :3, 3] - surface
    assert np.abs(reached - tips).max() < 1e-3
    t, z = np.radians(tilt), np.radians(azimuth)
    wanted = np.column_stack([np.sin(t) * np.cos(z), np.sin(t) * np.sin(z), np.cos(t)])
    assert np.abs(part[:, :3, :3] @ machine.tool.axis - wanted).max() < 1e-5
