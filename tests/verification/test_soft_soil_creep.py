"""Soft soil creep at a material point against exact solutions, published tables and independent integration.

Numbers marked "limit" are those of the differential equations, computed with independent code. Strains are small
strains, which the driver's equations are as they stand.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from geoswarm.solver.constitutive.soft_soil_creep.physics import SoftSoilCreep, soft_soil_creep
from geoswarm.solver.element_test.material_point import follow
from geoswarm.solver.element_test.setups import (
    confined_load,
    constant_rate_oedometer,
    drained_triaxial,
    isotropic_strain,
    undrained_triaxial,
)
from geoswarm.solver.forward.oedometer import OedometerSpec
from geoswarm.verification.specimens.soils import creep_law, creep_point, overconsolidation

INDEX = {"lambda_star": 0.1, "kappa_star": 0.02, "mu_star": 0.005}
BETA = 0.08 / 0.005


def isotropic(p: float) -> list[float]:
    return [p, p, p, 0.0, 0.0, 0.0]


@pytest.mark.parametrize("rate", [0.001, 0.1, 10.0])
@pytest.mark.parametrize("OCR", [1.0, 2.0])
def test_isotropic_constant_rate_of_strain(rate: float, OCR: float) -> None:
    soil = soft_soil_creep(**INDEX, c=0.0, phi=30.0)
    start = creep_point(isotropic(50.0), soil, OCR=OCR)
    duration = 0.12 / rate
    times = duration * np.array([0.05, 0.3, 0.6, 1.0])
    history = follow(creep_law(soil), start, [isotropic_strain(0.12, duration)], [times], tolerance=1.0e-8)
    growth = np.expm1(BETA * rate * times / 0.02)
    creep = 0.005 * 0.02 / 0.1 * np.log1p(0.1 * OCR**-BETA / (0.08 / 0.005 * rate) * growth)
    expected = 50.0 * np.exp((rate * times - creep) / 0.02)
    assert history.p == pytest.approx(expected, rel=1.0e-5)


@pytest.mark.parametrize("rate", [0.01, 1.0])
@pytest.mark.parametrize("c", [0.0, 20.0])
def test_steady_constant_rate_oedometer(rate: float, c: float) -> None:
    """OCR -> [mu* lambda*/(tau rate (lambda* - kappa*))]^(1/beta) and K0 -> K0nc, translated by the attraction."""
    soil = soft_soil_creep(**INDEX, c=c, phi=30.0)
    start = creep_point([25.0, 25.0, 50.0, 0.0, 0.0, 0.0], soil)
    history = follow(
        creep_law(soil), start, [constant_rate_oedometer(0.6, 0.6 / rate)], [[0.6 / rate]], tolerance=1.0e-7
    )
    stress = history.stress[0] + soil.attraction
    assert stress[0] / stress[2] == pytest.approx(soil.K0nc, rel=1.0e-4)
    assert overconsolidation(history, soil)[0] == pytest.approx(
        (0.005 * 0.1 / (rate * 0.08)) ** (1.0 / BETA), rel=1.0e-4
    )


def stolle_soil() -> SoftSoilCreep:
    return soft_soil_creep(0.106, 0.016, 0.004, 0.0, 30.0, 0.0, 0.25, M=1.29, tau=0.70 / 1440.0)


def test_stolle_constant_rate_oedometer() -> None:
    """Table I, case 1: 20 % in 2160 minutes from 10 kPa at OCR 6. Limit: K0 0.61716, creep 0.15006, OCR 1.20985."""
    soil = stolle_soil()
    start = creep_point(isotropic(10.0), soil, OCR=6.0)
    duration = 2160.0 / 1440.0
    history = follow(creep_law(soil), start, [constant_rate_oedometer(0.2, duration)], [[duration]])
    assert history.stress[0, 0] / history.stress[0, 2] == pytest.approx(0.61716, abs=2.0e-5)
    assert history.stress[0, 0] / history.stress[0, 2] == pytest.approx(0.617, abs=1.0e-3)
    assert overconsolidation(history, soil)[0] == pytest.approx(1.20985, rel=1.0e-4)
    creep = 0.09 * (history.internal[0, 0] - start.internal[0])
    assert creep == pytest.approx(0.15006, abs=1.0e-4)


@pytest.mark.parametrize(
    ("minutes", "limit", "published"), [(21600, 51.16, 51.06), (2160, 55.80, 55.70), (216, 60.87, 60.76)]
)
def test_stolle_undrained_peak(minutes: float, limit: float, published: float) -> None:
    """Table I, cases 2 to 4: peak deviatoric stress of undrained compression from 100 kPa, normally consolidated."""
    soil = stolle_soil()
    start = creep_point(isotropic(100.0), soil)
    duration = minutes / 1440.0
    times = duration * np.linspace(0.005, 1.0, 800)
    history = follow(creep_law(soil), start, [undrained_triaxial(0.2, duration)], [times])
    assert history.q.max() == pytest.approx(limit, rel=1.0e-3)
    assert history.q.max() == pytest.approx(published, rel=3.0e-3)
    assert history.q[-1] < history.q.max() - 1.0


OEDOMETER_TABLE = np.array(
    [
        # strain after the load, strain at the end, K0, OCR
        [0.010334, 0.048785, 0.52826, 1.00015],
        [0.058896, 0.118116, 0.52972, 1.00000],
        [0.128216, 0.187431, 0.52972, 1.00000],
        [math.nan, 0.210458, 0.52981, 1.33352],
    ]
)


def test_incremental_oedometer_to_the_printed_digits() -> None:
    soil = soft_soil_creep(**INDEX, c=0.0, phi=30.0)
    start = creep_point([25.0, 25.0, 50.0, 0.0, 0.0, 0.0], soil, OCR=1.3)
    stages = [confined_load(100.0, 1.0), confined_load(200.0, 1.0), confined_load(400.0, 100.0)]
    history = follow(creep_law(soil), start, stages, [[0.0, 1.0], [0.0, 1.0], [0.0, 1.0, 100.0]], tolerance=1.0e-7)
    after, end = [0, 2, 4], [1, 3, 5, 6]
    assert history.strain[after, 2] == pytest.approx(OEDOMETER_TABLE[:3, 0], abs=6.0e-7)
    assert history.strain[end, 2] == pytest.approx(OEDOMETER_TABLE[:, 1], abs=6.0e-7)
    assert history.stress[end, 0] / history.stress[end, 2] == pytest.approx(OEDOMETER_TABLE[:, 2], abs=6.0e-6)
    assert overconsolidation(history, soil)[end] == pytest.approx(OEDOMETER_TABLE[:, 3], abs=6.0e-6)
    assert history.strain[5, 2] - history.strain[3, 2] == pytest.approx(0.1 * math.log(2.0), abs=2.0e-6)


def test_incremental_oedometer_by_the_forward_model() -> None:
    stages = [
        {"stress": 100.0, "duration": 1.0},
        {"stress": 200.0, "duration": 1.0},
        {"stress": 400.0, "duration": 1.0},
        {"stress": 400.0, "duration": 99.0},
    ]
    for geometry in ("fixed", "updated"):
        spec = OedometerSpec.model_validate(
            {
                "height": 0.02,
                "initial_stress": 50.0,
                "stages": stages,
                "OCR": 1.3,
                "geometry": geometry,
                "tolerance": 1.0e-7,
            }
        )
        run = spec.build().prepare({"stage_axial_strain": np.arange(1.0, 5.0)})
        result = run({**INDEX, "c": 0.0, "phi": 30.0})
        expected = OEDOMETER_TABLE[:, 1] if geometry == "fixed" else -np.expm1(-OEDOMETER_TABLE[:, 1])
        assert result["stage_axial_strain"] == pytest.approx(expected, abs=6.0e-7)


@pytest.mark.parametrize(("rate", "stress"), [(0.01, 282.991), (0.1, 317.521), (1.0, 356.264)])
def test_constant_rate_vertical_stress(rate: float, stress: float) -> None:
    soil = soft_soil_creep(**INDEX, c=0.0, phi=30.0)
    start = creep_point([25.0, 25.0, 50.0, 0.0, 0.0, 0.0], soil, OCR=1.3)
    history = follow(
        creep_law(soil), start, [constant_rate_oedometer(0.15, 0.15 / rate)], [[0.15 / rate]], tolerance=1.0e-7
    )
    assert history.stress[0, 2] == pytest.approx(stress, abs=1.0e-3)


@pytest.mark.parametrize("psi", [0.0, 5.0, 25.0])
def test_mohr_coulomb_triaxial_strength(psi: float) -> None:
    """c = 5 kPa, phi = 25 degree, cell pressure 100 kPa: q_f = 162.0881 kPa, whatever the dilatancy."""
    soil = soft_soil_creep(0.1, 0.02, 1.0e-5, 5.0, 25.0, psi)
    start = creep_point(isotropic(100.0), soil, OCR=50.0)
    history = follow(creep_law(soil), start, [drained_triaxial(0.1, 100.0, 1.0)], [[0.5, 1.0]])
    assert history.q == pytest.approx([162.0881, 162.0881], abs=1.0e-4)
    volume, axial = np.diff(history.strain[:, :3].sum(axis=1))[0], np.diff(history.strain[:, 2])[0]
    sine = math.sin(math.radians(psi))
    assert volume / axial == pytest.approx(-2.0 * sine / (1.0 - sine), abs=1.0e-6)


def test_large_one_dimensional_compaction() -> None:
    """Ten times the stress with lambda* = 0.1: logarithmic strain 0.23026, engineering strain 0.20567."""
    stages = [{"stress": float(load), "duration": 1.0} for load in np.geomspace(50.0, 5000.0, 161)]
    spec = OedometerSpec.model_validate({"height": 0.02, "initial_stress": 50.0, "stages": stages, "zero_at_stage": 1})
    soil = {**INDEX, "mu_star": 1.0e-4, "c": 0.0, "phi": 30.0}
    fixed = spec.model_copy(update={"geometry": "fixed"}).build()
    x = np.array([81.0, 161.0])
    logarithmic = np.diff(fixed.prepare({"stage_axial_strain": x})(soil)["stage_axial_strain"])[0]
    assert logarithmic == pytest.approx(0.23026, rel=1.0e-4)
    remaining = 1.0 - spec.build().prepare({"stage_axial_strain": x})(soil)["stage_axial_strain"]
    assert 1.0 - remaining[1] / remaining[0] == pytest.approx(0.20567, rel=1.0e-4)
