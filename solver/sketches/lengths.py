"""Lengths as they are usual: of specimens in mm, of ground in m, thin layers in cm."""

from __future__ import annotations

__all__ = ["ground_length", "specimen_length"]


def specimen_length(metres: float) -> str:
    """A length of a specimen, which is given in mm below 1 m.

    >>> specimen_length(0.02021)
    '20.21 mm'
    """
    return f"{metres:g} m" if metres >= 1.0 else f"{_rounded(1e3 * metres)} mm"


def ground_length(metres: float) -> str:
    """A depth, distance or thickness in the ground, which is given in cm below 0.1 m.

    >>> ground_length(1.5)
    '1.5 m'
    """
    return f"{metres:g} m" if metres == 0.0 or metres >= 0.1 else f"{_rounded(1e2 * metres)} cm"


def _rounded(value: float) -> str:
    return f"{float(f'{value:.12g}'):g}"  # 1000 times 0.07 is 70.00000000000001
