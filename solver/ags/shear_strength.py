"""Triaxial tests: stresses at failure, as TREG/TRET (effective) and TRIG/TRIT (total) hold them.

The curves are not in these groups.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

from geoswarm.solver.ags.specimens import Specimen, details_of, specimen_of, without_test
from geoswarm.solver.ags.tables import AgsError, AgsFile, AgsGroup, AgsRow
from geoswarm.solver.parameter_estimates.mohr_circles import FailureLine, mohr_circles
from geoswarm.solver.parameter_estimates.values import NoEvaluationError

__all__ = ["Failure", "ShearTest", "shear_tests", "strength_of"]

Drainage: TypeAlias = Literal["drained", "undrained", "total"]

_DRAINED = frozenset({"CD", "CDM", "CIDC", "CIDE", "CADC", "CADE"})
_UNDRAINED = frozenset({"CU", "CUM", "CIUC", "CIUCM", "CIUE", "CAUC", "CAUE", "UUP"})
_EXTENSION = frozenset({"CIDE", "CADE", "CIUE", "CAUE"})
_SEVERAL_STAGES = frozenset({"CDM", "CUM", "CIUCM", "UUM"})


@dataclass(frozen=True, slots=True)
class Failure:
    """One specimen, or one stage of a specimen, at failure; None for what the file does not say.

    Parameters
    ----------
    number
        Of the test or stage.
    deviator_stress
        At failure, kPa, without sign.
    strain
        Axial strain at failure, without unit.
    axial, radial
        Effective stresses before shearing, kPa.
    pore_pressure, pore_pressure_at_failure
        Before shearing, and at failure, kPa.
    smaller
        The smaller of axial and radial stress at failure, kPa: effective, or total in a test without pore pressures.
        In extension it is the axial one.
    rate
        Axial strain in a day.
    modulus
        Secant modulus at half the deviator stress, kPa.
    void_ratio
        At the beginning.
    undrained
        Undrained shear strength, kPa, as the file gives it.
    """

    number: str
    deviator_stress: float
    strain: float | None
    axial: float | None
    radial: float | None
    pore_pressure: float | None
    pore_pressure_at_failure: float | None
    smaller: float | None
    rate: float | None
    modulus: float | None
    void_ratio: float | None
    undrained: float | None = None


@dataclass(frozen=True, slots=True)
class ShearTest:
    """A set of specimens, or of stages of one specimen.

    ``laboratory`` is the cohesion, kPa, and the friction angle, degree, that the laboratory has found.
    """

    specimen: Specimen
    groups: str
    kind: str
    drainage: Drainage
    extension: bool
    several_stages: bool
    failures: tuple[Failure, ...]
    laboratory: tuple[float | None, float | None]
    criterion: str


def shear_tests(file: AgsFile) -> tuple[list[ShearTest], list[tuple[Specimen, str]]]:
    """Return the tests of a file, and those that cannot be understood, with the reason.

    Raises
    ------
    AgsError
        A general group is missing.
    """
    tests: list[ShearTest] = []
    without: list[tuple[Specimen, str]] = []
    for general, details, read in (("TREG", "TRET", _effective), ("TRIG", "TRIT", _total)):
        for above, row, below, rows in details_of(file, general, details):
            try:
                tests.append(read(above, row, below, rows))
            except AgsError as error:
                without.append((specimen_of(above, row), str(error)))
        without += without_test(file, general, details)
    return tests, without


def strength_of(tests: Sequence[ShearTest]) -> FailureLine:
    """Lay a line along the circles of some tests; raises NoEvaluationError where there is none."""
    circles = [
        (one.smaller + one.deviator_stress, one.smaller)
        for test in tests
        for one in test.failures
        if one.smaller is not None and one.deviator_stress > 0.0
    ]
    if not circles:
        raise NoEvaluationError("no test gives both principal stresses at failure")
    return mohr_circles([first for first, _ in circles], [third for _, third in circles])


def _effective(general: AgsGroup, row: AgsRow, details: AgsGroup, rows: Sequence[AgsRow]) -> ShearTest:
    kind = general.text(row, "TREG_TYPE").upper()
    if kind not in _DRAINED | _UNDRAINED:
        raise general.error(row, "TREG_TYPE", f"one of {', '.join(sorted(_DRAINED | _UNDRAINED))} is accepted")
    drained, extension = kind in _DRAINED, kind in _EXTENSION
    laboratory = (
        general.number(row, "TREG_COH", "kPa", least=0.0, default_unit="kPa"),
        general.number(row, "TREG_PHI", "degree", least=0.0, default_unit="deg"),
    )
    return ShearTest(
        specimen_of(general, row),
        "TREG/TRET",
        kind,
        "drained" if drained else "undrained",
        extension,
        kind in _SEVERAL_STAGES,
        tuple(_failure(details, one, str(n), drained, extension) for n, one in enumerate(rows, start=1)),
        laboratory,
        general.text(row, "TREG_FCR"),
    )


def _failure(details: AgsGroup, row: AgsRow, position: str, drained: bool, extension: bool) -> Failure:
    def pressure(name: str) -> float | None:
        return details.number(row, f"TRET_{name}", "kPa", default_unit="kPa")

    deviator = abs(details.needed(row, "TRET_DEVF", "kPa", above=-1e9, default_unit="kPa"))
    same = details.number(row, "TRET_CONP", "kPa", above=0.0, default_unit="kPa")
    axial = details.number(row, "TRET_CVP", "kPa", above=0.0, default_unit="kPa") or same
    radial = details.number(row, "TRET_CRP", "kPa", above=0.0, default_unit="kPa") or same
    before, at_failure = pressure("PWPI"), pressure("PWPF")
    before = pressure("BACK") if before is None else before
    cell = pressure("CELL")
    pore = before if at_failure is None and drained else at_failure
    side = cell - pore if cell is not None and pore is not None else radial if drained else None
    smaller = side if side is None or not extension else side - deviator
    strain = details.number(row, "TRET_STRN", "", default_unit="%")
    return Failure(
        details.text(row, "TRET_TESN") or position,
        deviator,
        None if strain is None else abs(strain),
        axial,
        radial,
        before,
        at_failure,
        smaller,
        details.number(row, "TRET_STRR", "1/day", least=0.0, default_unit="%/hr"),
        details.number(row, "TRET_E50", "kPa", above=0.0, default_unit="MPa"),
        details.number(row, "TRET_IVR", "", above=0.0),
    )


def _total(general: AgsGroup, row: AgsRow, details: AgsGroup, rows: Sequence[AgsRow]) -> ShearTest:
    kind = general.text(row, "TRIG_TYPE").upper() or "UU"
    failures = []
    for position, one in enumerate(rows, start=1):
        deviator = details.number(one, "TRIT_DEVF", "kPa", above=0.0, default_unit="kPa")
        strength = details.number(one, "TRIT_CU", "kPa", above=0.0, default_unit="kPa")
        if deviator is None:
            deviator = 2.0 * details.needed(one, "TRIT_CU", "kPa", default_unit="kPa")
        cell = details.number(one, "TRIT_CELL", "kPa", least=0.0, default_unit="kPa")
        strain = details.number(one, "TRIT_STRN", "", least=0.0, default_unit="%")
        number = details.text(one, "TRIT_TESN") or str(position)
        failures.append(Failure(number, deviator, strain, None, None, None, None, cell, None, None, None, strength))
    return ShearTest(
        specimen_of(general, row),
        "TRIG/TRIT",
        kind,
        "total",
        False,
        kind in _SEVERAL_STAGES,
        tuple(failures),
        (None, None),
        "",
    )
