"""Readings that are missed by far: said first, units before other remedies, and nothing to fix at a bound."""

from __future__ import annotations

from typing import Any

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.examples import example_file
from geoswarm.solver.identifiability.remedies import Remedy
from geoswarm.solver.identifiability.samples import Samples
from geoswarm.solver.identifiability.stored.stored_fit import fit_of_samples
from geoswarm.solver.identifiability.stored.study import analyse
from geoswarm.solver.plausibility import to_be_accepted
from geoswarm.solver.problem import Problem, load_problem, parse_problem
from geoswarm.solver.runs.local import calibrate


def published(unit: str = "mm", **parameters: Any) -> Problem:
    """The published oedometer test with another unit and other parameters."""
    with example_file("oedometer") as file:
        document = load_problem(file).document()
    document["observations"][0]["y_unit"] = unit
    document["parameters"] |= parameters
    changes = {"stopping": {"max_evaluations": 60}, "accept": ["settlement"], "seed": 1}
    return parse_problem(document | changes)


def test_readings_that_no_soil_can_have_come_first() -> None:
    """A thousandfold settlement ended with all parameters at their bounds and the remedy "consolidation"."""
    problem = published("m")
    samples = Samples.from_result(problem, calibrate(problem))
    fit = fit_of_samples(Calibration(problem, 1), samples)
    assert fit.kind == "lack_of_fit"
    assert fit.sentence.startswith(
        "settlement: the largest reading, 3.66 m, is more than the height of the specimen, 0.02021 m; in mm it would "
        "be 0.18 of it."
    )
    assert fit.headline == "The readings do not fit this specimen"
    slip = {"series": "settlement", "key": "y_unit", "unit": "mm"}
    assert fit.remedies == (Remedy("check_readings", values={"units": [slip]}),)
    assert fit.remedies[0].text.endswith("They would fit the specimen with settlement in mm (y_unit: 'mm').")
    found = analyse(Calibration(problem, 1), samples)
    assert found.fit == fit
    assert not {one.kind for verdict in found.verdicts for one in verdict.proposals} & {"fix", "link"}


def test_readings_that_soils_hardly_have_come_first_where_parameters_are_at_their_bounds() -> None:
    """Millimetres read as micrometres were a warning before the search, and no word behind it."""
    with example_file("oedometer") as file:
        document = load_problem(file).document()
    observation = document["observations"][0]
    observation["y_unit"] = "um"
    observation["points"]["y"] = [8.0 * y for y in observation["points"]["y"]]
    changes = {"stopping": {"max_evaluations": 60}, "seed": 1}
    problem = parse_problem(document | changes)
    assert to_be_accepted(problem) == []
    fit = fit_of_samples(Calibration(problem, 1), Samples.from_result(problem, calibrate(problem)))
    assert fit.headline == "The readings do not fit this specimen"
    assert "they would fit" in fit.remedies[0].text.lower()
    meant = parse_problem(document | changes | {"accept": ["settlement"]})
    fit = fit_of_samples(Calibration(meant, 1), Samples.from_result(meant, calibrate(meant)))
    assert fit.headline != "The readings do not fit this specimen"


def test_times_that_end_in_the_first_stage_come_first() -> None:
    """Minutes read as seconds and accepted: the page said that the fit was not tested."""
    with example_file("oedometer") as file:
        document = load_problem(file).document()
    document["observations"][0]["x_unit"] = "s"
    changes = {"stopping": {"max_evaluations": 60}, "seed": 1}
    assert to_be_accepted(parse_problem(document | changes)) == ["settlement"]
    problem = parse_problem(document | changes | {"accept": ["settlement"]})
    fit = fit_of_samples(Calibration(problem, 1), Samples.from_result(problem, calibrate(problem)))
    assert fit.headline == "The readings do not fit this specimen"
    assert fit.remedies == (
        Remedy("check_readings", values={"units": [{"series": "settlement", "key": "x_unit", "unit": "min"}]}),
    )


def test_readings_that_are_missed_with_parameters_at_their_bounds() -> None:
    narrow = {"lower": 0.002, "upper": 0.004, "scale": "log"}
    problem = published(lambda_star=narrow, kappa_star={"lower": 0.001, "upper": 0.002, "scale": "log"})
    samples = Samples.from_result(problem, calibrate(problem))
    fit = fit_of_samples(Calibration(problem, 1), samples)
    assert fit.kind == "lack_of_fit"
    assert [(one.series, one.reason) for one in fit.misfits] == [("settlement", "missed")]
    assert "calculated below measured" in fit.sentence
    assert "a constant would be about as close, and parameters are at their bounds" in fit.sentence
    assert fit.remedies[0] == Remedy("check_readings")


def test_a_search_that_fits_is_not_missed() -> None:
    problem = published()
    fit = fit_of_samples(Calibration(problem, 1), Samples.from_result(problem, calibrate(problem)))
    assert "missed" not in {one.reason for one in fit.misfits}
    assert not fit.headline
