"""Proposals that the engineer can accept: fix, link, widen a bound, add a test.

Each carries the change of the problem file that a follow-up job needs.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from copy import deepcopy
from dataclasses import dataclass, field
from typing import Any, Literal, TypeAlias

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.identifiability.samples import Samples
from geoswarm.solver.identifiability.stored.projections import Projection
from geoswarm.solver.words import ends, per_cent

__all__ = ["FittedLine", "Proposal", "ProposalKind", "apply_changes", "fit_line", "propose"]

ProposalKind: TypeAlias = Literal["fix", "link", "widen", "add_test"]

_FEWEST_FOR_LINE = 5

_LARGEST_LOGARITHM = 700.0


@dataclass(frozen=True, slots=True)
class FittedLine:
    """A straight line through the good fits: ``parameter`` from ``partner``, natural values.

    On a ``linear`` scale parameter = intercept + slope * partner; on a ``log`` scale the same between their logarithms,
    a power law.

    Parameters
    ----------
    scale
        The one on which the line fits better.
    intercept, slope
        Reduced major axis of the good fits: slope = sign(r) sd(parameter) / sd(partner). Neither of the two is a
        measured cause of the other, and this line is the same whichever is linked to which, where least squares would
        be flattened by the scatter in ``partner`` (Kermack and Haldane 1950; Isobe et al. 1990).
    lower, upper
        Range of ``partner`` among the good fits.
    residual
        Standard deviation of the parameter around the line, relative to its mean (linear) or as a difference of
        logarithms (log).
    correlation
        r on that scale.
    count
        Number of good fits.
    """

    parameter: str
    partner: str
    scale: Literal["linear", "log"]
    intercept: float
    slope: float
    lower: float
    upper: float
    residual: float
    correlation: float
    count: int

    @property
    def can_be_written(self) -> bool:
        """Whether the factor of a line on a log scale is a number; it lies at a partner of 1, far from the fits."""
        return self.scale != "log" or abs(self.intercept) < _LARGEST_LOGARITHM

    @property
    def expression(self) -> str:
        """The line as an expression for the problem file."""
        if self.scale == "log":
            return f"{np.exp(self.intercept):.6g} * {self.partner} ** {_signed(self.slope)}"
        sign = "-" if self.slope < 0 else "+"
        return f"{self.intercept:.6g} {sign} {abs(self.slope):.6g} * {self.partner}"

    def value(self, partner: FloatArray | float) -> FloatArray:
        """The parameter at values of the partner, shape as given."""
        partner = np.asarray(partner, dtype=np.float64)
        if self.scale == "log":
            return np.asarray(np.exp(self.intercept + self.slope * np.log(partner)))
        return np.asarray(self.intercept + self.slope * partner)


@dataclass(frozen=True, slots=True)
class Proposal:
    """Something to do about a parameter.

    Parameters
    ----------
    kind
        ``fix`` at a value, ``link`` to another parameter, ``widen`` a bound, ``add_test``.
    parameter
        What it is about.
    sentence
        The proposal in words.
    changes
        Parts of the problem file to replace: {"parameters": {name: section}}; empty for ``add_test``. The value of a
        ``fix`` is that of the best fit: put a laboratory value in its place where there is one.
    line
        Of a ``link``.
    """

    kind: ProposalKind
    parameter: str
    sentence: str
    changes: dict[str, Any] = field(default_factory=dict)
    line: FittedLine | None = None

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        from dataclasses import asdict

        line = None if self.line is None else asdict(self.line) | {"expression": self.line.expression}
        return asdict(self) | {"line": line}


def apply_changes(document: Mapping[str, Any], changes: Iterable[Mapping[str, Any]]) -> dict[str, Any]:
    """Give the problem document of a follow-up job, with the ``changes`` of proposals; the later ones count."""
    changed = deepcopy(dict(document))
    for change in changes:
        changed["parameters"] |= change.get("parameters", {})
    return changed


def fit_line(samples: Samples, parameter: str, partner: str) -> FittedLine | None:
    """Fit the line of ``parameter`` over ``partner``; None with fewer than five samples or a constant partner."""
    y = samples.parameters[:, samples.names.index(parameter)]
    x = samples.parameters[:, samples.names.index(partner)]
    lines = [_line(x, y, parameter, partner, "linear")]
    if (x > 0).all() and (y > 0).all():
        lines.append(_line(np.log(x), np.log(y), parameter, partner, "log"))
    found = [line for line in lines if line is not None]
    if not found:
        return None
    # the logarithms must be clearly better to be worth their form
    best = found[0] if len(found) == 1 or found[1].correlation ** 2 < found[0].correlation ** 2 + 0.02 else found[1]
    lower, upper = float(x.min()), float(x.max())
    return FittedLine(**{**_fields(best), "lower": lower, "upper": upper})


def _fields(line: FittedLine) -> dict[str, Any]:
    from dataclasses import asdict

    return asdict(line)


def _line(
    x: FloatArray, y: FloatArray, parameter: str, partner: str, scale: Literal["linear", "log"]
) -> FittedLine | None:
    count = len(x)
    if count < _FEWEST_FOR_LINE:
        return None
    dx, dy = x - x.mean(), y - y.mean()
    sxx, syy, sxy = float(dx @ dx), float(dy @ dy), float(dx @ dy)
    if not (sxx > 0 and syy > 0):
        return None
    slope = float(np.copysign(np.sqrt(syy / sxx), sxy))
    scatter = np.sqrt(max(syy - 2.0 * slope * sxy + slope * slope * sxx, 0.0) / (count - 2))
    relative = scatter if scale == "log" else scatter / abs(y.mean())
    intercept = float(y.mean() - slope * x.mean())
    r = float(np.clip(sxy / np.sqrt(sxx * syy), -1.0, 1.0))
    return FittedLine(parameter, partner, scale, intercept, slope, np.nan, np.nan, float(relative), r, count)


def propose(
    parameter: str,
    verdict: str,
    good_fits: Samples,
    projection: Projection,
    partners: tuple[tuple[str, float | None], ...],
    *,
    held: str | None = None,
    several: bool = False,
) -> tuple[Proposal, ...]:
    """Propose what to do about a parameter after its verdict.

    Parameters
    ----------
    good_fits
        Filtered samples.
    partners
        Parameters it is tied to, strongest first.
    held
        The bound, ``lower`` or ``upper``, that the minimum lies on and the data pull beyond.
    several
        The data allow several separate values.
    """
    proposals: list[Proposal] = []
    if held is not None:
        proposals += _widen(parameter, good_fits, held, "the data pull beyond it")
    fair = good_fits.select(good_fits.unbiased) if good_fits.source == "mixed" else good_fits
    if verdict == "in_combination":
        partner = partners[0][0]
        lines = (fit_line(fair, parameter, name) for name, r in partners if r is not None)
        proposals += [_link(line) for line in lines if line is not None and line.can_be_written]
        proposals.append(_fix(parameter, projection, f"it cannot be distinguished from {partner}"))
        proposals.append(_add_test(parameter, f"in which {parameter} and {partner} act differently"))
    elif verdict == "not_identified" and several:
        proposals.append(_fix(parameter, projection, "the data allow several separate values"))
        proposals.append(_add_test(parameter, f"that tells these values of {parameter} apart"))
    elif verdict == "not_identified":
        proposals.append(_fix(parameter, projection, "the data hardly depend on it"))
        proposals.append(_add_test(parameter, f"that {parameter} influences"))
    elif verdict == "bounded_on_one_side":
        if held is None:
            side = "lower" if projection.open_below else "upper"
            proposals += _widen(parameter, good_fits, side, "good fits reach the bound")
        proposals.append(_add_test(parameter, f"that limits {parameter} on the open side"))
    elif verdict == "undecided":
        proposals.append(_add_test(parameter, f"that is more sensitive to {parameter}, or evaluate more samples"))
    return tuple(proposals)


def _link(line: FittedLine) -> Proposal:
    scatter = f"the good fits scatter {per_cent(line.residual)} around it"
    low, high = ends(line.lower, line.upper, plain=True)
    sentence = (
        f"Link {line.parameter} to {line.partner}: {line.parameter} = {line.expression} "
        f"for {line.partner} from {low} to {high} ({scatter})."
    )
    return Proposal(
        "link", line.parameter, sentence, {"parameters": {line.parameter: {"expression": line.expression}}}, line
    )


def _fix(parameter: str, projection: Projection, reason: str) -> Proposal:
    value = projection.best
    sentence = f"Fix {parameter} at a value known from elsewhere (best fit: {value:.4g}): {reason}."
    return Proposal("fix", parameter, sentence, {"parameters": {parameter: {"value": value}}})


def _add_test(parameter: str, what: str) -> Proposal:
    return Proposal("add_test", parameter, f"Add a test or a measured series {what}.")


def _widen(parameter: str, samples: Samples, bound: str, reason: str) -> list[Proposal]:
    index = samples.names.index(parameter)
    lower, upper = float(samples.lower[index]), float(samples.upper[index])
    below = bound == "lower"
    if samples.log[index]:
        ratio = upper / lower
        lower, upper = (lower / np.sqrt(ratio), upper) if below else (lower, upper * np.sqrt(ratio))
    else:
        span = upper - lower
        floor = 0.0 if lower >= 0.0 else -np.inf  # a quantity that was given as positive stays so
        if below and lower == floor:
            return []
        lower, upper = (max(lower - span / 2, floor), upper) if below else (lower, upper + span / 2)
    value = lower if below else upper
    section = {"lower": float(lower), "upper": float(upper), "scale": samples.scales[index]}
    sentence = f"Widen the {bound} bound of {parameter} to {value:.4g} if that is physically possible: {reason}."
    return [Proposal("widen", parameter, sentence, {"parameters": {parameter: section}})]


def _signed(value: float) -> str:
    return f"{value:.6g}" if value >= 0 else f"({value:.6g})"
