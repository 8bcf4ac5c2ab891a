"""Random numbers that depend on (seed, generation, particle) only.

The order in which particles are computed, the number of workers and any restart therefore change nothing.
"""

from __future__ import annotations

import sys
from contextlib import AbstractContextManager
from functools import cache

import numpy as np
from threadpoolctl import ThreadpoolController

__all__ = ["design_generator", "one_thread", "particle_generator", "proposer_generator"]

_DESIGN = 2**32 - 1  # a generation number that no search reaches: the stream of a whole sampling design


def particle_generator(seed: int, generation: int, particle: int) -> np.random.Generator:
    """Return the random stream of one particle in one generation."""
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed, spawn_key=(generation, particle))))


def design_generator(seed: int) -> np.random.Generator:
    """Return the random stream of a sampling design that is drawn as a whole."""
    return particle_generator(seed, _DESIGN, 0)


def proposer_generator(seed: int, generation: int) -> np.random.Generator:
    """Return the random stream for aiming particles of a generation."""
    return particle_generator(seed, generation, _DESIGN)


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
