"""The baseline: findings that are known and accepted, in a file that is kept with the programs."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from math import inf
from pathlib import Path, PurePath
from typing import Any

from gcodesim.checking.verdict import CheckResult
from gcodesim.constants import DEPTH_SLACK
from gcodesim.errors import UsageError
from gcodesim.findings.codes import FORMER_CODES, Finding
from gcodesim.findings.fingerprints import fingerprints
from gcodesim.input_file import read_bytes
from gcodesim.output_file import write_text

SCHEMA = "gcodesim.baseline/2"
FORMER_SCHEMA = "gcodesim.baseline/1"
"""Without depths and parts."""

Key = tuple[str, str, str, str]


@dataclass(frozen=True)
class Entry:
    """A finding that is accepted.

    Attributes:
        program, setup: files, counted from the folder of the baseline; no setup is empty. After
            a blank the O-number of a program that is not the first of its file.
        machine: name of the machine.
        fingerprint: of the finding; it survives edits elsewhere in the program.
        code, message: what was found when the entry was made, for people.
        depth: how deep it was then (Finding.depth); None where that was not known.
        reason: why it is accepted; a contact needs one.
    """

    program: str
    machine: str
    setup: str
    fingerprint: str
    code: str
    message: str
    depth: float | None = None
    reason: str = ""

    @property
    def limit(self) -> float | None:
        """Down to which depth the finding is accepted; None: any."""
        return None if self.depth is None else self.depth + DEPTH_SLACK

    @property
    def key(self) -> Key:
        """What finds the entry."""
        return self.program, self.machine, self.setup, self.fingerprint


@dataclass(frozen=True)
class Baseline:
    """A baseline file.

    Attributes:
        path: the file, as the user named it.
        entries: by key, in the order of the file.
    """

    path: str
    entries: dict[Key, Entry]

    def entries_of(self, result: CheckResult) -> list[Entry | None]:
        """The entry of every finding of a result, None where there is none."""
        return [self._entry(keys) for keys in self._keys(result)]

    def unused(self, result: CheckResult) -> list[Entry]:
        """Entries of this program on this machine that no finding matches."""
        found = {key for keys in self._keys(result) for key in keys}
        checked = self._checked(result)
        return [e for key, e in self.entries.items() if key[:3] == checked and key not in found]

    def updated(self, wanted: Iterable[tuple[CheckResult, Sequence[Finding], bool]]) -> Baseline:
        """The baseline with exactly the wanted findings of the checked programs.

        Entries of other programs stay, and so does every reason, unless what it was given for is
        deeper now.

        Args:
            wanted: results, each with those of its findings that are to be in, and whether the
                whole program was looked at: otherwise an entry that matches nothing stays too.
        """
        wanted = list(wanted)
        checked = {self._checked(result) for result, _, whole in wanted if whole}
        entries = {key: e for key, e in self.entries.items() if key[:3] not in checked}
        for result, findings, _ in wanted:
            chosen = {id(finding) for finding in findings}
            for finding, keys in zip(result.findings, self._keys(result), strict=True):
                if id(finding) in chosen:
                    known = self._entry(keys)
                    for former in keys[1:]:
                        entries.pop(former, None)
                    entries[keys[0]] = _renewed(keys[0], finding, known)
        return Baseline(self.path, dict(sorted(entries.items())))

    def write(self) -> None:
        """Write the file.

        Raises:
            UsageError: it cannot be written.
        """
        rows = [
            {name: value for name, value in asdict(entry).items() if value is not None}
            for entry in self.entries.values()
        ]
        text = json.dumps({"schema": SCHEMA, "entries": rows}, indent=2) + "\n"
        try:
            write_text(self.path, text)
        except OSError as error:
            raise UsageError(f"{self.path}: cannot be written: {error.strerror}") from error

    def _entry(self, keys: Sequence[Key]) -> Entry | None:
        """The entry of a finding; by a former key only one from before depths were kept."""
        if keys[0] in self.entries:
            return self.entries[keys[0]]
        former = (self.entries[key] for key in keys[1:] if key in self.entries)
        return next((entry for entry in former if entry.depth is None), None)

    def _keys(self, result: CheckResult) -> list[list[Key]]:
        """The keys of every finding: its own first, then those it had in former versions."""
        files = {file: self._beside(file) for file in {f.file for f in result.findings}}
        moved = [replace(f, file=files[f.file]) for f in result.findings]
        checked = self._checked(result)
        keys: list[list[Key]] = [[(*checked, mark)] for mark in fingerprints(moved)]
        # A contact was one finding then, of its bodies, in the block in which it begins.
        whole = [(i, replace(f, parts=None)) for i, f in enumerate(moved) if not f.continues]
        for i, mark in _marked(whole):
            keys[i].append((*checked, mark))
        for code, formers in FORMER_CODES.items():
            renamed = [(i, f) for i, f in whole if f.code == code]
            for former in formers:
                for i, mark in _marked([(i, replace(f, code=former)) for i, f in renamed]):
                    keys[i].append((*checked, mark))
        return keys

    def _checked(self, result: CheckResult) -> tuple[str, str, str]:
        program = f"{self._beside(result.program)} {result.main_program}".rstrip()
        return program, result.machine, self._beside(result.setup)

    def _beside(self, file: str) -> str:
        """A file counted from the folder of the baseline: the same from wherever one works."""
        if not file:
            return ""
        return PurePath(os.path.relpath(file, Path(self.path).parent)).as_posix()


def _marked(findings: Sequence[tuple[int, Finding]]) -> Iterator[tuple[int, str]]:
    """Yield the numbers of some findings with the fingerprints of these findings."""
    marks = fingerprints(finding for _, finding in findings)
    yield from zip((i for i, _ in findings), marks, strict=True)


def _renewed(key: Key, finding: Finding, known: Entry | None) -> Entry:
    """The entry of a finding; a reason does not speak of what is deeper than it was."""
    new = Entry(*key, finding.code, finding.message, finding.depth)
    if known is None:
        return new
    if finding.depth is None:
        return replace(new, depth=known.depth, reason=known.reason)
    deeper = known.limit is not None and finding.depth > known.limit
    return replace(new, reason="" if deeper else known.reason)


def read_baseline(path: str, *, may_be_new: bool = False) -> Baseline:
    """Read a baseline file.

    Args:
        path: the file.
        may_be_new: a file that is not there is empty, for it is about to be written.

    Raises:
        UsageError: it is missing or wrong; names the entry and the key.
    """
    if may_be_new and not Path(path).exists():
        return Baseline(path, {})
    try:
        data = json.loads(read_bytes(path).decode("utf-8"))
    except FileNotFoundError as error:
        makes = f"`gcodesim check PROGRAM... --baseline {path} --update-baseline` makes it"
        raise UsageError(f"{path}: there is no such file: {makes}") from error
    except OSError as error:
        raise UsageError(f"{path}: cannot be read: {error.strerror}") from error
    except (ValueError, RecursionError) as error:
        raise UsageError(f"{path}: no JSON: {error}") from error
    if not isinstance(data, dict) or data.get("schema") not in (SCHEMA, FORMER_SCHEMA):
        raise UsageError(f"{path}: schema: expected {SCHEMA!r}, as --update-baseline writes")
    rows = data.get("entries")
    if not isinstance(rows, list):
        raise UsageError(f"{path}: entries: expected a list")
    entries = [_entry(row, f"{path}: entries[{i}]") for i, row in enumerate(rows)]
    return Baseline(path, {entry.key: entry for entry in entries})


def _entry(row: Any, place: str) -> Entry:
    names = list(Entry.__dataclass_fields__)
    texts = [name for name in names if name != "depth"]
    values = row if isinstance(row, dict) else {"": None}
    if not all(isinstance(value, str) for name, value in values.items() if name != "depth"):
        raise UsageError(f"{place}: expected texts for {', '.join(texts)}")
    depth = values.get("depth", 0.0)
    if isinstance(depth, bool) or not isinstance(depth, int | float) or not 0.0 <= depth < inf:
        raise UsageError(f"{place}.depth: expected a number from 0 on [mm, deg]")
    for name in texts[:-1]:
        if name not in row:
            raise UsageError(f"{place}.{name}: this key is required and missing")
    for name in row:
        if name not in names:
            raise UsageError(f"{place}.{name}: unknown key; valid: {', '.join(names)}")
    return Entry(**row)
