"""The command trace: rows where the axes are, commanded and real."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from gcodesim.cli import main

PROGRAM = "G21 G90 G94\nT1 M6\nG1 X-1. F6000.\nG4 P100\nG1 X1. Y2. C30. F600.\nM30\n"

MACHINE = """
name: slide
links: {bed: {}, X: {box: {size: [10, 10, 10], center: [0, 0, 0]}}}
joints:
  X: {type: linear, parent: bed, child: X, axis: [1, 0, 0], limits: [-100, 100], rapid: 24000,
      servo: {order: 1, time_constant: 0.01}}
"""


def rows(tmp_path: Path, *args: str, program: str = PROGRAM) -> list[list[str]]:
    (tmp_path / "part.nc").write_text(program)
    done = CliRunner().invoke(main, ["trace", str(tmp_path / "part.nc"), *args])
    assert done.exit_code == 0, done.output
    return [line.split(",") for line in done.stdout.splitlines()]


def test_rows_are_where_the_axes_are(tmp_path: Path) -> None:
    header, *found = rows(tmp_path, "--machine", "table_tilt", "--every", "5ms")
    assert header == ["time_s", "line", *"YXACZ"]
    times = [float(row[0]) for row in found]
    # 1 mm at 100 mm/s, 0.1 s of dwell, then sqrt(8) mm at 10 mm/s.
    assert times[-1] == pytest.approx(0.01 + 0.1 + 0.1 * 8**0.5, abs=1e-9)
    assert times[:-1] == pytest.approx(0.005 * np.arange(len(times) - 1), abs=1e-12)
    at = dict(zip(times, found, strict=True))
    assert at[0.005][1:4] == ["3", "0.000000000", "-0.500000000"]
    assert at[0.06][1:4] == ["4", "0.000000000", "-1.000000000"]
    assert [float(q) for q in found[-1][2:6]] == pytest.approx([2.0, 1.0, 0.0, 30.0], abs=1e-9)


def test_real_positions_lag_behind(tmp_path: Path) -> None:
    (tmp_path / "m.yaml").write_text(MACHINE)
    program = "G21 G90 G94\nG1 X50. F6000.\nM30\n"
    machine = ["--machine", str(tmp_path / "m.yaml"), "--every", "50ms"]
    commanded = [float(row[2]) for row in rows(tmp_path, *machine, program=program)[1:]]
    real = [float(row[2]) for row in rows(tmp_path, *machine, "--real", program=program)[1:]]
    t = 0.05 * np.arange(len(real))
    # A ramp of 100 mm/s through a lag of 10 ms: y = v (t - tau (1 - exp(-t/tau))).
    expected = 100.0 * (t - 0.01 * -np.expm1(-t / 0.01))
    assert commanded == pytest.approx(100.0 * t, abs=1e-8)
    assert real == pytest.approx(expected, abs=1e-8)


def test_npz_holds_the_same(tmp_path: Path) -> None:
    file = tmp_path / "out.npz"
    header, *found = rows(tmp_path, "--machine", "table_tilt", "--every", "7ms")
    assert rows(tmp_path, "--machine", "table_tilt", "--every", "7ms", "--npz", str(file)) == []
    with np.load(file) as columns:
        assert list(columns["axes"]) == header[2:]
        assert columns["time_s"] == pytest.approx([float(row[0]) for row in found], abs=1e-9)
        assert columns["line"].tolist() == [int(row[1]) for row in found]
        assert columns["positions"] == pytest.approx(
            np.array([row[2:] for row in found], float), abs=1e-8
        )


@pytest.mark.parametrize(
    ("text", "code", "said"),
    [("G1 X1.\nM30\n", 1, "GC405"), ("G21 G0 X1.\nG188 X2.\nM30\n", 3, "GC402")],
)
def test_where_the_program_ends_early_is_said(
    tmp_path: Path, text: str, code: int, said: str
) -> None:
    (tmp_path / "part.nc").write_text(text)
    args = ["trace", str(tmp_path / "part.nc"), "--machine", "table_tilt"]
    done = CliRunner().invoke(main, args)
    assert (done.exit_code, said in done.stderr) == (code, True), done.stderr
    args.append("--real")
    assert CliRunner().invoke(main, args).exit_code == 2


def test_the_end_of_the_clock_is_said(tmp_path: Path) -> None:
    (tmp_path / "part.nc").write_text("G21 G90 G94\nT1 M6\nG1 X1. F6000.\nG1 X2. F0.000001\nM30\n")
    args = ["trace", str(tmp_path / "part.nc"), "--machine", "table_tilt"]
    done = CliRunner().invoke(main, args)
    assert (done.exit_code, "GC424" in done.stderr) == (3, True), done.stderr
