"""Shear tests as triaxial tests whose stresses at failure are known."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from geoswarm.solver.ags.parts import Part, Reading
from geoswarm.solver.ags.shear_strength import Failure, ShearTest
from geoswarm.solver.external.pest_control.names import word

if TYPE_CHECKING:
    from geoswarm.solver.laws.base import Law

__all__ = ["least_modulus", "no_test", "triaxial_parts"]

_RATE = 0.24
"""Axial strain in a day, for laws that ask for it: 1 % in an hour."""
_LARGEST = 0.5
"""Axial strain at failure beyond which something is wrong."""


def triaxial_parts(name: str, id: str, test: ShearTest, law: Law) -> tuple[list[Part], list[str]]:
    """Return the specimens of a test as parts of a problem, and what was left out or assumed.

    Parameters
    ----------
    name, id
        Of the parts, which get the number of the specimen, and of the test in the file.
    """
    reason = _of_no_use(test)
    if reason is not None:
        return [], [f"{id}: {reason}; no test is made of it"]
    notes: list[str] = []
    failures: Sequence[Failure] = test.failures
    if test.several_stages and len(failures) > 1:
        notes.append(
            f"{id}: of a specimen in several stages only the first is a test; the others serve the Mohr circles"
        )
        failures = failures[:1]
    parts = []
    for one in failures:
        missing = _missing(one)
        if missing is not None:
            notes.append(f"{id} test {one.number}: {missing}; no test is made of it")
            continue
        parts.append(_part(name, id, test, one, law, notes))
    if parts and {"OCR", "POP"} & {info.name for info in law.parameters}:
        notes.append(
            f"{id}: specimens are taken as normally consolidated under their stress before shearing; else give a "
            "part an OCR"
        )
    return parts, notes


def no_test(test: ShearTest) -> str | None:
    """Return why no problem can be made of a test; None: it can."""
    reasons = [_missing(one) for one in (test.failures[:1] if test.several_stages else test.failures)]
    return _of_no_use(test) or (None if None in reasons else next(iter(reasons), "it has no results"))


def _of_no_use(test: ShearTest) -> str | None:
    """What keeps all specimens of a test from being calculated."""
    if test.drainage == "total" or test.kind == "UUP":
        why = "total stresses" if test.drainage == "total" else "not consolidated"
        return f"{test.kind}, {why}: the effective stress before shearing is not known"
    if test.extension:
        return f"{test.kind}: the sign of q in extension is not laid down in the file"
    return None


def least_modulus(tests: Sequence[ShearTest]) -> float:
    """Return a Young's modulus, kPa, with which all tests fail before half their strain at failure.

    The mean of the secant moduli at half the deviator stress, where the file gives them and it is larger.
    """
    failures = [one for test in tests for one in test.failures if one.strain]
    secants = [one.deviator_stress / one.strain for one in failures if one.strain]
    given = [one.modulus for one in failures if one.modulus is not None]
    return max(2.0 * max(secants, default=1e3), sum(given) / len(given) if given else 0.0)


def _missing(one: Failure) -> str | None:
    if one.axial is None or one.radial is None:
        return "the effective stress at the end of consolidation (TRET_CONP, or TRET_CVP and TRET_CRP) is not given"
    if one.strain is None or not 0.0 < one.strain <= _LARGEST:
        told = "not given" if one.strain is None else f"{100.0 * one.strain:g} %"
        return (
            f"the axial strain at failure (TRET_STRN) is {told}; above 0 and at most {100.0 * _LARGEST:g} % is accepted"
        )
    return None


def _part(name: str, id: str, test: ShearTest, one: Failure, law: Law, notes: list[str]) -> Part:
    assert one.axial is not None
    assert one.radial is not None
    assert one.strain is not None
    strain = float(f"{one.strain:.12g}")
    shearing: dict[str, Any] = {"kind": "monotonic", "axial_strain": strain}
    if law.depends_on_time:
        shearing["rate"] = float(f"{one.rate or _RATE:.12g}")
        if not one.rate:
            notes.append(f"{id} test {one.number}: TRET_STRR is not given; 1 %/h is assumed")
    section: dict[str, Any] = {
        "kind": "triaxial",
        "material": law.kind,
        "initial_stress": one.axial,
        "initial_ratio": one.radial / one.axial,
        "drainage": test.drainage,
        "shearing": [shearing],
    }
    if one.void_ratio is not None:
        section["initial_void_ratio"] = one.void_ratio
    own = word(f"{name}_{one.number}")
    readings = [_reading("q", own, id, one, strain, one.deviator_stress)]
    undrained = test.drainage == "undrained"
    if undrained and one.pore_pressure is not None and one.pore_pressure >= 0.0:
        section["back_pressure"] = one.pore_pressure
        if one.pore_pressure_at_failure is not None:
            readings.append(_reading("pore_pressure", own, id, one, strain, one.pore_pressure_at_failure))
    elif undrained:
        notes.append(
            f"{id} test {one.number}: no pore pressure before shearing (TRET_PWPI): that at failure is not compared"
        )
    void = {"e0": {"value": one.void_ratio}} if one.void_ratio and "e0" in {i.name for i in law.parameters} else {}
    return Part(own, id, section, tuple(readings), void)


def _reading(series: str, name: str, id: str, one: Failure, strain: float, value: float) -> Reading:
    about = f"{series} of {id} test {one.number} at failure: axial strain, kPa"
    return Reading(
        series, f"{name}_{series}", about, (strain,), (value,), keys={"x_unit": "dimensionless", "y_unit": "kPa"}
    )
