"""A sample of the parameters of a job, to run another forward model with.

Around each optimum the estimates scatter as a multivariate Student's t (normal where the error of the readings is
known) with the covariance of the linearised fit, in search coordinates (Seber and Wild 2003, section 2.1). What
lies outside the bounds or breaks a constraint is drawn again: the distribution is truncated. Along directions that the
data leave open, points are uniform between the bounds. The draws are a scrambled Sobol sequence (Owen 1998), whose
quantiles settle sooner than those of random numbers.

A basin b weighs as its part of the posterior by Laplace's approximation with the same curvature for all:
exp(-n (f_b - f_0) / (2 f_noise)) with known error, (f_b / f_0)^(-(n - d) / 2) with an estimated one (Box and Tiao 1973,
section 2.2: the likelihood integrated over the size of the noise).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri, ndtri

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability.errors import StatisticsError
from geoswarm.solver.identifiability.noise import Noise, noise_objective
from geoswarm.solver.identifiability.optimum.linearisation import Linearisation
from geoswarm.solver.identifiability.prediction.shapes import Shape, shape_of

__all__ = ["Basin", "ParameterSample", "basins_of", "draw_around", "take_from"]

Place = tuple[FloatArray, float]

_APART = 0.1  # parts of the range between two basins
_MOST_BASINS = 6
_LEAST_SHARE = 1e-3
_FEWEST = 20  # runs of a basin
_MOST_DRAWN = 2**17
_SWEEPS = 8  # through the open directions
_LARGEST_SEED = 2**32


@dataclass(frozen=True, slots=True)
class Basin:
    """One optimum, shape (d,), natural values, its objective, the scatter around it, and its share of all."""

    optimum: FloatArray
    objective: float
    shape: Shape
    share: float = 1.0


@dataclass(frozen=True, slots=True)
class ParameterSample:
    """Parameters to run through a forward model.

    Parameters
    ----------
    names
        Of the d parameters.
    optima, shares
        Of the basins, shape (b, d), natural values, and (b,).
    parameters, weights, basins
        Draws, shape (n, d), natural values; their weights, shape (n,), of sum 1; to which basin each belongs, (n,).
    noise_factors
        Of the error of a reading in each draw, shape (n,): an estimated error is uncertain itself.
    basis
        ``covariance`` or ``posterior``.
    undecided
        Parameters that the data do not limit: drawn over their searched range.
    """

    names: tuple[str, ...]
    optima: FloatArray
    shares: FloatArray
    parameters: FloatArray
    weights: FloatArray
    basins: IntArray
    noise_factors: FloatArray
    basis: str
    undecided: tuple[str, ...]


def basins_of(
    calibration: Calibration,
    linearisation: Linearisation,
    objective: float,
    others: Sequence[Place],
    exchanges: Sequence[tuple[str, str]],
    known: Noise | None,
) -> list[Basin]:
    """Return the optimum and the other sets of parameters that the data do not exclude, with their shares.

    Parameters
    ----------
    objective
        At the optimum of the linearisation.
    others
        Parameters, shape (d,), natural values, and objectives of good fits elsewhere.
    exchanges
        Pairs of parameters that can be exchanged.
    known
        The error of the readings, where it is stated.

    Raises
    ------
    StatisticsError
        When the error of a reading is not known.
    """
    names = calibration.free_names
    shape = shape_of(linearisation)
    found = [Basin(linearisation.optimum, objective, shape)]
    for first, second in exchanges:
        i, j = names.index(first), names.index(second)
        for basin in tuple(found):
            swapped = basin.optimum.copy()
            swapped[[i, j]] = basin.optimum[[j, i]]
            _add(calibration, found, Basin(swapped, basin.objective, basin.shape.exchanged(i, j)))
    for place, value in sorted(others, key=lambda other: other[1]):
        _add(calibration, found, Basin(place, value, shape))
    found = found[:_MOST_BASINS]
    values = np.array([basin.objective for basin in found])
    shares = np.exp(_log_weights(calibration, values, known))
    kept = [i for i in range(len(found)) if shares[i] >= _LEAST_SHARE * shares.sum()]
    total = shares[kept].sum()
    return [Basin(found[i].optimum, found[i].objective, found[i].shape, float(shares[i] / total)) for i in kept]


def _add(calibration: Calibration, found: list[Basin], basin: Basin) -> None:
    unit = calibration.space.to_unit(np.array([one.optimum for one in found]))
    apart = np.abs(unit - calibration.space.to_unit(basin.optimum)).max(axis=1)
    if float(apart.min()) > _APART and calibration.space.feasible(basin.optimum):
        found.append(basin)


def _log_weights(calibration: Calibration, values: FloatArray, known: Noise | None) -> FloatArray:
    points, lowest = calibration.problem.counted_points, float(values.min())
    if known is not None:
        weights = -0.5 * points * (values - lowest) / noise_objective(calibration.problem, known)
    else:
        free = max(points - calibration.space.dimension, 1)
        weights = -0.5 * free * np.log(np.maximum(values, 1e-300) / max(lowest, 1e-300))
    return np.asarray(weights - weights.max())


def draw_around(calibration: Calibration, basins: Sequence[Basin], runs: int, seed: int) -> ParameterSample:
    """Draw around the optima of all basins.

    Parameters
    ----------
    runs
        Draws in all; of several basins each has at least 20.
    seed
        Of the draws.

    Raises
    ------
    StatisticsError
        When hardly a draw lies between the bounds and satisfies the constraints.
    """
    shares = np.array([basin.share for basin in basins])
    least = min(_FEWEST, runs // len(basins))
    counts = np.maximum(np.floor(runs * shares).astype(int), least)
    counts[int(np.argmax(counts))] += runs - int(counts.sum())
    parts, factors = [], []
    for number, (basin, count) in enumerate(zip(basins, counts.tolist(), strict=True)):
        drawn, noise = _draw(calibration, basin, count, (seed + 7919 * number) % _LARGEST_SEED)
        parts.append(drawn)
        factors.append(noise)
    sizes = [len(part) for part in parts]
    undecided = basins[0].shape.undecided
    return ParameterSample(
        calibration.free_names,
        np.array([basin.optimum for basin in basins]),
        shares,
        np.concatenate(parts),
        np.concatenate([np.full(size, share / size) for size, share in zip(sizes, shares, strict=True)]),
        np.repeat(np.arange(len(basins)), sizes),
        np.concatenate(factors),
        "covariance",
        tuple(name for name, open_ in zip(calibration.free_names, undecided, strict=True) if open_),
    )


def _draw(calibration: Calibration, basin: Basin, count: int, seed: int) -> tuple[FloatArray, FloatArray]:
    """Draws, shape (count, d), natural values, and the factors of the noise, shape (count,)."""
    from scipy.stats import qmc  # slow to import, and few commands draw

    space, shape = calibration.space, basin.shape
    centre = space.to_unit(basin.optimum)
    rank, opened = shape.root.shape[1], shape.open.shape[1]
    sequence = qmc.Sobol(rank + 1 + opened * _SWEEPS if opened else rank + 1, rng=seed)
    kept: list[FloatArray] = []
    factors: list[float] = []
    drawn, size = 0, 1 << max(int(np.ceil(np.log2(max(count, 2)))), 6)
    while len(kept) < count and drawn < _MOST_DRAWN:
        uniform = np.clip(sequence.random(size), 1e-12, 1.0 - 1e-12)
        drawn += size
        freedom = shape.degrees_of_freedom
        noise = np.ones(size) if np.isinf(freedom) else np.sqrt(freedom / chdtri(freedom, uniform[:, rank]))
        unit = centre + (ndtri(uniform[:, :rank]) * noise[:, None]) @ shape.root.T
        if opened:
            unit = _along_open(unit, shape.open, uniform[:, rank + 1 :])
        inside = ((unit >= 0.0) & (unit <= 1.0)).all(axis=1)
        for i in np.flatnonzero(inside):
            natural = space.from_unit(unit[i])
            if space.feasible(natural):
                kept.append(natural)
                factors.append(float(noise[i]))
                if len(kept) == count:
                    break
        size = min(2 * size, 2**14)
    _check_draws(len(kept), drawn, count)
    return np.array(kept), np.array(factors)


def _check_draws(kept: int, drawn: int, wanted: int) -> None:
    if kept < max(min(_FEWEST, wanted) // 2, 1):
        raise StatisticsError(
            f"only {kept} of {drawn} draws around the optimum lie between the bounds and satisfy the constraints; "
            "widen the bounds, or relax the constraints"
        )


def _along_open(unit: FloatArray, directions: FloatArray, uniform: FloatArray) -> FloatArray:
    """Move points, shape (n, d), along open directions, so that they are uniform on what the bounds leave of these.

    One direction has the chord of its line through the box; several are gone through in turn (hit and run), each time
    along its chord. Points whose determined part alone lies outside are moved inside where a direction can.
    """
    moved = unit.copy()
    count = directions.shape[1]
    for step in range(uniform.shape[1]):
        direction = directions[:, step % count]
        low, high = _chord(moved, direction)
        position = low + uniform[:, step] * (high - low)
        moved = moved + np.where(high >= low, position, 0.0)[:, None] * direction
    return moved


def _chord(unit: FloatArray, direction: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Ends of the lines through points along a direction inside the box, shape (n,) each; empty: high below low.

    Coordinates that the direction does not move take no part.
    """
    moving = np.abs(direction) > 1e-9
    ends = np.stack([-unit[:, moving], 1.0 - unit[:, moving]]) / direction[moving]
    return ends.min(axis=0).max(axis=1), ends.max(axis=0).min(axis=1)


def take_from(
    calibration: Calibration,
    optimum: FloatArray,
    drawn: FloatArray,
    runs: int,
    undecided: tuple[str, ...],
    degrees_of_freedom: float,
    seed: int,
    widening: float = 1.0,
) -> ParameterSample:
    """Take draws from a posterior sample, shape (k, d), natural values: evenly over its chains.

    It takes the errors of readings as independent, so draws are moved away from the optimum as much as intervals are
    wider than the usual ones; those that leave the bounds or break a constraint are left out.

    Parameters
    ----------
    degrees_of_freedom
        Of the estimated error of a reading; infinite where it is known.
    seed
        Of the factors of that error.
    widening
        By how much intervals are wider than the usual ones.

    Raises
    ------
    StatisticsError
        When hardly a draw lies between the bounds and satisfies the constraints.
    """
    if widening > 1.0:
        space = calibration.space
        centre = space.to_unit(optimum)
        unit = centre + widening * (space.to_unit(drawn) - centre)
        natural = space.from_unit(unit[((unit >= 0.0) & (unit <= 1.0)).all(axis=1)])
        before, drawn = len(drawn), natural[[space.feasible(one) for one in natural]]
        _check_draws(len(drawn), before, runs)
    rows = np.unique(np.linspace(0, len(drawn) - 1, runs).round().astype(int))
    chosen = drawn[rows]
    count = len(chosen)
    factors = np.ones(count)
    if np.isfinite(degrees_of_freedom):
        even = (np.arange(count) + 0.5) / count
        factors = np.sqrt(degrees_of_freedom / chdtri(degrees_of_freedom, even))
        factors = np.random.default_rng(seed).permutation(factors)
    return ParameterSample(
        calibration.free_names,
        optimum[None],
        np.ones(1),
        chosen,
        np.full(count, 1.0 / count),
        np.zeros(count, dtype=np.int64),
        factors,
        "posterior",
        undecided,
    )
