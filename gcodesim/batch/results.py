"""The results file of a batch: JSON Lines, a plan of what is to be done, then one record per job.

A plan opens every run, and the last one of a file counts. A job of the plan without a record was
not checked, and makes the whole INCONCLUSIVE: half a batch is never taken for all of it.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from gcodesim import __version__
from gcodesim.batch.records import Record, exit_code, is_done
from gcodesim.checking.verdict import EXIT_CODES, worst_exit
from gcodesim.errors import UsageError
from gcodesim.findings.codes import INCONCLUSIVE
from gcodesim.input_file import read_bytes
from gcodesim.output_file import replacing

SCHEMA = "gcodesim.batch/1"

Label = dict[str, str]
"""What tells jobs apart: program, machine, setup, and the key of what they depend on."""


@dataclass(frozen=True)
class RunPlan:
    """What a run is to do.

    Attributes:
        jobs: labels of its jobs.
        shard: number of this part of the batch, counted from 1, and how many parts there are.
        version: of gcodesim.
    """

    jobs: Sequence[Label] = ()
    shard: tuple[int, int] = (1, 1)
    version: str = __version__

    def as_json(self) -> str:
        """The plan as one line of JSON."""
        return json.dumps({"schema": SCHEMA, **asdict(self)})


@dataclass(frozen=True)
class Results:
    """A plan, the records that are there, and the parts of the batch that are not."""

    plan: RunPlan
    records: dict[tuple[str, ...], Record] = field(default_factory=dict)
    missing_shards: tuple[str, ...] = ()

    def add(self, record: Record) -> None:
        """Take a record in; it replaces an older one of the same job."""
        self.records[identity(record)] = record

    @property
    def done(self) -> list[Record]:
        """Records of the jobs of the plan, in its order."""
        found = (self.records.get(identity(job)) for job in self.plan.jobs)
        return [record for record in found if record is not None]

    @property
    def missing(self) -> list[Label]:
        """Labels of the jobs that have no record."""
        return [job for job in self.plan.jobs if identity(job) not in self.records]

    @property
    def exit_code(self) -> int:
        """The worst of all programs; what was not checked counts as INCONCLUSIVE."""
        codes = [exit_code(record) for record in self.done]
        if self.missing or self.missing_shards or not codes:
            codes.append(EXIT_CODES[INCONCLUSIVE])
        return worst_exit(codes)


def identity(label: dict[str, Any]) -> tuple[str, ...]:
    """What a job and its record have in common."""
    return label["program"], label["machine"], label["setup"], label["key"]


def read_results(path: str) -> Results:
    """The results of a file; a last line that was cut off is as if it had not been begun.

    Raises:
        UsageError: the file cannot be read, or holds something else.
    """
    try:
        lines = read_bytes(path).decode("utf-8").splitlines(keepends=True)
    except OSError as error:
        raise UsageError(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise UsageError(f"{path}: no results of gcodesim batch: {error}") from error
    plan, records = None, {}
    for number, line in enumerate(lines, start=1):
        if not line.endswith("\n"):
            break
        try:
            values = json.loads(line)
            if "schema" in values:
                plan = _plan_of(values)
            else:
                records[identity(values)] = values
        except (ValueError, KeyError, TypeError, OverflowError, RecursionError) as error:
            raise UsageError(f"{path}:{number}: no results of gcodesim batch: {error}") from None
    if plan is None:
        raise UsageError(f"{path}: no results of gcodesim batch: there is no plan in it")
    return Results(plan, records)


@contextmanager
def naming_damage(place: str) -> Iterator[None]:
    """Errors of what is made from records say that they are damaged, or of another version."""
    try:
        yield
    except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
        why = f"a record is damaged, or not of this version of gcodesim ({error!r})"
        raise UsageError(f"{place}: {why}") from error


def _plan_of(values: dict[str, Any]) -> RunPlan:
    """The plan of a line of JSON; ValueError, KeyError or TypeError where it is none."""
    for job in values["jobs"]:
        if not all(isinstance(word, str) for word in identity(job)):
            raise TypeError("a job is told by texts")
    index, count = map(int, values["shard"])
    return RunPlan(values["jobs"], (index, count), values["version"])


def start_results(path: str, plan: RunPlan, *, resume: bool) -> Results:
    """Open a run in a results file; what of the plan it has already.

    Raises:
        UsageError: the file is there without `resume`, or holds something else.
    """
    results = Results(plan)
    if Path(path).exists():
        if not resume:
            raise UsageError(f"{path} is there already: --resume goes on with it, or remove it")
        if not Path(path).is_file():
            raise UsageError(f"{path} is no file: --resume needs what an earlier run wrote")
        old = read_results(path).records
        with naming_damage(path):
            done = {name: record for name, record in old.items() if is_done(record)}
        results = Results(plan, done)
        _cut_off_half_a_line(Path(path))
    with open(path, "a", encoding="utf-8") as out:
        print(plan.as_json(), file=out)
    return results


def write_record(path: str, record: Record) -> None:
    """Append a record; it is in the file at once."""
    with open(path, "a", encoding="utf-8") as out:
        print(json.dumps(record), file=out)


def write_results(path: str, results: Results) -> None:
    """Write a plan and its records as a new file, or in place of older results.

    Raises:
        UsageError: the file holds something else.
        OSError: it cannot be written.
    """
    if Path(path).is_file() and Path(path).stat().st_size:
        try:
            read_results(path)
        except UsageError as error:
            raise UsageError(f"--out would replace another kind of file: {error}") from error
    with replacing(path, "w", encoding="utf-8") as out:
        print(results.plan.as_json(), file=out)
        for record in results.done:
            print(json.dumps(record), file=out)


def merge_results(paths: Sequence[str]) -> Results:
    """The results of several files as one; of the same job of the same part the later file counts.

    Raises:
        UsageError: a file cannot be read, or the files are parts of batches of different sizes.
    """
    all_results = [read_results(path) for path in paths]
    count = all_results[0].plan.shard[1]
    for path, results in zip(paths, all_results, strict=True):
        if results.plan.shard[1] != count:
            parts = f"{paths[0]} is one of {count}, {path} one of {results.plan.shard[1]}"
            raise UsageError(f"parts of different batches: {parts}")
    there = {results.plan.shard[0] for results in all_results}
    jobs = {place: job for results in all_results for place, job in _places(results.plan)}
    missing = tuple(f"{i}/{count}" for i in range(1, count + 1) if i not in there)
    merged = Results(RunPlan(list(jobs.values())), missing_shards=missing)
    for results in all_results:
        merged.records.update(results.records)
    return merged


def _places(plan: RunPlan) -> Iterator[tuple[tuple[Any, ...], Label]]:
    """Yield every job with its place in the batch, which stays when the program is changed.

    A program may be checked twice on one machine, with different options: none must be lost.
    """
    counts: Counter[tuple[str, ...]] = Counter()
    for job in plan.jobs:
        names = identity(job)[:3]
        counts[names] += 1
        yield (plan.shard[0], *names, counts[names]), job


def _cut_off_half_a_line(path: Path) -> None:
    """Remove what was being written when the last run was killed."""
    content = path.read_bytes()
    with path.open("r+b") as file:
        file.truncate(content.rfind(b"\n") + 1)
