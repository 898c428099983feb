"""A batch on this machine: its results file, lost workers, time limits, resuming and shards."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from threading import Timer
from typing import Any
from xml.etree import ElementTree

import pytest
from click.testing import CliRunner, Result

from gcodesim.batch.process import WorkerProcess
from gcodesim.batch.programs import SUFFIXES
from gcodesim.batch.records import Record
from gcodesim.cli import main

SAMPLES = Path(__file__).parents[2] / "samples"
PASSES = "G21 G90\nT1 M6\nS1000 M3\nG0 X20 Y10\nM30\n"
FAILS = "G21 G90\nG1 X10\nM30\n"  # a feed move without a feed
UNCLEAR = "G21 G90\nG0 X10\nG332 X0\nM30\n"
ENDLESS = "#1=1\nWHILE[#1GT0]DO1\n#1=2\nEND1\nM30\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with one program per verdict."""
    for name, text in {"pass.nc": PASSES, "fail.nc": FAILS, "unclear.nc": UNCLEAR}.items():
        (tmp_path / name).write_text(text)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def batch(*args: str) -> Result:
    return CliRunner().invoke(main, ["batch", "--machine", "table_tilt", "--device", "cpu", *args])


def lines(name: str) -> list[dict[str, Any]]:
    return [json.loads(line) for line in Path(name).read_text().splitlines()]


def records(name: str) -> dict[str, dict[str, Any]]:
    return {r["program"]: r for r in lines(name) if "schema" not in r}


def codes(record: dict[str, Any]) -> list[str]:
    return [finding["code"] for finding in record["report"]["findings"]]


@pytest.mark.usefixtures("folder")
def test_every_program_has_a_record_a_row_and_the_worst_decides() -> None:
    done = batch("*.nc", "gone.nc", "--out", "r.jsonl", "--html", "o.html", "--jobs", "2")
    assert done.exit_code == 2
    found = records("r.jsonl")
    assert found["gone.nc"]["error"] == "gone.nc: cannot be read: No such file or directory"
    verdicts = {name: r["report"]["verdict"] for name, r in found.items() if "report" in r}
    assert verdicts == {"pass.nc": "pass", "fail.nc": "fail", "unclear.nc": "inconclusive"}
    rows = [line.split() for line in done.stdout.splitlines()]
    assert [row[:2] for row in rows[1:-1]] == [
        ["ERROR", "gone.nc"],
        ["FAIL", "fail.nc"],
        ["INCONCLUSIVE", "unclear.nc"],
        ["PASS", "pass.nc"],
    ]
    assert "line 2: GC405 feed move without F" in done.stdout
    assert done.stdout.endswith("4 checks: 1 PASS, 1 INCONCLUSIVE, 1 FAIL, 1 ERROR\n")
    page = Path("o.html").read_text(encoding="utf-8")
    assert page.count("<tr class=") == 4
    assert "http" not in page.replace("http-equiv", "")


def test_rows_tell_what_decided_what_is_ignored_and_what_differs(folder: Path) -> None:
    text = (SAMPLES / "tilt_into_holder.nc").read_text()
    wish = "F2000. (gcodesim: ignore GC102 reason=dummy)"
    (folder / "waived.nc").write_text(text.replace("F2000.", wish))
    (folder / "empty.nc").write_text("")
    jobs = ["stop = 'all'", "stop = 'all'\nclearance = 2"]
    head = "[[jobs]]\nprograms = ['waived.nc', 'empty.nc']\nmachine = 'table_tilt'\n"
    (folder / "gcodesim.toml").write_text("".join(f"{head}{job}\n" for job in jobs))
    args = ["batch", "--device", "cpu", "--html", "o.html", "--report", "junit=j.xml"]
    done = CliRunner().invoke(main, [*args, "--out", "r.jsonl"])
    merged = CliRunner().invoke(main, ["merge", "r.jsonl", "--html", "m.html"])
    assert merged.stdout == done.stdout, done.stderr
    rows = [" ".join(line.split()) for line in done.stdout.splitlines()[1:-1]]
    nothing = "GC901 nothing was checked: no motion, or no pair of bodies"
    cells = "0.000 cutter-A 4.0 1 contact ignored (comment: dummy)"
    assert rows[:2] == [
        f"INCONCLUSIVE empty.nc table_tilt 0.0 {nothing}",
        f"INCONCLUSIVE empty.nc #2 table_tilt --clearance 2 0.0 {nothing}",
    ]
    assert rows[2] == f"PASS waived.nc table_tilt {cells}"
    assert rows[3].startswith(f"PASS waived.nc #2 table_tilt --clearance 2 {cells}")
    for page in (Path("o.html").read_text(), Path("m.html").read_text()):
        assert page.count("1 contact ignored (comment: dummy)") == 2
        assert "with <code>--stop all</code>" in page
    names = [case.get("name") for case in ElementTree.parse("j.xml").iter("testcase")]
    assert names == ["empty.nc", "empty.nc #2", "waived.nc", "waived.nc #2"]


def test_no_file_of_a_folder_is_passed_over_in_silence(folder: Path) -> None:
    (folder / "sub").mkdir()
    (folder / "sub/O1234").write_text(PASSES)
    (folder / "notes.txt").write_text("")
    (folder / "lost.nc").symlink_to("nowhere")
    endings = "(1 .txt, 1 without ending)"
    message = f"gcodesim: skipped: 2 files that are no programs by ending or text {endings}\n"
    done = batch(".", "--jobs", "1")
    assert (done.exit_code, done.stderr) == (2, message)
    assert done.stdout.splitlines()[1].split()[:2] == ["ERROR", "lost.nc"]
    assert batch("sub/O*", "pass.nc", "--jobs", "1").stderr == ""
    endings = set(re.findall(r"\.[a-z]+", CliRunner().invoke(main, ["batch", "--help"]).stdout))
    assert endings >= SUFFIXES
    (folder / "gcodesim.toml").write_text("jobs = [{programs = ['.'], machine = 'table_tilt'}]")
    done = CliRunner().invoke(main, ["batch", "--device", "cpu", "--jobs", "1"])
    assert (done.exit_code, "(1 .toml, 1 .txt, 1 without ending)" in done.stderr) == (2, True)


def test_the_parent_imports_nothing_that_slows_down_its_workers() -> None:
    modules = "gcodesim.cli, gcodesim.batch.jobs, gcodesim.batch.pool, gcodesim.batch.results"
    code = f"import sys, {modules}; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert not {"numpy", "pydantic", "rich", "warp"} & set(done.stdout.split())


@pytest.mark.usefixtures("folder")
def test_a_record_is_what_check_reports() -> None:
    batch("unclear.nc", "--out", "r.jsonl", "--no-min-clearance")
    args = ["check", "unclear.nc", "--machine", "table_tilt", "--device", "cpu", "--format", "json"]
    alone = json.loads(CliRunner().invoke(main, args).stdout)
    report = records("r.jsonl")["unclear.nc"]["report"]
    changing = {"timing_s": None}
    assert report | changing == alone | changing


def test_what_does_not_count_is_the_same_as_for_check(folder: Path) -> None:
    (folder / "over.nc").write_text("G21 G90\nG0 X900. (gcodesim: ignore GC301 reason=fake)\n")
    assert batch("over.nc", "--out", "r.jsonl").exit_code == 0
    assert batch("over.nc", "--fail-on", "note", "--out", "n.jsonl").exit_code == 1
    assert "no code begins so" in batch("over.nc", "--ignore", "GC9999").stderr
    assert records("r.jsonl")["over.nc"]["key"] != records("n.jsonl")["over.nc"]["key"]


def test_a_killed_worker_costs_one_program(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "endless.nc").write_text(ENDLESS)
    receive = WorkerProcess.receive

    def kill_at_endless(self: WorkerProcess, limit_s: float | None) -> Record:
        if self._in_hand[0].program == "endless.nc":
            assert self._process is not None
            Timer(0.1, self._process.kill).start()
        return receive(self, limit_s)

    monkeypatch.setattr("gcodesim.batch.pool.PLENTY", 0)  # the next one is in its hands already
    monkeypatch.setattr(WorkerProcess, "receive", kill_at_endless)
    done = batch("endless.nc", "pass.nc", "fail.nc", "--out", "r.jsonl", "--jobs", "1")
    found = records("r.jsonl")
    assert codes(found["endless.nc"]) == ["GC901"]
    assert "exit status -9" in found["endless.nc"]["report"]["findings"][0]["message"]
    assert found["pass.nc"]["report"]["verdict"] == "pass"
    assert codes(found["fail.nc"])[0] == "GC405"
    assert done.exit_code == 1


def test_the_time_limit_ends_one_program_and_resume_tries_it_again(folder: Path) -> None:
    (folder / "long.nc").write_text(ENDLESS)
    args = ("long.nc", "pass.nc", "--out", "r.jsonl", "--jobs", "1", "--time-limit")
    done = batch(*args, "2")
    assert done.exit_code == 3
    found = records("r.jsonl")
    assert codes(found["long.nc"]) == ["GC901"]
    assert "stopped after 2 s" in found["long.nc"]["report"]["findings"][0]["message"]
    assert found["pass.nc"]["report"]["verdict"] == "pass"
    (folder / "long.nc").write_text(PASSES)
    done = batch(*args, "60", "--resume")
    assert (done.exit_code, "1 of 2 are done already" in done.stderr) == (0, True)


def test_resume_does_what_is_new_or_changed_and_nothing_twice(folder: Path) -> None:
    args = ("*.nc", "--out", "r.jsonl", "--jobs", "1", "--resume")
    assert batch(*args).exit_code == 1
    assert len(lines("r.jsonl")) == 1 + 3
    (folder / "fail.nc").write_text(PASSES)
    (folder / "new.nc").write_text(PASSES)
    with open("r.jsonl", "a") as out:
        out.write('{"program": "cut o')  # as when the last run was killed
    done = batch(*args)
    assert "2 of 4 are done already" in done.stderr
    assert [r["program"] for r in lines("r.jsonl")[5:]] == ["fail.nc", "new.nc"]
    assert done.exit_code == 3
    assert done.stdout.endswith("4 checks: 3 PASS, 1 INCONCLUSIVE, 0 FAIL, 0 ERROR\n")


@pytest.mark.usefixtures("folder")
def test_results_are_never_overwritten() -> None:
    Path("r.jsonl").write_text("precious")
    assert batch("pass.nc", "--out", "r.jsonl").exit_code == 2
    again = batch("pass.nc", "--out", "r.jsonl", "--resume")
    assert (again.exit_code, "r.jsonl: no results" in again.stderr) == (2, True)
    assert Path("r.jsonl").read_text() == "precious"


@pytest.mark.usefixtures("folder")
def test_shards_join_to_the_whole_and_a_missing_one_is_inconclusive() -> None:
    for part in ("1", "2"):
        batch("pass.nc", "unclear.nc", "--shard", f"{part}/2", "--out", f"{part}.jsonl")
    assert [len(lines(f"{part}.jsonl")) for part in ("1", "2")] == [2, 2]
    joined = CliRunner().invoke(main, ["merge", "1.jsonl", "2.jsonl", "--out", "all.jsonl"])
    assert joined.exit_code == 3
    assert records("all.jsonl").keys() == {"pass.nc", "unclear.nc"}
    again = CliRunner().invoke(main, ["merge", "all.jsonl"])
    assert (again.exit_code, again.stdout) == (3, joined.stdout)
    (passing,) = (n for n in ("1.jsonl", "2.jsonl") if "pass.nc" in records(n))
    half = CliRunner().invoke(main, ["merge", passing])
    assert half.exit_code == 3
    assert "INCONCLUSIVE  shard" in half.stdout


@pytest.mark.usefixtures("folder")
def test_a_job_without_a_record_is_inconclusive() -> None:
    batch("pass.nc", "fail.nc", "--out", "r.jsonl")
    kept = [line for line in Path("r.jsonl").read_text().splitlines() if "feed_missing" not in line]
    Path("r.jsonl").write_text("".join(f"{line}\n" for line in kept))
    merged = CliRunner().invoke(main, ["merge", "r.jsonl"])
    assert merged.exit_code == 3
    assert "fail.nc" in next(line for line in merged.stdout.splitlines() if "not checked" in line)


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["--resume"], "--resume needs --out FILE"),
        (["--jobs", "2", "--scheduler", "tcp://host:1"], "a scheduler has its own"),
        (["--shard", "3/2"], "expected a part and how many there are"),
        (["--time-limit", "0"], "--time-limit"),
        (["--device", "gpu"], "expected auto, cpu, cuda or cuda:N"),
        (["no_such_folder_*"], "no_such_folder_*: no program there"),
    ],
)
@pytest.mark.usefixtures("folder")
def test_what_is_wrong_with_an_option_is_said(args: list[str], message: str) -> None:
    done = batch("pass.nc", *args)
    assert (done.exit_code, message in done.stderr) == (2, True), done.stderr


@pytest.mark.usefixtures("folder")
def test_no_worker_outlives_its_batch() -> None:
    batch("*.nc", "--jobs", "2")
    with pytest.raises(ChildProcessError):
        os.waitpid(-1, os.WNOHANG)
