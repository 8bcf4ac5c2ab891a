from __future__ import annotations

import numpy as np
import pytest

from geoswarm.solver.errors import BadOutputError, NotFiniteError
from geoswarm.solver.objective import LeastSquares, ObservedSeries


def observed(series: str, y: list[float], point_weights: list[float], weight: float) -> ObservedSeries:
    x = np.arange(len(y), dtype=float)
    return ObservedSeries(series, x, np.array(y), np.array(point_weights), weight)


OBJECTIVE = LeastSquares(
    [observed("settlement", [1.0, 2.0, 4.0], [1.0, 1.0, 4.0], 2.0), observed("radial", [1.0, 1.0], [1.0, 1.0], 0.5)]
)


def test_equations_1_and_2_by_hand() -> None:
    misfits = OBJECTIVE.misfits({"settlement": np.array([1.0, 3.0, 5.0]), "radial": np.array([3.0, 1.0])})
    assert misfits == {"settlement": pytest.approx((0 + 1 + 4) / 3, rel=1e-15), "radial": pytest.approx(2.0, rel=1e-15)}
    assert OBJECTIVE.value(misfits) == pytest.approx(2 * 5 / 3 + 0.5 * 2, rel=1e-15)


def test_perfect_responses_give_zero() -> None:
    misfits = OBJECTIVE.misfits({"settlement": np.array([1.0, 2.0, 4.0]), "radial": np.array([1.0, 1.0])})
    assert OBJECTIVE.value(misfits) == 0.0


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_value_that_is_not_finite_is_named(bad: float) -> None:
    with pytest.raises(NotFiniteError, match=rf"series 'settlement' is {bad} at point 2 of 3 \(x = 1\)"):
        OBJECTIVE.responses({"settlement": np.array([1.0, bad, 4.0]), "radial": np.array([1.0, 1.0])})


def test_an_overflowing_misfit_is_a_failure() -> None:
    with pytest.raises(NotFiniteError, match="too large to be squared"):
        OBJECTIVE.misfits({"settlement": np.full(3, 1e200), "radial": np.array([1.0, 1.0])})


def test_a_missing_series_or_wrong_shape_is_bad_output() -> None:
    with pytest.raises(BadOutputError, match="series 'radial' is missing in the response; it has settlement"):
        OBJECTIVE.responses({"settlement": np.zeros(3)})
    with pytest.raises(BadOutputError, match=r"series 'settlement' has shape \(2,\), but 3 points"):
        OBJECTIVE.responses({"settlement": np.zeros(2), "radial": np.zeros(2)})
