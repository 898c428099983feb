"""Programs outside Python that tests need: where one lacks they skip, with CI=true they fail."""

from __future__ import annotations

import os
from typing import NoReturn

import pytest

IN_CI = os.environ.get("CI") == "true"
"""Whether nothing may be left out; read before a test takes CI out of the environment."""


def lacking(what: str) -> NoReturn:
    """End a test that cannot run here: skipped, and failed in CI."""
    if IN_CI:
        pytest.fail(f"CI may leave out no test: {what}", pytrace=False)
    pytest.skip(what)


def need(found: object, package: str) -> None:
    """End a test when the programs of a Debian package were not found."""
    if not found:
        lacking(f"not installed: apt-get install {package}")
