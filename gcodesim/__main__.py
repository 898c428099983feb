"""Runs the command line as `gcodesim` or `python -m gcodesim`."""

from __future__ import annotations

from gcodesim import interrupt


def run() -> None:
    """Run the command of the command line, and exit with its code."""
    interrupt.arm()
    # Imported now that Ctrl-C is heard: it takes a while.
    import os
    import sys

    from gcodesim.memory_limit import shortage
    from gcodesim.streams import flush, open_streams

    # It has no large matrices to work on, and raises SIGINT where it finds no memory for threads.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    open_streams()
    if why := shortage():
        print(f"gcodesim: {why}", file=sys.stderr, flush=True)
        sys.exit(2)
    interrupt.watch()
    from gcodesim.checking.verdict import USAGE_EXIT
    from gcodesim.cli import main

    code = 0
    try:
        main(prog_name="gcodesim")
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else int(bool(end.code))
    interrupt.disarm()
    if (why := flush()) and code != USAGE_EXIT:
        print(f"gcodesim: standard output cannot be written: {why}", file=sys.stderr, flush=True)
        code = USAGE_EXIT
    if code == interrupt.EXIT:
        # Python would end itself by the signal if it came while `exec` ran, caught or not.
        os._exit(code)
    sys.exit(code)


if __name__ == "__main__":
    run()
