"""Policy: what may be ignored, and that ignoring never makes checked what was not."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from reporting import LIMIT, NEAR, NOTE, PASSED, TOUCH, UNKNOWN, finding

from gcodesim.checking.verdict import LEVELS, decide
from gcodesim.cli import main
from gcodesim.errors import UsageError
from gcodesim.findings.codes import CODES, CONTAINMENT_UNDECIDED, FAIL, FORMER_CODES, Finding
from gcodesim.policy.baseline import Baseline, read_baseline
from gcodesim.policy.comments import comments_in
from gcodesim.policy.policy import Policy
from gcodesim.policy.rules import parse_rule

SAMPLES = Path(__file__).parents[1] / "samples"


def judged(*findings: Finding, text: str = "", stop_all: bool = True, **policy: object):
    """The result of a check with these findings, under a policy."""
    if "ignore" in policy:
        policy["ignore"] = tuple(parse_rule(rule, "--ignore") for rule in policy["ignore"])
    result = replace(PASSED, findings=findings)
    return Policy(**policy).apply(result, text, stop_all=stop_all)


def codes(result) -> list[str]:
    return [f.code for f in result.counted]


@pytest.mark.parametrize("code", CODES)
@pytest.mark.parametrize("how", ["comment", "rule", "both"])
def test_ignoring_never_makes_checked_what_was_not(code: str, how: str) -> None:
    """For every code: only contacts, clearances, limits and notes can be ignored, ever."""
    comment = f"(gcodesim: ignore {code} reason=because)"
    given = finding(code, block=f"N6 G1 {comment}" if how != "rule" else "N6 G1")
    family = [f"{code[:3]}=because"] if how != "comment" and code[2] != "9" else []
    result = judged(given, text=f"\n\n\n\n\n{given.block}", ignore=family)
    noted = ("GC430", "GC431", "GC432", "GC602")
    ends = (code[2] in "469" and code not in noted) or code == "GC503"
    assert bool(result.ignored) == (not ends)
    assert (result.verdict == "pass") == (not ends)
    if ends and how != "rule":
        assert "GC601" in codes(result)


def test_an_open_mesh_is_ignored_unless_it_leaves_a_question_open() -> None:
    mesh, question = finding("GC501"), finding("GC501", meaning=CONTAINMENT_UNDECIDED)
    assert judged(mesh, ignore=["GC501=thin sheet"]).verdict == "pass"
    assert judged(mesh, question, ignore=["GC501=thin sheet"]).verdict == "inconclusive"


def test_a_contact_needs_a_reason() -> None:
    with pytest.raises(UsageError, match="never ignored without a reason"):
        parse_rule("GC102", "--ignore")
    for wish in ("ignore GC102", "ignore GC1 reason="):
        touch = replace(TOUCH, block=f"N6 G1 X0 (gcodesim: {wish})")
        result = judged(touch)
        assert result.verdict == "fail"
        assert codes(result)[0] == "GC102"
    assert codes(judged(replace(TOUCH, block="N6 (gcodesim: ignore GC1)"))) == ["GC102", "GC601"]
    assert codes(judged(TOUCH, select=("GC3",))) == ["GC102"]


def test_what_follows_an_ignored_contact_must_have_been_looked_at() -> None:
    stopped = judged(TOUCH, ignore=["GC102=dummy"], stop_all=False)
    assert stopped.verdict == "inconclusive"
    assert [f.meaning for f in stopped.counted] == ["stopped_at_ignored"]
    looked = judged(TOUCH, ignore=["GC102=dummy"])
    assert looked.verdict == "pass"
    assert "the move in which an ignored contact ends" in looked.coverage.uncertified[0]
    other = replace(TOUCH, code="GC104", line=9)
    assert judged(TOUCH, other, ignore=["GC102=dummy"]).verdict == "fail"


def test_select_drops_only_what_may_be_ignored() -> None:
    result = judged(TOUCH, UNKNOWN, NEAR, LIMIT, NOTE, select=("GC3",))
    assert codes(result) == ["GC102", "GC402", "GC301"]
    assert judged(NEAR, LIMIT, NOTE, select=("GC2",)).verdict == "pass"


@pytest.mark.parametrize(
    ("given", "verdicts"),
    [
        # in the order of LEVELS: contact, error, warning, note
        (TOUCH, ["fail"] * 4),
        (LIMIT, ["pass", "fail", "fail", "fail"]),
        (replace(NEAR, severity="error"), ["pass", "fail", "fail", "fail"]),
        (NEAR, ["pass", "pass", "fail", "fail"]),
        (NOTE, ["pass", "pass", "pass", "fail"]),
        (UNKNOWN, ["inconclusive"] * 4),
        (finding("GC405"), ["inconclusive", "fail", "fail", "fail"]),
        (finding("GC420"), ["inconclusive"] * 4),
        (finding("GC601"), ["fail"] * 4),
    ],
)
def test_fail_on(given: Finding, verdicts: list[str]) -> None:
    assert [decide([given], 1, 1, level) for level in LEVELS] == verdicts
    assert [judged(given, fail_on=level).verdict for level in LEVELS] == verdicts


def test_a_stricter_level_never_makes_a_verdict_milder() -> None:
    order = ["fail", "inconclusive", "pass"]
    for code in CODES:
        for severity in ("error", "warning", "note"):
            given = finding(code, severity=severity)
            ranks = [order.index(decide([given], 1, 1, level)) for level in LEVELS]
            assert ranks == sorted(ranks, reverse=True), code
            assert (ranks[0] == 2) <= (given.effect != FAIL or not given.leaves_unchecked)


@pytest.mark.parametrize(
    ("comment", "prefixes", "reason"),
    [
        ("(gcodesim: ignore GC201)", ["GC201"], ""),
        ("(GCODESIM: IGNORE GC201, GC3 REASON=GAUGE BLOCK)", ["GC201", "GC3"], "GAUGE BLOCK"),
        ("; gcodesim: ignore gc2 reason = a = b", ["GC2"], "a = b"),
        ("(x)(gcodesim:ignore GC201 GC202 reason=r)", ["GC201", "GC202"], "r"),
    ],
)
def test_comments(comment: str, prefixes: list[str], reason: str) -> None:
    (read,) = comments_in(f"G1\r\nG0 X1\rG0 {comment}\n")
    assert read.line == 3
    assert [rule.prefix for rule in read.rules] == prefixes
    assert {rule.mark.reason for rule in read.rules} == {reason}


@pytest.mark.parametrize("text", ["ignor GC201", "ignore", "ignore GC7", "ignore 201", ""])
def test_a_comment_that_cannot_be_read_is_an_error(text: str) -> None:
    result = judged(NEAR, text=f"(gcodesim: {text})")
    assert result.verdict == "fail"
    (wrong,) = (f for f in result.counted if f.code == "GC601")
    assert (wrong.file, wrong.line, wrong.meaning) == (PASSED.program, 1, "ignore_unreadable")


def test_a_comment_that_ignores_nothing_is_told() -> None:
    result = judged(text="G1\nG0 X1 (gcodesim: ignore GC201)")
    assert result.verdict == "pass"
    assert [(f.code, f.line) for f in result.counted] == [("GC602", 2)]


@pytest.mark.parametrize(
    ("rule", "said"),
    [
        ("GC7", "no code begins so"),
        ("201", "no code begins so"),
        ("GC", "no code begins so"),
        ("GC402=why", "cannot be ignored"),
        ("GC9=why", "cannot be ignored"),
        ("GC1", "never ignored without a reason"),
    ],
)
def test_rules_that_make_no_sense_are_refused(rule: str, said: str) -> None:
    with pytest.raises(UsageError, match=said):
        parse_rule(rule, "--ignore")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the collision sample, and the same with two collisions."""
    text = (SAMPLES / "tilt_into_holder.nc").read_text()
    again = text.replace("N150 A0.\n", "N150 A0.\nN151 G0 Z40.\nN152 G1 A-30. F2000.\nN153 A0.\n")
    assert again != text
    (tmp_path / "once.nc").write_text(text)
    (tmp_path / "twice.nc").write_text(again)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def check(*args: str) -> Result:
    # With the dialect named there is no note about it, which a baseline would take in too.
    given = ["--machine", "table_tilt", "--dialect", "fanuc", "--device", "cpu"]
    return CliRunner().invoke(main, ["check", *given, *args])


def report(*args: str) -> dict:
    return json.loads(check("--format", "json", *args).stdout)


def ignoring(path: Path, block: str, comment: str) -> None:
    path.write_text(path.read_text().replace(f"{block}\n", f"{block} ({comment})\n"))


def test_a_later_contact_is_found_behind_an_ignored_one(folder: Path) -> None:
    ignoring(folder / "twice.nc", "N130 A-40. F2000.", "gcodesim: ignore GC102 reason=dummy arm")
    seen = report("twice.nc", "--stop", "all")
    assert seen["verdict"] == "fail"
    (touch,) = (f for f in seen["findings"] if f["severity"] == "error")
    assert (touch["code"], touch["block"]) == ("GC102", "N152 G1 A-30. F2000.")
    assert [f["ignored"]["reason"] for f in seen["suppressed"]] == ["dummy arm"]
    stopped = report("twice.nc")
    assert stopped["verdict"] == "inconclusive"
    assert "stopped_at_ignored" in [f.get("meaning") for f in stopped["findings"]]


def test_pairs_that_touch_at_the_same_instant_are_findings_each(folder: Path) -> None:
    """Ignoring the first of two contacts of one instant must leave the other."""
    (folder / "setup.yaml").write_text(
        "start: {X: 0, Y: 0, Z: -320, A: 0, C: 0}\nbodies:\n"
        "  clamp: {link: C, role: fixture, box: {size: [120, 80, 60], center: [0, 0, -10]}}\n"
        "  shell: {link: C, role: fixture, box: {size: [300, 300, 300], center: [0, 0, 60]}}\n"
    )
    (folder / "still.nc").write_text("G21 G90\nG0 Z-310\nM30\n")
    seen = report("still.nc", "--setup", "setup.yaml", "--stop", "all")
    pairs = [tuple(f["pair"]) for f in seen["findings"] if f["code"] == "GC106"]
    assert len(pairs) == len(set(pairs))
    assert {("clamp", "cutter"), ("cutter", "shell")} <= {tuple(sorted(pair)) for pair in pairs}


def test_baseline_from_making_it_to_taking_it_out(folder: Path) -> None:
    at = ("--baseline", "accepted.json", "--stop", "all")
    assert check("twice.nc", "--baseline", "accepted.json").exit_code == 2
    made = check("twice.nc", *at, "--update-baseline")
    assert made.exit_code == 1, "contacts wait for a reason"
    assert "accepted.json: 2 added, 0 removed" in made.stderr
    entries = json.loads((folder / "accepted.json").read_text())
    assert [e["code"] for e in entries["entries"]] == ["GC102", "GC102"]
    refused = report("twice.nc", *at)
    assert sorted({f["code"] for f in refused["findings"]} & {"GC102", "GC601"}) == [
        "GC102",
        "GC601",
    ]

    for entry in entries["entries"]:
        entry["reason"] = "the arm is a dummy"
    (folder / "accepted.json").write_text(json.dumps(entries))
    assert check("twice.nc", *at).exit_code == 0
    text = (folder / "twice.nc").read_text()
    (folder / "twice.nc").write_text(
        text.replace("N100 M8\n", "N100 M8\nN101 (new)\nN102 G4 P10\n")
    )
    assert check("twice.nc", *at).exit_code == 0, "an edit elsewhere keeps the fingerprints"
    assert check("once.nc", *at).exit_code == 1, "another program has entries of its own"

    (folder / "twice.nc").write_text((folder / "once.nc").read_text())
    gone = report("twice.nc", *at)
    assert [f["meaning"] for f in gone["findings"] if f["code"] == "GC602"] == ["baseline_unused"]
    pruned = check("twice.nc", *at, "--update-baseline")
    assert "0 added, 1 removed" in pruned.stderr
    (left,) = read_baseline("accepted.json").entries.values()
    assert left.reason == "the arm is a dummy"
    assert check("twice.nc", *at).exit_code == 0


def test_what_was_not_reached_is_not_gone(folder: Path) -> None:
    """A check that ends at the first contact knows nothing of the second one."""
    at = ("--baseline", "accepted.json")
    check("twice.nc", *at, "--stop", "all", "--update-baseline")
    entries = json.loads((folder / "accepted.json").read_text())
    assert "baseline_unused" not in str(report("twice.nc", *at))
    check("twice.nc", *at, "--update-baseline")
    assert json.loads((folder / "accepted.json").read_text()) == entries
    later = "\n\nG0 X1 (gcodesim: ignore GC201)"
    assert "GC602" not in codes(judged(TOUCH, text=later, stop_all=False))
    assert "GC602" not in codes(judged(finding("GC405"), text=later))


def test_a_baseline_holds_wherever_it_is_used_from(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    check("once.nc", "--baseline", "accepted.json", "--update-baseline")
    (folder / "below").mkdir()
    monkeypatch.chdir(folder / "below")
    baseline = read_baseline("../accepted.json")
    found = report("../once.nc", "--baseline", "../accepted.json")
    assert [e.program for e in baseline.entries.values()] == ["once.nc"]
    assert "ignore_refused" in [f.get("meaning") for f in found["findings"]]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{", "no JSON"),
        ("[]", "schema: expected 'gcodesim.baseline/2'"),
        ('{"schema": "gcodesim.baseline/1"}', "entries: expected a list"),
        ('{"schema": "gcodesim.baseline/1", "entries": [{"program": 1}]}', "entries[0]: expected"),
        ('{"schema": "gcodesim.baseline/1", "entries": [{}]}', "entries[0].program: this key"),
    ],
)
def test_a_wrong_baseline_is_named(folder: Path, text: str, said: str) -> None:
    (folder / "b.json").write_text(text)
    result = check("once.nc", "--baseline", "b.json")
    assert result.exit_code == 2
    assert f"b.json: {said}" in result.stderr


@pytest.mark.parametrize("former", FORMER_CODES["GC108"])
@pytest.mark.parametrize("whole", [True, False])
def test_what_was_accepted_under_a_former_code_stays_accepted(
    tmp_path: Path, former: str, whole: bool
) -> None:
    """A baseline from before GC108: its entry is found, keeps its reason, and is written anew."""
    twice = [finding("GC108", pair=("Z", "part")), finding("GC108", pair=("Z", "part"))]
    now = replace(PASSED, findings=(*twice, NEAR))
    before = replace(now, findings=(*(replace(f, code=former) for f in twice), NEAR))
    path = str(tmp_path / "accepted.json")
    old = Baseline(path, {}).updated([(before, before.findings, True)])
    entries = {k: replace(e, reason=f"reason {i}") for i, (k, e) in enumerate(old.entries.items())}
    old = replace(old, entries=entries)

    assert old.unused(now) == []
    accepted = Policy(baseline=old).apply(now, "", stop_all=True)
    assert (accepted.verdict, len(accepted.ignored)) == ("pass", 3)
    assert [e.reason for e in old.entries_of(now)] == [e.reason for e in old.entries_of(before)]

    new = old.updated([(now, now.findings, whole)])
    assert sorted(e.code for e in new.entries.values()) == ["GC108", "GC108", "GC201"]
    assert [e.reason for e in new.entries_of(now)] == [e.reason for e in old.entries_of(before)]


def test_a_former_code_speaks_of_no_other_finding(tmp_path: Path) -> None:
    touch = finding("GC108", pair=("Z", "part"))
    others = [
        replace(touch, pair=("Z", "vise")),
        replace(touch, block="N7"),
        replace(touch, tool=3),
    ]
    others = [replace(other, code="GC103") for other in others]
    before = replace(PASSED, findings=(*others, replace(touch, code="GC107")))
    old = Baseline(str(tmp_path / "b.json"), {}).updated([(before, before.findings, True)])
    assert old.entries_of(replace(PASSED, findings=(touch,))) == [None]
