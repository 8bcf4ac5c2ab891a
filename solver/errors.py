"""Everything that can go wrong in the solver.

::

    SolverError
    ├── ProblemError            the problem is invalid: lists every issue with its path
    ├── ExpressionError         a formula or constraint cannot be understood
    ├── WorkerLostError         a worker process of an in-process run died
    ├── UnknownForwardModelError     no forward model of that kind is installed
    ├── BrokenForwardModelError      a forward model is installed, but cannot be loaded
    ├── SignedListError         a list of registered models is not what was signed, or cannot be made
    ├── MeshError               a mesh cannot be read or is not sound
    ├── StatisticsError         the stored evaluations do not suffice for what was asked
    ├── InfeasibleSpaceError    no proposal satisfies the constraints after a bounded search
    └── ForwardError            one forward calculation failed; becomes a failed evaluation
        ├── DivergedError       the calculation found no solution
        ├── NotFiniteError      a response is NaN or infinite
        ├── InfeasibleError     the parameters are outside the limits of the model
        └── BadOutputError      the model did not return a valid response

``ForwardError.reason`` is the word stored with the failed evaluation.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

from geoswarm.solver.sentences import Key, Sentence, plain

__all__ = [
    "FailureReason",
    "BadOutputError",
    "BrokenForwardModelError",
    "DivergedError",
    "ExpressionError",
    "ForwardError",
    "InfeasibleError",
    "InfeasibleSpaceError",
    "Issue",
    "MeshError",
    "NotFiniteError",
    "ProblemError",
    "SignedListError",
    "SolverError",
    "StatisticsError",
    "WorkerLostError",
    "in_words",
    "message_of",
    "unknown_series",
]

FailureReason: TypeAlias = Literal[
    "diverged",
    "not_finite",
    "infeasible",
    "bad_output",
    "timeout",
    "killed_memory",
    "worker_lost",
    "not_started",
    "program_failed",
    "no_output",
    "no_licence",
]
"""Why an evaluation failed: the words of ForwardError, and those of the engine that runs it."""


class SolverError(Exception):
    """Base of all errors that the solver raises on purpose.

    Examples
    --------
    >>> import geoswarm as gs
    >>> issubclass(gs.ProblemError, gs.SolverError), issubclass(gs.ForwardError, gs.SolverError)
    (True, True)
    """


def message_of(error: BaseException) -> str:
    """Return the message of an error, also of one that cannot be printed."""
    try:
        return str(error)
    except Exception:  # noqa: BLE001  a forward model's own class
        return "(its message cannot be printed)"


def in_words(error: BaseException) -> str:
    """Return the name and message of an error."""
    message = message_of(error)
    return f"{type(error).__name__}: {message}" if message else type(error).__name__


@dataclass(frozen=True, slots=True)
class Issue:
    """One mistake in a problem: ``path`` (``parameters.c.lower``) and what is wrong and accepted there."""

    path: str
    message: str
    parts: Sentence = ()
    """The message with the keys that it names, where the form words these."""

    @classmethod
    def about(cls, path: str, sentence: Sentence, within: str = "") -> Issue:
        """A mistake whose message names keys of the problem, by their paths ``within`` a part of it."""
        keys = tuple(replace(one, path=f"{within}{one.path}") if isinstance(one, Key) else one for one in sentence)
        return cls(path, plain(sentence), keys if any(isinstance(one, Key) for one in keys) else ())

    def __post_init__(self) -> None:
        # What was written is quoted in messages, and may be of any length.
        object.__setattr__(self, "path", _shortened(self.path, 200))
        object.__setattr__(self, "message", _shortened(self.message, 1000))

    def __str__(self) -> str:
        return f"{self.path}: {self.message}" if self.path else self.message


def _shortened(text: str, length: int) -> str:
    return text if len(text) <= length else f"{text[: length - 103]} ... {text[-98:]}"


class ProblemError(SolverError):
    """The problem cannot be accepted; ``issues`` names every mistake with its path in the file.

    Examples
    --------
    >>> import geoswarm as gs
    >>> try:
    ...     gs.problem({"forward_model": {"kind": "formula", "series": {}}})
    ... except gs.ProblemError as error:
    ...     paths = [issue.path for issue in error.issues]
    >>> "parameters" in paths, "observations" in paths
    (True, True)
    """

    def __init__(self, issues: Sequence[Issue]) -> None:
        self.issues: tuple[Issue, ...] = tuple(issues)
        super().__init__("\n".join(str(issue) for issue in self.issues))


class ExpressionError(SolverError):
    """An expression cannot be parsed or names something unknown."""


class UnknownForwardModelError(SolverError):
    """No forward model of the wanted kind is installed; the message lists the known kinds."""


class BrokenForwardModelError(SolverError):
    """A forward model is installed, but its entry point cannot be loaded or gives no forward model."""


class SignedListError(SolverError):
    """A signed list of registered models is not what was signed, or cannot be made."""


class MeshError(SolverError):
    """A mesh cannot be read, or is not sound; the message names where."""


class InfeasibleSpaceError(SolverError):
    """No parameter vector inside the bounds was found that satisfies the constraints."""


class StatisticsError(SolverError):
    """The stored evaluations do not suffice for the request; the message says what is missing."""


class WorkerLostError(SolverError):
    """A worker process of an in-process run ended unexpectedly.

    Examples
    --------
    >>> import geoswarm as gs
    >>> issubclass(gs.WorkerLostError, gs.SolverError)
    True
    """


def unknown_series(name: str, known: Iterable[str]) -> ProblemError:
    """The error for a series that a model does not have."""
    return ProblemError([Issue("series", f"{name!r} is unknown; known are {', '.join(known)}")])


class ForwardError(SolverError):
    """One forward calculation failed.

    Examples
    --------
    >>> import geoswarm as gs
    >>> try:
    ...     gs.evaluate(lambda a: [a / 0.0], observations=gs.observed([0], [1]), a=1)
    ... except gs.ForwardError as error:
    ...     print(error.reason)
    bad_output
    """

    reason: str = "diverged"


class DivergedError(ForwardError):
    """The forward calculation found no solution.

    Examples
    --------
    >>> import geoswarm as gs
    >>> def run(values):
    ...     raise gs.DivergedError("no equilibrium at 80 kPa")
    >>> try:
    ...     run({"E": 1e4})
    ... except gs.ForwardError as error:
    ...     print(f"{error.reason}: {error}")
    diverged: no equilibrium at 80 kPa
    """

    reason = "diverged"


class NotFiniteError(ForwardError):
    """A response is NaN or infinite.

    Examples
    --------
    >>> import geoswarm as gs
    >>> def run(values):
    ...     raise gs.NotFiniteError("q is nan at x = 3")
    >>> try:
    ...     run({"E": 1e4})
    ... except gs.ForwardError as error:
    ...     print(f"{error.reason}: {error}")
    not_finite: q is nan at x = 3
    """

    reason = "not_finite"


class InfeasibleError(ForwardError):
    """The parameters are outside the limits of the model.

    Examples
    --------
    >>> import geoswarm as gs
    >>> def run(values):
    ...     raise gs.InfeasibleError("phi must be below 90 degree")
    >>> try:
    ...     run({"E": 1e4})
    ... except gs.ForwardError as error:
    ...     print(f"{error.reason}: {error}")
    infeasible: phi must be below 90 degree
    """

    reason = "infeasible"


class BadOutputError(ForwardError):
    """The model did not return the requested response.

    Examples
    --------
    >>> import geoswarm as gs
    >>> def run(values):
    ...     raise gs.BadOutputError("result.csv has no column uy")
    >>> try:
    ...     run({"E": 1e4})
    ... except gs.ForwardError as error:
    ...     print(f"{error.reason}: {error}")
    bad_output: result.csv has no column uy
    """

    reason = "bad_output"
