"""What in a valid problem is probably not meant.

A finding is a sentence and a warning; only readings that no soil can have are errors, unless the problem accepts them.

================  =======================================================================================
``ranges``        values far outside the usual ranges that forms show
``expectations``  bounds that leave out what index properties of the soil let expect
``headings``      units of the problem file against those in the headings of the data
``readings``      size and sign of readings against the specimen
``loads``         loads of a test in stages that the readings do not show
``weights``       series of different units without weights
``pace``          rates and durations of shear tests that neither the law nor a reading knows of
``staged``        observations of laboratory tests with loads in stages, wherever in a problem they stand
================  =======================================================================================
"""

from __future__ import annotations

from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.plausibility.expectations import unexpected_bounds
from geoswarm.solver.plausibility.headings import contradicted_headings
from geoswarm.solver.plausibility.loads import loads_not_shown
from geoswarm.solver.plausibility.pace import pace_without_effect
from geoswarm.solver.plausibility.ranges import unusual_values
from geoswarm.solver.plausibility.readings import Doubt, doubtful_readings
from geoswarm.solver.plausibility.weights import unweighted_units
from geoswarm.solver.problem import Problem
from geoswarm.solver.sentences import Sentence
from geoswarm.solver.words import did_you_mean

__all__ = ["implausible", "impossible", "require_possible", "to_be_accepted"]


def impossible(problem: Problem) -> list[Issue]:
    """Return readings that no soil can have and that the problem does not accept, as mistakes in it; runs nothing.

    So are series that it names and that do not exist.
    """
    known = [info.name for info in problem.model.series]
    named = {"accept": problem.accept, "noise.series": () if problem.noise is None else problem.noise.series}
    unknown = [
        Issue(f"{key}[{index}]", f"unknown series '{name[:60]}'{did_you_mean(name, known)}")
        for key, names in named.items()
        for index, name in enumerate(names)
        if name not in known
    ]
    return unknown + [doubt.issue for doubt in _unaccepted(problem)]


def to_be_accepted(problem: Problem) -> list[str]:
    """Return the series whose readings :func:`impossible` refuses."""
    return list(dict.fromkeys(doubt.series for doubt in _unaccepted(problem)))


def _unaccepted(problem: Problem) -> list[Doubt]:
    return [doubt for doubt in doubtful_readings(problem) if doubt.impossible and doubt.series not in problem.accept]


def implausible(problem: Problem) -> tuple[Sentence, ...]:
    """Everything about a problem that is probably not meant; runs nothing."""
    return (
        *unusual_values(problem),
        *unexpected_bounds(problem),
        *contradicted_headings(problem),
        *(doubt.sentence for doubt in doubtful_readings(problem)),
        *loads_not_shown(problem),
        *unweighted_units(problem),
        *pace_without_effect(problem),
    )


def require_possible(problem: Problem) -> None:
    """Refuse a problem with readings that no soil can have, see :func:`impossible`.

    Raises
    ------
    ProblemError
    """
    if found := impossible(problem):
        raise ProblemError(found)
