"""Compilation of numerical kernels, the same everywhere: cached on disk, without the GIL, IEEE arithmetic."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any, TypeVar, cast

import numba
from numba.core import config

from geoswarm.solver.kernels.cache import part_of, settle

__all__ = ["compiled", "inlined", "kernel", "kernel_in_place"]

Function = TypeVar("Function", bound=Callable[..., object])

_folder = settle()
if _folder is not None:
    config.CACHE_DIR = str(_folder)  # type: ignore[attr-defined]  # Numba sets its options by name


def _load_numpy_support() -> None:
    """Have Numba load what kernels need of NumPy, without the linear algebra of SciPy, which they do not use.

    Numba only looks whether it is there, which takes 0.15 s. A kernel that does use it loads it when it is compiled.
    """
    name = "scipy.linalg.cython_blas"
    if name in sys.modules:
        return
    sys.modules[name] = ModuleType(name)
    try:
        import numba.np.arraymath  # noqa: F401  loads its kernels
    finally:
        del sys.modules[name]


_load_numpy_support()


@contextmanager
def _cached(function: Callable[..., object]) -> Iterator[bool]:
    """Have the machine code of a function kept in the folder of its source; whether there is one.

    Numba reads its option in the moment in which it decorates a function.
    """
    if _folder is None:
        yield False
        return
    config.CACHE_DIR = str(part_of(_folder, Path(function.__code__.co_filename)))  # type: ignore[attr-defined]  # by name
    try:
        yield True
    finally:
        config.CACHE_DIR = str(_folder)  # type: ignore[attr-defined]  # Numba sets its options by name


def kernel(function: Function) -> Function:
    """Compile a kernel.

    No ``fastmath``: the same input gives the same bits on every worker. ``error_model="numpy"`` lets a division by zero
    give inf or nan, which the finite-value guard of the objective then names. A function whose name begins with an
    underscore is called by kernels only, which makes it quicker to compile.
    """
    return _kernel(function, in_place=False)


def kernel_in_place(function: Function) -> Function:
    """Compile a kernel whose machine code is put in the place of each call of it.

    For what the innermost loops call and what is so long that the compiler would leave the call: 6 % of an oedometer
    test. The numbers are the same.
    """
    return _kernel(function, in_place=True)


def _kernel(function: Function, *, in_place: bool) -> Function:
    private = function.__name__.startswith("_")
    with _cached(function) as cache:
        options: Any = {"cache": cache, "nogil": True, "no_cfunc_wrapper": True, "no_cpython_wrapper": private}
        return cast(Function, numba.njit(error_model="numpy", forceinline=in_place, **options)(function))


def inlined(function: Function) -> Function:
    """Compile a function as a part of every kernel that calls it.

    For what one kernel calls: compiled by itself it would be translated once for itself and once more for each kernel
    above it. The numbers are the same.
    """
    options: Any = {"nogil": True, "no_cfunc_wrapper": True, "inline": "always"}
    return cast(Function, numba.njit(error_model="numpy", **options)(function))


def compiled(function: Callable[..., object], signature: Any) -> Any:
    """Compile a function that is called by its address, as :func:`kernel` does; with ``address``."""
    with _cached(function) as cache:
        return numba.cfunc(signature, cache=cache, error_model="numpy")(function)
