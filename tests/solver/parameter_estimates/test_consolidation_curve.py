"""c_v, beginning, end and secondary compression of Terzaghi's series with and without secondary compression."""

from __future__ import annotations

import numpy as np
import pytest

from geoswarm.solver.parameter_estimates.consolidation_curve import log_time, root_time
from geoswarm.solver.parameter_estimates.values import NoEvaluationError
from geoswarm.verification.exact.consolidation import degree as terzaghi

C_V, PATH = 2.0e-3, 0.01  # m²/day, m: t_90 is 61 minutes
LABORATORY = np.array([0.1, 0.25, 0.5, 1, 2, 4, 8, 15, 30, 60, 120, 240, 480, 720, 1440]) / 1440.0
DENSE = 10.0 ** np.linspace(-5.0, 1.0, 241)


def degree(time: np.ndarray) -> np.ndarray:
    """Terzaghi's average degree of consolidation, exact to rounding: 4000 terms."""
    return terzaghi(C_V * np.asarray(time) / PATH**2, 4000)


def settlement(time: np.ndarray, secondary: float = 0.0) -> np.ndarray:
    """0.3 at once, 1.2 by consolidation, and ``secondary`` a decade of time beyond 0.01 day; mm."""
    return np.asarray(0.3 + 1.2 * degree(time) + secondary * np.log10(1.0 + time / 0.01))


@pytest.mark.parametrize(("times", "tolerance"), [(DENSE, 0.005), (LABORATORY, 0.01)])
def test_terzaghis_curve_gives_its_coefficient(times: np.ndarray, tolerance: float) -> None:
    d = settlement(times)
    for found in (root_time(times, d, PATH), log_time(times, d, PATH)):
        assert found.c_v == pytest.approx(C_V, rel=tolerance)
        assert found.start == pytest.approx(0.3, abs=0.002)
        assert found.end == pytest.approx(1.5, abs=0.002)
    assert root_time(times, d, PATH).time == pytest.approx(0.848 * PATH**2 / C_V, rel=tolerance)
    assert log_time(times, d, PATH).secondary == pytest.approx(0.0, abs=1e-4)


def test_a_reading_at_the_beginning_does_no_harm() -> None:
    times = np.concatenate([[0.0], DENSE])
    d = settlement(times)
    assert log_time(times, d, PATH) == log_time(DENSE, d[1:], PATH)
    assert root_time(times, d, PATH).c_v == pytest.approx(C_V, rel=0.005)


def test_secondary_compression_is_the_slope_at_the_end() -> None:
    d = settlement(DENSE, secondary=0.05)
    found = log_time(DENSE, d, PATH)
    assert found.secondary == pytest.approx(0.05, rel=0.005)  # (1 + t/0.01) is t/0.01 to some 0.5 % of a decade
    assert found.c_v == pytest.approx(C_V, rel=0.1)
    assert 1.5 < found.end < 1.7


def test_units_of_time_and_reading_scale() -> None:
    d = settlement(DENSE)
    one, other = log_time(DENSE, d, PATH), log_time(DENSE, 1e-3 * d, 2.0 * PATH)
    assert other.c_v == pytest.approx(4.0 * one.c_v, rel=1e-9)
    assert other.end == pytest.approx(1e-3 * one.end, rel=1e-9)


@pytest.mark.parametrize("method", [root_time, log_time])
def test_what_the_readings_do_not_show_is_reported(method: object) -> None:
    assert callable(method)
    d = settlement(DENSE)
    for times, readings, path, message in (
        (DENSE[:5], d[:5], PATH, "5 readings of one stage; at least 8"),
        (DENSE[::-1], d, PATH, "times must be at least 0 and increase"),
        (DENSE, np.full(241, 1.0), PATH, "the settlement does not grow"),
        (DENSE, d, 0.0, "the drainage path must be above 0 m, got 0"),
    ):
        with pytest.raises(NoEvaluationError, match=message):
            method(times, readings, path)


def test_consolidation_that_is_not_over_is_reported() -> None:
    begun = DENSE[DENSE < 0.01]
    with pytest.raises(NoEvaluationError, match="primary consolidation is not over"):
        log_time(begun, settlement(begun), PATH)
    with pytest.raises(NoEvaluationError, match="the readings end before"):
        root_time(begun, settlement(begun), PATH)
    late = DENSE[DENSE > 0.1]
    with pytest.raises(NoEvaluationError, match=r"decades of time|last half decade|not over|half of the consolidation"):
        log_time(late, settlement(late), PATH)


def test_creep_alone_is_no_consolidation() -> None:
    creep = np.log1p(DENSE / 0.001)
    with pytest.raises(NoEvaluationError, match="primary consolidation is not over"):
        log_time(DENSE, creep, PATH)
