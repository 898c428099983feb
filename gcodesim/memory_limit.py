"""Refuses to begin under a limit of memory at which libraries would end the process, or hang."""

from __future__ import annotations

import sys

LEAST_BYTES = 512 << 20
"""Address space that the libraries need to tell that they lack more [bytes]: below it OpenBLAS
exits with 1, which is FAIL, and Warp waits for ever."""


def shortage() -> str:
    """Return why there is too little memory to begin, or nothing."""
    if sys.platform == "win32":
        return ""
    import resource

    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    if limit == resource.RLIM_INFINITY or limit >= LEAST_BYTES:
        return ""
    needed = f"at least {LEAST_BYTES >> 20} MiB, and about 1 GiB for a check"
    return f"only {limit >> 20} MiB of memory may be used (ulimit -v): give {needed}"
