"""Plans: programs that are checked with the same options, and what these options come to."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gcodesim.batch.programs import each_once
from gcodesim.checking.option_kinds import Switch
from gcodesim.checking.options import OptionField
from gcodesim.checking.request import CheckRequest
from gcodesim.cli.arguments import machine_path_of
from gcodesim.cli.outputs import Input, model_files
from gcodesim.cli.run_options import RunOptions, run_options
from gcodesim.cli.settings_file import Keys, SettingsFile
from gcodesim.errors import UsageError

if TYPE_CHECKING:
    from gcodesim.policy.baseline import Baseline
    from gcodesim.policy.policy import Policy

COMMAND_LINE, DEFAULT = "command line", "default"


@dataclass(frozen=True)
class Choice:
    """The value of an option, and where it comes from.

    Attributes:
        of: the option.
        value: as its field takes it; None: it is not given.
        source: for people.
        keys: where it stands in the settings; empty where it does not.
    """

    of: OptionField
    value: Any
    source: str
    keys: Keys = ()


@dataclass(frozen=True)
class CheckPlan:
    """Programs that are checked with the same options.

    Attributes:
        title: where the plan comes from, for people.
        choices: long option without dashes -> choice.
        settings: that the choices come from.
    """

    title: str
    programs: tuple[str, ...]
    choices: dict[str, Choice]
    settings: SettingsFile = field(default_factory=SettingsFile)

    @cached_property
    def run(self) -> RunOptions:
        """What the choices come to; UsageError where they do not go together."""
        self._refuse_search_options()
        return run_options({each.of.field: each.value for each in self.choices.values()})

    @property
    def asked_of_batch(self) -> CheckRequest:
        """What is asked; the nearest pair is reported unless --min-clearance says otherwise."""
        asked = self.run.asked
        if self.choices["min-clearance"].value is not None:
            return asked
        return replace(asked, options=replace(asked.options, nearest=True))

    def label(self, name: str) -> str:
        """What to call an option in a message: as it was given, or where it stands in a file."""
        keys = self.choices[name].keys
        return self.settings.place(*keys) if keys else f"--{name}"

    @contextmanager
    def naming_places(self) -> Iterator[None]:
        """Errors that begin with an option begin with its place where the settings give it."""
        try:
            yield
        except UsageError as error:
            option, _, rest = str(error).partition(" ")
            name = option.removeprefix("--")
            if name == option or name not in self.choices or not self.choices[name].keys:
                raise
            raise UsageError(f"{self.label(name)} {rest}") from error

    @contextmanager
    def placing(self, name: str) -> Iterator[None]:
        """Errors about the value of an option begin with its place where the settings give it."""
        try:
            yield
        except UsageError as error:
            if not self.choices[name].keys:
                raise
            raise UsageError(f"{self.label(name)}: {error}") from error

    def refuse_missing_files(self) -> None:
        """UsageError where the settings name a file that is not there."""
        for name in ("setup", "tools"):
            choice = self.choices[name]
            if choice.keys and not Path(choice.value).is_file():
                raise UsageError(f"{self.label(name)}: {choice.value}: there is no such file")

    @property
    def machines(self) -> Sequence[str]:
        """The machine files that every program is checked on; UsageError where there is none."""
        from gcodesim.machine.files import find_machine

        machine, setup = self.run.machine, self.run.asked.setup
        with self.placing("machine"):
            return each_once(machine or [machine_path_of(None, setup)], find_machine)

    @property
    def checks(self) -> list[tuple[str, str]]:
        """Every program with every machine."""
        machines = self.machines
        return [(program, machine) for program in self.programs for machine in machines]

    @property
    def inputs(self) -> Iterator[Input]:
        """Yield the files that are read: for what `outputs.claim` refuses to overwrite."""
        yield from ((program, "a program that is checked") for program in self.programs)
        asked = self.run.asked
        for file, what in (
            (self.settings.path, "the settings file"),
            (asked.baseline, "the baseline"),
        ):
            if file:
                yield file, what
        for machine in self.machines:
            yield from model_files(machine, asked.setup, asked.tools)

    def policy(self, baseline: Baseline | None) -> Policy:
        """What counts; UsageError where it is wrong."""
        from gcodesim.policy.policy import policy_of

        return policy_of(self.run.asked, baseline, self.label)

    def _refuse_search_options(self) -> None:
        """UsageError where an option is dropped by the method: never in silence."""
        method = self.choices["method"].value
        for name, choice in self.choices.items():
            option = choice.of.option
            if not option.goes_with(choice.value, method):
                is_word = isinstance(option.kind, Switch) and option.kind.words
                what = self.label(name) + (f" {is_word[1]}" if is_word else "")
                raise UsageError(f"{what} needs --method search, not {method}")
