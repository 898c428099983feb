"""Writes binary STL for tests."""

import numpy as np


def stl_bytes(triangles: np.ndarray) -> bytes:
    """A binary STL file."""
    table = np.zeros(len(triangles), dtype=[("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")])
    table["v"] = triangles
    return bytes(80) + len(triangles).to_bytes(4, "little") + table.tobytes()
