"""Laboratory tests with any law: closed forms, and the general driver beside the fast path."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.forward import staged_history
from geoswarm.solver.forward.isotropic_compression import IsotropicCompressionSpec
from geoswarm.solver.forward.oedometer import OedometerSpec
from tests.solver.forward.staged_tests import IDENTIFIED

STAGES = [{"stress": 60.0, "duration": 1.0}, {"stress": 150.0, "duration": 2.0}, {"stress": 40.0, "duration": 1.0}]
STRESSES = np.array([60.0, 150.0, 40.0])
YOUNG, POISSON = 5.0e3, 0.3
CONFINED = YOUNG * (1.0 - POISSON) / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON))


def oedometer(material: str, **changes: object) -> OedometerSpec:
    """Three loads at small strain."""
    section = {"height": 0.02, "initial_stress": 20.0, "stages": STAGES, "geometry": "fixed"}
    return OedometerSpec.model_validate({**section, "material": material, **changes})


@pytest.mark.parametrize("discretization", ["material_point", "finite_element"])
def test_an_elastic_specimen_settles_by_the_confined_modulus(discretization: str) -> None:
    extra = {"unit_weight": 0.0} if discretization == "finite_element" else {}
    model = oedometer("elastic", discretization=discretization, **extra).build()
    run = model.prepare({"stage_axial_strain": np.array([1.0, 2.0, 3.0])})
    found = run({"E": YOUNG, "nu": POISSON})["stage_axial_strain"]
    assert found == pytest.approx((STRESSES - 20.0) / CONFINED, rel=1.0e-6)
    by_shear = run({"G": YOUNG / 2.6, "nu": POISSON})["stage_axial_strain"]
    assert by_shear == pytest.approx(found, rel=1.0e-12)


def test_an_elastic_specimen_shrinks_by_the_bulk_modulus() -> None:
    section = {"height": 0.1, "diameter": 0.05, "initial_stress": 20.0, "stages": STAGES, "geometry": "fixed"}
    model = IsotropicCompressionSpec.model_validate({**section, "material": "elastic"}).build()
    run = model.prepare({"stage_volumetric_strain": np.array([1.0, 2.0, 3.0])})
    found = run({"E": YOUNG, "nu": POISSON})["stage_volumetric_strain"]
    assert found == pytest.approx((STRESSES - 20.0) * 3.0 * (1.0 - 2.0 * POISSON) / YOUNG, rel=1.0e-6)


def test_mohr_coulomb_is_elastic_until_unloading_reaches_passive_failure() -> None:
    model = oedometer("mohr_coulomb", K0=0.5).build()
    run = model.prepare({"stage_axial_strain": np.array([1.0, 2.0, 3.0])})
    soil = {"E": YOUNG, "nu": POISSON, "c": 0.0, "phi": 30.0}
    first, second, third = run(soil)["stage_axial_strain"].tolist()
    assert first == pytest.approx(40.0 / CONFINED, rel=1.0e-6)
    assert second == pytest.approx(130.0 / CONFINED, rel=1.0e-6)
    # sigma_h = 10 + 3/7 (sigma_v - 20), unloading along it: sigma_h/sigma_v stays below K_p = 3.
    assert third == pytest.approx(20.0 / CONFINED, rel=1.0e-6)
    # With phi = 5 degree K_a = 0.84: plastic from the beginning of the load on.
    weak = run(soil | {"phi": 5.0, "c": 10.0})["stage_axial_strain"]
    assert weak[1] > second


def test_the_general_driver_gives_what_the_fast_path_gives(monkeypatch: pytest.MonkeyPatch) -> None:
    x = {"axial_strain": np.array([0.01, 0.5, 1.0, 1.2, 3.0, 3.5]), "stage_axial_strain": np.array([1.0, 2.0, 3.0])}
    spec = oedometer("soft_soil_creep", tolerance=1.0e-6, OCR=1.2)
    fast = spec.build().prepare(x)(IDENTIFIED)
    monkeypatch.setattr(staged_history, "FAST_PATHS", {})
    general = spec.build().prepare(x)(IDENTIFIED)
    for name in x:
        assert general[name] == pytest.approx(fast[name], abs=5.0e-6)


def test_the_lateral_stress_of_elasticity_follows_poissons_ratio() -> None:
    model = oedometer("elastic", K0=0.6).build()
    x = {"stage_lateral_stress": np.array([1.0, 2.0, 3.0]), "K0": np.array([0.0, 0.5, 1.0, 2.0])}
    found = model.prepare(x)({"E": YOUNG, "nu": POISSON})
    lateral = 0.6 * 20.0 + POISSON / (1.0 - POISSON) * (STRESSES - 20.0)
    assert found["stage_lateral_stress"] == pytest.approx(lateral, rel=1.0e-9)
    assert found["K0"] == pytest.approx([0.6, *(lateral[[0, 0, 1]] / STRESSES[[0, 0, 1]])], rel=1.0e-9)


def test_state_variables_of_the_general_driver_are_those_of_the_fast_path(monkeypatch: pytest.MonkeyPatch) -> None:
    times = np.array([0.0, 0.01, 0.5, 1.0, 1.2, 3.0, 3.5])
    x = {"lateral_stress": times, "log_pp": times, "stage_log_pp": np.array([1.0, 2.0, 3.0])}
    spec = oedometer("soft_soil_creep", tolerance=1.0e-6, OCR=1.2)
    fast = spec.build().prepare(x)(IDENTIFIED)
    alone = spec.build().prepare({"settlement": times})(IDENTIFIED)["settlement"]
    assert (spec.build().prepare({**x, "settlement": times})(IDENTIFIED)["settlement"] == alone).all()
    monkeypatch.setattr(staged_history, "FAST_PATHS", {})
    general = spec.build().prepare(x)(IDENTIFIED)
    assert general["lateral_stress"] == pytest.approx(fast["lateral_stress"], abs=0.02)
    for name in ("log_pp", "stage_log_pp"):
        assert general[name] == pytest.approx(fast[name], abs=2.0e-4)


def test_measured_K0_and_preconsolidation_of_the_incremental_oedometer() -> None:
    """Values of an independent integration of the rate equations (small strain), to the printed digits."""
    soil = {"lambda_star": 0.1, "kappa_star": 0.02, "mu_star": 0.005, "c": 0.0, "phi": 30.0, "K0nc": 0.5, "OCR": 1.3}
    stages = [
        {"stress": 100.0, "duration": 1.0},
        {"stress": 200.0, "duration": 1.0},
        {"stress": 400.0, "duration": 100.0},
    ]
    model = oedometer("soft_soil_creep", stages=stages, initial_stress=50.0, tolerance=1.0e-7).build()
    found = model.prepare({"K0": np.array([1.0, 2.0, 3.0, 102.0])})(soil)
    assert found["K0"] == pytest.approx([0.52826, 0.52972, 0.52972, 0.52981], abs=1.0e-5)


def test_the_preconsolidation_pressure_of_isotropic_creep() -> None:
    """p_p = p_p0 exp(mu*/(lambda* - kappa*) ln(1 + t/tau)) under a constant pressure that was there before."""
    section = {"height": 0.1, "diameter": 0.05, "initial_stress": 20.0, "stages": [{"stress": 20.0, "duration": 50.0}]}
    model = IsotropicCompressionSpec.model_validate(section).build()
    soil = {"lambda_star": 0.1, "kappa_star": 0.02, "mu_star": 0.004, "c": 0.0, "phi": 30.0}
    times = np.array([0.0, 0.3, 7.0, 50.0])
    found = model.prepare({"log_pp": times})(soil)["log_pp"]
    assert found == pytest.approx(math.log(20.0) + 0.05 * np.log1p(times), rel=1.0e-9)
    assert not {"K0", "lateral_stress"} & {info.name for info in model.series}


def test_finite_elements_have_no_series_of_states() -> None:
    names = {info.name for info in oedometer("soft_soil_creep", discretization="finite_element").build().series}
    assert not {"K0", "lateral_stress", "log_pp"} & names


@pytest.mark.parametrize(
    ("material", "soil"),
    [
        ("modified_cam_clay", {"M": 1.0, "lambda": 0.2, "kappa": 0.04, "nu": 0.3, "e0": 1.0}),
        ("soft_soil", {"lambda_star": 0.1, "kappa_star": 0.02, "c": 0.0, "phi": 28.0}),
    ],
)
def test_a_preconsolidation_above_the_stress_is_vertical_everywhere(material: str, soil: dict[str, float]) -> None:
    x = {"stage_axial_strain": np.array([1.0, 2.0, 3.0])}
    point = oedometer(material, POP=60.0, tolerance=1.0e-6).build().prepare(x)(soil)["stage_axial_strain"]
    mesh = oedometer(material, POP=60.0, tolerance=1.0e-6, discretization="finite_element", unit_weight=0.0)
    assert mesh.build().prepare(x)(soil)["stage_axial_strain"] == pytest.approx(point, rel=1.0e-2)
    # Elastic up to 80 kPa and beyond: the first load stays below it.
    lame = oedometer(material, OCR=20.0, tolerance=1.0e-6).build().prepare(x)(soil)["stage_axial_strain"]
    assert point[0] == pytest.approx(lame[0], rel=1.0e-6)
    assert point[1] > 2.0 * lame[1]


@pytest.mark.parametrize(
    ("material", "changes", "message"),
    [
        ("elastic", {"OCR": 2.0}, "OCR is given, which material elastic does not have"),
        ("elastic", {"tension_cutoff": None}, "tension_cutoff is given, which material elastic does not have"),
        ("mohr_coulomb", {"formulation": "untranslated"}, "formulation is given, which material mohr_coulomb"),
        ("mohr-coulomb", {}, "unknown law 'mohr-coulomb'"),
    ],
)
def test_what_a_law_does_not_have_is_reported(material: str, changes: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        oedometer(material, **changes)


def test_a_stress_at_rest_beyond_the_strength_is_inadmissible() -> None:
    run = oedometer("mohr_coulomb", K0=0.2).build().prepare({"settlement": np.array([0.5])})
    least = (1.0 - math.sin(math.radians(30.0))) / (1.0 + math.sin(math.radians(30.0)))
    with pytest.raises(InfeasibleError, match=f"K0 must be from {least:g}"):
        run({"E": YOUNG, "nu": POISSON, "c": 0.0, "phi": 30.0})
