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
describe the data, or a stated error is not met, a parameter is called ``identified`` or ``bounded_on_one_side`` only
by an interval that counts each test as one piece of information.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import comb
from typing import Any, Literal, TypeAlias

from geoswarm.solver.identifiability.optimum.basins import OtherFit
from geoswarm.solver.identifiability.optimum.hidden import is_sparse
from geoswarm.solver.identifiability.optimum.linearisation import Linearisation
from geoswarm.solver.identifiability.remedies import FollowUpKind, Remedy, follow_up
from geoswarm.solver.identifiability.residuals.lack_of_fit import FitVerdict
from geoswarm.solver.identifiability.residuals.readings import FEWEST_FREE
from geoswarm.solver.identifiability.samples import Samples
from geoswarm.solver.identifiability.stored.correlations import COORDINATES, Correlation, correlate_at
from geoswarm.solver.identifiability.stored.filtering import Filtered
from geoswarm.solver.identifiability.stored.projections import Projection
from geoswarm.solver.identifiability.stored.proposals import Proposal, propose
from geoswarm.solver.identifiability.stored.verdict_words import FEWEST_GOOD_FITS, in_words
from geoswarm.solver.words import verdict_in_words

__all__ = ["WIDTH_LIMIT", "Beyond", "Evidence", "Verdict", "VerdictCode", "VerdictKind", "judge"]

VerdictKind: TypeAlias = Literal[
    "identified",
    "bounded_on_one_side",
    "in_combination",
    "not_identified",
    "undecided",
    "lack_of_fit",
    "error_not_met",
]

VerdictCode: TypeAlias = Literal[
    "width",
    "several",
    "no_influence",
    "tied",
    "correlated",
    "no_interval",
    "not_minimum",
    "nonlinear",
    "no_error",
    "unexplored",
    "untried",
    "misfit",
    "swarm",
    "thin",
    "few_good_fits",
]
"""Why a verdict is of its kind; ``width``: of the good fits or the interval, with the bounds that it reaches."""

_FOLLOW_UPS: dict[VerdictCode, FollowUpKind] = {
    "swarm": "sensitivity",
    "few_good_fits": "sensitivity",
    "thin": "sensitivity",
    "not_minimum": "sensitivity",
    "nonlinear": "profile",
    "unexplored": "explore",
    "untried": "explore",
}

WIDTH_LIMIT = 0.5
"""A parameter that keeps more than this share of its prior width is not identified."""

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
    partner_intervals
        Of the correlations with ``partners``, 95 %; empty without correlations.
    elsewhere
        Values of the parameter in other basins: where the data allow these as well, or where stored runs point to.
    exchangeable
        Parameters with which it may be exchanged for all that is known.
    exact, spare
        As in :class:`Beyond`.
    tests
        Number of tests that count as one piece of information each, where the model does not describe them; else 0.
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
    partner_intervals: tuple[tuple[float, float], ...] = ()
    elsewhere: tuple[float, ...] = ()
    exchangeable: tuple[str, ...] = ()
    exact: bool = False
    spare: int | None = None
    tests: int = 0

    @property
    def sparse(self) -> bool:
        """Whether another basin could hide in so much of the space that "identified" is said of one basin only."""
        return is_sparse(self.hidden)


@dataclass(frozen=True, slots=True)
class Verdict:
    """What the data say about one parameter.

    Parameters
    ----------
    kind, code
        What is said, and why.
    reason, sentence
        Why in one clause, and all of it in words.
    """

    parameter: str
    kind: VerdictKind
    code: VerdictCode
    reason: str
    sentence: str
    evidence: Evidence
    proposals: tuple[Proposal, ...] = field(default=())

    @property
    def remedies(self) -> tuple[Remedy, ...]:
        """The follow-up that would settle it, where there is one."""
        return (follow_up(_FOLLOW_UPS[self.code]),) if self.code in _FOLLOW_UPS else ()

    @property
    def words(self) -> str:
        """The kind in words, as every table shows it: "identified", "identified within one basin, for this model"."""
        within = " within one basin" if self.kind == "identified" and self.evidence.sparse else ""
        model = ", for this model" if self.evidence.tests else ""
        return f"{verdict_in_words(self.kind)}{within}{model}"

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values."""
        from dataclasses import asdict

        proposals = [proposal.to_json() for proposal in self.proposals]
        remedies = [remedy.to_json() for remedy in self.remedies]
        return asdict(self) | {"words": self.words, "proposals": proposals, "what_to_do": remedies}


@dataclass(frozen=True, slots=True)
class Beyond:
    """What the interval at an optimum does not show.

    Parameters
    ----------
    hidden
        Share of the searched space in which a basin like that of the optimum could hide, 0 to 1; None: not known.
    exact
        The model meets all readings but for rounding, and their error is not stated.
    spare
        Readings beyond the parameters, from which the error was estimated; None where it is stated.
    unfinished
        Runs that point to another basin into which nobody has gone down.
    untried
        Pairs of parameters that may be exchanged for all that is known.
    """

    hidden: float | None = None
    exact: bool = False
    spare: int | None = None
    unfinished: tuple[OtherFit, ...] = ()
    untried: tuple[tuple[str, str], ...] = ()

    @property
    def errorless(self) -> bool:
        """Whether the error cannot be estimated: too few readings, all met."""
        return self.exact and self.spare is not None and self.spare < FEWEST_FREE

    def left(self, name: str) -> tuple[OtherFit, ...]:
        """Those of the unfinished basins in which a parameter has another value."""
        return tuple(other for other in self.unfinished if name in other.differs)

    def exchangeable(self, name: str) -> tuple[str, ...]:
        """Parameters with which one may be exchanged for all that is known."""
        return tuple(first if second == name else second for first, second in self.untried if name in (first, second))


NOTHING_BEYOND = Beyond()

Judged: TypeAlias = tuple[VerdictKind, VerdictCode, Evidence]


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
    held = {} if linearisation is None else dict(linearisation.held)
    verdicts = []
    for index, projection in enumerate(projections):
        name = projection.parameter
        kind, code, evidence = _judge(samples, projection, tied, linearisation, filtered.thin)
        if evidence.basis == "linearisation" and evidence.range_lower is not None:
            solutions = tuple(float(other.parameters[index]) for other in others if name in other.differs)
            kind, code, evidence = _look_beyond(name, index, (kind, code, evidence), solutions, beyond)
        if fit is not None and fit.wrong and kind in ("identified", "bounded_on_one_side"):
            if evidence.basis == "linearisation" and linearisation is not None and linearisation.counts_tests(name):
                evidence = replace(evidence, tests=fit.tests)
            else:
                kind, code = "lack_of_fit" if fit.kind == "lack_of_fit" else "error_not_met", "misfit"
        reason, sentence = in_words(name, kind, code, evidence, linearisation, filtered.thin)
        ignored = code == "no_influence" and evidence.basis == "none"  # by the model: no value and no test mends that
        asked = (filtered.samples, projection, evidence.partners)
        several = code == "several"
        proposals = () if ignored else propose(name, kind, *asked, held=held.get(name), several=several)
        if (fit is not None and fit.kind in ("lack_of_fit", "gross_error")) or _at_bound(samples, projection):
            proposals = tuple(one for one in proposals if one.kind not in ("fix", "link"))
        verdicts.append(Verdict(name, kind, code, reason, sentence, evidence, proposals))
    return tuple(verdicts)


def _at_bound(samples: Samples, projection: Projection) -> bool:
    """Whether the best value lies at a bound: where the search had to stop is not a value to keep."""
    index = samples.names.index(projection.parameter)
    return projection.best in (float(samples.lower[index]), float(samples.upper[index]))


def _look_beyond(name: str, index: int, judged: Judged, solutions: tuple[float, ...], beyond: Beyond) -> Judged:
    """What an interval at the optimum is worth where other basins, exchanges or the error are not excluded."""
    kind, code, evidence = judged
    if solutions:
        return "not_identified", "several", replace(evidence, unimodal=False, elsewhere=solutions)
    if kind not in ("identified", "bounded_on_one_side"):
        return judged
    evidence = replace(evidence, hidden=beyond.hidden, exact=beyond.exact, spare=beyond.spare)
    if beyond.errorless:
        return "undecided", "no_error", evidence
    if left := beyond.left(name):
        places = tuple(float(other.parameters[index]) for other in left)
        return "undecided", "unexplored", replace(evidence, elsewhere=places)
    if exchangeable := beyond.exchangeable(name):
        return "undecided", "untried", replace(evidence, exchangeable=exchangeable)
    return kind, code, evidence


def _tied_pairs(filtered: Filtered) -> tuple[Correlation, ...]:
    """Pairs that are correlated beyond doubt over natural values or search coordinates, with their usual intervals.

    A relation that is straight in one of them may be too curved in the other to show among few samples.
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
) -> Judged:
    name = projection.parameter
    swarm = not samples.unbiased.any()
    good_fits = 0 if swarm else projection.kept
    influence = None if linearisation is None else linearisation.influence(name)
    if linearisation is not None:
        evidence = Evidence("linearisation", good_fits, influence=influence, sampling_bias=swarm)
        if name in linearisation.without_influence:
            return "not_identified", "no_influence", evidence
        if linearisation.unclear:
            return "undecided", "no_interval", evidence
        if tied := linearisation.tied_to(name):
            partners = tuple((partner, None) for partner in tied)
            return "in_combination", "tied", replace(evidence, partners=partners)
    if good_fits >= FEWEST_GOOD_FITS and thin is None:
        return _judge_sampling(projection, tied_pairs, influence)
    if linearisation is not None:
        return _judge_linearisation(samples, name, linearisation, evidence)
    if len(set(samples.objectives.tolist())) == 1 and samples.objectives.size >= FEWEST_GOOD_FITS:
        return "not_identified", "no_influence", Evidence("none", good_fits, sampling_bias=swarm)
    return (
        "undecided",
        "swarm" if swarm else "few_good_fits" if thin is None else "thin",
        Evidence("none", good_fits, sampling_bias=swarm),
    )


def _judge_sampling(projection: Projection, tied_pairs: tuple[Correlation, ...], influence: float | None) -> Judged:
    name = projection.parameter
    tied = sorted(
        (pair for pair in tied_pairs if name in (pair.first, pair.second)),
        key=lambda pair: -abs(pair.coefficient or 0.0),
    )
    evidence = Evidence(
        "sampling",
        projection.kept,
        projection.lowest,
        projection.highest,
        projection.width_ratio,
        projection.unimodal,
        projection.open_below,
        projection.open_above,
        tuple((pair.second if pair.first == name else pair.first, pair.coefficient) for pair in tied),
        influence,
        partner_intervals=tuple((p.lower, p.upper) for p in tied if p.lower is not None and p.upper is not None),
    )
    if tied:
        return "in_combination", "correlated", evidence
    if projection.width_ratio is not None and projection.width_ratio <= WIDTH_LIMIT:
        contact = (bool(projection.open_below), bool(projection.open_above))
        if contact == (False, False):
            if projection.unimodal is False:
                return "not_identified", "several", evidence
            return "identified", "width", evidence
        if contact != (True, True):
            return "bounded_on_one_side", "width", evidence
    return "not_identified", "width", evidence


def _judge_linearisation(samples: Samples, name: str, linearisation: Linearisation, evidence: Evidence) -> Judged:
    index = samples.names.index(name)
    interval = linearisation.interval(name)
    if interval is None:
        return "not_identified", "no_interval", evidence
    low, high = interval
    open_below, open_above = bool(low <= samples.lower[index]), bool(high >= samples.upper[index])
    width = linearisation.unit_width(name)
    evidence = replace(
        evidence, range_lower=low, range_upper=high, width_ratio=width, open_below=open_below, open_above=open_above
    )
    if linearisation.misplaced:
        return "undecided", "not_minimum", evidence
    if linearisation.needs_profile(name):
        return "undecided", "nonlinear", evidence
    if width <= WIDTH_LIMIT and not (open_below or open_above):
        return "identified", "width", evidence
    if width <= 2 * WIDTH_LIMIT and open_below != open_above:
        return "bounded_on_one_side", "width", evidence
    return "not_identified", "width", evidence
