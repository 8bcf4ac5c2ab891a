"""The triaxial test with each built-in law: every kind of stage, and strength or critical state in closed form."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.element_test.material_point import follow, point_under
from geoswarm.solver.element_test.setups import drained_triaxial, undrained_triaxial
from geoswarm.solver.laws.registry import BUILT_IN, find_law
from geoswarm.verification.specimens.laboratory import run, triaxial
from tests.solver.laws.checks import usual_values, void_ratio_for

PACE = {"rate": 0.5}
SIN, COS = 0.5, math.sqrt(0.75)
STRENGTH = {"E": 2.0e4, "nu": 0.3, "c": 5.0, "phi": 30.0}
SOFT = {"lambda_star": 0.1, "kappa_star": 0.02, "c": 5.0, "phi": 30.0}


def soil_of(kind: str) -> dict[str, float]:
    """A usual soil."""
    return usual_values(find_law(kind))


@pytest.mark.parametrize("kind", BUILT_IN)
@pytest.mark.parametrize("drainage", ["drained", "undrained"])
def test_every_law_goes_through_every_kind_of_stage(kind: str, drainage: str) -> None:
    stages: list[dict[str, Any]] = [
        {"axial_strain": 0.01, **PACE},
        {"deviator_stress": 5.0, "duration": 0.1},
        {"kind": "cyclic", "axial_strain_amplitude": 1.0e-3, "cycles": 2, "period": 0.01},
        {"kind": "hold", "keep": "strain", "duration": 1.0},
        {"kind": "hold", "duration": 1.0},
        {"axial_strain": -0.02, **PACE},
    ]
    consolidation = [{"axial": 120.0, "duration": 0.5, "loading_time": 0.2}, {"axial": 150.0, "radial": "K0"}]
    spec = triaxial(kind, stages, drainage=drainage, consolidation=consolidation, **void_ratio_for(kind, 1.0))
    model = spec.build()
    numbers = {"stage_": np.arange(1.0, 7.0), "consolidation_": np.array([1.0, 2.0]), "cycle_": np.array([1.0, 2.0])}
    points = {
        info.name: next((x for start, x in numbers.items() if info.name.startswith(start)), np.array([0.0, -0.01]))
        for info in model.series
        if not info.name.startswith(("time_", "branch_", "path_"))
    }
    found = model.prepare(points)(soil_of(kind))
    assert all(np.isfinite(values[1:]).all() for values in found.values())
    assert found["stage_axial_strain"][[0, 3, 5]] == pytest.approx(
        [0.01, found["stage_axial_strain"][2], -0.02], abs=1.0e-10
    )
    assert found["stage_q"][[1, 4]] == pytest.approx([5.0, found["stage_q"][3]], rel=1.0e-8)
    assert found["consolidation_axial_strain"][1] > found["consolidation_axial_strain"][0] > 0.0
    assert 0.2 < found["consolidation_K0"][1] < 1.0
    if drainage == "undrained":
        assert found["stage_volumetric_strain"] == pytest.approx(np.zeros(6), abs=1.0e-10)
        total = found["stage_radial_stress"] + found["stage_pore_pressure"]
        radial = found["consolidation_q"][1] / -3.0 + found["consolidation_p"][1]
        assert total == pytest.approx(np.full(6, radial), rel=1.0e-9)
    else:
        assert found["stage_radial_stress"] == pytest.approx(np.full(6, found["stage_radial_stress"][0]), rel=1.0e-9)


@pytest.mark.parametrize("kind", BUILT_IN)
@pytest.mark.parametrize("drainage", ["drained", "undrained"])
def test_four_components_give_what_the_general_driver_gives_in_six(kind: str, drainage: str) -> None:
    soil = find_law(kind).soil(soil_of(kind))
    x = np.array([1.0e-3, 5.0e-3, 0.02])
    stage = drained_triaxial(0.02, 100.0, 0.04) if drainage == "drained" else undrained_triaxial(0.02, 0.04)
    start = point_under([100.0, 100.0, 100.0, 0.0, 0.0, 0.0], soil)
    history = follow(soil, start, [stage], [x / 0.5], tolerance=1.0e-7)
    shearing = [{"axial_strain": 0.02, **PACE}]
    q, p = run(triaxial(kind, shearing, drainage=drainage, tolerance=1.0e-7), soil_of(kind), x, "q", "p")
    assert q == pytest.approx(history.q, rel=1.0e-4)
    assert p == pytest.approx(history.p, rel=1.0e-4)


@pytest.mark.parametrize("kind", ["mohr_coulomb", "matsuoka_nakai", "drucker_prager", "soft_soil"])
def test_shearing_to_failure_ends_at_the_strength_of_the_law(kind: str) -> None:
    """sigma_1 - sigma_3 = (sigma_1 + sigma_3) sin(phi) + 2 c cos(phi); the cone has q = M p + k in extension, too."""
    parameters = SOFT if kind == "soft_soil" else STRENGTH
    M, k = 6.0 * SIN / (3.0 - SIN), 6.0 * 5.0 * COS / (3.0 - SIN)
    compression = (2.0 * 5.0 * COS + 2.0 * 100.0 * SIN) / (1.0 - SIN)
    extension = (2.0 * 5.0 * COS + 2.0 * 100.0 * SIN) / (1.0 + SIN)
    if kind == "drucker_prager":
        extension = (100.0 * M + k) / (1.0 + M / 3.0)
    end = 0.6 if kind == "soft_soil" else 0.1
    for way, strength in ((1.0, compression), (-1.0, extension)):
        (q,) = run(triaxial(kind, [{"axial_strain": way * end}]), parameters, way * end, "q")
        assert q == pytest.approx([way * strength], rel=1.0e-5)


@pytest.mark.parametrize("OCR", [1.0, 3.0])
def test_undrained_cam_clay_follows_its_path_to_the_critical_state(OCR: float) -> None:
    """p ((M^2 + eta^2)/M^2)^Lambda stays after yield (Wood 1990, section 5.4); u is what the cell pressure leaves."""
    M, plastic = 1.0, 0.8
    clay = {"M": M, "lambda": 0.2, "kappa": 0.04, "nu": 0.25, "e0": 1.0, "OCR": OCR}
    spec = triaxial("modified_cam_clay", [{"axial_strain": 0.8}], drainage="undrained", tolerance=1.0e-7)
    x = np.array([0.02, 0.1, 0.3, 0.8])
    names = ("q", "p", "pore_pressure", "e", "secant_modulus")
    q, p, u, e, secant = run(spec, clay, x, *names)
    at_yield = M * math.sqrt(OCR - 1.0)
    path = 100.0 * ((M**2 + at_yield**2) / (M**2 + (q / p) ** 2)) ** plastic
    assert p == pytest.approx(path, rel=1.0e-5)
    end = 100.0 * (OCR / 2.0) ** plastic
    assert p[-1] == pytest.approx(end, rel=1.0e-5)
    assert q[-1] == pytest.approx(M * end, rel=1.0e-5)
    assert u == pytest.approx(100.0 + q / 3.0 - p, rel=1.0e-9)
    assert e == pytest.approx(np.ones(4), rel=1.0e-9)
    assert secant == pytest.approx(q / x, rel=1.0e-9)
