"""Verdicts: what the data say about each parameter, on which evidence, and what the engineer may do about it.

Rules, in this order (docs/statistics.md explains them):

1. *Linearisation at the optimum*, when given. Where its derivatives are too uncertain: ``undecided``. A parameter
   without influence is ``not_identified``. One that takes part in a combination that the data leave open is
   ``in_combination``.
2. *Good fits of a sampling*, at least ten, below a threshold that is at most twice what statistics would have: above,
   they describe how thin the sampling is, and are left aside. With |r| >= 0.5 to another parameter, over natural
   values or search coordinates, where 0 is excluded with 99 % over all pairs together: ``in_combination``. Otherwise,
   with at most half the prior width left and no bound contact: ``identified``; with contact on one side:
   ``bounded_on_one_side``; all else: ``not_identified``.
3. *A swarm alone* proves nothing by its width. With a linearisation: ``identified`` when the 95 % interval is at most
   half the range wide and inside the bounds, ``bounded_on_one_side`` when it crosses one bound, else
   ``not_identified``. Without one: ``undecided``, and so where the model is nonlinear within that interval and no
   profile has been calculated, and with fewer than ten good fits. ``not_identified``, too, where
   stored runs fit as well as the optimum outside the region that the linearisation allows.

Before all of them stands the fit (``residuals.lack_of_fit``): where the model does not
describe the data, or a stated error is not met, no parameter is called ``identified`` or ``bounded_on_one_side``.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import comb
from typing import Any, Literal, TypeAlias

from geoswarm.solver.identifiability.optimum.basins import OtherFit
from geoswarm.solver.identifiability.optimum.linearisation import Linearisation
from geoswarm.solver.identifiability.residuals.lack_of_fit import FitVerdict
from geoswarm.solver.identifiability.samples import Samples
from geoswarm.solver.identifiability.stored.basin_words import (
    NOTHING_BEYOND,
    SPARSE,
    Beyond,
    left_alone,
    several,
    untried_exchange,
    within_basin,
)
from geoswarm.solver.identifiability.stored.correlations import COORDINATES, Correlation, correlate_at
from geoswarm.solver.identifiability.stored.filtering import Filtered
from geoswarm.solver.identifiability.stored.projections import Projection
from geoswarm.solver.identifiability.stored.proposals import Proposal, propose
from geoswarm.solver.words import ends, share, verdict_in_words

__all__ = ["FEWEST_GOOD_FITS", "WIDTH_LIMIT", "Evidence", "Verdict", "VerdictKind", "judge"]

VerdictKind: TypeAlias = Literal[
    "identified",
    "bounded_on_one_side",
    "in_combination",
    "not_identified",
    "undecided",
    "lack_of_fit",
    "error_not_met",
]

WIDTH_LIMIT = 0.5
"""A parameter that keeps more than this share of its prior width is not identified."""

FEWEST_GOOD_FITS = 10

_FALSE_PAIRS = 0.01  # probability of calling any pair correlated that is not


@dataclass(frozen=True, slots=True)
class Evidence:
    """What a verdict rests on; None where something is not known.

    Parameters
    ----------
    basis
        ``sampling``, ``linearisation`` or ``none``.
    good_fits
        Monte Carlo samples below the threshold.
    range_lower, range_upper
        Least and largest value among the good fits, or the confidence interval; natural values.
    width_ratio, unimodal, open_below, open_above
        As in :class:`Projection`; of the interval where the basis is the linearisation.
    partners
        Parameters it is tied to, strongest first, with the correlation where there is one.
    influence
        Largest share that the parameter has in what the data see (0: none); None without a linearisation.
    sampling_bias
        True when the samples are a swarm's.
    hidden
        Share of the searched space in which a basin like this one could still hide, 0 to 1; None where nobody looked.
    """

    basis: Literal["sampling", "linearisation", "none"]
    good_fits: int
    range_lower: float | None = None
    range_upper: float | None = None
    width_ratio: float | None = None
    unimodal: bool | None = None
    open_below: bool | None = None
    open_above: bool | None = None
    partners: tuple[tuple[str, float | None], ...] = ()
    influence: float | None = None
    sampling_bias: bool = False
    hidden: float | None = None


@dataclass(frozen=True, slots=True)
class Verdict:
    """What the data say about one parameter: kind, evidence, one plain sentence, and proposals."""

    parameter: str
    kind: VerdictKind
    sentence: str
    evidence: Evidence
    proposals: tuple[Proposal, ...] = field(default=())

    @property
    def words(self) -> str:
        """The kind in words, as every table shows it: "identified", or "identified within one basin"."""
        hidden = self.evidence.hidden
        sparse = self.kind == "identified" and hidden is not None and hidden > SPARSE
        return f"{verdict_in_words(self.kind)} within one basin" if sparse else verdict_in_words(self.kind)

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        from dataclasses import asdict

        proposals = [proposal.to_json() for proposal in self.proposals]
        return asdict(self) | {"words": self.words, "proposals": proposals}


def judge(
    samples: Samples,
    filtered: Filtered,
    projections: tuple[Projection, ...],
    linearisation: Linearisation | None = None,
    others: tuple[OtherFit, ...] = (),
    fit: FitVerdict | None = None,
    beyond: Beyond = NOTHING_BEYOND,
) -> tuple[Verdict, ...]:
    """Judge every parameter.

    Parameters
    ----------
    samples, filtered
        All samples and the good fits among them.
    projections
        Of all samples with the filter's threshold.
    linearisation
        At the optimum, when it was made.
    others
        Sets of parameters that fit as well as the optimum, outside the region of its linearisation.
    fit
        Whether the model describes the data; that of the linearisation when None.
    beyond
        What the interval at an optimum does not show: where another basin could hide, and whether an error is known.
    """
    fit = fit or (None if linearisation is None else linearisation.fit)
    tied = _tied_pairs(filtered)
    verdicts = []
    for projection in projections:
        kind, evidence, sentence = _judge(samples, projection, tied, linearisation, filtered.thin)
        elsewhere = [other for other in others if projection.parameter in other.differs]
        if linearisation is not None and elsewhere and evidence.basis == "linearisation" and evidence.width_ratio:
            kind, evidence = "not_identified", replace(evidence, unimodal=False)
            sentence = several(projection.parameter, linearisation, elsewhere)
        elif evidence.basis == "linearisation" and kind in ("identified", "bounded_on_one_side"):
            evidence = replace(evidence, hidden=beyond.hidden)
            if beyond.errorless:
                kind, sentence = "undecided", beyond.undecided(projection.parameter)
            elif linearisation is not None and (left := beyond.left(projection.parameter)):
                kind = "undecided"
                sentence = left_alone(projection.parameter, sentence, linearisation, left)
            elif (swaps := untried_exchange(projection.parameter, sentence, beyond)) is not None:
                kind, sentence = "undecided", swaps
            else:
                sentence = within_basin(projection.parameter, sentence, beyond)
        kind, sentence = _under_fit(projection.parameter, kind, sentence, fit)
        proposals = propose(projection.parameter, kind, filtered.samples, projection, evidence.partners)
        if (fit is not None and fit.kind in ("lack_of_fit", "gross_error")) or _at_bound(samples, projection):
            proposals = tuple(one for one in proposals if one.kind not in ("fix", "link"))
        verdicts.append(Verdict(projection.parameter, kind, sentence, evidence, proposals))
    return tuple(verdicts)


def _at_bound(samples: Samples, projection: Projection) -> bool:
    """Whether the best value lies at a bound: where the search had to stop is no value to keep."""
    index = samples.names.index(projection.parameter)
    return projection.best in (float(samples.lower[index]), float(samples.upper[index]))


def _under_fit(name: str, kind: VerdictKind, sentence: str, fit: FitVerdict | None) -> tuple[VerdictKind, str]:
    """What is left of a verdict where the model does not describe the data, or the stated error is not met."""
    if fit is None or kind not in ("identified", "bounded_on_one_side"):
        return kind, sentence
    _, _, values = sentence.partition(": ")
    if fit.kind == "lack_of_fit":
        return "lack_of_fit", (
            f"{name} is that of the closest curve only: the model does not describe the data, so this does not hold: "
            f"{values}"
        )
    if fit.kind == "error_not_met":
        return "error_not_met", f"{name} is less certain than this says, as the stated error is not met: {values}"
    return kind, sentence


def _tied_pairs(filtered: Filtered) -> tuple[Correlation, ...]:
    """Pairs that are correlated beyond doubt over natural values or search coordinates, with their usual intervals.

    A relation that is straight in one of them may be too bent in the other to show among few samples.
    """
    found: list[Correlation] = []
    pairs = comb(filtered.samples.dimension, 2)
    levels = (0.95, 1.0 - _FALSE_PAIRS / max(len(COORDINATES) * pairs, 1))
    both = [correlate_at(filtered.samples, levels, coordinates=coordinates) for coordinates in COORDINATES]
    for index in range(pairs):
        tied = [usual.pairs[index] for usual, strict in both if strict.pairs[index].correlated]
        found += sorted(tied, key=lambda pair: -abs(pair.coefficient or 0.0))[:1]
    return tuple(found)


def _judge(
    samples: Samples,
    projection: Projection,
    tied_pairs: tuple[Correlation, ...],
    linearisation: Linearisation | None,
    thin: str | None,
) -> tuple[VerdictKind, Evidence, str]:
    name = projection.parameter
    swarm = not samples.unbiased.any()
    good_fits = 0 if swarm else projection.kept
    influence = None if linearisation is None else linearisation.influence(name)
    if linearisation is not None and name in linearisation.without_influence:
        evidence = Evidence("linearisation", good_fits, influence=influence, sampling_bias=swarm)
        return (
            "not_identified",
            evidence,
            f"{name} has no influence on the measured series at the optimum: there, the data say nothing about it.",
        )
    if linearisation is not None and linearisation.unclear:
        evidence = Evidence("linearisation", good_fits, influence=influence, sampling_bias=swarm)
        return "undecided", evidence, f"{name} is undecided: {linearisation.why_no_interval(name)}."
    tied = () if linearisation is None else linearisation.tied_to(name)
    if tied:
        evidence = Evidence(
            "linearisation",
            good_fits,
            partners=tuple((partner, None) for partner in tied),
            influence=influence,
            sampling_bias=swarm,
        )
        sentence = (
            f"{name} acts on the measured series only in combination with {' and '.join(tied)}: "
            "changing them together changes nothing that was measured, so none of them has an interval of its own."
        )
        return "in_combination", evidence, sentence
    if good_fits >= FEWEST_GOOD_FITS and thin is None:
        return _judge_sampling(projection, tied_pairs, influence)
    if linearisation is not None:
        return _judge_linearisation(samples, name, linearisation, good_fits, swarm)
    evidence = Evidence("none", good_fits, sampling_bias=swarm)
    if thin is not None and not swarm:
        reason = thin
    elif swarm:
        reason = "a swarm crowds where it was drawn to, so the spread of its particles proves nothing"
    else:
        reason = f"only {good_fits} samples fit well, at least {FEWEST_GOOD_FITS} are needed"
    sentence = f"{name} is undecided: {reason}; sample the space or calculate sensitivities at the optimum."
    return "undecided", evidence, sentence


def _judge_sampling(
    projection: Projection, tied_pairs: tuple[Correlation, ...], influence: float | None
) -> tuple[VerdictKind, Evidence, str]:
    name, kept = projection.parameter, projection.kept
    tied = sorted(
        (pair for pair in tied_pairs if name in (pair.first, pair.second)),
        key=lambda pair: -abs(pair.coefficient or 0.0),
    )
    partners = tuple((_other(pair, name), pair.coefficient) for pair in tied)
    evidence = Evidence(
        "sampling",
        kept,
        projection.lowest,
        projection.highest,
        projection.width_ratio,
        projection.unimodal,
        projection.open_below,
        projection.open_above,
        partners,
        influence,
    )
    low, high = ends(projection.lowest or 0.0, projection.highest or 0.0, plain=True)
    values = (
        f"{kept} good fits lie between {low} and {high}, {share(projection.width_ratio or 0.0)} of the searched range"
    )
    several = "" if projection.unimodal is not False else "; they form more than one group"
    if tied:
        words = " and ".join(f"{_other(pair, name)} ({_interval(pair)})" for pair in tied)
        return "in_combination", evidence, f"{name} is determined only in combination with {words}; {values}{several}."
    if projection.width_ratio is not None and projection.width_ratio <= WIDTH_LIMIT:
        contact = (bool(projection.open_below), bool(projection.open_above))
        if contact == (False, False):
            if projection.unimodal is False:
                return "not_identified", evidence, f"{name} has more than one solution: {values}, in separate groups."
            return "identified", evidence, f"{name} is identified: {values}."
        if contact != (True, True):
            side, bound = ("above", "lower") if contact[0] else ("below", "upper")
            sentence = f"{name} is only bounded from {side}: {values}, and they reach the {bound} bound{several}."
            return "bounded_on_one_side", evidence, sentence
    return "not_identified", evidence, f"{name} is not identified: {values}{several}."


def _judge_linearisation(
    samples: Samples, name: str, linearisation: Linearisation, good_fits: int, swarm: bool
) -> tuple[VerdictKind, Evidence, str]:
    index = samples.names.index(name)
    interval = linearisation.interval(name)
    influence = linearisation.influence(name)
    if interval is None:
        evidence = Evidence("linearisation", good_fits, influence=influence, sampling_bias=swarm)
        reason = linearisation.why_no_interval(name)
        return "not_identified", evidence, f"{name} is not identified: {reason}."
    low, high = interval
    open_below, open_above = low <= samples.lower[index], high >= samples.upper[index]
    width = linearisation.unit_width(name)
    evidence = Evidence(
        "linearisation",
        good_fits,
        low,
        high,
        width,
        None,
        bool(open_below),
        bool(open_above),
        influence=influence,
        sampling_bias=swarm,
    )
    values = f"{linearisation.interval_in_words(name)} is {' to '.join(ends(low, high, plain=True))}"
    if linearisation.misplaced:
        sentence = (
            f"{name} is undecided: {values}, but that is not the minimum yet ({linearisation.far:.2g} standard errors "
            "away); polish the best parameters first."
        )
        return "undecided", evidence, sentence
    if linearisation.bent(name):
        sentence = (
            f"{name} is undecided: {values}, but the model is nonlinear there, and the interval by likelihood differs "
            f"by about {share(linearisation.bending_of(name))} on one side; 'geoswarm profile' calculates it."
        )
        return "undecided", evidence, sentence
    if width <= WIDTH_LIMIT and not (open_below or open_above):
        return "identified", evidence, f"{name} is identified: {values}, {share(width)} of the searched range."
    if width <= 2 * WIDTH_LIMIT and bool(open_below) != bool(open_above):
        side, bound = ("above", "lower") if open_below else ("below", "upper")
        return (
            "bounded_on_one_side",
            evidence,
            f"{name} is only bounded from {side}: {values}, up to the {bound} bound or beyond.",
        )
    return "not_identified", evidence, f"{name} is not identified: {values}, {share(width)} of the searched range."


def _other(pair: Correlation, name: str) -> str:
    return pair.second if pair.first == name else pair.first


def _interval(pair: Correlation) -> str:
    return f"r = {pair.coefficient:.2f}, {pair.lower:.2f} to {pair.upper:.2f}"
