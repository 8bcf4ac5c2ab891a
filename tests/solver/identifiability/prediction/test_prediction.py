"""Bands of predictions: how often they hold, and what they say of basins, bounds and open parameters."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import norm, t

from geoswarm.calibration import Result, calibrate
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.errors import ProblemError
from geoswarm.solver.identifiability import StatisticsError
from geoswarm.solver.identifiability.prediction.bands import weighted_quantiles
from geoswarm.solver.identifiability.prediction.draws import basins_of, draw_around, take_from
from geoswarm.solver.identifiability.prediction.question import predict_problem, problem_of_tests
from geoswarm.solver.identifiability.stored.findings import findings_of
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.report.document.outlook_tables import prediction_table
from geoswarm.solver.report.figures.outlook.prediction_plot import prediction_figure
from geoswarm.solver.report.folder.folder_findings import evaluations_of_folder
from geoswarm.solver.report.folder.run_folder import open_run_folder
from geoswarm.solver.runs.local import calibrate as calibrate_here
from geoswarm.solver.words import per_cent
from tests.solver.identifiability.cases import WHITE, X, free, linearised, problem_of
from tests.solver.identifiability.prediction.coverage import CASES, coverage, predicted

NOISE = 0.05 * np.random.default_rng(2).standard_normal(X.size)


def line(known: bool = False) -> Problem:
    y = 1.0 + 2.0 * X + NOISE
    changes: dict[str, Any] = {"noise": WHITE}
    if known:
        points = {"x": X.tolist(), "y": y.tolist()}
        changes["observations"] = [{"series": "y", "points": points, "error": 0.05}]
    return problem_of("a + b * x", {"a": free(-10.0), "b": free(-10.0)}, y, **changes)


def later(expression: str = "a + b * x", x: tuple[float, ...] = (10.0,), **more: Any) -> dict[str, Any]:
    return {
        "forward_model": {"kind": "formula", "series": {"y": expression}},
        "observations": [{"series": "y", "points": {"x": list(x)}}],
    } | more


@cache
def line_result(known: bool = False) -> Result:
    return calibrated(line(known))


def calibrated(problem: Problem) -> Result:
    """A short plain swarm is enough: it ends with the runs down to the minimum and around it."""
    method = {"kind": "particle_swarm", "particles": 10, "acceleration": "none"}
    return calibrate(problem, seed=3, method=method, stopping={"max_evaluations": 100})


@pytest.mark.parametrize("known", [False, True])
def test_the_band_of_a_line_is_the_textbook_one(known: bool) -> None:
    problem = line(known)
    y = problem.observations[0].y
    found = line_result(known).predict(later(x=(4.0, 10.0, 30.0)), runs=2000, level=0.8)["y"]
    design = np.stack([np.ones_like(X), X], axis=1)
    best, *_ = np.linalg.lstsq(design, y, rcond=None)
    free_degrees = X.size - 2
    deviation = 0.05 if known else float(np.sqrt(np.sum((y - design @ best) ** 2) / free_degrees))
    at = np.stack([np.ones(3), [4.0, 10.0, 30.0]], axis=1)
    error = deviation * np.sqrt(np.einsum("ij,jk,ik->i", at, np.linalg.inv(design.T @ design), at))
    quantile = norm.ppf(0.9) if known else t.ppf(0.9, free_degrees)
    np.testing.assert_allclose(found.median, at @ best, atol=0.02 * error.max())
    np.testing.assert_allclose(found.upper - found.lower, 2.0 * quantile * error, rtol=0.03)
    assert found.reading_lower is not None
    assert found.reading_upper is not None
    reading = quantile * np.sqrt(error**2 + deviation**2)
    np.testing.assert_allclose(found.reading_upper - found.reading_lower, 2.0 * reading, rtol=0.03)
    assert found.straight == pytest.approx(1.0, abs=1e-9)


def test_bands_hold_the_truth_as_often_as_they_say() -> None:
    held = [coverage(case, 15, runs=60)[-1] for case in CASES.values()]
    assert 0.78 <= float(np.mean(held)) <= 0.99  # 60 repeats: three standard errors


@pytest.mark.slow
@pytest.mark.parametrize("name", list(CASES))
def test_bands_of_90_percent_hold_the_truth_in_87_to_93_percent_of_500_repeats(name: str) -> None:
    held = coverage(CASES[name], 500, seed=11)
    assert (held >= 0.87).all(), held
    assert (held <= 0.93).all(), held


def test_draws_of_a_posterior_scatter_as_much_wider_as_intervals_do() -> None:
    """They came as they were, of independent errors, and the remark said that they scattered as intervals do."""
    calibration = Calibration(line(), 1)
    optimum = np.array([1.0, 2.0])
    drawn = optimum + np.random.default_rng(4).normal(0.0, 0.01, (4000, 2))
    plain, wider = (take_from(calibration, optimum, drawn, 4000, (), 8.0, 1, widening) for widening in (1.0, 3.0))
    np.testing.assert_allclose(wider.parameters - optimum, 3.0 * (plain.parameters - optimum), atol=1e-12)
    with pytest.raises(StatisticsError, match="only 0 of 4000 draws"):
        take_from(calibration, optimum, drawn, 4000, (), 8.0, 1, 1e9)


def test_all_basins_take_part_by_their_weights() -> None:
    y = 4.0 * np.exp(-0.5 * X) + 1.3**2 * X + NOISE
    problem = problem_of("b * exp(-0.5 * x) + (a - 3)**2 * x", {"a": free(0.1, 5.9), "b": free()}, y)
    calibration = Calibration(problem, 1)
    found = linearised(problem, [1.7, 4.0])
    best = calibration.evaluate(np.array([1.7, 4.0])).objective
    other = calibration.evaluate(np.array([4.3, 4.0])).objective
    assert best is not None
    assert other is not None
    basins = basins_of(calibration, found, best, [(np.array([4.3, 4.0]), other)], (), None)
    assert [basin.share for basin in basins] == pytest.approx([0.5, 0.5])
    sample = draw_around(calibration, basins, 200, 1)
    assert sample.parameters[sample.basins == 0, 0].mean() == pytest.approx(1.7, abs=0.01)
    assert sample.parameters[sample.basins == 1, 0].mean() == pytest.approx(4.3, abs=0.01)
    worse = basins_of(calibration, found, best, [(np.array([4.3, 4.0]), 1.5 * best)], (), None)
    expected = 1.5 ** (-0.5 * (X.size - 2))  # of the likelihood integrated over the noise
    assert worse[1].share / worse[0].share == pytest.approx(expected)


def test_a_result_with_two_basins_predicts_both() -> None:
    y = 4.0 * np.exp(-0.5 * X) + 1.3**2 * X + NOISE
    problem = problem_of(
        "b * exp(-0.5 * x) + (a - 3)**2 * x", {"a": free(0.1, 5.9), "b": free()}, y, stopping={"max_evaluations": 600}
    )
    result = calibrate(problem, seed=5, method={"kind": "particle_swarm", "particles": 30, "acceleration": "none"})
    found = result.predict(later("a", (1.0,)))
    assert sorted(round(values["a"], 1) for _, values in found.basins) == [1.7, 4.3]
    assert [share for share, _ in found.basins] == pytest.approx([0.5, 0.5], abs=0.02)
    one = found["y"]
    assert one.lower[0] < 1.72
    assert one.upper[0] > 4.28
    assert any("2 sets of parameters" in remark for remark in found.remarks)


def test_exchanged_parameters_are_two_basins_of_the_same_shape() -> None:
    truth = np.exp(-0.3 * X) + np.exp(-2.0 * X)
    problem = problem_of("exp(-a * x) + exp(-b * x)", {"a": free(), "b": free()}, truth + 0.1 * NOISE)
    calibration = Calibration(problem, 1)
    found = linearised(problem, [0.3, 2.0])
    first, second = basins_of(calibration, found, 1e-5, (), [("a", "b")], None)
    np.testing.assert_allclose(second.optimum, first.optimum[::-1])
    np.testing.assert_allclose(second.shape.covariance, first.shape.covariance[::-1, ::-1])
    assert second.share == pytest.approx(0.5)


def test_a_parameter_without_influence_is_drawn_over_its_range() -> None:
    problem = problem_of("a * x + 0 * b", {"a": free(), "b": free(1.0, 5.0)}, 2.0 * X + NOISE)
    result = calibrated(problem)
    found = result.predict(later("b", (1.0,)), runs=400)
    assert found["y"].lower[0] == pytest.approx(1.2, abs=0.05)
    assert found["y"].upper[0] == pytest.approx(4.8, abs=0.05)
    assert any("b undecided" in remark for remark in found.remarks)


def test_open_combinations_are_drawn_along_what_the_data_determine() -> None:
    """Of a product only the product is known: on log scales that is a straight line through the box."""
    parameters = {"a": free(0.1, 10.0, "log"), "b": free(0.1, 10.0, "log")}
    problem = problem_of("a * b * x", parameters, 2.0 * X + NOISE)
    calibration = Calibration(problem, 1)
    found = linearised(problem, [1.0, 2.0])
    sample = draw_around(calibration, basins_of(calibration, found, 0.0025, (), (), None), 400, 1)
    product = sample.parameters.prod(axis=1)
    error = 0.05 / np.sqrt(np.sum(X**2))
    assert product.std() == pytest.approx(error, rel=0.4)
    assert np.quantile(np.log(sample.parameters[:, 0]), [0.0, 1.0]) == pytest.approx(np.log([0.2, 10.0]), abs=0.1)
    assert sample.undecided == ("a", "b")


def test_a_parameter_at_its_bound_is_truncated() -> None:
    y = 1.0 + 2.0 * X + NOISE
    problem = problem_of("a + b * x", {"a": free(1.0, 3.0), "b": free(0.0, 5.0)}, y)
    calibration = Calibration(problem, 1)
    sample = draw_around(
        calibration, basins_of(calibration, linearised(problem, [1.0, 2.0]), 0.0025, (), (), None), 200, 1
    )
    assert sample.parameters[:, 0].min() >= 1.0
    assert np.median(sample.parameters[:, 0]) > 1.005


def test_a_model_that_does_not_fit_is_said_before_the_band() -> None:
    problem = problem_of("a + b * x", {"a": free(-50.0, 50.0), "b": free(-50.0, 50.0)}, X**2 + 0.1 * NOISE)
    found = calibrated(problem).predict(later())
    assert found.alarm is not None
    assert "not what the model lacks" in found.alarm
    assert found.to_json()["alarm"] == found.alarm


def test_correlated_residuals_widen_the_band() -> None:
    random = np.random.default_rng(1)
    x = np.linspace(0.0, 4.0, 60)
    noise = np.zeros(60)
    for i in range(1, 60):
        noise[i] = 0.8 * noise[i - 1] + random.normal(0.0, 0.05)
    problem = problem_of("a + b * x", {"a": free(-10.0), "b": free(-10.0)}, 1.0 + 2.0 * x + noise, x)
    result = calibrated(problem)
    linearisation = result.statistics().linearisation
    assert linearisation is not None
    assert linearisation.dependence
    found = result.predict(later(x=(2.0,)))["y"]
    design = np.stack([np.ones_like(x), x], axis=1)
    independent = np.sqrt(
        np.sum(noise**2) / 58 * np.array([1, 2]) @ np.linalg.inv(design.T @ design) @ np.array([1, 2])
    )
    assert found.upper[0] - found.lower[0] > 1.5 * 2 * 1.67 * independent


def test_readings_without_error_give_no_band() -> None:
    problem = problem_of("a + b * x", {"a": free(-10.0), "b": free(-10.0)}, 1.0 + 2.0 * X)
    result = calibrated(problem)
    with pytest.raises(StatisticsError, match="give the error of a reading"):
        result.predict(later())
    found = result.predict(later(), noise=0.05)["y"]
    assert found.upper[0] > found.lower[0]


def test_measured_points_are_compared_with_the_band() -> None:
    other = later(x=(5.0, 6.0))
    other["observations"][0]["points"]["y"] = [11.0, 20.0]
    found = line_result().predict(other)["y"]
    assert found.inside == 1
    assert found.measured is not None
    assert found.closeness is not None
    assert found.closeness.largest == pytest.approx(7.0, abs=0.1)
    assert found.closeness.deviation == pytest.approx(7.0 / np.sqrt(2), abs=0.1)


def test_series_that_were_not_measured_come_close_to_nothing() -> None:
    found = line_result().predict(later())
    assert found["y"].closeness is None
    assert not any("is met within" in remark for remark in found.remarks)


def test_a_table_of_tests_is_predicted_and_compared_test_by_test(tmp_path: Path) -> None:
    problem = problem_of("E * x", {"E": free(1.0, 5000.0)}, 1000.0 * X + 20.0 * NOISE)
    calibration = Calibration(problem, 1)
    basins = basins_of(calibration, linearised(problem, [1000.0]), 1.0, (), (), None)
    for name, factor in zip("ABCD", (1.0, 1.0, 1.0, 1.1), strict=True):
        rows = "\n".join(f"{x},{10.0 * factor * x}" for x in (0.1, 0.2, 0.4))
        (tmp_path / f"{name}.csv").write_text(f"axial strain [%],q [kPa]\n{rows}\n")
    (tmp_path / "tests.csv").write_text(
        "file,kind,cell pressure [kPa]\n" + "".join(f"{n}.csv,CD,100\n" for n in "ABCD")
    )
    (tmp_path / "later.yaml").write_text(
        "tests: {table: tests.csv, material: elastic}\nparameters: {nu: {value: 0.3}}\n"
    )
    question = predict_problem(problem, tmp_path / "later.yaml", draw_around(calibration, basins, 20, 1), seed=1)
    evaluations = [record.evaluation for record in calibrate_here(question).history]
    (found,) = findings_of(question, 1, evaluations).predictions
    assert [one.series for one in found.series] == ["A.q", "B.q", "C.q", "D.q"]
    last = found.series[-1].closeness
    assert last is not None
    assert last.peak == pytest.approx(1.0 - 1.0 / 1.1, abs=5e-3)
    assert found.remarks[0].startswith("With the values of the best fit, q is met within 0.3")
    assert "peaks within" in found.remarks[0]
    figure = prediction_figure("further tests", found)
    assert len({line.get_color() for line in figure.axes[0].lines}) == 4
    many = replace(found, series=4 * found.series)
    assert [row[3] for row in prediction_table(many).rows][-1] == per_cent(last.peak)


@pytest.mark.parametrize(
    ("change", "path", "message"),
    [
        ({"parameters": {"c": {"lower": 0, "upper": 1}}}, "parameters.c", "is not identified by the job"),
        ({}, "parameters.c", "is needed by the forward model, and the job does not identify it"),
        ({"parameters": {"c": {"value": 1}, "a": {"value": 1}, "b": {"value": 1}}}, "parameters", "none of the"),
        ({"parameters": {"c": {"value": 1}}, "observations": []}, "observations", "must be a list"),
    ],
)
def test_mistakes_are_told_with_their_path(change: dict[str, Any], path: str, message: str) -> None:
    problem = line()
    calibration = Calibration(problem, 1)
    sample = draw_around(
        calibration, basins_of(calibration, linearised(problem, [1.0, 2.0]), 0.0025, (), (), None), 40, 1
    )
    with pytest.raises(ProblemError) as caught:
        predict_problem(problem, later("a + b * x + c") | change, sample, seed=1)
    assert any(issue.path == path and message in issue.message for issue in caught.value.issues), caught.value


def test_a_value_in_the_other_problem_goes_before_what_was_identified() -> None:
    found = line_result().predict(later(parameters={"a": {"value": 5.0}, "b": free(-1.0)}, x=(1.0,)))
    assert found["y"].median[0] == pytest.approx(7.0, abs=0.1)
    assert any(remark.startswith("A: the predicted problem gives a value") for remark in found.remarks)


def test_files_are_read_beside_the_other_problem(tmp_path: Path) -> None:
    (tmp_path / "later.csv").write_text("x,y\n5,11\n6,13\n")
    (tmp_path / "later.yaml").write_text(
        "forward_model: {kind: formula, series: {y: a + b * x}}\nobservations: [{series: y, file: later.csv}]\n"
    )
    found = line_result().predict(tmp_path / "later.yaml")
    assert found.found.name == "later"
    assert found["y"].x.tolist() == [5.0, 6.0]


def test_quantiles_by_weight() -> None:
    values = np.random.default_rng(0).normal(size=(999, 2))
    equal = weighted_quantiles(values, np.ones(999), (0.05, 0.5))
    np.testing.assert_allclose(equal, np.quantile(values, [0.05, 0.5], axis=0, method="weibull"))
    double = weighted_quantiles(np.repeat(values[:400], 2, axis=0), np.ones(800), (0.3,))
    weighted = weighted_quantiles(values[:400], np.full(400, 2.0), (0.3,))
    np.testing.assert_allclose(double, weighted, atol=0.02)


def test_the_case_that_the_study_repeats() -> None:
    case = CASES["linear, known error"]
    y = case.curve(np.array(case.truth), case.x)
    points = {"x": case.x.tolist(), "y": y.tolist()}
    problem = problem_of(
        case.expression, case.parameters, y, case.x, observations=[{"series": "y", "points": points, "error": 0.2}]
    )
    found = predicted(problem, np.array(case.truth), case, 100, 0.9, 1)["s"]
    np.testing.assert_allclose(found.median, case.other(np.array(case.truth), case.at), atol=0.1)


def test_a_table_alone_takes_the_law_of_the_job_and_what_it_fixes(tmp_path: Path) -> None:
    (tmp_path / "A.csv").write_text("axial strain [%],q [kPa]\n0.1,10\n0.2,20\n0.4,40\n")
    (tmp_path / "B.csv").write_text("stress [kPa],void ratio\n10,0.9\n100,0.88\n200,0.87\n")
    (tmp_path / "tests.csv").write_text("file,kind,cell pressure [kPa]\nA.csv,CD,100\nB.csv,oedometer,\n")
    section = {"kind": "triaxial", "material": "elastic", "initial_stress": 50.0}
    document = {
        "forward_model": section | {"shearing": [{"kind": "monotonic", "axial_strain": 0.01}]},
        "parameters": {"E": free(1e3, 1e5), "nu": {"expression": "0.1 * three"}, "three": {"value": 3.0}},
        "observations": [{"series": "q", "points": {"x": [0.001, 0.002], "y": [10.0, 20.0]}}],
        "stopping": {"max_evaluations": 20},
    }
    found = problem_of_tests(parse_problem(document), tmp_path / "tests.csv")
    assert found["name"] == "tests"
    assert list(found["parameters"]) == ["nu", "three"]
    assert found["forward_model"]["parts"]["A"]["material"] == "elastic"
    calibration = Calibration(parse_problem(document), 1)
    basins = basins_of(calibration, linearised(calibration.problem, [1e4]), 1.0, (), (), None)
    question = predict_problem(calibration.problem, found, draw_around(calibration, basins, 20, 1), seed=1)
    assert question.free_names == ("E",)
    other = section | {"material": "mohr_coulomb", "shearing": [{"kind": "monotonic", "axial_strain": 0.01}]}
    parts = {"kind": "combined", "parts": {"a": document["forward_model"], "b": other}}
    strength = {"c": {"value": 1.0}, "phi": {"value": 30.0}}
    two = {
        "forward_model": parts,
        "parameters": document["parameters"] | strength,  # type: ignore[operator]
        "observations": [{"series": "a.q", "points": {"x": [0.001], "y": [10.0]}}],
    }
    with pytest.raises(ProblemError, match="one law that those of a table take, got elastic and mohr_coulomb"):
        problem_of_tests(parse_problem(document | two), tmp_path / "tests.csv")


def with_a_fragile_test(expression: str) -> dict[str, Any]:
    """Two tests: one that any parameters give, one that some do not."""
    series = {"sound": "a + b * x", "fragile": expression}
    return {
        "forward_model": {
            "kind": "combined",
            "parts": {name: {"kind": "formula", "series": {"y": formula}} for name, formula in series.items()},
        },
        "observations": [{"series": f"{name}.y", "points": {"x": [4.0, 10.0]}} for name in series],
    }


def test_a_test_that_fails_takes_its_own_band_alone(tmp_path: Path) -> None:
    """Each draw of which one test failed was lost for all."""
    problem = line(known=True)
    calibration = Calibration(problem, 1)
    optimum = line_result(known=True).parameters
    found = linearised(problem, list(optimum.values()))
    sample = draw_around(calibration, basins_of(calibration, found, 1.0, (), (), None), 40, 1)
    asked = predict_problem(problem, with_a_fragile_test(f"ln(a - {optimum['a'] - 1e-3})"), sample, seed=1)
    folder = open_run_folder(tmp_path, asked, seed=None, offer=None, resume=False)
    assert folder is not None
    result = calibrate_here(asked, keeper=folder)
    folder.finish(result)
    folder.complete()
    (plain,) = findings_of(
        question := predict_problem(problem, later(x=(4.0, 10.0)), sample, seed=1),
        1,
        [record.evaluation for record in calibrate_here(question).history],
    ).predictions
    for evaluations in ([r.evaluation for r in result.history], evaluations_of_folder(tmp_path, asked)):
        (both,) = findings_of(asked, 1, evaluations).predictions
        assert both["sound.y"].lower.tolist() == plain["y"].lower.tolist()
        assert both["sound.y"].upper.tolist() == plain["y"].upper.tolist()
        assert both["fragile.y"].lower[0] < both["fragile.y"].upper[0]
        assert 5 < both.failed < 30
        assert any(f"left out are {both.failed} runs of fragile." in remark for remark in both.remarks)
    asked = predict_problem(problem, with_a_fragile_test("ln(-1 - a**2)"), sample, seed=1)
    (sound,) = findings_of(asked, 1, [r.evaluation for r in calibrate_here(asked).history]).predictions
    assert [one.series for one in sound.series] == ["sound.y"]
    assert "Fragile.y: no band, which needs 10 successful runs." in sound.remarks
    assert not prediction_figure("one of two", sound).axes[1:]


def test_a_search_takes_a_run_as_failed_when_a_test_fails() -> None:
    document = with_a_fragile_test("ln(a)")
    for section in document["observations"]:
        section["points"]["y"] = [1.0, 2.0]
    problem = parse_problem(
        document | {"parameters": {"a": free(-1.0), "b": free(-1.0)}, "stopping": {"max_evaluations": 20}}
    )
    evaluation = Calibration(problem, 1).evaluate(np.array([-0.5, 0.5]))
    assert evaluation.reason == "not_finite"
    assert not evaluation.responses
