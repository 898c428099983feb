"""Runs LinuxCNC's own motion controller without screen and machine, and records its joints."""

from __future__ import annotations

import fcntl
import os
import shutil
import signal
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from motion.linuxcnc_machines import LENGTH, Array, Module
from needs import lacking, need

PYTHON = "/usr/bin/python3"
"""The interpreter that LinuxCNC's Python module is built for."""

LONGEST_S = 60.0
"""A run takes 8 s; after this long it is ended."""

COORDINATES = {
    "xyzac-trt-kins": "XYZAC",
    "xyzbc-trt-kins": "XYZBC",
    "5axiskins": "XYZBCW",
    "maxkins": "XYZABC",
}
SPEED = "MIN_LIMIT = -9000\nMAX_LIMIT = 9000\nMAX_VELOCITY = 150\nMAX_ACCELERATION = 400\n"
"""Slow enough that its smoothing over 1 ms stays below a micrometre at a lever of 300 mm."""

INI = """\
[EMC]
VERSION = 1.1
[DISPLAY]
DISPLAY = {folder}/display
[RS274NGC]
PARAMETER_FILE = parameters.var
[EMCMOT]
EMCMOT = motmod
SERVO_PERIOD = 1000000
COMM_TIMEOUT = 4
[TASK]
TASK = milltask
CYCLE_TIME = 0.002
[EMCIO]
EMCIO = io
CYCLE_TIME = 0.05
TOOL_TABLE = tools.tbl
[HAL]
HALFILE = machine.hal
[KINS]
KINEMATICS = {kins}
JOINTS = {n}
[TRAJ]
COORDINATES = {letters}
LINEAR_UNITS = mm
ANGULAR_UNITS = deg
MAX_LINEAR_VELOCITY = 150
MAX_ANGULAR_VELOCITY = 150
MAX_LINEAR_ACCELERATION = 400
"""
DISPLAY = f"""\
#!/bin/sh
cd "$(dirname "$0")"
halsampler -n 60000 samples.txt &
sampler=$!
{PYTHON} operate.py
sleep 0.3
kill $sampler
"""
OPERATE = """\
import sys, time
import linuxcnc

command, status = linuxcnc.command(), linuxcnc.stat()


def wait(ready):
    end = time.monotonic() + 30.0
    while time.monotonic() < end:
        status.poll()
        if ready():
            return
        time.sleep(0.01)
    sys.exit("timeout")


command.state(linuxcnc.STATE_ESTOP_RESET)
command.wait_complete()
command.state(linuxcnc.STATE_ON)
command.wait_complete()
command.mode(linuxcnc.MODE_MANUAL)
command.wait_complete()
command.teleop_enable(0)
command.wait_complete()
command.home(-1)
wait(lambda: all(status.homed[: status.joints]))
command.mode(linuxcnc.MODE_AUTO)
command.wait_complete()
command.program_open("program.ngc")
command.wait_complete()
command.auto(linuxcnc.AUTO_RUN, 0)
time.sleep(0.2)
wait(lambda: status.interp_state == linuxcnc.INTERP_IDLE and status.inpos)
"""


def is_installed() -> bool:
    """Whether the controller and its Python module are there."""
    if not all(shutil.which(name) for name in ("linuxcnc", "halcmd", "halsampler")):
        return False
    if not Path(PYTHON).exists():
        return False
    asked = [PYTHON, "-c", "import linuxcnc"]
    return subprocess.run(asked, capture_output=True, check=False).returncode == 0


def joint_samples(module: Module, program: str) -> Array:
    """Joints X Y Z, tilt, C of every servo cycle (1 ms), shape (n, 5) [mm, deg].

    The test cannot run where a LinuxCNC is running, for this one would stop it.
    """
    need(is_installed(), "linuxcnc-uspace")
    lock = Path(tempfile.gettempdir(), "gcodesim-linuxcnc.lock")
    with lock.open("w") as mine, tempfile.TemporaryDirectory() as folder:
        fcntl.flock(mine, fcntl.LOCK_EX)
        if Path("/tmp/linuxcnc.lock").exists():
            lacking("a LinuxCNC is running")
        Path(folder).chmod(0o755 if os.getuid() else 0o777)
        _write(module, program, Path(folder))
        path = f"/usr/bin:{os.environ['PATH']}"  # its interpreter looks there for its Python
        env = {"HOME": folder, "PATH": path}
        if not os.getuid():  # its real-time part refuses to be root
            env |= {"RTAPI_UID": "65534", "RTAPI_FIFO_PATH": f"{folder}/fifo"}
        returned = _run(Path(folder), env)
        samples = Path(folder, "samples.txt")
        if returned != 0 or not samples.exists():
            lacking("LinuxCNC cannot run its real-time part here")
        joints = np.loadtxt(samples)
    letters = COORDINATES[module.name]
    return joints[:, [letters.index(letter) for letter in ("X", "Y", "Z", module.tilt, "C")]]


def _run(folder: Path, env: dict[str, str]) -> int | None:
    """Exit status of LinuxCNC, None when it had to be ended."""
    void = subprocess.DEVNULL
    process = subprocess.Popen(
        ["linuxcnc", f"{folder}/machine.ini"], stdin=void, stdout=void, stderr=void,
        env=env, cwd=folder, start_new_session=True,
    )  # fmt: skip
    try:
        return process.wait(LONGEST_S)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        subprocess.run(["halrun", "-U"], stdin=void, capture_output=True, env=env, check=False)
        return None


def _write(module: Module, program: str, folder: Path) -> None:
    """The files of a configuration whose motors are where they are told to be."""
    letters = COORDINATES[module.name]
    kins = f"{module.name} coordinates={letters}" if "W" in letters else module.name
    ini = INI.format(folder=folder, kins=kins, n=len(letters), letters=letters)
    hal = [
        f"loadrt {kins}",
        f"loadrt motmod servo_period_nsec=1000000 num_joints={len(letters)}",
        f"loadrt sampler depth=60000 cfg={'f' * len(letters)}",
        *(f"addf {f} servo-thread" for f in ("motion-command-handler", "motion-controller")),
        "addf sampler.0 servo-thread",
        "net enable iocontrol.0.user-enable-out => iocontrol.0.emc-enable-in",
    ]
    for n, letter in enumerate(letters):
        ini += f"[AXIS_{letter}]\n{SPEED}"
        kind = "LINEAR" if letter in "XYZW" else "ANGULAR"
        ini += f"[JOINT_{n}]\nTYPE = {kind}\nHOME = 0\nHOME_SEQUENCE = 0\n{SPEED}"
        ini += "FERROR = 1000\nMIN_FERROR = 1000\n"
        ends = f"joint.{n}.motor-pos-fb sampler.0.pin.{n}"
        hal.append(f"net j{n} joint.{n}.motor-pos-cmd => {ends}")
    pins = module.pins | ({"tool-offset": LENGTH} if "trt" in module.name else {})
    hal += [f"setp {module.name}.{pin} {value}" for pin, value in pins.items()]
    (folder / "machine.ini").write_text(ini)
    (folder / "machine.hal").write_text("\n".join(hal) + "\n")
    (folder / "program.ngc").write_text(program)
    (folder / "operate.py").write_text(OPERATE)
    (folder / "tools.tbl").touch()
    (folder / "display").write_text(DISPLAY)
    (folder / "display").chmod(0o755)
