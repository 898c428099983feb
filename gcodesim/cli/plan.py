"""Plans: programs that are checked with the same options, and what these options come to."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gcodesim.batch.programs import each_once
from gcodesim.cli.arguments import machine_path_of
from gcodesim.cli.outputs import Input, model_files
from gcodesim.cli.settings_file import Keys, Settings
from gcodesim.errors import UsageError

if TYPE_CHECKING:
    from gcodesim.checking.options import Options
    from gcodesim.policy.baseline import Baseline
    from gcodesim.policy.policy import Policy

COMMAND_LINE, DEFAULT = "command line", "default"


@dataclass(frozen=True)
class Choice:
    """The value of an option, and where it comes from.

    Attributes:
        source: for people.
        keys: where it stands in the settings; empty where it does not.
    """

    value: Any
    source: str
    keys: Keys = ()


@dataclass(frozen=True)
class Plan:
    """Programs that are checked with the same options.

    Attributes:
        title: where the plan comes from, for people.
        choices: long option without dashes -> choice.
        settings: that the choices come from.
    """

    title: str
    programs: tuple[str, ...]
    choices: dict[str, Choice]
    settings: Settings = field(default_factory=Settings)

    @property
    def values(self) -> dict[str, Any]:
        """Option, as a Python name -> value."""
        return {name.replace("-", "_"): choice.value for name, choice in self.choices.items()}

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
    def told_at(self, name: str) -> Iterator[None]:
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

        machine, setup = self.choices["machine"].value, self.choices["setup"].value
        with self.told_at("machine"):
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
        values = self.values
        for file, what in (
            (self.settings.path, "the settings file"),
            (values["baseline"], "the baseline"),
        ):
            if file:
                yield file, what
        for machine in self.machines:
            yield from model_files(machine, values["setup"], values["tools"])

    def options(self, *, nearest: bool = False) -> Options:
        """Options of the check; UsageError where they do not go together.

        Args:
            nearest: tell the pair that comes nearest, unless --min-clearance says otherwise.
        """
        from gcodesim.checking.options import Options

        values = self.values
        self._refuse_search_options(values)
        return Options(
            dialect=values["dialect"],
            feed=values["feed"],
            period_ps=values["sample_period"],
            device=values["device"],
            method=values["method"],
            between=values["between_samples"] == "on",
            clearance=values["clearance"],
            minimum=bool(values["min_clearance"]),
            nearest=nearest and values["min_clearance"] is None,
            stop_all=values["stop"] == "all",
            audit=values["audit"],
            block_delete=values["block_delete"],
            max_blocks=values["max_blocks"],
        )

    def policy(self, baseline: Baseline | None) -> Policy:
        """What counts; UsageError where it is wrong."""
        from gcodesim.policy.policy import Policy
        from gcodesim.policy.rules import parse_prefix, parse_rule

        values = self.values
        return Policy(
            fail_on=values["fail_on"],
            select=tuple(parse_prefix(text, self.label("select")) for text in values["select"]),
            ignore=tuple(parse_rule(text, self.label("ignore")) for text in values["ignore"]),
            baseline=baseline,
        )

    def _refuse_search_options(self, values: dict[str, Any]) -> None:
        """Only the method search knows distances: its options must not be dropped in silence."""
        asked = {
            "clearance": values["clearance"] is not None,
            "min-clearance": values["min_clearance"],
            "stop": values["stop"] == "all",
            "audit": values["audit"],
        }
        wrong = [name for name, is_given in asked.items() if is_given]
        if wrong and values["method"] != "search":
            what = self.label(wrong[0]) + (" all" if wrong[0] == "stop" else "")
            raise UsageError(f"{what} needs --method search, not {values['method']}")
