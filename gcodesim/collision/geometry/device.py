"""The device that kernels run on, and quiet, reproducible settings for Warp."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from gcodesim.collision.geometry.kernel_cache import start_warp
from gcodesim.errors import UsageError

wp.config.log_level = wp.LOG_ERROR
wp.config.enable_backward = False


def _start_quietly() -> None:
    """Start Warp; its native code prints a driver warning on every machine without a GPU."""
    saved, void = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(void, 2)
    try:
        start_warp()
    finally:
        os.dup2(saved, 2)
        os.close(saved)
        os.close(void)


_start_quietly()

BIT_EQUAL: dict[str, Any] = {"fuse_fp": False, "fast_math": False, "enable_backward": False}
"""Module options of every kernel file: without contraction of a*b+c the CPU and CUDA round alike,
so both give the same poses and verdicts bit for bit."""


def lent(data: NDArray[Any], dtype: Any, device: str) -> Any:
    """An array on the device; on the CPU the memory of `data` itself, for nothing."""
    return wp.array(np.ascontiguousarray(data), dtype=dtype, device=device, copy=False)


def resolve_device(name: str) -> str:
    """Return the Warp device for `auto`, `cpu`, `cuda` or `cuda:N`.

    Raises:
        UsageError: no such device is present.
    """
    cuda_count = wp.get_cuda_device_count()
    if name == "auto":
        return "cuda:0" if cuda_count else "cpu"
    if name == "cpu":
        return name
    kind, _, index = name.partition(":")
    if kind != "cuda" or (index and not index.isdigit()):
        raise UsageError(f"--device {name}: expected auto, cpu, cuda or cuda:N")
    if int(index or 0) >= cuda_count:
        raise UsageError(f"--device {name}: {cuda_count} CUDA devices present; use --device cpu")
    return f"cuda:{index or 0}"


def every_device(name: str) -> list[str]:
    """All devices that a name allows: every CUDA device for `auto` and `cuda`; UsageError."""
    first = resolve_device(name)
    if name in ("auto", "cuda") and first != "cpu":
        return [f"cuda:{index}" for index in range(wp.get_cuda_device_count())]
    return [first]
