"""The public names: the example of README, and what they are."""

from __future__ import annotations

import math
import re
import subprocess
import sys
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gcodesim
from gcodesim.checking.options import options_of
from gcodesim.nc.control.readings import ROWS, choose_readings

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


def test_every_field_of_options_is_named_in_the_readme() -> None:
    section = README.partition("## From Python")[2].partition("\n## ")[0]
    named = re.findall(r"`(\w+)`", "".join(re.findall(r"^\| (`.*?) \|", section, re.MULTILINE)))
    assert sorted(named) == sorted(field.name for field in fields(gcodesim.Options))


def test_the_readme_says_which_option_a_field_is() -> None:
    section = README.partition("## From Python")[2].partition("\n## ")[0]
    rows = re.findall(r"^\| (`.*?) \| (.*) \|$", section, re.MULTILINE)
    for name, option, _ in options_of(gcodesim.Options):
        ((_, meaning),) = (row for row in rows if f"`{name}`" in row[0])
        if option.name == name.replace("_", "-"):
            assert meaning == "the same name"
        else:
            assert f"`--{option.name}" in meaning or not option.name


def test_every_dialect_that_is_offered_is_one() -> None:
    for name in ROWS:
        assert choose_readings(name).dialect == name


def test_every_field_of_options_says_what_it_is() -> None:
    described = {name: option for name, option, _ in options_of(gcodesim.Options)}
    assert list(described) == [field.name for field in fields(gcodesim.Options)]
    for name, option in described.items():
        assert f"    {name}: {option.help}" in (gcodesim.Options.__doc__ or "")


def test_check_gives_the_same_function_every_time() -> None:
    """A module of that name would hide the function after the first import."""
    first = gcodesim.check
    report = first(ROOT / "samples/no_feed.nc", "table_tilt")
    assert isinstance(report, gcodesim.Report)
    assert report.verdict == "fail"
    assert gcodesim.check is first


def test_what_cannot_be_used_is_an_error_of_usage() -> None:
    options, path = gcodesim.Options(dialect="cobol"), ROOT / "samples/part.nc"
    with pytest.raises(gcodesim.UsageError, match="no machine of that name"):
        gcodesim.check(ROOT / "samples/part.nc", "table_tlit")
    with pytest.raises(gcodesim.UsageError, match=r"gone\.nc: cannot be read"):
        gcodesim.check("gone.nc", "table_tilt")
    with pytest.raises(gcodesim.UsageError, match="cobol"):
        gcodesim.check(path, "table_tilt", options=options)
    with pytest.raises(gcodesim.UsageError, match=r"expected gcodesim\.Options"):
        gcodesim.check(path, "table_tilt", options={"clearance": 2.0})  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("name", "wrong", "right"),
    [
        ("clearance", (-1, math.nan, math.inf, "2", True), "mm, 0 or more, or None"),
        ("feed", (-5, 0, math.nan, "100"), "mm/min above 0, or None"),
        ("period_ps", (0, -5, 1e8, 999_999, 10**14), "from 1000000 (1 us)"),
        ("method", ("foo", None, 1), "search, exhaustive, paper"),
        ("device", ("gpu", None, "cuda:x"), "auto, cpu, cuda or cuda:N"),
        ("dialect", (1, ["fanuc"]), "the name of a dialect"),
        ("between", ("off", 1, None), "True or False"),
        ("stop_all", ("all", 0), "True or False"),
        ("max_blocks", (0, 2.5, True), "a whole number from 1 on"),
        ("threads", (-1, None), "a whole number, 0 for one per core"),
    ],
)
def test_options_refuse_what_cannot_be_used_and_say_what_can(
    name: str, wrong: tuple[object, ...], right: str
) -> None:
    for value in wrong:
        given: dict[str, Any] = {name: value}
        with pytest.raises(gcodesim.UsageError, match=rf"{name}=.*{re.escape(right)}"):
            gcodesim.Options(**given)


def test_options_take_numbers_of_numpy_and_know_what_only_the_search_can() -> None:
    given: dict[str, Any] = {"clearance": np.float32(2), "max_blocks": np.int64(5)}
    options = gcodesim.Options(feed=100, **given)
    assert (options.clearance, options.max_blocks, options.feed) == (2, 5, 100)
    with pytest.raises(gcodesim.UsageError, match="clearance needs method='search'"):
        gcodesim.Options(method="exhaustive", clearance=0.0)
