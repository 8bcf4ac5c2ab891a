"""From the runs of a sample to the band of a prediction."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from scipy.special import ndtri

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.identifiability.errors import StatisticsError
from geoswarm.solver.identifiability.misfits import Closeness, in_words
from geoswarm.solver.identifiability.residuals.closeness import closeness_of
from geoswarm.solver.identifiability.residuals.readings import MeasuredResiduals
from geoswarm.solver.methods.predict import PredictMethod
from geoswarm.solver.problem import Observation, Problem
from geoswarm.solver.problem.weighting import test_of
from geoswarm.solver.units import convert
from geoswarm.solver.words import listed, per_cent

__all__ = ["BasinOutcome", "Prediction", "PredictedSeries", "prediction_of", "weighted_quantiles"]

_STRATA = 25  # of the error of a reading, in each draw
_FEWEST = 10  # successful draws
_LOOSE = 0.1  # error of an end in parts of the band's width, from which more runs are advised
_MOST_NAMED = 3  # series in a remark
_BENT = 0.95  # share of the variation that a plane explains


@dataclass(frozen=True, slots=True)
class BasinOutcome:
    """One basin: its share, its optimum by name, and its draws of which a test succeeded."""

    share: float
    parameters: dict[str, float]
    draws: int


@dataclass(frozen=True, slots=True)
class PredictedSeries:
    """The band of one series, in the units that the problem gives its points in.

    Parameters
    ----------
    series, x_quantity, y_quantity, x_unit, y_unit
        What it is.
    x, median, lower, upper
        Shape (m,), in the order of x.
    reading_lower, reading_upper
        The same of a future reading, which has an error of its own; None where that is not known.
    optima
        Curve at the optimum of each basin, shape (b, m); nan where its run failed.
    basin_lower, basin_upper
        Band of each basin alone, shape (b, m).
    measured
        Measured y, shape (m,); None where nothing was measured.
    straight
        Share of the variation of the draws that a plane over the parameters explains, the least over x: 1 where the
        model is linear in them.
    end_error
        How far the ends of the band differ between two halves of the draws, in parts of its width, the median over x.
    closeness
        How close the curve at the best optimum comes to the measured points; None without them, or if its run failed.
    """

    series: str
    x_quantity: str
    y_quantity: str
    x_unit: str
    y_unit: str
    x: FloatArray
    median: FloatArray
    lower: FloatArray
    upper: FloatArray
    reading_lower: FloatArray | None
    reading_upper: FloatArray | None
    optima: FloatArray
    basin_lower: FloatArray
    basin_upper: FloatArray
    measured: FloatArray | None
    straight: float
    end_error: float
    closeness: Closeness | None

    @property
    def inside(self) -> int | None:
        """How many measured points lie in the band: of a reading where it is known, else of the parameters."""
        if self.measured is None:
            return None
        known = self.reading_lower is not None and self.reading_upper is not None
        low, high = (self.reading_lower, self.reading_upper) if known else (self.lower, self.upper)
        assert low is not None
        assert high is not None
        return int(((self.measured >= low) & (self.measured <= high)).sum())

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values; None for nan."""
        arrays = ("x", "median", "lower", "upper", "reading_lower", "reading_upper", "measured")
        return {
            **{name: getattr(self, name) for name in ("series", "x_quantity", "y_quantity", "x_unit", "y_unit")},
            **{name: None if (values := getattr(self, name)) is None else values.tolist() for name in arrays},
            "basins": [
                {"optimum": _numbers(curve), "lower": _numbers(low), "upper": _numbers(high)}
                for curve, low, high in zip(self.optima, self.basin_lower, self.basin_upper, strict=True)
            ],
            "inside": self.inside,
            "straight": _number(self.straight),
            "end_error": _number(self.end_error),
            "closeness": None if self.closeness is None else asdict(self.closeness),
        }


@dataclass(frozen=True, slots=True)
class Prediction:
    """What the uncertainty of identified parameters makes of a forward model.

    Parameters
    ----------
    name
        Of the problem that is predicted.
    level
        Of the band at each x.
    basis
        ``covariance`` or ``posterior``: where the draws come from.
    runs, failed
        Draws that were run, and those of them that failed; where one test did, the bands of the others keep the draw.
    basins
        One or more, the best first.
    undecided
        Parameters drawn over their searched range.
    series
        One band each.
    alarm
        Why the band is unreliable; None if nothing is wrong.
    remarks
        What it contains, and what to be careful about, in sentences.
    problem, responses
        What was predicted, and the series at the best optimum, shape (m_g,), base units; without those that failed.
    """

    name: str
    level: float
    basis: str
    runs: int
    failed: int
    basins: tuple[BasinOutcome, ...]
    undecided: tuple[str, ...]
    series: tuple[PredictedSeries, ...]
    alarm: str | None
    remarks: tuple[str, ...]
    problem: Problem
    responses: Mapping[str, FloatArray]

    def __getitem__(self, series: str) -> PredictedSeries:
        """The band of a series; KeyError lists those that there are."""
        for one in self.series:
            if one.series == series:
                return one
        raise KeyError(f"no series {series!r}; predicted: {', '.join(one.series for one in self.series)}")

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "name": self.name,
            "level": self.level,
            "basis": self.basis,
            "runs": self.runs,
            "failed": self.failed,
            "basins": [{"share": b.share, "parameters": b.parameters, "draws": b.draws} for b in self.basins],
            "undecided": list(self.undecided),
            "series": [one.to_json() for one in self.series],
            "alarm": self.alarm,
            "remarks": list(self.remarks),
        }


def weighted_quantiles(values: FloatArray, weights: FloatArray, levels: Sequence[float]) -> FloatArray:
    """Return quantiles over the first axis, shape (q, m), of values, shape (n, m), with weights, shape (n,).

    The k-th of n equal draws stands at k / (n + 1) (Weibull), so that an interval holds on average the share of further
    draws that its level says.
    """
    order = np.argsort(values, axis=0, kind="stable")
    ordered = np.take_along_axis(values, order, axis=0)
    effective = float(weights.sum() ** 2 / (weights**2).sum())
    places = np.cumsum(weights[order], axis=0) / float(weights.sum()) * effective / (effective + 1.0)
    return np.array(
        [
            [np.interp(level, places[:, column], ordered[:, column]) for column in range(values.shape[1])]
            for level in levels
        ]
    )


def prediction_of(calibration: Calibration, method: PredictMethod, evaluations: Sequence[Evaluation]) -> Prediction:
    """Read the evaluations of a prediction that are there, in their order.

    Raises
    ------
    StatisticsError
        When fewer than ten draws of every test have succeeded.
    """
    problem = calibration.problem
    count = len(method.shares)
    optima, draws = evaluations[:count], evaluations[count:]
    gave = [i for i, run in enumerate(draws) if run.responses]
    failed = [run for run in draws if run.reason is not None]
    such = "; ".join({run.reason: f"{run.reason}: {run.message}" for run in failed}.values())
    rows = {o.series: [i for i in gave if o.series in draws[i].responses] for o in problem.observations}
    most = max(map(len, rows.values()), default=0)
    if most < _FEWEST:
        why = f": {such}" if such else ""
        raise StatisticsError(f"{most} of {len(draws)} draws have succeeded; a band needs {_FEWEST}{why}")
    points = method.positions(problem.free_names)
    unit = calibration.space.to_unit(points[count:][: len(draws)])
    names = problem.free_names
    measured = _measured(calibration, method, optima[0])
    series = tuple(
        _series(problem, method, o, optima, draws, rows[o.series], unit, measured.get(o.series))
        for o in problem.observations
        if len(rows[o.series]) >= _FEWEST
    )
    remarks = list(method.remarks)
    if measured:
        found = closeness_of(problem, list(measured), list(measured.values()))
        remarks.insert(0, f"with the values of the best fit, {in_words(found)}")
    remarks += _failures(problem, rows, len(draws), len(failed), such)
    loose = [one.series for one in series if one.end_error > _LOOSE]
    if loose:
        worst = max(one.end_error for one in series)
        remarks.append(
            f"the ends of the band of {_named(loose)} are known to {per_cent(worst)} of its width only, by two "
            "halves of the runs; more runs sharpen them"
        )
    curved = [one.series for one in series if one.straight < _BENT]
    if curved:
        remarks.append(
            f"not linear in the parameters over their uncertainty: {_named(curved)}; the band is that of real "
            "runs, so it holds all the same, but the median need not be the curve at the optimum"
        )
    return Prediction(
        problem.name,
        method.level,
        method.basis,
        len(draws),
        len(failed),
        tuple(
            BasinOutcome(
                share,
                dict(zip(names, points[number].tolist(), strict=True)),
                sum(method.basins[i] == number for i in gave),
            )
            for number, share in enumerate(method.shares)
        ),
        tuple(method.undecided),
        series,
        method.alarm,
        tuple(f"{remark[:1].upper()}{remark[1:]}{'' if remark.endswith('.') else '.'}" for remark in remarks),
        problem,
        dict(optima[0].responses),
    )


def _failures(problem: Problem, rows: Mapping[str, Sequence[int]], runs: int, failed: int, such: str) -> list[str]:
    """How many runs the bands leave out, by test where these differ, and which series have none."""
    if not failed:
        return []
    lost = {test_of(problem.forward_model, series): runs - len(own) for series, own in rows.items()}
    left = "the band leaves them out"
    if len(set(lost.values())) > 1:
        left = f"left out are {listed([f'{number} runs of {test}' for test, number in lost.items() if number])}"
    told = f"{failed} of {runs} runs failed, such as {such}; {left}"
    without = [series for series, own in rows.items() if len(own) < _FEWEST]
    return [told, f"{listed(without)}: no band, which needs {_FEWEST} successful runs"] if without else [told]


def _named(series: Sequence[str]) -> str:
    more = len(series) - _MOST_NAMED
    return ", ".join(series) if more <= 1 else f"{', '.join(series[:_MOST_NAMED])} and {more} others"


def _measured(calibration: Calibration, method: PredictMethod, best: Evaluation) -> dict[str, MeasuredResiduals]:
    """Residuals of the best optimum by series, of those that were measured."""
    observed = [
        o for o in calibration.objective.observed if o.series not in method.unmeasured and o.series in best.responses
    ]
    return {o.series: MeasuredResiduals.of(calibration.problem, o, best.responses[o.series]) for o in observed}


def _series(
    problem: Problem,
    method: PredictMethod,
    observation: Observation,
    optima: Sequence[Evaluation],
    draws: Sequence[Evaluation],
    rows: list[int],
    unit: FloatArray,
    residuals: MeasuredResiduals | None,
) -> PredictedSeries:
    info = next(info for info in problem.model.series if info.name == observation.series)
    x_unit, y_unit = observation.x_unit or info.x_unit, observation.y_unit or info.y_unit
    order = np.argsort(observation.x, kind="stable")

    def to_y(values: FloatArray) -> FloatArray:
        return convert(values, info.y_unit, y_unit)

    name, unit = observation.series, unit[rows]
    weights, basins = np.array(method.weights)[rows], np.array(method.basins)[rows]
    values = np.array([draws[row].responses[name][order] for row in rows])
    tail = (1.0 - method.level) / 2.0
    levels = (0.5, tail, 1.0 - tail)
    median, lower, upper = weighted_quantiles(values, weights, levels)
    reading = None
    deviation = method.readings.get(name)
    if deviation is not None:
        factors = deviation * np.array(method.noise_factors)[rows]
        # each draw with errors in strata of equal probability
        errors = ndtri((np.arange(_STRATA) + 0.5) / _STRATA)
        spread = (values[:, None, :] + (factors[:, None] * errors)[:, :, None]).reshape(-1, values.shape[1])
        reading = weighted_quantiles(spread, np.repeat(weights, _STRATA), levels[1:])
    curves = np.array(
        [run.responses[name][order] if name in run.responses else np.full(len(order), np.nan) for run in optima]
    )
    alone = [
        weighted_quantiles(values[basins == b], weights[basins == b], levels[1:])
        if (basins == b).sum() >= _FEWEST
        else np.full((2, len(order)), np.nan)
        for b in range(len(method.shares))
    ]
    measured = None if name in method.unmeasured else to_y(observation.y[order])
    return PredictedSeries(
        name,
        info.x_quantity,
        info.y_quantity,
        x_unit,
        y_unit,
        convert(observation.x[order], info.x_unit, x_unit),
        to_y(median),
        to_y(lower),
        to_y(upper),
        None if reading is None else to_y(reading[0]),
        None if reading is None else to_y(reading[1]),
        to_y(curves),
        to_y(np.array([ends[0] for ends in alone])),
        to_y(np.array([ends[1] for ends in alone])),
        measured,
        _straight(unit, values, weights),
        _end_error(values, weights, levels[1:], upper - lower),
        None if residuals is None else closeness_of(problem, [name], [residuals])[0],
    )


def _straight(unit: FloatArray, values: FloatArray, weights: FloatArray) -> float:
    """The least share of the variation of a column that a plane explains, of columns that vary visibly."""
    root = np.sqrt(weights)[:, None]
    centred = values - weights @ values / weights.sum()
    planes = np.column_stack([np.ones(len(unit)), unit])
    if len(unit) < 2 * planes.shape[1]:
        return float("nan")
    found = np.linalg.lstsq(planes * root, centred * root, rcond=None)[0]
    total = np.sum((centred * root) ** 2, axis=0)
    left = np.sum(((centred - planes @ found) * root) ** 2, axis=0)
    seen = total > 1e-6 * float(total.max(initial=0.0))
    return float(np.min(1.0 - left[seen] / total[seen])) if seen.any() else 1.0


def _end_error(values: FloatArray, weights: FloatArray, levels: Sequence[float], width: FloatArray) -> float:
    """Half the difference of the ends between two halves of the draws, parts of the width, median over x.

    The halves are random: every other point of a Sobol sequence lies on one side of the first axis.
    """
    rows = np.random.default_rng(0).permutation(len(values))
    halves = [weighted_quantiles(values[half], weights[half], levels) for half in (rows[::2], rows[1::2])]
    gap = np.abs(halves[0] - halves[1]).max(axis=0) / 2.0
    seen = width > 1e-9 * float(np.abs(values).max(initial=0.0))
    return float(np.median(gap[seen] / width[seen])) if seen.any() else 0.0


def _numbers(values: FloatArray) -> list[float] | None:
    return values.tolist() if bool(np.isfinite(values).all()) else None


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
