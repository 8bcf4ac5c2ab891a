"""Compilation of numerical kernels, the same everywhere: cached on disk, without the GIL, IEEE arithmetic."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba
from numba.core import config

from geoswarm.solver.kernel_cache import settle

__all__ = ["compiled", "kernel"]

Function = TypeVar("Function", bound=Callable[..., object])

_folder = settle()
if _folder is not None:
    config.CACHE_DIR = str(_folder)  # type: ignore[attr-defined]  # Numba sets its options by name


def kernel(function: Function) -> Function:
    """Compile a kernel.

    No ``fastmath``: the same input gives the same bits on every worker. ``error_model="numpy"`` lets a division by zero
    give inf or nan, which the finite-value guard of the objective then names.
    """
    return cast(Function, numba.njit(cache=_folder is not None, nogil=True, no_cfunc_wrapper=True, error_model="numpy")(function))


def compiled(function: Callable[..., object], signature: Any) -> Any:
    """Compile a function that is called by its address, as :func:`kernel` does; with ``address``."""
    return numba.cfunc(signature, cache=_folder is not None, error_model="numpy")(function)
