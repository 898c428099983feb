"""A batch on a real Dask scheduler with two workers, one of which is killed in mid-run."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("distributed")

PROGRAM = "G21 G90\nT1 M6\nG0 X{} Y10\nG0 A-20 C90\nG0 X0 Y0 A0 C0\nM30\n"
COUNT = 24


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """Starts `python -m`; what is left of it ends with the test."""
    started: list[subprocess.Popen[str]] = []

    def start_one(*args: str) -> subprocess.Popen[str]:
        log = (tmp_path / f"{len(started)}.log").open("w")
        with log:
            command = [sys.executable, "-m", *args]
            started.append(subprocess.Popen(command, cwd=tmp_path, stdout=log, stderr=log))
        return started[-1]

    yield start_one
    for process in started:
        process.kill()
        process.wait()


def until(condition: Callable[[], Any], process: subprocess.Popen[str]) -> Any:
    """What the condition gives as soon as it gives something; fails when the process ends."""
    while not (found := condition()):
        assert process.poll() is None, "ended early"
        time.sleep(0.02)
    return found


@pytest.mark.slow
def test_a_worker_is_killed_and_nothing_is_lost(
    tmp_path: Path, start: Callable[..., subprocess.Popen[str]]
) -> None:
    for number in range(COUNT):
        (tmp_path / f"{number}.nc").write_text(PROGRAM.format(number))
    file, results = tmp_path / "scheduler.json", tmp_path / "results.jsonl"
    here = ("--host", "127.0.0.1", "--scheduler-file", str(file), "--no-dashboard")
    scheduler = start("distributed.cli.dask_scheduler", "--port", "0", *here)
    address = until(lambda: file.exists() and json.loads(file.read_text())["address"], scheduler)
    one_thread = ("--nthreads", "1", "--no-nanny")
    workers = [start("distributed.cli.dask_worker", *here, *one_thread) for _ in range(2)]
    options = ("--machine", "table_tilt", "--device", "cpu", "--out", str(results))
    batch = start("gcodesim", "batch", ".", *options, "--scheduler", address)

    def records() -> list[dict[str, Any]]:
        text = results.read_text() if results.exists() else ""
        return [json.loads(line) for line in text.splitlines(keepends=True)[1:] if "\n" in line]

    until(lambda: len(records()) > 2, batch)
    workers[0].kill()
    assert len(records()) < COUNT - 2, "killed too late to prove anything"
    assert batch.wait() == 0, (tmp_path / "3.log").read_text()
    done = records()
    assert sorted(record["program"] for record in done) == sorted(f"{n}.nc" for n in range(COUNT))
    assert {record["report"]["verdict"] for record in done} == {"pass"}
    assert workers[1].poll() is None


def test_a_scheduler_that_is_not_there_is_said(
    tmp_path: Path, start: Callable[..., subprocess.Popen[str]]
) -> None:
    (tmp_path / "a.nc").write_text(PROGRAM.format(1))
    where = ("--machine", "table_tilt", "--scheduler", "nonsense")
    assert start("gcodesim", "batch", "a.nc", *where).wait() == 2
    assert "gcodesim: --scheduler nonsense: no answer" in (tmp_path / "0.log").read_text()
