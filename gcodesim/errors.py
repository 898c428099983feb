"""The errors that leave the room they are raised in, and who catches each one.

GcodesimError          everything below; a bare traceback of another type is a defect
├── UsageError         an option or a file cannot be used: the only kind that reaches a caller of
│   │                  gcodesim; a command ends with exit code 2
│   └── ModelError     a machine, tools or setup file is wrong: names file, line and key
├── OrientationError   no rotary position holds the tool so: raised in machine/, carries a meaning;
│                      the interpreter and the planner make a finding of it
└── ProgramError       a block no control would accept: carries a Finding; the interpreter stops

Errors that the reading of a program raises and catches itself (nc/: of an arc, an expression, the
flow) stand beside the code that raises them and are no GcodesimError: nc/ makes a ProgramError or a
finding of each of them, so none leaves it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gcodesim.findings.codes import Finding


class GcodesimError(Exception):
    """Base of every error that leaves the room it is raised in."""


class UsageError(GcodesimError):
    """An option or a file that cannot be used; the message says what is wrong and what is right."""


class ModelError(UsageError):
    """A machine, tools or setup file is wrong.

    Attributes:
        path: the file, as the user named it.
        line: 1-based line of the key at fault, None when the whole file is meant.
        key: dotted key, for example ``joints.A.limits``; empty when the whole file is meant.
    """

    def __init__(self, message: str, path: str, line: int | None = None, key: str = "") -> None:
        self.path, self.line, self.key = path, line, key
        place = path if line is None else f"{path}:{line}"
        super().__init__(f"{place}: {key}: {message}" if key else f"{place}: {message}")


class OrientationError(GcodesimError):
    """The rotary joints cannot hold the tool in a wanted direction.

    Attributes:
        meaning: stable id of the cause, a key of findings.meanings.MEANINGS.
    """

    def __init__(self, meaning: str, message: str) -> None:
        self.meaning = meaning
        super().__init__(message)


class ProgramError(GcodesimError):
    """A block is refused as a whole; ``finding`` says where and why."""

    def __init__(self, finding: Finding) -> None:
        self.finding = finding
        super().__init__(f"{finding.file}:{finding.line}: {finding.code} {finding.message}")
