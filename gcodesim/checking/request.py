"""What a check is asked for besides program and machine file: model, options, and what counts."""

from __future__ import annotations

from dataclasses import dataclass, field

from gcodesim.checking.option_kinds import File, OneOf, Switch, Text
from gcodesim.checking.options import Options, Scope, option
from gcodesim.checking.verdict import LEVELS
from gcodesim.nc.control.readings import ways_of


@dataclass(frozen=True, kw_only=True)
class CheckRequest:
    """What decides the answer to a program on a machine; each field says what it is."""

    setup: str | None = option(
        None,
        File(),
        "Setup file: what is clamped where, work offsets, tools; it may name the machine.",
        name="setup",
        metavar="FILE",
    )
    tools: str | None = option(
        None,
        File(),
        "Shapes and lengths of tools: a tools file (YAML), or a library of Fusion (.json, .tools), "
        "FreeCAD (.fctl, .fctb), LinuxCNC (.tbl), Heidenhain (TOOL.T) or a control (G10, $TC_).",
        name="tools",
        metavar="FILE",
    )
    rapids: str | None = option(
        None,
        OneOf(ways_of("rapids")),
        "Rapid moves run straight, or every axis at its own rate. Left out: as the machine file "
        "says.",
        name="rapids",
    )
    allow_outside: bool = option(
        False,
        Switch(),
        "Mesh files may lie outside the folder of the file that names them.",
        name="allow-outside",
    )
    options: Options = field(default_factory=Options)
    fail_on: str = option(
        "error",
        OneOf(LEVELS),
        "What makes a program FAIL: contacts only, or findings of this severity and above.",
        name="fail-on",
    )
    select: tuple[str, ...] = option(
        (),
        Text(),
        "Of what may be ignored only these codes count (GC201, or GC2 for all of GC2xx).",
        name="select",
        metavar="CODE",
        many=True,
    )
    ignore: tuple[str, ...] = option(
        (),
        Text(),
        "These codes do not count; contacts (GC1xx) need a reason.",
        name="ignore",
        metavar="CODE[=REASON]",
        many=True,
        table=True,
    )
    baseline: str | None = option(
        None,
        File(),
        "The findings in this file do not count.",
        name="baseline",
        metavar="FILE",
        scope=Scope.RUN,
    )
