"""Noise that is not independent and even: what correlated residuals, and residuals of uneven size, do to intervals.

Used where the residuals show it; otherwise noise is taken as independent and of the stated or estimated size.

- *Correlated*: autoregressive of first order within a series. rho is the one whose residuals, after the same fit, have
  the correlation of neighbours that was found on average: residuals themselves are less correlated than the noise.
  n readings are worth n (1 - rho) / (1 + rho) independent ones.
- *Uneven*: each residual stands for its own variance, r_i^2 / (1 - h_i)^2 with the leverage h_i (MacKinnon and White
  1985, HC3).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.linalg import matmul_toeplitz

from geoswarm.solver.arrays import FloatArray, IntArray

__all__ = ["Dependence", "dependence_of", "noise_root"]

_SIGNIFICANT = 2.58  # of the correlation of sizes with x, times the root of n - 1
_LARGEST = 0.95
_FEWEST = 8
_MOST = 400  # readings up to which the correlation is corrected for the fit


@dataclass(frozen=True, slots=True)
class Dependence:
    """How the noise of one series departs from independent and even noise.

    Parameters
    ----------
    series
        Its name.
    kind
        ``correlated`` or ``uneven``.
    rho
        Correlation of neighbouring readings; 0 for uneven ones.
    readings, effective
        Number, and how many independent ones they are worth.
    """

    series: str
    kind: Literal["correlated", "uneven"]
    rho: float
    readings: int
    effective: float

    @property
    def sentence(self) -> str:
        """What it means for intervals."""
        if self.kind == "correlated":
            return (
                f"{self.series}: neighbouring residuals are correlated ({self.rho:.2f}), so {self.readings} readings "
                f"are worth {self.effective:.0f} independent ones; intervals allow for that."
            )
        return (
            f"{self.series}: the size of the residuals changes with x; intervals allow for that, and weights from "
            "their spread would make better use of the readings (geoswarm reweight --weighting by_spread)."
        )


def dependence_of(series: str, scaled: FloatArray, basis: FloatArray, correlated: bool) -> Dependence | None:
    """Describe the noise of one series.

    Parameters
    ----------
    scaled
        Residuals in the order of x, scaled to one standard deviation, shape (m,).
    basis
        Rows of the orthonormal basis of the weighted derivatives for these readings, shape (m, r).
    correlated
        Whether a pattern was found in them.
    """
    count = len(scaled)
    if count < _FEWEST or not np.any(scaled):
        return None
    if correlated:
        rho = _rho(scaled, basis)
        if rho <= 0.0:
            return None
        return Dependence(series, "correlated", rho, count, max(count * (1.0 - rho) / (1.0 + rho), 1.0))
    ranks = np.argsort(np.argsort(np.abs(scaled), kind="stable"), kind="stable")
    strength = float(np.corrcoef(ranks, np.arange(count))[0, 1]) * np.sqrt(count - 1.0)
    return Dependence(series, "uneven", 0.0, count, float(count)) if abs(strength) > _SIGNIFICANT else None


def _rho(scaled: FloatArray, basis: FloatArray) -> float:
    found = float(scaled[1:] @ scaled[:-1] / (scaled @ scaled))
    if len(scaled) > _MOST:
        return float(np.clip(found, 0.0, _LARGEST))
    count = len(scaled)
    neighbours = np.abs(np.subtract.outer(np.arange(count), np.arange(count)))
    left = np.eye(count) - basis @ basis.T
    shifted = left @ (neighbours == 1) @ left / 2.0

    def expected(rho: float) -> float:
        noise = rho**neighbours
        return float(np.sum(shifted * noise) / np.sum((left @ left) * noise))

    low, high = 0.0, _LARGEST
    if found <= expected(low):
        return 0.0
    for _ in range(30):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if expected(middle) < found else (low, middle)
    return 0.5 * (low + high)


def noise_root(
    inverse: FloatArray,
    deviations: FloatArray,
    residuals: FloatArray,
    leverage: FloatArray,
    found: list[tuple[Dependence, IntArray]],
) -> FloatArray:
    """Covariance of the estimates, shape (d, d), under noise that is not independent and even in some series.

    Parameters
    ----------
    inverse
        What estimates take from weighted readings, shape (d, n).
    deviations
        Standard deviation of the weighted noise, shape (n,).
    residuals, leverage
        Weighted residuals and diagonal of the hat matrix, shape (n,).
    found
        Series that depart, with the places of their readings in the order of x.
    """
    scaled = inverse * deviations
    departing = np.zeros(len(deviations), dtype=np.bool_)
    full = np.zeros((len(inverse), len(inverse)))
    for dependence, places in found:
        departing[places] = True
        if dependence.kind == "uneven":
            own = inverse[:, places] * (residuals[places] / np.maximum(1.0 - leverage[places], 0.05))
            full += own @ own.T
            continue
        own = scaled[:, places]
        kernel = dependence.rho ** np.arange(len(places))
        # the spread of correlated residuals understates that of the noise by what the fit takes along
        inflation = len(places) / max(dependence.effective - 1.0, 1.0) if dependence.effective < 3.0 else 1.0
        full += inflation * own @ np.asarray(matmul_toeplitz((kernel, kernel), own.T))
    rest = scaled[:, ~departing]
    return np.asarray(full + rest @ rest.T)
