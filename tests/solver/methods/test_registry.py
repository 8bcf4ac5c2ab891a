"""Methods are found by their kind: built-in ones, and those of other packages."""

from __future__ import annotations

import pytest

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.errors import ProblemError
from geoswarm.solver.identifiability.samples import Samples
from geoswarm.solver.identifiability.stored.study import analyse
from geoswarm.solver.methods.registry import UnknownMethodError, find_method, kinds, kinds_of
from geoswarm.solver.problem import parse_problem, problem_schema
from geoswarm.solver.report.record import method_in_words
from geoswarm.solver.runs.local import calibrate
from tests.solver.problems import decay_document


def test_every_kind_has_a_role_and_words() -> None:
    assert {kind for role in ("search", "sampling", "follow_up") for kind in kinds_of(role)} == set(kinds())  # type: ignore[arg-type]  # a role each
    for kind in kinds():
        assert find_method(kind).title
        assert find_method(kind).model_fields["kind"].default == kind


def test_an_unknown_kind_names_the_nearest_and_all() -> None:
    with pytest.raises(UnknownMethodError, match=r"unknown kind 'montecarlo'.*monte_carlo"):
        find_method("montecarlo")
    with pytest.raises(ProblemError, match="differential_evolution, monte_carlo"):
        parse_problem(decay_document(method={"kind": "annealing"}))


@pytest.mark.usefixtures("misbehaving_models")
def test_a_method_of_another_package_is_like_a_built_in_one() -> None:
    document = decay_document(method={"kind": "grid", "levels": 5}, stopping={})
    problem = parse_problem(document)
    assert problem.planned_evaluations == 25
    result = calibrate(problem, seed=1)
    assert (result.evaluations, result.generations, result.stop_reasons) == (25, 5, ("grid_completed",))
    assert method_in_words(problem) == "grid of 5 levels"
    samples = Samples.from_result(problem, result)
    assert samples.source == "grid"
    assert samples.unbiased.all()
    assert analyse(Calibration(problem, 1), samples).samples.size == 25
    assert problem.document()["method"] == {"kind": "grid", "levels": 5, "fault": "none"}
    schema = problem_schema()
    assert schema["properties"]["method"]["discriminator"]["mapping"]["grid"] == "#/$defs/method_grid"
    assert schema["$defs"]["method_grid"]["properties"]["levels"]["default"] == 4
    with pytest.raises(ProblemError, match=r"method\.levels"):
        parse_problem(decay_document(method={"kind": "grid", "levels": "many"}))
