"""Laboratory tests as boundary value problems: as the material point without weight, and what weight changes."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from geoswarm.solver.arrays import FloatArray
from tests.solver.forward.staged_tests import (
    IDENTIFIED,
    ISOTROPIC_IDENTIFIED,
    isotropic_spec,
    observation_times,
    oedometer_spec,
)

FINE = {"tolerance": 4.0e-8}
ELEMENTS = {"discretization": "finite_element", **FINE}


def settlements(values: dict[str, float], **changes: object) -> FloatArray:
    spec = oedometer_spec(**changes)
    run = spec.build().prepare({"settlement": observation_times(spec)})
    return run(values)["settlement"]


@pytest.mark.parametrize("geometry", ["updated", "fixed"])
def test_without_weight_the_oedometer_is_that_of_the_material_point(geometry: str) -> None:
    point = settlements(IDENTIFIED, geometry=geometry, **FINE)
    elements = settlements(IDENTIFIED, geometry=geometry, unit_weight=0.0, **ELEMENTS)
    assert point[-1] == pytest.approx(3.57e-3, rel=0.15)  # published set, independent implementation: 3.57 mm
    assert np.abs(elements - point).max() < 1.0e-4 * point[-1]


def test_without_weight_isotropic_compression_is_that_of_the_material_point() -> None:
    found = {}
    for name, changes in (("point", FINE), ("elements", {**ELEMENTS, "unit_weight": 0.0})):
        spec = isotropic_spec(**changes)
        times = observation_times(spec)
        series = ("axial_displacement", "radial_displacement", "volumetric_strain")
        found[name] = spec.build().prepare(dict.fromkeys(series, times))(ISOTROPIC_IDENTIFIED)
    for name, point in found["point"].items():
        assert point[-1] > 0.0
        assert np.abs(found["elements"][name] - point).max() < 1.0e-4 * point[-1], name


def test_weight_stiffens_the_first_load_as_the_higher_initial_stress_explains() -> None:
    """ln(stress) before the load grows by the mean of ln(1 + gamma z/s0), and the settlement falls by lambda* of it.

    c = 0 makes compression logarithmic in the vertical stress; creep is the same in both.
    """
    values = {**IDENTIFIED, "c": 0.0, "mu_star": 5.0e-4}
    changes = {"geometry": "fixed", "stages": [{"stress": 100.0, "duration": 1.0}]}
    spec = oedometer_spec(**changes)
    weight, height, initial = 17.85, spec.height, spec.initial_stress
    light = settlements(values, unit_weight=0.0, **changes, **ELEMENTS)[-1]
    heavy = settlements(values, mesh={"columns": 1, "rows": 8}, **changes, **ELEMENTS)[-1]
    z = (np.arange(1000) + 0.5) / 1000.0 * height
    expected = height * values["lambda_star"] * float(np.mean(np.log(1.0 + weight * z / initial)))
    expected -= height * values["lambda_star"] * float(np.mean(np.log(1.0 + weight * z / 100.0)))
    assert light - heavy == pytest.approx(expected, rel=0.02)


def test_finer_meshes_and_other_diameters_give_the_same_curve_without_weight() -> None:
    coarse = settlements(IDENTIFIED, unit_weight=0.0, discretization="finite_element")
    fine = settlements(
        IDENTIFIED, unit_weight=0.0, discretization="finite_element", mesh={"columns": 2, "rows": 3}, diameter=0.07145
    )
    assert np.abs(fine - coarse).max() < 1.0e-3 * coarse[-1]


def test_elements_and_weight_belong_to_finite_elements() -> None:
    with pytest.raises(ValidationError, match="unit_weight and mesh are of a specimen with discretization"):
        oedometer_spec(unit_weight=18.0)
    with pytest.raises(ValidationError, match="'material_point' or 'finite_element'"):
        oedometer_spec(discretization="finite_elements")
