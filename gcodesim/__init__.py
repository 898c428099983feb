"""Finds the first collision of a five-axis machine tool running an NC program, before it is cut."""

from __future__ import annotations

TYPE_CHECKING = False  # as in typing, which takes its time to import
if TYPE_CHECKING:
    from typing import Any

    from gcodesim.api import check
    from gcodesim.checking.options import Options
    from gcodesim.checking.verdict import CheckResult as Report
    from gcodesim.collision.geometry.triangles import triangles_intersect
    from gcodesim.errors import UsageError
    from gcodesim.findings.codes import Finding

__all__ = [
    "Finding",
    "Options",
    "Report",
    "UsageError",
    "__version__",
    "check",
    "triangles_intersect",
]
__version__ = "0.1.0"

_HOMES = {
    "Finding": ("gcodesim.findings.codes", "Finding"),
    "Options": ("gcodesim.checking.options", "Options"),
    "Report": ("gcodesim.checking.verdict", "CheckResult"),
    "UsageError": ("gcodesim.errors", "UsageError"),
    "check": ("gcodesim.api", "check"),
    "triangles_intersect": ("gcodesim.collision.geometry.triangles", "triangles_intersect"),
}


def __getattr__(name: str) -> Any:
    # NumPy and Warp take their time to import: each name is loaded only when it is asked for.
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    module, attribute = _HOMES[name]
    return getattr(import_module(module), attribute)
