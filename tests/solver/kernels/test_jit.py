"""Kernels divide like NumPy, and are cached in a folder of ours."""

from __future__ import annotations

from numba.core import config

from geoswarm.solver.kernels.cache import settle
from geoswarm.solver.kernels.jit import kernel


def test_kernels_are_cached_in_the_folder_that_was_settled() -> None:
    assert config.CACHE_DIR
    assert str(settle()) == config.CACHE_DIR


def test_a_kernel_divides_like_numpy() -> None:
    @kernel
    def divide(a: float, b: float) -> float:
        return a / b

    assert divide(1.0, 0.0) == float("inf")
    assert divide(3.0, 2.0) == 1.5
