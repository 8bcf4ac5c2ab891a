"""What stands by limit equilibrium stands after a change of strength, and what does not falls."""

from __future__ import annotations

from itertools import cycle, product
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.errors import DivergedError
from geoswarm.solver.forward.cross_section import SectionModel, SectionSpec
from geoswarm.verification.specimens.infinite_slopes import LENGTH, WEIGHT, InfiniteSlope
from tests.variants import variants


@pytest.mark.parametrize(
    ("slope", "path"),
    [
        (InfiniteSlope(20.0, 5.0, 0.0, 1.3, 0.0, 0.0), "steps"),
        (InfiniteSlope(20.0, 5.0, 0.0, 1.02, 0.0, None), "associated"),
        (InfiniteSlope(20.0, 5.0, 2.0, 1.02, 1.0, 0.0), "direct"),
    ],
)
def test_an_infinite_slope_stands_after_its_strength_has_changed(slope: InfiniteSlope, path: str) -> None:
    """Without dilatancy a band along the slope carries tan = sin(phi) only: 1.02 is found with associated flow."""
    result = slope.calculate()
    assert result.path == path
    stress = -result.stress
    centre, half = 0.5 * (stress[..., 0] + stress[..., 1]), 0.5 * (stress[..., 0] - stress[..., 1])
    radius = np.hypot(half, stress[..., 3])
    phi = np.radians(slope.friction)
    excess = radius - centre * np.sin(phi) - slope.c * np.cos(phi)
    assert excess.max() < 1.0e-6 * WEIGHT * slope.depth
    # What no displacement can have changed: the weight is carried.
    assert result.reactions[:, 1].sum() == pytest.approx(WEIGHT * slope.depth * LENGTH * slope.depth, rel=1.0e-5)


@pytest.mark.parametrize(("c", "dilatancy"), [(0.0, 0.0), (2.0, 1.0)])
def test_an_infinite_slope_falls_below_its_strength(c: float, dilatancy: float) -> None:
    assert not InfiniteSlope(20.0, 5.0, c, 0.97, dilatancy, 0.0).stands()


@pytest.mark.slow
def test_forty_slopes_stand_and_those_below_their_strength_fall() -> None:
    """Safety 1.02 to 2, c = 0 to 10 kPa, with and without cut-off, of five angles and dilatancies in turn."""
    kinds = cycle(((20.0, 0.0), (20.0, 1.0), (12.0, 0.5), (30.0, 0.0), (25.0, 0.0)))
    slopes = [
        InfiniteSlope(angle, 5.0, c, safety, dilatancy, cutoff)
        for (c, cutoff, safety), (angle, dilatancy) in zip(
            product((0.0, 0.5, 2.0, 10.0), (0.0, None), (1.02, 1.05, 1.1, 1.3, 2.0, 0.8, 0.97)), kinds, strict=False
        )
    ]
    standing = [slope for slope in slopes if slope.safety > 1.0]
    assert len(standing) >= 40
    assert [slope for slope in slopes if slope.stands() != (slope in standing)] == []


def _section(c: float, phi: float) -> dict[str, Any]:
    """A problem's forward model: 100 m along a slope of 20 degree, 5 m deep, held at its ends."""
    strength = {"law": "mohr_coulomb", "E": 1.0e5, "nu": 0.3, "c": c, "phi": phi, "unit_weight": WEIGHT}
    return {
        "kind": "section",
        "surface": [[0, "100 * tan(20 * pi / 180)"], [100, 0]],
        "layers": [{"name": "soil", "thickness": 5, "rows": 5}],
        "element_length": 2.5,
        "points": {"A": {"x": 50}},
        "materials": {"elastic": {"law": "elastic", "E": 1.0e5, "nu": 0.3, "unit_weight": WEIGHT}, "soil": strength},
        "fixities": {"left": "horizontal", "right": "horizontal", "bottom": "both"},
        "phases": [
            {"name": "weight", "kind": "gravity", "materials": {"soil": "elastic"}},
            {"name": "strength", "kind": "plastic", "materials": {"soil": "soil"}},
            {"name": "rest", "kind": "creep", "duration": 1},
        ],
    }


@pytest.mark.parametrize(
    ("c", "phi", "stands"),
    variants([(0.0, 25.3, True), (2.0, 19.4, True), (0.0, 18.1, False)], {2.0}),
)
def test_a_long_slope_of_a_problem_file_stands_or_falls(c: float, phi: float, stands: bool) -> None:
    """Safety 1.3, 1.03 and 0.9; its ends add less than 0.06. Cracked ground at its head does not move without end."""
    model = SectionModel(SectionSpec.model_validate(_section(c, phi)))
    if stands:
        run = model.calculate({})
        assert np.abs(run.results[1].displacements).max() < 0.1
    else:
        with pytest.raises(DivergedError, match="'strength': no equilibrium"):
            model.calculate({})
