"""Verdicts in words: the reason in one clause, and the sentence, from the record of a verdict.

No other module words a verdict, and nothing reads a sentence back: who needs a part of one takes it from the record.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, assert_never

from geoswarm.solver.identifiability.optimum.linearisation import Linearisation
from geoswarm.solver.identifiability.residuals.readings import FEWEST_FREE
from geoswarm.solver.words import ends, listed, per_cent

if TYPE_CHECKING:
    from geoswarm.solver.identifiability.stored.verdicts import Evidence, VerdictCode, VerdictKind

__all__ = ["FEWEST_GOOD_FITS", "in_words", "where_intervals_hold"]

FEWEST_GOOD_FITS = 10
_SMALLEST = 0.001  # share that is named
_MORE_RUNS = "calculate sensitivities at the optimum, or sample the space"


def where_intervals_hold(hidden: float | None) -> str:
    """Note below a table of intervals, with the share of the space in which another basin could hide."""
    if hidden is None:
        return "Intervals hold within the basin of the optimum."
    return (
        "Intervals hold within the basin of the optimum; another basin like it could still hide in "
        f"{_share(hidden)} of the searched space."
    )


def in_words(
    name: str,
    kind: VerdictKind,
    code: VerdictCode,
    evidence: Evidence,
    linearisation: Linearisation | None = None,
    thin: str | None = None,
) -> tuple[str, str]:
    """Return the reason of a verdict in one clause, and the verdict as a sentence.

    Parameters
    ----------
    linearisation
        On which the verdict rests, where its basis is one.
    thin
        Why the sampling is too thin, where that is the reason.
    """
    if evidence.basis == "linearisation":
        assert linearisation is not None
        reason = _at_optimum(name, kind, code, evidence, linearisation)
    else:
        reason = _of_runs(kind, code, evidence, thin)
    return reason, f"{name} {_claim(kind, evidence)}: {'; '.join((reason, *_caveats(kind, evidence)))}."


def _claim(kind: VerdictKind, evidence: Evidence) -> str:
    model = ", for this model" if evidence.tests else ""
    match kind:
        case "identified":
            return f"is identified{' within one basin only' if evidence.sparse else ''}{model}"
        case "bounded_on_one_side":
            return f"is only bounded from {'above' if evidence.open_below else 'below'}{model}"
        case "in_combination":
            return f"is determined only in combination with {_partners(evidence)}"
        case "not_identified":
            return "is not identified"
        case "undecided":
            return "is undecided"
        case "lack_of_fit":
            return "is that of the closest curve only"
        case "error_not_met":
            return "is less certain than calculated"
        case _:
            assert_never(kind)


def _of_runs(kind: VerdictKind, code: VerdictCode, evidence: Evidence, thin: str | None) -> str:
    """Reason from a sampling or a swarm."""
    if code == "no_influence":
        return "all runs gave the same objective, whatever its value; check that the forward model uses it"
    if code == "swarm":
        return f"the runs of a search cluster around its best fit, so their spread gives no interval; {_MORE_RUNS}"
    if code == "few_good_fits":
        return f"only {evidence.good_fits} samples fit well, at least {FEWEST_GOOD_FITS} are needed; {_MORE_RUNS}"
    if code == "thin":
        return f"{thin}; {_MORE_RUNS}"
    low, high = _ends(evidence)
    values = f"{evidence.good_fits} good fits lie between {low} and {high}, {_part(evidence)}"
    if code == "several":
        return f"it has more than one solution: {values}, in separate groups"
    if (bound := _bound(evidence)) is not None:
        values += f", and they reach the {bound} bound"
    if evidence.unimodal is False:
        values += "; they form more than one group"
    if code == "correlated":
        pairs = zip(evidence.partners, evidence.partner_intervals, strict=True)
        return f"{listed([f'r = {r:.2f} ({a:.2f} to {b:.2f}) with {other}' for (other, r), (a, b) in pairs])}; {values}"
    return f"{_misfit(kind)}{values}"


def _at_optimum(name: str, kind: VerdictKind, code: VerdictCode, evidence: Evidence, found: Linearisation) -> str:
    """Reason from the linearisation at the optimum."""
    if code == "no_influence":
        return "it has no influence on the measured series at the optimum: there, the data say nothing about it"
    if code == "tied":
        return (
            f"changing it together with {_partners(evidence)} changes nothing that was measured, so none of them has "
            "an interval of its own"
        )
    if code == "no_interval":
        return found.why_no_interval(name)
    if code == "no_error":
        return (
            f"there {'is' if evidence.spare == 1 else 'are'} only {_more(evidence)} than parameters, all readings are "
            "met to rounding, and so no error can be estimated; state the error of the readings"
        )
    if code == "several":
        values = (float(found.optimum[found.names.index(name)]), *evidence.elsewhere)
        solutions = _distinct(values) if len(_distinct(values)) > 1 else [f"{value:.6g}" for value in values[:2]]
        return (
            f"it has more than one solution, {name} = {listed(solutions, 'or')}: the data allow "
            f"{'both' if len(solutions) == 2 else 'all of them'}, with other values of the parameters; the interval at "
            "the optimum holds only within the basin of the first"
        )
    interval = f"{found.interval_in_words(name)} is {' to '.join(_ends(evidence))}"
    if code == "not_minimum":
        return (
            f"{interval}, but that is not the minimum yet ({found.far:.2g} standard errors away); polish the best "
            "parameters first"
        )
    if code == "nonlinear":
        return (
            f"{interval}, but the model is nonlinear there, and the interval by likelihood differs by about "
            f"{per_cent(found.bending_of(name))} on one side"
        )
    width = f"{interval}, {_part(evidence)}"
    if (bound := _bound(evidence)) is not None:
        width += f", up to the {bound} bound or beyond"
    if code == "unexplored":
        places = _distinct(evidence.elsewhere)
        where = "another basin" if len(places) == 1 else "other basins"
        return (
            f"{width}; but this holds within its basin, and stored runs point to {where}, around {name} = "
            f"{listed(places)}, which the search did not explore"
        )
    if code == "untried":
        return (
            f"{width}; but {name} and {listed(evidence.exchangeable, 'or')} may be exchanged for all that the stored "
            "runs show: none has tried the optimum with their values swapped"
        )
    return f"{_misfit(kind)}{width}"


def _misfit(kind: VerdictKind) -> str:
    if kind == "lack_of_fit":
        return "the model does not describe the data, so the following does not hold: "
    return "the stated error is not met, so the following does not hold: " if kind == "error_not_met" else ""


def _caveats(kind: VerdictKind, evidence: Evidence) -> list[str]:
    """The basin in which an interval holds, where another could hide, and the source of the error."""
    if evidence.basis != "linearisation" or kind not in ("identified", "bounded_on_one_side"):
        return []
    parts = ["it holds within its basin"]
    if evidence.tests:
        parts[:0] = [
            f"it counts each of the {evidence.tests} tests as one piece of information, as the model does not describe "
            "them within the scatter of their readings"
        ]
    if evidence.hidden is not None:
        sparse = "the runs are sparse, and " if evidence.sparse else ""
        parts.append(
            f"{sparse}another basin like it could still hide in {_share(evidence.hidden)} of the searched space"
        )
    if evidence.exact:
        parts.append("all readings are met to rounding, so no error can be estimated: the width is that of rounding")
    elif evidence.spare is not None and evidence.spare < FEWEST_FREE:
        parts.append(f"the error is estimated from only {_more(evidence)} than parameters")
    return parts


def _partners(evidence: Evidence) -> str:
    return listed([partner for partner, _ in evidence.partners])


def _ends(evidence: Evidence) -> tuple[str, str]:
    assert evidence.range_lower is not None
    assert evidence.range_upper is not None
    return ends(evidence.range_lower, evidence.range_upper, plain=True)


def _part(evidence: Evidence) -> str:
    return f"{per_cent(evidence.width_ratio or 0.0)} of the searched range"


def _bound(evidence: Evidence) -> str | None:
    """The one bound that the range reaches."""
    if bool(evidence.open_below) == bool(evidence.open_above):
        return None
    return "lower" if evidence.open_below else "upper"


def _more(evidence: Evidence) -> str:
    return "1 more reading" if evidence.spare == 1 else f"{evidence.spare} more readings"


def _distinct(values: tuple[float, ...]) -> list[str]:
    return list(dict.fromkeys(f"{value:.3g}" for value in values))


def _share(hidden: float) -> str:
    return "less than 0.1 %" if hidden < _SMALLEST else per_cent(hidden)
