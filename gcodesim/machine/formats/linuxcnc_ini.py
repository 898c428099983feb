"""Turns a LinuxCNC INI file into a machine file: axes, travels, speeds and kinematics.

Joints and their directions follow the documented conventions of each kinematics module: X, Y and Z
move the tool, and the machine's zero is where the spindle face stands with every joint at 0.
"""

from __future__ import annotations

import configparser
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gcodesim.errors import ModelError, UsageError
from gcodesim.input_file import TEXT_BYTES, read_bytes, read_text
from gcodesim.machine.formats.imported import Imported
from gcodesim.machine.yaml_lines import suggest

LETTERS = "XYZABCUVW"
SLIDES = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}
LINEAR_UNITS = {"mm": 1.0, "metric": 1.0, "inch": 25.4, "in": 25.4, "imperial": 25.4}
ANGULAR_UNITS = {"deg": 1.0, "degree": 1.0, "rad": 180.0 / math.pi, "radian": 180.0 / math.pi,
                 "grad": 0.9, "gon": 0.9}  # fmt: skip
TYPES = {"LINEAR": False, "ANGULAR": True}

UNLIMITED = 1e9
"""A travel that ends beyond this [machine unit or deg] is none: LinuxCNC's own default is 1e99."""

DEFAULT_SPEED = 1.0
"""LinuxCNC's own MAX_VELOCITY where the file gives none [machine unit/s or deg/s]."""

DEEPEST_INCLUDE = 8


@dataclass(frozen=True)
class KinematicsModule:
    """What a kinematics module says about the rotary axes.

    Attributes:
        work, tool: letters from the base to the work, and from the slides to the tool.
        axes: letter -> direction in which the link turns when the command grows.
        parameters: pins that place the axes, with the module's default in machine units.
        joints: letter of each joint where the module fixes them, else "" (its `coordinates`).
    """

    work: str
    tool: str
    axes: dict[str, tuple[float, float, float]]
    parameters: dict[str, float]
    joints: str = ""


ROTATION_POINT = {"x-rot-point": 0.0, "y-rot-point": 0.0, "z-rot-point": 0.0}
MODULES = {
    "xyzac-trt-kins": KinematicsModule(
        "AC", "", {"A": (1.0, 0.0, 0.0), "C": (0.0, 0.0, 1.0)},
        {**ROTATION_POINT, "y-offset": 0.0, "z-offset": 0.0},
    ),
    "xyzbc-trt-kins": KinematicsModule(
        "BC", "", {"B": (0.0, 1.0, 0.0), "C": (0.0, 0.0, 1.0)},
        {**ROTATION_POINT, "x-offset": 0.0, "z-offset": 0.0},
    ),
    "5axiskins": KinematicsModule(
        "", "CB", {"C": (0.0, 0.0, 1.0), "B": (0.0, -1.0, 0.0)}, {"pivot-length": 250.0}
    ),
    "maxkins": KinematicsModule(
        "C", "B", {"B": (0.0, -1.0, 0.0), "C": (0.0, 0.0, -1.0)}, {"pivot-length": 0.666}, LETTERS
    ),
}  # fmt: skip
"""Module -> its conventions. `trivkins` says nothing about rotary axes: see `_trivial`."""


@dataclass(frozen=True)
class IniFile:
    """An INI file with the files it includes, and the place of every line.

    Attributes:
        lines: (file, line number, text) of every line read.
        parser: what configparser makes of them; of repeated keys the last one counts.
    """

    path: str
    lines: tuple[tuple[str, int, str], ...]
    parser: configparser.ConfigParser

    def value(self, section: str, key: str) -> str | None:
        """The value of a key, None where it is missing or empty."""
        return self.parser.get(section, key, fallback=None) or None

    def number(self, section: str, key: str) -> float | None:
        """The value as a finite number; ModelError for anything else."""
        text = self.value(section, key)
        if text is None:
            return None
        try:
            found = float(text.split()[0])
        except ValueError:
            found = math.nan
        if not math.isfinite(found):
            raise self.error(f"expected a number, not {text!r}", section, key)
        return found

    def values(self, section: str, key: str) -> list[str]:
        """All values of a key that may be repeated, as HALCMD, in the order of the file."""
        found, now = [], ""
        for _, _, text in self.lines:
            header = re.fullmatch(r"\[(.*)\]", text)
            now = header[1] if header else now
            name, equals, value = text.partition("=")
            if now == section and equals and name.strip() == key:
                found.append(value.strip())
        return found

    def error(self, message: str, section: str, key: str = "") -> ModelError:
        """A ModelError at a key, or else at its section, or else at the file."""
        file, line, now, place = self.path, None, "", f"[{section}]"
        for where, number, text in self.lines:
            header = re.fullmatch(r"\[(.*)\]", text)
            now = header[1] if header else now
            if now != section:
                continue
            if line is None or (key and text.partition("=")[0].strip() == key):
                file, line = where, number
        return ModelError(message, file, line, f"{place}{key}")


def import_ini(path: str) -> Imported:
    """The machine of a LinuxCNC INI file.

    Raises:
        UsageError: the file cannot be read.
        ModelError: it is no INI file, or holds what no machine file can say; names the line.
    """
    ini = read_ini(path)
    name, kinematics, letters = _kinematics(ini)
    title = ini.value("EMC", "MACHINE") or Path(path).stem
    machine = Imported(title, f"{Path(path).name} (LinuxCNC, {name})", {"dialect": "linuxcnc"})
    points = _points(ini, machine, name, kinematics)
    machine.links["bed"] = {}
    tool = [letter for letter in "XYZ" if letter in letters] + list(kinematics.tool)
    for chain in (tool, list(kinematics.work)):
        parent = "bed"
        for letter in chain:
            machine.links[letter] = {}
            machine.joints[letter] = _joint(
                ini, machine, letter, letters, parent, kinematics.axes, points
            )
            parent = letter
    work = kinematics.work[-1] if kinematics.work else "bed"
    machine.sections["tool"] = {"link": tool[-1], "gauge_point": (0, 0, 0), "axis": (0, 0, 1)}
    zero = dict.fromkeys("XYZ", 0)
    machine.sections["work"] = {"link": work, "offsets": {"G54": zero}}
    machine.sections["start"] = _start(ini, machine, letters)
    if _unit(ini, "LINEAR_UNITS", LINEAR_UNITS) == LINEAR_UNITS["inch"]:
        machine.sections["control"] = {"program_unit": "inch"}
    machine.remarks += _left_behind(ini, letters)
    return machine


def read_ini(path: str) -> IniFile:
    """Read an INI file; UsageError or ModelError when that cannot be done."""
    lines = tuple(_lines(Path(path), 0))
    parser = configparser.ConfigParser(
        strict=False, interpolation=None, delimiters=("=",), comment_prefixes=("#", ";"),
        inline_comment_prefixes=("#", ";"), allow_no_value=True, default_section="\0",
    )  # fmt: skip
    parser.optionxform = str  # type: ignore[assignment,method-assign]
    try:
        parser.read_string("\n".join(text for _, _, text in lines))
    except configparser.MissingSectionHeaderError as error:
        file, line, _ = lines[error.lineno - 1]
        raise ModelError("expected a [SECTION] before the first key", file, line) from None
    except configparser.ParsingError as error:
        file, line, _ = lines[error.errors[0][0] - 1]
        raise ModelError("expected [SECTION], KEY = value or a comment", file, line) from None
    return IniFile(path, lines, parser)


def _lines(path: Path, depth: int) -> Iterator[tuple[str, int, str]]:
    """Yield every line without indentation, those of included files in their place."""
    try:
        text = read_text(path)
    except OSError as error:
        raise UsageError(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise ModelError(f"not UTF-8 text: byte {error.start}", str(path)) from error
    for number, line in enumerate(text.splitlines(), 1):
        yield str(path), number, line.strip()
        word, _, name = line.strip().partition(" ")
        if word == "#INCLUDE" and name:
            if depth == DEEPEST_INCLUDE:
                raise ModelError("files include each other too deeply", str(path), number)
            yield from _lines(path.parent / name.strip(), depth + 1)


def _kinematics(ini: IniFile) -> tuple[str, KinematicsModule, str]:
    """Name and conventions of the kinematics module, and the letter of each joint."""
    words = (ini.value("KINS", "KINEMATICS") or "trivkins").split()
    name = words[0].lower()
    if name not in MODULES and name != "trivkins":
        text = f"kinematics {name} cannot be turned; {suggest(name, [*MODULES, 'trivkins'])}"
        raise ini.error(text, "KINS", "KINEMATICS")
    given = dict(word.split("=", 1) for word in words[1:] if "=" in word)
    coordinates = given.get("coordinates") or ini.value("TRAJ", "COORDINATES")
    if coordinates is None:
        raise ini.error("COORDINATES is missing: give the axis letters, as XYZAC", "TRAJ")
    letters = "".join(c for c in coordinates.upper() if c in LETTERS)
    kinematics = MODULES.get(name) or _trivial(letters)
    letters = kinematics.joints or letters
    for letter in (*kinematics.work, *kinematics.tool, *SLIDES):
        if letter not in letters and (letter not in SLIDES or name != "trivkins"):
            text = f"{name} needs an axis {letter}, and COORDINATES has {letters}"
            raise ini.error(text, "TRAJ", "COORDINATES")
    if not set(letters) & set("XYZ"):
        raise ini.error("there is no axis X, Y or Z", "TRAJ", "COORDINATES")
    return name, kinematics, letters


def _trivial(letters: str) -> KinematicsModule:
    """Rotary axes of which nothing is known: they carry the work, and turn as ISO 841 has it."""
    axes = {"A": (-1.0, 0.0, 0.0), "B": (0.0, -1.0, 0.0), "C": (0.0, 0.0, -1.0)}
    return KinematicsModule("".join(c for c in "ABC" if c in letters), "", axes, {})


def _points(
    ini: IniFile, machine: Imported, name: str, kinematics: KinematicsModule
) -> dict[str, tuple[float, ...]]:
    """A point on the axis of every rotary joint [mm]; what had to be assumed is remarked."""
    rotary = kinematics.work + kinematics.tool
    if name == "trivkins":
        if rotary:
            text = f"{', '.join(rotary)}: trivkins says neither what the axis carries, nor which "
            machine.remarks.append(f"{text}way it turns (ISO table assumed), nor where it lies")
        return dict.fromkeys(rotary, (0.0, 0.0, 0.0))
    pins = _pins(ini, name)
    scale, found = _unit(ini, "LINEAR_UNITS", LINEAR_UNITS), {}
    for pin, default in kinematics.parameters.items():
        if pin not in pins:
            text = f"no number was found for {name}.{pin}: its default {default:g} is used"
            machine.remarks.append(text)
        found[pin] = pins.get(pin, default) * scale
    for pin in sorted(pins.keys() - found.keys() - {"tool-offset"}):
        machine.remarks.append(f"{name}.{pin} = {pins[pin]:g} is not carried over")
    if "pivot-length" in found:
        pivot = (0.0, 0.0, found["pivot-length"])
        return {c: pivot if c in kinematics.tool else (0.0, 0.0, 0.0) for c in rotary}
    centre = tuple(found[f"{axis}-rot-point"] for axis in "xyz")
    away = (found.get(f"{axis}-offset", 0.0) for axis in "xyz")
    tilt = tuple(c + d for c, d in zip(centre, away, strict=True))
    return {kinematics.work[0]: tilt, kinematics.work[1]: centre}


def _pins(ini: IniFile, name: str) -> dict[str, float]:
    """Pins of the module that HALCMD lines or the HAL files beside the INI file set."""
    commands = []
    for file in ini.values("HAL", "HALFILE"):
        beside = Path(ini.path).parent / file.split()[0] if file else None
        if beside and beside.suffix == ".hal" and beside.is_file():
            commands += read_bytes(beside, TEXT_BYTES).decode(errors="replace").splitlines()
    commands += ini.values("HAL", "HALCMD")
    net_of: dict[str, str] = {}
    settings: dict[str, str] = {}
    for command in commands:
        words = command.partition("#")[0].split()
        if words[:1] == ["net"]:
            net_of |= {word: words[1] for word in words[2:] if word.startswith(f"{name}.")}
        elif words[:1] in (["setp"], ["sets"]) and len(words) == 3:
            settings[words[1]] = words[2]
    settings |= {pin: settings[net] for pin, net in net_of.items() if net in settings}
    pins = {}
    for pin, text in settings.items():
        entry = re.fullmatch(r"\[(\w+)\](\w+)", text)
        value = _float(ini.value(entry[1], entry[2]) or "" if entry else text)
        if pin.startswith(f"{name}.") and value is not None:
            pins[pin.removeprefix(f"{name}.")] = value
    return pins


def _float(text: str) -> float | None:
    """A finite number, None for anything else; HAL's TRUE counts as 1."""
    try:
        value = 1.0 if text.upper() == "TRUE" else float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def _unit(ini: IniFile, key: str, units: dict[str, float]) -> float:
    """Millimetres or degrees in a machine unit; a number says how many units those are."""
    text = (ini.value("TRAJ", key) or next(iter(units))).lower()
    per_unit = _float(text)
    if per_unit is not None and per_unit > 0.0:
        return 1.0 / per_unit
    if text not in units:
        raise ini.error(f"unknown unit {text!r}; {suggest(text, units)}", "TRAJ", key)
    return units[text]


def _find(ini: IniFile, letters: str, letter: str, key: str) -> tuple[str, float | None]:
    """A value of the joint, or else of its axis, with the section that gives it."""
    number = letters.index(letter)
    # Joint limits are what ends the travel; those of an axis hold for the tip.
    sections = [f"JOINT_{number}", f"AXIS_{letter}", f"AXIS_{number}"]
    section = next((s for s in sections if ini.value(s, key) is not None), sections[0])
    return section, ini.number(section, key)


def _joint(
    ini: IniFile,
    machine: Imported,
    letter: str,
    letters: str,
    parent: str,
    axes: dict[str, tuple[float, float, float]],
    points: dict[str, tuple[float, ...]],
) -> dict[str, Any]:
    """The entry of one joint."""
    rotary = letter in "ABC"
    section = f"JOINT_{letters.index(letter)}"
    kind = (ini.value(section, "TYPE") or "").upper()
    if TYPES.get(kind, rotary) != rotary:
        right = "ANGULAR" if rotary else "LINEAR"
        raise ini.error(f"axis {letter} must be {right}, not {kind}", section, "TYPE")
    scale = _scale(ini, letter)
    joint: dict[str, Any] = {"type": "rotary" if rotary else "linear"}
    joint |= {"parent": parent, "child": letter, "axis": SLIDES.get(letter) or axes[letter]}
    joint |= {"point": points[letter]} if rotary else {}
    wrapped = bool(rotary and ini.number(f"AXIS_{letter}", "WRAPPED_ROTARY"))
    limits = None if wrapped else _limits(ini, letters, letter)
    joint |= {"limits": tuple(end * scale for end in limits)} if limits else {}
    where, speed = _find(ini, letters, letter, "MAX_VELOCITY")
    if speed is None:
        speed = DEFAULT_SPEED
        machine.remarks.append(f"{letter}: no MAX_VELOCITY, {speed:g} a second assumed")
    if speed <= 0.0:
        raise ini.error("a speed must be above 0", where, "MAX_VELOCITY")
    joint["rapid"] = speed * scale * 60.0
    where, acceleration = _find(ini, letters, letter, "MAX_ACCELERATION")
    if acceleration is not None and acceleration <= 0.0:
        raise ini.error("an acceleration must be above 0", where, "MAX_ACCELERATION")
    joint |= {"max_acceleration": acceleration * scale} if acceleration else {}
    return joint | ({"wrap": "sign"} if wrapped else {})


def _scale(ini: IniFile, letter: str) -> float:
    if letter in "ABC":
        return _unit(ini, "ANGULAR_UNITS", ANGULAR_UNITS)
    return _unit(ini, "LINEAR_UNITS", LINEAR_UNITS)


def _limits(ini: IniFile, letters: str, letter: str) -> tuple[float, float] | None:
    """Travel in machine units, None where it is unlimited."""
    where, lower = _find(ini, letters, letter, "MIN_LIMIT")
    _, upper = _find(ini, letters, letter, "MAX_LIMIT")
    low = -UNLIMITED if lower is None else lower
    high = UNLIMITED if upper is None else upper
    if low >= high:
        text = f"MIN_LIMIT {low:g} of {letter} is not below MAX_LIMIT {high:g}"
        raise ini.error(text, where, "MIN_LIMIT")
    if low > -UNLIMITED and high < UNLIMITED:
        return low, high
    if (lower is None and upper is None) or (low <= -UNLIMITED and high >= UNLIMITED):
        return None
    text = f"{letter} has one limit only: give both MIN_LIMIT and MAX_LIMIT"
    raise ini.error(text, where, "MIN_LIMIT" if lower is not None else "MAX_LIMIT")


def _start(ini: IniFile, machine: Imported, letters: str) -> dict[str, float]:
    """Where the machine stands after homing, within its travel."""
    start = {}
    for letter, joint in machine.joints.items():
        home = (_find(ini, letters, letter, "HOME")[1] or 0.0) * _scale(ini, letter)
        low, high = joint.get("limits", (-math.inf, math.inf))
        start[letter] = min(max(home, low), high)
        if start[letter] != home:
            text = f"{letter}: HOME {home:g} lies outside its travel, so it starts at the limit"
            machine.remarks.append(text)
    return start


def _left_behind(ini: IniFile, letters: str) -> Iterator[str]:
    """Yield what a machine file has no place for."""
    yield "shapes: an INI file has none; give every link its boxes, cylinders or meshes"
    yield "X, Y and Z are drawn as moving the tool: hang the slides that carry the work under it"
    for letter in sorted(set(letters) & set("UVW")):
        if any(s == f"AXIS_{letter}" for s in ini.parser.sections()):
            yield f"axis {letter}: it stands; give it a joint and a `start` if it carries things"
    for letter in sorted({c for c in letters if letters.count(c) > 1}):
        yield f"joints {letter}: several joints drive the axis, the first one counts"
    for section, key, what in (
        ("RS274NGC", "PARAMETER_FILE", "work offsets and G28 positions in it, G54 = 0 assumed"),
        ("RS274NGC", "RS274NGC_STARTUP_CODE", "blocks that run at power-up"),
        ("RS274NGC", "REMAP", "remapped codes: list those that move nothing in m_codes, g_codes"),
        ("EMCIO", "TOOL_TABLE", "tools: give the file to --tools"),
        ("TRAJ", "MAX_LINEAR_VELOCITY", "a limit of the speed along the path"),
    ):
        values = ini.values(section, key)
        if values:
            yield f"[{section}]{key} = {', '.join(values)}: {what}"
