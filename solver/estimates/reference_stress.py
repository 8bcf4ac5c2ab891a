"""Parameters at a reference stress that no test was made at: E50_ref of hardening soil, N of Cam clay."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

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

__all__ = ["normal_volume_of", "reference_modulus_of"]

_REFERENCE = 100.0
_USUAL_POISSON = 0.3
_HOW = "largest load of first loading, lambda, kappa and M"


def reference_modulus_of(
    problem: Problem, test: TestOfLaw, known: Mapping[str, float]
) -> Iterator[tuple[str, Candidate]]:
    """E50_ref [kPa] of a drained specimen, E50 (100 kPa/sigma_3)^m; m is in its usual range unless ``known``."""
    usual = next((one.typical for one in test.law.parameters if one.name == "m"), None)
    low, high = (known["m"], known["m"]) if "m" in known else usual or (math.nan, math.nan)
    for part in parts_of(problem.forward_model, problem.model):
        if part.name != test.part or not isinstance(part.spec, TriaxialSpec) or not low <= high:
            continue
        try:
            one = sheared_specimen(problem, part)
        except NoEvaluationError:
            continue
        if one.drained and one.modulus is not None:
            middle, *ends = (one.modulus * (_REFERENCE / one.radial) ** m for m in (0.5 * (low + high), low, high))
            powers = f"{low:.3g}" if low == high else f"{low:.3g} to {high:.3g}"
            how = f"{part.name or 'specimen'}: secant at half the strength, σ′₃ = {one.radial:.4g} kPa, m = {powers}"
            yield "E50_ref", Candidate(middle, (min(ends), max(ends)), how, True)


def normal_volume_of(problem: Problem, test: TestOfLaw, known: Mapping[str, float]) -> Iterator[tuple[str, Candidate]]:
    """N of Cam clay from the largest load of first loading: 1 + e + lambda ln(p_c) - kappa ln(p_c/p), p in kPa.

    The state there is on the yield surface, p_c = p (1 + eta^2/M^2), in an oedometer at the law's K0. Nothing where
    lambda, kappa or M is missing from ``known``.
    """
    if not {"lambda", "kappa", "M"} <= known.keys():
        return
    for load_test in load_tests(problem):
        read = compression_readings(problem, load_test) if load_test.part == test.part else None
        if read is not None and read.void_ratio is not None:
            logarithm, e = first_loading(read.stress, read.y)
            yield "N", Candidate.read(_normal_volume(test, known, 10.0 ** float(logarithm[-1]), float(e[-1])), _HOW)


def _normal_volume(test: TestOfLaw, known: Mapping[str, float], stress: float, e: float) -> float:
    poisson = known.get("nu", _USUAL_POISSON)
    ratio = 1.5 * (1.0 - 2.0 * poisson) / (1.0 + poisson)
    at_rest = test.law.K0(np.array([known["M"], known["lambda"], known["kappa"], ratio])) if test.confined else None
    K0 = 1.0 if at_rest is None else at_rest
    p = stress * (1.0 + 2.0 * K0) / 3.0
    eta = 3.0 * (1.0 - K0) / (1.0 + 2.0 * K0)
    over = math.log(1.0 + (eta / known["M"]) ** 2)
    return 1.0 + e + known["lambda"] * (math.log(p) + over) - known["kappa"] * over
