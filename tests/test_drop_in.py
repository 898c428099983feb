"""What others put into their projects: `init`, the action, the component, the hook, the image."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import pytest
import yaml
from click.testing import CliRunner
from pre_commit.clientlib import load_manifest

from gcodesim.batch.programs import SUFFIXES
from gcodesim.cli import main
from gcodesim.starter import TEMPLATES

ROOT = Path(__file__).parents[1]
WORKFLOW = ROOT / ".github/workflows/ci.yml"
PIN = re.compile(r"uses: ([\w/-]+)@([0-9a-f]{40}) # (v[\d.]+)$", re.MULTILINE)
OPTIONS = "--device cpu"


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A fresh project as working folder, and `gcodesim` on the path."""
    assert CliRunner().invoke(main, ["init", str(tmp_path / "project")]).exit_code == 0
    program = tmp_path / "gcodesim"
    program.write_text(f'#!/bin/sh\nexec {shlex.quote(sys.executable)} -m gcodesim "$@"\n')
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    monkeypatch.chdir(tmp_path / "project")
    return tmp_path / "project"


def bash(script: str, **environment: str) -> int:
    """Exit code of a script, run as GitHub and GitLab run it."""
    command = ["bash", "-e", "-o", "pipefail", "-c", script]
    return subprocess.run(command, env=os.environ | environment, check=False).returncode


def assert_valid(schema: str, *files: Path) -> None:
    """Hold files against a schema that GitHub or GitLab publish, as check-jsonschema carries it."""
    command = [sys.executable, "-m", "check_jsonschema", "--builtin-schema", f"vendor.{schema}"]
    done = subprocess.run([*command, *files], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


def load(path: Path) -> Any:
    return yaml.safe_load(path.read_text(encoding="utf-8"))


@pytest.mark.usefixtures("project")
def test_the_first_check_of_a_new_project_passes() -> None:
    done = CliRunner().invoke(main, ["check", "programs/part.nc"])
    assert (done.exit_code, done.stderr) == (0, "")
    assert done.stdout.startswith("PASS  programs/part.nc on table_tilt")
    assert "cutter-plate" in done.stdout
    by_settings = CliRunner().invoke(main, ["check"])
    assert (by_settings.exit_code, by_settings.stdout) == (0, done.stdout)


def test_the_next_step_that_init_names_works_in_any_folder(tmp_path: Path) -> None:
    folder = tmp_path / "a dir" / "it's new"
    done = CliRunner().invoke(main, ["init", str(folder)])
    (command,) = re.findall(r"^next: (.*)$", done.stderr, re.MULTILINE)
    assert command == f"cd {shlex.quote(str(folder))} && gcodesim batch"
    assert bash(command.replace("gcodesim", f"{shlex.quote(sys.executable)} -m gcodesim")) == 0


@pytest.mark.usefixtures("project")
@pytest.mark.parametrize(
    "name",
    [".github/workflows/gcodesim.yml", pytest.param(".gitlab-ci.yml", marks=pytest.mark.slow)],
)
def test_the_ci_file_of_a_new_project_runs_and_keeps_all(name: str) -> None:
    text = Path(name).read_text()
    steps = [line.strip() for line in text.splitlines()]
    (command,) = (s.removeprefix("- ").removeprefix("run: ") for s in steps if " batch " in s)
    assert bash(command, CI="true") == 0
    assert "1 checks: 1 PASS" in Path("overview.html").read_text()
    assert "@VERSION@" not in text
    assert "gcodesim==" not in text  # anybody could take this name on the package index
    add_a_crash(Path())
    assert bash(command, CI="true", GITHUB_STEP_SUMMARY="summary.md") == 1
    assert_all_is_kept(load(Path(name)), command, Path("overview.html"))
    ignored = Path(".gitignore").read_text().splitlines()
    made = {path.name for path in Path().iterdir() if path.is_file()} - {"summary.md"}
    kept = {name for name in made if not any(fnmatch(name, pattern) for pattern in ignored)}
    made_by_init = {"gcodesim.toml", "setup.yaml", "setup.schema.json", ".gitignore"}
    assert kept == made_by_init | {".gitlab-ci.yml"}


def add_a_crash(project: Path) -> None:
    """A program that fails: of two programs one has a picture."""
    (project / "programs/crash.nc").write_text((ROOT / "samples/tilt_into_holder.nc").read_text())


def assert_all_is_kept(file: Any, command: str, page: Path) -> None:
    """Page, pictures and reports of a run are among the artifacts of a CI file."""
    links = re.findall(r'href="\./([^"]+)"', page.read_text())
    assert links == ["gcodesim-crash.png"]
    patterns = list(words(file, "path", "paths"))
    for name in (page.name, *links):
        assert (page.parent / name).is_file()
        assert any(fnmatch(name, pattern) for pattern in patterns)
    reports = set(re.findall(r"--report [a-z]+=([^-\s]\S*)", command))
    assert reports == set(words(file, "junit", "codequality"))
    assert all((page.parent / name).is_file() for name in reports)


def words(value: Any, *keys: str, inside: bool = False) -> Iterator[str]:
    """Yield the words of all texts below some keys of a YAML file."""
    if isinstance(value, str) and inside:
        yield from value.split()
    elif isinstance(value, list):
        for item in value:
            yield from words(item, *keys, inside=inside)
    elif isinstance(value, dict):
        for key, item in value.items():
            yield from words(item, *keys, inside=key in keys)


@pytest.mark.usefixtures("project")
def test_the_settings_of_the_readme_work_in_a_new_project() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    (settings,) = re.findall(r"^```toml\n(.*?)```$", readme, re.MULTILINE | re.DOTALL)
    Path("gcodesim.toml").write_text(settings)
    for command in ("batch", "check"):
        done = CliRunner().invoke(main, [command])
        assert (done.exit_code, done.stderr) == (0, "")
        assert Path("out/gcodesim.xml").is_file()
        Path("out/gcodesim.xml").unlink()
    with_baseline = ["batch", "--baseline", "accepted.json"]
    (makes,) = re.findall("`(.*)` makes it", CliRunner().invoke(main, with_baseline).stderr)
    assert bash(makes.replace("PROGRAM...", "programs/part.nc")) == 0
    assert CliRunner().invoke(main, with_baseline).exit_code == 0


def test_ci_files_are_valid_by_the_published_schemas(project: Path) -> None:
    assert_valid("github-actions", ROOT / "action.yml")
    assert_valid("github-workflows", WORKFLOW, project / ".github/workflows/gcodesim.yml")
    # A component is a header and, after it, what is included: two documents.
    documents = (ROOT / "templates/gcodesim.yml").read_text(encoding="utf-8").split("\n---\n")
    files = [project / f"component-{number}.yml" for number in range(len(documents))]
    for file, document in zip(files, documents, strict=True):
        file.write_text(document)
    assert_valid("gitlab-ci", project / ".gitlab-ci.yml", *files)
    misspelt = project / "misspelt.yml"
    misspelt.write_text(documents[1].replace("script:", "scripts:"))
    with pytest.raises(AssertionError, match="scripts"):
        assert_valid("gitlab-ci", misspelt)


def test_init_overwrites_nothing(tmp_path: Path) -> None:
    (tmp_path / "setup.yaml").write_text("mine")
    done = CliRunner().invoke(main, ["init", str(tmp_path)])
    assert (done.exit_code, "setup.yaml there already" in done.stderr) == (2, True)
    assert [path.name for path in tmp_path.iterdir()] == ["setup.yaml"]


def test_actions_are_pinned_and_the_same_everywhere() -> None:
    starter = ROOT / "gcodesim/starter" / TEMPLATES[".github/workflows/gcodesim.yml"]
    pins = {}
    for file in (WORKFLOW, ROOT / "action.yml", starter):
        text = file.read_text(encoding="utf-8")
        found = PIN.findall(text)
        assert len(found) == text.count("uses:"), file
        for action, commit, version in found:
            assert pins.setdefault(action, (commit, version)) == (commit, version), file


@pytest.mark.slow
def test_the_action_runs_and_reads_no_input_as_code(project: Path) -> None:
    action = load(ROOT / "action.yml")
    steps = action["runs"]["steps"]
    assert action["runs"]["using"] == "composite"
    assert all(step["shell"] == "bash" for step in steps if "run" in step)
    assert not any("${{" in step.get("run", "") for step in steps)
    (step,) = (step for step in steps if "gcodesim batch" in step.get("run", ""))
    wanted = set(re.findall(r"inputs\.(\w+)", (ROOT / "action.yml").read_text()))
    assert wanted == set(action["inputs"])
    assert bash(step["run"], PROGRAMS="programs/**/*.nc", OPTIONS=OPTIONS) == 0
    assert (project / "gcodesim.html").is_file()
    add_a_crash(project)
    assert bash(step["run"], PROGRAMS="", OPTIONS=OPTIONS, CI="true") == 1
    assert_all_is_kept(action, step["run"], project / "gcodesim.html")
    assert bash(step["run"], PROGRAMS="programs; touch $(echo pwned)", OPTIONS=OPTIONS) == 2
    assert not (project / "pwned").exists()


@pytest.mark.slow
def test_the_component_runs(project: Path) -> None:
    text = (ROOT / "templates/gcodesim.yml").read_text(encoding="utf-8")
    header, _ = yaml.safe_load_all(text)
    inputs = header["spec"]["inputs"]
    assert set(re.findall(r"\$\[\[ inputs\.(\w+) \]\]", text)) == set(inputs)
    assert "default" not in inputs["package"]  # anybody could take its name on the package index
    given = {"package": "gcodesim.whl", "options": OPTIONS}
    for name, spec in inputs.items():
        text = text.replace(f"$[[ inputs.{name} ]]", given.get(name) or spec["default"])
    _, body = yaml.safe_load_all(text)
    job = body["gcodesim"]
    assert job["script"][0] == 'pip install -q "$PACKAGE"'
    variables = {name: str(value) for name, value in job["variables"].items()}
    del variables["WARP_CACHE_PATH"]
    add_a_crash(project)
    script = "\n".join(job["script"][1:])
    assert bash(script, CI="true", **variables) == 1
    assert_all_is_kept(job, script, project / "gcodesim.html")


def test_the_hook_runs_on_programs_only() -> None:
    (hook,) = load_manifest(str(ROOT / ".pre-commit-hooks.yaml"))
    pattern = re.compile(hook["files"])
    assert all(pattern.search(f"a/b{suffix}") for suffix in SUFFIXES)
    assert not any(pattern.search(name) for name in ("a.py", "nc", "a.nc.txt"))
    program, *args = shlex.split(hook["entry"])
    assert program in tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["scripts"]
    options = ["--machine", "table_tilt", *shlex.split(OPTIONS)]
    done = CliRunner().invoke(main, [*args, str(ROOT / "samples/part.nc"), *options])
    assert done.exit_code == 0


def test_the_image_is_built_from_files_that_are_there() -> None:
    lines = (ROOT / "Dockerfile").read_text(encoding="utf-8").splitlines()
    steps = [line.split() for line in lines if line and not line.startswith("#")]
    assert steps[0] == ["FROM", "python:3.12-slim"]
    copied = {name for word, *names in steps if word == "COPY" for name in names[:-1]}
    assert all((ROOT / name).exists() for name in copied)
    # All that the wheel is made of.
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    wheel = settings["tool"]["hatch"]["build"]["targets"]["wheel"]
    needed = {*wheel["packages"], *wheel["force-include"], "pyproject.toml"}
    assert copied == needed | {settings["project"]["readme"], "LICENSE"}
    assert ["ENTRYPOINT", '["gcodesim"]'] in steps
