"""Transcripts: the commands of gcodesim that a program was given once, and all that they said.

A transcript is a JSON file, `transcripts/GROUP/NAME.json`: the folder, seen from the root of the
repository, and steps. A step is a command with what came of it, or a change of a file between two
commands: `copy` one over another, or `replace` words in it. Only the command line is used here, so
that everything behind it may be moved. A new transcript needs its folder and the bare commands;
`python tests/frozen/renew.py` writes the rest.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import re
import shlex
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from click.testing import CliRunner

from gcodesim import __version__
from gcodesim.cli import main

Step = dict[str, Any]
HERE = Path(__file__).parent
ROOT = HERE.parents[1]
TRANSCRIPTS = HERE / "transcripts"
WIDTH = 100
"""Columns of a transcript that a list or an object may fill before it gets a line per item."""
LONGEST = 20_000
"""Characters of output that are kept as text; of more only a hash and the number of lines."""
PLACES = 9
"""Decimals that are compared: more than any result means, fewer than processors differ in."""
LONG_NUMBER = re.compile(r"-?\d+\.\d{10,}(?:e[-+]?\d+)?|-?\d+(?:\.\d+)?e-\d+")
RUN_TIME = re.compile(r'(?<= time=")[\d.]+(?=")')
SHIPPED = re.compile(r"/\S*/(?=machines/)")
"""The folder of this computer that holds the shipped machines."""


def transcripts(*groups: str) -> list[Path]:
    """The transcripts of GROUPS, of all groups where none is named."""
    return sorted(
        path for group in groups or ("*",) for path in TRANSCRIPTS.glob(f"{group}/*.json")
    )


def name_of(path: Path) -> str:
    """GROUP/NAME of a transcript."""
    return path.relative_to(TRANSCRIPTS).with_suffix("").as_posix()


def then_and_now(path: Path) -> tuple[list[Step], list[Step]]:
    """The steps of a transcript as they are written, and as they come out now."""
    frozen = json.loads(path.read_text(encoding="utf-8"))
    return frozen["steps"], repeated(frozen)["steps"]


def repeated(transcript: dict[str, Any]) -> dict[str, Any]:
    """The transcript as it reads when its steps are carried out now."""
    with _working_folder(transcript):
        return transcript | {"steps": [_carried_out(step) for step in transcript["steps"]]}


@contextlib.contextmanager
def _working_folder(transcript: dict[str, Any]) -> Iterator[None]:
    """The folder of the transcript; where steps change files, a copy of it."""
    folder = ROOT / transcript["folder"]
    with tempfile.TemporaryDirectory() as copies:
        if any("command" not in step for step in transcript["steps"]):
            folder = Path(shutil.copytree(folder, Path(copies) / "copy"))
        with contextlib.chdir(folder):
            yield


def _carried_out(step: Step) -> Step:
    if "copy" in step:
        shutil.copyfile(*step["copy"])
        return step
    if "replace" in step:
        name, old, new = step["replace"]
        Path(name).write_text(Path(name).read_text().replace(old, new))
        return step
    # In CI a check writes a picture of a contact into the working folder.
    done = CliRunner().invoke(main, shlex.split(step["command"]), env={"CI": None})
    output = {"command": step["command"], "exit": done.exit_code}
    if done.stderr:
        output["errors"] = _comparable(done.stderr).splitlines()
    return output | _output(_comparable(done.stdout))


def _comparable(text: str) -> str:
    """Text without what differs from run to run, and with numbers that mean the same everywhere."""
    text = LONG_NUMBER.sub(lambda number: repr(round(float(number[0]), PLACES) + 0.0), text)
    text = text.replace(f'"version": "{__version__}"', '"version": ""')
    return SHIPPED.sub("", RUN_TIME.sub("0", text))


def _output(text: str) -> Step:
    """Standard output as a transcript keeps it."""
    with contextlib.suppress(ValueError):
        report = json.loads(text)
        if isinstance(report, dict):
            report.pop("timing_s", None)
        return {"report": report}
    if len(text) > LONGEST:
        digest = hashlib.sha256(text.encode()).hexdigest()
        return {"lines": text.count("\n"), "sha256": digest}
    return {"output": text.splitlines()} if text else {}


def rendered(value: Any, indent: str = "") -> str:
    """JSON with a line for every item, except where all items fit into one line."""
    short = json.dumps(value, ensure_ascii=False)
    if not isinstance(value, dict | list) or len(indent) + len(short) <= WIDTH:
        return short
    inner = indent + " "
    if isinstance(value, dict):
        items = [f"{json.dumps(key)}: {rendered(item, inner)}" for key, item in value.items()]
        begin, end = "{}"
    else:
        items = [rendered(item, inner) for item in value]
        begin, end = "[]"
    body = ",\n".join(inner + item for item in items)
    return f"{begin}\n{body}\n{indent}{end}"
