"""The device that kernel tests run on, and seeded random numbers."""

from __future__ import annotations

import numpy as np
import pytest

from gcodesim.collision.geometry.device import resolve_device
from gcodesim.errors import UsageError

DEVICES = {"cpu": ["cpu"], "cuda": ["cuda"], "all": ["cpu", "cuda"]}


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--device", choices=sorted(DEVICES), default="cpu", help="device of kernels")


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    if "device" in metafunc.fixturenames:
        chosen = DEVICES[metafunc.config.getoption("--device")]
        metafunc.parametrize("device", chosen, indirect=True, scope="session")


@pytest.fixture(scope="session")
def device(request: pytest.FixtureRequest) -> str:
    """Warp's name of the device; skips where there is none of that kind."""
    try:
        return resolve_device(request.param)
    except UsageError as error:
        pytest.skip(str(error))


@pytest.fixture
def rng() -> np.random.Generator:
    """Random numbers, the same in every run."""
    return np.random.default_rng(20260101)


@pytest.fixture(autouse=True)
def _outside_ci(monkeypatch: pytest.MonkeyPatch) -> None:
    """In CI a check writes a picture of a contact into the working folder: not in every test."""
    monkeypatch.delenv("CI", raising=False)
