"""The public functions of the package, for programs that use gcodesim as a library."""

from __future__ import annotations

from os import PathLike, fspath

from gcodesim.checking.flow import check_program
from gcodesim.checking.options import Options
from gcodesim.checking.verdict import CheckResult
from gcodesim.errors import UsageError
from gcodesim.machine.loading import load_machine
from gcodesim.nc.lines import read_program
from gcodesim.policy.policy import Policy


def check(
    program: str | PathLike[str],
    machine: str | PathLike[str],
    *,
    setup: str | PathLike[str] | None = None,
    tools: str | PathLike[str] | None = None,
    allow_outside: bool = False,
    options: Options | None = None,
) -> CheckResult:
    """Check a program on a machine.

    Args:
        program: NC program.
        machine: machine file, or the name of a shipped machine.
        setup: what is clamped where, work offsets, tools.
        tools: tools file or LinuxCNC tool table.
        allow_outside: mesh files may lie outside the folder of the file that names them.
        options: of the check; see gcodesim.Options, which refuses what cannot be used.

    Returns:
        The report: `verdict` is "pass", "fail" or "inconclusive".

    Raises:
        UsageError: a file is missing or wrong, or an option cannot be used.
    """
    if not isinstance(options, Options | None):
        raise UsageError(f"options: expected gcodesim.Options(...), not {options!r}")
    model = load_machine(
        fspath(machine),
        setup=None if setup is None else fspath(setup),
        tools=None if tools is None else fspath(tools),
        allow_outside=allow_outside,
    )
    name, options = fspath(program), options or Options()
    text = read_program(name)
    result = check_program(text, name, model, options)
    # What a comment in the program ignores is ignored here too.
    return Policy().apply(result, text, stop_all=options.stop_all)
