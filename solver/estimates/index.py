"""What index properties of the soil let expect of the parameters of a problem."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from geoswarm.solver.correlations.catalogue import correlated
from geoswarm.solver.correlations.correlation import Correlated
from geoswarm.solver.correlations.properties import IndexProperties
from geoswarm.solver.forward.base import ForwardModel, ForwardModelSpec
from geoswarm.solver.forward.combined import parts_of
from geoswarm.solver.laws.base import Law
from geoswarm.solver.laws.terms import Term
from geoswarm.solver.problem import FixedParameter, Problem

__all__ = [
    "ParameterEstimate",
    "TestOfLaw",
    "estimates_of",
    "full_name",
    "index_document",
    "index_estimates",
    "soils_of",
    "term_known",
]

_CONFINED = ("oedometer", "consolidation", "crs_oedometer")
_OWN = ("C_k",)
"""Quantities that are parameters of their own name, of whatever law."""


@dataclass(frozen=True, slots=True)
class TestOfLaw:
    """A test of a problem with its law; ``part`` is its name in a combined model, empty otherwise."""

    __test__ = False

    part: str
    spec: ForwardModelSpec
    law: Law
    void_ratio: float | None
    parameters: tuple[str, ...]
    """All that the test knows, those of the flow of water, too."""
    confined: bool = False
    """Whether a ring holds the side, as in the oedometer."""


@dataclass(frozen=True, slots=True)
class ParameterEstimate:
    """What a correlation lets expect of one parameter.

    Parameters
    ----------
    parameter, symbol, unit
        Parameter of the law.
    value
        In its unit.
    ends
        The same with the published scatter of the correlation, in rising order; None: none is published.
    told
        The correlation with its own value.
    quantity, quantity_value
        What was translated: Cα where the correlation gives Cα/Cc.
    """

    parameter: str
    symbol: str
    unit: str
    value: float
    ends: tuple[float, float] | None
    told: Correlated
    quantity: str
    quantity_value: float


def soils_of(spec: ForwardModelSpec, model: ForwardModel) -> tuple[TestOfLaw, ...]:
    """The tests of a model that have one law, in which correlations and readings have terms."""
    if spec.runs_outside:
        return ()
    found = []
    for part in parts_of(spec, model):
        law: Any = getattr(part.model, "law", None)
        if isinstance(law, Law):
            voids: float | None = getattr(part.spec, "initial_void_ratio", None)
            names = tuple(info.name for info in part.model.parameters)
            confined = part.spec.kind in _CONFINED
            found.append(TestOfLaw(part.name, part.spec, law, voids, names, confined))
    return tuple(found)


def term_known(test: TestOfLaw, values: Mapping[str, float], soil: IndexProperties | None) -> dict[str, float]:
    """What terms may look at: parameters as far as they are known, defaults, and ``e_0``.

    The void ratio is that of the test, else the parameter e0, else that of the index properties.
    """
    defaults = {info.name: info.default for info in test.law.parameters if info.default is not None}
    known = {**defaults, **values}
    voids = test.void_ratio or known.get("e0") or (None if soil is None else soil.voids)
    return known | ({} if voids is None else {"e_0": voids})


def index_estimates(
    test: TestOfLaw, values: Mapping[str, float], soil: IndexProperties
) -> tuple[ParameterEstimate, ...]:
    """What the index properties let expect of the parameters of a test's law.

    Parameters
    ----------
    values
        Parameters that are known, such as fixed ones.
    """
    if soil.voids is None and (test.void_ratio or values.get("e0")):
        soil = replace(soil, void_ratio=test.void_ratio or values["e0"])
    known = term_known(test, values, soil)
    infos = {info.name: info for info in test.law.parameters}
    found = []
    for told, quantity, value, ends in _quantities(soil, known):
        if quantity in _OWN and quantity in test.parameters:
            found.append(ParameterEstimate(quantity, quantity, "", value, ends, told, quantity, value))
        for term in test.law.terms:
            if not _same(term, quantity) or (term.voids and "e_0" not in known):
                continue
            info = infos[term.parameter]
            both = None if ends is None else sorted(term.back(end, known) for end in ends)
            found.append(
                ParameterEstimate(
                    term.parameter,
                    info.symbol,
                    info.unit,
                    term.back(value, known),
                    None if both is None else (both[0], both[1]),
                    told,
                    quantity,
                    value,
                )
            )
    return tuple(found)


def _same(term: Term, quantity: str) -> bool:
    """A friction angle by the plasticity is that of the critical state, which is also the one without dilatancy."""
    return term.quantity == quantity or (quantity, term.quantity) == ("φ", "φ_cs")


def _quantities(
    soil: IndexProperties, known: Mapping[str, float]
) -> Iterator[tuple[Correlated, str, float, tuple[float, float] | None]]:
    """Correlations with the quantity that they stand for, its value and its ends."""
    everything = [one for one in correlated(soil) if one.value > 0.0]
    indices = sorted(one.value for one in everything if one.correlation.quantity == "Cc")
    middle = indices[len(indices) // 2] if indices else None
    for one in everything:
        quantity, factor = one.correlation.quantity, 1.0
        if quantity == "Cα/Cc":
            if middle is None:
                continue
            quantity, factor = "Cα", middle
        elif quantity == "Cα/(1 + e₀)":
            if "e_0" not in known:
                continue
            quantity, factor = "Cα", 1.0 + known["e_0"]
        ends = None if one.ends is None else (factor * one.ends[0], factor * one.ends[1])
        yield one, quantity, factor * one.value, ends


def estimates_of(problem: Problem) -> tuple[ParameterEstimate, ...]:
    """What the index properties of a problem let expect of its parameters, under the names that the problem uses."""
    if problem.index_properties is None:
        return ()
    soil = problem.index_properties.properties()
    fixed = {name: p.value for name, p in problem.parameters.items() if isinstance(p, FixedParameter)}
    found: dict[tuple[str, str], ParameterEstimate] = {}
    for test in soils_of(problem.forward_model, problem.model):
        own = fixed | {name.removeprefix(f"{test.part}."): value for name, value in fixed.items()}
        for one in index_estimates(test, own, soil):
            name = full_name(problem, test, one.parameter)
            found.setdefault((name, one.told.correlation.equation), replace(one, parameter=name))
    return tuple(found.values())


def full_name(problem: Problem, test: TestOfLaw, name: str) -> str:
    """Name of a test's parameter in its problem: that for the test alone where there is one, else the shared one."""
    own = f"{test.part}.{name}"
    return own if own in problem.parameters else name


def index_document(estimates: Iterable[ParameterEstimate]) -> list[dict[str, Any]]:
    """Return estimates as plain JSON."""
    return [
        {
            "parameter": one.parameter,
            "unit": one.unit,
            "value": one.value,
            "ends": one.ends,
            "quantity": one.quantity,
            "quantity_value": one.quantity_value,
            "equation": one.told.correlation.equation,
            "soils": one.told.correlation.soils,
            "source": one.told.correlation.source,
            "outside": one.told.outside,
        }
        for one in estimates
    ]
