"""A batch as the gate: settings, reports and pictures are those of `check`."""

from __future__ import annotations

import json
from pathlib import Path
from xml.etree import ElementTree

import pytest
from click.testing import CliRunner, Result

from gcodesim.cli import main

SAMPLES = Path(__file__).parents[2] / "samples"
NAMES = ("no_feed", "part", "tilt_into_holder", "unknown_code")
SETTINGS = """
device = "cpu"
sample-period = "1ms"
stop = "all"
format = "text"  # of check only
time-limit = 600  # of batch only
out = "made/results.jsonl"
ignore = { GC430 = "" }

[[jobs]]
programs = ["parts/part.nc", "parts/unknown_code.nc"]
machine = "table_tilt"

[[jobs]]
programs = ["parts/tilt*.nc"]
machine = ["table_tilt", "nutating_head"]
"""


@pytest.fixture
def shop(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with a program per verdict in parts/."""
    (tmp_path / "parts").mkdir()
    for name in NAMES:
        (tmp_path / f"parts/{name}.nc").write_text((SAMPLES / f"{name}.nc").read_text())
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("CI", "")
    return tmp_path


def run(*args: str) -> Result:
    return CliRunner().invoke(main, list(args))


OPTIONS = ("--machine", "table_tilt", "--device", "cpu", "--sample-period", "1ms")


@pytest.mark.usefixtures("shop")
def test_the_jobs_of_the_settings_are_carried_out_as_check_does() -> None:
    Path("gcodesim.toml").write_text(SETTINGS)
    done = run("batch", "--report", "json=b.json", "--jobs", "2", "--no-min-clearance")
    alone = run("check", "--report", "json=c.json")
    assert (done.exit_code, alone.exit_code) == (1, 1), done.stderr
    lists = [json.loads(Path(name).read_text()) for name in ("b.json", "c.json")]
    for reports in lists:
        reports.sort(key=lambda report: (report["program"], report["machine"]))
        for report in reports:
            report["timing_s"] = {}
    assert lists[0] == lists[1]
    assert len(Path("made/results.jsonl").read_text().splitlines()) == 1 + 4
    assert [(r["program"], r["machine"], r["verdict"]) for r in lists[0]] == [
        ("parts/part.nc", "table_tilt", "pass"),
        ("parts/tilt_into_holder.nc", "nutating_head", "inconclusive"),
        ("parts/tilt_into_holder.nc", "table_tilt", "fail"),
        ("parts/unknown_code.nc", "table_tilt", "inconclusive"),
    ]


@pytest.mark.usefixtures("shop")
def test_settings_of_a_batch_are_shown_and_found_above_its_programs(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    Path("gcodesim.toml").write_text(SETTINGS)
    monkeypatch.chdir("parts")
    shown = run("batch", "part.nc", "--show-settings", "--clearance", "2").stdout
    lines = [line.split() for line in shown.splitlines()]
    assert lines[0] == ["settings:", "../gcodesim.toml"]
    assert ["time-limit", "=", "600.0", "(../gcodesim.toml)"] in lines
    assert ["clearance", "=", "2.0", "(command", "line)"] in lines
    assert ["machine", "=", "table_tilt", "(../gcodesim.toml:", "jobs[0])"] in lines
    assert not any(line[0] == "format" for line in lines)
    monkeypatch.chdir("..")
    Path("gcodesim.toml").unlink()
    nothing = run("batch")
    assert (nothing.exit_code, nothing.stdout) == (2, "")
    assert "Missing argument 'PATTERN...', and no [[jobs]] in a settings file." in nothing.stderr


@pytest.mark.usefixtures("shop")
def test_sarif_of_a_batch_is_that_of_check() -> None:
    programs = [f"parts/{name}.nc" for name in NAMES]
    done = run("batch", "parts", "parts/gone.nc", *OPTIONS, "--report", "sarif=b.sarif")
    alone = run("check", *programs, "parts/gone.nc", *OPTIONS, "--report", "sarif=c.sarif")
    assert (done.exit_code, alone.exit_code) == (2, 2)
    assert Path("b.sarif").read_bytes() == Path("c.sarif").read_bytes()


@pytest.mark.usefixtures("shop")
def test_shards_are_reported_as_one_and_one_that_is_missing_is_no_success() -> None:
    for part in "12":
        run("batch", "parts", *OPTIONS, "--shard", f"{part}/2", "--out", f"{part}.jsonl")
    run("batch", "parts", *OPTIONS, "--report", "sarif=whole.sarif")
    assert run("merge", "1.jsonl", "2.jsonl", "--report", "sarif=m.sarif").exit_code == 1
    assert Path("m.sarif").read_bytes() == Path("whole.sarif").read_bytes()
    run("merge", "1.jsonl", "--report", "junit=half.xml")
    (suite,) = ElementTree.parse("half.xml").getroot()
    (missing,) = suite.iterfind("testcase[@name='shard 2/2']")
    assert missing.find("error").get("message") == "not there"
    over = run("merge", "1.jsonl", "--report", "json=1.jsonl")
    assert (over.exit_code, "1.jsonl is a part that is joined" in over.stderr) == (2, True)


@pytest.mark.usefixtures("shop")
def test_merge_destroys_nothing() -> None:
    run("batch", "parts/part.nc", *OPTIONS, "--out", "r.jsonl")
    run("batch", "parts/part.nc", *OPTIONS, "--shard", "1/3", "--out", "s.jsonl")
    program = Path("parts/part.nc").read_text()
    Path("p.html").symlink_to("parts/part.nc")
    Path("notes.txt").write_text("notes")
    for args, message in (
        (["--html", "p.html"], "p.html is a program that was checked"),
        (["--out", "parts/part.nc"], "parts/part.nc is a program that was checked"),
        (["--out", "./r.jsonl"], "./r.jsonl is a part that is joined"),
        (["--out", "notes.txt"], "another kind of file: notes.txt: no results"),
        (["--html", "r.jsonl"], "--html r.jsonl: expected the name of a .html file"),
        (["--out", "o.html", "--html", "./o.html"], "./o.html is what --out o.html writes"),
        (["s.jsonl"], "r.jsonl is one of 1, s.jsonl one of 3"),
    ):
        over = run("merge", "r.jsonl", *args)
        assert (over.exit_code, message in over.stderr) == (2, True), over.stderr
    assert Path("parts/part.nc").read_text() == program
    assert Path("notes.txt").read_text() == "notes"
    assert run("merge", "r.jsonl", "--out", "all.jsonl").exit_code == 0
    assert run("merge", "r.jsonl", "--out", "all.jsonl").exit_code == 0, "results are replaced"


@pytest.mark.slow
def test_every_contact_has_its_picture_and_the_reports_name_it(
    shop: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (shop / "other").mkdir()
    crash = (shop / "parts/tilt_into_holder.nc").rename(shop / "parts/crash.nc").read_text()
    (shop / "other/crash.nc").write_text(crash)
    reports = ("--report", "junit=out/r.xml", "--html", "out/o.html")
    done = run("batch", "parts", "other", *OPTIONS, "--snapshot", "out/contact.png", *reports)
    assert (done.exit_code, done.stderr) == (1, "")
    names = ["contact-crash-2.png", "contact-crash.png"]
    assert sorted(path.name for path in shop.rglob("*.png")) == names
    for name in names:
        assert (shop / "out" / name).read_bytes().startswith(b"\x89PNG")
        assert f"[[ATTACHMENT|out/{name}]]" in Path("out/r.xml").read_text()
        assert f'<a href="./{name}">picture</a>' in Path("out/o.html").read_text()
    monkeypatch.setenv("CI", "true")
    machines = ("--machine", "nutating_head")
    run("batch", "other", *OPTIONS, *machines)
    assert [path.name for path in shop.glob("*.png")] == ["gcodesim-crash-table_tilt.png"]


@pytest.mark.slow
@pytest.mark.usefixtures("shop")
def test_a_picture_that_cannot_be_written_takes_no_answer_away() -> None:
    Path("a.png").mkdir()
    args = ("parts/tilt_into_holder.nc", *OPTIONS, "--snapshot", "a.png", "--out", "r.jsonl")
    done = run("batch", *args)
    assert done.exit_code == 2
    assert done.stdout.startswith("verdict")
    assert "1 FAIL, 0 ERROR" in done.stdout
    assert "gcodesim: no snapshot: " in done.stderr
    Path("a.png").rmdir()
    assert run("batch", *args, "--resume").exit_code == 1
    assert Path("a.png").is_file()


@pytest.mark.usefixtures("shop")
def test_a_program_with_two_sets_of_options_is_there_twice_after_merging() -> None:
    job = '[[jobs]]\nprograms = ["parts/part.nc"]\nmachine = "table_tilt"\nrapids = "{}"\n'
    Path("gcodesim.toml").write_text("".join(map(job.format, ("linear", "dogleg"))))
    for part in "12":
        run("batch", "--device", "cpu", "--shard", f"{part}/2", "--out", f"{part}.jsonl")
    assert run("merge", "1.jsonl", "2.jsonl").stdout.count("parts/part.nc") == 2


@pytest.mark.usefixtures("shop")
def test_a_batch_tells_the_pair_that_comes_nearest() -> None:
    def row(*more: str) -> list[str]:
        return run("batch", "parts/part.nc", *OPTIONS, *more).stdout.splitlines()[1].split()

    nearest = row()
    assert nearest == row("--min-clearance")
    assert nearest[3:5] == ["12.000", "cutter-C"]
    assert row("--no-min-clearance")[3] != "12.000"
