"""Slopes and preconsolidation stresses of curves in closed form, and of a published oedometer test."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

from geoswarm.solver.parameter_estimates.compression_curve import (
    casagrande,
    compression_index,
    first_loading,
    log_log,
    swelling_index,
    virgin_line,
)
from geoswarm.solver.parameter_estimates.values import NoEvaluationError
from tests.solver.ags.synthetic import CC, CS, STRESSES, void_ratio

PAST = 100.0
LOOP = [12.5, 25.0, 50.0, 100.0, 200.0, 400.0, 100.0, 25.0, 100.0, 400.0, 800.0, 1600.0, 400.0]


def test_two_straight_lines_have_their_slopes() -> None:
    e = void_ratio(LOOP, past=PAST)
    assert compression_index(LOOP, e) == pytest.approx(CC, rel=1e-10)
    assert swelling_index(LOOP, e) == pytest.approx(CS, rel=1e-10)
    line = virgin_line(LOOP, e)
    assert line.points == 5
    assert line.start - line.index * math.log10(PAST) == pytest.approx(e[3], rel=1e-10)


def test_a_break_between_two_points_is_no_part_of_the_virgin_line() -> None:
    e = void_ratio(STRESSES, past=80.0)
    assert compression_index(STRESSES, e) == pytest.approx(CC, rel=1e-10)
    assert virgin_line(STRESSES, e).points == 4


def test_strains_give_the_ratios() -> None:
    strain = (1.2 - np.array(void_ratio(LOOP, past=PAST))) / 2.2
    assert compression_index(LOOP, -strain) == pytest.approx(CC / 2.2, rel=1e-10)


def test_only_first_loading_counts() -> None:
    x, _ = first_loading(LOOP, void_ratio(LOOP))
    assert 10.0**x == pytest.approx([12.5, 25.0, 50.0, 100.0, 200.0, 400.0, 800.0, 1600.0])


def test_unloadings_share_a_slope() -> None:
    """Two unloadings of 0.02 and 0.04 over a decade, from and to the same stresses: their mean."""
    stress = [100.0, 1000.0, 100.0, 1000.0, 100.0]
    assert swelling_index(stress, [1.0, 0.7, 0.72, 0.70, 0.74]) == pytest.approx(0.03, rel=1e-12)


def test_the_break_of_two_lines_is_casagrandes_stress() -> None:
    """Where the kink is a reading, a spline through dense readings bends there, and both lines meet there."""
    stress = 10.0 ** np.linspace(0.0, 4.0, 161)  # 40 readings a decade, one of them at 100 kPa
    e = void_ratio(stress.tolist(), past=PAST)
    assert casagrande(stress, e).stress == pytest.approx(PAST, rel=0.03)


def hyperbola(width: float) -> tuple[np.ndarray, np.ndarray]:
    """Stress and void ratio of a curve between the slopes 0.05 and 0.45 over log10(stress), bent at 100 kPa."""
    x = np.linspace(0.0, 5.0, 201)
    z = x - 2.0
    return 10.0**x, 1.5 - 0.25 * z - 0.2 * np.sqrt(z**2 + width**2)


@pytest.mark.parametrize("width", [0.1, 0.3])
def test_a_smooth_bend_gives_casagrandes_construction(width: float) -> None:
    """The construction with closed derivatives, and the asymptote as virgin line."""

    def slope(z: float) -> float:
        return -0.25 - 0.2 * z / math.hypot(z, width)

    def bend(z: float) -> float:
        return 0.2 * width**2 / math.hypot(z, width) ** 3 / (1.0 + slope(z) ** 2) ** 1.5

    z = float(minimize_scalar(lambda z: -bend(z), bounds=(-1.0, 1.0), method="bounded", options={"xatol": 1e-10}).x)
    height = 1.5 - 0.25 * z - 0.2 * math.hypot(z, width)
    half = math.tan(0.5 * math.atan(slope(z)))
    meet = brentq(lambda s: height + half * (s - z) - (1.5 - 0.45 * s), -3.0, 3.0)
    stress, e = hyperbola(width)
    line = virgin_line(stress, e)  # laid through all that has nine tenths of the steepest slope
    assert line.index == pytest.approx(0.45, rel=0.02)
    assert math.log10(casagrande(stress, e).stress) - 2.0 == pytest.approx(meet, abs=0.06)


def test_lines_in_ln_1_e_meet_at_the_preconsolidation_stress() -> None:
    stress = np.array([10.0, 20.0, 40.0, 80.0, 160.0, 320.0, 640.0])
    volume = math.log(2.2) - 0.01 * np.log(stress / 10.0) - 0.09 * np.log(np.maximum(stress, 95.0) / 95.0)
    assert log_log(stress, np.expm1(volume)).stress == pytest.approx(95.0, rel=1e-9)


def test_a_published_test() -> None:
    """End-of-stage readings of a real test (pySigmaP, BSD-2-Clause, doi 10.1016/j.softx.2022.100990, testData.csv)."""
    stress = [6.18, 12.36, 24.81, 49.52, 99.05, 198.19, 396.38, 792.77, 1585.43, 792.77, 396.38, 198.19, 99.05, 49.52]
    e = [0.759745368, 0.746786484, 0.730454741, 0.709152466, 0.684654851, 0.656384958, 0.616842612, 0.573883025]
    e += [0.512772126, 0.519917264, 0.532166072, 0.548320296, 0.566072191, 0.586131833]
    # by hand: the last interval is the steepest one, and no other has nine tenths of its slope
    assert compression_index(stress, e) == pytest.approx(
        (0.573883025 - 0.512772126) / math.log10(1585.43 / 792.77), rel=1e-9
    )
    assert 0.02 < swelling_index(stress, e) < 0.07  # its five unloading steps have 0.024 to 0.067
    for found in (casagrande(stress, e).stress, log_log(stress, e).stress):
        assert 100.0 < found < 800.0


@pytest.mark.parametrize(
    ("stress", "e", "message"),
    [
        ([10.0, 20.0], [1.0, 0.9], "2 points of first loading; at least 3"),
        ([10.0, 20.0, 40.0], [1.0, 0.9, 0.8], "does not become steeper"),
        ([10.0, 20.0, 40.0], [1.0, 1.1, 1.2], "does not fall with the stress"),
        ([10.0, 0.0], [1.0, 0.9], "stresses must be above 0 kPa"),
        ([10.0, 20.0], [1.0], "as many of both are needed"),
        ([10.0, 20.0], [1.0, math.nan], "finite"),
    ],
)
def test_what_has_no_virgin_line_is_reported(stress: list[float], e: list[float], message: str) -> None:
    with pytest.raises(NoEvaluationError, match=message):
        virgin_line(stress, e)


def test_what_has_no_preconsolidation_stress_is_reported() -> None:
    with pytest.raises(NoEvaluationError, match="there is no unloading"):
        swelling_index([10.0, 20.0], [1.0, 0.9])
    for method in (casagrande, log_log):
        with pytest.raises(NoEvaluationError, match="4 points of first loading; at least 5"):
            method([10.0, 20.0, 40.0, 80.0], [1.0, 0.99, 0.9, 0.8])
    straight = np.linspace(1.0, 3.0, 9)
    with pytest.raises(NoEvaluationError, match="does not become steeper"):
        casagrande(10.0**straight, 1.0 - 0.1 * straight)
    with pytest.raises(NoEvaluationError, match="does not become steeper"):
        log_log(10.0**straight, np.expm1(1.0 - 0.1 * np.sqrt(straight)))
    with pytest.raises(NoEvaluationError, match="void ratios must be above -1"):
        log_log(10.0**straight, -straight)
