"""The errors that gcodesim raises on purpose, and who catches each one.

GcodesimError          everything below; a bare traceback of another type is a defect
├── UsageError         an option or a file cannot be used: the only kind that reaches a caller of
│   │                  gcodesim; a command ends with exit code 2
│   ├── ModelError     a machine, tools or setup file is wrong: names file, line and key
│   └── UnreadableError  a program cannot be read (cli/check.py): the other programs are checked
├── OrientationError   no rotary position holds the tool so: raised in machine/, carries a meaning;
│                      the interpreter and the planner make a finding of it
├── ProgramError       a line is refused as a whole (nc/control/place.py): carries a Finding, which
│                      the interpreter keeps when it stops
└── ArcError, FlowError (nc/control/), ExpressionError, StructureError (nc/iso/)
                       a rule of the language is broken: the line that broke it becomes a
                       ProgramError where it is known, so none of them leaves nc/
"""

from __future__ import annotations


class GcodesimError(Exception):
    """Base of every error that gcodesim raises on purpose."""


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
