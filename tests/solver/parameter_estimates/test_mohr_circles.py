"""Lines along Mohr circles: exact circles give the line back, scattered ones the least squares of their gaps."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import least_squares

from geoswarm.solver.parameter_estimates.mohr_circles import mohr_circles
from geoswarm.solver.parameter_estimates.values import NoEvaluationError


def largest(third: np.ndarray, c: float, phi: float) -> np.ndarray:
    """Mohr and Coulomb: sigma_1 = sigma_3 tan^2(45 + phi/2) + 2 c tan(45 + phi/2)."""
    root = math.tan(math.radians(45.0 + 0.5 * phi))
    return np.asarray(third * root**2 + 2.0 * c * root)


@pytest.mark.parametrize(("c", "phi"), [(0.0, 33.0), (12.0, 21.0), (150.0, 5.0), (3.0, 60.0)])
def test_exact_circles_give_their_line(c: float, phi: float) -> None:
    third = np.array([30.0, 90.0, 310.0])
    found = mohr_circles(largest(third, c, phi), third)
    assert found.friction_angle == pytest.approx(phi, rel=1e-9)
    assert found.cohesion == pytest.approx(c, abs=1e-9)
    assert found.gap == pytest.approx(0.0, abs=1e-9)


def test_scattered_circles_have_the_least_gaps() -> None:
    third = np.array([50.0, 100.0, 200.0, 400.0])
    first = largest(third, 15.0, 25.0) + np.array([9.0, -14.0, 11.0, -4.0])
    s, t = 0.5 * (first + third), 0.5 * (first - third)

    def gaps(line: np.ndarray) -> np.ndarray:  # distance of the centre from the line, less the radius
        c, phi = line
        return np.asarray((c + s * math.tan(phi)) / math.hypot(1.0, math.tan(phi)) - t)

    best = least_squares(gaps, [10.0, 0.4], xtol=1e-14, ftol=1e-14, gtol=1e-14)
    found = mohr_circles(first, third)
    assert found.cohesion == pytest.approx(best.x[0], rel=1e-5)
    assert math.radians(found.friction_angle) == pytest.approx(best.x[1], rel=1e-6)
    assert found.gap == pytest.approx(math.sqrt(2.0 * best.cost / 4.0), rel=1e-8)


def test_one_circle_or_a_negative_cohesion_gives_a_line_through_the_origin() -> None:
    one = mohr_circles([300.0], [100.0])
    assert (one.through_origin, one.cohesion) == (True, 0.0)
    assert one.friction_angle == pytest.approx(30.0, rel=1e-12)
    third = np.array([50.0, 400.0])
    steep = mohr_circles(largest(third, 0.0, 30.0) + np.array([-30.0, 30.0]), third)
    assert (steep.through_origin, steep.cohesion) == (True, 0.0)


@pytest.mark.parametrize(
    ("first", "third", "message"),
    [
        ([], [], "at least one"),
        ([1.0, 2.0], [1.0], "as many largest as smallest"),
        ([100.0], [100.0], "must be above the smallest"),
        ([math.nan], [100.0], "must be above the smallest"),
        ([100.0], [-200.0], "the centre of a circle is at -50 kPa; above 0 is needed"),
        ([200.0, 420.0], [100.0, 400.0], "the radii change by -0.154 of the change of the centres"),
    ],
)
def test_what_has_no_line_is_reported(first: list[float], third: list[float], message: str) -> None:
    with pytest.raises(NoEvaluationError, match=message):
        mohr_circles(first, third)
