"""Stiff drives and extreme accelerations, each by two formulations; see stability_motion.py."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from decimal import Decimal
from math import inf, pi, sqrt

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import PS_PER_S
from gcodesim.machine.model import Servo
from gcodesim.motion.ramps import phases, reachable_speed
from gcodesim.motion.servo import exponentials, lagged_positions
from gcodesim.study.exact_motion import exact_functions, exact_hop_time, exact_ramp_time
from gcodesim.study.stability_case import Case, power
from gcodesim.study.stability_motion import DT, SEED, free_machine, path_of

Floats = NDArray[np.float64]
TAUS = 10.0 ** np.arange(-9.0, 1.1, 0.5)
"""Time constants of drives [s]."""

FASTEST = 1e12
"""Largest feed of the moves [mm/s]: far beyond what they can reach."""

STEPS = 20
"""Samples after which a drive is looked at."""

SPEED = 300.0
"""Speed of a ramp [mm/s]."""

EULER: dict[str, Callable[[float], float]] = {
    "explicit Euler": lambda x: 1.0 - x,
    "implicit Euler": lambda x: 1.0 / (1.0 + x),
}
"""What is left of a lag after a sample of x time constants."""


def steps_of_drives(quick: bool) -> Iterator[Case]:
    """A command that jumps by 1 mm: what is left of it after 20 samples."""
    x = DT * STEPS / TAUS
    exact = np.array([float((-Decimal(v)).exp()) for v in x])
    ours = np.abs(exponentials(x, None)[0][0] - exact).max()
    for usual, left in EULER.items():
        naive = max(abs(left(DT / tau) ** STEPS - e) for tau, e in zip(TAUS, exact, strict=True))
        yield Case(
            "servo", "first order, tau 1e-9 .. 10 s", "response to a step of 1 mm", usual,
            naive, float(ours), 4 * float(np.spacing(1.0)), "mm",
        )  # fmt: skip


def ramps_of_drives(quick: bool) -> Iterator[Case]:
    """A command of 300 mm/s from rest: the lag after 20 samples."""
    path, _ = path_of(f"G1 X1000. F{SPEED * 60:.0f}.")
    time = round(STEPS * DT * PS_PER_S)
    column = path.xyz[0]
    worst = {**dict.fromkeys(EULER, 0.0), "zero-order hold": 0.0, "": 0.0}
    machine = free_machine()
    for tau in TAUS.tolist():
        exact = float(Decimal(SPEED) * Decimal(tau) * (1 - (-Decimal(STEPS * DT / tau)).exp()))
        joints = tuple(replace(j, servo=Servo(1, tau)) for j in machine.joints)
        at = np.array([time])
        place = lagged_positions(path, replace(machine, joints=joints), at)[0, column]
        found = {"": float(path.positions(at)[0, column] - place)}
        kept = {usual: left(DT / tau) for usual, left in EULER.items()}
        kept["zero-order hold"] = float((-Decimal(DT / tau)).exp())
        for usual, factor in kept.items():
            found[usual] = _stepped_lag(usual, factor)
        worst = {usual: max(w, abs(found[usual] - exact)) for usual, w in worst.items()}
    ours = worst.pop("")
    for usual, naive in worst.items():
        yield Case(
            "servo", "first order, tau 1e-9 .. 10 s", "lag at 300 mm/s", usual, naive, ours,
            1e-12, "mm",
        )  # fmt: skip


def _stepped_lag(usual: str, kept: float) -> float:
    """Lag after STEPS samples: implicit Euler sees the new command, the others the old one."""
    y = 0.0
    for k in range(STEPS):
        command = SPEED * DT * (k + (usual == "implicit Euler"))
        y += (1.0 - kept) * (command - y)
    return SPEED * DT * STEPS - y


def second_order(quick: bool) -> Iterator[Case]:
    """Drives of 100 Hz to 1 MHz at 0.1 ms: growth by a sample, and the response itself."""
    dampings = (0.05, 0.3, 0.7, 1.0, 2.0)
    grown = {"explicit Euler": 0.0, "symplectic Euler": 0.0, "": 0.0}
    wrong, hertz = 0.0, 10.0 ** np.arange(2.0, 5.1 if quick else 6.1)
    for theta in (2.0 * pi * DT * hertz).tolist():
        for z in dampings:
            found = [_matrix(a[0], b[0], z) for a, b in exponentials(np.array([theta]), z)]
            exact = np.array(exact_functions(theta, z))
            wrong = max(wrong, float(np.abs(np.array(found).reshape(4, 4) - exact).max()))
    for theta in 2.0 * pi * DT * 10.0 ** np.arange(2.0, 6.1):
        for z in dampings:
            (a, b), *_ = exponentials(np.array([theta]), z)
            for usual, matrix in {**_euler_matrices(theta, z), "": _matrix(a[0], b[0], z)}.items():
                radius = np.abs(np.linalg.eigvals(matrix)).max()
                grown[usual] = max(grown[usual], float(radius) - 1.0)
    ours = grown.pop("")
    case = "second order, 100 Hz .. 1 MHz"
    for usual, naive in grown.items():
        yield Case("servo", case, "growth by a sample", usual, naive, ours, 0.0, "")
    case = f"second order, 100 Hz .. {power(hertz[-1])} Hz"
    yield Case("servo", case, "response against its series", "", None, wrong, 1e-12, "")


def _matrix(a: float, b: float, z: float) -> Floats:
    return np.array([[a, -b], [b, a - 2.0 * z * b]])


def _euler_matrices(x: float, z: float) -> dict[str, Floats]:
    """A sample of x = w dt for position and speed over w, by Euler's methods."""
    explicit = np.array([[1.0, x], [-x, 1.0 - 2.0 * z * x]])
    speed = np.array([-x, 1.0 - 2.0 * z * x])
    symplectic = np.array([[1.0, 0.0] + x * speed, speed])
    return {"explicit Euler": explicit, "symplectic Euler": symplectic}


def accelerations(quick: bool) -> Iterator[Case]:
    """Moves that hardly change their speed, or hardly begin: v^2/(a d) up to 1e18."""
    naive, ours = ramp_errors(300 if quick else 3000, np.random.default_rng([SEED, 5]))
    yield Case(
        "ramps", "v^2/(a d) from 1e-16 to 1e18", "time, relative",
        "(-v + sqrt(v^2 + 2 a d))/a", naive, ours, 4 * 2.0**-53, "",
    )  # fmt: skip


def ramp_errors(count: int, rng: np.random.Generator) -> tuple[float, float]:
    """Largest relative error of the time of random ramps: by the usual formula, and ours.

    v 1e-3 .. 1e3 mm/s, a 1e-6 .. 1e6 mm/s^2, d 1e-6 .. 1e4 mm.
    """
    naive = ours = 0.0
    for v, a, d in (10.0 ** rng.uniform([-3, -6, -6], [3, 6, 4], (count, 3))).tolist():
        w = reachable_speed(v, d, a, inf)
        found = phases(*np.array([[v], [w], [1e9], [d], [a], [inf]])).seconds.sum()
        exact = exact_ramp_time(v, a, d)
        ours = max(ours, abs(float(Decimal(float(found)) / exact - 1)))
        usual = (-v + sqrt(v * v + 2.0 * a * d)) / a
        naive = max(naive, abs(float(Decimal(usual) / exact - 1)))
    return naive, ours


def jerks(quick: bool) -> Iterator[Case]:
    """Moves from a speed back to it at limited jerk: how long a slight rise takes.

    The top speed is bisected, from below, so that no move is too fast.
    """
    count = 100 if quick else 1000
    rng = np.random.default_rng([SEED, 6])
    naive = ours = 0.0
    for v, j, d in (10.0 ** rng.uniform([-3, -3, -6], [3, 9, 4], (count, 3))).tolist():
        found = phases(*np.array([[v], [v], [FASTEST], [d], [1e12], [j]])).seconds.sum()
        exact = exact_hop_time(v, j, d)
        if Decimal(j) * (exact / 4) ** 2 > FASTEST - v:
            continue
        ours = max(ours, abs(float(Decimal(float(found)) / exact - 1)))
        top = v + float(Decimal(j) * (exact / 4) ** 2)
        naive = max(naive, abs(float(Decimal(4.0 * sqrt((top - v) / j)) / exact - 1)))
    yield Case(
        "ramps", "jerk alone, v back to v", "time, relative",
        "4 sqrt((top - v)/j)", naive, ours, 1e-12, "",
    )  # fmt: skip


def limits(quick: bool) -> Iterator[Case]:
    """Acceleration and jerk up to twelve powers of ten apart: phases vanish at one end or another.

    A fault is a jump between pieces, a piece without time, and a way that runs backwards.
    """
    machine, faults = free_machine(), 0
    rng = np.random.default_rng([SEED, 7])
    to = np.cumsum(10.0 ** rng.uniform(-4, 2, (300, 3)) * rng.choice([-1, 0, 1], (300, 3)), axis=0)
    feeds = 10.0 ** rng.uniform(0, 6, 300)
    text = "\n".join(
        f"G1 X{x:.4f} Y{y:.4f} C{c:.4f} F{f:.3f}"
        for (x, y, c), f in zip(to.tolist(), feeds.tolist(), strict=True)
    )
    values = (1e-3, 1e3, 1e9)
    for a, j in ((a, j) for a in values for j in values):
        joints = (replace(q, max_acceleration=a, max_jerk=j) for q in machine.joints)
        limited = replace(machine, joints=tuple(joints))
        for time in ("acceleration", "jerk"):
            path, _ = path_of(text, replace(limited, time=time))
            faults += int(np.count_nonzero(path.q0[1:] != path.q1[:-1]))
            faults += int(np.count_nonzero(np.diff(path.bounds_ps) <= 0))
            slopes = [path.law @ [1, 2 * x, 3 * x * x] for x in np.linspace(0, 1, 11)]
            faults += int(np.count_nonzero(~(np.min(slopes, axis=0) >= -1e-14)))
    case = "a and jerk 1e-3 .. 1e9, any pair"
    yield Case("ramps", case, "faults of the path", "", None, float(faults), 0.0, "faults")


DRIVES = (steps_of_drives, ramps_of_drives, second_order, accelerations, jerks, limits)
