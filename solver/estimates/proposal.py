"""Initial parameters of a problem: bounds and estimates from the readings, index properties and usual ranges."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

from pydantic import ValidationError

from geoswarm.solver.errors import SolverError
from geoswarm.solver.estimates.classical import classical_values
from geoswarm.solver.estimates.granular import alphas_of, beta_of, hardness_of
from geoswarm.solver.estimates.index import (
    ParameterEstimate,
    TestOfLaw,
    full_name,
    index_estimates,
    layers_of,
    soils_of,
    term_known,
    with_index,
)
from geoswarm.solver.estimates.reference_stress import compression_moduli_of, normal_volume_of, reference_modulus_of
from geoswarm.solver.estimates.usual import is_wide, usual_section, wanted
from geoswarm.solver.estimates.value import Candidate, ClassicalValue
from geoswarm.solver.forward.registry import built, parse_spec
from geoswarm.solver.parameter_info import ParameterInfo
from geoswarm.solver.problem import FixedParameter, FreeParameter, LinkedParameter, Problem

__all__ = ["Proposed", "candidates_of", "of_correlation", "proposed", "with_parameters"]

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
    candidates: tuple[Candidate, ...]
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


def candidates_of(problem: Problem) -> dict[str, list[Candidate]]:
    """Estimates of each parameter from readings and index properties, under the names that the problem uses."""
    fixed = {name: p.value for name, p in problem.parameters.items() if isinstance(p, FixedParameter)}
    soil = None if problem.index_properties is None else problem.index_properties.properties()
    read = [one for one in classical_values(problem) if one.value is not None]
    found: dict[str, list[Candidate]] = {}
    for test in soils_of(problem.forward_model, problem.model):
        known = term_known(test, test.own(fixed), soil)
        known |= {"all_round": 1.0} if test.spec.kind in _ALL_ROUND else {}
        _gather(found, problem, test, [*_read(test, read, known), *_past(test, read)])
    for test, known_index in with_index(problem.forward_model, problem.model, soil):
        told = index_estimates(test, test.own(fixed), known_index)
        _gather(found, problem, test, [(one.parameter, of_correlation(one)) for one in told if not one.told.outside])
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
    for test in compressed:
        _gather(found, problem, test, compression_moduli_of(problem, test, _known(problem, test, found)))
    for test in without:
        _gather(found, problem, test, reference_modulus_of(problem, test, _known(problem, test, found)))
    return found


def _gather(
    found: dict[str, list[Candidate]], problem: Problem, test: TestOfLaw, told: Iterable[tuple[str, Candidate]]
) -> None:
    """Put the candidates of a test's parameters under their names, each once."""
    for name, candidate in told:
        candidates = found.setdefault(full_name(problem, test, name), [])
        if candidate not in candidates:
            candidates.append(candidate)


def of_correlation(one: ParameterEstimate) -> Candidate:
    """An estimate by index properties as a candidate."""
    source = f"{one.quantity}: {one.told.correlation.equation}, {one.told.correlation.authors}"
    return Candidate(one.value, one.ends or (one.value, one.value), source, False)


def _proposed(problem: Problem, info: ParameterInfo, candidates: Sequence[Candidate]) -> Proposed:
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
) -> Iterator[tuple[str, Candidate]]:
    """What was read of a test, or of all tests together, by the terms of its law."""
    for one in read:
        if one.part not in ("", test.part) or one.value is None or not one.value > 0.0:
            continue
        method = f"{one.method}{'' if one.stage is None else f', stage {one.stage}'}"
        source = f"{one.part}: {method}" if one.part else method
        if one.symbol in ("k", "C_k") and one.symbol in test.parameters:
            yield one.symbol, Candidate.read(one.value, source)
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
            yield term.parameter, Candidate.read(found, source)


def _gather_sand(found: dict[str, list[Candidate]], problem: Problem, test: TestOfLaw) -> None:
    """Put what is read of hypoplastic sand under its names, each with what was read before: h_s and n, alpha, beta."""
    for evaluate in (hardness_of, alphas_of, beta_of):
        _gather(found, problem, test, evaluate(problem, _known(problem, test, found)))


def _known(problem: Problem, test: TestOfLaw, found: Mapping[str, Sequence[Candidate]]) -> dict[str, float]:
    """Parameters of a test as far as they are fixed, have candidates, or follow from such."""
    values: dict[str, float] = {}
    for name in test.parameters:
        candidates = found.get(full_name(problem, test, name), ())
        read = [one.value for one in candidates if one.reading] or [one.value for one in candidates]
        values |= {name: median(read)} if read else {}
    fixed = {name: p.value for name, p in problem.parameters.items() if isinstance(p, FixedParameter)}
    values |= test.own(fixed)
    linked = [p for p in problem.parameters.values() if isinstance(p, LinkedParameter)]
    return values | {p.name: float(p.expression.value(values)) for p in linked if p.expression.names <= values.keys()}


def _past(test: TestOfLaw, read: Sequence[ClassicalValue]) -> Iterator[tuple[str, Candidate]]:
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
                yield name, Candidate.read(value, f"σ′p, {one.method}")


def _section(info: ParameterInfo, candidates: Sequence[Candidate]) -> dict[str, Any]:
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
