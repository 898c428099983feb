"""The options that write pictures: into which files, and when none is written."""

from __future__ import annotations

import shutil
import webbrowser
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from report.checked import SAMPLES

from gcodesim.cli import main
from gcodesim.report import snapshot

CRASH = (SAMPLES / "tilt_into_holder.nc").read_text()
QUIET = "G21 G90\nT1 M6\nS1000 M3\nG0 X20 Y10\nM30\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with programs; pictures are small."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(snapshot.snapshot, "__defaults__", (48,))
    (tmp_path / "crash.nc").write_text(CRASH)
    (tmp_path / "quiet.nc").write_text(QUIET)
    return tmp_path


def check(*args: str) -> Result:
    options = ("--machine", "table_tilt", "--device", "cpu", "--sample-period", "1ms")
    return CliRunner().invoke(main, ["check", *options, *args])


def pictures(folder: Path) -> list[str]:
    return sorted(
        file.relative_to(folder).as_posix()
        for file in folder.rglob("*")
        if file.is_file() and file.suffix != ".nc"
    )


def test_all_pictures_of_one_program(folder: Path) -> None:
    names = ["a.png", "new/b.html", "new/c.glb"]
    asked = ("--snapshot", "--html", "--glb")
    result = check("crash.nc", *(word for both in zip(asked, names, strict=True) for word in both))
    assert (result.exit_code, result.stderr) == (1, "")
    assert pictures(folder) == names
    beginnings = [(folder / name).read_bytes()[:4] for name in pictures(folder)]
    assert beginnings == [b"\x89PNG", b"<!do", b"glTF"]


def test_of_several_programs_each_has_its_own_files(folder: Path) -> None:
    (folder / "other").mkdir()
    shutil.copy("crash.nc", "other/crash.nc")
    result = check(
        "crash.nc", "quiet.nc", "other/crash.nc", "--snapshot", "a.png", "--glb", "g.glb"
    )
    assert result.exit_code == 1
    assert pictures(folder) == [
        *("a-crash-2.png", "a-crash.png"),
        *("g-crash-2.glb", "g-crash.glb", "g-quiet.glb"),
    ]


@pytest.mark.parametrize(
    ("program", "ci", "options", "written"),
    [
        ("crash.nc", "true", [], ["gcodesim-crash.png"]),
        ("crash.nc", "true", ["--snapshot", "none"], []),
        ("crash.nc", "", [], []),
        ("quiet.nc", "true", [], []),
        ("quiet.nc", "", ["--snapshot", "a.png"], []),
        ("quiet.nc", "true", ["--clearance", "300"], ["gcodesim-quiet.png"]),
        ("quiet.nc", "true", ["--clearance", "300", "--ignore", "GC201"], []),
    ],
)
def test_a_snapshot_is_the_default_in_ci_and_only_of_two_bodies_too_near(
    program: str,
    ci: str,
    options: list[str],
    written: list[str],
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("CI", ci)
    result = check(program, *options)
    assert result.exit_code == (program == "crash.nc")
    assert pictures(folder) == written


def test_a_picture_that_cannot_be_written(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "b.html").mkdir()
    result = check("crash.nc", "--html", "b.html")
    assert result.exit_code == 2
    assert result.stdout.startswith("FAIL  crash.nc"), "the report is still given"
    assert "b.html" in result.stderr
    # One that nobody asked for changes nothing but a note.
    monkeypatch.setenv("CI", "true")
    (folder / "gcodesim-crash.png").mkdir()
    result = check("crash.nc")
    assert result.exit_code == 1
    assert result.stderr.startswith("gcodesim: no snapshot: ")


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("option", ["--snapshot", "--html", "--glb"])
def test_a_picture_is_not_written_over_a_program(option: str) -> None:
    result = check("crash.nc", option, "crash.nc")
    assert (result.exit_code, result.stdout) == (2, "")
    assert f"{option} crash.nc: expected the name of a ." in result.stderr
    assert Path("crash.nc").read_text() == CRASH


def test_view_opens_a_replay_and_nothing_else(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[str] = []
    monkeypatch.setattr(webbrowser, "open", lambda address: opened.append(address) or len(opened))
    check("quiet.nc", "--html", "a b.html")
    result = CliRunner().invoke(main, ["view", "a b.html"])
    assert (result.exit_code, opened) == (0, [(folder / "a b.html").as_uri()])
    for page, said in (("missing.html", "does not exist"), ("quiet.nc", "is no replay")):
        result = CliRunner().invoke(main, ["view", page])
        assert (result.exit_code, said in result.stderr) == (2, True)
    monkeypatch.setattr(webbrowser, "open", lambda address: False)
    result = CliRunner().invoke(main, ["view", "a b.html"])
    assert (result.exit_code, "no browser was found" in result.stderr) == (2, True)


def test_pictures_stand_in_a_settings_file(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CI", "true")
    (folder / "below").mkdir()
    shutil.copy("crash.nc", "below/crash.nc")
    (folder / "gcodesim.toml").write_text('snapshot = "none"\nglb = "out/machine.glb"\n')
    monkeypatch.chdir(folder / "below")
    assert check("crash.nc").exit_code == 1
    assert pictures(folder) == ["gcodesim.toml", "out/machine.glb"]
