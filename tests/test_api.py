"""The public names: the example of README, and what they are."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

import gcodesim

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
(EXAMPLE,) = re.findall(r"^```python\n(.*?)```$", README, re.MULTILINE | re.DOTALL)


def test_the_example_of_the_readme_prints_what_it_says() -> None:
    """In a process of its own: nothing but `import gcodesim` comes before it."""
    shown = re.findall(r"# prints (.*)$", EXAMPLE, re.MULTILINE)
    assert shown
    command = [sys.executable, "-c", EXAMPLE]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == shown


def test_every_stable_name_is_listed_in_the_readme() -> None:
    for name in gcodesim.__all__:
        assert f"`gcodesim.{name}" in README, name


def test_check_gives_the_same_function_every_time() -> None:
    """A module of that name would hide the function after the first import."""
    first = gcodesim.check
    report = first(ROOT / "samples/no_feed.nc", "table_tilt")
    assert isinstance(report, gcodesim.Report)
    assert report.verdict == "fail"
    assert gcodesim.check is first


def test_what_cannot_be_used_is_an_error_of_usage() -> None:
    options = gcodesim.Options(dialect="cobol")
    with pytest.raises(gcodesim.UsageError, match="no machine of that name"):
        gcodesim.check(ROOT / "samples/part.nc", "table_tlit")
    with pytest.raises(gcodesim.UsageError, match=r"gone\.nc: cannot be read"):
        gcodesim.check("gone.nc", "table_tilt")
    with pytest.raises(gcodesim.UsageError, match="cobol"):
        gcodesim.check(ROOT / "samples/part.nc", "table_tilt", options=options)
