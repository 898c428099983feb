"""Runs LinuxCNC's stand-alone interpreter, and reads its canonical calls in the machine frame.

Its own unit is the inch whatever a program says: so is that of the tool table. Positions are
program coordinates in the unit in force, with four decimals.

Read from 2.9.0~pre1+git20230208, which is Debian 12 (bookworm); later releases write other text.
"""

import math
import random
import re
import subprocess

INCH = 25.4
CALL = re.compile(r"^\s*\d+ N[0-9.]+?\s*([A-Z]\w*)\((.*)\)$")
PLANES = {"XY": (0, 1, 2), "XZ": (2, 0, 1), "YZ": (1, 2, 0)}
NAMES = {"XY": "XY", "XZ": "ZX", "YZ": "YZ"}
MOVES = {"STRAIGHT_TRAVERSE": "rapid", "STRAIGHT_FEED": "feed", "STRAIGHT_PROBE": "feed"}

SAME = 5e-3
"""Nearer positions are the same to four decimals of an inch [mm]."""


def canonical_calls(text, tools, folder):
    """Return the calls a program makes as rows like those of `canon`, or None when it is refused.

    Args:
        text: the program.
        tools: number -> entry of our tool table.
        folder: an empty folder to work in.
    """
    done = _run(text, tools, folder)
    if done.returncode:
        return None
    return list(Reader().rows(done.stdout.decode("latin-1").splitlines()))


def refused_block(text, tools, folder):
    """Return the block that a refused program is stopped at; arguments as above."""
    done = _run(text, tools, folder)
    _executing, _why, block, *_stack = filter(str.strip, done.stderr.decode("latin-1").splitlines())
    return block.strip()


def _run(text, tools, folder):
    rows = [
        f"T{n} P{n} "
        + " ".join(f"{a}{v / INCH:.12f}" for a, v in zip("XYZ", t.offset[:3], strict=True))
        + f" D{t.diameter / INCH:.12f} ;"
        for n, t in tools.items()
    ]
    (folder / "tool.tbl").write_text("\n".join(rows) + "\n")
    (folder / "program.ngc").write_text(text)
    command = ["rs274", "-t", str(folder / "tool.tbl"), "-g", str(folder / "program.ngc")]
    return subprocess.run(
        command, capture_output=True, stdin=subprocess.DEVNULL, env={"HOME": str(folder)},
        cwd=folder, timeout=60, check=False,
    )  # fmt: skip


class Reader:
    """What the calls so far have set."""

    def __init__(self):
        self.scale, self.plane, self.rotation, self.feed = 1.0, "XY", 0.0, 0.0
        self.g5x, self.g92, self.tool, self.last = [0.0] * 6, [0.0] * 6, [0.0] * 6, [0.0] * 6

    def rows(self, lines):
        """Yield a row for every call that moves or waits."""
        for line in lines:
            match = CALL.match(line)
            name, inside = match.groups() if match else ("", "")
            if name == "PROGRAM_END":
                return
            yield from self._row(name, inside)

    def _row(self, name, inside):
        numbers = [float(n) for n in re.findall(r"-?\d+(?:\.\d+)?", inside)]
        match name:
            case "USE_LENGTH_UNITS":
                self.scale = INCH if "INCHES" in inside else 1.0
            case "SELECT_PLANE":
                self.plane = inside.removeprefix("CANON_PLANE_")
            case "SET_G5X_OFFSET":
                self.g5x = self._lengths(numbers[1:])
            case "SET_G92_OFFSET":
                self.g92 = self._lengths(numbers)
            case "SET_XY_ROTATION":
                (self.rotation,) = numbers
            case "USE_TOOL_LENGTH_OFFSET":
                self.tool = self._lengths(numbers[:6])
            case "SET_FEED_RATE":
                (self.feed,) = numbers
            case "DWELL":
                yield {"kind": "dwell", "seconds": numbers[0]}
            case "CHANGE_TOOL":
                yield {"kind": "tool", "index": int(numbers[0])}
            case "ARC_FEED":
                yield self._arc(numbers)
            case _ if name in MOVES:
                yield self._move(MOVES[name], self._lengths(numbers))

    def _lengths(self, numbers):
        return [n * self.scale for n in numbers[:3]] + numbers[3:6]

    def _machine(self, point):
        """Return the machine position of a program point [mm, deg]."""
        x, y, *rest = (p + g for p, g in zip(point, self.g92, strict=True))
        c, s = math.cos(math.radians(self.rotation)), math.sin(math.radians(self.rotation))
        turned = [c * x - s * y, s * x + c * y, *rest]
        return [t + g + o for t, g, o in zip(turned, self.g5x, self.tool, strict=True)]

    def _move(self, kind, point):
        to = self._machine(point)
        turning = all(abs(a - b) < SAME for a, b in zip(to[:3], self.last[:3], strict=True))
        self.last = to
        scale = 1.0 if turning else self.scale
        row = {"kind": kind, "to": to}
        return row | ({"f": self.feed * scale} if kind == "feed" else {})

    def _arc(self, numbers):
        first, second, centre_first, centre_second, turns, along, *rotary = numbers
        u, v, w = (0, 1, 2) if self.plane == "XY" else PLANES[self.plane]
        end, centre = [0.0] * 3, [0.0] * 3
        end[u], end[v], end[w] = first, second, along
        centre[u], centre[v], centre[w] = centre_first, centre_second, along
        self.last = self._machine(self._lengths([*end, *rotary]))
        return {
            "kind": "arc",
            "to": self.last,
            "center": self._machine(self._lengths([*centre, *rotary]))[:3],
            # Where X and Y are turned, we name the plane by the normal in the machine.
            **({} if self.rotation else {"plane": NAMES[self.plane], "turns": int(turns)}),
            "f": self.feed * self.scale,
        }


def random_program(seed):
    """Return a program of blocks that both interpreters know.

    Left out is what the stand-alone interpreter does in its own way: probing ends 0.254 mm early,
    a tool change forgets the position, M61 makes no call; and where X and Y are turned, G53, G28
    and G30 beside G92 take their words in the turned frame.
    """
    rng = random.Random(seed)
    turned = rng.random() < 0.5
    blocks = ["G20"] * (rng.random() < 0.15) + [f"T{rng.randint(1, 3)} M6", "S100 M3", "F100"]
    for _ in range(rng.randint(3, 14)):
        text = rng.choice(KINDS)(rng)
        if not (turned and re.search(r"G92 |G52|G28 |G30 ", text)):
            blocks.append(text if turned else text.replace("R30", "").replace("R90", ""))
    return "\n".join([*blocks, "M2", ""])


def _number(rng, most=50):
    return f"{rng.uniform(-most, most):.{rng.choice((0, 1, 2, 3))}f}"


def _words(rng, letters="XYZABC", most=3):
    chosen = rng.sample(letters, rng.randint(1, most))
    return " ".join(f"{letter}{_number(rng)}" for letter in chosen)


def _arc(rng):
    plane, (u, v), (i, j) = rng.choice(
        (("G17", "XY", "IJ"), ("G18", "ZX", "KI"), ("G19", "YZ", "JK"))
    )
    head = f"{plane} {rng.choice(('G2', 'G3'))} F100"
    if rng.random() < 0.5:
        radius = rng.choice((60, 70, -65, 80))
        return f"{head} {u}{_number(rng, 20)} {v}{_number(rng, 20)} R{radius}"
    centre = f"{i}{_number(rng, 9)} {j}{_number(rng, 9)}"
    return f"{head} {centre} {rng.choice(('', 'P2', 'P3', f'{u}0'))} {rng.choice(('', 'A9'))}"


def _cycle(rng):
    code = rng.choice(("G81", "G82 P.5", "G83 Q3", "G73 Q4", "G85", "G89 P1", "G86 P1"))
    repeats = rng.choice(("", "L2", "L3"))
    levels = f"Z{_number(rng, 9)} R{rng.randint(10, 20)}"
    return f"{code} {_words(rng, 'XY', 2)} {levels} {repeats} F100\n{_words(rng, 'XY', 2)}\nG80"


def _loop(rng):
    label = f"o{rng.randint(10**6, 10**8)}"
    return f"{label} repeat [2]\nG91 G0 X1\nG90\n{label} endrepeat"


MODES = (
    "G90 G91 G90.1 G91.1 G17 G18 G19 G40 G94 G61 G64 G98 G99 G80 G92.1 G92.2 G92.3 G28 G30 G49 "
    "G54 G55 G56 G57 G59.3 G43 G28.1 G30.1"
)

KINDS = (
    lambda rng: f"G0 {_words(rng)}",
    lambda rng: f"G1 {_words(rng)} F{rng.randint(1, 900)}",
    lambda rng: f"G1 {_words(rng, 'ABC', 1)} F200",
    _words,
    _arc,
    _arc,
    _cycle,
    _loop,
    *[lambda rng: rng.choice(MODES.split())] * 3,
    lambda rng: f"G10 L2 P{rng.randint(0, 4)} {_words(rng)} R{rng.choice((0, 30, 90))}",
    lambda rng: f"G10 L20 P{rng.randint(0, 4)} {_words(rng)}",
    lambda rng: f"G10 L{rng.choice((1, 10, 11))} P{rng.randint(1, 3)} Z{_number(rng)}",
    lambda rng: f"{rng.choice(('G92', 'G52', 'G28', 'G30'))} {_words(rng)}",
    lambda rng: f"G53 {rng.choice(('G0', 'G1 F50'))} {_words(rng)}",
    lambda rng: rng.choice((f"G43 H{rng.randint(0, 3)}", f"G43.1 Z{_number(rng)}", "G43.2 H2")),
    lambda rng: f"G4 P{rng.choice((0.5, 1, 2))}",
    lambda rng: f"G93 G1 {_words(rng)} F{rng.randint(1, 9)}\nG94 F100",
    lambda rng: f"G95 G1 {_words(rng)} F.3\nG94 F100",
    lambda rng: f"#{rng.randint(1, 4)}=[{_number(rng)}*{rng.choice((2, 3))}]",
    lambda rng: rng.choice(("G0 X#1 Y#2", "G0 X#5420 Y[#5421+1]", "G0 X[#5220]")),
    lambda rng: f"G1 X[SIN[{_number(rng)}]*10] Y[ROUND[{_number(rng)}]] F9",
    lambda rng: f"G87 X{_number(rng)} Y{_number(rng)} Z-5 R20 I1 J1 K-1 F100\nG80",
)
"""What makes one block, or a few, with a random generator."""
