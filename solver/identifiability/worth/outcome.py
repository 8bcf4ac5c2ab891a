"""Expected reductions of intervals by candidate readings, from their sensitivities.

With C the covariance that the data of the job leave, J the sensitivities of the candidate's readings and S the diagonal
of their variances, the covariance afterwards is (C^-1 + J' S^-1 J)^-1 (Chaloner and Verdinelli 1995, section 2), in
search coordinates. Averaged over the optima of all basins and draws around them, as logarithms:

- widths: the mean log width of the intervals, their geometric mean (A-optimality, in logarithms)
- volume: log det C / 2 a parameter, that of the common region (D-optimality)
- prediction: the mean log width of the band over the points that are predicted
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import ndtr

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.identifiability.errors import StatisticsError
from geoswarm.solver.methods.design import DesignCandidate, DesignMethod, DesignPoint
from geoswarm.solver.words import listed

__all__ = ["CandidateWorth", "Design", "design_of"]


@dataclass(frozen=True, slots=True)
class CandidateWorth:
    """Worth of a candidate.

    Parameters
    ----------
    name, cost, readings
        The candidate, and the number of its readings.
    parameters
        Expected reduction of the width of each interval, parts of it, 0 to 1.
    intervals
        Expected 95 % interval of each parameter around the best optimum, natural values; None beyond the bounds.
    widths, volume, prediction
        Expected reduction of the geometric mean of all intervals, of the common region (its d-th root), and of the band
        that is predicted; None where nothing is.
    distinguishes
        Probability that it distinguishes the two basins that are closest; None with one basin.
    per_cost
        Decrease of log width by the criterion for each unit of cost; None without costs.
    """

    name: str
    cost: float | None
    readings: int
    parameters: dict[str, float]
    intervals: dict[str, tuple[float, float] | None]
    widths: float
    volume: float
    prediction: float | None
    distinguishes: float | None
    per_cost: float | None

    def by(self, criterion: str) -> float:
        """The reduction by a criterion."""
        value = {"widths": self.widths, "volume": self.volume, "prediction": self.prediction}[criterion]
        return 0.0 if value is None else value


@dataclass(frozen=True, slots=True)
class Design:
    """Candidates in order of their worth.

    Parameters
    ----------
    criterion
        What they are put in order by: widths, volume or prediction.
    predicted
        Name of what is predicted; None: nothing.
    candidates
        The best first.
    basins, centres, failed
        Sets of parameters that the data allow, places over which the worth is averaged (at most; a candidate may fail
        at some), and runs of which a candidate failed.
    alarm, remarks
        Why nothing of it can be relied on, and what to be careful about.
    """

    name: str
    criterion: str
    predicted: str | None
    candidates: tuple[CandidateWorth, ...]
    basins: int
    centres: int
    failed: int
    alarm: str | None
    remarks: tuple[str, ...]

    @property
    def best(self) -> CandidateWorth:
        """The one to take first."""
        return self.candidates[0]

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        return {
            "name": self.name,
            "criterion": self.criterion,
            "predicted": self.predicted,
            "candidates": [
                {
                    "name": c.name,
                    "cost": c.cost,
                    "readings": c.readings,
                    "parameters": c.parameters,
                    "intervals": {k: None if v is None else list(v) for k, v in c.intervals.items()},
                    "widths": c.widths,
                    "volume": c.volume,
                    "prediction": c.prediction,
                    "distinguishes": c.distinguishes,
                    "per_cost": c.per_cost,
                }
                for c in self.candidates
            ],
            "basins": self.basins,
            "centres": self.centres,
            "failed": self.failed,
            "alarm": self.alarm,
            "remarks": list(self.remarks),
        }


@dataclass(frozen=True, slots=True)
class _Centre:
    weight: float
    basin: int
    values: dict[str, FloatArray]
    slopes: dict[str, FloatArray]  # (m, d), per range; of the series with sensitivities to every parameter

    def has(self, candidate: DesignCandidate) -> bool:
        """Whether the sensitivities of all its readings are there."""
        return all(readings.series in self.slopes for readings in candidate.readings)


def design_of(calibration: Calibration, method: DesignMethod, evaluations: Sequence[Evaluation]) -> Design:
    """Read the evaluations of a design, all of them.

    Raises
    ------
    StatisticsError
        When some are missing, or no candidate has sensitivities at a single centre.
    """
    if len(evaluations) < len(method.plan):
        raise StatisticsError(f"{len(evaluations)} of {len(method.plan)} evaluations are done")
    names = tuple(method.identified)
    wanted = method.prediction
    centres = [c for c in _centres(method, evaluations, names) if wanted is None or c.has(wanted)]
    failed = [run for run in evaluations if run.reason is not None]
    such = "; ".join({run.reason: f"{run.reason}: {run.message}" for run in failed}.values())
    usable = {candidate.name: [c for c in centres if c.has(candidate)] for candidate in method.candidates}
    most = max(map(len, usable.values()))
    if most == 0:
        of = "" if centres or wanted is None else f" of {wanted.name}"
        raise StatisticsError(f"no sensitivities{of} could be calculated, because runs failed: {such}")
    before = [np.array(covariance) for covariance in method.covariances]
    optimum = np.array([parameter.value for parameter in method.identified.values()])
    found = []
    for candidate in method.candidates:
        own = usable[candidate.name]
        if not own:
            continue
        total = sum(centre.weight for centre in own)
        logs, volume, bands = np.zeros(len(names)), 0.0, 0.0
        for centre in own:
            share, c0 = centre.weight / total, before[centre.basin]
            c1 = _afterwards(c0, *_rows(candidate, centre))
            logs += share * 0.5 * np.log(np.diag(c1) / np.diag(c0))
            volume += share * 0.5 * float(np.linalg.slogdet(c1)[1] - np.linalg.slogdet(c0)[1]) / len(names)
            if wanted is not None:
                bands += share * _narrower(_rows(wanted, centre)[0], c0, c1)
        predicted = None if wanted is None else 1.0 - float(np.exp(bands))
        gain = {"widths": -float(logs.mean()), "volume": -volume, "prediction": -bands}[method.criterion]
        found.append(
            CandidateWorth(
                candidate.name,
                candidate.cost,
                sum(len(readings.at) for readings in candidate.readings),
                dict(zip(names, (1.0 - np.exp(logs)).tolist(), strict=True)),
                _intervals(method, optimum, np.sqrt(np.diag(before[0])) * np.exp(logs)),
                1.0 - float(np.exp(logs.mean())),
                1.0 - float(np.exp(volume)),
                predicted,
                _distinguishes(candidate, own),
                None if candidate.cost is None else gain / candidate.cost,
            )
        )
    order = sorted(range(len(found)), key=lambda i: (-found[i].by(method.criterion), i))
    remarks = [*method.remarks, *_failures(method, evaluations, usable, such)]
    return Design(
        calibration.problem.name,
        method.criterion,
        None if wanted is None else wanted.name,
        tuple(found[i] for i in order),
        len(method.covariances),
        most,
        len(failed),
        method.alarm,
        tuple(f"{remark[:1].upper()}{remark[1:]}{'' if remark.endswith('.') else '.'}" for remark in remarks),
    )


def _failures(
    method: DesignMethod, evaluations: Sequence[Evaluation], usable: Mapping[str, Sequence[_Centre]], such: str
) -> list[str]:
    """Which candidates lack runs, and at how many places their worth is known."""
    if not such:
        return []
    tests = [*method.candidates, *(() if method.prediction is None else (method.prediction,))]
    lost = {
        test.name: sum(any(r.series not in run.responses for r in test.readings) for run in evaluations)
        for test in tests
    }
    counts = listed([f"{number} of {name}" for name, number in lost.items() if number])
    found = [f"of {len(evaluations)} runs, {counts} failed, such as {such}"]
    places = len(method.basins)
    found += [
        f"of {places} places around the optimum, {name} has its worth from {len(own)}"
        for name, own in usable.items()
        if 0 < len(own) < places
    ]
    return found + [f"{name} has no worth, because its runs failed" for name, own in usable.items() if not own]


def _centres(method: DesignMethod, evaluations: Sequence[Evaluation], names: tuple[str, ...]) -> list[_Centre]:
    """The centres, each with the series of which the sensitivity to every parameter could be had."""
    found = []
    for number, (basin, weight) in enumerate(zip(method.basins, method.weights, strict=True)):
        own = [(point, run) for point, run in zip(method.plan, evaluations, strict=False) if point.centre == number]
        middle = next(run for point, run in own if point.parameter is None)
        slopes = {
            series: slope
            for series, values in middle.responses.items()
            if (slope := _slopes(series, values, own, method, names)) is not None
        }
        found.append(_Centre(weight, basin, dict(middle.responses), slopes))
    return found


def _slopes(
    series: str,
    values: FloatArray,
    own: Sequence[tuple[DesignPoint, Evaluation]],
    method: DesignMethod,
    names: tuple[str, ...],
) -> FloatArray | None:
    """Sensitivities of a series around a centre with these values, shape (m, d); None where a parameter has none."""
    slopes = np.zeros((len(values), len(names)))
    for index, name in enumerate(names):
        if name not in method.points:
            continue
        beside = [(p.offset, run) for p, run in own if p.parameter == name and series in run.responses]
        if not beside:
            return None
        rows = np.array([run.responses[series] - values for _, run in beside])
        slopes[:, index] = _slope(np.array([offset for offset, _ in beside]), rows)
    return slopes


def _slope(offsets: FloatArray, rows: FloatArray) -> FloatArray:
    """Derivative at 0 of differences from there, shape (k, m), at k offsets: of the line or parabola through them."""
    if len(offsets) == 1:
        return np.asarray(rows[0] / offsets[0])
    first, second = offsets
    return np.asarray((rows[0] * second / first - rows[1] * first / second) / (second - first))


def _rows(candidate: DesignCandidate, centre: _Centre) -> tuple[FloatArray, FloatArray]:
    """Sensitivities of the readings of a candidate, shape (m, d), and their deviations, shape (m,)."""
    slopes = [centre.slopes[readings.series][readings.at] for readings in candidate.readings]
    errors = [np.full(len(readings.at), readings.error or np.inf) for readings in candidate.readings]
    return np.concatenate(slopes), np.concatenate(errors)


def _afterwards(covariance: FloatArray, slopes: FloatArray, errors: FloatArray) -> FloatArray:
    """The covariance with further readings; in the form that inverts what is as large as the number of parameters."""
    scaled = slopes / errors[:, None]
    root = np.linalg.cholesky(covariance)
    inner = np.eye(len(covariance)) + root.T @ (scaled.T @ scaled) @ root
    return np.asarray(root @ np.linalg.solve(inner, root.T))


def _narrower(wanted: FloatArray, before: FloatArray, after: FloatArray) -> float:
    """Mean logarithm of how much narrower the band of what is predicted becomes."""
    first, last = (np.einsum("ij,jk,ik->i", wanted, c, wanted) for c in (before, after))
    seen = first > 1e-12 * float(first.max(initial=0.0))
    return float(np.mean(0.5 * np.log(last[seen] / first[seen]))) if seen.any() else 0.0


def _distinguishes(candidate: DesignCandidate, centres: Sequence[_Centre]) -> float | None:
    """Probability that the nearer of two curves is the right one, of the optima of basins that differ the least."""
    optima = {centre.basin: centre for centre in reversed(centres)}  # the first of each is its optimum
    if len(optima) < 2:
        return None
    curves = [
        np.concatenate([o.values[r.series][r.at] / (r.error or np.inf) for r in candidate.readings])
        for o in optima.values()
    ]
    apart = [float(np.linalg.norm(a - b)) for i, a in enumerate(curves) for b in curves[:i]]
    return float(ndtr(min(apart) / 2.0))


def _intervals(
    method: DesignMethod, optimum: FloatArray, deviations: FloatArray
) -> dict[str, tuple[float, float] | None]:
    """Expected 95 % intervals around an optimum, natural values; deviations in parts of the range."""
    found: dict[str, tuple[float, float] | None] = {}
    for (name, parameter), value, deviation in zip(method.identified.items(), optimum, deviations, strict=True):
        half = method.quantile * float(deviation)
        if 2.0 * half > 1.0:
            found[name] = None
        elif parameter.scale == "log":
            factor = float((parameter.upper / parameter.lower) ** half)
            found[name] = (float(value / factor), float(value * factor))
        else:
            half *= parameter.upper - parameter.lower
            found[name] = (float(value - half), float(value + half))
    return found
