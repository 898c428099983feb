"""Servo lag: exact responses from 1 ns to 10 s at 0.1 ms, and the bound that no motion exceeds."""

from __future__ import annotations

from dataclasses import replace
from decimal import Decimal
from math import exp, expm1, inf, pi

import numpy as np
import pytest
from collision.scenes import random_joints, random_path
from motion.programs import limited_machine, program
from numpy.typing import NDArray

from gcodesim.machine.model import Servo
from gcodesim.motion.path import Path
from gcodesim.motion.planner import plan
from gcodesim.motion.servo import (
    exponentials,
    lag_gain,
    lagged_positions,
    servo_deviation,
)
from gcodesim.motion.speeds import joint_speeds
from gcodesim.nc.program import Kind
from gcodesim.study.exact_motion import exact_functions
from gcodesim.study.scenes import joint, machine, path

DT = 1e-4
TAUS = 10.0 ** np.arange(-9.0, 1.1, 0.5)
SERVOS = [Servo(1, 0.02), *(Servo(2, 0.005, z) for z in (0.05, 0.3, 0.7, 1.0, 1.5, 8.0))]
X = joint("X", [1, 0, 0])


def lag(p: Path, servo: Servo, times: NDArray[np.int64]) -> NDArray[np.float64]:
    m = machine([replace(X, servo=servo)], {}, [])
    return (p.positions(times) - lagged_positions(p, m, times))[:, 0]


@pytest.mark.parametrize("tau", TAUS)
def test_a_ramp_lags_by_speed_times_time_constant(tau: float) -> None:
    """Ramp of 300 mm/s: lag v tau (1 - exp(-t/tau)), after it v tau (1 - exp(-T/tau)) exp(...)."""
    p = path([X], [0.0], [(1.0, [300.0])])
    times = np.array([1, 10**4, 10**8, 10**9, 10**11, 10**12])
    exact = [300.0 * tau * -expm1(-t / 1e12 / tau) for t in times]
    np.testing.assert_allclose(lag(p, Servo(1, tau), times), exact, rtol=1e-12, atol=2e-13)
    after = times + 10**12
    exact = [exact[-1] * exp(-t / 1e12 / tau) for t in times]
    np.testing.assert_allclose(lag(p, Servo(1, tau), after), exact, rtol=1e-12, atol=2e-13)


@pytest.mark.parametrize("tau", TAUS)
def test_a_step_decays_to_four_ulp_and_never_gains(tau: float) -> None:
    x = DT * np.arange(1, 100) / tau
    kept = exponentials(x, None)[0][0]
    exact = np.array([float((-Decimal(v)).exp()) for v in x])
    step, exact_step = 1.0 - kept, np.array([-expm1(-v) for v in x])
    assert np.abs(kept - exact).max() <= 4 * np.spacing(1.0)
    assert np.abs(step - exact_step).max() <= 4 * np.spacing(1.0)
    assert (kept >= 0).all()
    assert (kept <= 1).all()


@pytest.mark.parametrize("z", [0.05, 0.7, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 3.0])
def test_second_order_functions_equal_their_series(z: float) -> None:
    for theta in 10.0 ** np.arange(-10.0, 2.1):  # 100 Hz to 1 MHz and far beyond, at 0.1 ms
        found = exponentials(np.array([theta]), z)
        for (a, b), exact in zip(found, exact_functions(theta, z), strict=True):
            matrix = [a[0], -b[0], b[0], a[0] - 2 * z * b[0]]
            np.testing.assert_allclose(matrix, exact, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("z", [0.05, 0.3, 0.7, 1.0, 2.0])
@pytest.mark.parametrize("hertz", [1e2, 1e3, 1e4, 1e5, 1e6])
def test_second_order_never_grows(hertz: float, z: float) -> None:
    ((a, b), *_) = exponentials(np.array([2 * pi * hertz * DT]), z)
    matrix = np.array([[a[0], -b[0]], [b[0], a[0] - 2 * z * b[0]]])
    assert np.abs(np.linalg.eigvals(matrix)).max() <= 1.0


@pytest.mark.parametrize("servo", SERVOS, ids=str)
def test_responses_satisfy_their_equation(servo: Servo, rng: np.random.Generator) -> None:
    """Against a Runge-Kutta integration in small steps, lines and arcs, cubic laws, all joints."""
    m = limited_machine("jerk", a=2000.0, j=1e5)
    m = replace(m, joints=tuple(replace(j, servo=servo) for j in m.joints))
    rows = [
        {"kind": Kind.FEED, "to": (3, -2, 1, 5, 0, 9), "f": 3000},
        {"kind": Kind.ARC, "to": (13, 8, 2), "center": (13, -2, 0), "turns": -1, "f": 4000},
        {"kind": Kind.RAPID, "to": (0, 0, 0)},
    ]
    p, _ = plan(program(rows), m)
    steps = 8000
    times = np.linspace(0, p.duration_ps, 2 * steps + 1).astype(np.int64)
    u = p.positions(times)
    h, w, z = p.duration_s / steps, 1 / servo.time_constant, servo.damping

    def slope(y: NDArray, speed: NDArray, command: NDArray) -> tuple[NDArray, NDArray]:
        if servo.order == 1:
            return w * (command - y), 0 * y
        return speed, w * w * (command - y) - 2 * z * w * speed

    y, speed, found = u[0].copy(), 0 * u[0], [u[0].copy()]
    for i in range(0, 2 * steps, 2):
        k1 = slope(y, speed, u[i])
        k2 = slope(y + h / 2 * k1[0], speed + h / 2 * k1[1], u[i + 1])
        k3 = slope(y + h / 2 * k2[0], speed + h / 2 * k2[1], u[i + 1])
        k4 = slope(y + h * k3[0], speed + h * k3[1], u[i + 2])
        y = y + h / 6 * (k1[0] + 2 * k2[0] + 2 * k3[0] + k4[0])
        speed = speed + h / 6 * (k1[1] + 2 * k2[1] + 2 * k3[1] + k4[1])
        found.append(y)
    lagged = lagged_positions(p, m, times[::2])
    np.testing.assert_allclose(lagged, found, rtol=0, atol=1e-6)


@pytest.mark.parametrize("servo", SERVOS, ids=str)
def test_no_motion_lags_beyond_the_bound(servo: Servo, rng: np.random.Generator) -> None:
    joints = [replace(j, servo=servo) for j in random_joints(rng)]
    p = random_path(rng, joints, 60, seconds=0.2)
    m = machine(joints, {}, [])
    times = np.linspace(0, p.duration_ps + 10**11, 20_001).astype(np.int64)
    bound = servo_deviation(p, m)
    worst = np.abs(p.positions(times) - lagged_positions(p, m, times)).max(axis=0)
    assert (worst <= bound + 1e-9).all()
    fastest = np.abs(np.diff(p.positions(times), axis=0)).max(axis=0) / (times[1] / 1e12)
    assert (fastest <= joint_speeds(p) * (1 + 1e-6)).all()


@pytest.mark.parametrize("servo", SERVOS, ids=str)
def test_the_bound_is_reached(servo: Servo) -> None:
    """The command that reverses whenever the step response passes through zero, backwards."""
    z = min(servo.damping, 1.0)
    if servo.order == 1 or z == 1.0:
        pieces = [(40 * servo.damping * servo.time_constant, [1.0])]
    else:
        k = np.sqrt(1 - z * z) / servo.time_constant
        zeros = (np.arcsin(z) + pi / 2 + pi * np.arange(200)) / k
        pieces, place = [], 0.0
        for number in range(len(zeros) - 1, -1, -1):
            seconds = zeros[number] - (zeros[number - 1] if number else 0.0)
            place += seconds * (-1) ** number
            pieces.append((seconds, [place]))
    p = path([X], [0.0], pieces)
    speed = joint_speeds(p)[0]
    found = lag(p, servo, np.array([p.duration_ps]))[0]
    assert found == pytest.approx(speed * lag_gain(servo), rel=1e-6)


def test_without_a_servo_joints_follow_at_once() -> None:
    p = path([X], [0.0], [(1.0, [300.0])])
    m = machine([X], {}, [])
    times = np.array([0, 10**11, 10**12, 2 * 10**12])
    np.testing.assert_array_equal(lagged_positions(p, m, times), p.positions(times))
    assert servo_deviation(p, m).tolist() == [0.0]
    assert lag_gain(Servo(2, 0.01, 1.0 - 1e-12)) == pytest.approx(0.02)
    assert lag_gain(Servo(1, 0.01, inf)) == 0.01
