"""Stiff and extreme motion: clocks, feeds, arcs and helices, each by two formulations.

Every function yields cases (stability_case.py), computed there and then; exact values come from
fractions and decimals (exact_motion.py). Programs run through the interpreter and the planner on
the shipped machine with its travel unlimited.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from math import fsum, hypot, inf, sqrt

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import DEFAULT_PERIOD_PS, PS_PER_S
from gcodesim.findings.codes import Finding
from gcodesim.machine.control_data import control_for
from gcodesim.machine.loading import load_machine
from gcodesim.machine.model import Machine
from gcodesim.motion.path import ARC_PIECE, Path, arc_displacement
from gcodesim.motion.planner import plan
from gcodesim.motion.samples import sample_count, tool_spans, window
from gcodesim.nc.control.arcs import centre_from_radius
from gcodesim.nc.control.readings import ArcTolerance
from gcodesim.nc.interpret import interpret
from gcodesim.study.exact_motion import decimal, exact_displacement, exact_sincosd
from gcodesim.study.stability_case import Case, power

Floats = NDArray[np.float64]
FLOATS: dict[str, type[np.floating]] = {"float32": np.float32, "float64": np.float64}
DT = DEFAULT_PERIOD_PS / PS_PER_S
SEED = 20261121


def free_machine() -> Machine:
    """The shipped machine table_tilt, its joints without ends."""
    machine = load_machine("table_tilt")
    joints = tuple(replace(joint, lower=-inf, upper=inf) for joint in machine.joints)
    return replace(machine, joints=joints)


def path_of(text: str, machine: Machine | None = None) -> tuple[Path, list[Finding]]:
    """The path of a program and its findings, on `free_machine` unless another is given."""
    machine = machine or free_machine()
    control = control_for(machine, None, None, False)
    meaning = interpret(f"G21 G90 G94 G54 S1000 M3\n{text}\nM30\n", control, "study")
    path, findings = plan(meaning.program, machine)
    return path, [*meaning.findings, *findings]


# --- time ---------------------------------------------------------------------------------------


def clocks(quick: bool) -> Iterator[Case]:
    """Time after many samples, and where a joint then stands."""
    count = 10**7 if quick else 10**8
    case = f"{power(count)} samples of 0.1 ms"
    path, _ = path_of("G1 X10000000. F20000.")
    found = window(path, tool_spans(path)[0], count, 1, DEFAULT_PERIOD_PS).time_ps
    exact = Fraction(count, 10_000)
    ours = abs(float(Fraction(int(found[0]), PS_PER_S) - exact))
    for name, dtype in FLOATS.items():
        naive = abs(accumulated(dtype, count) - float(exact))
        yield Case("time", case, "time of the last", f"t += dt, {name}", naive, ours, 0.0, "s")
    place = exact * PS_PER_S / path.duration_ps * 10**7
    off = abs(Fraction(float(path.positions(found)[0, path.xyz[0]])) - place)
    naive = abs(float(np.float32(float(exact)) * np.float32(20_000 / 60)) - float(place))
    usual, ulp = "speed times a float32 time", float(np.spacing(float(place)))
    yield Case("time", case, "place at 20 m/min", usual, naive, float(off), ulp, "mm")


def accumulated(dtype: type[np.floating], count: int) -> float:
    """The sum of 0.0001, `count` times, in a floating type [s]."""
    part = 10**6
    t = dtype(0.0)
    for _ in range(count // part):
        steps = np.full(part + 1, DT, dtype)
        steps[0] = t
        t = np.cumsum(steps, dtype=dtype)[-1]
    return float(t)


def cycle_times(quick: bool) -> Iterator[Case]:
    """The duration of blocks of 0.6 s each, as a sum of rounded times; ten rounds of a program."""
    count, rounds = (10**5 if quick else 10**6), 10
    rng = np.random.default_rng([SEED, 1])
    steps = rng.integers(-4000, 4001, (count, 3)) * 1e-3
    feeds = rng.integers(300, 700, count)
    points = np.cumsum(steps, axis=0)
    rows = zip(points.tolist(), feeds.tolist(), strict=True)
    path, _ = path_of("\n".join(f"G1 X{p[0]:.3f} Y{p[1]:.3f} Z{p[2]:.3f} F{f}" for p, f in rows))
    # As the control reads them: thousandths, above the work offset.
    ends = np.rint(np.vstack([[0.0, 0.0, path.q0[0, path.xyz[2]] + 520.0], points]) * 1e3) / 1e3
    seconds = np.linalg.norm(np.diff(ends, axis=0), axis=1) * 60.0 / feeds
    exact = fsum(seconds.tolist()) * rounds
    ours = abs(int(np.tile(np.diff(path.bounds_ps), rounds).sum()) / PS_PER_S - exact)
    for name, dtype in FLOATS.items():
        added = float(np.cumsum(np.tile(seconds, rounds), dtype=dtype)[-1])
        yield Case(
            "time", f"{power(count * rounds)} blocks of 0.6 s", "cycle time", f"sum in {name}",
            abs(added - exact), ours, 1e-6, "s",
        )  # fmt: skip


def short_blocks(quick: bool) -> Iterator[Case]:
    """Blocks of 0.1 um at 20 m/min: three hundred and thirty-three to a sample."""
    count = 10**5 if quick else 10**6
    case = f"{power(count)} blocks of 0.1 um, 20 m/min"
    path, _ = path_of(
        "G1 F20000.\n" + "\n".join(f"X{k // 10**4}.{k % 10**4:04d}" for k in range(1, count + 1))
    )
    each = 1e-4 / (20_000 / 60)
    exact = count * each
    ours = abs(path.duration_s - exact)
    ceiling, rounded = (count * float(f(each / DT)) * DT for f in (np.ceil, np.rint))
    for usual, total in (("whole samples, rounded up", ceiling), ("rounded", rounded)):
        yield Case("time", case, "cycle time", usual, abs(total - exact), ours, 1e-6, "s")
    span = tool_spans(path)[0]
    seen = window(path, span, 0, sample_count(path, DEFAULT_PERIOD_PS), DEFAULT_PERIOD_PS)
    never = np.setdiff1d(path.bounds_ps, seen.time_ps)
    at_samples = np.count_nonzero(path.bounds_ps % DEFAULT_PERIOD_PS)
    yield Case(
        "time", case, "block ends never looked at", "samples alone", float(at_samples),
        float(len(never)), 0.0, "ends",
    )  # fmt: skip


def feeds(quick: bool) -> Iterator[Case]:
    """Feeds no machine can run, and blocks longer than a clock."""
    limit = 400.0
    for words, time in (("F1000000000.", 100 * 60 / 1e9), ("G93 F1000000000.", 60 / 1e9)):
        path, _ = path_of(f"G1 X100. {words}")
        naive, ours = (max(0.0, 100.0 / t - limit) for t in (time, path.duration_s))
        case, quantity = words.replace("000000000.", "e9"), "speed above the rapid rate"
        yield Case("feed", case, quantity, "as programmed", naive, ours, 1e-6, "mm/s")
    path, _ = path_of("G1 X0.01 F0.000001")
    exact = 6 * 10**9 + 1
    wrapped = (exact + 2**31) % 2**32 - 2**31
    ours = abs(sample_count(path, DEFAULT_PERIOD_PS) - exact)
    yield Case(
        "feed", "F1e-6 over 0.01 mm, 6e5 s", "samples", "int32 sample number",
        float(abs(wrapped - exact)), float(ours), 0.0, "samples",
    )  # fmt: skip
    path, findings = path_of("G93 G1 X1. F0.000001")
    clock = 6 * 10**7 * PS_PER_S
    wraps = (clock + 2**63) % 2**64 - 2**63 != clock
    reported = any(f.code == "GC424" for f in findings) and bool(
        (np.diff(path.bounds_ps) > 0).all()
    )
    yield Case(
        "feed", "G93 F1e-6, 6e7 s", "clocks that overflow unnoticed", "int64 picoseconds, unasked",
        float(wraps), float(not reported), 0.0, "clocks",
    )  # fmt: skip


# --- arcs ---------------------------------------------------------------------------------------


def arcs(quick: bool) -> Iterator[Case]:
    """Places on arcs of up to a metre, tiny and huge, seen from their start."""
    count = 50 if quick else 500
    for radius in (1e-4, 1.0, 1e3, 1e6, 1e8):
        rng = np.random.default_rng([SEED, 2])
        sweep = np.degrees(10.0 ** rng.uniform(-4, 3, count) / radius).clip(max=700.0)
        arc = np.zeros(count, ARC_PIECE)
        begin = rng.uniform(0.0, 2.0 * np.pi, count)
        cosine, sine, flat = np.cos(begin), np.sin(begin), np.zeros(count)
        arc["u"], arc["v"] = np.stack([[cosine, sine, flat], [-sine, cosine, flat]], axis=0).mT
        arc["r0"] = arc["r1"] = radius
        arc["sweep"] = sweep * rng.choice([-1, 1], count)
        s = rng.uniform(0, 1, count)
        exact = np.array([exact_displacement(arc[k], float(s[k])) for k in range(count)])
        ours = np.abs(arc_displacement(arc, s) - exact).max()
        for name, dtype in FLOATS.items():
            naive = np.abs(from_centre(arc, begin, s, dtype) - exact).max()
            case, usual = f"R {power(radius)} mm, up to 1 m", f"centre form, {name}"
            yield Case(
                "arcs", case, "place on the arc", usual, float(naive), float(ours), 1e-12, "mm"
            )


def from_centre(
    arc: NDArray[np.void], begin: Floats, s: Floats, dtype: type[np.floating]
) -> Floats:
    """The textbook form c + R (cos a, sin a, 0) with c = -R u: seen from the start, (n, 3)."""
    radius = arc["r0"].astype(dtype)[:, None]
    angle = (begin + np.radians(arc["sweep"] * s)).astype(dtype)
    arm = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    return np.asarray(radius * arm - radius * arc["u"].astype(dtype), np.float64)


def radius_words(quick: bool) -> Iterator[Case]:
    """R arcs next to half a circle: how high the centre stands over the chord."""
    naive = ours = 0.0
    for excess in 10.0 ** -np.arange(3.0, 13.0):
        radius = 50.0 + excess
        exact = (decimal(radius) ** 2 - 2500).sqrt()
        height = centre_from_radius((0.0, 0.0), (100.0, 0.0), radius, False, ArcTolerance())[1]
        ours = max(ours, abs(float(Decimal(height) / exact - 1)))
        naive = max(naive, abs(float(Decimal(sqrt(radius**2 - 100.0**2 / 4)) / exact - 1)))
    yield Case(
        "arcs", "R half the chord + 1e-12 .. 1e-3", "height of the centre, relative",
        "sqrt(R^2 - c^2/4)", naive, ours, 1e-15, "",
    )  # fmt: skip


def full_circles(quick: bool) -> Iterator[Case]:
    """Circles from any point under any offset, their end words absent or the same."""
    count = 2000 if quick else 20_000
    words = np.random.default_rng([SEED, 3]).uniform(-500, 500, (count, 4)).round(4)
    path, _ = path_of(circle_program(words[::2], "") + circle_program(words[1::2], "X{x} Y{y} "))
    whole = np.count_nonzero(np.abs(path.arcs["sweep"] + 360.0) < 1e-9)
    x, y, i, j = words.T
    back = (x + 123.4567) - 123.4567
    angles = np.arctan2(y - (y + j), x - (x + i)), np.arctan2(y - (y + j), back - (x + i))
    swept = np.mod(angles[0] - angles[1], 2 * np.pi)
    lost = np.count_nonzero((swept > 0.0) & (swept < 1e-6))
    yield Case(
        "arcs", f"{count} full circles", "circles that vanish", "difference of two atan2",
        float(lost), float(count - whole), 0.0, "circles",
    )  # fmt: skip


def circle_program(words: Floats, end: str) -> str:
    """Full circles from X Y about I J, rows of `words` (n, 4), under a turned work offset.

    Args:
        words: [mm], of 4 decimals.
        end: the end words of each, with {x} and {y}; empty: none.
    """
    lines = ["G10 L2 P1 X123.4567 Y-76.5433 R33.3", "F1000."]
    for x, y, i, j in words.tolist():
        same = end.format(x=f"{x:.4f}", y=f"{y:.4f}")
        lines.append(f"G0 X{x:.4f} Y{y:.4f}\nG2 {same}I{i:.4f} J{j:.4f}")
    return "\n".join([*lines, ""])


def rounded_centres(quick: bool) -> Iterator[Case]:
    """I and J to 3 decimals: where the arc ends, and how its radius runs."""
    count = 50 if quick else 1000
    rng = np.random.default_rng([SEED, 4])
    lines, centres, last, gap = ["F1000."], [], [], 0.0
    for radius, begin, sweep in rng.uniform([1, 0, 0.1], [200, 6, 6], (count, 3)).tolist():
        angle = begin, begin + sweep
        ends = [(radius * np.array([np.cos(a), np.sin(a)])).round(4) for a in angle]
        arm = (-radius * np.array([np.cos(begin), np.sin(begin)])).round(3)
        centres.append(ends[0] + arm)
        last.append(ends[1])
        gap = max(gap, abs(hypot(*(ends[1] - centres[-1])) - hypot(*arm)))
        words = [f"X{p[0]:.4f} Y{p[1]:.4f}" for p in ends]
        lines.append(f"G0 {words[0]}\nG3 {words[1]} I{arm[0]:.3f} J{arm[1]:.3f}")
    path, _ = path_of("\n".join(lines))
    piece = np.repeat(np.flatnonzero(path.arc >= 0), 51)
    s = np.tile(np.linspace(0, 1, 51), count)
    seen = path.positions_on(piece, s)[:, path.xyz[:2]] - np.repeat(np.array(centres), 51, axis=0)
    away = np.hypot(*seen.T).reshape(count, 51)
    even = away[:, :1] + s[:51] * (away[:, -1:] - away[:, :1])
    off = np.abs(path.q1[path.arc >= 0][:, path.xyz[:2]] - np.array(last)).max()
    ours = max(float(off), float(np.abs(away - even).max()))
    yield Case(
        "arcs", "I J to 3 decimals", "end point and radius", "one radius to the end",
        float(gap), ours, 1e-12, "mm",
    )  # fmt: skip


def helices(quick: bool) -> Iterator[Case]:
    """Many turns and a quarter, R = 100: places at sixteenths of the way."""
    for turns in (10, 1000, 1_000_000):
        path, _ = path_of(f"G0 X100. Y0.\nG3 X0. Y100. Z-50. I-100. P{turns} F20000.")
        total = turns - 1 + Fraction(1, 4)
        first = int(np.argmax(path.arc >= 0))
        ours = helix_error(path, first, total)
        for name, dtype in FLOATS.items():
            naive = 0.0
            for share in SIXTEENTHS:
                angle = dtype(2 * np.pi) * dtype(float(total * share))
                sine, cosine = exact_sincosd(360 * total * share)
                off = [np.cos(angle) - dtype(float(cosine)), np.sin(angle) - dtype(float(sine))]
                naive = max(naive, 100 * hypot(*map(float, off)))
            yield Case(
                "arcs", f"helix of {power(turns)} turns", "place on the cylinder",
                f"cos(2 pi k), {name}", naive, ours, 2e-12, "mm",
            )  # fmt: skip


SIXTEENTHS = [Fraction(k, 16) for k in range(1, 16)]


def helix_error(path: Path, first: int, total: Fraction) -> float:
    """Largest distance [mm] from a helix about the origin, R = 100, that begins at X100 Y0.

    Infinite when it turns otherwise than it should.

    Args:
        path: with the helix at its end.
        first: piece of the path where it begins.
        total: its turns, either way.
    """
    sense = np.sign(path.arcs["sweep"][path.arc[first]])
    sweeps = sense * path.arcs["sweep"][path.arc[first:]]
    begins = np.concatenate([[0.0], np.cumsum(np.rint(sweeps[:-1]))])
    worst = 0.0
    for share in SIXTEENTHS:
        piece = int(np.searchsorted(begins, float(360 * total * share), side="right")) - 1
        angle = 360 * total * share
        s = float((angle - Fraction(float(begins[piece]))) / Fraction(float(sweeps[piece])))
        q = path.positions_on(np.array([first + piece]), np.array([s]))[0]
        turned = Fraction(float(begins[piece])) + Fraction(float(sweeps[piece])) * Fraction(s)
        sine, cosine = exact_sincosd(turned)
        place = 100 * float(cosine), 100 * sense * float(sine)
        off = [q[path.xyz[axis]] - place[axis] for axis in (0, 1)]
        worst = max(worst, hypot(*off))
    swept = fsum(sweeps.tolist()) / 360.0
    return worst if abs(swept - float(total)) < 1e-9 else inf


MOTION = (
    clocks,
    cycle_times,
    short_blocks,
    feeds,
    arcs,
    radius_words,
    full_circles,
    rounded_centres,
    helices,
)
