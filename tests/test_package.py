"""The package: a quick --help, and a wheel that carries its machines."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

from gcodesim import __version__

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


@pytest.mark.parametrize(
    "args", [["--help"], ["check", "--help"], ["batch", "--help"], ["--version"]]
)
def test_help_loads_nothing_heavy(args: list[str]) -> None:
    """What makes a start slow is imported inside the commands, or not at all."""
    code = (
        "import sys\n"
        "from gcodesim.cli import main\n"
        f"main({args!r}, standalone_mode=False)\n"
        "heavy = {'warp', 'trimesh', 'numpy', 'pydantic', 'yaml', 'rich', 'scipy', 'dask'}\n"
        "assert not heavy & set(sys.modules), heavy & set(sys.modules)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_a_check_needs_no_scipy_networkx_or_gl(tmp_path: Path) -> None:
    (tmp_path / "part.nc").write_text("G21 G90\nT1 M6\nG0 X20\nM30\n")
    code = (
        "import sys\n"
        "for name in ('scipy', 'networkx', 'OpenGL', 'pyglet', 'matplotlib', 'dask'):\n"
        "    sys.modules[name] = None\n"  # importing it raises ImportError
        "from gcodesim.cli import main\n"
        "main(['check', 'part.nc', '--machine', 'table_tilt', '--device', 'cpu'])\n"
    )
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("PASS  part.nc")


def test_version_and_extras() -> None:
    assert PROJECT["version"] == __version__
    assert PROJECT["requires-python"] == ">=3.11"
    assert PROJECT["license"] == "Apache-2.0"
    assert set(PROJECT["optional-dependencies"]) == {"plot", "cluster", "dev"}


def test_the_wheel_carries_machines_and_licence(tmp_path: Path) -> None:
    """Built from a copy, without network: hatchling comes with the extra dev."""
    tree = tmp_path / "tree"
    for name in ("gcodesim", "machines"):
        shutil.copytree(ROOT / name, tree / name, ignore=shutil.ignore_patterns("__pycache__"))
    (tree / "samples").mkdir()
    for name in ("pyproject.toml", "README.md", "LICENSE", "samples/part.nc"):
        shutil.copy(ROOT / name, tree / name)
    build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(tmp_path)]
    done = subprocess.run([*build, str(tree)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    (wheel,) = tmp_path.glob("*.whl")
    names = set(zipfile.ZipFile(wheel).namelist())
    for file in (*(ROOT / "machines").glob("*.yaml"), *(ROOT / "machines").glob("*/*.stl")):
        assert f"gcodesim/{file.relative_to(ROOT).as_posix()}" in names
    for file in (ROOT / "gcodesim/report/viewer").iterdir():
        assert f"gcodesim/report/viewer/{file.name}" in names
    assert {"gcodesim/starter/part.nc", "gcodesim/starter/setup.yaml"} <= names
    assert any(name.endswith("licenses/LICENSE") for name in names)
    assert any(name.endswith("licenses/gcodesim/report/viewer/three.LICENSE") for name in names)
    assert not any(name.startswith(("tests", "samples")) for name in names)
