"""Write the five-axis samples for table_tilt: ``python samples/make_five_axis.py [FOLDER]``.

part.nc             a boss: faced in three axes, then chamfered with the table turning and tilting
five_axis_finish.nc a dish of real size: its wall with A negative, its rim with A positive
five_axis_crash.nc  the same program with one wrong value: a retract with a slipped decimal point

Everything is planned in the part frame: origin in the centre of the table's surface, Z up at A0 C0.
`post` then turns tool tips and tool directions into the X Y Z A C words of the machine. The bytes
are the same in every run.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Machine table_tilt: the A axis runs along X through (y, z), seen from the centre of the table.
A_AXIS_Y = -6.0
A_AXIS_Z = 40.0
BALL = 6.0  # radius of the ball end mill [mm]
SPACING = 2.2  # distance of two tip positions [mm]
TIP_SPEED = 100.0  # of the tip on the part [mm/s]
MAX_RATES = (300.0, 300.0, 300.0, 120.0, 240.0)  # of X Y Z A C [mm/s, deg/s]: 3/4 of the rapids
WALL_BLOCKS, RIM_BLOCKS = 1700, 1400
RETRACT, SLIPPED = "G0 Z150.", "G0 Z15.0"  # above the uprights, and the same with a wrong point


def post(tip: Array, tilt: Array, azimuth: Array) -> Array:
    """Return the X Y Z A C words [mm, deg], shape (n, 5), that put the tool where it is wanted.

    Args:
        tip: tool tips in the part frame, shape (n, 3) [mm].
        tilt: angle between tool and part Z, shape (n,) [deg]; its sign chooses the sign of A.
        azimuth: direction in the part's XY plane towards which the tool leans [deg]; with a
            negative tilt it leans the other way.
    """
    a, c = -tilt, azimuth - 90.0
    sin_a, cos_a = np.sin(np.radians(a)), np.cos(np.radians(a))
    sin_c, cos_c = np.sin(np.radians(c)), np.cos(np.radians(c))
    # ISO signs: the table turns against the letters.
    x = tip[:, 0] * cos_c + tip[:, 1] * sin_c
    y = -tip[:, 0] * sin_c + tip[:, 1] * cos_c - A_AXIS_Y
    z = tip[:, 2] - A_AXIS_Z
    turned_y = y * cos_a + z * sin_a + A_AXIS_Y
    turned_z = z * cos_a - y * sin_a + A_AXIS_Z
    return np.column_stack([x, turned_y, turned_z, a, c])


def ball_tips(contact: Array, normal: Array, tilt: Array, azimuth: Array) -> Array:
    """Return the tips of a ball end mill that touches a surface, shape (n, 3) [mm]."""
    sin_t, cos_t = np.sin(np.radians(tilt)), np.cos(np.radians(tilt))
    sin_z, cos_z = np.sin(np.radians(azimuth)), np.cos(np.radians(azimuth))
    tool = np.column_stack([sin_t * cos_z, sin_t * sin_z, cos_t])
    return np.asarray(contact + BALL * (normal - tool))


# -- tool paths in the part frame ------------------------------------------------------------------


def turned_surface(theta: Array, r: Array, z: Array, slope: Array) -> tuple[Array, Array]:
    """Return points and upward normals of a surface z(r) about the table's axis."""
    out = np.column_stack([np.cos(theta), np.sin(theta), np.zeros_like(theta)])
    up = np.array([0.0, 0.0, 1.0])
    normal = (up - slope[:, None] * out) / np.sqrt(1.0 + slope**2)[:, None]
    return r[:, None] * out + z[:, None] * up, normal


def wall() -> tuple[Array, Array, Array]:
    """Tips, tilts and azimuths of the dish's wall: a spiral inwards, the tool leans inwards."""
    s = np.linspace(0.0, 1.0, WALL_BLOCKS)
    theta = s * SPACING * WALL_BLOCKS / 113.0
    r = 131.0 - 31.0 * s + 2.0 * np.cos(6.0 * theta)
    depth = (r - 95.0) / 35.0
    contact, normal = turned_surface(theta, r, 5.0 + 20.0 * depth**2, 40.0 / 35.0 * depth)
    tilt = 72.0 - 30.0 * s + 3.0 * np.cos(6.0 * theta)
    azimuth = np.degrees(theta) + 180.0 + 78.0 * np.sin(2.0 * theta)
    return ball_tips(contact, normal, tilt, azimuth), tilt, azimuth


def rim() -> tuple[Array, Array, Array]:
    """Tips, tilts and azimuths of the rim: a spiral down its outer chamfer, A positive."""
    s = np.linspace(0.0, 1.0, RIM_BLOCKS)
    theta = s * SPACING * RIM_BLOCKS / 136.0
    r = 134.0 + 6.0 * s
    contact, normal = turned_surface(theta, r, 11.0 - 6.0 * s, np.full_like(s, -1.0))
    tilt = -16.0 - 8.0 * np.sin(5.0 * theta)
    azimuth = np.degrees(theta) + 40.0 * np.sin(3.0 * theta)
    return ball_tips(contact, normal, tilt, azimuth), tilt, azimuth


# -- blocks ----------------------------------------------------------------------------------------


def word(letter: str, value: float) -> str:
    """Return a word with four decimals at most, and always a decimal point."""
    text = f"{value + 0.0:.4f}".rstrip("0")
    return letter + ("0." if text in ("-0.", "0.") else text)


def words(row: Array) -> str:
    """Return the X Y Z A C words of one position; C between 0 and 360."""
    values = [*row[:4], row[4] % 360.0]
    return " ".join(word(letter, value) for letter, value in zip("XYZAC", values, strict=True))


def approach(row: Array, above: float) -> Iterator[str]:
    """Turn the table at the safe height, go down to `above` the first point, and onto it."""
    yield f"G0 {word('A', row[3])} {word('C', row[4] % 360.0)}"
    yield f"{word('X', row[0])} {word('Y', row[1])}"
    yield word("Z", row[2] + above)
    yield f"G1 {word('Z', row[2])} F3000."


def five_axis(rows: Array, tips: Array) -> Iterator[str]:
    """Feed blocks under G93: the tip's speed on the part, less where an axis would be too fast."""
    step = np.abs(np.diff(rows, axis=0))
    seconds = np.maximum(
        np.linalg.norm(np.diff(tips, axis=0), axis=1) / TIP_SPEED,
        np.max(step / np.array(MAX_RATES), axis=1),
    )
    yield f"G93 G1 {words(rows[1])} {word('F', round(60.0 / seconds[0], 1))}"
    for row, time in zip(rows[2:], seconds[1:], strict=True):
        yield f"{words(row)} {word('F', round(60.0 / time, 1))}"
    yield "G94"


def start(tool: str) -> Iterator[str]:
    """The blocks every program begins with."""
    yield from ("G21 G17 G40 G49 G80", "G90 G94 G54", "G91 G28 Z0.", "G90", f"T1 M6 ({tool})")
    yield from ("S12000 M3", "G0 X0. Y0.", "G43 H1 Z250.", "M8")


def finish() -> Iterator[str]:
    """The blocks every program ends with."""
    yield from ("G0 Z250.", "M9", "M5", "G91 G28 Z0.", "G28 X0. Y0. A0. C0.", "G90", "M30")


def dish(retract: str) -> Iterator[str]:
    """The dish: wall, way round over the machine's edges, rim."""
    tips, tilt, azimuth = wall()
    rows = post(tips, tilt, azimuth)
    yield from start("BALL END MILL D12")
    yield "(WALL, A NEGATIVE)"
    yield from (*approach(rows[0], 120.0), *five_axis(rows, tips))
    yield "(BLOW THE TABLE CLEAN FROM THE RIGHT AND FROM BEHIND)"
    yield from (retract, "A0.", "X250. Y-6.", "G4 P100", "Y150.", "X0. Y195.", "G4 P100")
    tips, tilt, azimuth = rim()
    rows = post(tips, tilt, azimuth)
    yield "(RIM, A POSITIVE)"
    yield from (*approach(rows[0], 60.0), *five_axis(rows, tips))
    yield from finish()


def boss() -> Iterator[str]:
    """The boss: face and outline in three axes, then a chamfer in five."""
    yield from start("BALL END MILL D12")
    yield "(FACE)"
    yield from ("X-75. Y-40.", "Z35.", "G1 Z30. F6000.", "X75.", "Y0.", "X-75.", "Y40.", "X75.")
    yield "(OUTLINE)"
    yield from ("G0 Z35.", "X90. Y0.", "G1 Z12. F3000.")
    yield from ("X66. F6000.", "G2 I-66. J0.", "G1 X90.", "G0 Z160.")
    theta = np.radians(np.linspace(0.0, 360.0, 73))
    around = np.column_stack([np.cos(theta), np.sin(theta), np.zeros_like(theta)])
    tips = 58.0 * around + [0.0, 0.0, 24.0]
    tilt = 40.0 + 10.0 * np.cos(2.0 * theta)
    rows = post(tips, tilt, np.degrees(theta))
    yield "(CHAMFER, THE TOOL LEANS OUTWARDS)"
    yield from (*approach(rows[0], 50.0), *five_axis(rows, tips))
    yield from finish()


def program(number: int, head: str, comments: Iterable[str], blocks: Iterable[str]) -> str:
    """Return the text of a program; every block but a comment gets an N number."""
    lines = ["%", f"O{number:04d} {head}", *(f"({comment})" for comment in comments)]
    count = 0
    for block in blocks:
        count += not block.startswith("(")
        lines.append(block if block.startswith("(") else f"N{count} {block}")
    return "\n".join([*lines, "%", ""])


def main(folder: Path) -> None:
    """Write the three programs."""
    crash = [
        "AS FIVE_AXIS_FINISH, BUT ONE WORD IS WRONG: THE RETRACT FROM THE WALL",
        f"READS {SLIPPED} INSTEAD OF {RETRACT}",
    ]
    title, expected = "DISH: WALL AND RIM, FIVE-AXIS FINISHING", "FAIL GC102 cutter-A N1716"
    texts = {
        "part.nc": program(
            2000, "(expect: PASS)", ["BOSS: FACE, OUTLINE, FIVE-AXIS CHAMFER"], boss()
        ),
        "five_axis_finish.nc": program(
            2001, "(expect: PASS) (period: 1ms)", [title], dish(RETRACT)
        ),
        "five_axis_crash.nc": program(
            2002, f"(expect: {expected}) (period: 1ms)", [title, *crash], dish(SLIPPED)
        ),
    }
    for name, text in texts.items():
        (folder / name).write_bytes(text.encode("ascii"))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
