"""What an interval at an optimum does not show: other basins, and readings without information on their error."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from geoswarm.solver.identifiability.optimum.basins import OtherFit
from geoswarm.solver.identifiability.optimum.linearisation import Linearisation
from geoswarm.solver.words import listed, share

__all__ = [
    "NOTHING_BEYOND",
    "SPARSE",
    "Beyond",
    "left_alone",
    "several",
    "untried_exchange",
    "where_intervals_hold",
    "within_basin",
]

SPARSE = 0.1
"""From this share of the space in which another basin could hide, "identified" is said of one basin only."""

_FEWEST_FREE = 4  # readings beyond the parameters: fewer do not show whether they have an error
_SMALLEST = 0.001  # share that is told


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
        return self.exact and self.spare is not None and self.spare < _FEWEST_FREE

    def undecided(self, name: str) -> str:
        """What is said of a parameter then."""
        more = "is only 1 more reading" if self.spare == 1 else f"are only {self.spare} more readings"
        return (
            f"{name} is undecided: there {more} than parameters, all readings are met to rounding, and so no "
            "error can be estimated; state the error of the readings."
        )

    def left(self, name: str) -> tuple[OtherFit, ...]:
        """Those of the unfinished basins in which a parameter has another value."""
        return tuple(other for other in self.unfinished if name in other.differs)


NOTHING_BEYOND = Beyond()


def where_intervals_hold(hidden: float | None) -> str:
    """Note below a table of intervals, with the share of the space in which another basin could hide."""
    if hidden is None:
        return "Intervals hold within the basin of the optimum."
    return (
        f"Intervals hold within the basin of the optimum; one like it could still hide in {_share(hidden)} of the "
        "searched space."
    )


def _share(hidden: float) -> str:
    return "below 0.1%" if hidden < _SMALLEST else share(hidden)


def several(name: str, linearisation: Linearisation, others: Sequence[OtherFit]) -> str:
    """Name the values of a parameter in all basins that the data allow."""
    index = linearisation.names.index(name)
    here = f"{linearisation.optimum[index]:.3g}"
    values = list(dict.fromkeys((here, *(f"{float(other.parameters[index]):.3g}" for other in others))))
    if len(values) == 1:
        values = [f"{linearisation.optimum[index]:.6g}", f"{float(others[0].parameters[index]):.6g}"]
    allowed = "both" if len(values) == 2 else "all of them"
    return (
        f"{name} has more than one solution: {name} = {listed(values, 'or')}: the data allow "
        f"{allowed}, with other values of the parameters; the interval at the optimum holds within the basin of the "
        "first alone."
    )


def untried_exchange(name: str, sentence: str, beyond: Beyond) -> str | None:
    """Sentence that an interval proves nothing while a parameter may be exchangeable with another; else None."""
    others = [first if second == name else second for first, second in beyond.untried if name in (first, second)]
    if not others:
        return None
    _, _, values = sentence.removesuffix(".").partition(": ")
    return (
        f"{name} is undecided: {values}; but {name} and {' or '.join(others)} may be exchanged for all that the stored "
        "runs show: 'geoswarm explore' runs the optimum with their values swapped."
    )


def left_alone(name: str, sentence: str, linearisation: Linearisation, left: Sequence[OtherFit]) -> str:
    """Sentence that an interval proves nothing while runs point to another basin that was not explored."""
    index = linearisation.names.index(name)
    _, _, values = sentence.removesuffix(".").partition(": ")
    places = list(dict.fromkeys(f"{float(other.parameters[index]):.3g}" for other in left))
    where = "another basin" if len(left) == 1 else "other basins"
    return (
        f"{name} is undecided: {values}; but this holds within its basin, and stored runs point to {where}, around "
        f"{name} = {listed(places)} that the search did not explore; 'geoswarm explore' goes there."
    )


def within_basin(name: str, sentence: str, beyond: Beyond) -> str:
    """Sentence on the basin in which an interval holds, where another could hide, and the source of the error."""
    parts = [sentence.removesuffix(".")]
    hidden = beyond.hidden
    if hidden is None:
        parts.append("it holds within its basin")
    else:
        like = f"one like it could still hide in {_share(hidden)} of the searched space"
        if hidden > SPARSE:
            parts[0] = parts[0].replace(f"{name} is identified: ", f"{name} is identified within one basin only: ", 1)
            like = f"the runs are sparse, and {like}"
        parts.append(f"it holds within its basin; {like}")
    if beyond.exact:
        parts.append("all readings are met to rounding, so no error can be estimated: the width is that of rounding")
    elif beyond.spare is not None and beyond.spare < _FEWEST_FREE:
        more = "1 more reading" if beyond.spare == 1 else f"{beyond.spare} more readings"
        parts.append(f"the error is estimated from only {more} than parameters")
    return "; ".join(parts) + "."
