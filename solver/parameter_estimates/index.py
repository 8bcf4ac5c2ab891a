"""What index properties of the soil let expect of the parameters of a problem."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from geoswarm.solver.forward.base import ForwardModel, ForwardModelSpec
from geoswarm.solver.forward.combined import parts_of
from geoswarm.solver.index_properties import IndexProperties
from geoswarm.solver.laws.base import Law
from geoswarm.solver.laws.terms import Term
from geoswarm.solver.parameter_estimates.correlations import Correlated, correlated
from geoswarm.solver.problem import FixedParameter, Problem

__all__ = [
    "ParameterEstimate",
    "TestOfLaw",
    "estimates_of",
    "full_name",
    "index_document",
    "index_estimates",
    "layers_of",
    "name_among",
    "soils_of",
    "soil_of",
    "fixed_values",
    "term_known",
    "with_index",
]

_CONFINED = ("oedometer", "consolidation", "crs_oedometer")
_OWN = ("C_k", "e_d0", "e_c0", "e_i0")
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
    layer: str = ""
    """Name that its parameters have before them, where it is a soil of layered ground."""
    index: IndexProperties | None = None
    """What is known of that soil."""

    def named(self, name: str) -> str:
        """A parameter of the law under the name that the forward model has for it."""
        return f"{self.layer}.{name}" if self.layer else name

    def own(self, values: Mapping[str, float]) -> dict[str, float]:
        """Values under the names of the law beside those that are given: of the layer, and for this test alone."""
        found = dict(values)
        for start in (f"{self.layer}.", f"{self.part}.", f"{self.part}.{self.layer}."):
            found |= {name.removeprefix(start): value for name, value in values.items() if name.startswith(start)}
        return found


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
    correlated
        The correlation with its own value.
    quantity, quantity_value
        What was translated: Cα where the correlation gives Cα/Cc.
    """

    parameter: str
    symbol: str
    unit: str
    value: float
    ends: tuple[float, float] | None
    correlated: Correlated
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


def layers_of(spec: ForwardModelSpec, model: ForwardModel) -> tuple[TestOfLaw, ...]:
    """Soils of layered ground, each with its law, as a test of it."""
    if spec.runs_outside:
        return ()
    found = []
    for part in parts_of(spec, model):
        names = [info.name for info in part.model.parameters]
        for layer, index in part.spec.index_properties_of_soils.items():
            soil: Any = part.spec.soils[layer]  # type: ignore[attr-defined]  # index properties belong to soils
            start = f"{layer}."
            own = tuple(name.removeprefix(start) for name in names if name.startswith(start))
            found.append(
                TestOfLaw(part.name, part.spec, soil.law, soil.initial_void_ratio, own, layer=layer, index=index)
            )
    return tuple(found)


def with_index(
    spec: ForwardModelSpec, model: ForwardModel, soil: IndexProperties | None
) -> Iterator[tuple[TestOfLaw, IndexProperties]]:
    """Tests whose index properties are known: those of the problem, or of a layer its own."""
    if soil is not None:
        yield from ((test, soil) for test in soils_of(spec, model))
    yield from ((test, test.index) for test in layers_of(spec, model) if test.index is not None)


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
    """What the index properties suggest of the parameters of a test's law.

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
    for one, quantity, value, ends in _quantities(soil, known):
        if quantity in _OWN and quantity in test.parameters:
            found.append(ParameterEstimate(quantity, quantity, "", value, ends, one, quantity, value))
        for term in test.law.terms:
            if not _same(term, quantity) or (term.voids and "e_0" not in known):
                continue
            info = infos[term.parameter]
            back = [term.back(end, known) for end in ends or ()]
            own = info.symbol, info.unit, term.back(value, known), (min(back), max(back)) if back else None
            found.append(ParameterEstimate(term.parameter, *own, one, quantity, value))
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
    soil, fixed = soil_of(problem), fixed_values(problem)
    found: dict[tuple[str, str], ParameterEstimate] = {}
    for test, known in with_index(problem.forward_model, problem.model, soil):
        for one in index_estimates(test, test.own(fixed), known):
            name = full_name(problem, test, one.parameter)
            found.setdefault((name, one.correlated.correlation.equation), replace(one, parameter=name))
    return tuple(found.values())


def soil_of(problem: Problem) -> IndexProperties | None:
    """What is known of the soil by index tests."""
    return None if problem.index_properties is None else problem.index_properties.properties()


def fixed_values(problem: Problem) -> dict[str, float]:
    """Parameters that the problem gives a value."""
    return {name: p.value for name, p in problem.parameters.items() if isinstance(p, FixedParameter)}


def full_name(problem: Problem, test: TestOfLaw, name: str) -> str:
    """Name of a test's parameter in its problem: that for the test alone where there is one, else the shared one."""
    return name_among(problem.parameters, test, name)


def name_among(names: Collection[str], test: TestOfLaw, name: str) -> str:
    """The same among names of parameters."""
    own = f"{test.part}.{test.named(name)}"
    return own if own in names else test.named(name)


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
            "equation": one.correlated.correlation.equation,
            "soils": one.correlated.correlation.soils,
            "source": one.correlated.correlation.source,
            "outside": one.correlated.outside,
        }
        for one in estimates
    ]
