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
from gcodesim.checking.options import Options
from gcodesim.constants import PS_PER_S
from gcodesim.errors import UsageError
from gcodesim.machine.files import files_of
from gcodesim.policy.baseline import read_baseline
from gcodesim.policy.policy import Policy
from gcodesim.policy.rules import parse_prefix, parse_rule


@dataclass(frozen=True)
class Job:
    """One program on one machine.

    Attributes:
        program, machine, setup, tools: as for `gcodesim check`, relative to `folder`.
        allow_outside: mesh files may lie outside the folder of the file that names them.
        rapids: linear | dogleg, None as the machine file says.
        options: of the check.
        fail_on, select, ignore, baseline: what counts, as for `gcodesim check`.
        snapshot: file for the picture of what was found, "" where none is wanted.
        folder: where the names are looked up.
        size: of the program [bytes]; a longer one is begun earlier.
        model: hash of the files of machine, setup, tools and baseline.
        key: hash of everything the answer depends on, "" where a file cannot be read.
        version: of the gcodesim that must do it.
    """

    program: str
    machine: str
    setup: str | None = None
    tools: str | None = None
    allow_outside: bool = False
    rapids: str | None = None
    options: Options = field(default_factory=Options)
    fail_on: str = "error"
    select: tuple[str, ...] = ()
    ignore: tuple[str, ...] = ()
    baseline: str | None = None
    snapshot: str = ""
    folder: str = field(default_factory=os.getcwd)
    size: int = 0
    model: str = ""
    key: str = ""
    version: str = __version__

    def as_json(self) -> str:
        """The job as one line of JSON."""
        return json.dumps(self._values)

    @property
    def _values(self) -> dict[str, Any]:
        """Everything that makes up the job; dataclasses.asdict would take ten times as long."""
        return vars(self) | {"options": vars(self.options)}

    @classmethod
    def from_json(cls, line: str) -> Job:
        """The job of a line of JSON."""
        values: dict[str, Any] = json.loads(line)
        lists = {name: tuple(values[name]) for name in ("select", "ignore")}
        return cls(**values | lists | {"options": Options(**values["options"])})

    def policy(self) -> Policy:
        """What counts; UsageError where it is wrong."""
        return Policy(
            fail_on=self.fail_on,
            select=tuple(parse_prefix(text, "--select") for text in self.select),
            ignore=tuple(parse_rule(text, "--ignore") for text in self.ignore),
            baseline=read_baseline(self.baseline) if self.baseline else None,
        )

    @property
    def label(self) -> dict[str, Any]:
        """What tells one job from another, and an answer to it from an older one."""
        names = {"program": self.program, "machine": self.machine, "setup": self.setup or ""}
        return names | {"key": self.key, "options": list(self._asked())}

    def _asked(self) -> Iterator[str]:
        """Yield the options that differ from what a batch does unless asked, for people."""
        usual = Job("", "", options=Options(nearest=True))._named_options()
        for name, value in self._named_options().items():
            if isinstance(value, tuple):
                yield from (f"--{name} {item}" for item in value)
            elif value != usual[name]:
                text = f"{value:.15g}" if isinstance(value, float) else value
                yield f"--{name}" if value is True else f"--{name} {text}"

    def _named_options(self) -> dict[str, Any]:
        """Values of the options of this job by their names on the command line."""
        asked = self.options
        return {
            "tools": self.tools,
            "dialect": asked.dialect,
            "feed": asked.feed,
            "block-delete": asked.block_delete,
            "rapids": self.rapids,
            "max-blocks": asked.max_blocks,
            "sample-period": f"{asked.period_ps * 1e3 / PS_PER_S:g}ms",
            "method": asked.method,
            "between-samples": "on" if asked.between else "off",
            "clearance": asked.clearance,
            "min-clearance": asked.minimum,
            "no-min-clearance": not asked.minimum and not asked.nearest,
            "stop": "all" if asked.stop_all else "first",
            "audit": asked.audit,
            "fail-on": self.fail_on,
            "select": self.select,
            "ignore": self.ignore,
            "baseline": self.baseline,
            "allow-outside": self.allow_outside,
        }


def prepare(jobs: Iterable[Job]) -> list[Job]:
    """The jobs with size and key, longest program first; what is alike stays in its order."""
    digest = cache(model_digest)  # of this call only: files change
    ready = [_keyed(job, digest) for job in jobs]
    return sorted(ready, key=lambda job: (-job.size, job.program, job.machine, job.setup or ""))


def shard_of(jobs: Sequence[Job], index: int, count: int) -> list[Job]:
    """Part `index` (from 1) of `count` parts of prepared jobs: every part gets long and short."""
    return list(jobs[index - 1 :: count])


def model_digest(machine: str, setup: str | None, tools: str | None, baseline: str | None) -> str:
    """Hash of the content of every file the answers depend on; UsageError, OSError."""
    digest = hashlib.sha256()
    for file in [*files_of(machine, setup, tools), *([Path(baseline)] if baseline else [])]:
        content = file.read_bytes()
        digest.update(f"{len(content)}\0".encode() + content)
    return digest.hexdigest()


def _keyed(job: Job, digest: Callable[..., str]) -> Job:
    """The job with size and key; what cannot be read has no key: it is never done already."""
    try:
        text = Path(job.program).read_bytes()
        model = digest(job.machine, job.setup, job.tools, job.baseline)
    except (UsageError, OSError):
        return job
    job = replace(job, size=len(text), model=model)
    # A result does not depend on where the folder lies, or what its picture is called.
    asked = json.dumps(job._values | {"folder": "", "snapshot": ""}, sort_keys=True)
    return replace(job, key=hashlib.sha256(asked.encode() + b"\0" + text).hexdigest()[:32])
