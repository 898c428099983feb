"""Small tool libraries as other programs and controls write them, made for the tests."""

from __future__ import annotations

import json
from typing import Any

HOLDER: dict[str, Any] = {
    "description": "collet chuck", "type": "holder", "unit": "inches", "gaugeLength": 2.0,
    "segments": [
        {"height": 1.0, "lower-diameter": 1.0, "upper-diameter": 1.2},
        {"height": 1.0, "lower-diameter": 2.0, "upper-diameter": 2.0},
        {"height": 0.5, "lower-diameter": 1.5, "upper-diameter": 1.5},
    ],
}  # fmt: skip
"""2 inches up to the gauge line, half an inch of it in the spindle."""


def fusion_tool(kind: str = "flat end mill", number: int = 1, **geometry: Any) -> dict[str, Any]:
    """A tool of a Fusion library in mm."""
    usual = {"DC": 10.0, "LCF": 20.0, "LB": 45.0, "OAL": 80.0, "SFDM": 8.0, "NOF": 3,
             "shoulder-length": 30.0, "shoulder-diameter": 9.0, "RE": 0.0}  # fmt: skip
    return {
        "type": kind, "unit": "millimeters", "description": f"{kind} {number}",
        "geometry": usual | geometry, "holder": HOLDER,
        "post-process": {"number": number, "length-offset": number, "diameter-offset": number},
        "start-values": {"presets": [{"n": 8000}]},
    }  # fmt: skip


def fusion_text(*tools: dict[str, Any]) -> str:
    """A Fusion library, one key a line."""
    return json.dumps({"data": list(tools), "version": 36}, indent=1)


def bit_text(shape: str, name: str = "bit", **parameters: str) -> str:
    """A tool bit of FreeCAD."""
    bit = {"version": 2, "name": name, "shape": f"{shape}.fcstd", "parameter": parameters}
    return json.dumps(bit, indent=1)


TOOL_T = """\
BEGIN TOOL.T MM
T     NAME          L        R       R2     DL     DR     TYP   LCUTS  T-ANGLE
0     ZERO          +0       +0      +0     +0     +0     9     +0     +0
1     MILL_D10      +120.5   +5      +0     -0.5   +0.01  9     +25    +0
2     BALL_D6       +100     +3      +3     +0     +0     22    +12    +0
3     DRILL_D8      +150     +4      +0     +0     +0     1     +60    +118
4     TORUS         +90      +6      +1.5   +0     +0     0     +15    +0
5     LATHE         +90      +6      +0     +0     +0     29    +15    +0
7                   +0       +0      +0     +0     +0     99    +0     +0
21    PROBE         +200     +2      +0     +0     +0     21    +0     +0
[END]
"""

G10 = """\
%
O9999 (OFFSETS)
G21
G90 G10 L2 P1 X-350. Y-200.5 Z-100.
G10 L20 P3 X10. B5.
G10 L10 P1 R200. (END MILL D10)
G10 L11 P1 R-0.05
G10 L12 P1 R5.
N60 G10L10P2R-31.5
M30
%
"""

SIEMENS = """\
%_N_TO_TOA_INI
CHANDATA(1)
$TC_TP2[1]="MILL_D10"
$TC_DP1[1,1]=120
$TC_DP3[1,1]=118.2
$TC_DP6[1,1]=5
$TC_DP12[1,1]=-0.2
$TC_TP2[3]="TORUS"
$TC_DP1[3,1]=121 ; end mill with corner rounding
$TC_DP3[3,1]=90
$TC_DP6[3,1]=6
$TC_DP7[3,1]=1.5
$TC_DP3[3,2]=88
$TC_DP1[9,1]=500
$TC_DP3[9,1]=50
$P_UIFR[1]=CTRANS(X,10,Y,-20,Z,-300.5):CROT(X,0,Y,0,Z,0)
M17
"""
