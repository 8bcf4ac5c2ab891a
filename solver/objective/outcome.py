"""One forward calculation to its end: its responses, or why there are none. Nothing is said of measurements here."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import ForwardError, in_words, message_of
from geoswarm.solver.forward.base import ForwardRun, NotedResponse
from geoswarm.solver.forward.combined import CombinedRun
from geoswarm.solver.objective.least_squares import LeastSquares, ObservedSeries
from geoswarm.solver.system.activity import counting

__all__ = ["Calculation", "ForwardOutcome"]


@dataclass(frozen=True, slots=True)
class ForwardOutcome:
    """What a forward calculation gave; it failed when ``reason`` is not None.

    Parameters
    ----------
    responses
        Calculated values of each series at its points, shape (m_g,), base units. When it failed, of the parts that
        a :class:`Calculation` has kept.
    reason, message
        Kind of failure and what happened; of a success a note, or None.
    seconds
        Wall time of the calculation without what it waited [s].
    """

    responses: dict[str, FloatArray]
    reason: str | None
    message: str | None
    seconds: float


class Calculation:
    """A prepared forward run with the series that it gives.

    Parameters
    ----------
    observed
        The series.
    keeps_parts
        Whether a combined run of which a part fails keeps the series of the others.
    """

    def __init__(self, run: ForwardRun, observed: Sequence[ObservedSeries], *, keeps_parts: bool) -> None:
        self._parts = [(run, LeastSquares(observed))]
        if keeps_parts and isinstance(run, CombinedRun):
            self._parts = [
                (calculate, LeastSquares([one for one in observed if one.series.partition(".")[0] == part]))
                for part, calculate in run.parts.items()
            ]

    def outcome(self, values: Mapping[str, float]) -> ForwardOutcome:
        """Run it for all parameters by name; never raises for a run that fails."""
        return _joined([_outcome_of(run, values, series.responses) for run, series in self._parts])


def _outcome_of(
    run: ForwardRun,
    values: Mapping[str, float],
    checked: Callable[[Mapping[str, npt.ArrayLike]], dict[str, FloatArray]],
) -> ForwardOutcome:
    began = time.perf_counter()
    with counting() as waited:
        try:
            with np.errstate(all="ignore"):
                found = run(values)
            seconds = time.perf_counter() - began - waited.seconds
            responses = checked(found)
        except ForwardError as error:
            reason, message = error.reason, message_of(error)
        except MemoryError:
            reason, message = "killed_memory", "the forward model ran out of memory"
        except Exception as error:  # noqa: BLE001  a forward model may be anybody's code; its bug is one failed evaluation
            reason, message = "bad_output", f"the forward model raised {in_words(error)}"
        else:
            return ForwardOutcome(responses, None, found.note if isinstance(found, NotedResponse) else None, seconds)
    return ForwardOutcome({}, reason, message, time.perf_counter() - began - waited.seconds)


def _joined(parts: Sequence[ForwardOutcome]) -> ForwardOutcome:
    """The outcome of a calculation from those of its parts: failed where one is, with what the others gave."""
    if len(parts) == 1:
        return parts[0]
    failed = [part for part in parts if part.reason is not None]
    return ForwardOutcome(
        {series: values for part in parts for series, values in part.responses.items()},
        failed[0].reason if failed else None,
        "; ".join(part.message for part in failed if part.message) or None,
        sum(part.seconds for part in parts),
    )
