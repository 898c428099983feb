"""The options of `check`, `batch` and `merge`: one model, of which everything else is derived.

Options of click, keys of settings files, --show-settings and the table of README are made from the
fields here and in the two dataclasses below this one: adding an option is adding a field.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from typing import Any

from gcodesim.checking.option_kinds import (
    Count,
    File,
    MachineName,
    Number,
    OneOf,
    ReportFile,
    Shard,
    Switch,
    Text,
)
from gcodesim.checking.options import OptionField, Scope, option, options_of
from gcodesim.checking.request import CheckRequest
from gcodesim.report.outcome import FORMATS

CHECK, BATCH, MERGE = "check", "batch", "merge"


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """What a run is asked for; each field says what it is."""

    machine: tuple[str, ...] = option(
        (),
        MachineName(),
        "Machine file, or the name of a shipped machine; of several, every program is checked on "
        "each. Left out: the one that the setup names.",
        name="machine",
        metavar="M.yaml",
        many=True,
    )
    asked: CheckRequest = field(default_factory=CheckRequest)
    all_programs: bool = option(
        False,
        Switch(),
        "Check the other main programs of a file too, each as a program of its own.",
        name="all-programs",
        scope=Scope.RUN,
        commands=(CHECK,),
    )
    update_baseline: bool = option(
        False,
        Switch(),
        "Write what is found into the baseline, and take out what is gone.",
        name="update-baseline",
        scope=Scope.COMMAND_LINE,
        commands=(CHECK,),
    )
    format: str = option(
        "text",
        OneOf(FORMATS),
        "Form of the report on standard output.",
        name="format",
        scope=Scope.RUN,
        commands=(CHECK,),
    )
    report: tuple[str, ...] = option(
        (),
        ReportFile(),
        "Write the report in this form too; may be repeated. PATH - is standard output.",
        name="report",
        metavar="FORMAT=PATH",
        many=True,
        table=True,
        scope=Scope.RUN,
        commands=(CHECK, BATCH, MERGE),
    )
    snapshot: str | None = option(
        None,
        File(),
        "Write a picture of the first contact, or else of a pair nearer than its clearance. "
        "Left out: with the environment variable CI=true gcodesim-PROGRAM.png in the working "
        "folder, unless this says none.",
        name="snapshot",
        metavar="PATH.png",
        scope=Scope.RUN,
    )
    html: str | None = option(
        None,
        File(),
        "Write a page that replays the motion in 3D.",
        name="html",
        metavar="PATH.html",
        scope=Scope.RUN,
        commands=(CHECK,),
    )
    glb: str | None = option(
        None,
        File(),
        "Write the moving machine as animated glTF.",
        name="glb",
        metavar="PATH.glb",
        scope=Scope.RUN,
        commands=(CHECK,),
    )
    out: str | None = option(
        None,
        File(),
        "Results file: JSON Lines, one per program, each written at once.",
        name="out",
        metavar="FILE",
        scope=Scope.RUN,
        commands=(BATCH, MERGE),
    )
    overview: str | None = option(
        None,
        File(),
        "Write an overview page.",
        name="html",
        metavar="PATH.html",
        scope=Scope.RUN,
        commands=(BATCH, MERGE),
    )
    resume: bool = option(
        False,
        Switch(),
        "Go on with --out: skip what is done and unchanged.",
        name="resume",
        scope=Scope.RUN,
        commands=(BATCH,),
    )
    jobs: int | None = option(
        None,
        Count(1),
        "Worker processes. Left out: one per core, or one per GPU.",
        name="jobs",
        metavar="N",
        scope=Scope.COMMAND_LINE,
        commands=(BATCH,),
    )
    time_limit: float | None = option(
        None,
        Number("s", above_zero=True),
        "Seconds after which a check is ended: INCONCLUSIVE (GC901).",
        name="time-limit",
        metavar="S",
        scope=Scope.RUN,
        commands=(BATCH,),
    )
    shard: tuple[int, int] = option(
        (1, 1),
        Shard(),
        "Do part I of N; `gcodesim merge` joins the results.",
        name="shard",
        metavar="I/N",
        scope=Scope.COMMAND_LINE,
        commands=(BATCH,),
    )
    scheduler: str | None = option(
        None,
        Text(),
        "Dask scheduler that has the work done, tcp://HOST:PORT, or `local` for a cluster here.",
        name="scheduler",
        metavar="ADDRESS",
        scope=Scope.RUN,
        commands=(BATCH,),
    )
    settings: str | None = option(
        None,
        File(),
        "Settings file. Left out: gcodesim.toml or pyproject.toml above the programs.",
        name="settings",
        metavar="FILE",
        scope=Scope.COMMAND_LINE,
    )
    show_settings: bool = option(
        False,
        Switch(),
        "Print every option in force and where it comes from, and check nothing.",
        name="show-settings",
        scope=Scope.COMMAND_LINE,
    )
    quiet: bool = option(
        False,
        Switch(),
        "No progress bar, and no line that kernels are being compiled.",
        name="quiet",
        scope=Scope.RUN,
    )
    no_color: bool = option(
        False,
        Switch(),
        "No colours; NO_COLOR does the same.",
        name="no-color",
        scope=Scope.RUN,
        commands=(CHECK, BATCH, MERGE),
    )


def _options(model: Any) -> Iterator[OptionField]:
    """Yield the options of a dataclass and of those in it, those about the language together."""
    described = {each.field: each for each in options_of(model) if each.option.name}
    language = [each for each in described.values() if each.option.language]
    yield from language
    for each in fields(model):
        if is_dataclass(each.default_factory):
            yield from _options(each.default_factory)
        elif each.name in described and described[each.name] not in language:
            yield described[each.name]


MODEL = tuple(_options(RunOptions))
"""Every option of the three commands, in the order of --help."""


def of_command(command: str) -> dict[str, OptionField]:
    """The options of a command: long name without dashes -> field."""
    return {each.option.name: each for each in MODEL if command in each.option.commands}


def run_options(given: Mapping[str, Any]) -> RunOptions:
    """The options of a run.

    Args:
        given: field -> value; what is missing or None has its default.

    Raises:
        UsageError: values do not go together.
    """
    made: RunOptions = _made(RunOptions, given)
    return made


def _made(model: Any, given: Mapping[str, Any]) -> Any:
    values = {name: given[name] for name, _, _ in options_of(model) if given.get(name) is not None}
    for each in fields(model):
        if is_dataclass(each.default_factory):
            values[each.name] = _made(each.default_factory, given)
    return model(**values)
