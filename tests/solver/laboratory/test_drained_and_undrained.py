"""Drained and undrained tests of one law agree where they must, whatever the law is."""

from __future__ import annotations

import numpy as np
import pytest

from geoswarm.solver.laws.registry import BUILT_IN, find_law
from geoswarm.verification.specimens.laboratory import run, triaxial
from tests.solver.laws.checks import usual_values, void_ratio_for

SHEARING = [{"axial_strain": 0.03, "rate": 0.5}, {"axial_strain": 0.02, "rate": 0.5}]
STRAINS = np.array([1.0e-3, 5.0e-3, 0.015, 0.03])


@pytest.mark.parametrize("kind", BUILT_IN)
def test_water_without_stiffness_drains_and_stiff_water_is_rigid(kind: str) -> None:
    """The bulk modulus of water leads from the drained to the undrained test."""
    soil = usual_values(find_law(kind))
    names = ("q", "p", "volumetric_strain")
    for drainage, bulk in (("drained", 1.0e-4), ("undrained", 1.0e11)):
        limit = run(triaxial(kind, SHEARING, drainage=drainage, tolerance=1.0e-6), soil, STRAINS, *names)
        wet = triaxial(
            kind,
            SHEARING,
            drainage="undrained",
            tolerance=1.0e-6,
            water_bulk_modulus=bulk,
            **void_ratio_for(kind, 0.8),
        )
        found = run(wet, soil, STRAINS, *names)
        assert found[0] == pytest.approx(limit[0], rel=1.0e-4)
        assert found[1] == pytest.approx(limit[1], rel=1.0e-4)
        assert found[2] == pytest.approx(limit[2], abs=2.0e-6)


@pytest.mark.parametrize("kind", BUILT_IN)
def test_the_effective_path_is_the_same_whichever_total_stress_stays(kind: str) -> None:
    """The pore pressure is what that total stress leaves: u differs by q/3 and by q."""
    soil = usual_values(find_law(kind))
    u = {}
    for constant in ("radial_stress", "mean_stress", "axial_stress"):
        spec = triaxial(
            kind, [{**one, "constant": constant} for one in SHEARING], drainage="undrained", back_pressure=200.0
        )
        q, p, u[constant] = run(spec, soil, STRAINS, "q", "p", "pore_pressure")
        if constant == "radial_stress":
            first = q, p
        assert q == pytest.approx(first[0], rel=1.0e-9)
        assert p == pytest.approx(first[1], rel=1.0e-9)
    assert u["mean_stress"] == pytest.approx(300.0 - p, rel=1.0e-9)
    assert u["radial_stress"] - u["mean_stress"] == pytest.approx(q / 3.0, rel=1.0e-8)
    assert u["radial_stress"] - u["axial_stress"] == pytest.approx(q, rel=1.0e-8)
