"""Finds the first collision of a five-axis machine tool running an NC program, before it is cut."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gcodesim.collision.triangles import triangles_intersect

__all__ = ["__version__", "triangles_intersect"]
__version__ = "0.1.0"


def __getattr__(name: str) -> Any:
    # Warp takes half a second to import, so it is loaded only when the triangle test is asked for.
    if name == "triangles_intersect":
        from gcodesim.collision.triangles import triangles_intersect

        return triangles_intersect
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
