"""Nothing stale: what was read is done again when it changes, and is never overwritten."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from gcodesim.batch.jobs import Job, prepare
from gcodesim.cli import main

MACHINE = """
name: plate
dialect: fanuc
links:
  bed: {box: {size: [100, 100, 10], center: [0, 0, -5]}}
  Z: {box: {size: [40, 40, 40], center: [0, 0, 220]}}
joints:
  Z: {type: linear, parent: bed, child: Z, axis: [0, 0, 1], limits: [-200, 200], rapid: 9000}
tool: {link: Z, gauge_point: [0, 0, 200], axis: [0, 0, 1], mounted: {name: cutter, length: 100,
       for: all, cylinder: {radius: 5, height: 100, center: [0, 0, 150]}}}
work: {link: bed, offsets: {G54: {X: 0, Y: 0, Z: 0}}}
"""
AWAY, CRASH = "O2000\nG1 Z-50. F1000.\nM99\n", "O2000\nG1 Z-105. F1000.\nM99\n"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "m.yaml").write_text(MACHINE)
    (tmp_path / "main.nc").write_text("O1\nG21 G90\nM3 S1000\nM98 P2000\nM30\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(*args: str) -> Result:
    return CliRunner().invoke(main, [*args, "--machine", "m.yaml", "--device", "cpu", "--quiet"])


def batch(*args: str) -> int:
    return run("batch", "main.nc", "--out", "r.jsonl", "--jobs", "1", *args).exit_code


def seconds() -> list[float]:
    rows = [json.loads(line) for line in Path("r.jsonl").read_text().splitlines()]
    return [row["seconds"] for row in rows if "report" in row]


def test_a_subprogram_that_changed_is_checked_again() -> None:
    Path("O2000.nc").write_text(AWAY)
    assert batch() == 0
    assert batch("--resume") == 0
    assert len(seconds()) == 1, "nothing has changed"
    Path("O2000.nc").write_text(CRASH)
    assert batch("--resume") == 1
    assert len(seconds()) == 2


def test_a_subprogram_that_was_missing_or_comes_first_now_is_looked_for_again() -> None:
    assert batch() == 3
    Path("O2000.nc").write_text(AWAY)
    assert batch("--resume") == 0
    Path("O2000.nc").rename("o2000.nc")
    assert batch("--resume") == 0
    assert len(seconds()) == 3
    Path("O2000.nc").write_text(CRASH)
    assert batch("--resume") == 3, "two files of one number, which differ"
    Path("o2000.nc").unlink()
    assert batch("--resume") == 1


def gltf(size: float) -> None:
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], np.float32) * size
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], np.uint16)
    Path("points.bin").write_bytes(corners.tobytes() + faces.tobytes())
    views = [(0, 48, 34962), (48, 24, 34963)]
    content = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"uri": "points.bin", "byteLength": 72}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": o, "byteLength": n, "target": t} for o, n, t in views
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"},
        ],
    }
    Path("bed.gltf").write_text(json.dumps(content))


def test_the_points_of_a_mesh_in_a_file_beside_it_belong_to_the_key() -> None:
    text = MACHINE.replace("box: {size: [100, 100, 10], center: [0, 0, -5]}", "mesh: bed.gltf")
    Path("m.yaml").write_text(text)
    keys = []
    for size in (10.0, 20.0):
        gltf(size)
        (job,) = prepare([Job(program="main.nc", machine="m.yaml")])
        keys.append(job.key)
    assert keys[0]
    assert keys[0] != keys[1]
    before = Path("points.bin").read_bytes()
    Path("link.bin").symlink_to("points.bin")
    for name in ("points.bin", "link.bin", "./points.bin"):
        result = run("check", "main.nc", "--report", f"json={name}")
        assert result.exit_code == 2
        assert "a file of machine, setup or tools" in result.stderr
    assert Path("points.bin").read_bytes() == before


def test_the_step_summary_is_no_file_that_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    Path("O2000.nc").write_text(AWAY)
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", "m.yaml")
    result = run("check", "main.nc", "--format", "github")
    assert result.exit_code == 2
    assert "GITHUB_STEP_SUMMARY m.yaml: m.yaml is a file of machine" in result.stderr
    assert Path("m.yaml").read_text() == MACHINE
