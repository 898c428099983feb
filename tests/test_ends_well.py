"""Whatever is read, written, closed or interrupted: one line and the right exit code."""

from __future__ import annotations

import gc
import importlib.util
import io
import json
import os
import stat
import subprocess
import sys
import threading
import weakref
from pathlib import Path

import pytest
import warp as wp
from click.testing import CliRunner

from gcodesim import Options, input_file, output_file
from gcodesim.batch.results import merge_results
from gcodesim.checking.flow import check_program
from gcodesim.cli import main
from gcodesim.collision.bodies import scene
from gcodesim.collision.geometry import kernel_cache
from gcodesim.errors import ModelError, UsageError
from gcodesim.input_file import read_bytes, read_stream
from gcodesim.interrupt import MESSAGE
from gcodesim.machine.formats.linuxcnc_ini import read_ini
from gcodesim.machine.loading import load_machine
from gcodesim.machine.mesh import read_mesh
from gcodesim.nc.detect import reads_like_program
from gcodesim.output_file import replacing, write_text
from gcodesim.policy.baseline import read_baseline
from gcodesim.policy.comments import comments_in

PROGRAM = "G21 G90 G54\nG0 X1\nM30\n"


def python(code: str, **how: object) -> subprocess.CompletedProcess[str]:
    # What is started in the background of a shell has Ctrl-C switched off.
    heard = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
    command = [sys.executable, "-c", heard + code]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False, **how)


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("/dev/zero", "a device, not a file"),
        (".", "Is a directory"),
        ("no\0name", "no file has such a name"),
        ("missing", "No such file"),
    ],
)
def test_odd_files_are_refused(name: str, why: str) -> None:
    with pytest.raises(OSError, match=why):
        read_bytes(name)


def test_a_pipe_is_read_and_one_without_a_writer_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pipe = tmp_path / "pipe.nc"
    os.mkfifo(pipe)
    writer = threading.Thread(target=pipe.write_text, args=(PROGRAM,))
    writer.start()
    assert read_bytes(pipe).decode() == PROGRAM
    writer.join()
    monkeypatch.setattr(input_file, "PIPE_S", 0.05)
    with pytest.raises(OSError, match="nothing came through this pipe"):
        read_bytes(pipe)


def test_a_file_beyond_belief_is_refused_unread(tmp_path: Path) -> None:
    huge = tmp_path / "huge.obj"
    with huge.open("wb") as file:
        file.truncate(1 << 40)
    with pytest.raises(OSError, match="1,099,511,627,776 bytes, and 2,147,483,648 are read"):
        read_bytes(huge)
    with pytest.raises(ModelError, match="bytes, and"):
        read_mesh(huge)


def test_what_is_half_written_never_stands_under_its_name(tmp_path: Path) -> None:
    page, link = tmp_path / "page.html", tmp_path / "link.html"
    page.write_text("old")
    page.chmod(0o640)
    link.symlink_to(page)

    def interrupted() -> None:
        with replacing(link, "w") as file:
            file.write("ha")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert page.read_text() == "old"
    write_text(link, "new")
    assert (link.is_symlink(), page.read_text()) == (True, "new")
    assert stat.S_IMODE(page.stat().st_mode) == 0o640
    write_text(os.devnull, "gone")
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(OSError, match="No such device"):
        write_text(tmp_path / "pipe", "nobody reads it")
    (tmp_path / "pipe").unlink()
    assert sorted(file.name for file in tmp_path.iterdir()) == ["link.html", "page.html"]
    assert not output_file._unfinished


def test_damaged_results_baselines_meshes_and_includes_are_named(tmp_path: Path) -> None:
    file = tmp_path / "file"
    for plan in (
        {"jobs": [{"machine": "m", "setup": "", "key": "k"}], "shard": [1, 1], "version": "0"},
        {"jobs": [], "shard": [float("inf"), 1], "version": "0"},
    ):
        file.write_text(json.dumps({"schema": "gcodesim.batch/1", **plan}) + "\n")
        with pytest.raises(UsageError, match="no results of gcodesim batch"):
            merge_results([str(file)])
    file.write_text("[" * 100_000)
    with pytest.raises(UsageError, match="no JSON"):
        read_baseline(str(file))
    ragged = tmp_path / "ragged.obj"
    ragged.write_text("v 0 0 0\nv 1 0 0\nv 0 1\nv 0 1\nf 1 2 3\n")
    with pytest.raises(ModelError, match="point 3 has 2 of 3 numbers"):
        read_mesh(ragged)
    ini = tmp_path / "nul.ini"
    ini.write_text("[EMC]\n#INCLUDE o\0ther.inc\n")
    with pytest.raises(UsageError, match="no file has such a name"):
        read_ini(str(ini))


def test_a_record_that_is_damaged_is_an_error_of_merge(tmp_path: Path) -> None:
    label = {"program": "a", "machine": "m", "setup": "", "key": "k"}
    plan = {"schema": "gcodesim.batch/1", "jobs": [label], "shard": [1, 1], "version": "0"}
    results = tmp_path / "results.jsonl"
    results.write_text(f"{json.dumps(plan)}\n{json.dumps({**label, 'report': []})}\n")
    done = CliRunner().invoke(main, ["merge", str(results)])
    assert (done.exit_code, "a record is damaged" in done.stderr) == (2, True)


def test_long_texts_are_read_to_their_end() -> None:
    blanks = " " * 150_000
    comment = next(comments_in(f"G0 X1 (gcodesim: ignore GC101{blanks}x)"))
    assert comment.wrong
    good = next(comments_in(f"(gcodesim: ignore GC101,GC2 {blanks} reason = why not {blanks})"))
    assert [rule.mark.reason for rule in good.rules] == ["why not"] * 2
    assert reads_like_program(["G1" + "X[1]Y[[2]*3]" * 300, "M30"])
    assert not reads_like_program(["G1" + "X[1]" * 300 + "!"])


def test_the_pattern_of_a_comment_reads_what_it_always_read() -> None:
    for text in ("ignore GC201", "  ignore  GC201 , GC1 reason=x ", "IGNORE gc1\treason = a = b"):
        assert not next(comments_in(f"(gcodesim:{text})")).wrong
    for text in ("ignore", "ignore GC201reason=x", "ignore GC201 because", "ignore GC1 reason="):
        assert next(comments_in(f"(gcodesim:{text})")).wrong


def test_ctrl_c_before_any_command_is_one_line_and_130() -> None:
    code = "from gcodesim import interrupt; interrupt.arm(); import os; os.kill(os.getpid(), 2)"
    done = python(code)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", f"{MESSAGE}\n")


def test_ctrl_c_that_is_swallowed_or_not_heard_still_ends_the_process() -> None:
    code = """
import os, time
from gcodesim import interrupt
interrupt.PATIENCE_S = 0.1
interrupt.arm()
interrupt.watch()
try:
    with interrupt.Caught():
        os.kill(os.getpid(), 2)
        time.sleep(60)
except BaseException:
    pass
time.sleep(60)
"""
    done = python(code)
    assert (done.returncode, done.stderr) == (130, f"{MESSAGE}\n")


def test_ctrl_c_inside_exec_of_a_command_is_130_too() -> None:
    """Python itself would end by the signal then, whoever catches the exception."""
    code = """
import os, gcodesim.machine.describe as describe
describe.describe = lambda machine: exec("os.kill(os.getpid(), 2); import time; time.sleep(9)")
import sys
sys.argv = ["gcodesim", "machine", "show", "table_tilt"]
from gcodesim.__main__ import run
run()
"""
    done = python(code)
    assert (done.returncode, done.stderr) == (130, f"{MESSAGE}\n")


def test_ctrl_c_that_a_library_turns_into_an_error_is_130_too() -> None:
    """As pydantic does, which builds its validators while modules are imported."""
    code = """
import os, gcodesim.machine.describe as describe
def swallow(machine):
    try:
        os.kill(os.getpid(), 2)
        import time; time.sleep(9)
    except KeyboardInterrupt as error:
        raise ValueError("no schema") from error
describe.describe = swallow
import sys
sys.argv = ["gcodesim", "machine", "show", "table_tilt"]
from gcodesim.__main__ import run
run()
"""
    done = python(code)
    assert (done.returncode, done.stderr) == (130, f"{MESSAGE}\n")


@pytest.mark.parametrize("given", ["/dev/zero", "-"])
def test_standard_input_without_end_is_refused(given: str) -> None:
    command = [sys.executable, "-m", "gcodesim", "check", given, "--machine", "table_tilt"]
    with Path("/dev/zero").open("rb") as endless:
        done = subprocess.run(
            command, stdin=endless, capture_output=True, text=True, timeout=60, check=False
        )
    assert (done.returncode, "a device, not a file" in done.stderr) == (2, True)


def test_more_on_standard_input_than_is_read_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    assert read_stream(io.BytesIO(b"G0 X1")) == b"G0 X1"
    monkeypatch.setattr(input_file, "DATA_BYTES", 100_000)
    with pytest.raises(OSError, match="and 100,000 are read at most"):
        read_stream(io.BytesIO(bytes(1_000_000)))


@pytest.mark.parametrize("megabytes", [30, 60, 150, 250, 400, 560])
def test_little_memory_is_one_line_and_never_a_verdict(megabytes: int) -> None:
    run = f'exec "{sys.executable}" -m gcodesim check samples/part.nc --machine table_tilt --quiet'
    command = f"ulimit -v {megabytes}000; {run}"
    done = subprocess.run(
        ["sh", "-c", command], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode in (0, 2), "what works with less is welcome"
    assert "memory" in done.stderr or not done.returncode
    assert "Traceback" not in done.stderr


CLOSED = [("<&-", 2), (">&-", 0), ("2>&-", 0), (">/dev/full", 2)]


@pytest.mark.parametrize(("closed", "code"), CLOSED)
def test_closed_and_full_streams_change_no_verdict_but_what_cannot_be_had(
    closed: str, code: int
) -> None:
    arguments = "canon -" if closed == "<&-" else "explain GC101"
    command = f'exec "{sys.executable}" -m gcodesim {arguments} {closed}'
    done = subprocess.run(["sh", "-c", command], capture_output=True, text=True, check=False)
    assert (done.returncode, "Traceback" in done.stderr) == (code, False)


def test_a_reader_that_goes_away_does_not_change_the_exit_code(tmp_path: Path) -> None:
    program = tmp_path / "bad.nc"
    program.write_text("G21 G90\n" + "G0 X1\nX2\n" * 5000 + "G1 X3\nM30\n")  # without a feed: 1
    command = [sys.executable, "-m", "gcodesim", "canon", str(program)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.read(10)
        process.stdout.close()
        said = process.stderr.read()
    assert (process.returncode, b"Traceback" in said) == (1, False)


@pytest.fixture
def kernels(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A kernel cache with one module in it, sealed."""
    module = tmp_path / "cache/1.0/wp_gcodesim.some_1"
    module.mkdir(parents=True)
    (module / "some.o").write_bytes(b"code")
    (module / "some.meta").write_text("{}")
    monkeypatch.setattr(wp.config, "kernel_cache_dir", str(module.parent))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    kernel_cache.seal()
    return module


DAMAGE = [("some.o", b""), ("some.o", b"c0de"), ("some.meta", b"{")]


@pytest.mark.parametrize(("file", "content"), DAMAGE)
def test_a_damaged_kernel_is_removed_and_said(kernels: Path, file: str, content: bytes) -> None:
    kernel_cache.start_warp()
    assert (kernels.exists(), kernel_cache.remarks()) == (True, [])
    (kernels / file).write_bytes(content)
    kernel_cache.start_warp()
    assert not kernels.exists()
    assert [remark.split(": ")[1:] for remark in kernel_cache.remarks()] == [
        ["1 damaged", "built again"]
    ]


def test_a_cache_that_cannot_be_written_is_replaced_and_said(
    kernels: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(**given: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("tempfile.TemporaryFile", refused)
    kernel_cache.start_warp()
    folder = Path(wp.config.kernel_cache_dir)
    assert folder.parent.parent == tmp_path
    assert (folder / kernels.name / "some.o").read_bytes() == b"code"
    (remark,) = kernel_cache.remarks()
    assert "cannot be used (Permission denied)" in remark


def test_mutants_of_every_file_end_with_an_error_of_one_line() -> None:
    path = Path(__file__).parent / "benchmarks" / "fuzz_files.py"
    spec = importlib.util.spec_from_file_location("fuzz_files", path)
    fuzz_files = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(fuzz_files)
    wrong, met = fuzz_files.fuzz(170, 20260101)
    assert not wrong, wrong
    assert met["read"]
    assert met["ModelError"]


def test_nothing_of_a_machine_is_kept_when_it_is_gone(tmp_path: Path) -> None:
    program = tmp_path / "part.nc"
    program.write_text("G21 G90 G54\nT1 M6\nS900 M3\nG0 X10.\nM30\n")
    machine = load_machine("table_tilt")
    check_program(program.read_text(), str(program), machine, Options(device="cpu"))
    parts = [weakref.ref(part) for body in machine.bodies.values() for part in body.parts]
    assert any(ref() in scene._regions for ref in parts)
    del machine
    gc.collect()
    assert not any(ref() for ref in parts)
