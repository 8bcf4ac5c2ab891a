"""Parameters that follow from several others: of hypoplastic sand and clay, moduli of hardening soil at p_ref, N."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from statistics import median

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.forward.combined import parts_of
from geoswarm.solver.laboratory.shear.triaxial import TriaxialSpec
from geoswarm.solver.parameter_estimates.compression import CompressionReadings, compression_readings
from geoswarm.solver.parameter_estimates.compression_curve import first_loading
from geoswarm.solver.parameter_estimates.index import TestOfLaw
from geoswarm.solver.parameter_estimates.observed_curves import load_tests
from geoswarm.solver.parameter_estimates.shear import sheared_specimen
from geoswarm.solver.parameter_estimates.values import Estimate, NoEvaluationError, straight_line
from geoswarm.solver.problem import Problem

__all__ = [
    "alpha_at_peak",
    "alphas_of",
    "bauer_fit",
    "beta_of",
    "compression_moduli_of",
    "hardness_of",
    "normal_volume_of",
    "reference_modulus_of",
    "stiffness_exponent",
    "swelling_slope_of",
]

_FEWEST = 4
"""Readings of first loading through which a law of three constants is drawn."""
_EXPONENTS = np.linspace(0.05, 1.0, 951)
_DENSE = 0.8
"""Largest (e - e_d)/(e_c - e_d) at a peak that shows alpha: at looser states a small error of e changes it much."""
_USUAL_ANGLE = 33.0
"""Critical friction angle, degree, for the earth pressure at rest, where none is known."""


def hardness_of(problem: Problem, known: Mapping[str, float]) -> tuple[tuple[str, Estimate], ...]:
    """h_s [kPa] and n from first loading of the specimen with the largest void ratio; nothing where it shows none.

    The mean stress of an oedometer is that at rest, K0 = 1 - sin(phi_c), with ``phi_c`` [degree] among ``known``. Both
    values depend on each other, and a specimen denser than the loosest state overestimates h_s: its least value is that
    of twice the exponent with the same compression at the largest stress, 3 p (h_s/(3 p))^(1/2).
    """
    read = _compressed(problem)
    if not read:
        return ()
    loose = max(read, key=_voids)
    try:
        p, e = _first_loading(loose, known.get("phi_c", _USUAL_ANGLE))
        h_s, n, _ = bauer_fit(p, e)
    except NoEvaluationError:
        return ()
    least = min(math.sqrt(3.0 * float(p.max()) * h_s), h_s)
    how = f"{_of(loose.part)}Bauer's law through first loading, e = {_voids(loose):.3g}; Herle & Gudehus (1999)"
    return ("h_s", Estimate(h_s, (least, h_s), how, True)), ("n", Estimate.read(n, how))


def alphas_of(problem: Problem, known: Mapping[str, float]) -> Iterator[tuple[str, Estimate]]:
    """alpha from the peak of each dense specimen that was sheared drained, its volume read.

    ``known`` are the other parameters; nothing where phi_c, h_s, n, e_d0 or e_c0 is missing.
    """
    if not {"phi_c", "h_s", "n", "e_d0", "e_c0"} <= known.keys():
        return
    for part in parts_of(problem.forward_model, problem.model):
        if not isinstance(part.spec, TriaxialSpec):
            continue
        try:
            one = sheared_specimen(problem, part)
        except NoEvaluationError:
            continue
        if not one.drained or one.void_ratio is None or one.peak_volume is None:
            continue
        major, minor = one.failure
        e = one.void_ratio - (1.0 + one.void_ratio) * one.peak_volume
        density = _density(known, e, (major + 2.0 * minor) / 3.0)
        value = alpha_at_peak(major / minor, known["phi_c"], density) if 0.0 < density < _DENSE else 0.0
        if value > 0.0:
            yield "alpha", Estimate.read(value, f"{_of(one.part)}peak of q; Herle & Gudehus (1999)")


def alpha_at_peak(ratio: float, phi_c: float, density: float) -> float:
    """alpha by the axial over the radial stress at a peak: there the law has a strain rate without a stress rate.

    With L and N of the law (von Wolffersdorff 1996), ``f_d |L^-1 N| = 1`` and ``f_d = density^alpha``: the same as the
    closed form of Herle & Gudehus (1999). Below 0 where the ratio is not above that of the critical state.

    Parameters
    ----------
    density
        (e - e_d)/(e_c - e_d) at the peak, above 0 and below 1.
    """
    a = _a(phi_c)
    stress = np.array([ratio, 1.0, 1.0]) / (ratio + 2.0)
    n = a * (2.0 * stress - 1.0 / 3.0)
    direction = n - a**2 * stress * float(stress @ n) / (1.0 + a**2 * float(stress @ stress))
    return -math.log(float(np.linalg.norm(direction))) / math.log(density)


def beta_of(problem: Problem, known: Mapping[str, float]) -> tuple[tuple[str, Estimate], ...]:
    """beta from the stiffness of the densest specimen in first loading of an oedometer; nothing without one.

    ``known`` are the other parameters; nothing where one of them is missing.
    """
    read = [one for one in _compressed(problem) if one.confined]
    if not read or not {"phi_c", "h_s", "n", "e_d0", "e_c0", "e_i0", "alpha"} <= known.keys():
        return ()
    dense = min(read, key=_voids)
    logarithm, e = first_loading(dense.stress, dense.y)
    found = stiffness_exponent(10.0**logarithm, e, known)
    if not found > 0.0:
        return ()
    how = f"{_of(dense.part)}stiffness in first loading, e = {_voids(dense):.3g}; Herle & Gudehus (1999)"
    return (("beta", Estimate.read(found, how)),)


def stiffness_exponent(stress: FloatArray, e: FloatArray, known: Mapping[str, float]) -> float:
    """beta of readings of an oedometer: the median of all steps, nan without one.

    The stiffness of the law without lateral strain, at K0 = 1 - sin(phi_c), is that with beta = 0 times (e_i/e)^beta.

    Parameters
    ----------
    stress, e
        Vertical stress, kPa, rising, and void ratio, shape (k,).
    """
    phi_c, alpha = known["phi_c"], known["alpha"]
    a, at_rest = _a(phi_c), 1.0 - math.sin(math.radians(phi_c))
    vertical = 1.0 / (1.0 + 2.0 * at_rest)
    square = (1.0 + 2.0 * at_rest**2) * vertical**2
    widest = (known["e_i0"] - known["e_d0"]) / (known["e_c0"] - known["e_d0"])
    values = []
    for low, high, before, after in zip(stress, stress[1:], e, e[1:], strict=False):
        p, middle = math.sqrt(low * high) * (1.0 + 2.0 * at_rest) / 3.0, 0.5 * (before + after)
        e_i = known["e_i0"] * _shrunk(known, p)
        f_d = max(_density(known, middle, p), 0.0) ** alpha
        barotropy = known["h_s"] / known["n"] * (1.0 + e_i) / e_i * (3.0 * p / known["h_s"]) ** (1.0 - known["n"])
        barotropy /= 3.0 + a**2 - a * math.sqrt(3.0) * widest**alpha
        plain = barotropy * (1.0 + (a * vertical) ** 2 - f_d * a * (2.0 * vertical - 1.0 / 3.0)) / square
        strain = math.log((1.0 + before) / (1.0 + after))
        if strain > 0.0 and plain > 0.0 and middle < e_i:
            values.append(math.log((high - low) / strain / plain) / math.log(e_i / middle))
    return median(values) if values else math.nan


def _a(phi_c: float) -> float:
    sine = math.sin(math.radians(phi_c))
    return math.sqrt(3.0) * (3.0 - sine) / (2.0 * math.sqrt(2.0) * sine)


def _shrunk(known: Mapping[str, float], p: float) -> float:
    """Limiting void ratios under a mean stress over those at none."""
    return math.exp(-((3.0 * p / known["h_s"]) ** known["n"]))


def _density(known: Mapping[str, float], e: float, p: float) -> float:
    """(e - e_d)/(e_c - e_d) under a mean stress."""
    shrunk = _shrunk(known, p)
    return (e / shrunk - known["e_d0"]) / (known["e_c0"] - known["e_d0"])


def _compressed(problem: Problem) -> list[CompressionReadings]:
    read = [one for test in load_tests(problem) if (one := compression_readings(problem, test)) is not None]
    return [one for one in read if one.void_ratio is not None]


def _voids(read: CompressionReadings) -> float:
    return read.void_ratio or 0.0


def _of(part: str) -> str:
    return f"{part}: " if part else ""


def _first_loading(read: CompressionReadings, phi_c: float) -> tuple[FloatArray, FloatArray]:
    logarithm, e = first_loading(read.stress, read.y)
    share = 1.0 - 2.0 / 3.0 * math.sin(math.radians(phi_c)) if read.confined else 1.0  # (1 + 2 K0) / 3
    return share * 10.0**logarithm, e


def bauer_fit(p: FloatArray, e: FloatArray) -> tuple[float, float, float]:
    """Return h_s [kPa], n and the void ratio at p = 0 of ``e = e_0 exp(-(3 p/h_s)^n)`` (Bauer 1996), least squares.

    Parameters
    ----------
    p, e
        Mean effective stress, kPa, and void ratio, shape (k,).

    Raises
    ------
    NoEvaluationError
        There are fewer than four readings, or they do not bend as the law does.
    """
    if p.size < _FEWEST:
        raise NoEvaluationError(f"first loading has {p.size} readings; at least {_FEWEST} are needed")
    logarithm = np.log(e)  # a - (3/h_s)^n p^n: a straight line over p^n

    def missed(n: float) -> float:
        slope, start, _ = straight_line(p**n, logarithm)
        return float(np.sum((logarithm - start - slope * p**n) ** 2)) if slope < 0.0 else math.inf

    misses = np.array([missed(n) for n in _EXPONENTS])
    best = int(np.argmin(misses))
    if not np.isfinite(misses[best]) or best in (0, _EXPONENTS.size - 1):
        raise NoEvaluationError("the compression curve does not bend as Bauer's law does")
    n = float(_EXPONENTS[best])
    slope, start, _ = straight_line(p**n, logarithm)
    return 3.0 / (-slope) ** (1.0 / n), n, math.exp(start)


_REFERENCE = 100.0
_USUAL_POISSON = 0.3
_USUAL_UNLOADING = 0.2
"""Poisson's ratio of unloading that the law takes where none is given."""
_USUAL_ANGLE_OF_CLAY = 25.0
_VIRGIN = 0.9
"""Least Eoed_ref of the steps of first loading over that of others which are virgin, too."""


def reference_modulus_of(
    problem: Problem, test: TestOfLaw, known: Mapping[str, float]
) -> Iterator[tuple[str, Estimate]]:
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
            yield "E50_ref", Estimate(middle, (min(ends), max(ends)), f"{part.name or 'specimen'}: {how}", True)


def compression_moduli_of(
    problem: Problem, test: TestOfLaw, known: Mapping[str, float]
) -> Iterator[tuple[str, Estimate]]:
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
            yield name, Estimate(middle, (min(ends), max(ends)), f"{prefix}{how}, m = {words}", True)


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
    at_rest, most = known.get("K0nc", 1.0 - sine), (1.0 + sine) / (1.0 - sine)
    factor = (1.0 + nu) * (1.0 - 2.0 * nu) / nu if confined else 3.0 * (1.0 - 2.0 * nu)
    found = []
    for step in steps:
        before, after = step.before, step.after
        if confined:
            before, after = (_horizontal(step.largest, stress, at_rest, nu) for stress in (before, after))
            if not 0.0 < after < most * step.after:
                continue
        found.append(factor * _reference_change(before, after, m, known) / step.strain)
    return float(np.median(found)) if found else math.nan


def _horizontal(largest: float, stress: float, at_rest: float, nu: float) -> float:
    """Horizontal stress of an oedometer unloaded from the largest load [kPa], elastic with Poisson's ratio nu."""
    return at_rest * largest - nu / (1.0 - nu) * (largest - stress)


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


def normal_volume_of(problem: Problem, test: TestOfLaw, known: Mapping[str, float]) -> Iterator[tuple[str, Estimate]]:
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
            yield "N", Estimate.read(found, f"largest load of first loading, {how}")


def swelling_slope_of(problem: Problem, test: TestOfLaw, known: Mapping[str, float]) -> Iterator[tuple[str, Estimate]]:
    """kappa* of hypoplastic clay: -d ln(1 + e)/d ln(p) where unloading from the largest load begins (Masin 2013).

    The first step of unloading counts alone. The slope of the law grows along it, which is taken off where lambda*
    is among ``known``. The horizontal stress of an oedometer falls elastically from that at rest, K0 = 1 - sin(phi_c),
    with nu; usual ones where none are known.
    """
    for load_test in load_tests(problem):
        read = compression_readings(problem, load_test) if load_test.part == test.part else None
        if read is None or (at := int(np.argmax(read.stress[::-1]))) == 0:
            continue
        last = read.stress.size - 1 - at
        before, after = read.stress[last : last + 2].tolist()
        nu = known.get("nu", _USUAL_POISSON)
        sine = math.sin(math.radians(known.get("phi_c", _USUAL_ANGLE_OF_CLAY)))
        p_before, p_after = before, after
        if test.confined:
            p_before, p_after = (
                (stress + 2.0 * _horizontal(before, stress, 1.0 - sine, nu)) / 3.0 for stress in (before, after)
            )
        heave = float(np.log1p(read.y[last + 1]) - np.log1p(read.y[last]))
        if heave > 0.0 and 0.0 < p_after < p_before:
            how = f"{_of(test.part)}unloading from {before:.4g} to {after:.4g} kPa, ln(1 + e) over ln(p′); Mašín (2013)"
            slope = heave / math.log(p_before / p_after)
            soft = known.get("lambda_star", 0.0)
            if slope < soft:
                over = 0.5 * (1.0 - slope / soft)  # in the middle of the step; swelling takes from it
                slope = _at_the_beginning(slope, soft, sine, (p_before / p_after) ** over)
            yield "kappa_star", Estimate.read(slope, how)


def _at_the_beginning(slope: float, soft: float, sine: float, past: float) -> float:
    """Slope of unloading at OCR 1 by that at an OCR: 2/slope = 1/lambda* + 1/kappa* + (1/kappa* - 1/lambda*) f_d there.

    f_d is OCR^-alpha, with alpha by lambda*, kappa* and sin(phi_c) (Masin 2013).
    """
    from geoswarm.solver.laws.hypoplasticity.shared import strength_ratio  # loads Numba: only where clay is estimated

    stiff = slope
    for _ in range(3):  # alpha depends on kappa* little
        alpha = max(math.log2((soft - stiff) / (soft + stiff) * strength_ratio(sine)), 0.0)
        density = past**-alpha
        stiff = 0.5 * (1.0 + density) / (1.0 / slope - 0.5 * (1.0 - density) / soft)
    return stiff


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
