"""Jobs: which programs are found, in which order, and what makes an answer an old one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from gcodesim.batch.jobs import Job, prepare, shard_of
from gcodesim.batch.programs import find_programs
from gcodesim.checking.options import Options
from gcodesim.checking.request import CheckRequest
from gcodesim.errors import UsageError
from gcodesim.machine.files import files_of

MACHINE = """
name: slide
links: {bed: {box: {size: [1, 1, 1]}}, X: {mesh: x.stl}}
joints: {X: {type: linear, parent: bed, child: X, axis: [1, 0, 0], limits: [0, 9], rapid: 600}}
"""
SETUP = """
machine: m.yaml
tools: t.yaml
bodies: {part: {link: X, role: part, parts: [{name: a, mesh: p.stl}]}}
"""
TOOLS = "tools: [{number: 1, length: 9, flute: {mesh: f.stl}}]"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    texts = {"m.yaml": MACHINE, "s.yaml": SETUP, "t.yaml": TOOLS}
    texts |= {name: name for name in ("x.stl", "p.stl", "f.stl", "a.nc", "b.NC", "c.txt", "d/e.nc")}
    (tmp_path / "d").mkdir()
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.usefixtures("folder")
def test_programs_are_found_once_by_folder_glob_and_name() -> None:
    assert find_programs(["."]) == ["a.nc", "b.NC", "d/e.nc"]
    assert find_programs(["**/*.nc"]) == ["a.nc", "d/e.nc"]
    assert find_programs(["c.txt", "d", "*.nc", "d/e.nc", "gone.nc"]) == [
        *("c.txt", "d/e.nc", "a.nc", "gone.nc")
    ]
    with pytest.raises(UsageError, match=r"\*.mpf: no program there"):
        find_programs(["*.nc", "*.mpf"])


def test_endings_shared_with_other_files_count_where_the_text_reads_like_a_program(
    tmp_path: Path,
) -> None:
    texts = {
        "a.txt": "%\nO1 (NAME)\n(COMMENT)\nN10 G0 X1 Y-.5\n#1=5\nG1 Z[#1+2] F#2\nM30\n%\n",
        "b.h": "0 BEGIN PGM B MM\n1 L X+10 FMAX\n2 END PGM B MM\n",
        "c.spf": "R1=5\nG1 X=R1\nTRAORI\nM17\n",
        "d.PTP": "G21 G90\r\nG0X1Y2\r\nM30\r\n",
        "no.h": "#ifndef NO_H\n#define NO_H\nint g0(int x1);\n#endif\n",
        "no.txt": "Tools for G54:\nT1 end mill\nT2 drill M6\n",
        "empty.txt": "",
        "no.iso": "\0" * 40000,
        "tools.i": "X1 2 3\n4 5 6\n",
    }
    for name, text in texts.items():
        (tmp_path / name).write_bytes(text.encode())
    (tmp_path / "folder.txt").mkdir()
    found = [Path(name).name for name in find_programs([str(tmp_path)])]
    assert found == ["a.txt", "b.h", "c.spf", "d.PTP"]


@pytest.mark.usefixtures("folder")
def test_every_file_of_a_machine_is_named() -> None:
    names = [file.name for file in files_of("m.yaml", "s.yaml", None)]
    assert names == ["m.yaml", "s.yaml", "t.yaml", "x.stl", "p.stl", "f.stl"]


ASKED = CheckRequest(setup="s.yaml")
JOB = Job(program="a.nc", machine="m.yaml", asked=ASKED, folder="")


def key(job: Job = JOB) -> str:
    (ready,) = prepare([job])
    assert ready.key
    return ready.key


@pytest.mark.parametrize("file", ["a.nc", "m.yaml", "x.stl", "s.yaml", "p.stl", "t.yaml", "f.stl"])
def test_whatever_the_answer_depends_on_changes_the_key(folder: Path, file: str) -> None:
    before = key()
    assert key() == before
    (folder / file).write_text((folder / file).read_text() + " ")
    assert key() != before


@pytest.mark.usefixtures("folder")
def test_options_and_version_change_the_key_and_the_folder_does_not() -> None:
    others = [
        JOB.with_options(clearance=1.0),
        replace(JOB, version="0.0.0"),
        replace(JOB, asked=replace(ASKED, rapids="dogleg")),
    ]
    assert len({key(), *map(key, others)}) == 4
    assert key(replace(JOB, folder="/elsewhere")) == key()


@pytest.mark.usefixtures("folder")
def test_what_cannot_be_read_has_no_key() -> None:
    missing = [replace(JOB, program="gone.nc"), replace(JOB, machine="gone.yaml")]
    assert [job.key for job in prepare(missing)] == ["", ""]


def test_longest_first_and_every_shard_gets_its_share(folder: Path) -> None:
    names = []
    for size in range(10):
        names.append(f"{size}.nc")
        (folder / names[-1]).write_text(size * "\n")
    jobs = prepare(Job(program=name, machine="m.yaml") for name in names)
    assert [job.program for job in jobs] == names[::-1]
    shards = [shard_of(jobs, index, 3) for index in (1, 2, 3)]
    assert sorted(job.program for shard in shards for job in shard) == names
    assert [shard[0].size for shard in shards] == [9, 8, 7]


def test_a_job_survives_its_line_of_json() -> None:
    asked = replace(ASKED, select=("GC2",), ignore=("GC102=dummy", "GC430"))
    job = replace(JOB, asked=asked, size=3, key="k", model="m")
    job = job.with_options(feed=100.0, minimum=True)
    assert "\n" not in job.as_json()
    assert Job.from_json(job.as_json()) == job


def test_the_label_names_every_option_that_a_batch_has_not_by_itself() -> None:
    usual = Options(nearest=True)
    assert replace(JOB, asked=replace(ASKED, options=usual)).label["options"] == []
    asked = CheckRequest(
        setup="s.yaml",
        tools="t.yaml",
        allow_outside=True,
        options=Options(period_ps=10**9, clearance=2.5, stop_all=True, device="cpu", threads=3),
        fail_on="note",
        ignore=("GC102=dummy", "GC430"),
    )
    assert replace(JOB, asked=asked).label["options"] == [
        "--tools t.yaml",
        "--allow-outside",
        "--fail-on note",
        "--ignore GC102=dummy",
        "--ignore GC430",
        "--sample-period 1ms",
        "--clearance 2.5",
        "--stop all",
        "--no-min-clearance",
    ]
