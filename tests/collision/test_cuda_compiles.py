"""Every kernel module compiles for CUDA, on machines without a GPU too."""

from __future__ import annotations

import pkgutil
from importlib import import_module
from pathlib import Path

import pytest
import warp as wp

import gcodesim.collision
import gcodesim.study.kernels

QUICK = "gcodesim.collision.geometry.triangles"
ARCHITECTURES = [75, 90]  # Turing, the oldest that counts, and Hopper


def kernel_modules() -> list[str]:
    names = [
        module.name
        for package in (gcodesim.collision, gcodesim.study.kernels)
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}.")
    ]
    return [
        name
        for name in names
        if any(
            isinstance(item, wp.Kernel) and item.module.name == name
            for item in vars(import_module(name)).values()
        )
    ]


def test_there_are_kernels_to_compile() -> None:
    assert {"gcodesim.collision.instants.touches", QUICK} <= {*kernel_modules()}


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=() if name == QUICK else pytest.mark.slow)
        for name in kernel_modules()
    ],
)
def test_module_compiles_for_cuda(name: str, tmp_path: Path) -> None:
    wp.compile_aot_module(
        import_module(name), device=None, arch=ARCHITECTURES, module_dir=tmp_path, use_ptx=True
    )
    kernels = [k for k in vars(import_module(name)).values() if isinstance(k, wp.Kernel)]
    written = sorted(tmp_path.rglob("*.ptx"))
    assert len(written) == len(ARCHITECTURES)
    for file in written:
        text = file.read_text()
        for kernel in kernels:
            if kernel.module.name == name:
                assert f"{kernel.key}_" in text
