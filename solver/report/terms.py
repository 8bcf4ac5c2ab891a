"""Identified parameters of any law in the laboratory's terms, as the law declares them."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from geoswarm.solver.identifiability import Linearisation
from geoswarm.solver.laws.terms import Term
from geoswarm.solver.parameter_estimates.index import TestOfLaw, full_name, soil_of, soils_of, term_known
from geoswarm.solver.problem import FixedParameter, Problem
from geoswarm.solver.report.laboratory import LaboratoryValue, interval_of, laboratory_values

__all__ = ["values_in_terms"]


def values_in_terms(
    problem: Problem,
    values: Mapping[str, float],
    linearisation: Linearisation | None,
    beside: Collection[str] = (),
) -> tuple[LaboratoryValue, ...]:
    """Give the parameters of all laboratory tests in the laboratory's terms.

    Those of :func:`geoswarm.solver.report.laboratory.laboratory_values`, and what else the laws declare.

    Parameters
    ----------
    values, linearisation
        Value of every parameter, and what gives the intervals.
    beside
        Symbols with something beside them. They are shown in any case; others where the parameter is not fixed and has
        another name in the laboratory.
    """
    found = list(laboratory_values(problem, values, linearisation))
    seen = {(one.part, one.symbol) for one in found}
    told: set[tuple[str, str]] = set()
    for test in soils_of(problem.forward_model, problem.model):
        for term in test.law.terms:
            one = _value(problem, test, term, values, linearisation, beside)
            if one is None or (test.part, one.symbol) in seen or (term.quantity, term.parameter) in told:
                continue
            name = full_name(problem, test, term.parameter)
            if name == term.parameter:  # shared by all tests: told once
                told.add((term.quantity, term.parameter))
            elsewhere = any(symbol.partition("/")[0] == term.quantity for part, symbol in seen if part == test.part)
            if not elsewhere:
                found.append(one)
    return tuple(found)


def _value(
    problem: Problem,
    test: TestOfLaw,
    term: Term,
    values: Mapping[str, float],
    linearisation: Linearisation | None,
    beside: Collection[str],
) -> LaboratoryValue | None:
    name = full_name(problem, test, term.parameter)
    parameter = problem.parameters.get(name)
    fixed = parameter is None or isinstance(parameter, FixedParameter)
    plain = term.relation == term.quantity  # the table of parameters has it
    if (fixed or plain) and term.quantity not in beside:
        return None
    soil = soil_of(problem)

    def quantity(given: Mapping[str, float]) -> float:
        own = {key.removeprefix(f"{test.part}."): value for key, value in given.items()}
        return term.of(term_known(test, dict(given) | own, soil))

    known = term_known(test, values, soil)
    if term.voids and "e_0" not in known:
        return None
    if term.parameter in test.law.derived and not known.get(term.parameter):
        return None
    value = quantity(values)
    interval = None
    if linearisation is not None and not fixed and value > 0.0:
        interval = interval_of(problem, quantity, linearisation)
    part = test.part if name != term.parameter or _differs(problem, test) else ""
    return LaboratoryValue(part, term.quantity, term.name, term.unit, value, interval, _relation(term))


def _differs(problem: Problem, test: TestOfLaw) -> bool:
    """Whether the laws of a problem's tests differ, so that a value belongs to one of them."""
    kinds = {one.law.kind for one in soils_of(problem.forward_model, problem.model)}
    return bool(test.part) and len(kinds) > 1


def _relation(term: Term) -> str:
    return "" if term.relation == term.quantity else term.relation
