"""Jobs: a program on a machine, in which order they are done, and what makes one done."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

from gcodesim import __version__
from gcodesim.checking.option_kinds import Switch
from gcodesim.checking.options import Option, OptionField, Options, options_of
from gcodesim.checking.request import CheckRequest
from gcodesim.errors import UsageError
from gcodesim.input_file import read_bytes
from gcodesim.machine.files import files_of
from gcodesim.policy.baseline import read_baseline
from gcodesim.policy.policy import Policy, policy_of

IN_THE_LABEL = ("setup", "device")
"""Options that a label has beside the others, or that do not change the answer."""


@dataclass(frozen=True, kw_only=True)
class Job:
    """One program on one machine.

    Attributes:
        program, machine: as for `gcodesim check`, relative to `folder`, as all files of `asked`.
        asked: model, options and what counts.
        snapshot: file for the picture of what was found, "" where none is wanted.
        ignored_by: what to call the option that ignores, where it does.
        folder: where the names are looked up.
        size: of the program [bytes]; a longer one is begun earlier.
        model: hash of the files of machine, setup, tools and baseline.
        key: hash of everything the answer depends on, "" where a file cannot be read.
        version: of the gcodesim that must do it.
    """

    program: str
    machine: str
    asked: CheckRequest = field(default_factory=CheckRequest)
    snapshot: str = ""
    ignored_by: str = "--ignore"
    folder: str = field(default_factory=os.getcwd)
    size: int = 0
    model: str = ""
    key: str = ""
    version: str = __version__

    @property
    def options(self) -> Options:
        """Options of the check."""
        return self.asked.options

    @property
    def setup(self) -> str:
        """Setup file, "" where there is none."""
        return self.asked.setup or ""

    def with_options(self, **changed: Any) -> Job:
        """The job with some options of the check changed."""
        asked = replace(self.asked, options=replace(self.options, **changed))
        return replace(self, asked=asked)

    def as_json(self) -> str:
        """The job as one line of JSON."""
        return json.dumps(self._values)

    @property
    def _values(self) -> dict[str, Any]:
        """Everything that makes up the job; dataclasses.asdict would take ten times as long."""
        return vars(self) | {"asked": vars(self.asked) | {"options": vars(self.options)}}

    @classmethod
    def from_json(cls, line: str) -> Job:
        """The job of a line of JSON."""
        values: dict[str, Any] = json.loads(line)
        asked = values["asked"]
        asked |= {each.field: tuple(asked[each.field]) for each in _lists()}
        asked["options"] = Options(**asked["options"])
        return cls(**values | {"asked": CheckRequest(**asked)})

    def policy(self) -> Policy:
        """What counts; UsageError where it is wrong."""
        baseline = self.asked.baseline
        given = read_baseline(baseline) if baseline else None
        names = {"select": "--select", "ignore": self.ignored_by}
        return policy_of(self.asked, given, names.__getitem__)

    @property
    def label(self) -> dict[str, Any]:
        """What tells one job from another, and an answer to it from an older one."""
        names = {"program": self.program, "machine": self.machine, "setup": self.setup}
        return names | {"key": self.key, "options": list(self._named_options())}

    def _named_options(self) -> Iterator[str]:
        """Yield the options that differ from what a batch does unless asked, for people."""
        for described in (self.asked, self.options):
            for name, option, default in options_of(type(described)):
                value = getattr(described, name)
                if option.name and option.name not in IN_THE_LABEL and value != default:
                    items = value if option.many else [value]
                    yield from (_on_the_command_line(option, item) for item in items)
        if not (self.options.minimum or self.options.nearest):
            yield "--no-min-clearance"


def _lists() -> list[OptionField]:
    return [each for each in options_of(CheckRequest) if each.option.many]


def _on_the_command_line(option: Option, value: Any) -> str:
    """An option that is given, as a user would give it."""
    if isinstance(value, bool) and isinstance(option.kind, Switch) and not option.kind.words:
        return f"--{option.name}"
    text = f"{value:.15g}" if isinstance(value, float) else option.kind.written(value)
    return f"--{option.name} {text}"


def prepare(jobs: Iterable[Job]) -> list[Job]:
    """The jobs with size and key, longest program first; what is alike stays in its order."""
    digest = cache(model_digest)  # of this call only: files change
    ready = [_keyed(job, digest) for job in jobs]
    return sorted(
        ready, key=lambda job: (-job.size, job.program, job.machine, job.asked.setup or "")
    )


def shard_of(jobs: Sequence[Job], index: int, count: int) -> list[Job]:
    """Part `index` (from 1) of `count` parts of prepared jobs: every part gets long and short."""
    return list(jobs[index - 1 :: count])


def model_digest(machine: str, setup: str | None, tools: str | None, baseline: str | None) -> str:
    """Hash of the content of every file the answers depend on; UsageError, OSError."""
    digest = hashlib.sha256()
    for file in [*files_of(machine, setup, tools), *([Path(baseline)] if baseline else [])]:
        content = read_bytes(file)
        digest.update(f"{len(content)}\0".encode() + content)
    return digest.hexdigest()


def _keyed(job: Job, digest: Callable[..., str]) -> Job:
    """The job with size and key; what cannot be read has no key: it is never done already."""
    asked = job.asked
    try:
        text = read_bytes(job.program)
        model = digest(job.machine, asked.setup, asked.tools, asked.baseline)
    except (UsageError, OSError):
        return job
    job = replace(job, size=len(text), model=model)
    # A result does not depend on where the folder lies, or what its picture is called.
    values = json.dumps(job._values | {"folder": "", "snapshot": ""}, sort_keys=True)
    return replace(job, key=hashlib.sha256(values.encode() + b"\0" + text).hexdigest()[:32])
