"""Shear tests: stresses at failure and at the end, secant modulus, dilatancy, and angle in direct simple shear."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.forward.combined import ModelPart
from geoswarm.solver.laboratory.shear.simple_shear import DirectSimpleShearSpec, SimpleShearMonotonic
from geoswarm.solver.laboratory.shear.triaxial import TriaxialMonotonic, TriaxialSpec
from geoswarm.solver.parameter_estimates.mohr_circles import FailureLine, mohr_circles
from geoswarm.solver.parameter_estimates.observed_curves import first_of, observed, rising
from geoswarm.solver.parameter_estimates.values import (
    Arc,
    ClassicalValue,
    Construction,
    DrawnLine,
    NoEvaluationError,
    straight_line,
)
from geoswarm.solver.problem import Observation, Problem
from geoswarm.solver.words import per_cent

__all__ = ["Sheared", "sheared_specimen", "simple_shear_values", "triaxial_construction", "triaxial_values"]

_REFERENCE = 100.0
"""kPa: stress of reference moduli, as usual."""
_APART = 1.3
"""Least ratio of the largest to the smallest radial stress needed for a power of stress."""
_NEAR = 0.95
"""Part of the strength above which the volumetric strain gives the dilatancy at failure."""
_FAR, _STILL, _RATE = 0.1, 0.03, 0.05
"""Least axial strain of a critical state; largest changes of p' and q/p', and of the volume, over its last quarter."""
_ALIKE = 0.05
"""Range of void ratios within which specimens have one density."""
_SAME = 0.02
"""Range of strengths, over their mean, within which circles lie on one another."""


@dataclass(frozen=True, slots=True)
class Sheared:
    """What was read of one specimen, compression positive, kPa.

    Parameters
    ----------
    part
        Name of the test.
    drained
        Whether the first stage of shearing is.
    radial
        Effective radial stress before shearing.
    failure, end
        Largest and smallest principal effective stress where q (drained) or q/p' (undrained) is largest, and at the
        last reading.
    modulus
        Secant modulus at half the strength; None where the readings do not show it.
    dilatancy
        Angle at failure, degree; None: not drained, or no volumetric strain was read there.
    peak_volume
        Volumetric strain where q is largest; None: not drained, or not read.
    settled
        Whether stresses and volume change no more at the end, so that the state there is the critical one.
    void_ratio
        Before the test; None where it is not known.
    """

    part: str
    drained: bool
    radial: float
    failure: tuple[float, float]
    end: tuple[float, float]
    modulus: float | None
    dilatancy: float | None
    peak_volume: float | None
    settled: bool
    void_ratio: float | None


def sheared_specimen(problem: Problem, part: ModelPart) -> Sheared:
    """What was read of a specimen; a single reading of q is that at failure.

    Raises
    ------
    NoEvaluationError
        The test or the readings tell no strength.
    """
    spec = part.spec
    assert isinstance(spec, TriaxialSpec)
    series = observed(problem, part.name)
    first = spec.shearing[0]
    if not isinstance(first, TriaxialMonotonic):
        raise NoEvaluationError("the first stage of shearing is not monotonic")
    q_of = first_of(series, "q")
    if q_of is None:
        raise NoEvaluationError("q over the axial strain was not read")
    axial, radial = _consolidated(spec)
    strain, q = rising(q_of)
    if strain.size == 2 or not q.max() > max(0.0, -q.min()):
        raise NoEvaluationError("q has two readings only, or is that of extension; compression is evaluated")
    drained = not spec.is_undrained(first)
    minor = {
        "radial_stress": np.full(q.size, radial),
        "mean_stress": (axial + 2.0 * radial) / 3.0 - q / 3.0,
        "axial_stress": axial - q,
    }[first.constant]
    if not drained:
        minor = _undrained(series, strain, q, minor, spec.back_pressure)
    good = np.flatnonzero(minor > 0.0)
    if good.size == 0:
        raise NoEvaluationError("the smallest effective stress is nowhere above 0 kPa")
    ratio = q[good] if drained else q[good] / (minor[good] + q[good] / 3.0)
    at, last = int(good[np.argmax(ratio)]), int(good[-1])
    return Sheared(
        part.name,
        drained,
        radial,
        (float(minor[at] + q[at]), float(minor[at])),
        (float(minor[last] + q[last]), float(minor[last])),
        _secant(strain, q, axial - radial),
        _dilatancy(series, strain, q) if drained else None,
        _volume_at(series, float(strain[at])) if drained else None,
        strain.size > 1 and _is_settled(series, strain[good], minor[good] + q[good] / 3.0, q[good]),
        spec.initial_void_ratio,
    )


def triaxial_values(specimens: Sequence[Sheared]) -> Iterator[ClassicalValue]:
    """Strength of all specimens together, and stiffness of each."""
    count = f"{len(specimens)} specimens" if len(specimens) > 1 else "1 specimen"
    try:
        found = _circles(specimens)
    except NoEvaluationError as error:
        yield ClassicalValue("", "φ", f"Mohr circles, {count}", None, str(error), "degree")
    else:
        how = f"Mohr circles, {count}{', c = 0' if found.through_origin else ''}"
        yield ClassicalValue("", "φ", how, found.friction_angle, unit="degree")
        if not found.through_origin:
            yield ClassicalValue("", "c", how, found.cohesion, unit="kPa")
    yield _critical([one for one in specimens if one.settled])
    dilating = [one.dilatancy for one in specimens if one.dilatancy is not None]
    if dilating:
        mean = float(np.mean(dilating))
        yield ClassicalValue("", "ψ", f"volumetric strain near failure, mean of {len(dilating)}", mean, unit="degree")
    drained = [one for one in specimens if one.drained and one.modulus is not None]
    for one in specimens:
        if one.modulus is not None:
            symbol = "E₅₀" if one.drained else "E₅₀ᵤ"
            how = f"secant at half the strength, σ′₃ = {one.radial:.4g} kPa"
            yield ClassicalValue(one.part, symbol, how, one.modulus, unit="kPa")
    yield from _power(drained)


def _critical(settled: Sequence[Sheared]) -> ClassicalValue:
    """Critical friction angle, from the specimens whose state changes no more at the end."""
    count = f"{len(settled)} specimens" if len(settled) != 1 else "1 specimen"
    how = f"end of shearing, {count}, c = 0"
    if not settled:
        why = (
            "no specimen is at its critical state at the end: that needs an axial strain of at least "
            f"{per_cent(_FAR)}, over whose last quarter p' and q/p' change by less than {per_cent(_STILL)}, and the "
            f"volume by less than {per_cent(_RATE)} of that strain"
        )
        return ClassicalValue("", "φ_cs", "end of shearing, c = 0", None, why, "degree")
    s = np.array([0.5 * sum(one.end) for one in settled])
    t = np.array([0.5 * (one.end[0] - one.end[1]) for one in settled])
    sine = float(s @ t / (s @ s))
    angle = math.degrees(math.asin(sine)) if 0.0 < sine < 1.0 else None
    why = "" if angle is not None else "the stresses at the end are not those of compression"
    return ClassicalValue("", "φ_cs", how, angle, why, "degree")


def _is_settled(series: dict[str, Observation], strain: FloatArray, p: FloatArray, q: FloatArray) -> bool:
    """Whether mean stress, q/p' and volume change no more over the last quarter of the axial strain."""
    if not strain[-1] >= _FAR:
        return False
    late = strain >= 0.75 * strain[-1]
    for values in (p[late], q[late] / p[late]):
        if float(np.ptp(_smooth(strain[late], values))) > _STILL * abs(float(values.mean())):
            return False
    volume = first_of(series, "volumetric_strain")
    if volume is None:
        return True
    x, y = rising(volume)
    inside = x >= 0.75 * strain[-1]
    return bool(inside.sum() < 2 or abs(straight_line(x[inside], y[inside])[0]) < _RATE)


def _volume_at(series: dict[str, Observation], strain: float) -> float | None:
    one = first_of(series, "volumetric_strain")
    if one is None or not one.x.min() <= strain <= one.x.max():
        return None
    return float(np.interp(strain, *rising(one)))


def _smooth(x: FloatArray, y: FloatArray) -> FloatArray:
    """A straight line through readings, so that their scatter is no change."""
    if x.size < 3:
        return y
    slope, start, _ = straight_line(x, y)
    return start + slope * x


def triaxial_construction(specimens: Sequence[Sheared]) -> Construction | None:
    """Mohr circles at failure with the line along them; None where there is none."""
    try:
        found = _circles(specimens)
    except NoEvaluationError:
        return None
    largest = max(one.failure[0] for one in specimens)
    x = np.array([0.0, largest])
    tau = found.cohesion + x * math.tan(math.radians(found.friction_angle))
    label = f"φ = {found.friction_angle:.3g}°, c = {found.cohesion:.3g} kPa"
    empty = np.empty(0)
    return Construction(
        "mohr_circles",
        "",
        "Mohr circles at failure",
        "Effective stresses where q (drained) or q/p′ (undrained) is largest; the line has the least squares of its "
        "distances from the circles, and goes through the origin where cohesion would be negative or there is one "
        "circle.",
        "normal stress σ′",
        "kPa",
        "shear stress τ",
        "kPa",
        empty,
        empty,
        (DrawnLine(label, x, tau, "main"),),
        arcs=tuple(Arc(one.failure[1], one.failure[0]) for one in specimens),
    )


def _circles(specimens: Sequence[Sheared]) -> FailureLine:
    return mohr_circles([one.failure[0] for one in specimens], [one.failure[1] for one in specimens])


def _power(drained: Sequence[Sheared]) -> Iterator[ClassicalValue]:
    """Reference modulus and power of stress of several drained specimens: E50 = E50_ref (sigma_3/100 kPa)^m (Janbu)."""
    radial = np.array([one.radial for one in drained])
    if radial.size == 0:
        return
    moduli = np.array([one.modulus for one in drained], dtype=np.float64)
    voids = [one.void_ratio for one in drained if one.void_ratio is not None]
    if voids and max(voids) - min(voids) > _ALIKE and radial.max() >= _APART * radial.min():
        why = (
            f"the specimens have void ratios from {min(voids):.3g} to {max(voids):.3g}; a power of stress is read from "
            f"specimens of one density, within {_ALIKE:g}"
        )
        yield ClassicalValue("", "m", "power of σ′₃/100 kPa", None, why)
    elif radial.max() >= _APART * radial.min():
        m, offset, _ = straight_line(np.log(radial / _REFERENCE), np.log(moduli))
        how = f"{radial.size} specimens, power of σ′₃/100 kPa"
        yield ClassicalValue("", "E₅₀ʳᵉᶠ", how, math.exp(offset), unit="kPa")
        yield ClassicalValue("", "m", how, m)
    elif abs(radial.mean() / _REFERENCE - 1.0) <= _SAME:
        yield ClassicalValue("", "E₅₀ʳᵉᶠ", "σ′₃ = 100 kPa", float(moduli.mean()), unit="kPa")


def _consolidated(spec: TriaxialSpec) -> tuple[float, float]:
    """Axial and radial effective stress before shearing."""
    if not spec.consolidation:
        if spec.initial_ratio == "K0":
            raise NoEvaluationError("the radial stress before shearing is that at rest, which was not measured")
        return spec.initial_stress, spec.initial_ratio * spec.initial_stress
    last = spec.consolidation[-1]
    if last.radial == "K0":
        raise NoEvaluationError("the radial stress after K0 consolidation was not measured")
    return last.axial, last.axial if last.radial is None else last.radial


def _undrained(
    series: dict[str, Observation], strain: FloatArray, q: FloatArray, total: FloatArray, back_pressure: float
) -> FloatArray:
    """Smallest effective stress, from the mean stress or the pore pressure that was read."""
    p, u = first_of(series, "p"), first_of(series, "pore_pressure")
    if p is not None:
        return np.asarray(np.interp(strain, *rising(p)) - q / 3.0)
    if u is None:
        raise NoEvaluationError("an undrained test without p or pore_pressure gives no effective stress")
    return np.asarray(total - (np.interp(strain, *rising(u)) - back_pressure))


def _secant(strain: FloatArray, q: FloatArray, start: float) -> float | None:
    rising = np.maximum.accumulate(q[: int(np.argmax(q)) + 1])
    half = start + 0.5 * (float(q.max()) - start)
    if rising.size < 2 or not rising[0] < half:
        return None
    at = int(np.argmax(rising >= half))
    share = (half - rising[at - 1]) / (rising[at] - rising[at - 1])
    place = float(strain[at - 1] + share * (strain[at] - strain[at - 1]))
    return (half - start) / place if place > 0.0 else None


def _dilatancy(series: dict[str, Observation], strain: FloatArray, q: FloatArray) -> float | None:
    """``sin(psi) = -r/(2 - r)``, r the volumetric over the axial strain rate (Schanz & Vermeer 1996)."""
    one = first_of(series, "volumetric_strain")
    if one is None:
        return None
    near = strain[q >= _NEAR * q.max()]
    x, volume = rising(one)
    inside = (x >= near.min()) & (x <= near.max())
    if inside.sum() < 3:
        return None
    rate = straight_line(x[inside], volume[inside])[0]
    return math.degrees(math.asin(max(min(-rate / (2.0 - rate), 1.0), -1.0)))


def simple_shear_values(problem: Problem, part: ModelPart) -> Iterator[ClassicalValue]:
    """Angle of the largest ratio of shear to normal stress, and of a test at constant volume s_u.

    The horizontal plane is taken for the plane of failure, tan(phi) = tau/sigma'_v; a soil that fails at critical state
    while the horizontal plane is one of largest shear has sin(phi) there, and a larger angle.
    """
    spec = part.spec
    assert isinstance(spec, DirectSimpleShearSpec)
    series = observed(problem, part.name)
    shear = first_of(series, "shear_stress")
    first = spec.shearing[0]
    method = "largest τ/σ′v on the horizontal plane"
    if shear is None or not isinstance(first, SimpleShearMonotonic):
        why = "shear_stress over the shear strain of a monotonic first stage was not read"
        yield ClassicalValue(part.name, "φ", method, None, why, "degree")
        return
    vertical = spec.consolidation[-1].normal_stress if spec.consolidation else spec.initial_stress
    strain, tau = rising(shear)
    tau = np.abs(tau)
    volume_kept = (first.constant or spec.constant) == "volume"
    if volume_kept:
        yield ClassicalValue(part.name, "s_u/σ′v", "largest τ over σ′v before shearing", float(tau.max() / vertical))
    normal: FloatArray | None = None if volume_kept else np.full(tau.size, vertical)
    for name, sign, start in (("normal_stress", 1.0, 0.0), ("pore_pressure", -1.0, vertical)):
        one = first_of(series, name)
        if volume_kept and normal is None and one is not None:
            normal = np.asarray(start + sign * np.interp(strain, *rising(one)))
    if normal is None:
        why = "a test at constant volume without normal_stress or pore_pressure gives no effective stress"
        yield ClassicalValue(part.name, "φ", method, None, why, "degree")
        return
    good = normal > 0.0
    angle = math.degrees(math.atan(float((tau[good] / normal[good]).max()))) if good.any() else None
    yield ClassicalValue(part.name, "φ", method, angle, "" if good.any() else "σ′v is nowhere above 0 kPa", "degree")
