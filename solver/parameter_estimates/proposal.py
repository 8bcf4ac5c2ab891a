"""Sections of parameters in their usual ranges, and what laws want between parameters."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

from pydantic import ValidationError

from geoswarm.solver.errors import SolverError
from geoswarm.solver.forward.registry import built, parse_spec
from geoswarm.solver.index_properties import IndexSection
from geoswarm.solver.laws.base import Law
from geoswarm.solver.parameter_estimates.classical import classical_values
from geoswarm.solver.parameter_estimates.index import (
    ParameterEstimate,
    TestOfLaw,
    fixed_values,
    full_name,
    index_estimates,
    layers_of,
    name_among,
    soil_of,
    soils_of,
    term_known,
    with_index,
)
from geoswarm.solver.parameter_estimates.law_parameters import (
    alphas_of,
    beta_of,
    compression_moduli_of,
    hardness_of,
    normal_volume_of,
    reference_modulus_of,
    swelling_slope_of,
)
from geoswarm.solver.parameter_estimates.values import ClassicalValue, Estimate
from geoswarm.solver.parameter_info import ParameterInfo
from geoswarm.solver.problem import Draft, FreeParameter, LinkedParameter, Problem

__all__ = [
    "DraftEstimate",
    "Proposed",
    "candidates_of",
    "estimates_of_draft",
    "is_wide",
    "of_correlation",
    "ordered",
    "proposed",
    "usual_section",
    "wanted",
    "with_parameters",
]

_DECADE = 10.0
_LARGER = (("lambda_star", "kappa_star"), ("lambda", "kappa"))
"""Pairs of which the first must be larger."""
_PAIRS = (("M", "phi_cs"), ("N", "e0"), ("nu", "G"), ("E", "G"))
"""Pairs of which laws want one; the first is left out where the second is there, and free otherwise."""


def wanted(law: Law, given: Collection[str]) -> list[str]:
    """Names of a law's parameters that a problem has to give: those without default, and one of each pair.

    ``given``: names that are there anyway.
    """
    infos = {info.name: info for info in law.parameters}
    names = [name for name, info in infos.items() if info.default is None or name in given]
    for first, second in _PAIRS:
        told = law.incomplete(frozenset(names))
        if told is not None and first in told and first in infos and second not in names:
            names.append(first)
    return [name for name in infos if name in names]


def usual_section(info: ParameterInfo) -> dict[str, Any] | None:
    """A free parameter in its usual range, on a log scale where that spans a decade; None without such a range."""
    if info.typical is None:
        return None
    low, high = info.typical
    return {"lower": low, "upper": high} | ({"scale": "log"} if is_wide(low, high) else {})


def ordered(sections: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """Constraints between parameters."""
    found = []
    for name in sections:
        start, _, own = name.rpartition(".")
        for one, other in _LARGER:
            beside = f"{start}.{other}" if start else other
            if own == one and beside in sections:
                found.append(f"{name} > {beside}")
    return found


def is_wide(low: float, high: float) -> bool:
    """Whether a range spans a decade."""
    return low > 0.0 and high >= _DECADE * low


_FACTOR = 2.0
"""Bounds of indices, moduli and permeabilities: this factor beyond the smallest and the largest candidate."""
_ANGLE = 5.0
"""Bounds of angles lie this far beyond them [degree]."""
_VOIDS, _OF_VOIDS = ("e_d0", "e_c0", "e_i0", "N"), 1.15
"""Bounds of limiting void ratios and specific volumes: this factor beyond the smallest and the largest candidate."""
_PAST = ("OCR", "POP")
_ALL_ROUND = ("isotropic_compression", "triaxial")
"""Tests that are compressed by all-round stress."""


@dataclass(frozen=True, slots=True)
class Proposed:
    """A proposed section of one parameter, and what it rests on; nothing: the usual range of the law.

    ``as_given``: nothing is known, and the section is that of the problem.
    """

    name: str
    info: ParameterInfo
    section: dict[str, Any]
    candidates: tuple[Estimate, ...]
    as_given: bool = False


def with_parameters(document: dict[str, Any]) -> dict[str, Any]:
    """Give a document without parameters those that its forward model needs, in their usual ranges.

    A stopping criterion comes to a document without one: nothing is calibrated with it. A document whose forward
    model has mistakes stays as it is.
    """
    document = {**document}
    document.setdefault("stopping", {"max_seconds": 60})
    if document.get("parameters"):
        return document
    try:
        spec = parse_spec(document.get("forward_model"))
        model = built(spec)
    except (ValidationError, SolverError, ValueError):
        return document  # reading it reports what is wrong
    infos = {info.name: info for info in model.parameters}
    found: dict[str, dict[str, Any]] = {}
    for test in (*soils_of(spec, model), *layers_of(spec, model)):
        flow = [name for name in test.parameters if name not in {info.name for info in test.law.parameters}]
        for name in (*wanted(test.law, ()), *(name for name in flow if infos[test.named(name)].default is None)):
            own = test.named(name)
            section = usual_section(infos[own]) if own in infos else None
            if section is not None:
                found.setdefault(own, section)
    return {**document, "parameters": found} if found else document


def proposed(problem: Problem) -> tuple[Proposed, ...]:
    """Propose a section for every free parameter of the problem's laws, and for an initial preconsolidation.

    An estimate (``initial``) is the median of what was read, else of what the index properties let expect. Bounds lie
    a factor of 2 (limiting void ratios, N: 1.15), or 5 degrees, beyond all candidates, within what is admissible.
    """
    infos = {info.name: info for info in problem.model.parameters}
    found = candidates_of(problem)
    free = [name for name, p in problem.parameters.items() if isinstance(p, FreeParameter)]
    more = [name for name in found if name.rpartition(".")[2] in _PAST and name not in problem.parameters]
    given = {name.rpartition(".")[2] for name in problem.parameters}
    more = [] if given & set(_PAST) else [name for name in more if name.endswith("POP")]  # one of both
    return tuple(_proposed(problem, infos[name], found.get(name, ())) for name in (*free, *more) if name in infos)


def candidates_of(problem: Problem) -> dict[str, list[Estimate]]:
    """Estimates of each parameter from readings and index properties, under the names that the problem uses."""
    fixed, soil = fixed_values(problem), soil_of(problem)
    read = [one for one in classical_values(problem) if one.value is not None]
    found: dict[str, list[Estimate]] = {}
    for test in soils_of(problem.forward_model, problem.model):
        known = term_known(test, test.own(fixed), soil)
        known |= {"all_round": 1.0} if test.spec.kind in _ALL_ROUND else {}
        _gather(found, problem, test, [*_read(test, read, known), *_past(test, read)])
    for test, known_index in with_index(problem.forward_model, problem.model, soil):
        told = index_estimates(test, test.own(fixed), known_index)
        _gather(
            found, problem, test, [(one.parameter, of_correlation(one)) for one in told if not one.correlated.outside]
        )
    compressed: list[TestOfLaw] = []
    without: list[TestOfLaw] = []
    for test in soils_of(problem.forward_model, problem.model):
        if "h_s" in test.parameters:
            _gather_sand(found, problem, test)
        moduli = found.get(full_name(problem, test, "E50_ref"), ())
        if "Eoed_ref" in test.parameters:
            compressed.append(test)
        if "E50_ref" in test.parameters and not any(one.reading for one in moduli):
            without.append(test)
        if "N" in problem.parameters and "N" in test.parameters:
            _gather(found, problem, test, normal_volume_of(problem, test, _known(problem, test, found)))
        if {"kappa_star", "N"} <= set(test.parameters):
            _gather(found, problem, test, swelling_slope_of(problem, test, _known(problem, test, found)))
    for test in compressed:
        _gather(found, problem, test, compression_moduli_of(problem, test, _known(problem, test, found)))
    for test in without:
        _gather(found, problem, test, reference_modulus_of(problem, test, _known(problem, test, found)))
    return found


def _gather(
    found: dict[str, list[Estimate]],
    problem: Problem,
    test: TestOfLaw,
    told: Iterable[tuple[str, Estimate]],
) -> None:
    """Put the candidates of a test's parameters under their names, each once."""
    for name, candidate in told:
        candidates = found.setdefault(full_name(problem, test, name), [])
        if candidate not in candidates:
            candidates.append(candidate)


def of_correlation(one: ParameterEstimate) -> Estimate:
    """An estimate by index properties as a candidate."""
    source = f"{one.quantity}: {one.correlated.correlation.equation}, {one.correlated.correlation.authors}"
    return Estimate(one.value, one.ends or (one.value, one.value), source, False)


def _proposed(problem: Problem, info: ParameterInfo, candidates: Sequence[Estimate]) -> Proposed:
    given = problem.parameters.get(info.name)
    usual = usual_section(info)
    if candidates:
        return Proposed(info.name, info, _section(info, candidates), tuple(candidates))
    if isinstance(given, FreeParameter):
        own = {"lower": given.lower, "upper": given.upper} | ({"scale": "log"} if given.scale == "log" else {})
        return Proposed(info.name, info, own, (), as_given=own != usual)
    return Proposed(info.name, info, usual or {}, ())


def _read(
    test: TestOfLaw, read: Sequence[ClassicalValue], known: Mapping[str, float]
) -> Iterator[tuple[str, Estimate]]:
    """What was read of a test, or of all tests together, by the terms of its law."""
    for one in read:
        if one.part not in ("", test.part) or one.value is None or not one.value > 0.0:
            continue
        method = f"{one.method}{'' if one.stage is None else f', stage {one.stage}'}"
        source = f"{one.part}: {method}" if one.part else method
        if one.symbol in ("k", "C_k") and one.symbol in test.parameters:
            yield one.symbol, Estimate.read(one.value, source)
        symbol, value = one.symbol, one.value
        if symbol.endswith("/(1 + e₀)"):
            symbol = symbol.removesuffix("/(1 + e₀)")
            around = {**known, "e_0": 0.0}  # with strains, 1 + e_0 is in the value already
        else:
            around = dict(known)
        for term in test.law.terms:
            if term.quantity in ("Cc", "Cs") and term.parameter in ("Eoed_ref", "Eur_ref"):
                continue  # they are those at p_ref: see compression_moduli_of
            strains = symbol != one.symbol
            if term.quantity != symbol or (term.voids and "e_0" not in around) or (strains and not term.voids):
                continue
            found = term.back(value, around)
            yield term.parameter, Estimate.read(found, source)


def _gather_sand(found: dict[str, list[Estimate]], problem: Problem, test: TestOfLaw) -> None:
    """Put what is read of hypoplastic sand under its names, each with what was read before: h_s and n, alpha, beta."""
    for evaluate in (hardness_of, alphas_of, beta_of):
        _gather(found, problem, test, evaluate(problem, _known(problem, test, found)))


def _known(problem: Problem, test: TestOfLaw, found: Mapping[str, Sequence[Estimate]]) -> dict[str, float]:
    """Parameters of a test as far as they are fixed, have candidates, or follow from such."""
    values: dict[str, float] = {}
    for name in test.parameters:
        candidates = found.get(full_name(problem, test, name), ())
        read = [one.value for one in candidates if one.reading] or [one.value for one in candidates]
        values |= {name: median(read)} if read else {}
    values |= test.own(fixed_values(problem))
    linked = [p for p in problem.parameters.values() if isinstance(p, LinkedParameter)]
    return values | {p.name: float(p.expression.value(values)) for p in linked if p.expression.names <= values.keys()}


def _past(test: TestOfLaw, read: Sequence[ClassicalValue]) -> Iterator[tuple[str, Estimate]]:
    """OCR and POP of an oedometer test."""
    spec = test.spec
    initial = getattr(spec, "initial_stress", None)
    section = getattr(spec, "OCR", None), getattr(spec, "POP", None)
    if initial is None or any(one is not None for one in section) or not test.confined:
        return
    for one in read:
        if one.symbol != "σ′p" or one.part != test.part or one.value is None or not one.value > initial:
            continue
        for name, value in (("OCR", one.value / initial), ("POP", one.value - initial)):
            if name in test.parameters:
                yield name, Estimate.read(value, f"σ′p, {one.method}")


def _section(info: ParameterInfo, candidates: Sequence[Estimate]) -> dict[str, Any]:
    """Bounds, scale and estimate of a parameter."""
    lowest, highest = min(one.ends[0] for one in candidates), max(one.ends[1] for one in candidates)
    read = [one.value for one in candidates if one.reading]
    initial = median(read or [one.value for one in candidates])
    name = info.name.rpartition(".")[2]
    if info.unit == "degree":
        low, high = lowest - _ANGLE, highest + _ANGLE
    elif info.unit == "kPa" and name in ("c", "POP"):
        low, high = 0.0, _FACTOR * highest
    elif name in _VOIDS:
        low, high = lowest / _OF_VOIDS, highest * _OF_VOIDS
    elif name == "OCR":
        low, high = 1.0, _FACTOR * highest
    else:
        least = min((one.ends[0] for one in candidates if one.reading), default=math.inf)
        low, high = min(max(lowest, 0.1 * initial), least) / _FACTOR, highest * _FACTOR
    low, high = _admitted(info, _rounded(low), _rounded(high))
    initial = min(max(_rounded(initial, 3), low), high)
    section = {"lower": low, "upper": high}
    scale = {"scale": "log"} if low > 0.0 and (is_wide(low, high) or is_wide(*(info.typical or (0.0, 0.0)))) else {}
    return section | scale | {"initial": initial}


def _admitted(info: ParameterInfo, low: float, high: float) -> tuple[float, float]:
    least = 0.0 if info.lower is None else info.lower
    if low < least or (low == least and info.lower_open):
        low = least if not info.lower_open else _rounded(0.01 * high)
    if info.upper is not None and high >= info.upper:
        high = info.upper if not info.upper_open else _rounded(low + 0.99 * (info.upper - low))
    return low, high


def _rounded(value: float, digits: int = 2) -> float:
    return float(f"{value:.{digits}g}")


@dataclass(frozen=True, slots=True)
class DraftEstimate:
    """A value that a parameter may have, in its unit, with the ends of the published scatter."""

    parameter: str
    unit: str
    lower: float
    value: float
    upper: float
    source: str
    measured: bool


def estimates_of_draft(draft: Draft) -> tuple[DraftEstimate, ...]:
    """Estimates of all parameters of a draft, under the names that it uses."""
    if draft.model is None:
        return ()
    units = {info.name: info.unit for info in draft.model.parameters}
    found = candidates_of(draft.problem) if draft.problem is not None else _of_index(draft)
    return tuple(
        DraftEstimate(
            name, units.get(name, ""), min(one.ends), one.value, max(one.ends), one.source, measured=one.reading
        )
        for name, candidates in found.items()
        for one in candidates
    )


def _of_index(draft: Draft) -> dict[str, list[Estimate]]:
    """Of the index properties alone, as far as these are sound."""
    document = draft.document or {}
    if draft.model is None or draft.spec is None:
        return {}
    soil = None
    if isinstance(document.get("index_properties"), dict):
        try:
            soil = IndexSection.model_validate(document["index_properties"]).properties()
        except ValidationError:
            soil = None
    sections: Any = document.get("parameters")
    given = sections if isinstance(sections, dict) else {}
    fixed = {
        str(name): float(section["value"])
        for name, section in given.items()
        if isinstance(section, dict) and isinstance(section.get("value"), int | float)
    }
    found: dict[str, list[Estimate]] = {}
    for test, known in with_index(draft.spec, draft.model, soil):
        for one in index_estimates(test, test.own(fixed), known):
            candidates = found.setdefault(name_among(given, test, one.parameter), [])
            candidate = of_correlation(one)
            if not one.correlated.outside and candidate not in candidates:
                candidates.append(candidate)
    return found
