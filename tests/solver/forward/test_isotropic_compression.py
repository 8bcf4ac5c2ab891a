"""Isotropic compression as a forward model."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pydantic import ValidationError

from geoswarm.solver.constitutive.soft_soil_creep.physics import soft_soil_creep
from geoswarm.solver.forward.isotropic_compression import IsotropicCompressionSpec
from tests.solver.forward.staged_tests import ISOTROPIC_IDENTIFIED, isotropic_spec

HEIGHT, DIAMETER = 0.09855, 0.04988
MODEL = isotropic_spec(initial_void_ratio=1.13).build()


def test_OCR_multiplies_the_pressure_shifted_by_the_attraction() -> None:
    """OCR (p + a) = p + POP + a: what the documentation says of OCR with cohesion."""
    attraction = ISOTROPIC_IDENTIFIED["c"] / math.tan(math.radians(ISOTROPIC_IDENTIFIED["phi"]))
    series = {"stage_volumetric_strain": np.array([1.0, 2.0, 3.0])}
    by_ratio = isotropic_spec(OCR=2.0).build().prepare(series)(ISOTROPIC_IDENTIFIED)
    by_stress = isotropic_spec(POP=0.2 + attraction).build().prepare(series)(ISOTROPIC_IDENTIFIED)
    for name in series:
        assert by_ratio[name] == pytest.approx(by_stress[name], rel=1.0e-9)


def closed_form(times: np.ndarray) -> np.ndarray:
    """Volume strain under the published loads: a creep law at constant stress in each stage, joined by hand."""
    values = ISOTROPIC_IDENTIFIED
    stiff, soft, creep = values["lambda_star"], values["kappa_star"], values["mu_star"]
    attraction = values["c"] / math.tan(math.radians(values["phi"]))
    pressure = p_p = 0.2 + attraction
    strain, start = 0.0, 0.0
    result = np.zeros_like(times)
    for stage in isotropic_spec().stages:
        loaded = stage.stress + attraction
        strain += soft * math.log(loaded / pressure)
        pressure = loaded
        rate = (pressure / p_p) ** ((stiff - soft) / creep)
        inside = (times > start) & (times <= start + stage.duration)
        result[inside] = strain + creep * np.log1p((times[inside] - start) * rate)
        total = creep * math.log1p(stage.duration * rate)
        strain += total
        p_p *= math.exp(total / (stiff - soft))
        start += stage.duration
    return result


def test_the_published_test_follows_the_closed_form() -> None:
    times = np.geomspace(1.0e-4, 21.0, 200)
    run = MODEL.prepare({"volumetric_strain": times, "axial_displacement": times, "radial_displacement": times})
    result = run(ISOTROPIC_IDENTIFIED)
    volume = closed_form(times)
    assert result["volumetric_strain"] == pytest.approx(1.0 - np.exp(-volume), rel=1.0e-11)
    assert result["axial_displacement"] == pytest.approx(HEIGHT * (1.0 - np.exp(-volume / 3.0)), rel=1.0e-11)
    assert result["radial_displacement"] == pytest.approx(0.5 * DIAMETER * (1.0 - np.exp(-volume / 3.0)), rel=1.0e-11)


def test_the_load_integral_of_the_published_test_is_kept() -> None:
    stages = isotropic_spec().stages
    integral = sum(stage.stress * stage.duration for stage in stages)
    assert integral == pytest.approx((30.0 * 3.0 + 50.0 * 17.0 + 450.0 + 800.0 * 21.0 * 24.0) / 24.0, rel=1.0e-12)


def test_stage_series_are_the_ends_of_the_stages() -> None:
    ends = np.cumsum([stage.duration for stage in isotropic_spec().stages])
    points = {"axial_displacement": ends, "stage_axial_displacement": np.arange(1.0, 4.0)}
    result = MODEL.prepare(
        {**points, "stage_void_ratio": np.arange(1.0, 4.0), "stage_volumetric_strain": np.arange(1.0, 4.0)}
    )(ISOTROPIC_IDENTIFIED)
    assert (result["axial_displacement"] == result["stage_axial_displacement"]).all()
    assert result["stage_void_ratio"] == pytest.approx(1.13 - 2.13 * result["stage_volumetric_strain"], rel=1.0e-12)


def test_zero_at_the_last_stage_counts_from_just_before_it() -> None:
    model = isotropic_spec(zero_at_stage=3).build()
    start = float(np.cumsum([stage.duration for stage in isotropic_spec().stages])[1])
    x = np.array([0.0, 0.5, 20.0])
    later = model.prepare({"axial_displacement": x, "volumetric_strain": x})(ISOTROPIC_IDENTIFIED)
    whole = MODEL.prepare({"axial_displacement": start + x, "volumetric_strain": start + x})(ISOTROPIC_IDENTIFIED)
    for name, values in later.items():
        assert values[0] == 0.0
        assert values == pytest.approx(whole[name] - whole[name][0], abs=1.0e-14)


def test_OCR_and_POP_delay_the_creep() -> None:
    def final(**parameters: float) -> float:
        run = MODEL.prepare({"stage_volumetric_strain": np.array([2.0])})
        return float(run({**ISOTROPIC_IDENTIFIED, **parameters})["stage_volumetric_strain"][0])

    assert final(POP=60.0) < final(POP=20.0) < final()
    attraction = soft_soil_creep(0.089, 0.0445, 2.33e-3, 27.0, 20.0).attraction
    assert final(OCR=1.5) == pytest.approx(final(POP=0.5 * (0.2 + attraction)), rel=1.0e-12)


def test_series_and_bad_sections() -> None:
    assert [info.name for info in MODEL.series] == [
        "axial_displacement",
        "radial_displacement",
        "volumetric_strain",
        "log_pp",
        "stage_axial_displacement",
        "stage_radial_displacement",
        "stage_volumetric_strain",
        "stage_log_pp",
        "stage_void_ratio",
    ]
    with pytest.raises(ValidationError, match="diameter"):
        isotropic_spec(diameter=0.0)
    with pytest.raises(ValidationError, match="diameter"):
        IsotropicCompressionSpec.model_validate(
            {"height": 0.1, "initial_stress": 1.0, "stages": [{"stress": 5.0, "duration": 1.0}]}
        )
    message = MODEL.check({"phi": 0.0})
    assert message is not None
    assert "needs friction" in message
