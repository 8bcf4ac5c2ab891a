"""Parameters at a reference stress that no test was made at: moduli of hardening soil, N of clays."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np

from geoswarm.solver.classical.compression import first_loading
from geoswarm.solver.classical.curves import NoEvaluationError
from geoswarm.solver.estimates.compression import compression_readings
from geoswarm.solver.estimates.index import TestOfLaw
from geoswarm.solver.estimates.stage_ends import load_tests
from geoswarm.solver.estimates.triaxial import sheared_specimen
from geoswarm.solver.estimates.value import Candidate
from geoswarm.solver.forward.combined import parts_of
from geoswarm.solver.laboratory.shear.triaxial import TriaxialSpec
from geoswarm.solver.problem import Problem

__all__ = ["compression_moduli_of", "normal_volume_of", "reference_modulus_of"]

_REFERENCE = 100.0
_USUAL_POISSON = 0.3
_USUAL_UNLOADING = 0.2
"""Poisson's ratio of unloading that the law takes where none is given."""
_USUAL_ANGLE = 33.0
"""Friction angle, degree, for the earth pressure at rest, where none is known."""
_VIRGIN = 0.9
"""Least Eoed_ref of the steps of first loading over that of others which are virgin, too."""


def reference_modulus_of(
    problem: Problem, test: TestOfLaw, known: Mapping[str, float]
) -> Iterator[tuple[str, Candidate]]:
    """E50_ref [kPa] of a drained specimen, E50 (100 kPa/sigma_3)^m; m is in its usual range unless ``known``."""
    low, high = _powers(test, known)
    for part in parts_of(problem.forward_model, problem.model):
        if part.name != test.part or not isinstance(part.spec, TriaxialSpec) or not low <= high:
            continue
        try:
            one = sheared_specimen(problem, part)
        except NoEvaluationError:
            continue
        if one.drained and one.modulus is not None:
            middle, *ends = (one.modulus * (_REFERENCE / one.radial) ** m for m in (0.5 * (low + high), low, high))
            how = f"secant at half the strength, σ′₃ = {one.radial:.4g} kPa, m = {_in_words(low, high)}"
            yield "E50_ref", Candidate(middle, (min(ends), max(ends)), f"{part.name or 'specimen'}: {how}", True)


def compression_moduli_of(
    problem: Problem, test: TestOfLaw, known: Mapping[str, float]
) -> Iterator[tuple[str, Candidate]]:
    """Eoed_ref and Eur_ref [kPa] of a compression test, by its steps; m is in its usual range unless ``known``.

    Virgin steps of an oedometer have E_oed = Eoed_ref (sigma_v/p_ref)^m: those of first loading with the least value.
    Steps of unloading have E_ur = Eur_ref (sigma_3/p_ref)^m and are taken as elastic: the horizontal stress of an
    oedometer falls from that at rest by nu/(1 - nu) of the vertical one, and steps that end beyond failure by it do not
    count.
    """
    low, high = _powers(test, known)
    for load_test in load_tests(problem):
        read = compression_readings(problem, load_test) if load_test.part == test.part else None
        if read is None or not low <= high:
            continue
        e = 0.0 if read.void_ratio is None else read.void_ratio
        stress, strains = read.stress.tolist(), (-np.diff(read.y) / (1.0 + e)).tolist()
        largest = np.maximum.accumulate(read.stress).tolist()
        steps = [_Step(*ends, *more) for *more, ends in zip(largest, strains, pairwise(stress), strict=False)]
        loading = [step for step in steps if step.after > step.largest and step.strain > 0.0]
        unloading = [step for step in steps if step.after < step.before and step.strain < 0.0]
        prefix, words = f"{test.part}: " if test.part else "", _in_words(low, high)
        evaluations: list[tuple[str, str, Callable[[float], float]]] = []
        if len(loading) > 1 and test.confined:
            evaluations.append(("Eoed_ref", "virgin steps", partial(_virgin_modulus, loading, known)))
        if unloading:
            evaluations.append(("Eur_ref", "unloading", partial(_unloading_modulus, unloading, known, test.confined)))
        for name, how, evaluate in evaluations:
            middle, *ends = (evaluate(m) for m in (0.5 * (low + high), low, high))
            if math.isnan(middle):
                continue
            yield name, Candidate(middle, (min(ends), max(ends)), f"{prefix}{how}, m = {words}", True)


@dataclass(frozen=True, slots=True)
class _Step:
    """From one stress to another [kPa], the largest stress so far, and the strain of the step."""

    before: float
    after: float
    largest: float
    strain: float


def _virgin_modulus(steps: Sequence[_Step], known: Mapping[str, float], m: float) -> float:
    """Eoed_ref of steps of first loading."""
    found = np.array([_reference_change(step.before, step.after, m, known) / step.strain for step in steps])
    return float(np.median(found[found <= found.min() / _VIRGIN]))


def _unloading_modulus(steps: Sequence[_Step], known: Mapping[str, float], confined: bool, m: float) -> float:
    """Eur_ref of steps of unloading; nan where none is elastic."""
    nu = known.get("nu_ur", _USUAL_UNLOADING)
    sine = math.sin(math.radians(known.get("phi", _USUAL_ANGLE)))
    at_rest, most, slope = known.get("K0nc", 1.0 - sine), (1.0 + sine) / (1.0 - sine), nu / (1.0 - nu)
    factor = (1.0 + nu) * (1.0 - 2.0 * nu) / nu if confined else 3.0 * (1.0 - 2.0 * nu)
    found = []
    for step in steps:
        before, after = step.before, step.after
        if confined:
            before, after = (at_rest * step.largest - slope * (step.largest - stress) for stress in (before, after))
            if not 0.0 < after < most * step.after:
                continue
        found.append(factor * _reference_change(before, after, m, known) / step.strain)
    return float(np.median(found)) if found else math.nan


def _reference_change(a: float, b: float, m: float, known: Mapping[str, float]) -> float:
    """The integral of (p_ref/stress)^m over a stress: strain times the modulus at p_ref, kPa."""
    reference = known.get("p_ref", _REFERENCE)
    if abs(1.0 - m) < 1e-6:
        return reference * math.log(b / a)
    return float(reference**m * (b ** (1.0 - m) - a ** (1.0 - m)) / (1.0 - m))


def _powers(test: TestOfLaw, known: Mapping[str, float]) -> tuple[float, float]:
    """m, as known or the ends of its usual range; nan without one."""
    usual = next((one.typical for one in test.law.parameters if one.name == "m"), None)
    return (known["m"], known["m"]) if "m" in known else usual or (math.nan, math.nan)


def _in_words(low: float, high: float) -> str:
    return f"{low:.3g}" if low == high else f"{low:.3g} to {high:.3g}"


def normal_volume_of(problem: Problem, test: TestOfLaw, known: Mapping[str, float]) -> Iterator[tuple[str, Candidate]]:
    """N from the largest load of first loading, in an oedometer at the law's K0, p in kPa.

    Of Cam clay 1 + e + lambda ln(p_c) - kappa ln(p_c/p): the state there is on the yield surface, p_c = p (1 +
    eta^2/M^2). Of hypoplastic clay ln(1 + e) + lambda* ln(p), less than N by lambda* ln(p_e/p) where eta is not 0.
    Nothing where one of these is missing from ``known``.
    """
    if {"lambda", "kappa", "M"} <= known.keys():
        how, evaluate = "lambda, kappa and M", _normal_volume
    elif {"lambda_star", "phi_c"} <= known.keys():
        how, evaluate = "lambda_star and phi_c", _normal_logarithm
    else:
        return
    for load_test in load_tests(problem):
        read = compression_readings(problem, load_test) if load_test.part == test.part else None
        if read is not None and read.void_ratio is not None:
            logarithm, e = first_loading(read.stress, read.y)
            found = evaluate(test, known, 10.0 ** float(logarithm[-1]), float(e[-1]))
            yield "N", Candidate.read(found, f"largest load of first loading, {how}")


def _normal_logarithm(test: TestOfLaw, known: Mapping[str, float], stress: float, e: float) -> float:
    K0 = 1.0 - math.sin(math.radians(known["phi_c"])) if test.confined else 1.0
    return math.log1p(e) + known["lambda_star"] * math.log(stress * (1.0 + 2.0 * K0) / 3.0)


def _normal_volume(test: TestOfLaw, known: Mapping[str, float], stress: float, e: float) -> float:
    poisson = known.get("nu", _USUAL_POISSON)
    ratio = 1.5 * (1.0 - 2.0 * poisson) / (1.0 + poisson)
    at_rest = test.law.K0(np.array([known["M"], known["lambda"], known["kappa"], ratio])) if test.confined else None
    K0 = 1.0 if at_rest is None else at_rest
    p = stress * (1.0 + 2.0 * K0) / 3.0
    eta = 3.0 * (1.0 - K0) / (1.0 + 2.0 * K0)
    over = math.log(1.0 + (eta / known["M"]) ** 2)
    return 1.0 + e + known["lambda"] * (math.log(p) + over) - known["kappa"] * over
