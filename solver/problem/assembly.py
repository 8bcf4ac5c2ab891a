"""From a document to a checked problem: first each section on its own, so that all mistakes are reported together."""

from __future__ import annotations

import copyreg
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

from pydantic import BaseModel, ValidationError

from geoswarm.solver.errors import ExpressionError, Issue, ProblemError, SolverError
from geoswarm.solver.expressions import Expression
from geoswarm.solver.forward.base import ForwardModel, ForwardModelSpec
from geoswarm.solver.forward.formula import FormulaModel
from geoswarm.solver.forward.registry import PROGRAMS_REFUSED, built, find_spec, parse_spec
from geoswarm.solver.index_properties import IndexSection
from geoswarm.solver.methods.base import Method
from geoswarm.solver.methods.registry import UnknownMethodError, find_method, kinds
from geoswarm.solver.problem.checks.extremes import extreme_issues
from geoswarm.solver.problem.checks.feasibility import estimates_in_conflict, infeasibility
from geoswarm.solver.problem.checks.sizes import point_issues, size_issues
from geoswarm.solver.problem.issues import describe, issues_of, validated
from geoswarm.solver.problem.observation_section import ObservationSection
from geoswarm.solver.problem.observations import Observation, build_observations, preparation_issues
from geoswarm.solver.problem.parameters import (
    FixedParameter,
    FreeParameter,
    LinkedParameter,
    Parameter,
    build_parameter,
    check_against_model,
    link_order,
    parse_known,
)
from geoswarm.solver.problem.points import Points, read_points
from geoswarm.solver.problem.problem import Problem
from geoswarm.solver.problem.running import Answering, Failures, Limits
from geoswarm.solver.problem.sections import (
    PARAMETER_FORMS,
    ParameterSection,
    ProblemFile,
    Settings,
    Stopping,
    WarmStart,
)
from geoswarm.solver.problem.test_table.expansion import without_table
from geoswarm.solver.problem.text.reading import plain_document, read_problem_file
from geoswarm.solver.problem.weighting import scheme_factors
from geoswarm.solver.words import did_you_mean

__all__ = ["load_problem", "parse_problem"]

Completed: TypeAlias = Callable[[dict[str, Any]], dict[str, Any]] | None
Model = TypeVar("Model", bound=BaseModel)

_MOST_PARAMETERS = 100
_MOST_OBSERVATIONS = 1000
_MOST_ISSUES = 100
_FORMS = (
    "must have either lower and upper (free; also scale, initial, integer), or value (fixed), or expression (linked)"
)
_SETTINGS = tuple(Settings.model_fields)


def parse_problem(document: Mapping[str, Any], *, programs: bool = False, completed: Completed = None) -> Problem:
    """Check a document and build its problem; files are refused, points must be inlined.

    Parameters
    ----------
    document
        As in a problem file; NumPy arrays and tuples are accepted for lists.
    programs
        Whether its forward model may start programs of this machine: True for what a user of this machine has written,
        or was made of a problem that had been accepted so; never for what came over the network.
    completed
        Adds what is missing, once a table of tests is parts and observations.

    Raises
    ------
    ProblemError
        Lists every mistake with its path.
    """
    with without_table(plain_document(document), None) as plain:
        return _Assembly(plain if completed is None else completed(plain), None, programs).problem()


def load_problem(path: str | Path, completed: Completed = None) -> Problem:
    """Read a YAML or JSON problem file, and the CSV files beside it that its observations name.

    A problem without a name is named after its file; ``completed``: as for :func:`parse_problem`.

    Raises
    ------
    ProblemError
        Lists every mistake with its path.

    Examples
    --------
    >>> from pathlib import Path
    >>> import geoswarm as gs
    >>> model = "forward_model: {kind: formula, series: {y: {expression: a * x}}}"
    >>> data = "observations: [{series: y, points: {x: [1], y: [2]}}], stopping: {max_evaluations: 20}"
    >>> _ = Path("line.yaml").write_text(f"{{{model}, parameters: {{a: {{lower: 0, upper: 9}}}}, {data}}}")
    >>> gs.load_problem("line.yaml").free_names
    ('a',)
    """
    path = Path(path)
    with without_table({"name": path.stem, **read_problem_file(path)}, path.parent) as plain:
        problem = _Assembly(plain if completed is None else completed(plain), path.parent, programs=True).problem()
        if extreme := extreme_issues(problem):
            raise ProblemError(extreme)
    return problem


# Compiled expressions and models need not travel to other processes: the document says it all.
copyreg.pickle(Problem, lambda problem: (_parsed_again, (problem.document(), problem.forward_model.runs_programs)))


def _parsed_again(document: Mapping[str, Any], programs: bool) -> Problem:
    return parse_problem(document, programs=programs)


@dataclass
class _Assembly:
    document: dict[str, Any]
    folder: Path | None
    programs: bool
    issues: list[Issue] = field(default_factory=list)

    def problem(self) -> Problem:
        self._unknown_sections()
        given = {key: self.document[key] for key in _SETTINGS if key in self.document}
        settings = self._validated(Settings, given, "")
        spec, model = self._forward_model()
        parameters, complete = self._parameters()
        constraints = self._constraints(settings, parameters, complete)
        observations = self._weighted(settings, spec, self._observations(spec, model))
        model = self._with_inputs(model, observations)
        if model is not None and parameters:
            declared = self.document["parameters"]
            self.issues += check_against_model(parameters, declared, model, self._kind)
        links, circles = link_order(parameters)
        self.issues += circles
        if complete and not circles:
            self._check_known_values(parameters, links, constraints, model)
        method = self._method()
        stopping = self._validated(Stopping, self.document.get("stopping", {}), "stopping")
        if method is not None and stopping is not None:
            self.issues += method.stopping_issues(stopping)
        limits = self._validated(Limits, self.document.get("limits", {}), "limits")
        failures = self._validated(Failures, self.document.get("failures", {}), "failures")
        answer = self._validated(Answering, self.document.get("answer", {}), "answer")
        index = self.document.get("index_properties")
        known = None if index is None else self._validated(IndexSection, index, "index_properties")
        warm_start = self._warm_start(method)
        if self.issues or not (settings and spec and model and method and stopping and limits and failures and answer):
            raise ProblemError(self._sorted_issues())
        problem = Problem(
            name=settings.name,
            forward_model=spec,
            model=model,
            parameters=parameters,
            constraints=constraints,
            observations=observations,
            method=method,
            stopping=stopping,
            seed=settings.seed,
            weighting=settings.weighting,
            limits=limits,
            failures=failures,
            answer=answer,
            warm_start=warm_start,
            priority=settings.priority,
            index_properties=known,
            accept=tuple(settings.accept),
            noise=settings.noise,
        )
        unsatisfiable = (
            size_issues(problem)
            or infeasibility(problem)
            or estimates_in_conflict(problem)
            or problem.method.issues(problem)
        )
        if unsatisfiable:
            raise ProblemError(unsatisfiable)
        return problem

    def _report(self, path: str, message: str) -> None:
        self.issues.append(Issue(path, message))

    def _sorted_issues(self) -> list[Issue]:
        order = {section: place for place, section in enumerate(self.document)}

        def place(issue: Issue) -> int:
            return order.get(issue.path.partition(".")[0].partition("[")[0], len(order))

        issues = sorted(dict.fromkeys(self.issues), key=place)
        more = len(issues) - _MOST_ISSUES
        return [*issues[:_MOST_ISSUES], Issue("", f"{more} more mistakes")] if more > 0 else issues

    def _validated(self, model: type[Model], section: Any, path: str) -> Model | None:
        built, found = validated(model, section, path)
        self.issues += found
        return built

    def _unknown_sections(self) -> None:
        known = ProblemFile.model_fields
        unknown = [key for key in self.document if key not in known]
        for key in unknown[:_MOST_ISSUES]:
            self._report(key, f"unknown key{did_you_mean(key, known)}; accepted: {', '.join(known)}")
        if len(unknown) > _MOST_ISSUES:
            self._report("", f"{len(unknown) - _MOST_ISSUES} more unknown keys")
        for key, info in known.items():
            if info.is_required() and key not in self.document:
                self._report(key, "is missing")

    @property
    def _kind(self) -> str:
        return str(self.document["forward_model"]["kind"])

    def _forward_model(self) -> tuple[ForwardModelSpec | None, ForwardModel | None]:
        section = self.document.get("forward_model")
        if "forward_model" not in self.document:
            return None, None
        try:
            spec = parse_spec(section)
        except ValidationError as error:
            # Only an unknown key asks for the schema, and then the kind has been found.
            self.issues += issues_of(error, section, "forward_model", lambda: find_spec(self._kind).model_json_schema())
            return None, None
        if spec.runs_programs and not self.programs:
            self._report("forward_model", PROGRAMS_REFUSED)
            return spec, None
        try:
            spec = spec.with_files(self.folder, "forward_model")
        except ProblemError as error:
            self.issues += error.issues
            return spec, None
        try:
            return spec, built(spec)
        except ProblemError as error:
            self.issues += error.issues
            return spec, None
        except (SolverError, ValueError) as error:
            self._report("forward_model", str(error))
            return spec, None

    def _mapping(self, key: str, most: int) -> dict[str, Any]:
        section = self.document.get(key, {})
        if not isinstance(section, dict) or (key in self.document and not section):
            self._report(key, f"must be a mapping of names, got {describe(section)}")
            return {}
        if len(section) > most:
            self._report(key, f"has {len(section)} entries; at most {most} are accepted")
            return {}
        return section

    def _parameters(self) -> tuple[dict[str, Parameter], bool]:
        """Parameters that could be built, and whether these are all."""
        sections = self._mapping("parameters", _MOST_PARAMETERS)
        before = len(self.issues)
        parameters: dict[str, Parameter] = {}
        for name, section in sections.items():
            path = f"parameters.{name}"
            form = self._form(section, path)
            if form is None:
                continue
            checked = self._validated(form, section, path)
            if checked is None:
                continue
            parameter, found = build_parameter(name, checked, sections)
            self.issues += found
            if parameter is not None:
                parameters[name] = parameter
        complete = bool(sections) and len(self.issues) == before
        if complete and not any(isinstance(p, FreeParameter) for p in parameters.values()):
            self._report("parameters", "none is free; give at least one of them a lower and an upper bound")
        return parameters, complete

    def _form(self, section: Any, path: str) -> type[ParameterSection] | None:
        if not isinstance(section, dict):
            hint = f"; write {{value: {describe(section)}}}" if isinstance(section, int | float) else ""
            self._report(path, f"{_FORMS}, got {describe(section)}{hint}")
            return None
        forms = [form for form in PARAMETER_FORMS.values() if not form.model_fields.keys().isdisjoint(section)]
        if len(forms) == 1:
            return forms[0]
        self._report(path, f"{_FORMS}, got {describe(section)}")
        return None

    def _constraints(
        self, settings: Settings | None, parameters: dict[str, Parameter], complete: bool
    ) -> tuple[Expression, ...]:
        constraints = []
        names = parameters if complete else self.document.get("parameters")
        for index, text in enumerate(settings.constraints if settings else ()):
            path = f"constraints[{index}]"
            try:
                expression = parse_known(text, names if isinstance(names, dict) else {})
            except ExpressionError as error:
                self._report(path, str(error))
                continue
            if not expression.is_comparison:
                self._report(
                    path, f"'{expression.text}' is not a comparison; write for example lambda_star > kappa_star"
                )
            constraints.append(expression)
        return tuple(constraints)

    def _observations(self, spec: ForwardModelSpec | None, model: ForwardModel | None) -> tuple[Observation, ...]:
        sections = self.document.get("observations", [])
        if not isinstance(sections, list) or not 1 <= len(sections) <= _MOST_OBSERVATIONS:
            if "observations" in self.document:
                given = describe(sections)
                self._report("observations", f"must be a list of 1 to {_MOST_OBSERVATIONS} observations, got {given}")
            return ()
        complete: list[tuple[str, ObservationSection, Points]] = []
        for index, section in enumerate(sections):
            if len(self.issues) > _MOST_ISSUES:  # more are not read, and each takes time to put into words
                break
            path = f"observations[{index}]"
            checked = self._validated(ObservationSection, section, path)
            if checked is None:
                continue
            points, found = read_points(checked, path, self.folder, spec)
            self.issues += found
            if points is not None and not found:
                complete.append((path, checked, points))
        too_many = point_issues(len(points.x) for _, _, points in complete)
        self.issues += too_many
        if model is None or spec is None or too_many:
            return ()
        observations, found = build_observations(complete, model, spec)
        self.issues += found or preparation_issues(model, observations)
        return observations

    def _with_inputs(self, model: ForwardModel | None, observations: tuple[Observation, ...]) -> ForwardModel | None:
        """The model that knows what else was measured at the points, if anything was."""
        inputs = {o.series: (o.x, o.inputs) for o in observations if o.inputs}
        if not inputs:
            return model
        if not isinstance(model, FormulaModel):
            self._report("observations", f"inputs are for kind: formula; a model of kind {self._kind} uses none")
            return model
        declared = self.document.get("parameters")
        for name in sorted({name for _, given in inputs.values() for name in given}):
            if isinstance(declared, dict) and name in declared:
                self._report(f"parameters.{name}", "is an input of an observation; a name can only be one of the two")
        try:
            return model.with_inputs(inputs)
        except ValueError as error:
            self._report("observations", str(error))
            return model

    def _weighted(
        self, settings: Settings | None, spec: ForwardModelSpec | None, observations: tuple[Observation, ...]
    ) -> tuple[Observation, ...]:
        """Multiply the weights by those of the scheme, if there is one."""
        if settings is None or settings.weighting is None or spec is None or not observations:
            return observations
        errors = {o.series: o.error for o in observations if o.error is not None}
        if settings.weighting == "by_error" and len(errors) < len(observations):
            missing = ", ".join(o.series for o in observations if o.error is None)
            self._report("weighting", f"by_error needs the error of every observation; it is missing for {missing}")
            return observations
        factors = scheme_factors(settings.weighting, observations, spec, errors)
        return tuple(replace(o, weight=o.weight * factors[o.series]) for o in observations)

    def _check_known_values(
        self,
        parameters: dict[str, Parameter],
        links: tuple[LinkedParameter, ...],
        constraints: tuple[Expression, ...],
        model: ForwardModel | None,
    ) -> None:
        """Judge what is known before anything runs: fixed values and what follows from them alone."""
        known: dict[str, float] = {p.name: p.value for p in parameters.values() if isinstance(p, FixedParameter)}
        for link in links:
            if link.expression.names <= known.keys():
                value = float(link.expression.value(known))
                known[link.name] = value
                if not math.isfinite(value):
                    self._report(f"parameters.{link.name}.expression", f"'{link.expression.text}' has no finite value")
        self.issues += [
            Issue(f"constraints[{index}]", f"'{constraint.text}' does not hold for the fixed values")
            for index, constraint in enumerate(constraints)
            if constraint.is_comparison and constraint.names <= known.keys() and not constraint.value(known)
        ]
        # Single values outside their limits are reported by then; the model judges their combination.
        if model is not None and not any(issue.path.startswith("parameters") for issue in self.issues):
            message = model.check(known)
            if message is not None:
                self._report("parameters", message)

    def _method(self) -> Method | None:
        section = self.document.get("method", {"kind": "particle_swarm"})
        kind = section.get("kind") if isinstance(section, dict) else None
        if not isinstance(section, dict):
            self._report("method", f"must be a mapping with a kind of {', '.join(kinds())}, got {describe(section)}")
        elif not isinstance(kind, str) or kind not in kinds():
            given = "is missing" if "kind" not in section else f"unknown kind {describe(kind).removeprefix('text ')}"
            hint = did_you_mean(kind, kinds()) if isinstance(kind, str) else ""
            self._report("method.kind", f"{given}{hint}; known: {', '.join(kinds())}")
        else:
            try:
                return self._validated(find_method(kind), section, "method")
            except UnknownMethodError as error:  # installed, but broken
                self._report("method.kind", str(error))
        return None

    def _warm_start(self, method: Method | None) -> tuple[str, ...]:
        if self.document.get("warm_start") is None:
            return ()
        section = self._validated(WarmStart, self.document["warm_start"], "warm_start")
        if method is not None and not method.takes_offers:
            self._report("warm_start", "needs method particle_swarm with acceleration: response_surface")
        return tuple(section.jobs) if section else ()
