"""Files that hold several main programs: the others are named, or checked on their own."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

import gcodesim
from gcodesim.cli import main

HEAD = "G21 G17 G40 G49 G80 G90 G94 G54\nT1 M6\nS8000 M3\nG0 X0. Y0.\n"
SAFE, LOW = f"{HEAD}G43 H1 Z100.\n", f"{HEAD}G43 H1 Z-20.\n"
FILE = f"%\nO10 (FIRST)\n{SAFE}M98 P30\nM30\nO20 (SECOND)\n{LOW}M30\nO30\nG0 Z90.\nM99\n%\n"
"""A safe main program, one that drives into the table, and a subprogram of the first."""


def checked(folder: Path, text: str, *options: str) -> Result:
    file = folder / "part.nc"
    file.write_text(text)
    given = ["check", str(file), "--machine", "table_tilt", "--device", "cpu"]
    given += ["--dialect", "fanuc", *options]
    return CliRunner().invoke(main, given, env={"CI": None})


def reports(result: Result) -> list[dict]:
    found = json.loads(result.stdout)
    return found if isinstance(found, list) else [found]


def test_a_second_main_program_is_named_where_it_was_not_run(tmp_path):
    result = checked(tmp_path, FILE, "--format", "json")
    (report,) = reports(result)
    assert (result.exit_code, report["verdict"]) == (0, "pass")
    (note,) = report["findings"]
    assert (note["code"], note["severity"], note["line"]) == ("GC430", "note", 10)
    assert note["message"] == (
        "not run: the file also holds O20: check --all-programs checks each main program of a file"
    )
    assert report["coverage"]["not_run"] == [
        {"what": "programs of the file that were not called", "count": 1, "line": 10}
    ]


def test_each_main_program_has_a_verdict_and_the_worst_counts(tmp_path):
    result = checked(tmp_path, FILE, "--all-programs", "--format", "json")
    first, second = reports(result)
    assert result.exit_code == 1
    assert (first["verdict"], first.get("main_program"), first["findings"]) == ("pass", None, [])
    assert (second["verdict"], second["main_program"]) == ("fail", "O20")
    assert [(f["code"], f["line"]) for f in second["findings"]] == [("GC102", 15)]
    assert second["program"] == first["program"]


@pytest.mark.parametrize(
    ("form", "words"),
    [
        ("text", ["part.nc on table_tilt", "part.nc O20 on table_tilt"]),
        ("junit", ['part.nc"', 'part.nc O20"']),
        ("github", ["(O20 on table_tilt)"]),
        ("jsonl", ['"main_program":"O20"']),
        ("sarif", ["part.nc O20"]),
        ("gitlab", ["(O20 on table_tilt)"]),
    ],
)
def test_reports_say_which_program_is_meant(tmp_path, form, words):
    result = checked(tmp_path, FILE, "--all-programs", "--format", form)
    assert all(word in result.stdout for word in words)


def test_pictures_of_each_program_have_names_of_their_own(tmp_path):
    checked(tmp_path, FILE, "--all-programs", "--html", str(tmp_path / "motion.html"))
    pages = sorted(page.name for page in tmp_path.glob("*.html"))
    assert pages == ["motion-part-O20.html", "motion-part.html"]


def test_standard_input_is_read_once_for_all_programs():
    given = ["check", "-", "--machine", "table_tilt", "--all-programs", "--quiet"]
    result = CliRunner().invoke(main, given, input=FILE)
    assert result.exit_code == 1
    assert "<stdin> O20 on table_tilt" in result.stdout


def test_a_baseline_knows_one_program_from_the_other(tmp_path):
    """Both go through the same block into the table: each needs an entry of its own."""
    twice = f"O10\n{LOW}M30\nO20\n{LOW}M30\n"
    known = str(tmp_path / "known.json")
    options = ["--format", "json", "--baseline", known]
    checked(tmp_path, twice, "--update-baseline", *options)
    entries = json.loads(Path(known).read_text())["entries"]
    for entry in entries:
        entry["reason"] = "the table is not mounted"
    Path(known).write_text(json.dumps({"schema": "gcodesim.baseline/1", "entries": entries}))
    first, second = reports(checked(tmp_path, twice, "--all-programs", *options))
    assert [f["code"] for f in first["suppressed"]] == ["GC102"]
    assert (second["verdict"], second["suppressed"]) == ("fail", [])


def test_a_program_that_cannot_be_read_is_told_once(tmp_path):
    missing = str(tmp_path / "missing.nc")
    given = ["check", missing, "--machine", "table_tilt", "--all-programs"]
    result = CliRunner().invoke(main, given)
    assert result.exit_code == 2
    assert result.stderr.count("missing.nc") == 1


@pytest.mark.parametrize(
    ("text", "others"),
    [
        ("O1\nM30\nO2\nM30\nO3\nM2\n", "O2, O3"),
        ("O1\nM30\nO2\nX1\nM99\n", ""),  # a subprogram that nothing calls
        ("O1\nM30\nO2\nX1\n", "O2"),  # neither end nor return: not known to be called
        ("O1\nM30\nO2\n(M99)\nM30\n", "O2"),
        ("O1\nM30\nO2\nM97P5\nM030\nN5X1\nM99\n", "O2"),  # with a subprogram of its own
        ("O1\nM98P2\nM30\nO2\nX1\nM30\n", ""),  # called, and ended there
        ("O1\nX1\nO2\nX2\nM30\n", ""),  # ran on into it
        ("<ONE>\nM30\n<TWO>\nM30\n", "<TWO>"),
    ],
)
def test_a_main_program_ends_by_itself(tmp_path, text, others):
    file = tmp_path / "part.nc"
    file.write_text(text)
    options = gcodesim.Options(device="cpu", dialect="fanuc")
    result = gcodesim.check(file, "table_tilt", options=options)
    found = [f.message for f in result.findings if f.meaning == "other_programs"]
    assert [message.split(": ")[1] for message in found] == (
        [f"the file also holds {others}"] if others else []
    )


@pytest.mark.parametrize("name", ["O2", "<PART>"])
def test_a_main_program_that_is_not_there_is_refused(tmp_path, name):
    file = tmp_path / "part.nc"
    file.write_text("O1\nG0 X1\nM30\n")
    options = gcodesim.Options(device="cpu", main_program=name)
    result = gcodesim.check(file, "table_tilt", options=options)
    assert result.verdict == "inconclusive"
    assert result.findings[0].code == "GC412"


def test_the_program_of_a_linuxcnc_file_is_the_file(tmp_path):
    file = tmp_path / "part.ngc"
    file.write_text("G0 X1\nM2\nO2\nM2\n")
    options = gcodesim.Options(device="cpu", dialect="linuxcnc")
    assert not gcodesim.check(file, "table_tilt", options=options).findings
