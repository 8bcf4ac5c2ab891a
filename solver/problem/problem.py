"""A checked problem, ready to be calibrated."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from geoswarm.solver.expressions import Expression
from geoswarm.solver.forward.base import ForwardModel, ForwardModelSpec, ParameterInfo
from geoswarm.solver.index_properties import IndexSection
from geoswarm.solver.methods.base import Method
from geoswarm.solver.problem.observations import Observation
from geoswarm.solver.problem.parameters import (
    Bound,
    FixedParameter,
    FreeParameter,
    LinkedParameter,
    Parameter,
    limit_mistake,
    link_order,
)
from geoswarm.solver.problem.running import Answering, Failures, Limits
from geoswarm.solver.problem.sections import NoiseSection, Stopping
from geoswarm.solver.problem.weighting import Weighting, test_of

__all__ = ["Problem"]


@dataclass(frozen=True, eq=False)
class Problem:
    """What to calculate, what to identify, what was measured, how to search and when to stop.

    Made by :func:`geoswarm.solver.problem.parse_problem` and :func:`geoswarm.solver.problem.load_problem`, which check
    everything. Two problems are equal when their documents are.

    Parameters
    ----------
    name
        Name of the problem.
    forward_model, model
        The section that describes the forward model, and the model built from it.
    parameters
        All parameters by name in the order of the problem file.
    constraints
        Comparisons that every proposal must satisfy.
    observations
        Measured points, one observation a series.
    method, stopping
        How to search and when to stop.
    seed
        Seed of all random numbers; None to choose one.
    weighting
        Weighting scheme of the observations.
    warm_start
        Ids of earlier jobs whose runs are offered to the search.
    limits, failures, priority
        What one evaluation may use, what happens when it fails, and the job's rank among others.
    index_properties
        Index properties of the soil, if known; they are not used in the calibration.
    answer
        The runs after a search that its result needs.
    accept
        Series whose readings are meant as they are, whatever their size.
    noise
        What is known of the errors of the readings; None without.

    Examples
    --------
    >>> import geoswarm as gs
    >>> def line(x, a, b):
    ...     return a + b * x
    >>> parameters = {"a": gs.free(0, 10), "b": gs.free(0, 10)}
    >>> problem = gs.problem(line, parameters=parameters, observations=gs.observed([0, 1], [1, 3]))
    >>> problem.parameters["a"].upper, problem.observations[0].y.tolist()
    (10.0, [1.0, 3.0])
    """

    name: str
    forward_model: ForwardModelSpec
    model: ForwardModel
    parameters: dict[str, Parameter]
    constraints: tuple[Expression, ...]
    observations: tuple[Observation, ...]
    method: Method
    stopping: Stopping
    seed: int | None
    weighting: Weighting | None = None
    limits: Limits = field(default_factory=Limits)
    failures: Failures = field(default_factory=Failures)
    warm_start: tuple[str, ...] = ()
    priority: int = 0
    index_properties: IndexSection | None = None
    accept: tuple[str, ...] = ()
    answer: Answering = field(default_factory=Answering)
    noise: NoiseSection | None = None
    free: tuple[FreeParameter, ...] = field(init=False)
    free_names: tuple[str, ...] = field(init=False)
    _template: dict[str, float] = field(init=False, repr=False)
    _links: tuple[LinkedParameter, ...] = field(init=False, repr=False)
    _link_limits: tuple[tuple[str, ParameterInfo], ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        free = tuple(p for p in self.parameters.values() if isinstance(p, FreeParameter))
        links, _ = link_order(self.parameters)
        template = {
            name: float(p.value) if isinstance(p, FixedParameter) else math.nan for name, p in self.parameters.items()
        }
        infos = {info.name: info for info in self.model.parameters}
        limits = tuple((link.name, infos[link.name]) for link in links if link.name in infos)
        derived = {
            "free": free,
            "free_names": tuple(p.name for p in free),
            "_template": template,
            "_links": links,
            "_link_limits": limits,
        }
        for name, value in derived.items():
            object.__setattr__(self, name, value)

    @property
    def answers(self) -> bool:
        """Whether the runs that its result needs follow the search."""
        if self.method.role != "search" or self.answer.max_evaluations == "off":
            return False
        return self.counted_points >= len(self.free) and not all(p.integer for p in self.free)

    def noise_of(self, series: str) -> Literal["white", "correlated"] | None:
        """What the problem states of the errors of a series; None where it says nothing of it."""
        if self.noise is None or (self.noise.series and series not in self.noise.series):
            return None
        return self.noise.kind

    @property
    def counted_points(self) -> int:
        """Number of measured points that take part: weights of point and series above 0."""
        return sum(int((o.point_weights > 0).sum()) for o in self.observations if o.weight > 0)

    @property
    def series_by_test(self) -> tuple[tuple[str, int], ...]:
        """Name of the test and number of points of each series; the name is empty where none of its points counts."""
        return tuple(
            (test_of(self.forward_model, o.series) if o.weight > 0 and (o.point_weights > 0).any() else "", o.y.size)
            for o in self.observations
        )

    @property
    def planned_evaluations(self) -> int | None:
        """Maximum number of evaluations of a job; None if it is unlimited."""
        limit = self.stopping.max_evaluations
        planned = self.method.planned(len(self.free))
        return min((n for n in (limit, planned) if n is not None), default=None)

    def left_to_answer(self, limit: int) -> int:
        """Return how many of these evaluations the search leaves to the runs after it."""
        return self.answer.share_of(limit, len(self.free), learns=self.method.learns) if self.answers else 0

    def values(self, free_values: Sequence[float]) -> dict[str, float]:
        """Values of all parameters, in the order of the problem file.

        Parameters
        ----------
        free_values
            Values of the free parameters in the order of :attr:`free_names`, length d.

        Raises
        ------
        ValueError
            The number of values is not that of the free parameters.
        """
        values = self._template.copy()
        values.update(zip(self.free_names, map(float, free_values), strict=True))
        for link in self._links:
            values[link.name] = link.expression.value(values)  # type: ignore[assignment]  # numbers in, number out
        return values

    def at_bounds(self, values: Mapping[str, float]) -> dict[str, Bound]:
        """Free parameters that lie at a bound of their range, with that bound; ``values`` has all parameters."""
        bounds = {parameter.name: parameter.bound_at(values[parameter.name]) for parameter in self.free}
        return {name: bound for name, bound in bounds.items() if bound is not None}

    def satisfies(self, values: Mapping[str, float]) -> bool:
        """Whether values of all parameters are admissible.

        They are if all are finite, every constraint holds (one over an undefined value does not), linked ones are
        within the model's limits, and the forward model accepts them.
        """
        if not all(map(math.isfinite, values.values())):
            return False
        for constraint in self.constraints:
            if not constraint.value(values):
                return False
        for name, info in self._link_limits:
            if limit_mistake(values[name], info) is not None:
                return False
        return self.model.check(values) is None

    def document(self) -> dict[str, Any]:
        """The canonical document: plain JSON values, defaults written out, files inlined.

        ``parse_problem(problem.document())`` gives an equal problem.
        """
        document: dict[str, Any] = {
            "name": self.name,
            "forward_model": self.forward_model.model_dump(mode="json"),
            "parameters": {name: _section(parameter) for name, parameter in self.parameters.items()},
            "constraints": [constraint.text for constraint in self.constraints],
            "observations": [observation.document() for observation in self.observations],
            "method": self.method.model_dump(mode="json", exclude_none=True),
            "stopping": self.stopping.model_dump(mode="json", exclude_none=True),
        }
        if self.warm_start:
            document["warm_start"] = {"jobs": list(self.warm_start)}
        if self.index_properties is not None:
            document["index_properties"] = self.index_properties.model_dump(mode="json", exclude_defaults=True)
        if self.weighting is not None:
            document["weighting"] = self.weighting
        if self.noise is not None:
            document["noise"] = self.noise.model_dump(mode="json", exclude_defaults=True)
        if self.accept:
            document["accept"] = list(self.accept)
        if self.seed is not None:
            document["seed"] = self.seed
        # left out when there is nothing in them: older programs read it, too
        for name in ("limits", "failures", "answer"):
            section = getattr(self, name).model_dump(mode="json", exclude_defaults=True)
            if section:
                document[name] = section
        return document | {"priority": self.priority} if self.priority else document

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Problem) and other.document() == self.document()

    def __hash__(self) -> int:
        return hash((self.name, self.free_names, self.seed))


def _section(parameter: Parameter) -> dict[str, Any]:
    if isinstance(parameter, FixedParameter):
        return {"value": parameter.value}
    if isinstance(parameter, LinkedParameter):
        return {"expression": parameter.expression.text}
    section: dict[str, Any] = {"lower": parameter.lower, "upper": parameter.upper, "scale": parameter.scale}
    if parameter.integer:
        section["integer"] = True
    return section if parameter.initial is None else section | {"initial": parameter.initial}
