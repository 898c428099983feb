"""The figures of the README are those of the committed results, which say where they are from."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
MARKED = dict(re.findall(r"<!-- figures: ([\w-]+) -->\n(.*?)<!-- end -->", README, re.DOTALL))


def test_there_are_figures() -> None:
    assert {"accuracy", "triangles"} <= MARKED.keys()


@pytest.mark.parametrize("name", MARKED)
def test_figures_of_the_readme_are_those_of_the_results(name: str) -> None:
    results = ROOT / "tests" / "benchmarks" / "results" / f"study-{name}.json"
    report = json.loads(results.read_text(encoding="utf-8"))
    assert MARKED[name].splitlines() == report["table"]
    assert report["date"][:4].isdigit()
    assert {"gcodesim", "warp", "numpy", "python"} <= report["versions"].keys()
    assert report["cpu"]
    assert report["device"]
