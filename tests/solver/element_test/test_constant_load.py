"""The fast path of constant loads: accuracy, agreement with the general driver, honest failure."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest

from geoswarm.solver.constitutive.soft_soil_creep.physics import SoftSoilCreep, equivalent_pressure, soft_soil_creep
from geoswarm.solver.element_test.axial import confined_load, lateral_limits
from geoswarm.solver.element_test.boundary_conditions import Stage
from geoswarm.solver.element_test.constant_load import FAILED_SOIL, FINISHED, constant_load_history
from geoswarm.solver.element_test.material_point import follow
from geoswarm.solver.element_test.setups import confined_load as load_stage
from geoswarm.verification.specimens.soils import creep_law, creep_point

STRESSES = (9.0, 25.0, 100.0, 400.0, 100.0, 20.0, 200.0)
DURATIONS = (2.0, 1.0, 1.0, 1.0, 1.0, 3.0, 1.5)


def history(
    soil: SoftSoilCreep,
    tolerance: float,
    fractions: Sequence[float] = (),
    stresses: Sequence[float] = STRESSES,
    durations: Sequence[float] = DURATIONS,
    ratio: float = -1.0,
) -> tuple[int, np.ndarray, np.ndarray]:
    lateral = 0.2 * soil.K0nc if ratio < 0.0 else 0.2 * ratio
    p_eq = equivalent_pressure((0.2 + 2.0 * lateral) / 3.0, (0.2 - lateral) ** 2, soil)[0]
    times = np.concatenate([duration * np.array(fractions) for duration in durations])
    firsts = np.arange(len(durations) + 1) * len(fractions)
    status, _, _, output, ends = constant_load_history(
        soil,
        np.array(stresses),
        np.array(durations),
        ratio,
        0.2,
        lateral,
        math.log(p_eq),
        tolerance,
        times,
        firsts,
        np.empty((0, 2)),
        np.empty((0, 2)),
    )
    return status, output, ends


SOILS = {
    "paper": soft_soil_creep(0.082, 0.051, 1.46e-3, 25.0, 20.0),
    "soft": soft_soil_creep(0.3, 0.03, 0.02, 5.0, 25.0, 10.0),
    "hardly creeping": soft_soil_creep(0.1, 0.02, 2.0e-5, 10.0, 22.0),
    "strongly creeping": soft_soil_creep(0.12, 0.02, 0.1, 40.0, 18.0),
    "untranslated": soft_soil_creep(0.1, 0.02, 0.005, 8.0, 25.0, formulation="untranslated"),
    "untranslated at the cut-off": soft_soil_creep(0.0287, 0.00743, 0.0488, 14.0, 32.8, formulation="untranslated"),
}
FRACTIONS = (1.0e-6, 1.0e-4, 1.0e-3, 1.0e-2, 0.1, 0.3, 0.7, 1.0)


@pytest.mark.parametrize("name", SOILS)
@pytest.mark.parametrize("tolerance", [1.0e-4, 4.0e-5, 1.0e-5])
def test_the_error_is_below_the_tolerance_everywhere(name: str, tolerance: float) -> None:
    fine_status, fine, fine_ends = history(SOILS[name], 0.1 * tolerance, FRACTIONS)
    status, output, ends = history(SOILS[name], tolerance, FRACTIONS)
    _, halved, _ = history(SOILS[name], 0.5 * tolerance, FRACTIONS)
    assert fine_status == FINISHED
    assert status == FINISHED
    assert np.abs(output - fine).max() < tolerance
    assert np.abs(output - halved).max() < tolerance
    assert np.abs(ends - fine_ends).max() < tolerance


def test_values_do_not_depend_on_the_other_points() -> None:
    _, many, _ = history(SOILS["paper"], 4.0e-5, FRACTIONS)
    _, few, _ = history(SOILS["paper"], 4.0e-5, FRACTIONS[4:5])
    assert (many.reshape(len(DURATIONS), len(FRACTIONS), 2)[:, 4] == few).all()


@pytest.mark.parametrize("name", [name for name in SOILS if name != "hardly creeping"])
def test_the_general_driver_gives_the_same(name: str) -> None:
    soil = SOILS[name]
    lateral = 0.2 * soil.K0nc
    start = creep_point([lateral, lateral, 0.2, 0.0, 0.0, 0.0], soil)
    stages: list[Stage] = [load_stage(stress, time) for stress, time in zip(STRESSES, DURATIONS, strict=True)]
    general = follow(creep_law(soil), start, stages, [[0.3 * time, time] for time in DURATIONS], tolerance=1.0e-5)
    _, fast, _ = history(soil, 1.0e-7, (0.3, 1.0))
    assert general.strain[:, 2] == pytest.approx(fast[:, 0], abs=2.0e-6)
    assert np.abs(general.strain[:, [0, 1, 3, 4, 5]]).max() < 1.0e-10


def test_an_elastic_load_is_exact() -> None:
    soil = soft_soil_creep(0.1, 0.02, 0.005, 0.0, 30.0)
    lateral, strain, completed = confined_load(100.0, 60.0, 120.0, math.log(1.0e6), soil)
    assert completed
    slope = 0.15 / 0.85
    p_old, p_new = 220.0 / 3.0, (120.0 + 2.0 * (60.0 + 20.0 * slope)) / 3.0
    assert lateral == pytest.approx(60.0 + 20.0 * slope, rel=1.0e-13)
    assert strain == pytest.approx(0.02 * math.log(p_new / p_old), rel=1.0e-12)


def test_an_elastoplastic_load_is_exact() -> None:
    """Split at the contact with Mohr-Coulomb, it equals the sum of an elastic and a plastic part in closed form."""
    soil = soft_soil_creep(0.1, 0.02, 0.005, 0.0, 30.0, 10.0)
    active, elastic = 1.0 / 3.0, 0.15 / 0.85
    contact = (10.0 * 0.5 - elastic * 10.0) / (active - elastic)
    lateral, strain, completed = confined_load(10.0, 5.0, 60.0, math.log(1.0e6), soil)
    assert completed
    assert lateral == pytest.approx(60.0 * active, rel=1.0e-12)

    def p(axial: float, ratio: float) -> float:
        return axial * (1.0 + 2.0 * ratio) / 3.0

    first = 0.02 * math.log(p(contact, active) / p(10.0, 0.5))
    volume = 0.02 * math.log(60.0 / contact)
    shear_ratio = 1.5 * 0.7 / 1.15
    deviator = (1.0 - active) / p(1.0, active) / (3.0 * shear_ratio) * volume
    lateral_part, axial_part = volume / 3.0 - deviator / 2.0, volume / 3.0 + deviator
    psi = math.sin(math.radians(10.0))
    plastic = 2.0 * lateral_part * (1.0 - psi) / (1.0 + psi)
    assert strain == pytest.approx(first + axial_part + plastic, rel=1.0e-11)


def test_loading_in_parts_equals_loading_at_once() -> None:
    soil = soft_soil_creep(0.1, 0.02, 0.005, 3.0, 28.0, 5.0)
    at_once = confined_load(10.0, 5.5, 300.0, 5.0, soil)
    lateral, total = 5.5, 0.0
    axial = 10.0
    for target in np.linspace(10.0, 300.0, 38)[1:]:
        lateral, strain, _ = confined_load(axial, lateral, float(target), 5.0, soil)
        axial, total = float(target), total + strain
    assert lateral == pytest.approx(at_once[0], rel=1.0e-12)
    assert total == pytest.approx(at_once[1], rel=1.0e-11)


def test_unloading_follows_the_passive_limit_and_the_cut_off() -> None:
    soil = soft_soil_creep(0.1, 0.02, 0.005, 0.0, 20.0)
    lateral, _, completed = confined_load(800.0, 520.0, 5.0, 7.0, soil)
    assert completed
    assert lateral == pytest.approx(lateral_limits(5.0, soil)[1], rel=1.0e-12)


def test_constant_isotropic_stress_creeps_exactly() -> None:
    soil = SOILS["paper"]
    _, output, _ = history(soil, 1.0e-2, FRACTIONS, (100.0,), (50.0,), 1.0)
    start, pressure = 0.2 + soil.attraction, 100.0 + soil.attraction
    beta = (0.082 - 0.051) / 1.46e-3
    times = 50.0 * np.array(FRACTIONS)
    creep = 1.46e-3 * np.log1p(times * (pressure / start) ** beta)
    volume = 0.051 * math.log(pressure / start) + creep
    assert output.sum(axis=1) + output[:, 1] == pytest.approx(volume, rel=1.0e-12)


def test_a_load_above_the_strength_is_reported() -> None:
    status, _, _ = history(SOILS["soft"], 1.0e-5, (), (100.0, 200.0), (1.0, 1.0), 0.1)
    assert status == FAILED_SOIL
