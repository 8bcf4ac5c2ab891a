"""Filtering by a threshold of the objective, given by the engineer or proposed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.special import fdtri

from geoswarm.solver.identifiability.errors import StatisticsError
from geoswarm.solver.identifiability.samples import Samples
from geoswarm.solver.words import number

__all__ = ["Filtered", "Threshold", "filter_samples", "propose_threshold"]

_LEVEL = 0.95
_THIN = 2.0  # times the threshold that statistics would have, from which a raised one describes the sampling


@dataclass(frozen=True, slots=True)
class Threshold:
    """A limit of the objective: samples at or below it count as good fits.

    Parameters
    ----------
    value
        In the objective's unit.
    origin
        ``given`` by the engineer, or proposed from the ``statistics`` of the best fit, or relaxed to keep enough
        ``samples``.
    explanation
        One sentence: how it was found.
    wanted
        Where it was relaxed: the threshold that statistics would have.
    """

    value: float
    origin: Literal["given", "statistics", "samples"]
    explanation: str
    wanted: float | None = None


@dataclass(frozen=True, slots=True)
class Filtered:
    """What a filter leaves: ``kept`` of ``total`` samples, of which ``kept_unbiased`` are Monte Carlo samples."""

    samples: Samples
    threshold: Threshold
    total: int

    @property
    def kept(self) -> int:
        """Number of samples at or below the threshold."""
        return self.samples.size

    @property
    def kept_unbiased(self) -> int:
        """Monte Carlo samples among them."""
        return int(self.samples.unbiased.sum())

    @property
    def thin(self) -> str | None:
        """Why good fits describe how sparse the sampling is rather than the data; None where they do not.

        So where the threshold had to be raised to keep enough samples: then some of them fit worse than noise allows.
        """
        wanted = self.threshold.wanted
        if wanted is None or self.threshold.value <= _THIN * wanted:
            return None
        times = f", {self.threshold.value / wanted:.2g} times that" if wanted > 0.0 else ""  # 0: a perfect fit
        return (
            f"the sampling is too thin to judge: good fits lie below {wanted:.3g}, and to keep {self.kept} samples the "
            f"threshold was raised to {self.threshold.value:.3g}{times}"
        )

    @property
    def statement(self) -> str:
        """The filter in words, for captions."""
        return f"f ≤ {self.threshold.value:.3g}: {self.kept} of {self.total} evaluations"


def propose_threshold(samples: Samples, points: int, *, noise_objective: float | None = None) -> Threshold:
    """Propose a threshold from the best value, the noise and the number of samples.

    A fit is as good as the best one, on a level of 95 %, while

        f <= f_0 (1 + d / (n - d) F_0.95(d, n - d))

    for d parameters and n measured points, where f_0 is the larger of the best objective found and the objective that
    noise alone leaves (Beale 1960; Seber and Wild 2003, eq. 5.22, for independent errors of equal variance). A sampling
    seldom has enough points below it; then the threshold is raised until 20 times as many samples as there are
    parameters remain (at most a fifth of all).

    Parameters
    ----------
    samples
        At least one.
    points
        Number n of measured points.
    noise_objective
        f that the measurement noise alone leaves, when it is known.
    """
    dimension = samples.dimension
    best = float(samples.objectives[samples.best])
    base = best if noise_objective is None else max(best, noise_objective)
    words = "the best objective" if base == best else "the objective that noise alone leaves"
    lowest = f"{words}, {number(base, 3, plain=True)}"
    free = points - dimension
    factor = 1.0 + dimension / free * float(fdtri(dimension, free, _LEVEL)) if free > 0 else 2.0
    value = base * factor
    wanted = max(1, min(20 * dimension, samples.size // 5))
    if int((samples.objectives <= value).sum()) >= wanted:
        how = f"{factor:.3g} times {lowest}: such fits cannot be distinguished from the best one at 95 %"
        return Threshold(value, "statistics", how)
    relaxed = float(np.partition(samples.objectives, wanted - 1)[wanted - 1])
    kept = int((samples.objectives <= relaxed).sum())
    how = (
        f"raised from {number(value, 3, plain=True)} ({factor:.3g} times {lowest}), which too few samples meet, to "
        f"keep the best {kept}"
    )
    return Threshold(relaxed, "samples", how, value)


def filter_samples(samples: Samples, threshold: Threshold | float) -> Filtered:
    """Keep the samples at or below a threshold.

    Raises
    ------
    StatisticsError
        When the threshold is not a positive number.
    """
    if not isinstance(threshold, Threshold):
        if not (np.isfinite(threshold) and threshold > 0):
            raise StatisticsError(f"threshold is {threshold:g}; it must be a finite number above 0")
        threshold = Threshold(float(threshold), "given", "the threshold that you chose")
    return Filtered(samples.select(samples.objectives <= threshold.value), threshold, samples.size)
