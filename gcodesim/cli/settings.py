"""Options from the command line and from the settings file, brought together; --show-settings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from gcodesim.batch.programs import each_once, is_dangling, matching, skipped
from gcodesim.checking.option_kinds import File, MachineName, OptionKind, ReportFile, Switch
from gcodesim.checking.options import OptionField, Scope
from gcodesim.cli.plan import COMMAND_LINE, DEFAULT, CheckPlan, Choice
from gcodesim.cli.run_options import MODEL, of_command
from gcodesim.cli.settings_file import JobTable, Keys, SettingsFile, find_settings, read_settings
from gcodesim.errors import UsageError

SHOWN = 5
"""Programs of a job that --show-settings names."""

IN_FILES = {each.option.name: each for each in MODEL if each.option.scope is not Scope.COMMAND_LINE}
"""What may stand in a settings file: one file serves every command that reads settings."""

OF_THE_RUN = {name for name, each in IN_FILES.items() if each.option.scope is Scope.RUN}
"""Options that hold for a run as a whole, and not for a job."""

Layer = tuple[Keys, dict[str, Any]]
"""Values of the settings: those of a job, or those at the top; and where they stand."""


def make_plans(context: click.Context, programs: Sequence[str]) -> list[CheckPlan]:
    """What is to be checked with which options; with --show-settings that is printed, and all.

    Programs are checked as the jobs say that they belong to; a machine or setup of the command
    line puts the jobs aside. Without programs every job is carried out.

    Raises:
        UsageError: the settings are wrong.
        click.UsageError: there is nothing to check.
        click.exceptions.Exit: the settings were shown.
    """
    settings = read_settings(context.params["settings"] or find_settings(programs))
    top = CheckPlan("", tuple(each_once(programs)), _choices(context, settings), settings)
    plans = _plans(context, top)
    if context.params["show_settings"]:
        click.echo(_shown_settings(top, plans))
        context.exit()
    for plan in plans:
        plan.refuse_missing_files()
    if not plans:
        argument = next(p for p in context.command.params if isinstance(p, click.Argument))
        text = f"Missing argument '{argument.metavar}', and no [[jobs]] in a settings file."
        raise click.UsageError(text)
    if not programs:
        patterns = [pattern for job in settings.jobs for pattern in job.patterns]
        tell_skipped(skipped(patterns, settings.folder))
    return plans


def tell_skipped(summary: str) -> None:
    """Say on stderr which files of folders were not taken, if any: never in silence."""
    if summary:
        click.echo(f"gcodesim: {summary}", err=True)


def _plans(context: click.Context, top: CheckPlan) -> list[CheckPlan]:
    """The top of the settings, and the jobs that have programs."""
    programs, settings = top.programs, top.settings
    jobs = [(_job_plan(context, settings, job), job) for job in settings.jobs]
    if not programs:
        return [_with_programs(plan, _programs_of(settings, job)) for plan, job in jobs]
    if any(top.choices[name].source == COMMAND_LINE for name in ("machine", "setup")):
        return [top]
    plans = [_with_programs(plan, _chosen(settings, job, programs)) for plan, job in jobs]
    belonging = {program for plan in plans for program in plan.programs}
    plans.append(_with_programs(top, [name for name in programs if name not in belonging]))
    return [plan for plan in plans if plan.programs]


def _programs_of(settings: SettingsFile, job: JobTable) -> list[str]:
    """Files of a job, pattern by pattern; UsageError: nothing must be left out in silence."""
    found: list[str] = []
    for pattern in job.patterns:
        files = _matching(settings, pattern)
        if not files:
            text = f"no file matches {pattern!r} in folder {str(settings.folder)!r}"
            raise UsageError(f"{settings.place(*job.keys, 'programs')}: {text}")
        found += files
    return each_once(found)


def _chosen(settings: SettingsFile, job: JobTable, programs: Sequence[str]) -> list[str]:
    """Those of some programs that belong to a job."""
    files = {Path(file).resolve() for p in job.patterns for file in _matching(settings, p)}
    return [program for program in programs if Path(program).resolve() in files]


def _matching(settings: SettingsFile, pattern: str) -> list[str]:
    names = matching(pattern, settings.folder)
    return [name for name in names if Path(name).is_file() or is_dangling(Path(name))]


def _shown_settings(top: CheckPlan, plans: Sequence[CheckPlan]) -> str:
    """Every option with its value and where it comes from; then the jobs."""
    lines = [f"settings: {top.settings.path or 'no file found'}", *_table(top.choices)]
    for plan in plans:
        if plan.title:
            more = len(plan.programs) - SHOWN
            names = [*plan.programs[:SHOWN], *([f"and {more} more"] if more > 0 else [])]
            lines += [f"{plan.title}: {', '.join(names)}"]
            lines += _table({n: c for n, c in plan.choices.items() if c != top.choices[n]})
    return "\n".join(lines)


def _job_plan(context: click.Context, settings: SettingsFile, job: JobTable) -> CheckPlan:
    return CheckPlan(_source(settings, job.keys), (), _choices(context, settings, job), settings)


def _with_programs(plan: CheckPlan, programs: Sequence[str]) -> CheckPlan:
    return replace(plan, programs=tuple(programs))


def _source(settings: SettingsFile, keys: Keys) -> str:
    """File, or file and job, for people."""
    return f"{settings.path}: jobs[{keys[1]}]" if keys else f"{settings.path}"


def _choices(
    context: click.Context, settings: SettingsFile, job: JobTable | None = None
) -> dict[str, Choice]:
    """Every option: from the command line, else from the job, else from the top of the file."""
    layers: list[Layer] = [((), settings.values)]
    if job:
        layers.insert(0, (job.keys, job.values))
        for name in job.values:
            if name in OF_THE_RUN:
                place = settings.place(*job.keys, name)
                raise UsageError(f"{place}: holds for the whole run: write it at the top")
    for keys, values in layers:
        for name in values:
            if name not in IN_FILES:
                # Only needed for an error, and slow to import.
                from gcodesim.machine.yaml_lines import suggest

                own = {"programs"} | IN_FILES.keys() - OF_THE_RUN
                valid = sorted(own if keys else {*IN_FILES, "jobs"})
                place = settings.place(*keys, name)
                raise UsageError(f"{place}: unknown key; {suggest(name, valid)}")
    options = of_command(context.command.name or "").values()
    return {each.option.name: _choice(context, each, settings, layers) for each in options}


def _choice(
    context: click.Context, each: OptionField, settings: SettingsFile, layers: Sequence[Layer]
) -> Choice:
    given, name = context.params[each.field], each.option.name
    if context.get_parameter_source(each.field) is not ParameterSource.DEFAULT:
        return Choice(each, given, COMMAND_LINE)
    for keys, values in layers:
        if name not in values:
            continue
        try:
            value = _converted(context, each, values[name])
        except UsageError as error:
            raise UsageError(f"{settings.place(*keys, name)}: {error}") from error
        value = _from_folder(each.option.kind, value, settings.folder)
        return Choice(each, value, _source(settings, keys), (*keys, name))
    return Choice(each, given, DEFAULT)


def _converted(context: click.Context, each: OptionField, value: Any) -> Any:
    """A value of the file as the option takes it on the command line; UsageError."""
    option = each.option
    if isinstance(option.kind, Switch) and not option.kind.words:
        if not isinstance(value, bool):
            raise UsageError(f"expected true or false, not {value!r}")
        return value
    if isinstance(value, dict) and option.table:
        wrong = [key for key, item in value.items() if not isinstance(item, str)]
        if wrong:
            raise UsageError(f"{wrong[0]}: expected a text, not {value[wrong[0]]!r}")
        value = [f"{key}={item}" for key, item in value.items()]
    if isinstance(option.kind, MachineName):
        value = [value] if isinstance(value, str) else value  # most jobs have one machine
        if value == []:
            raise UsageError("expected a machine, or a list of machines, not []")
    texts = isinstance(value, list) and all(isinstance(item, str) for item in value)
    if option.many and not texts:
        raise UsageError(f"expected a list of texts, not {value!r}")
    plain = isinstance(value, str | int | float) and not isinstance(value, bool)
    if not option.many and not plain:
        raise UsageError(f"expected a text or a number, not {value!r}")
    parameter = next(p for p in context.command.params if p.name == each.field)
    try:
        return parameter.type_cast_value(context, value if option.many else str(value))
    except click.BadParameter as error:
        raise UsageError(error.message) from error


def _from_folder(kind: OptionKind, value: Any, folder: Path) -> Any:
    """Files counted from the folder of the settings; a machine may be a shipped one."""
    match kind:
        case File():
            return str(folder / value)
        case ReportFile():
            return tuple(_report_from(folder, text) for text in value)
        case MachineName():
            return tuple(str(folder / m) if (folder / m).is_file() else m for m in value)
    return value


def _report_from(folder: Path, text: str) -> str:
    name, _, path = text.partition("=")
    return text if path in ("", "-") else f"{name}={folder / path}"


def _table(choices: dict[str, Choice]) -> list[str]:
    rows = [
        (f"  {name} = {_shown(choice)}", choice.source)
        for name, choice in choices.items()
        if name in IN_FILES
    ]
    width = max((len(left) for left, _ in rows), default=0)
    return [f"{left:<{width}}  ({source})" for left, source in rows]


def _shown(choice: Choice) -> str:
    """The value as it is written in a file."""
    value = choice.value
    if value is None or value == ():
        return "not given"
    return ", ".join(value) if choice.of.option.many else choice.of.option.kind.written(value)
