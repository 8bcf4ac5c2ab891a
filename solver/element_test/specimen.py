"""How specimens are loaded: rows of controls in 4 or 6 components, yy being vertical, and strains of laboratories."""

from __future__ import annotations

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.element_test.load_paths import LoadPath

__all__ = ["combination", "specimen_load_paths", "engineering_strain", "inner_strain", "same_strain"]

_NAMES = ("xx", "yy", "zz", "xy", "yz", "zx")


def combination(components: int, **coefficients: float) -> FloatArray:
    """A combination (n,) of components of stress or strain: ``combination(4, yy=1, xx=-0.5, zz=-0.5)``."""
    row = np.zeros(components)
    for name, value in coefficients.items():
        row[_NAMES.index(name)] = value
    return row


def specimen_load_paths(
    name: str,
    components: int,
    vertical: float,
    horizontal: float | None,
    duration: float,
    loading_time: float,
    depends_on_time: bool,
) -> tuple[LoadPath, ...]:
    """The load paths of a stage of loading: the load, and the time under it where that matters.

    Parameters
    ----------
    vertical, horizontal
        Effective stresses at the end, kPa; ``horizontal`` None: no horizontal strain.
    duration, loading_time
        Of the stage, and of the load at its beginning, day; 0: at once.
    """
    n = components
    stress_rows, strain_rows, goal = np.zeros((n, n)), np.zeros((n, n)), np.zeros(n)
    stress_rows[0], goal[0] = combination(n, yy=1.0), vertical
    strain_rows[1] = combination(n, xx=1.0, zz=-1.0)
    if horizontal is None:
        strain_rows[2] = combination(n, xx=1.0)
    else:
        stress_rows[2], goal[2] = combination(n, xx=0.5, zz=0.5), horizontal
    strain_rows[3:, 3:] = np.eye(n - 3)
    load = LoadPath(name, stress_rows, strain_rows, goal, loading_time)
    rest = duration - loading_time
    if not depends_on_time or rest <= 0.0:
        return (load,)
    return load, LoadPath(name, stress_rows, strain_rows, goal, rest, hold=True)


def inner_strain(strain: FloatArray) -> FloatArray:
    """Logarithmic strains of engineering ones, any shape, positive in compression; those of 1 and above: very large."""
    return -np.log1p(-np.minimum(strain, 1.0 - 1.0e-15))


def engineering_strain(strain: FloatArray) -> FloatArray:
    """Engineering strains of logarithmic ones, any shape, positive in compression."""
    return -np.expm1(-strain)


def same_strain(strain: FloatArray) -> FloatArray:
    """Small strains are the same inside."""
    return strain
