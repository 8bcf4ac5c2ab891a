"""Materials refuse what has no meaning; interfaces take their constants from a soil."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from geoswarm.solver.constitutive.soft_soil_creep import soft_soil_creep
from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.fem.materials import (
    CONSTANTS,
    InterfaceMaterial,
    LinearElastic,
    MohrCoulomb,
    SoftSoilCreepMaterial,
    shear_modulus,
)

SOIL = soft_soil_creep(0.1, 0.02, 0.005, 5.0, 25.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: LinearElastic(0.0, 0.3), "young = 0: a value above 0 kPa is accepted"),
        (lambda: LinearElastic(1.0e4, 0.5), "poisson = 0.5: a value above -1 and below 0.5"),
        (lambda: LinearElastic(1.0e4, 0.3, -1.0), "unit_weight = -1"),
        (lambda: MohrCoulomb(1.0e4, 0.3, -1.0, 20.0), "c = -1"),
        (lambda: MohrCoulomb(1.0e4, 0.3, 1.0, 90.0), "phi = 90"),
        (lambda: MohrCoulomb(1.0e4, 0.3, 1.0, 20.0, 21.0), "psi = 21: a value from 0 to phi = 20 degree"),
        (lambda: MohrCoulomb(1.0e4, 0.3, 1.0, 20.0, tension_cutoff=-1.0), "tension_cutoff = -1"),
        (lambda: SoftSoilCreepMaterial(SOIL, OCR=0.9), "OCR = 0.9: 1 or more"),
        (lambda: SoftSoilCreepMaterial(SOIL, POP=-1.0), "POP = -1"),
        (lambda: InterfaceMaterial(0.0, 1.0, 0.0, 30.0), "normal_stiffness = 0"),
        (lambda: InterfaceMaterial.from_soil(1.0e3, 1.0, 30.0, 1.5, 0.1), "reduction = 1.5"),
    ],
)
def test_a_constant_outside_its_range_is_named(make: Callable[[], object], message: str) -> None:
    with pytest.raises(InfeasibleError) as failure:
        make()
    assert message in str(failure.value)


def test_an_interface_in_a_soil_is_weaker_and_softer() -> None:
    joint = InterfaceMaterial.from_soil(1.0e3, 10.0, 30.0, 0.5, 0.1)
    shear = 0.25 * 1.0e3
    assert joint.shear_stiffness == pytest.approx(shear / 0.1)
    assert joint.normal_stiffness == pytest.approx(2.0 * shear * 0.55 / 0.1 / 0.1)
    assert joint.c == pytest.approx(5.0)
    assert math.tan(math.radians(joint.phi)) == pytest.approx(0.5 * math.tan(math.radians(30.0)))


def test_constants_fit_into_their_row() -> None:
    for material in (LinearElastic(1.0e4, 0.3, 20.0), MohrCoulomb(1.0e4, 0.3, 5.0, 25.0), SoftSoilCreepMaterial(SOIL)):
        assert material.constants().shape == (CONSTANTS,)
    assert tuple(SoftSoilCreepMaterial(SOIL).constants()[2:]) == tuple(SOIL)


def test_the_stress_ratio_at_rest_has_its_usual_default() -> None:
    assert LinearElastic(1.0e4, 0.25).lateral_ratio() == pytest.approx(1.0 / 3.0)
    assert MohrCoulomb(1.0e4, 0.25, 0.0, 30.0).lateral_ratio() == pytest.approx(0.5)
    assert SoftSoilCreepMaterial(SOIL).lateral_ratio() == pytest.approx(SOIL.K0nc)
    assert MohrCoulomb(1.0e4, 0.25, 0.0, 30.0, K0=0.8).lateral_ratio() == 0.8


def test_the_shear_modulus_of_every_soil() -> None:
    assert shear_modulus(LinearElastic(2.6e4, 0.3)) == pytest.approx(1.0e4)
    bulk = (100.0 + SOIL.attraction) / SOIL.kappa_star
    assert shear_modulus(SoftSoilCreepMaterial(SOIL), 100.0) == pytest.approx(bulk * SOIL.shear_ratio)
