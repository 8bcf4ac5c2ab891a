"""Materials refuse what has no meaning, and have usual defaults."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from geoswarm.solver.constitutive.soft_soil_creep.physics import soft_soil_creep
from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.fem.materials import InterfaceMaterial
from geoswarm.verification.specimens.soils import creeping, elastic, mohr_coulomb

SOIL = soft_soil_creep(0.1, 0.02, 0.005, 5.0, 25.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: elastic(1.0e4, 0.3, -1.0), "unit_weight must be 0 kN/m3 or more, got -1"),
        (lambda: InterfaceMaterial(0.0, 1.0, 0.0, 30.0), "normal_stiffness must be a value above 0 kPa/m, got 0"),
    ],
)
def test_a_constant_outside_its_range_is_named(make: Callable[[], object], message: str) -> None:
    with pytest.raises(InfeasibleError) as failure:
        make()
    assert message in str(failure.value)


def test_the_stress_ratio_at_rest_has_its_usual_default() -> None:
    assert elastic(1.0e4, 0.25).lateral_ratio() == pytest.approx(1.0 / 3.0)
    assert mohr_coulomb(1.0e4, 0.25, 0.0, 30.0).lateral_ratio() == pytest.approx(0.5)
    assert creeping(SOIL).lateral_ratio() == pytest.approx(SOIL.K0nc)
    assert mohr_coulomb(1.0e4, 0.25, 0.0, 30.0, K0=0.8).lateral_ratio() == 0.8
