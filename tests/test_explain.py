"""Every code and meaning that the source can report is explained."""

import ast
from pathlib import Path

import pytest
from click.testing import CliRunner

from gcodesim.cli import main
from gcodesim.findings.codes import CODES, CONTAINMENT_UNDECIDED
from gcodesim.findings.explain import ADVICE, explain
from gcodesim.findings.meanings import CHECK_MEANINGS, LANGUAGE_MEANINGS, MEANINGS

SOURCE = Path(__file__).parents[1] / "gcodesim"
# Name of what makes a finding or its error -> position of the meaning among its arguments.
MAKERS = {
    **{"Finding": 2, "error": 0, "finding": 0, "error_at": 1, "_finding": 0, "named": 0},
    **{"ArcError": 0, "FlowError": 0, "ExpressionError": 0},
}


def constants(node):
    """The strings an argument may be: itself, or either side of a choice."""
    if isinstance(node, ast.IfExp):
        return [*constants(node.body), *constants(node.orelse)]
    return [node.value] if isinstance(node, ast.Constant) and isinstance(node.value, str) else []


def reported():
    """Meanings written down where findings are made, with their place."""
    for path in sorted(SOURCE.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not isinstance(node, ast.Call):
                continue
            name = getattr(node.func, "attr", getattr(node.func, "id", ""))
            named = [k.value for k in node.keywords if k.arg == "meaning" and name == "Finding"]
            given = node.args[MAKERS[name] :][:1] if name in MAKERS else []
            inside = name == "Finding" or "nc" in path.relative_to(SOURCE).parts
            for argument in (named or given) if inside else []:
                yield from ((path.name, meaning) for meaning in constants(argument))


def test_every_code_has_advice_and_every_meaning_a_sentence():
    assert ADVICE.keys() == CODES.keys()
    for right in (*ADVICE.values(), *(right for _, right in MEANINGS.values())):
        assert right
        assert "\n" not in right
    assert {code for code, _ in MEANINGS.values()} <= CODES.keys()
    assert not LANGUAGE_MEANINGS.keys() & CHECK_MEANINGS.keys()


def test_no_meaning_in_the_source_is_undocumented():
    found = list(reported())
    assert len({meaning for _, meaning in found}) > 60
    for file, meaning in found:
        assert meaning in MEANINGS, f"{file}: {meaning}"


def test_a_finding_has_the_code_of_its_meaning():
    """A few meanings come with several codes; the table names the first."""
    several = {"overtravel": "GC302", "reference_out_of_travel": "GC302"}
    pairs = set()
    for path in sorted(SOURCE.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "Finding":
                named = [k.value for k in node.keywords if k.arg == "meaning"] or node.args[2:3]
                meanings = [m for argument in named for m in constants(argument)]
                pairs |= {(c, m) for a in node.args[:1] for c in constants(a) for m in meanings}
    assert len(pairs) > 20
    for code, meaning in pairs:
        assert code in (MEANINGS[meaning][0], several.get(meaning)), meaning


def test_no_meaning_is_explained_that_nothing_reports():
    named = {CONTAINMENT_UNDECIDED: "CONTAINMENT_UNDECIDED"}
    paths = [path for path in SOURCE.rglob("*.py") if path.name != "meanings.py"]
    words = {
        node.value if isinstance(node, ast.Constant) else getattr(node, "id", "")
        for path in paths
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant | ast.Name)
    }
    for meaning in MEANINGS:
        assert named.get(meaning, meaning) in words, meaning


@pytest.mark.parametrize("name", ["GC405", "gc405", "feed_missing", "feed-missing"])
def test_codes_and_meanings_are_explained(name):
    result = CliRunner().invoke(main, ["explain", name])
    assert result.exit_code == 0
    assert "GC405 feed missing or impossible (error; verdict FAIL)" in result.stdout
    assert "feed_missing: give F above 0" in result.stdout


def test_every_name_has_an_answer():
    for name in (*CODES, *MEANINGS):
        assert explain(name)


def test_codes_are_listed_all_or_a_family():
    every = CliRunner().invoke(main, ["explain"])
    assert every.exit_code == 0
    for code, row in CODES.items():
        assert f"{code} {row.title} (" in every.stdout
    *family, _ = CliRunner().invoke(main, ["explain", "gc2"]).stdout.splitlines()
    assert [line[:5] for line in family] == ["GC201", "GC202"]


def test_unknown_names_are_refused_with_a_hint():
    result = CliRunner().invoke(main, ["explain", "feed_mising"])
    assert result.exit_code == 2
    assert "did you mean feed_missing" in result.stderr
