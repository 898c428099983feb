"""Options from the command line and from the settings file, brought together; --show-settings."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from gcodesim.cli.options import period_text
from gcodesim.errors import UsageError
from gcodesim.settings import Job, Settings, find_settings, read_settings

COMMAND_LINE, DEFAULT = "command line", "default"

NOT_IN_FILES = ("settings", "show-settings", "update-baseline")
"""Options that make no sense in a settings file."""

OF_THE_RUN = (
    *("report", "format", "baseline", "quiet", "no-color"),
    *("snapshot", "html", "glb"),
)
"""Options that hold for a run as a whole, and not for a job."""

SHOWN = 5
"""Programs of a job that --show-settings names."""

FILES = ("machine", "setup", "tools", "baseline", "snapshot", "html", "glb")
"""Options whose value is a file, counted from the folder of the settings."""


@dataclass(frozen=True)
class Choice:
    """The value of an option, and where it comes from."""

    value: Any
    source: str


@dataclass(frozen=True)
class Plan:
    """Programs that are checked with the same options.

    Attributes:
        title: where the plan comes from, for people.
        choices: long option without dashes -> choice.
    """

    title: str
    programs: tuple[str, ...]
    choices: dict[str, Choice]

    @property
    def values(self) -> dict[str, Any]:
        """Option, as a Python name -> value."""
        return {name.replace("-", "_"): choice.value for name, choice in self.choices.items()}

    def label(self, name: str) -> str:
        """What to call an option in a message: as it was given, or where it stands in a file."""
        source = self.choices[name].source
        return f"--{name}" if source in (COMMAND_LINE, DEFAULT) else f"{source}: {name}"


def make_plans(context: click.Context, programs: Sequence[str]) -> tuple[Settings, list[Plan]]:
    """The settings in force, and what is to be checked with which options.

    Programs are checked as the jobs say that they belong to; a machine or setup of the command
    line puts the jobs aside. Without programs every job is carried out.

    Raises:
        UsageError: the settings are wrong, or there is nothing to check.
    """
    settings = read_settings(context.params["settings"] or find_settings(programs))
    top = Plan("", tuple(programs), _choices(context, settings))
    jobs = [_job_plan(context, settings, job) for job in settings.jobs]
    if not programs:
        return settings, [_with_programs(plan, settings.programs(job)) for plan, job in jobs]
    if any(top.choices[name].source == COMMAND_LINE for name in ("machine", "setup")):
        return settings, [top]
    plans = [_with_programs(plan, settings.chosen(job, programs)) for plan, job in jobs]
    belonging = {program for plan in plans for program in plan.programs}
    plans.append(_with_programs(top, [name for name in programs if name not in belonging]))
    return settings, [plan for plan in plans if plan.programs]


def show_settings(context: click.Context, settings: Settings, plans: Sequence[Plan]) -> str:
    """Every option with its value and where it comes from; then the jobs."""
    lines = [f"settings: {settings.path or 'no file found'}"]
    choices = _choices(context, settings)
    lines += _table(choices)
    for plan in plans:
        if plan.title:
            more = len(plan.programs) - SHOWN
            names = [*plan.programs[:SHOWN], *([f"and {more} more"] if more > 0 else [])]
            lines += [f"{plan.title}: {', '.join(names)}"]
            lines += _table({n: c for n, c in plan.choices.items() if c != choices[n]})
    return "\n".join(lines)


def _job_plan(context: click.Context, settings: Settings, job: Job) -> tuple[Plan, Job]:
    return Plan(job.place, (), _choices(context, settings, job)), job


def _with_programs(plan: Plan, programs: Sequence[str]) -> Plan:
    return Plan(plan.title, tuple(programs), plan.choices)


def _choices(
    context: click.Context, settings: Settings, job: Job | None = None
) -> dict[str, Choice]:
    """Every option: from the command line, else from the job, else from the top of the file."""
    options = dict(_options(context.command))
    layers = [(f"{settings.path}", settings.values)]
    if job:
        layers.insert(0, (job.place, job.values))
        for name in set(OF_THE_RUN) & set(job.values):
            raise UsageError(f"{job.place}.{name}: holds for the whole run: write it at the top")
    for place, values in layers:
        for name in values:
            if name not in options:
                raise _unknown_key(place, name, options)
    return {
        name: _choice(context, option, name, layers, settings.folder)
        for name, option in options.items()
    }


def _unknown_key(place: str, name: str, options: Iterable[str]) -> UsageError:
    # Only needed for an error, and slow to import.
    from gcodesim.machine.yaml_lines import suggest

    return UsageError(f"{place}: unknown key {name!r}; {suggest(name, options)}")


def _choice(
    context: click.Context,
    option: click.Option,
    name: str,
    layers: Sequence[tuple[str, dict[str, Any]]],
    folder: Path,
) -> Choice:
    assert option.name is not None
    if context.get_parameter_source(option.name) is not ParameterSource.DEFAULT:
        return Choice(context.params[option.name], COMMAND_LINE)
    for place, values in layers:
        if name in values:
            value = _converted(context, option, values[name], f"{place}: {name}")
            return Choice(_from_folder(name, value, folder), place)
    return Choice(context.params[option.name], DEFAULT)


def _converted(context: click.Context, option: click.Option, value: Any, place: str) -> Any:
    """A value of the file as the option takes it on the command line."""
    if option.is_flag:
        if not isinstance(value, bool):
            raise UsageError(f"{place}: expected true or false, not {value!r}")
        return value
    if isinstance(value, dict) and option.multiple:
        value = [f"{key}={item}" for key, item in value.items()]
    texts = isinstance(value, list) and all(isinstance(item, str) for item in value)
    if option.multiple and not texts:
        raise UsageError(f"{place}: expected a list of texts, not {value!r}")
    plain = isinstance(value, str | int | float) and not isinstance(value, bool)
    if not option.multiple and not plain:
        raise UsageError(f"{place}: expected a text or a number, not {value!r}")
    try:
        return option.type_cast_value(context, value if option.multiple else str(value))
    except click.BadParameter as error:
        raise UsageError(f"{place}: {error.message}") from error


def _from_folder(name: str, value: Any, folder: Path) -> Any:
    """Files counted from the folder of the settings; a machine may be a shipped one."""
    if name == "report":
        return tuple(_report_from(folder, text) for text in value)
    if name not in FILES or (name == "machine" and not (folder / value).is_file()):
        return value
    return str(folder / value)


def _report_from(folder: Path, text: str) -> str:
    name, _, path = text.partition("=")
    return text if path in ("", "-") else f"{name}={folder / path}"


def _options(command: click.Command) -> Iterator[tuple[str, click.Option]]:
    """Yield the options a settings file may hold, by their long names without dashes."""
    for option in command.params:
        if isinstance(option, click.Option):
            name = next(o for o in option.opts if o.startswith("--")).removeprefix("--")
            if name not in NOT_IN_FILES:
                yield name, option


def _table(choices: dict[str, Choice]) -> list[str]:
    rows = [(f"  {name} = {_shown(name, c.value)}", c.source) for name, c in choices.items()]
    width = max((len(left) for left, _ in rows), default=0)
    return [f"{left:<{width}}  ({source})" for left, source in rows]


def _shown(name: str, value: Any) -> str:
    if value is None or value == ():
        return "not given"
    if isinstance(value, bool):
        return str(value).lower()
    if name == "sample-period":
        return period_text(value)
    return ", ".join(value) if isinstance(value, tuple) else str(value)
