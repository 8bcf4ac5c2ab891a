"""Parameters of a problem: free, fixed or linked; their names, limits and order of evaluation."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter
from typing import Literal, TypeAlias

from geoswarm.solver.errors import ExpressionError, Issue
from geoswarm.solver.expressions import CONSTANTS, FUNCTIONS, Expression, parse_expression
from geoswarm.solver.forward.base import ForwardModel, ParameterInfo, TellsIncomplete, TellsUnused
from geoswarm.solver.forward.combined import CombinedModel
from geoswarm.solver.problem.issues import number
from geoswarm.solver.problem.sections import FixedSection, FreeSection, LinkedSection, Scale
from geoswarm.solver.words import did_you_mean

__all__ = [
    "Bound",
    "FixedParameter",
    "FreeParameter",
    "LinkedParameter",
    "Parameter",
    "build_parameter",
    "check_against_model",
    "link_order",
    "missing_parameters",
    "limit_mistake",
    "parse_known",
]

_NAME = re.compile(r"[^\W\d]\w*(?:\.[^\W\d]\w*)*")
_MAX_NAME = 100
_NEAR = 1e-6  # of a range: a value so near to its end lies at it
Bound: TypeAlias = Literal["lower", "upper"]
_RESERVED = {"and", "or", "not", *FUNCTIONS, *CONSTANTS}


@dataclass(frozen=True, slots=True)
class FreeParameter:
    """To be identified between ``lower`` and ``upper`` (the parameter's unit), searched on a ``scale``.

    With ``integer`` it takes whole numbers only.
    """

    name: str
    lower: float
    upper: float
    scale: Scale = "linear"
    initial: float | None = None
    integer: bool = False

    def bound_at(self, value: float) -> Bound | None:
        """Return the bound that a value lies at, to a millionth of the range on its scale; else None."""
        place = (value - self.lower) / (self.upper - self.lower)
        if self.scale == "log" and value > 0.0:
            place = math.log(value / self.lower) / math.log(self.upper / self.lower)
        return "lower" if place <= _NEAR else "upper" if place >= 1.0 - _NEAR else None


@dataclass(frozen=True, slots=True)
class FixedParameter:
    """Known ``value`` in the parameter's unit."""

    name: str
    value: float


@dataclass(frozen=True, slots=True)
class LinkedParameter:
    """Follows from other parameters by an ``expression``."""

    name: str
    expression: Expression


Parameter: TypeAlias = FreeParameter | FixedParameter | LinkedParameter


def build_parameter(
    name: str, section: FreeSection | FixedSection | LinkedSection, names: Iterable[str]
) -> tuple[Parameter | None, list[Issue]]:
    """Build a parameter from its section; ``names`` are all names of the problem's parameters."""
    path = f"parameters.{name}"
    issues = [Issue(path, message) for message in _name_mistakes(name)]
    if isinstance(section, FixedSection):
        return FixedParameter(name, section.value), issues
    if isinstance(section, FreeSection):
        issues += _bound_mistakes(path, section)
        return FreeParameter(
            name, section.lower, section.upper, section.scale, section.initial, section.integer
        ), issues
    try:
        expression = parse_known(section.expression, names)
    except ExpressionError as error:
        return None, [*issues, Issue(f"{path}.expression", str(error))]
    if expression.is_comparison:
        message = f"'{expression.text}' is a comparison; a linked parameter needs a number such as 0.5 * lambda_star"
        return None, [*issues, Issue(f"{path}.expression", message)]
    return LinkedParameter(name, expression), issues


def parse_known(text: str, names: Iterable[str]) -> Expression:
    """Parse an expression whose names must all be among ``names``.

    Raises
    ------
    ExpressionError
        It cannot be parsed or names something else.
    """
    expression = parse_expression(text)
    known = list(names)
    unknown = sorted(expression.names.difference(known))
    if unknown:
        hints = "".join(did_you_mean(name, known) for name in unknown[:1])
        raise ExpressionError(
            f"'{expression.text}' uses unknown {', '.join(unknown)}{hints}; known: {', '.join(known)}"
        )
    return expression


def _name_mistakes(name: str) -> list[str]:
    if name in _RESERVED:
        return [f"'{name}' is a word of expressions and cannot name a parameter"]
    if len(name) > _MAX_NAME or not _NAME.fullmatch(name):
        return [f"a parameter's name has letters, digits and _ (at most {_MAX_NAME}), and does not begin with a digit"]
    return []


def _bound_mistakes(path: str, section: FreeSection) -> list[Issue]:
    lower, upper, initial = section.lower, section.upper, section.initial
    issues = []
    if lower >= upper:
        issues.append(Issue(f"{path}.lower", f"must be below upper ({number(upper)}), got {number(lower)}"))
    elif not math.isfinite(upper - lower):
        issues.append(Issue(f"{path}.upper", f"is too far from lower ({number(lower)}); the largest range is 1.79e308"))
    if section.scale == "log":
        issues += [
            Issue(f"{path}.{bound}", f"must be above 0 on a log scale, got {number(value)}")
            for bound, value in (("lower", lower), ("upper", upper))
            if value <= 0
        ]
    if section.integer:
        given = (("lower", lower), ("upper", upper), ("initial", initial))
        issues += [
            Issue(f"{path}.{key}", f"must be a whole number, got {number(value)}")
            for key, value in given
            if value is not None and not value.is_integer()
        ]
    if initial is not None and lower < upper and not lower <= initial <= upper:
        issues.append(
            Issue(
                f"{path}.initial",
                f"must lie between lower {number(lower)} and upper {number(upper)}, got {number(initial)}",
            )
        )
    return issues


def link_order(parameters: Mapping[str, Parameter]) -> tuple[tuple[LinkedParameter, ...], list[Issue]]:
    """Order linked parameters so that each comes after those it needs; an issue for the first circle found."""
    links = {name: p for name, p in parameters.items() if isinstance(p, LinkedParameter)}
    graph = {name: sorted(link.expression.names & links.keys()) for name, link in links.items()}
    try:
        order = tuple(TopologicalSorter(graph).static_order())
    except CycleError as error:
        circle: list[str] = error.args[1][::-1]
        message = f"linked parameters form a circle: {' -> '.join(circle)}; give one of them a value or bounds"
        return (), [Issue(f"parameters.{circle[0]}.expression", message)]
    return tuple(links[name] for name in order), []


def check_against_model(
    parameters: Mapping[str, Parameter], declared: Collection[str], model: ForwardModel, kind: str
) -> list[Issue]:
    """Unknown names, missing names, and values or bounds outside the model's limits.

    ``declared`` are all names of the problem file, also those of parameters that could not be built.
    """
    infos = {info.name: info for info in model.parameters}
    linked_from = {name for p in parameters.values() if isinstance(p, LinkedParameter) for name in p.expression.names}
    issues = []
    for name, parameter in parameters.items():
        if name in infos:
            issues += _limit_issues(parameter, infos[name])
        elif model.open_parameters and name == "x":
            issues.append(Issue("parameters.x", "x is the variable of formulas and cannot name a parameter"))
        elif not model.open_parameters and name not in linked_from and len(parameters) == len(declared):
            # A parameter that the model does not know may still serve linked ones as a helper.
            hint = did_you_mean(name, infos)
            message = f"unknown parameter of forward model {kind}{hint}; known: {', '.join(infos)}"
            issues.append(Issue(f"parameters.{name}", message))
    if isinstance(model, TellsUnused):
        free = [name for name, one in parameters.items() if isinstance(one, FreeParameter) and name not in linked_from]
        issues += [
            Issue(f"parameters.{name}", "is used by no template, and no file of all parameters is written (write)")
            for name in model.unused(free)
        ]
    missing = missing_parameters(model, declared)
    issues += [
        Issue(f"parameters.{info.name}", f"is missing ({_what(info)}); give bounds, a value or an expression")
        for info in missing
    ]
    fault = model.incomplete(declared) if isinstance(model, TellsIncomplete) else None
    return [*issues, Issue("parameters", fault)] if fault else issues


def _what(info: ParameterInfo) -> str:
    what = info.description.rstrip(".")
    return f"{what}, {info.unit}" if info.unit else what


def missing_parameters(model: ForwardModel, declared: Collection[str]) -> list[ParameterInfo]:
    """Parameters that a forward model needs and that are not among those declared."""
    if isinstance(model, CombinedModel):
        return model.missing(declared)
    return [info for info in model.parameters if info.default is None and not info.is_among(declared)]


def _limit_issues(parameter: Parameter, info: ParameterInfo) -> list[Issue]:
    if isinstance(parameter, FreeParameter):
        values = {"lower": parameter.lower, "upper": parameter.upper}
    elif isinstance(parameter, FixedParameter):
        values = {"value": parameter.value}
    else:
        return []
    mistakes = ((key, limit_mistake(value, info)) for key, value in values.items())
    return [Issue(f"parameters.{parameter.name}.{key}", message) for key, message in mistakes if message]


def limit_mistake(value: float, info: ParameterInfo) -> str | None:
    """Why a value violates the model's limits, or None."""
    unit = f" {info.unit}" if info.unit and info.unit != "dimensionless" else ""
    if info.set_by:
        return None if info.admits(value) else f"must be {info.accepted}, got {number(value)}{unit}"
    if info.lower is not None and (value < info.lower or (info.lower_open and value == info.lower)):
        return f"must be {'above' if info.lower_open else 'at least'} {number(info.lower)}{unit}, got {number(value)}"
    if info.upper is not None and (value > info.upper or (info.upper_open and value == info.upper)):
        return f"must be {'below' if info.upper_open else 'at most'} {number(info.upper)}{unit}, got {number(value)}"
    return None
