"""Mutates files of every kind that is read, and reads them: no traceback, no hang, whatever is in.

Run from the repository root: python tests/benchmarks/fuzz_files.py [--count N] [--seed S]; ends
with 1 at the first failure, and leaves the file that caused it in the working folder.
"""

from __future__ import annotations

import argparse
import random
import shutil
import struct
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import trimesh

from gcodesim.batch.results import merge_results, naming_damage
from gcodesim.cli.settings_file import read_settings
from gcodesim.errors import UsageError
from gcodesim.machine.formats.linuxcnc_ini import import_ini
from gcodesim.machine.formats.urdf import import_urdf
from gcodesim.machine.generic import machine_text
from gcodesim.machine.loading import load_machine
from gcodesim.machine.mesh import read_mesh
from gcodesim.machine.tools import read_tools
from gcodesim.policy.baseline import read_baseline
from gcodesim.report.overview import rows_of

SLOW_S = 10.0
"""A file that takes longer hangs for all we know [s]; usual are milliseconds."""

MACHINE = """name: m
dialect: fanuc
links: {bed: {}, X: {box: {size: [80, 80, 10]}}, C: {cylinder: {radius: 100, height: 20}}, Z: {}}
joints:
  X: {type: linear, parent: bed, child: X, axis: [-1, 0, 0], limits: [-300, 300], rapid: 20000}
  C: {type: rotary, parent: X, child: C, axis: [0, 0, -1], point: [0, 0, 0], rapid: 9000}
  Z: {type: linear, parent: bed, child: Z, axis: [0, 0, 1], limits: [-300, 200], rapid: 20000}
tool:
  link: Z
  gauge_point: [0, 0, 200]
  axis: [0, 0, 1]
  mounted: {name: t, length: 100, for: all, cylinder: {radius: 5, height: 9}}
work: {link: C, offsets: {G54: {X: 0, Y: 0, Z: -200}}}
pairs: [{links: [t, C], clearance: 1.5}]
control: {rapids: both}
"""
TOOLS = """tools:
  - number: 2
    type: lollipop
    length: 120
    flute: {diameter: 12, length: 10}
    holder: [[31.5, 0], [31.5, 26], [20, 26], [20, 90]]
  - number: 1
    name: drill
    length: 170
    flute: {diameter: 12, length: 80, corner_radius: 0.5}
    holder: [[31.5, 0], [31.5, 26], [20, 26], [20, 90]]
"""
SETUP = """machine: machine.yaml
bodies:
  vise: {link: C, role: fixture, box: {size: [100, 50, 30], center: [0, 0, 15]}}
offsets: {G54: {X: 1, Y: 2, Z: 3}}
"""
TABLE = "T1 P1 Z50 D10 ;a drill\nT2 P2 Z80.5 X1 Y-2\n"
SETTINGS = """machine = "table_tilt"
fail-on = "contact"
[[jobs]]
programs = ["parts/*.nc"]
setup = "setup.yaml"
"""
INI = """[EMC]
MACHINE = x
[KINS]
KINEMATICS = xyzac-trt-kins coordinates=XYZAC
[TRAJ]
COORDINATES = X Y Z A C
LINEAR_UNITS = mm
[HAL]
HALCMD = setp xyzac-trt-kins.z-rot-point 10
[JOINT_0]
TYPE = LINEAR
MAX_VELOCITY = 50
MIN_LIMIT = -100
MAX_LIMIT = 100
"""
URDF = """<?xml version="1.0"?>
<robot name="r"><link name="base"/><link name="x"><visual><geometry><box size="1 1 1"/></geometry>
</visual></link><joint name="x" type="prismatic"><parent link="base"/><child link="x"/>
<axis xyz="1 0 0"/><limit lower="-1" upper="1" velocity="1"/></joint></robot>
"""
BASELINE = """{"schema": "gcodesim.baseline/1", "entries": [{"program": "a.nc", "machine": "m",
"setup": "", "fingerprint": "0", "code": "GC101", "message": "x", "reason": ""}]}
"""
RESULTS = """{"schema":"gcodesim.batch/1","shard":[1,1],"version":"0",\
"jobs":[{"program":"a.nc","machine":"m","setup":"","key":"k"}]}
{"program":"a.nc","machine":"m","setup":"","key":"k","seconds":1.0,"error":"x"}
"""
FUSION = """{"data": [{"type": "flat end mill", "unit": "millimeters", "description": "mill",
"geometry": {"DC": 10.0, "LCF": 20.0, "LB": 45.0, "OAL": 80.0, "SFDM": 8.0, "NOF": 3,
"shoulder-length": 30.0, "shoulder-diameter": 9.0, "RE": 0.5, "assemblyGaugeLength": 95.0},
"holder": {"type": "holder", "unit": "inches", "gaugeLength": 2.0, "segments": [
{"height": 1.0, "lower-diameter": 1.0, "upper-diameter": 1.2}]},
"post-process": {"number": 1, "length-offset": 2}}], "version": 36}
"""
BIT = """{"version": 2, "name": "bit", "shape": "bullnose.fcstd", "parameter": {"Diameter":
"5,5 mm", "CornerRadius": "0.1 in", "CuttingEdgeHeight": 30, "Length": "50.0 mm",
"ShankDiameter": "3 mm"}}
"""
TOOL_T = """BEGIN TOOL.T MM
T     NAME          L        R       R2     DL     DR     TYP   LCUTS  T-ANGLE
1     MILL_D10      +120.5   +5      +0     -0.5   +0.01  9     +25    +0
2     DRILL_D8      +150     +4      +0     +0     +0     1     +60    +118
[END]
"""
DUMP = """G21
G90 G10 L2 P1 X-350. Y-200.5 Z-100.
G10 L20 P3 X1. C90. (second)
N30 G10 L10 P2 R80.5 (mill)
G10 L11 P2 R-0.1
"""
SIEMENS = """$TC_TP2[3]="MILL D10"
$TC_DP1[3,1]=120
$TC_DP3[3,1]=110.5
$TC_DP6[3,1]=5
$TC_DP7[3,1]=0.5
$P_UIFR[1]=CTRANS(X,-350,Y,-200.5,Z,-100):CFINE(X,0.1):CROT(Z,10)
"""
PIECES = (
    *"\0\n\r\t :-{}[]()<>/#%|~?*&=,;.'",
    *('"', "!!set ", "!!bool ", "!!int ", "!!python/name:os.system ", "&a ", "*a", "<<: ", "? "),
    *("1e999", "-1", "0", "nan", ".inf", "1e9", "9" * 5000, "true", "null", "- ", "::"),
    *("\u20ac", "\ud7ff", "\x85", "\u2028", "[" * 300, " " * 300, "#INCLUDE x\n", "f 1 2 999\n"),
    *("v 1 2\n", "vn 1\n", "solid\n", "facet normal a b c\n", "end_header\n", "e\n", "G54.1 P1"),
)


def seeds(folder: Path) -> dict[str, bytes]:
    """Return the files that are mutated, by name."""
    texts = {
        "machine.yaml": MACHINE,
        "generic.yaml": machine_text("table-table", "generic"),
        "tools.yaml": TOOLS,
        "setup.yaml": SETUP,
        "tools.tbl": TABLE,
        "tools.json": FUSION,
        "tools.fctb": BIT,
        "tools.t": TOOL_T,
        "tools.nc": DUMP,
        "tools.spf": SIEMENS,
        "gcodesim.toml": SETTINGS,
        "machine.ini": INI,
        "machine.urdf": URDF,
        "baseline.json": BASELINE,
        "results.jsonl": RESULTS,
    }
    found = {name: text.encode() for name, text in texts.items()}
    body = trimesh.creation.box([10.0, 20.0, 30.0])
    for kind, more in (
        *(("stl", {}), ("stl_ascii", {}), ("obj", {}), ("off", {}), ("ply", {})),
        *(("ply", {"encoding": "ascii"}), ("glb", {})),
    ):
        content = body.export(file_type=kind, **more)
        name = f"mesh{len(found)}.{kind.removesuffix('_ascii')}"
        found[name] = content.encode() if isinstance(content, str) else content
    (folder / "machine.yaml").write_text(MACHINE)
    return found


def _results(path: Path) -> None:
    merged = merge_results([str(path)])
    with naming_damage(str(path)):
        rows_of(merged.done, merged.missing, merged.missing_shards)
        _ = merged.exit_code


READERS: dict[str, Callable[[Path], Any]] = {
    "setup.yaml": lambda path: load_machine(str(path.parent / "machine.yaml"), setup=str(path)),
    "gcodesim.toml": lambda path: read_settings(str(path)),
    "machine.ini": lambda path: import_ini(str(path)).text,
    "machine.urdf": lambda path: import_urdf(str(path), str(path.parent)).text,
    "baseline.json": lambda path: read_baseline(str(path)),
    "results.jsonl": _results,
}


def reader(name: str) -> Callable[[Path], Any]:
    """Return what reads files of that name."""
    if name.startswith("mesh"):
        return read_mesh
    if name.startswith("tools"):
        return lambda path: read_tools(str(path))
    return READERS.get(name, lambda path: load_machine(str(path)))


def mutant(content: bytes, rng: random.Random) -> bytes:
    """Return a file with one or a few things changed."""
    for _ in range(rng.choice((1, 1, 2, 4))):
        at, kind = rng.randrange(len(content) + 1), rng.randrange(8)
        end = at + rng.randint(1, 12)
        if kind == 0:
            content = content[:at]
        elif kind == 1:
            content = content[:at] + content[end:]
        elif kind == 2:
            content = content[:at] + bytes([rng.randrange(256)]) + content[at + 1 :]
        elif kind == 3:
            other = rng.randrange(len(content) + 1)
            content = content[:at] + content[other : other + 40] + content[at:]
        elif kind == 4:
            number = rng.choice((0, 1, 0x7FFFFFFF, 0xFFFFFFFF, rng.randrange(1 << 32)))
            content = content[:at] + struct.pack("<I", number) + content[at + 4 :]
        elif kind == 5:
            lines = content.split(b"\n")
            line = rng.randrange(len(lines))
            content = b"\n".join([*lines[:line], lines[line], *lines[line + rng.randrange(2) :]])
        else:
            content = content[:at] + rng.choice(PIECES).encode() + content[at + rng.randrange(3) :]
    return content


def failure(path: Path, read: Callable[[Path], Any], met: Counter[str]) -> str:
    """Read a file; return what went wrong, or nothing."""
    begin = time.monotonic()
    try:
        read(path)
        met["read"] += 1
    except (UsageError, OSError) as error:
        met[type(error).__name__] += 1
        if "\n" in str(error):
            return f"a message of several lines: {error}"
    except Exception:
        return traceback.format_exc()
    seconds = time.monotonic() - begin
    return f"took {seconds:.1f} s" if seconds > SLOW_S else ""


def fuzz(count: int, seed: int) -> tuple[str, Counter[str]]:
    """Read mutants of every kind in turn; return the first failure, or nothing, and what became."""
    rng, met = random.Random(seed), Counter[str]()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        originals = seeds(folder)
        names = list(originals)
        for number in range(count):
            kind = names[number % len(names)]
            path = folder / f"mutant_{kind}" if kind != "gcodesim.toml" else folder / kind
            path.write_bytes(mutant(originals[kind], rng))
            if wrong := failure(path, reader(kind), met):
                kept = shutil.copy(path, f"failed_{number}_{kind}")
                return f"mutant {number}, kept as {kept}: {wrong}", met
    return "", met


def main() -> int:
    """Run as told on the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    begin = time.monotonic()
    wrong, met = fuzz(given.count, given.seed)
    print(f"{sum(met.values())} files, seed {given.seed}, {time.monotonic() - begin:.0f} s, {met}")
    print(wrong or "no traceback, no hang")
    return bool(wrong)


if __name__ == "__main__":
    sys.exit(main())
