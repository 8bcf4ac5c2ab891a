"""The oedometer as a forward model: series, times, stages, bad input."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pydantic import ValidationError

from geoswarm.solver.errors import InfeasibleError, ProblemError
from geoswarm.solver.forward.oedometer import OedometerSpec
from tests.solver.forward.staged_tests import IDENTIFIED, oedometer_spec

HEIGHT = 0.02021
MODEL = oedometer_spec(initial_void_ratio=1.1).build()


def run(
    model: object, points: dict[str, list[float]], parameters: dict[str, float] | None = None
) -> dict[str, np.ndarray]:
    prepared = model.prepare({name: np.array(x) for name, x in points.items()})  # type: ignore[attr-defined]
    return prepared(IDENTIFIED if parameters is None else parameters)  # type: ignore[no-any-return]


def test_series_and_parameters_are_declared() -> None:
    names = [info.name for info in MODEL.series]
    assert names == [
        "settlement",
        "axial_strain",
        "lateral_stress",
        "K0",
        "log_pp",
        "stage_settlement",
        "stage_axial_strain",
        "stage_lateral_stress",
        "stage_K0",
        "stage_log_pp",
        "stage_void_ratio",
    ]
    assert [info.name for info in MODEL.parameters if info.default is None] == [
        "lambda_star",
        "kappa_star",
        "mu_star",
        "c",
        "phi",
    ]
    assert {info.name for info in MODEL.parameters} >= {"psi", "nu_ur", "K0nc", "M", "OCR", "POP"}
    assert not MODEL.open_parameters
    for info in MODEL.series:
        x = MODEL.grid(info.name)
        assert info.x_lower is not None
        assert info.x_upper is not None
        assert info.x_lower <= x[0] < x[-1] <= info.x_upper
        assert (np.diff(x) > 0.0).all()


def test_a_change_of_stage_belongs_to_the_earlier_stage() -> None:
    second = 2.0
    result = run(MODEL, {"settlement": [0.0, 1.0e-6, second, second + 1.0e-6], "stage_settlement": [1, 2]})
    settlement = result["settlement"]
    assert settlement[0] == 0.0
    assert settlement[1] > 5.0e-5
    assert settlement[2] == result["stage_settlement"][0]
    assert settlement[3] - settlement[2] > 3.0e-6


def test_rounding_of_a_stage_time_does_not_change_the_side() -> None:
    exact, above, below = run(MODEL, {"settlement": [3.0, 3.0 * (1 + 1e-12), 3.0 * (1 - 1e-12)]})["settlement"]
    assert exact == above == below


def test_strain_is_engineering_and_void_ratio_follows_volume() -> None:
    stages = list(range(1, 17))
    result = run(MODEL, {"stage_settlement": stages, "stage_axial_strain": stages, "stage_void_ratio": stages})
    assert result["stage_axial_strain"] * HEIGHT == pytest.approx(result["stage_settlement"], rel=1.0e-14)
    assert result["stage_void_ratio"] == pytest.approx(1.1 - 2.1 * result["stage_axial_strain"], rel=1.0e-12)


def test_fixed_geometry_gives_the_logarithmic_strain() -> None:
    fixed = run(oedometer_spec(geometry="fixed").build(), {"stage_axial_strain": [8]})["stage_axial_strain"]
    updated = run(MODEL, {"stage_axial_strain": [8]})["stage_axial_strain"]
    assert updated == pytest.approx(1.0 - np.exp(-fixed), rel=1.0e-12)


def test_zero_at_stage_counts_time_and_settlement_from_before_that_stage() -> None:
    later = oedometer_spec(zero_at_stage=3, initial_void_ratio=1.1).build()
    offset = 3.0
    x = [0.0, 0.01, 1.0, 5.3]
    all_points = run(
        MODEL, {"settlement": [offset + t for t in x], "stage_settlement": [2, 5], "stage_void_ratio": [5]}
    )
    result = run(later, {"settlement": x, "stage_settlement": [2, 5], "stage_void_ratio": [5]})
    reference = all_points["settlement"][0]
    assert result["settlement"][0] == 0.0
    assert result["settlement"] == pytest.approx(all_points["settlement"] - reference, abs=1.0e-15)
    assert result["stage_settlement"] == pytest.approx(all_points["stage_settlement"] - reference, abs=1.0e-15)
    assert result["stage_void_ratio"] == pytest.approx(all_points["stage_void_ratio"], rel=1.0e-14)
    with pytest.raises(ProblemError, match=r"must be .*, got"):
        later.prepare({"settlement": np.array([-0.1])})


def test_points_in_any_order_and_several_series_at_once() -> None:
    together = run(MODEL, {"settlement": [5.0, 0.5, 5.0], "axial_strain": [0.5, 17.0]})
    assert together["settlement"][0] == together["settlement"][2]
    assert together["axial_strain"][0] * HEIGHT == pytest.approx(together["settlement"][1], rel=1.0e-14)


def test_halving_the_tolerance_changes_the_curve_by_less_than_the_tolerance() -> None:
    x = MODEL.grid("settlement")
    for tolerance in (4.0e-5, 1.0e-5):
        coarse, fine = (
            run(oedometer_spec(tolerance=t).build(), {"settlement": list(x)})["settlement"]
            for t in (tolerance, 0.5 * tolerance)
        )
        assert np.abs(coarse - fine).max() < tolerance * HEIGHT
        assert np.abs(coarse - fine).max() < 1.0e-6


def test_a_tolerance_of_1e_7_is_met_where_creep_slows_down_in_ten_thousand_logarithms_of_time() -> None:
    soil = {"lambda_star": 0.1, "kappa_star": 0.02, "mu_star": 1.0e-5, "c": 1.0, "phi": 20.0, "psi": 0.0}
    wanted = {"stage_axial_strain": [float(n) for n in range(1, 17)]}
    coarse, fine = (
        run(oedometer_spec(tolerance=t).build(), wanted, soil)["stage_axial_strain"] for t in (1.0e-5, 1.0e-7)
    )
    assert np.abs(coarse - fine).max() < 1.0e-5
    # 200, 400 and 800 kPa: virgin compression, lambda* for each logarithm of stress.
    assert np.diff(-np.log1p(-fine))[5:7] == pytest.approx(0.1 * math.log(2.0), rel=0.02)


def test_the_smallest_tolerance_is_reached_by_a_soil_that_hardly_creeps() -> None:
    """An index of 1e-6 leaves 1e5 logarithms of time in a stage: tens of thousands of steps, not a failure."""
    soil = {"lambda_star": 0.082, "kappa_star": 0.051, "mu_star": 1.0e-6, "c": 25.0, "phi": 20.0, "psi": 0.0}
    wanted = {"stage_axial_strain": [float(n) for n in range(1, 17)]}
    coarse, fine = (
        run(oedometer_spec(tolerance=t).build(), wanted, soil)["stage_axial_strain"] for t in (1.0e-6, 1.0e-8)
    )
    assert np.abs(coarse - fine).max() < 3.0e-6  # errors of 16 stages add up


def test_overconsolidation_from_OCR_or_POP_as_field_or_parameter() -> None:
    def final(spec: OedometerSpec, **parameters: float) -> float:
        return float(run(spec.build(), {"stage_settlement": [5]}, {**IDENTIFIED, **parameters})["stage_settlement"][0])

    base = final(oedometer_spec())
    assert final(oedometer_spec(OCR=2.0)) < base
    assert final(oedometer_spec(OCR=2.0)) == final(oedometer_spec(), OCR=2.0)
    assert final(oedometer_spec(OCR=3.0), OCR=2.0) == final(oedometer_spec(), OCR=2.0)
    assert final(oedometer_spec(POP=50.0)) < base
    assert final(oedometer_spec(POP=50.0)) == final(oedometer_spec(), POP=50.0)
    assert final(oedometer_spec(POP=0.0)) == base


def test_K0nc_and_M_change_the_settlement_consistently() -> None:
    def final(**parameters: float) -> float:
        return float(run(MODEL, {"stage_settlement": [8]}, {**IDENTIFIED, **parameters})["stage_settlement"][0])

    derived = 1.0 - math.sin(math.radians(20.0))
    assert final(K0nc=derived) == final()
    assert final(K0nc=0.0, M=0.0) == final()
    assert final(M=1.0) != final()


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ({"phi": 0.0}, "phi must be above 0 and below 90 degree, got 0 degree: soft soil creep needs friction"),
        ({"phi": 90.0}, "phi must be above 0 and below 90, got 90 degree"),
        ({"phi": -1.0}, "phi must be above 0 and below 90, got -1 degree"),
        ({"lambda_star": 0.05, "kappa_star": 0.05}, "lambda_star must be above kappa_star = 0.05, got 0.05"),
        ({"mu_star": 0.0}, "mu_star must be above 0, got 0"),
        ({"c": -2.0}, "c must be at least 0, got -2 kPa"),
        ({"psi": 25.0, "phi": 20.0}, "psi must be at most phi = 20 degree, got 25 degree"),
        ({"nu_ur": 0.5}, "nu_ur must be at least 0 and below 0.5"),
        ({"K0nc": 0.5, "M": 1.0}, "both given"),
        ({"OCR": 0.9}, "OCR must be at least 1"),
        ({"OCR": 2.0, "POP": 10.0}, "both given"),
        ({"lambda_star": 0.1, "kappa_star": 0.05, "K0nc": 0.01, "nu_ur": 0.45}, "gives no M"),
        ({"c": math.nan}, "c must be at least 0, got nan kPa"),
    ],
)
def test_check_names_parameter_value_and_what_is_accepted(parameters: dict[str, float], words: str) -> None:
    message = MODEL.check(parameters)
    assert message is not None
    assert words in message
    with pytest.raises(InfeasibleError):
        run(MODEL, {"settlement": [1.0]}, {**IDENTIFIED, **parameters})


@pytest.mark.parametrize("parameters", [{}, {"phi": 20.0}, {"kappa_star": 0.5}, {"psi": 0.0}, IDENTIFIED])
def test_check_accepts_what_is_admissible_so_far(parameters: dict[str, float]) -> None:
    assert MODEL.check(parameters) is None


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"discretization": "finite_elements"}, "'material_point' or 'finite_element'"),
        ({"material": "cam_clay"}, "soft_soil_creep"),
        ({"stages": []}, "at least 1"),
        ({"stages": [{"stress": 0.0, "duration": 1.0}]}, "greater than 0"),
        ({"stages": [{"stress": 5.0, "duration": -1.0}]}, "greater than 0"),
        ({"height": 0.0}, "greater than or equal to 0.000001"),
        ({"height": 5e-324, "discretization": "finite_element"}, "greater than or equal to 0.000001"),
        ({"zero_at_stage": 17}, "must be from 1 to 16, got 17"),
        ({"OCR": 2.0, "POP": 5.0}, "give only one of them"),
        ({"OCR": 0.5}, "greater than or equal to 1"),
        ({"formulation": "shifted"}, "translated"),
        ({"tolerance": 0.5}, "less than or equal"),
        ({"tall": 0.02}, "tall"),
    ],
)
def test_bad_sections_are_refused(changes: dict[str, object], words: str) -> None:
    with pytest.raises(ValidationError, match=words):
        oedometer_spec(**changes)


def test_bad_points_are_refused() -> None:
    with pytest.raises(ProblemError, match="'heave' is unknown; known are settlement, axial_strain"):
        MODEL.prepare({"heave": np.array([1.0])})
    with pytest.raises(ProblemError, match=r"from 0 to 17\.7917 day"):
        MODEL.prepare({"settlement": np.array([40.0])})
    with pytest.raises(ProblemError, match="whole numbers from 1 to 16"):
        MODEL.prepare({"stage_settlement": np.array([1.5])})
    with pytest.raises(ProblemError, match="initial_void_ratio"):
        oedometer_spec().build().prepare({"stage_void_ratio": np.array([1.0])})


def test_an_initial_state_beyond_the_strength_is_infeasible() -> None:
    with pytest.raises(InfeasibleError, match=r"K0 = 0.1.*must be from"):
        run(oedometer_spec(K0=0.1).build(), {"settlement": [1.0]}, {**IDENTIFIED, "c": 0.001})


def test_the_cut_off_can_be_switched_off() -> None:
    soil = {"lambda_star": 0.0287, "kappa_star": 0.00743, "mu_star": 0.0488, "c": 14.0, "phi": 32.8}
    free, cut = (
        run(oedometer_spec(formulation="untranslated", tension_cutoff=limit).build(), {"stage_settlement": [2]}, soil)
        for limit in (None, 0.0)
    )
    assert abs(free["stage_settlement"][0] - cut["stage_settlement"][0]) > 1.0e-6


def test_a_run_does_not_change_the_next_one() -> None:
    prepared = MODEL.prepare({"settlement": np.array([1.0, 8.0])})
    first = prepared(IDENTIFIED)["settlement"].copy()
    prepared({**IDENTIFIED, "c": 90.0})
    assert (prepared(IDENTIFIED)["settlement"] == first).all()
