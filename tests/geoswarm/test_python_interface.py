"""Calibrations from Python: functions, problems, what they give, and what is refused."""

from __future__ import annotations

import functools
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import geoswarm as gs
from geoswarm.cli import main
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.runs.local import calibrate as calibrate_problem
from geoswarm.workers.service.job_service import JobService
from tests.api.conftest import service, settings
from tests.geoswarm.python_models import OPTIONS, SOURCE, X, Y, module, numbers, problem_file, rows

__all__ = ["service", "settings"]

DOCUMENT: dict[str, Any] = {
    "forward_model": {"kind": "formula", "series": {"y": "a + b * x"}},
    **OPTIONS,
    "observations": [{"series": "y", "points": {"x": X, "y": Y}, "error": 0.1}],
}


@pytest.mark.usefixtures("blank_figures")
def test_a_function_is_calibrated_as_its_problem_file_to_the_last_bit(tmp_path: Path) -> None:
    line = module(tmp_path).line
    one = gs.calibrate(line, **OPTIONS, output=tmp_path / "python")
    path = problem_file(tmp_path, line)
    assert main(["run", str(path), "--workers", "2", "--output", str(tmp_path / "cli")]) == 0
    assert rows(tmp_path / "python") == rows(tmp_path / "cli")
    told = [json.loads((tmp_path / name / "problem.json").read_text()) for name in ("python", "cli")]
    assert told[0] == told[1]
    assert (tmp_path / "python" / "report.html").is_file()
    assert one.problem == gs.load_problem(path)


def test_what_a_result_tells(tmp_path: Path) -> None:
    result = gs.calibrate(DOCUMENT, stopping={"max_evaluations": 200})
    assert result.state == "finished"
    assert result.stop_reasons == ("max_evaluations",)
    assert result.parameters == pytest.approx({"a": 1.0, "b": 2.0}, abs=1e-2)
    assert 0.0 <= result.objective < 1e-4
    assert "Result max_evaluations: objective" in repr(result)
    assert "Calibration" in result._repr_html_()
    runs = result.runs
    assert runs["objective"].shape == runs["a"].shape == (runs.size,) == (result.evaluations,)
    assert 170 <= runs.size <= 200
    best = int(np.flatnonzero(runs["objective"] == result.objective)[0])
    np.testing.assert_array_equal(runs.responses["y"][best], result.best.responses["y"])
    assert list(runs.to_dataframe().columns) == list(runs)
    with pytest.raises(KeyError, match="E: the columns are generation"):
        runs["E"]
    assert {verdict.kind for verdict in result.statistics().verdicts} == {"identified"}
    written = result.report(tmp_path / "report")
    assert {"report.html", "report.pdf", "result.json", "fit.svg"} <= {path.name for path in written}
    assert main(["statistics", str(tmp_path / "report"), "--json"]) == 0


@pytest.mark.filterwarnings("ignore::geoswarm.InProcessWarning")
def test_axes_can_be_given() -> None:
    from matplotlib.figure import Figure

    def both(x: Any, a: float, b: float) -> Any:
        return {"u": a + b * x["u"], "v": (x["v"], b * x["v"])}

    parts = {"u": gs.observed(X, Y, x_unit="min", y_unit="mm"), "v": gs.observed([3, 1], [6, 2])}
    result = gs.calibrate(both, **OPTIONS | {"observations": parts})
    axes = Figure().subplots(2, 1)
    drawn = result.plot(axes)
    assert list(axes) == drawn
    assert drawn[0].get_xlabel() == "x [min]"
    measured, calculated = drawn[1].get_lines()
    assert list(measured.get_xdata()) == [1.0, 3.0]
    assert list(calculated.get_ydata()) == pytest.approx(list(2 * np.array([1.0, 3.0])), rel=0.5)
    with pytest.raises(ValueError, match="1 axes are given; accepted is one for each of the 2 series: u, v"):
        result.plot(axes[0])
    assert len(result.plot()) == 2


@pytest.mark.parametrize("limited", [False, True])
def test_a_lambda_stays_here_and_says_so(limited: bool) -> None:
    limits = {"limits": {"seconds_per_evaluation": 60}} if limited else {}
    with pytest.warns(gs.InProcessWarning, match="because it is a lambda.*\n.*without limits") as caught:
        result = gs.calibrate(lambda x, a, b: a + b * x, **OPTIONS, **limits, workers=2)
    assert [Path(one.filename) for one in caught] == [Path(__file__)]
    assert 50 <= result.evaluations <= 60
    assert result.failed_evaluations == 0


def test_a_lambda_has_the_history_of_the_function_in_a_file(tmp_path: Path) -> None:
    with pytest.warns(gs.InProcessWarning):
        here = gs.calibrate(lambda x, a, b=2.0: a + b * x, **OPTIONS, output=tmp_path / "out")
    assert numbers(here) == numbers(gs.calibrate(module(tmp_path).line, **OPTIONS))
    assert main(["statistics", str(tmp_path / "out"), "--json"]) == 0
    document = json.loads((tmp_path / "out" / "problem.json").read_text())
    document["forward_model"]["session"] = "of another day"
    with pytest.raises(gs.ForwardError, match="a function of a Python session that has ended"):
        gs.evaluate(document, a=1, b=2)


class Callable_:  # noqa: N801  the name of a class says what it is
    """An object that can be called."""

    def __call__(self, x: Any, a: float, b: float) -> Any:
        return a + b * x


def changed(folder: Path) -> Callable[..., Any]:
    """A function whose file was edited after its import."""
    found = module(folder)
    path = Path(found.__file__ or "")
    path.write_text(SOURCE.replace("a + b * x", "a - b * x"))
    return found.line  # type: ignore[no-any-return]


def nested(folder: Path) -> Callable[..., Any]:
    """A function inside another."""
    del folder

    def curve(x: Any, a: float, b: float) -> Any:
        return a + b * x

    return curve


def of_a_notebook(folder: Path) -> Callable[..., Any]:
    """A function of a cell."""
    del folder
    names: dict[str, Any] = {"__name__": "__main__"}
    exec(compile(SOURCE, "<cell 3>", "exec"), names)  # noqa: S102
    return names["line"]  # type: ignore[no-any-return]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (nested, "is nested.<locals>.curve, inside of something else"),
        (of_a_notebook, r"was not written in a file \(a notebook, or an interactive session\)"),
        (changed, "is not what model_of_tests_.* contains now; import it again"),
        (lambda folder: functools.partial(module(folder).line, b=2.0), "is a partial, no function"),
        (lambda _: Callable_(), "is a Callable_, no function"),
    ],
)
def test_functions_that_no_other_process_finds(
    tmp_path: Path, make: Callable[[Path], Callable[..., Any]], message: str
) -> None:
    with pytest.warns(gs.InProcessWarning, match=message):
        result = gs.calibrate(make(tmp_path), **OPTIONS)
    assert result.objective < 10.0


def test_exceptions_are_failed_evaluations_with_the_users_lines(tmp_path: Path) -> None:
    found = module(tmp_path)
    result = gs.calibrate(found.wrong, **OPTIONS)
    failed = result.runs["reason"] == "bad_output"
    assert 0 < failed.sum() == result.failed_evaluations < 60
    lines = result.history[int(np.argmax(failed))].evaluation.message
    assert lines is not None
    assert "wrong raised ValueError: a = " in lines
    assert f'  {found.__name__}.py, line 20, in wrong: raise ValueError(f"a = {{a:.1f}} is above 0")' in lines
    assert "geoswarm" not in lines.replace(found.__name__, "")


@pytest.mark.filterwarnings("ignore::geoswarm.InProcessWarning")
def test_nothing_found_is_told_where_it_is_asked_for() -> None:
    result = gs.calibrate(lambda x, a, b: None, **OPTIONS)  # noqa: ARG005
    assert result.state == "failed"
    for ask in (lambda: result.parameters, lambda: result.objective, result.statistics, result.plot):
        with pytest.raises(gs.SolverError, match=r"all 6 evaluations failed .*is a return missing"):
            ask()


@pytest.mark.usefixtures("blank_figures")
def test_resume_goes_on_to_the_same_result(tmp_path: Path) -> None:
    whole = gs.calibrate(DOCUMENT)

    def stop(record: Any) -> None:
        if record.number == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        gs.calibrate(DOCUMENT, output=tmp_path / "out", on_generation=stop)
    with pytest.raises(gs.SolverError, match="holds 24 runs of an interrupted calibration"):
        gs.calibrate(DOCUMENT, output=tmp_path / "out")
    again = gs.calibrate(DOCUMENT, output=tmp_path / "out", resume=True)
    assert numbers(again) == numbers(whole)
    with pytest.raises(gs.SolverError, match="is finished; read it"):
        gs.calibrate(DOCUMENT, output=tmp_path / "out", resume=True)


def test_every_option_of_a_problem_file_passes(tmp_path: Path) -> None:
    observation = gs.observed(
        [3, 1, 1, 2, 9, 10],
        [7000, 3000, 3000, 5000, 1, 1],
        **{"error": 100.0, "weight": 2.0, "weights": [1, 2, 2, 1, 1, 1], "x_unit": "min", "y_unit": "mm"},
        **{"sort": True, "repeated_x": "average", "x_from": 1.0, "x_to": 9.0},
    )
    options: dict[str, Any] = {
        "parameters": {
            "a": gs.free(0.1, 5, scale="log", initial=1),
            "b": gs.linked("2 * c"),
            "c": gs.free(1, 3, integer=True),
            "d": gs.fixed(9),
            "e": gs.linked("a * d"),
        },
        "constraints": ["a < d"],
        "observations": observation,
        "series": {"s": gs.series(x_unit="h", y_unit="cm", description="a line")},
        "method": {"kind": "monte_carlo", "samples": 8},
        "stopping": {"max_seconds": 1000},
        "limits": {"seconds_per_evaluation": 3, "memory_mb": 1000},
        "failures": {"retry": {"timeout": 1}, "policy": {"not_finite": "fail"}},
        "answer": {"max_evaluations": "off"},
        "weighting": "by_count",
        "noise": {"kind": "white"},
        "seed": np.int64(3),
        "name": "all of them",
    }
    line = module(tmp_path, SOURCE.replace("b=2.0", "b, d, **more")).line
    problem = gs.problem(line, **options)
    document = problem.document()
    assert (document["name"], document["seed"], document["weighting"]) == ("all of them", 3, "by_count")
    assert document["noise"] == {"kind": "white"}
    assert document["method"]["samples"] == 8
    assert document["limits"] == {"seconds_per_evaluation": 3.0, "memory_mb": 1000.0}
    assert document["failures"] == options["failures"]
    assert document["answer"] == options["answer"]
    (given,) = document["observations"]
    assert given["points"]["x"] == [1.0, 2.0, 3.0, 9.0, 10.0]
    assert (given["x_unit"], given["y_unit"], given["error"], given["weight"]) == ("min", "mm", 100.0, 2.0)
    assert document["forward_model"]["series"]["s"]["x_unit"] == "h"
    result = gs.calibrate(line, **options)
    assert result.failed_evaluations == 0
    assert result.parameters["b"] == 2 * result.parameters["c"]
    changed = gs.calibrate(problem, method={"kind": "monte_carlo", "samples": 3}, seed=4)
    assert (changed.evaluations, changed.seed) == (3, 4)


def test_a_search_of_a_function_without_stopping_ends_by_what_is_stated(tmp_path: Path) -> None:
    line = module(tmp_path).line
    options = {name: OPTIONS[name] for name in ("parameters", "observations")}
    assert gs.problem(line, **options).document()["stopping"] == dict(gs.DEFAULT_STOPPING)
    sampled = gs.problem(line, **options, method={"kind": "monte_carlo", "samples": 5})
    assert sampled.document()["stopping"] == {}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"parameters": {"a": gs.free(0, 1), "B": gs.free(0, 1)}}, r"parameters.B: unknown parameter .* known: a, b"),
        ({"parameters": {"b": gs.free(0, 1)}}, r"parameters.a: is missing \(Argument of line\)"),
        ({"parameters": {"a": gs.free(2, 1)}}, "parameters.a"),
        ({"parameters": {"a": 3}}, "parameters.a: must have either lower and upper"),
        ({"parameters": {"a": gs.free(0, 1), "x": gs.free(0, 1)}}, "parameters.x"),
        ({"parameters": {"__import__('os')": gs.free(0, 1)}}, "parameters"),
        ({"parameters": None}, "parameters: is missing"),
        ({"observations": None}, "observations: is missing; give observations=geoswarm.observed"),
        ({"observations": 3}, "observations: must be geoswarm.observed"),
        ({"observations": {"y": 3}}, "observations.y: must be geoswarm.observed"),
        ({"observations": {"no name!": gs.observed(X, Y)}}, "forward_model.series"),
        ({"observations": gs.observed(X, Y, y_unit="smoots")}, "unknown unit 'smoots"),
        ({"constraints": ["a > z"]}, r"constraints\[0\]: .* unknown z"),
        ({"series": {"z": gs.series(), "w": gs.series()}}, "unknown series 'y'"),
        ({"method": {"kind": "swarm"}}, "method.kind: unknown kind"),
        ({"method": "swarm"}, "method: must be a mapping"),
        ({"stopping": {"max_runs": 3}}, "stopping.max_runs"),
        ({"seed": -1}, "seed"),
    ],
)
def test_mistakes_are_told_with_their_place(tmp_path: Path, changes: dict[str, Any], message: str) -> None:
    with pytest.raises(gs.ProblemError, match=message):
        gs.calibrate(module(tmp_path).line, **OPTIONS | changes)


@pytest.mark.parametrize(
    ("x", "y", "message"),
    [
        ([1, 2], [[1, 2]], r"observed.y: must have one dimension, got the shape \(1, 2\)"),
        (["a"], [1], "observed.x: must be a list of numbers, got values of type"),
        ([[1, 2], [3]], [1], "observed.x: must be a list of numbers"),
        ([], [], r"observations\[0\].points.x: must not be empty"),
    ],
)
def test_points_that_are_none(x: Any, y: Any, message: str) -> None:
    with pytest.raises(gs.ProblemError, match=message):
        gs.problem(lambda a: a, parameters={"a": gs.free(0, 1)}, observations=gs.observed(x, y))


def test_what_is_no_model_is_refused() -> None:
    with pytest.raises(TypeError, match="model is a str: a function, a problem"):
        gs.calibrate("problem.yaml")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="workers must be a whole number from 1, got '4'"):
        gs.calibrate(lambda a: a, workers="4")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="resume=True needs output"):
        gs.calibrate(lambda a: a, resume=True)
    with pytest.raises(gs.ProblemError, match="series: is for a function"):
        gs.calibrate({"name": "x"}, series={"y": gs.series()})
    with pytest.raises(gs.ProblemError, match="by position only"):
        gs.calibrate(lambda a, /: a, observations=gs.observed(X, Y))


def test_evaluate(tmp_path: Path) -> None:
    found = module(tmp_path)
    problem = gs.load_problem(problem_file(tmp_path, found.line))
    one = gs.evaluate(problem, a=1, b=2)
    assert one.objective == 0.0
    np.testing.assert_array_equal(one.responses["y"], Y)
    assert one.parameters == {"a": 1.0, "b": 2.0}
    other = gs.evaluate(found.line, a=1.5, observations=gs.observed(X, Y))
    assert other.objective == pytest.approx(0.25, rel=1e-12)
    with pytest.raises(gs.ProblemError, match="E: unknown parameter; known: a, b\na: has no initial value"):
        gs.evaluate(problem, E=3, b=2)
    with pytest.raises(gs.ProblemError, match="a: 'nan' is not a finite number"):
        gs.evaluate(problem, a=float("nan"), b=2)
    with pytest.raises(gs.ForwardError, match="wrong raised ValueError") as caught:
        gs.evaluate(found.wrong, a=1, b=2, observations=gs.observed(X, Y))
    assert caught.value.reason == "bad_output"
    assert gs.evaluate(DOCUMENT, a=1, b=2).objective == 0.0


def test_the_service_refuses_it(tmp_path: Path, service: JobService) -> None:
    problem = gs.load_problem(problem_file(tmp_path, module(tmp_path).line))
    with pytest.raises(gs.ProblemError, match="accepted from problem files and Python only"):
        service.submit(problem)
    with pytest.raises(gs.ProblemError, match="accepted from problem files and Python only"):
        parse_problem(problem.document())


def test_a_mapping_is_a_problem() -> None:
    assert calibrate_problem(gs.problem(DOCUMENT)).objective == gs.calibrate(DOCUMENT).objective
