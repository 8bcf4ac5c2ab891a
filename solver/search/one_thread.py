"""One thread for linear algebra: the order of summation in BLAS, and so the last bits, may depend on their number."""

from __future__ import annotations

import sys
from contextlib import AbstractContextManager
from functools import cache

from threadpoolctl import ThreadpoolController

__all__ = ["one_thread"]


def one_thread() -> AbstractContextManager[object]:
    """Keep the linear algebra of NumPy, and of SciPy once it is imported, to one thread while the body runs."""
    limited: AbstractContextManager[object] = _threadpools("scipy.linalg" in sys.modules).limit(
        limits=1, user_api="blas"
    )
    return limited


@cache
def _threadpools(with_scipy: bool) -> ThreadpoolController:
    """Look through all libraries that are loaded, which takes some milliseconds; SciPy brings a BLAS of its own."""
    del with_scipy
    return ThreadpoolController()
