"""Settings: found above the programs, beaten by the command line, and named when they are wrong."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from gcodesim.checking.options import Scope
from gcodesim.cli import main
from gcodesim.cli.run_options import MODEL
from gcodesim.cli.settings_file import SettingsFile

PASSES = "G21 G90\nT1 M6\nG0 X20 Y10\nM30\n"
FAILS = "G21 G90\nG1 X10\nM30\n"
MACHINE = 'machine = "table_tilt"\ndevice = "cpu"\nsample-period = "10ms"\n'


@pytest.fixture
def shop(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with programs in parts/ and settings above them."""
    (tmp_path / "parts").mkdir()
    for name, text in {"good.nc": PASSES, "bad.nc": FAILS, "also.nc": PASSES}.items():
        (tmp_path / "parts" / name).write_text(text)
    (tmp_path / "gcodesim.toml").write_text(MACHINE)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def check(*args: str) -> Result:
    return CliRunner().invoke(main, ["check", *args])


def reports(*args: str) -> list[dict]:
    read = json.loads(check("--format", "json", *args).stdout)
    return read if isinstance(read, list) else [read]


def shown(*args: str) -> dict[str, str]:
    lines = check("--show-settings", *args).stdout.splitlines()
    return dict(line.strip().split(" = ", 1) for line in lines if " = " in line)


def test_settings_are_found_above_the_program(
    shop: Path, monkeypatch: pytest.MonkeyPatch, tmp_path_factory: pytest.TempPathFactory
) -> None:
    assert check("parts/good.nc").exit_code == 0
    monkeypatch.chdir(tmp_path_factory.mktemp("elsewhere"))
    assert check(str(shop / "parts/good.nc")).exit_code == 0
    assert check("good.nc").exit_code == 2


def test_the_nearest_file_counts_and_a_project_file_only_with_our_table(shop: Path) -> None:
    project = shop / "parts/pyproject.toml"
    project.write_text("[tool.other]\nfeed = 1\n")
    assert check("parts/bad.nc").exit_code == 1
    project.write_text('[tool.gcodesim]\nmachine = "table_tilt"\nfeed = 500\n')
    assert check("parts/bad.nc").exit_code == 0
    (shop / "parts/gcodesim.toml").write_text(MACHINE)
    assert check("parts/bad.nc").exit_code == 1


def test_the_command_line_wins(shop: Path) -> None:
    (report,) = reports("parts/good.nc", "--sample-period", "5ms")
    assert report["sample_period_s"] == 0.005
    (shop / "gcodesim.toml").write_text(MACHINE + 'format = "json"\nignore = ["GC430"]\n')
    assert json.loads(check("parts/good.nc").stdout)["verdict"] == "pass"
    assert check("parts/good.nc", "--format", "text").stdout.startswith("PASS")


def test_files_are_counted_from_the_settings(shop: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (shop / "setup.yaml").write_text("machine: table_tilt\n")
    text = 'setup = "setup.yaml"\nreport = ["junit=out/r.xml", "github=-"]\ndevice = "cpu"\n'
    (shop / "gcodesim.toml").write_text(text)
    monkeypatch.chdir(shop / "parts")
    assert check("bad.nc").stdout.count("::error") == 1
    assert (shop / "out/r.xml").read_text().startswith("<?xml")


def test_jobs_are_carried_out_without_programs(shop: Path) -> None:
    job = '[[jobs]]\nprograms = ["parts/*o*.nc"]\n'
    other = '[[jobs]]\nprograms = ["parts/bad.nc"]\nmachine = "head_tilt"\nfeed = 500\n'
    (shop / "gcodesim.toml").write_text(MACHINE + job + other)
    done = [(r["program"], r["machine"], r["verdict"]) for r in reports()]
    assert done == [
        ("parts/also.nc", "table_tilt", "pass"),
        ("parts/good.nc", "table_tilt", "pass"),
        ("parts/bad.nc", "head_tilt", "pass"),
    ]
    # A program that is named keeps its job, unless the command line says otherwise.
    assert [r["machine"] for r in reports("parts/bad.nc")] == ["head_tilt"]
    (aside,) = reports("parts/bad.nc", "--machine", "table_tilt")
    assert (aside["machine"], aside["verdict"]) == ("table_tilt", "fail")


def test_a_program_may_belong_to_several_machines_or_none(shop: Path) -> None:
    jobs = "".join(
        f'[[jobs]]\nprograms = ["parts/g*.nc"]\nmachine = "{machine}"\n'
        for machine in ("table_tilt", "head_tilt")
    )
    (shop / "gcodesim.toml").write_text(MACHINE + jobs)
    done = [(r["program"], r["machine"]) for r in reports("parts/good.nc", "parts/also.nc")]
    assert done == [
        ("parts/good.nc", "table_tilt"),
        ("parts/good.nc", "head_tilt"),
        ("parts/also.nc", "table_tilt"),
    ]


def test_show_settings_says_what_is_in_force_and_why(shop: Path) -> None:
    job = '[[jobs]]\nprograms = ["parts/g*.nc"]\nfeed = 500\n'
    (shop / "gcodesim.toml").write_text(MACHINE + "quiet = true\n" + job)
    found = shown("--stop", "all")
    assert found["machine"].split() == ["table_tilt", "(gcodesim.toml)"]
    assert found["sample-period"].split() == ["10ms", "(gcodesim.toml)"]
    assert found["quiet"].split() == ["true", "(gcodesim.toml)"]
    assert found["stop"].split() == ["all", "(command", "line)"]
    assert found["method"].split() == ["search", "(default)"]
    assert found["feed"].split() == ["500.0", "(gcodesim.toml:", "jobs[0])"]
    text = check("--show-settings").stdout
    assert text.startswith("settings: gcodesim.toml\n")
    assert "gcodesim.toml: jobs[0]: parts/good.nc\n" in text
    many = job.replace("g*.nc", "*.nc")
    for number in range(10):
        (shop / f"parts/x{number}.nc").write_text(PASSES)
    (shop / "gcodesim.toml").write_text(MACHINE + many)
    assert "parts/x0.nc, parts/x1.nc, and 8 more\n" in check("--show-settings").stdout


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("machine =  ?", "gcodesim.toml: no valid TOML: Invalid value (at line 1, column 12)"),
        ("mashine = 'x'", "gcodesim.toml:1: mashine: unknown key; did you mean 'machine'?"),
        ("update-baseline = true", "gcodesim.toml:1: update-baseline: unknown key; "),
        ("\n\nfeed = 'fast'", "gcodesim.toml:3: feed: 'fast' is not a valid float range."),
        ("feed = true", "gcodesim.toml:1: feed: expected a text or a number, not True"),
        ("quiet = 'yes'", "gcodesim.toml:1: quiet: expected true or false, not 'yes'"),
        ("select = 'GC2'", "gcodesim.toml:1: select: expected a list of texts, not 'GC2'"),
        ("stop = 'never'", "gcodesim.toml:1: stop: 'never' is not one of 'first', 'all'."),
        ("sample-period = 1", "gcodesim.toml:1: sample-period: '1': expected a time"),
        (
            "quiet = true\nignore = [\n  'GC1',\n]",
            "gcodesim.toml:2: ignore GC1: a contact is never ignored without a reason",
        ),
        ("[ignore]\nGC402 = 'x'", "gcodesim.toml:1: ignore GC402=x: GC402 cannot be ignored"),
        (
            "report = ['xml=a']",
            "gcodesim.toml:1: report xml=a: unknown format 'xml'; valid: text, json",
        ),
        ("report = ['junit']", "gcodesim.toml:1: report junit: expected FORMAT=PATH"),
        ("method = 'paper'\naudit = true", "gcodesim.toml:2: audit needs --method search, not"),
        ("baseline = 'no.json'", "no.json: there is no such file"),
        ("jobs = 1", "gcodesim.toml:1: jobs: expected [[jobs]], a list of tables"),
        ("[[jobs]]\nfeed = 1", "gcodesim.toml:1: jobs[0].programs: expected a list of patterns"),
        ("[[jobs]]\nprograms = ['*.nc']", "gcodesim.toml:2: jobs[0].programs: no file matches"),
        ("[[jobs]]\nprograms = ['/x']", "gcodesim.toml:2: jobs[0].programs: no file matches '/x'"),
        (
            "[[jobs]]\nprogram = ['x']",
            "gcodesim.toml:2: jobs[0].program: unknown key; did you mean",
        ),
        ("\n[[job]]\nprograms = ['x']", "gcodesim.toml:2: job: unknown key; did you mean 'jobs'?"),
        ("ignore = {GC102 = 3}", "gcodesim.toml:1: ignore: GC102: expected a text, not 3"),
        ("device = 'gpu'", "gcodesim.toml:1: device: 'gpu': expected auto, cpu, cuda or cuda:N"),
        ("quiet = true\nsnapshot = 'a.jpg'", "gcodesim.toml:2: snapshot a.jpg: expected the name"),
        ("setup = 's.yaml'", "gcodesim.toml:1: setup: s.yaml: there is no such file"),
        (
            "[[jobs]]\nprograms = ['parts']\nmachine = 'table_tillt'",
            "gcodesim.toml:3: jobs[0].machine: no machine file 'table_tillt', and no machine of",
        ),
        (
            "[[jobs]]\nprograms = ['parts']\nmachine = []",
            "gcodesim.toml:3: jobs[0].machine: expected a machine, or a list of machines, not []",
        ),
        (
            "report = ['junit=gcodesim.toml']",
            "gcodesim.toml:1: report junit=gcodesim.toml: gcodesim.toml is the settings file",
        ),
        (
            "[[jobs]]\nprograms = ['x']\nformat = 'json'",
            "gcodesim.toml:3: jobs[0].format: holds for the whole run",
        ),
        (
            "feed = 1 # feed = 2\n[[jobs]]\nprograms = ['x']\n[[jobs]]\nprograms = ['x']\nfed = 1",
            "gcodesim.toml:6: jobs[1].fed: unknown key",
        ),
    ],
)
def test_a_wrong_file_is_named_with_what_would_be_right(
    shop: Path, text: str, message: str
) -> None:
    (shop / "gcodesim.toml").write_text(f"{text}\n")
    programs = [] if "jobs" in text else ["parts/good.nc", "--machine", "table_tilt"]
    result = check(*programs)
    assert result.exit_code == 2
    assert message in result.stderr
    assert "Traceback" not in result.stderr


def test_lines_are_those_of_the_keys_whatever_stands_around_them(shop: Path) -> None:
    """Texts and lists over several lines, comments, other tables, and keys in quotes."""
    (shop / "pyproject.toml").write_text(
        '[project]\nfeed = 1\nnote = """\n[tool.gcodesim]\nfeed = 2\n"""\n'
        '[tool.gcodesim] # feed = 3\nreport = [\n  # feed = 4\n  "json=a",\n]\n"feed" = "fast"\n'
    )
    (shop / "gcodesim.toml").unlink()
    assert "pyproject.toml:12: feed: 'fast' is not" in check("parts/good.nc").stderr


AWKWARD = r'''
# [feed] = "1"
note = """ # no comment
[jobs]
feed = 2 \"""""
other = ''
[tool."x # ]".'y "']
list = [  # ]]
  "]", '"', # "
  { a = [1,
  2], "b = [" = """ } """ },
]
"a = 'b" = 3
c.d."e.f" = """""\\"""
[[jobs]]
programs = [""]
[[jobs]] # second
machine = """
table_tilt"""
last = 1'''


def test_every_key_of_an_awkward_file_is_found_in_its_line(tmp_path: Path) -> None:
    file = tmp_path / "gcodesim.toml"
    file.write_text(AWKWARD)
    assert tomllib.loads(AWKWARD)["jobs"][1] == {"machine": "table_tilt", "last": 1}
    tool = ("tool", "x # ]", 'y "')
    assert SettingsFile(str(file)).lines == {
        (): 3,
        ("note",): 3,
        ("other",): 6,
        tool[:-1]: 7,
        tool: 7,
        (*tool, "list"): 8,
        (*tool, "a = 'b"): 13,
        (*tool, "c"): 14,
        ("jobs",): 15,
        ("jobs", 0): 15,
        ("jobs", 0, "programs"): 16,
        ("jobs", 1): 17,
        ("jobs", 1, "machine"): 18,
        ("jobs", 1, "last"): 20,
    }


def test_every_character_of_a_long_file_is_parsed_once_to_find_a_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    parsed, loads = list[str](), tomllib.loads

    def counting(text: str) -> dict[str, Any]:
        parsed.append(text)
        return loads(text)

    names = "".join(f"  'part{number}.nc', # [\n" for number in range(5000))
    text = f"{names}]\nnote = '''\n{names}'''\n" + "# and so on\nfeed = 1\n" * 5000
    file = tmp_path / "gcodesim.toml"
    file.write_text(f"[[jobs]]\nprograms = [\n{text.replace('feed', 'f{}')}".format(*range(5000)))
    monkeypatch.setattr(tomllib, "loads", counting)
    lines = SettingsFile(str(file)).lines
    assert lines["jobs", 0, "note"] == 5004
    assert lines["jobs", 0, "f4999"] == len(file.read_text().splitlines())
    assert sum(map(len, parsed)) <= len(file.read_text())


def test_a_job_may_have_several_machines(shop: Path) -> None:
    job = '[[jobs]]\nprograms = ["parts/good.nc"]\nmachine = ["table_tilt", "head_tilt"]\n'
    (shop / "gcodesim.toml").write_text('device = "cpu"\nsample-period = "10ms"\n' + job)
    assert [r["machine"] for r in reports()] == ["table_tilt", "head_tilt"]
    done = reports("parts/good.nc", "--machine", "head_tilt", "--machine", "table_tilt")
    assert [r["machine"] for r in done] == ["head_tilt", "table_tilt"]


def test_every_option_may_stand_where_its_field_says_and_nowhere_else(shop: Path) -> None:
    for each in MODEL:
        name, scope = each.option.name, each.option.scope
        top, job = (
            "unknown key; " not in written(shop, f"{name} = 0"),
            written(shop, f"[[jobs]]\nprograms = ['parts']\n{name} = 0"),
        )
        if name != "jobs":  # there these are what is to be done
            assert top is (scope is not Scope.COMMAND_LINE), name
        assert ("holds for the whole run" in job) is (scope is Scope.RUN), name
        assert ("unknown key; " in job) is (scope is Scope.COMMAND_LINE), name


def written(shop: Path, text: str) -> str:
    """What `check` has to say about settings."""
    (shop / "gcodesim.toml").write_text(f"{text}\n")
    return check("--show-settings", "parts/good.nc").output


def test_a_job_of_every_option_shows_what_was_written(shop: Path) -> None:
    """Field, key, value on the command line and value that is shown are one model."""
    values = {
        **{"machine": "head_tilt", "setup": "s.yaml", "tools": "t.yaml", "rapids": "dogleg"},
        **{"allow-outside": True, "dialect": "haas", "feed": 12.5, "block-delete": True},
        **{"max-blocks": 7, "sample-period": "2ms", "method": "search", "between-samples": "off"},
        **{"clearance": 1.5, "min-clearance": True, "stop": "all", "audit": True},
        **{"fail-on": "note", "select": ["GC2"], "ignore": ["GC430"]},
    }
    of_jobs = {each.option.name for each in MODEL if each.option.scope is Scope.JOB}
    assert values.keys() == of_jobs
    lines = "".join(f"{name} = {json.dumps(value)}\n" for name, value in values.items())
    (shop / "gcodesim.toml").write_text(f"[[jobs]]\nprograms = ['parts/good.nc']\n{lines}")
    found = shown()
    for name, value in values.items():
        (item,) = value if isinstance(value, list) else [value]
        text = str(item).lower() if isinstance(item, bool) else str(item)
        if name != "method":  # the same as at the top, and not shown again
            assert found[name].split()[0] == text, name


@pytest.mark.parametrize("pattern", [".", "parts", "parts/", "{shop}/parts/*.nc"])
def test_a_folder_in_a_job_means_its_programs(shop: Path, pattern: str) -> None:
    (shop / "parts/notes.txt").write_text("no program")
    job = f"[[jobs]]\nprograms = ['{pattern.format(shop=shop)}', 'parts/../parts/bad.nc']\n"
    (shop / "gcodesim.toml").write_text(MACHINE + job)
    names = [Path(report["program"]).name for report in reports()]
    assert names == ["also.nc", "bad.nc", "good.nc"]


@pytest.mark.usefixtures("shop")
def test_what_is_named_twice_is_checked_once() -> None:
    programs = ("parts/good.nc", "./parts/../parts/good.nc")
    machines = ("--machine", "table_tilt", "--machine", "table_tilt.yaml")
    assert [r["program"] for r in reports(*programs, *machines)] == ["parts/good.nc"]


def test_programs_under_different_settings_are_not_mixed(shop: Path) -> None:
    (shop / "other").mkdir()
    (shop / "other/gcodesim.toml").write_text(MACHINE)
    (shop / "other/x.nc").write_text(PASSES)
    result = check("parts/good.nc", "other/x.nc")
    assert result.exit_code == 2
    assert "lie under different settings" in result.stderr
    assert check("parts/good.nc", "other/x.nc", "--settings", "gcodesim.toml").exit_code == 0


def test_settings_that_are_named_must_be_there(shop: Path) -> None:
    for file in ("no.toml", "parts"):
        result = check("parts/good.nc", "--settings", file)
        assert result.exit_code == 2
        assert f"{file}: cannot be read" in result.stderr


@pytest.mark.usefixtures("shop")
def test_one_run_feeds_every_report(shop: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    names = ("text", "json", "jsonl", "junit", "sarif", "github", "gitlab")
    given = [f"--report={name}=out/deep/{name}" for name in names]
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(shop / "summary.md"))
    (shop / "summary.md").write_text("before\n")
    result = check("parts/bad.nc", "parts/good.nc", "parts/no.nc", *given)
    assert result.exit_code == 2
    written = {path.name: path.read_text() for path in (shop / "out/deep").iterdir()}
    assert set(written) == set(names)
    assert all("parts/bad.nc" in text for text in written.values())
    assert written["text"].startswith(result.stdout)
    assert (shop / "summary.md").read_text().startswith("before\n### gcodesim\n")


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (["json=parts"], "parts is a folder"),
        (["json=parts/good.nc"], "parts/good.nc is a program that is checked"),
        (["json=a", "text=./a"], "a is given twice"),
    ],
)
@pytest.mark.usefixtures("shop")
def test_reports_that_would_destroy_something_are_refused(given: list[str], message: str) -> None:
    result = check("parts/good.nc", *(f"--report={text}" for text in given))
    assert result.exit_code == 2
    assert message in result.stderr
    assert Path("parts/good.nc").read_text() == PASSES
