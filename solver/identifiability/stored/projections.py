"""Objective function projections: the objective over one parameter, its lower envelope, and what it tells.

A parameter is well determined when its projection has one firm extreme value (Meier et al. 2008, section on the
statistical analysis). The evidence is taken from the good fits, at their place in the *prior*: the share of Monte Carlo
samples with a smaller value. There the samples of a parameter without influence are uniform whatever the constraints
cut away, so a gap between them, or between them and a bound, can be judged by its probability.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.identifiability.samples import Samples

__all__ = ["Projection", "project"]

_SIGNIFICANCE = 0.01
_FEWEST = 5
_SWARM_CONTACT = 0.01  # of the range; a swarm's density says nothing about gaps


@dataclass(frozen=True, slots=True)
class Projection:
    """The objective over one parameter.

    Parameters
    ----------
    parameter, scale
        Name, and ``linear`` or ``log``.
    edges
        Borders of the bins, shape (b + 1,), natural values, even in search coordinates.
    envelope
        Lowest objective in each bin, shape (b,), nan where it is empty.
    counts
        Samples in each bin, shape (b,).
    best
        Value of the parameter at the optimum where it is known, at the best sample otherwise.
    lowest, highest
        Least and largest value among the good fits; None without any.
    lower, upper
        5 % and 95 % quantile among the good fits; None without any.
    width_ratio
        Posterior over prior width: extent of the good fits over that of all samples (of the bounds for a swarm) in
        search coordinates, the former enlarged by (k + 1) / (k - 1), as k samples do not reach the ends of what they
        come from; at most 1. None without good fits.
    unimodal
        Whether the good fits form one group: no gap between neighbours that has a probability below 1 %. None when it
        cannot be told (fewer than five good fits, or a swarm's).
    open_below, open_above
        Bound contact: nothing speaks against good fits down to the lower, up to the upper bound (a gap to the bound as
        large as the one found has at least 1 % probability). None without any good fits.
    beyond_below, beyond_above
        Samples (good or not) outside the good fits on either side: the search did look there.
    kept
        Number of good fits the evidence rests on.
    """

    parameter: str
    scale: str
    edges: FloatArray
    envelope: FloatArray
    counts: IntArray
    best: float
    lowest: float | None
    highest: float | None
    lower: float | None
    upper: float | None
    width_ratio: float | None
    unimodal: bool | None
    open_below: bool | None
    open_above: bool | None
    beyond_below: int
    beyond_above: int
    kept: int


def project(samples: Samples, threshold: float, *, bins: int = 30) -> tuple[Projection, ...]:
    """Project the objective on every parameter.

    Parameters
    ----------
    samples
        All samples, not only the filtered ones. Where a sampling and a swarm are put together, widths and gaps come
        from the Monte Carlo samples alone, the envelope from all.
    threshold
        Samples with f at or below it are good fits.
    bins
        Number b of bins of the envelope.
    """
    return tuple(_project(samples, index, threshold, bins) for index in range(samples.dimension))


def _project(samples: Samples, index: int, threshold: float, bins: int) -> Projection:
    unit = np.clip(samples.unit[:, index], 0.0, 1.0)
    natural = samples.parameters[:, index]
    bin_of = np.minimum((unit * bins).astype(np.int64), bins - 1)
    envelope = np.full(bins, np.inf)
    np.minimum.at(envelope, bin_of, samples.objectives)
    edges = _natural_edges(samples, index, bins)

    fair = samples.unbiased if samples.unbiased.any() else np.ones(samples.size, dtype=np.bool_)
    swarm = not samples.unbiased.any()
    good = samples.objectives <= threshold
    evidence = good & fair
    kept = int(evidence.sum())
    lowest = highest = lower = upper = width_ratio = None
    unimodal = open_below = open_above = None
    below = above = 0
    if kept:
        chosen = natural[evidence]
        lowest, highest = float(chosen.min()), float(chosen.max())
        lower, upper = (float(q) for q in np.quantile(chosen, [0.05, 0.95]))
        prior = 1.0 if swarm else max(float(np.ptp(unit[fair])), 1e-300)
        width_ratio = float(min(np.ptp(unit[evidence]) / prior * (kept + 1) / (kept - 1), 1.0)) if kept > 1 else 1.0
        below, above = int((natural < lowest).sum()), int((natural > highest).sum())
        if swarm:
            open_below = bool(unit[evidence].min() <= _SWARM_CONTACT)
            open_above = bool(unit[evidence].max() >= 1.0 - _SWARM_CONTACT)
        else:
            place = np.sort(_place(unit[evidence], np.sort(unit[fair])))
            open_below = _probable(place[0], kept)
            open_above = _probable(1.0 - place[-1], kept)
            unimodal = _one_group(place) if kept >= _FEWEST else None
    return Projection(
        parameter=samples.names[index],
        scale=samples.scales[index],
        edges=edges,
        envelope=np.where(np.isfinite(envelope), envelope, np.nan),
        counts=np.bincount(bin_of, minlength=bins),
        best=float(natural[samples.best]),
        lowest=lowest,
        highest=highest,
        lower=lower,
        upper=upper,
        width_ratio=width_ratio,
        unimodal=unimodal,
        open_below=open_below,
        open_above=open_above,
        beyond_below=below,
        beyond_above=above,
        kept=kept,
    )


def _natural_edges(samples: Samples, index: int, bins: int) -> FloatArray:
    lower, upper = samples.lower[index], samples.upper[index]
    edges = np.geomspace(lower, upper, bins + 1) if samples.log[index] else np.linspace(lower, upper, bins + 1)
    return np.asarray(edges, dtype=np.float64)


def _place(values: FloatArray, prior: FloatArray) -> FloatArray:
    """Share of the prior below each value, 0 to 1."""
    return np.asarray(np.searchsorted(prior, values, side="left") / max(len(prior) - 1, 1))


def _probable(gap: float, count: int) -> bool:
    """Whether ``count`` uniform values leave a gap as large as this to an end with at least 1 % probability."""
    return bool((1.0 - gap) ** count >= _SIGNIFICANCE)


def _one_group(place: FloatArray) -> bool:
    """Whether the largest gap between neighbours is usual for uniform values between the outermost ones.

    The probability of a largest spacing above g of k intervals is at most k (1 - g)^(k - 1) (David and Nagaraja 2003).
    """
    span = place[-1] - place[0]
    if span <= 0:
        return True
    spacings = np.diff(place) / span
    count = len(spacings)
    return bool(count * (1.0 - spacings.max()) ** (count - 1) >= _SIGNIFICANCE)
