"""Frozen records of the service's answers; fields as in the HTTP contract, units kN, m, day, degree.

Fields that a newer service adds are ignored.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import datetime
from html import escape
from typing import Any

from geoswarm.records.evaluation import Response
from geoswarm.records.statistics import WeightShare

__all__ = [
    "CheckResult",
    "Figure",
    "ForwardModel",
    "ForwardModelInfo",
    "Health",
    "Operations",
    "Parameter",
    "Report",
    "Series",
    "Session",
    "TestRun",
    "WarmStart",
]


@dataclass(frozen=True, slots=True)
class Report:
    """The report of a job: ``html`` is a self-contained page."""

    html: str

    def _repr_html_(self) -> str:
        """Show the page in a notebook, in a frame of its own so that styles do not mix."""
        return f'<iframe srcdoc="{escape(self.html)}" style="width:100%;height:60rem;border:0"></iframe>'


@dataclass(frozen=True, slots=True)
class Figure:
    """A figure of a job: ``form`` is svg, png or csv (the numbers behind it)."""

    name: str
    form: str
    content: bytes

    def _repr_svg_(self) -> str | None:
        """Show it in a notebook."""
        return self.content.decode() if self.form == "svg" else None

    def _repr_png_(self) -> bytes | None:
        """Show it in a notebook."""
        return self.content if self.form == "png" else None


@dataclass(frozen=True, slots=True)
class TestRun:
    """One forward calculation to test a problem; ``reason`` and ``message`` when it failed."""

    __test__ = False

    state: str
    parameters: dict[str, float]
    objective: float | None
    misfits: dict[str, float | None]
    seconds: float
    reason: str | None
    message: str | None
    responses: dict[str, Response] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class WarmStart:
    """An earlier job with the same forward model: ``warm_start: {jobs: [ID]}`` offers its runs to the search."""

    job: str
    name: str
    evaluations: int


@dataclass(frozen=True, slots=True)
class CheckResult:
    """What a valid problem will run and cost; ``estimated_seconds`` is for one worker.

    Of ``planned_evaluations`` the search leaves ``left_to_answer`` for minimum and intervals.
    ``notes`` list how the readings were processed, by series; ``assumptions``, what the forward model assumes where the
    problem says nothing; ``shares``, what the weights make of each series.
    """

    valid: bool
    name: str
    forward_model: str
    method: str
    free_parameters: list[str]
    data_points: int
    planned_evaluations: int | None
    test_run: TestRun
    estimated_seconds: float | None
    warnings: list[str]
    warm_starts: list[WarmStart]
    notes: dict[str, list[str]] = field(default_factory=dict)
    assumptions: list[str] = field(default_factory=list)
    left_to_answer: int | None = None
    shares: list[WeightShare] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class ForwardModelInfo:
    """A kind of forward model; ``model`` names a registered model, None for all other kinds."""

    kind: str
    description: str
    model: str | None = None


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter of a forward model; if ``default`` is None, the problem must give it."""

    name: str
    symbol: str
    unit: str
    description: str
    default: float | None
    lower: float | None
    upper: float | None
    lower_open: bool
    upper_open: bool
    typical: tuple[float, float] | None
    source: str = ""


@dataclass(frozen=True, slots=True)
class Series:
    """An output of a forward model: y over x, in base units."""

    name: str
    description: str
    x_quantity: str
    x_unit: str
    y_quantity: str
    y_unit: str
    x_lower: float | None
    x_upper: float | None
    x_integer: bool
    x_increasing: bool


@dataclass(frozen=True, slots=True)
class ForwardModel:
    """A kind of forward model in full; with ``depends_on_section`` the lists are those of ``example``."""

    kind: str
    description: str
    json_schema: dict[str, Any]
    example: dict[str, Any] | None
    depends_on_section: bool
    note: str | None
    parameters: list[Parameter]
    series: list[Series]


@dataclass(frozen=True, slots=True)
class Health:
    """Whether the service can work; ``dependencies`` are ok, embedded, or say why they cannot be used."""

    status: str
    dependencies: dict[str, str]

    @property
    def ok(self) -> bool:
        """Whether all that the service needs can be reached."""
        return self.status == "ok"


@dataclass(frozen=True, slots=True)
class Session:
    """Whose key a request brings, and what it may; ``expires_at`` only of a browser's session."""

    owner: str | None
    role: str
    key_needed: bool
    signed_in: bool
    expires_at: datetime | None


@dataclass(frozen=True, slots=True)
class Operations:
    """How the installation is doing, over all owners.

    Attributes
    ----------
    jobs, workers
        Number by state.
    waiting, running
        Evaluations of running jobs that wait for a worker, and that a worker has.
    oldest_wait
        Age of the oldest job that no worker has begun [s].
    outcomes
        Forward runs since the installation was made: finished, or the kind of failure.
    lost_evaluations
        Evaluations that were taken from a lost worker.
    event_streams
        Open event streams of the process that answered.
    """

    jobs: dict[str, int]
    waiting: int
    running: int
    oldest_wait: float
    workers: dict[str, int]
    outcomes: dict[str, int]
    lost_evaluations: int
    event_streams: int
