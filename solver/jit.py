"""Compilation of numerical kernels, the same everywhere: cached on disk, without the GIL, IEEE arithmetic.

The cache folder carries a fingerprint of all kernel sources. Numba alone renews a cached kernel only when the kernel's
own file changes, not when a kernel that it calls does; a stale caller linked with a new callee gives wrong numbers or
crashes. ``NUMBA_CACHE_DIR`` overrides the folder.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar, cast

import numba
from numba.core import config

__all__ = ["cache_folder", "kernel"]

Function = TypeVar("Function", bound=Callable[..., object])

_KERNEL_PACKAGES = ("constitutive", "element_test", "fem")


def cache_folder(solver: Path) -> Path:
    """Folder of the compiled kernels of the package at ``solver``: another one for any change in a kernel's source."""
    fingerprint = hashlib.sha256()
    for package in _KERNEL_PACKAGES:
        for source in sorted((solver / package).glob("**/*.py")):
            fingerprint.update(source.relative_to(solver).as_posix().encode())
            fingerprint.update(source.read_bytes())
    return solver / "__pycache__" / f"kernels-{fingerprint.hexdigest()[:16]}"


if not config.CACHE_DIR:  # type: ignore[attr-defined]  # Numba sets its options by name
    # A folder that cannot be written to is no error: Numba goes on to its own choices.
    config.CACHE_DIR = str(cache_folder(Path(__file__).parent))  # type: ignore[attr-defined]  # as above


def kernel(function: Function) -> Function:
    """Compile a kernel.

    No ``fastmath``: the same input gives the same bits on every worker. ``error_model="numpy"`` lets a division by zero
    give inf or nan, which the finite-value guard of the objective then names.
    """
    return cast(Function, numba.njit(cache=True, nogil=True, error_model="numpy")(function))
