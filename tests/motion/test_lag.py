"""Lag over time: no drive lags more at any time, never more than the whole path's bound."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from collision.scenes import random_joints, random_path

from gcodesim.machine.model import Joint, Servo
from gcodesim.motion.lag import Lag, envelope, lag_over_time, scanned
from gcodesim.motion.path import Path
from gcodesim.motion.servo import commanded, lag_gain, lags, servo_deviation
from gcodesim.study.scenes import joint, machine, path

X = joint("X", [1, 0, 0])
DAMPINGS = (0.01, 0.2, 0.7, 0.93, 1.0 - 1e-9, 1.0, 1.0 + 1e-9, 1.1, 3.0, 100.0)


def lag_of(p: Path, servo: Servo) -> Lag:
    found = lag_over_time(p, machine([replace(X, servo=servo)], {}, []))
    assert found
    return found


def random_servo(rng: np.random.Generator) -> Servo:
    constant = 10.0 ** rng.uniform(-9, 1)
    return Servo(1, constant) if rng.random() < 0.5 else Servo(2, constant, rng.choice(DAMPINGS))


@pytest.mark.parametrize("seed", range(40))
def test_no_joint_lags_more_at_any_time(seed: int) -> None:
    """Lines, dwells and arcs, six time laws, pieces of 10 us to 10 s, drives of 1 ns to 10 s."""
    rng = np.random.default_rng([41, seed])
    joints = [replace(j, servo=random_servo(rng)) for j in random_joints(rng)]
    p = random_path(rng, joints, 60, seconds=10.0 ** rng.uniform(-5, 1))
    found = lag_over_time(p, machine(joints, {}, []))
    assert found
    times = np.unique(np.concatenate([rng.integers(1, p.duration_ps, 2000), p.bounds_ps[1:]]))
    width = (p.duration_ps * 10.0 ** rng.uniform(-9, 0, len(times))).astype(np.int64)
    start = np.maximum(times - (rng.random(len(times)) * width).astype(np.int64) - 1, 0)
    end = np.minimum(np.maximum(start + width, times), p.duration_ps)
    bound, point = found.over(start, end), found.over(times - 1, times)
    assert (point <= bound * (1.0 + 1e-9)).all()
    assert (bound <= servo_deviation(p, machine(joints, {}, []))).all()
    for column, j in enumerate(joints):
        assert j.servo
        lag = np.abs(lags(commanded(p, column), j.servo, times))
        # Cubics that stand for arcs leave them by 1e-7 mm, the other slack is rounding.
        arcs = 2e-7 if column in p.xyz else 0.0
        assert (lag <= point[:, column] * (1.0 + 1e-9) + 1e-12 + arcs).all()


@pytest.mark.parametrize("tau", 10.0 ** np.arange(-9.0, 1.1))
def test_first_order_bounds_are_the_lag_itself_on_one_way(tau: float) -> None:
    """A rapid, its ramp down, a slow cut: the bound of an instant is the lag of the instant."""
    ramp = (2.0, -1.0, 0.0)
    pieces = [(0.5, [250.0]), (0.05, [262.5]), (2.0, [282.5])]
    p = path([X], [0.0], pieces)
    p.law[1] = ramp
    times = np.unique(np.linspace(1, p.duration_ps, 4001).astype(np.int64))
    servo = Servo(1, tau)
    exact = lags(commanded(p, 0), servo, times)
    bound = lag_of(p, servo).over(times - 1, times)[:, 0]
    # Within 1 ps the bound holds from the start of it on.
    slack = 500.0 * 1e-12 * 3
    assert (np.abs(bound - exact) <= 1e-7 * exact + slack).all()


def test_a_slow_cut_gets_its_own_bound_once_the_rapid_has_died_out() -> None:
    p = path([X], [0.0], [(1.0, [500.0]), (2.0, [520.0]), (1.0, [1020.0])])
    found = lag_of(p, Servo(1, 0.01))

    def over(start_s: float, end_s: float) -> float:
        times = (np.array([round(t * 1e12)]) for t in (start_s, end_s))
        return float(found.over(*times)[0, 0])

    assert over(0.0, 4.0) == pytest.approx(5.0)
    assert over(0.5, 1.5) == pytest.approx(5.0)
    assert over(1.01, 1.5) == pytest.approx(0.1 + 4.9 * np.exp(-1.0))
    assert over(1.5, 3.0) == pytest.approx(0.1)
    assert over(3.0, 3.001) == pytest.approx(0.1 + 4.9 * -np.expm1(-0.1))
    assert over(2.9, 3.001) == pytest.approx(5.0)  # a later piece counts as a whole
    assert found.whole.tolist() == [5.0]


@pytest.mark.parametrize("z", DAMPINGS)
def test_the_envelope_is_above_the_response_to_a_step(z: float) -> None:
    """The lag after a quick step of 1 mm; its bound cannot be far off at a steady speed either."""
    servo = Servo(2, 0.01, z)
    k, a = envelope(servo)
    p = path([X], [0.0], [(1e-9, [1.0])])
    times = 1000 + np.linspace(0, 20 / a * 1e12, 4001).astype(np.int64)
    lag = lags(commanded(p, 0), servo, times)
    assert (np.abs(lag) <= k * np.exp(-a * (times - 1000) / 1e12) * (1 + 1e-6) + 1e-15).all()
    assert lag_gain(servo) <= k / a * (1 + 1e-12)
    assert k / a <= np.pi / 2 * lag_gain(servo)


@pytest.mark.parametrize("n", [1, 2, 3, 10, 1000])
def test_the_scan_is_the_recurrence(n: int, rng: np.random.Generator) -> None:
    kept, pushed = rng.random(n) ** rng.choice([0.01, 1, 100], n), rng.random(n)
    x = [0.0]
    for a, b in zip(kept, pushed, strict=True):
        x.append(a * x[-1] + b)
    np.testing.assert_allclose(scanned(kept, pushed), x, rtol=1e-13)


def test_nothing_lags_without_a_servo_or_motion() -> None:
    p = path([X], [0.0], [(1.0, [1.0])])
    lagging: Joint = replace(X, servo=Servo(1, 0.01))
    assert lag_over_time(p, machine([X], {}, [])) is None
    assert lag_over_time(path([X], [0.0], []), machine([lagging], {}, [])) is None
