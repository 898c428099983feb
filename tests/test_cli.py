"""The command line: exit codes, streams, and a clear sentence for whatever is wrong."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from gcodesim.cli import main
from gcodesim.cli.arguments import progress_bar
from gcodesim.constants import DEFAULT_PERIOD_PS

MACHINES = Path(__file__).parents[1] / "machines"
TOOLS = (Path(__file__).parent / "report/tools.yaml").read_text(encoding="utf-8")
PASSES = "G21 G90\nT1 M6\nS1000 M3\nG0 X20 Y10\nM30\n"
FAILS = "G21 G90\nG1 X10\nM30\n"  # a feed move without a feed
UNCLEAR = "G21 G90\nG0 X10\nG332 X0\nM30\n"
TEXTS = {"pass.nc": PASSES, "fail.nc": FAILS, "unclear.nc": UNCLEAR}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working folder outside the repository, with one program per verdict."""
    for name, text in TEXTS.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "empty.nc").touch()
    (tmp_path / "folder.nc").mkdir()
    (tmp_path / "binary.nc").write_bytes(bytes(range(256)) * 40)
    (tmp_path / "binary.yaml").write_bytes(bytes(range(256)))
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("NO_COLOR", raising=False)
    return tmp_path


def run(*args: str, **kwargs: object) -> Result:
    return CliRunner().invoke(main, list(args), **kwargs)


def check(*programs: str, machine: str = "table_tilt", **kwargs: object) -> Result:
    options = ["--machine", machine, "--device", "cpu", "--sample-period", "10ms"]
    return run("check", *options, *programs, **kwargs)


OUTPUTS = (
    ("check", "--report", "junit={}"),
    ("check", "--html", "{}"),
    ("batch", "--html", "{}"),
    ("batch", "--out", "{}"),
    ("batch", "--report", "json={}"),
    ("trace", "--npz", "{}"),
)


@pytest.fixture
def inputs(folder: Path) -> list[Path]:
    """Everything a run reads, with a link of every ending to each."""
    shutil.copytree(MACHINES / "table_tilt", folder / "m/table_tilt")
    shutil.copy(MACHINES / "table_tilt.yaml", folder / "m/m.yaml")
    (folder / "setup.yaml").write_text("machine: m/m.yaml\n")
    (folder / "tools.yaml").write_text(TOOLS)
    names = ["pass.nc", "m/m.yaml", "m/table_tilt/A.stl", "setup.yaml", "tools.yaml"]
    for name in names:
        for ending in ("html", "npz"):
            link = folder / f"{Path(name).name}.{ending}"
            link.symlink_to(folder / name)
    return [folder / name for name in names]


@pytest.mark.parametrize("output", OUTPUTS)
def test_no_output_is_written_over_an_input(output: tuple[str, ...], inputs: list[Path]) -> None:
    command, option, form = output
    setup = ("--setup", "setup.yaml", "--tools", "tools.yaml")
    for file in inputs:
        before = file.read_bytes()
        ending = {"--html": ".html", "--npz": ".npz"}.get(option)
        name = f"m/../{file.name}{ending}" if ending else str(file)
        result = run(command, "pass.nc", *setup, option, form.format(name))
        assert (result.exit_code, result.stdout) == (2, "")
        assert ": choose another file" in result.stderr
        assert file.read_bytes() == before


@pytest.mark.usefixtures("folder")
def test_two_outputs_are_never_one_file() -> None:
    Path("a.html").symlink_to("r.json")
    result = check("pass.nc", "--html", "a.html", "--report", "json=./r.json")
    assert result.exit_code == 2
    assert "--report json=./r.json: ./r.json is what --html a.html writes: choose" in result.stderr
    assert not Path("r.json").exists()


@pytest.mark.usefixtures("folder")
def test_a_program_beside_the_one_that_is_checked_is_no_place_for_a_report() -> None:
    """It may be a subprogram, which is found only when it is called."""
    result = check("pass.nc", "--report", "json=fail.nc")
    assert (result.exit_code, Path("fail.nc").read_text()) == (2, FAILS)
    assert "--report json=fail.nc: fail.nc is an NC program" in result.stderr


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("name", ["new/../fail.nc", "link.json", "new/../pass.nc"])
def test_no_way_round_leads_to_a_program(name: str) -> None:
    """Neither through a folder that is not there yet, nor by a link."""
    Path("link.json").symlink_to("fail.nc")
    before = [Path(file).read_text() for file in ("pass.nc", "fail.nc")]
    result = check("pass.nc", "--report", f"json={name}")
    assert (result.exit_code, "choose another file" in result.stderr) == (2, True)
    assert [Path(file).read_text() for file in ("pass.nc", "fail.nc")] == before


@pytest.mark.parametrize(
    "args",
    [
        ("check", "--html", "{}/x.html"),
        ("check", "--snapshot", "{}/x.png"),
        ("check", "--report", "json={}/x"),
        ("batch", "--out", "{}/x.jsonl"),
        ("batch", "--html", "{}/x.html"),
        ("trace", "--npz", "{}/x.npz"),
    ],
)
@pytest.mark.usefixtures("folder")
def test_an_output_that_cannot_be_written_names_its_option(args: tuple[str, ...]) -> None:
    command, *option = (word.format("empty.nc") for word in args)
    result = run(command, "pass.nc", "--machine", "table_tilt", *option)
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.startswith(f"gcodesim: {' '.join(option)}: folder 'empty.nc' cannot be")
    assert "Errno" not in result.stderr


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
@pytest.mark.usefixtures("folder")
def test_a_full_disk_is_told_with_the_option() -> None:
    Path("full.html").symlink_to("/dev/full")
    for option in (("--html", "full.html"), ("--report", "json=/dev/full")):
        result = check("pass.nc", *option)
        assert result.exit_code == 2
        assert f"gcodesim: {' '.join(option)}: cannot be written: No space left" in result.stderr


@pytest.mark.parametrize(
    "env",
    [
        {"PYTHONIOENCODING": "ascii"},
        {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
    ],
)
@pytest.mark.parametrize("command", ["check", "batch"])
def test_characters_that_the_terminal_lacks_are_replaced(
    command: str, env: dict[str, str], folder: Path
) -> None:
    (folder / "grün.nc").write_text("G21 G90\n(über) G1 X10\nM30\n", encoding="utf-8")
    args = [command, "grün.nc", "--machine", "table_tilt", "--device", "cpu"]
    done = subprocess.run(
        [sys.executable, "-m", "gcodesim", *args],
        capture_output=True,
        env=os.environ | env,
        check=False,
    )
    assert (done.returncode, done.stderr) == (1, b"")
    assert b"FAIL" in done.stdout
    assert re.search(rb"gr\?{1,2}n\.nc", done.stdout)


@pytest.mark.parametrize(
    ("programs", "code"),
    [
        (["pass.nc"], 0),
        (["fail.nc"], 1),
        (["unclear.nc"], 3),
        (["empty.nc"], 3),
        (["missing.nc"], 2),
        (["unclear.nc", "pass.nc"], 3),
        (["pass.nc", "fail.nc", "unclear.nc"], 1),
        (["fail.nc", "missing.nc", "unclear.nc"], 2),
    ],
)
@pytest.mark.usefixtures("folder")
def test_exit_code_is_that_of_the_worst_program(programs: list[str], code: int) -> None:
    assert check(*programs).exit_code == code


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["check", "pass.nc", "--machine", "table_tilt", "--fast"], "No such option '--fast'"),
        (["check", "--machine", "table_tilt"], "Missing argument 'PROGRAM...'"),
        (["check", "pass.nc"], "no machine: give --machine M.yaml"),
        (["check", "pass.nc", "--machine", "table_tlit"], "did you mean 'table_tilt'?"),
        (["check", "pass.nc", "--machine", "folder.nc"], "no machine file 'folder.nc'"),
        (["check", "pass.nc", "--machine", "binary.yaml"], "binary.yaml: not UTF-8 text"),
        (["check", "pass.nc", "--machine", "empty.nc"], "empty.nc:1: the file must be a mapping"),
        (["check", "pass.nc", "--machine", "m" * 300], "gcodesim: "),
        (["check", "pass.nc", "--setup", "folder.nc"], "folder.nc: cannot be read"),
        (["check", "pass.nc", "--machine", "table_tilt", "--tools", "no.tbl"], "no.tbl: cannot be"),
        (["check", "missing.nc", "--machine", "table_tilt"], "missing.nc: cannot be read"),
        (["check", "folder.nc", "--machine", "table_tilt"], "folder.nc: cannot be read"),
        (["check", "pass.nc", "--machine", "table_tilt", "--device", "gpu"], "expected auto, cpu"),
        (["check", "pass.nc", "--machine", "table_tilt", "--feed", "0"], "'--feed'"),
        (["check", "pass.nc", "--machine", "table_tilt", "--dialect", "x"], "'--dialect'"),
        (["canon", "missing.nc"], "missing.nc: cannot be read"),
        (["machine", "show", "binary.yaml"], "not UTF-8 text"),
        (["machine", "schema", "part"], "'part' is not one of 'machine', 'tools', 'setup'"),
        (["chekc"], "No such command 'chekc'"),
        (["init", "pass.nc"], "pass.nc: cannot be written as a folder: File exists"),
        (["merge", "no.jsonl"], "gcodesim: no.jsonl: cannot be read: No such file or directory"),
    ],
)
@pytest.mark.usefixtures("folder")
def test_what_cannot_be_carried_out_is_2_with_a_sentence(args: list[str], message: str) -> None:
    result = run(*args)
    assert result.exit_code == 2
    assert message in result.stderr
    assert "Traceback" not in result.stderr
    assert result.stdout == ""


@pytest.mark.parametrize("period", ["0.1", "0s", "-1ms", "1h", "11s", "0.1us", "nans", "1e99s", ""])
@pytest.mark.usefixtures("folder")
def test_bad_sample_period(period: str) -> None:
    result = run("check", "pass.nc", "--machine", "table_tilt", "--sample-period", period)
    assert result.exit_code == 2
    assert f"{period!r}: expected a time from 1us to 10s, such as 0.1ms" in result.stderr


@pytest.mark.parametrize("given", [[], ["--sample-period", "100us"], ["--sample-period", "1e-4s"]])
@pytest.mark.usefixtures("folder")
def test_sample_period_is_a_tenth_of_a_millisecond(given: list[str]) -> None:
    result = run("check", "pass.nc", "--machine", "table_tilt", "--format", "json", *given)
    assert json.loads(result.stdout)["sample_period_s"] == DEFAULT_PERIOD_PS / 1e12 == 1e-4


@pytest.mark.usefixtures("folder")
def test_a_binary_program_is_a_finding() -> None:
    result = check("binary.nc")
    assert result.exit_code == 1
    assert result.stderr == ""
    assert all(character.isprintable() for character in result.stdout.replace("\n", ""))


@pytest.mark.usefixtures("folder")
def test_a_program_that_cannot_be_read_takes_no_report_away() -> None:
    result = check("fail.nc", "missing.nc", "pass.nc")
    assert [line[:4] for line in result.stdout.splitlines() if line[0] != " "] == ["FAIL", "PASS"]
    assert result.stderr.startswith("gcodesim: missing.nc: cannot be read")


@pytest.mark.usefixtures("folder")
def test_json_of_several_programs_is_an_array() -> None:
    one = json.loads(check("pass.nc", "--format", "json").stdout)
    assert one["verdict"] == "pass"
    two = json.loads(check("pass.nc", "fail.nc", "--format", "json").stdout)
    assert [report["verdict"] for report in two] == ["pass", "fail"]
    half = json.loads(check("missing.nc", "pass.nc", "--format", "json").stdout)
    assert [report["program"] for report in half] == ["pass.nc"]
    assert check("missing.nc", "--format", "json").stdout == ""


@pytest.mark.usefixtures("folder")
def test_dash_reads_standard_input() -> None:
    result = check("-", input=FAILS)
    assert result.exit_code == 1
    assert result.stdout.startswith("FAIL  <stdin> on table_tilt")


@pytest.mark.usefixtures("folder")
def test_interrupt_is_130(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*args: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("gcodesim.checking.flow.check_program", interrupted)
    result = check("pass.nc")
    assert result.exit_code == 130
    assert result.stdout == ""
    assert result.stderr == "gcodesim: interrupted; what has no report is not decided\n"


@pytest.mark.usefixtures("folder")
def test_a_defect_of_ours_never_looks_like_a_verdict(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*args: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr("gcodesim.checking.flow.check_program", broken)
    result = check("pass.nc")
    assert result.exit_code == 2
    assert "please report it" in result.stderr


@pytest.mark.usefixtures("folder")
def test_colours_only_where_wanted() -> None:
    terminal = {"FORCE_COLOR": "1", "TERM": "xterm-256color"}
    assert "\x1b" in check("pass.nc", env=terminal).output
    assert "\x1b" not in check("pass.nc", "--no-color", env=terminal).output
    assert "\x1b" not in check("pass.nc", env=terminal | {"NO_COLOR": "1"}).output
    assert "\x1b" not in check("pass.nc").output


def test_a_process_answers_like_the_function(folder: Path) -> None:
    """Nothing but the report: no progress where stderr is no terminal, no banner of Warp."""
    command = [sys.executable, "-m", "gcodesim", "check", "--machine", "table_tilt", "pass.nc"]
    env = {k: v for k, v in os.environ.items() if k not in ("FORCE_COLOR", "TTY_COMPATIBLE")}
    done = subprocess.run(command, capture_output=True, text=True, env=env, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("PASS  pass.nc on table_tilt (unverified model)")


@pytest.mark.parametrize("terminal", [True, False])
def test_progress_is_drawn_on_a_terminal_only(
    terminal: bool, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A clock of our own: the bar appears after the first second."""
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(sys.stderr, "isatty", lambda: terminal)
    clock = iter([0.0, 0.5, 2.0])
    monkeypatch.setattr("gcodesim.cli.arguments.time.monotonic", lambda: next(clock, 3.0))
    with progress_bar("part.nc", quiet=False) as advance:
        advance(0.1)
        early = capsys.readouterr()
        advance(0.6)
    shown = capsys.readouterr()
    assert early.err == early.out == shown.out == ""
    assert ("checking part.nc" in shown.err) == terminal
    assert terminal or shown.err == ""


@pytest.mark.usefixtures("folder")
def test_canon_prints_json_lines_and_knows_the_exit_codes() -> None:
    result = run("canon", "-", input="G21 G90\nG0 X20 Y10\nM30\n")
    assert result.exit_code == 0
    assert all(isinstance(json.loads(line), dict) for line in result.stdout.splitlines())
    for name, code, why in (("fail.nc", 1, "2: GC405"), ("unclear.nc", 3, "3: GC40")):
        result = run("canon", name)
        assert (result.exit_code, result.stderr.startswith(f"{name}:{why}")) == (code, True)


def test_schema_and_show_print_what_they_say() -> None:
    schema = json.loads(run("machine", "schema", "tools").stdout)
    assert schema["title"] == "gcodesim tools file"
    assert "kinematic tree" in run("machine", "show", "table_tilt").stdout


@pytest.mark.parametrize("option", ["--clearance", "--feed"])
@pytest.mark.parametrize("value", ["nan", "inf"])
def test_numbers_must_be_finite(option: str, value: str) -> None:
    """A clearance of nan would compare false everywhere and check nothing, in silence."""
    result = CliRunner().invoke(main, ["check", "x.nc", "--machine", "table_tilt", option, value])
    assert (result.exit_code, "expected a finite number" in result.output) == (2, True)


@pytest.mark.parametrize("command", ["check", "canon"])
def test_a_program_without_end_ends_at_the_limit(command: str, folder: Path) -> None:
    (folder / "endless.nc").write_text("G0 X1\nWHILE[1EQ1]DO1\nX2\nX1\nEND1\nM30\n")
    result = run(command, "--machine", "table_tilt", "--max-blocks", "50", "endless.nc")
    assert result.exit_code == 3
    assert "limit of 50 blocks" in (result.stdout if command == "check" else result.stderr)
    assert run(command, "--max-blocks", "0", "endless.nc").exit_code == 2
