"""What goes back and forth between an agent and the service."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.errors import ForwardError, message_of
from geoswarm.solver.objective import LeastSquares
from geoswarm.solver.objective.outcome import ForwardOutcome

__all__ = ["Announcement", "BroughtRun", "Grant", "Run", "Terms", "Wanted", "evaluation_of"]


@dataclass(frozen=True, slots=True)
class Announcement:
    """How an agent makes itself known.

    Parameters
    ----------
    id
        Its own, new for each start.
    host, system, pid
        The machine that it runs on, and its process there.
    slots
        Runs that it makes at once.
    versions
        Of what calculates there, see :mod:`geoswarm.solver.system.versions`.
    kinds
        Kinds of built-in forward models that it runs.
    models
        Registered models that it has: SHA-256 of its files by name.
    """

    id: str
    host: str
    system: str
    pid: int
    slots: int
    versions: Mapping[str, str]
    kinds: Sequence[str]
    models: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class Terms:
    """Terms for an agent: heartbeat interval and length of a lease without one [s], and what it will be given."""

    heartbeat_seconds: float
    lease_seconds: float
    accepted: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Wanted:
    """What the slot of an agent asks for.

    Parameters
    ----------
    runs
        The most at once.
    seconds
        How long the agent still runs [s]; None: for ever.
    frames
        Those that it knows.
    """

    agent: str
    slot: int
    runs: int
    seconds: float | None = None
    frames: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class Run:
    """One run to make: values of all parameters by name; none where it must not be made (``refused``)."""

    particle: int
    attempt: int
    values: Mapping[str, float]
    refused: bool


@dataclass(frozen=True, slots=True)
class Grant:
    """A lease.

    Parameters
    ----------
    frame
        Name of what all runs of the job share.
    shared
        That itself; None where the agent knows it.
    typical
        What a run usually takes [s]; None: not known.
    """

    id: str
    job: str
    frame: str
    shared: Mapping[str, Any] | None
    runs: tuple[Run, ...]
    typical: float | None


@dataclass(frozen=True, slots=True)
class BroughtRun:
    """What came of a run; ``began``, ``ended``: by the agent's clock, since it was given the lease [s].

    A failed one may have the responses of parts that succeeded; an agent of an earlier version sends none.
    """

    particle: int
    attempt: int
    responses: Mapping[str, Sequence[float]]
    reason: str | None
    message: str | None
    log: str | None
    seconds: float
    began: float
    ended: float


def evaluation_of(calibration: Calibration, run: BroughtRun, *, refused: bool) -> Evaluation:
    """Return the evaluation that a run makes: the agent knows no measurement, so it is judged here."""
    nowhere = np.empty(0)
    if refused:
        return Evaluation(nowhere, None, {}, {}, "infeasible", "the constraints are not satisfied there", 0.0)
    found: dict[str, FloatArray] = {}
    if run.reason is None or calibration.problem.method.keeps_parts:
        found = {name: np.array(values, dtype=np.float64) for name, values in run.responses.items()}
    series = calibration.objective
    if run.reason is not None:
        series = LeastSquares([one for one in series.observed if one.series in found])
    try:
        outcome = ForwardOutcome(series.responses(found), run.reason, run.message, run.seconds)
    except ForwardError as error:
        why = (error.reason, message_of(error)) if run.reason is None else (run.reason, run.message)
        outcome = ForwardOutcome({}, *why, run.seconds)
    return calibration.judged(nowhere, outcome)
