"""Every code and meaning that the source can report is explained."""

import ast
from pathlib import Path

import pytest
from click.testing import CliRunner

from gcodesim.cli import main
from gcodesim.findings.codes import CODES
from gcodesim.findings.explain import ADVICE, OTHER_MEANINGS, explain
from gcodesim.findings.meanings import MEANINGS

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
            inside = name == "Finding" or path.parent.name == "nc"
            for argument in (named or given) if inside else []:
                yield from ((path.name, meaning) for meaning in constants(argument))


def test_every_code_has_advice_and_every_meaning_a_sentence():
    assert ADVICE.keys() == CODES.keys()
    for right in (*ADVICE.values(), *(right for _, right in OTHER_MEANINGS.values())):
        assert right
        assert "\n" not in right
    assert {code for code, _ in OTHER_MEANINGS.values()} <= CODES.keys()


def test_no_meaning_in_the_source_is_undocumented():
    found = list(reported())
    assert len({meaning for _, meaning in found}) > 60
    for file, meaning in found:
        assert meaning in MEANINGS or meaning in OTHER_MEANINGS, f"{file}: {meaning}"


def test_no_meaning_is_explained_that_nothing_reports():
    texts = "".join(path.read_text(encoding="utf-8") for path in SOURCE.rglob("*.py"))
    for meaning in MEANINGS | OTHER_MEANINGS:
        assert texts.count(f'"{meaning}"') >= 2 or meaning == "containment_undecided", meaning


@pytest.mark.parametrize("name", ["GC405", "gc405", "feed_missing", "feed-missing"])
def test_codes_and_meanings_are_explained(name):
    result = CliRunner().invoke(main, ["explain", name])
    assert result.exit_code == 0
    assert "GC405 feed missing or impossible (error; verdict FAIL)" in result.stdout
    assert "feed_missing: give F above 0" in result.stdout


def test_every_name_has_an_answer():
    for name in (*CODES, *MEANINGS, *OTHER_MEANINGS):
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
