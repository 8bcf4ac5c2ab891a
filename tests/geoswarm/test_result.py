"""What a result tells where a calibration, a folder or a question has gone wrong."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import geoswarm as gs
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.report.document.build import Report, report_of_result
from tests.geoswarm.python_models import OPTIONS
from tests.solver.identifiability.test_leaving_out import curves, scattered

pytestmark = pytest.mark.filterwarnings("ignore::geoswarm.InProcessWarning")


class Counted:
    """A line that counts its runs."""

    def __init__(self) -> None:
        self.runs = 0

    def __call__(self, x: Any, a: float, b: float) -> Any:
        self.runs += 1
        return a + b * np.asarray(x)


@pytest.fixture(scope="module")
def line() -> Counted:
    return Counted()


@pytest.fixture(scope="module")
def result(line: Counted) -> Iterator[gs.Result]:
    with pytest.warns(gs.InProcessWarning):
        yield gs.calibrate(line, **OPTIONS | {"stopping": {"max_evaluations": 200}}, quick_runs=True)


def test_another_threshold_takes_no_further_run(line: Counted, result: gs.Result) -> None:
    proposed = result.statistics()
    before = line.runs
    assert 150 < before <= 200  # those at the optimum are part of the search
    threshold = 2.0 * proposed.filtered.threshold.value
    other = result.statistics(threshold=np.float32(threshold))
    assert line.runs == before
    again = report_of_result(result.problem, result.found, threshold=float(np.float32(threshold))).statistics
    assert again is not None
    assert other.filtered.threshold == again.filtered.threshold != proposed.filtered.threshold
    assert other.filtered.kept == again.filtered.kept
    assert [one.sentence for one in other.verdicts] == [one.sentence for one in again.verdicts]
    assert other.linearisation is proposed.linearisation


@pytest.mark.parametrize("threshold", ["1", True, [1.0]])
def test_a_threshold_that_is_no_number_is_refused(result: gs.Result, threshold: Any) -> None:
    with pytest.raises(TypeError, match=r"threshold must be above 0, in base units squared; got "):
        result.statistics(threshold=threshold)


@pytest.mark.parametrize("threshold", [0, -1.0, float("nan")])
def test_a_threshold_that_is_no_limit_is_refused(result: gs.Result, threshold: float) -> None:
    with pytest.raises(gs.SolverError, match="it must be a finite number above 0"):
        result.statistics(threshold=threshold)


@pytest.mark.usefixtures("blank_figures")
def test_a_report_that_cannot_be_written_says_where_and_can_be_written_again(
    result: gs.Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(self: Report, folder: Path) -> list[Path]:
        del self
        raise OSError(28, "No space left on device", str(folder / "report.html"))

    with monkeypatch.context() as disk:
        disk.setattr(Report, "save", full)
        with pytest.raises(gs.SolverError, match=r"report\.html: No space left on device"):
            result.report(tmp_path)
    assert {"report.html", "result.json"} <= {path.name for path in result.report(tmp_path)}
    assert {"report.html", "result.json"} <= {path.name for path in result.report(tmp_path)}  # over itself


def test_a_folder_with_a_run_that_was_cut_off_is_left_to_it(result: gs.Result, tmp_path: Path) -> None:
    def interrupted(_: Any) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        gs.calibrate(Counted(), **OPTIONS, output=tmp_path, on_generation=interrupted)
    left = (tmp_path / "run.journal").read_bytes()
    for call in (lambda: result.report(tmp_path), lambda: gs.calibrate(Counted(), **OPTIONS, output=tmp_path)):
        with pytest.raises(
            gs.SolverError, match=r"of an interrupted calibration: calibrate\(\.\.\., resume=True\) continues it"
        ):
            call()
    assert (tmp_path / "run.journal").read_bytes() == left


@pytest.mark.usefixtures("blank_figures")
def test_writing_a_result_runs_nothing(result: gs.Result, line: Counted, tmp_path: Path) -> None:
    before = line.runs
    result.report(tmp_path)
    assert line.runs == before > 0


@pytest.mark.usefixtures("blank_figures")
def test_the_result_of_a_search_is_written_before_its_answer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(record: Any) -> None:
        if record.search_evaluations not in (None, record.evaluations):
            raise KeyboardInterrupt

    monkeypatch.setattr("geoswarm.solver.report.folder.run_folder._SHORT_ANSWER", 0.0)
    model = Counted()
    with pytest.raises(KeyboardInterrupt):
        gs.calibrate(model, **OPTIONS, output=tmp_path, on_generation=interrupted)
    early = json.loads((tmp_path / "result.json").read_text(encoding="utf-8"))
    assert (early["state"], early["intervals"]) == ("running", None)
    assert (tmp_path / "report.html").is_file()
    again = gs.calibrate(model, **OPTIONS, output=tmp_path, resume=True)
    assert model.runs == len({one.evaluation.parameters.tobytes() for one in again.history})
    assert again.state == json.loads((tmp_path / "result.json").read_text(encoding="utf-8"))["state"] == "finished"


def test_columns_are_those_of_their_names_and_cannot_be_changed(result: gs.Result) -> None:
    with pytest.raises(ValueError, match="read-only"):
        result.runs["a"][0] = 0.0
    with pytest.raises(ValueError, match="read-only"):
        result.runs.responses["y"][0, 0] = 0.0
    copied = result.runs["a"].copy()
    copied[:] = 0.0
    assert [one.evaluation.parameters[0] for one in result.history] == result.runs["a"].tolist()


def test_a_parameter_that_is_called_like_a_column_is_kept_apart() -> None:
    def curve(x: Any, seconds: float, state: float) -> Any:
        return seconds + state * np.asarray(x)

    bounds = {"seconds": gs.free(100.0, 101.0), "state": gs.free(0.0, 0.5)}
    runs = gs.calibrate(curve, **OPTIONS | {"parameters": bounds}).runs
    assert runs["parameter.seconds"].min() >= 100.0 > runs["seconds"].max()
    assert set(runs["state"].tolist()) == {"finished"}
    assert runs["parameter.state"].dtype == np.float64


def test_a_calibration_that_a_failure_ends_says_so() -> None:
    def curve(x: Any, a: float, b: float) -> Any:
        if len(calls) == 25:
            raise RuntimeError("no convergence")
        calls.append(a)
        return a + b * np.asarray(x)

    calls: list[float] = []
    result = gs.calibrate(curve, **OPTIONS, failures={"policy": "fail"})
    assert result.state == "failed"
    assert "no convergence" in (result.error or "")
    assert repr(result).startswith("<Result failed: evaluation ")
    assert result.evaluations < result.runs.size
    assert result.parameters  # the best of the generations before


def bent_and_straight(weighting: str | None) -> gs.Problem:
    """Two series of the same a: of q the readings are a parabola, of p a line of another slope."""
    noise = np.random.default_rng(5)
    v, w = np.linspace(0.1, 3.0, 30), np.linspace(0.1, 3.0, 8)
    q = 50.0 * v + 12.0 * v**2 + 2.0 * noise.standard_normal(30)
    p = 0.2 + 0.9 * w + 0.01 * noise.standard_normal(8)
    observations = [
        {"series": "q", "points": {"x": v.tolist(), "y": q.tolist()}, "error": 2.0},
        {"series": "p", "points": {"x": w.tolist(), "y": p.tolist()}, "error": 0.01},
    ]
    if weighting != "by_error":
        for observation in observations:
            del observation["error"]
    return parse_problem(
        {
            "name": "two series",
            "forward_model": {"kind": "formula", "series": {"q": "a * x", "p": "b + a * x / 100"}},
            "parameters": {"a": {"lower": 1, "upper": 500}, "b": {"lower": -2, "upper": 2}},
            "observations": observations,
            "method": {"kind": "particle_swarm", "particles": 10, "polish": True},
            "stopping": {"max_evaluations": 200},
            "seed": 1,
        }
        | ({} if weighting is None else {"weighting": weighting})
    )


@pytest.mark.parametrize("weighting", [None, "by_range", "by_count", "by_error"])
def test_misfits_are_those_of_the_fit_that_is_shown(weighting: str | None) -> None:
    found = gs.calibrate(bent_and_straight(weighting), workers=1)
    misfits = [misfit for misfit in found.statistics().fit.misfits if misfit.stage is None]
    assert "q" in {misfit.series for misfit in misfits}
    shown = report_of_result(found.problem, found.found).figures.csv("fit")
    rows = [row for row in csv.DictReader(io.StringIO(shown)) if row["residual"]]
    for misfit in misfits:
        x, residual = np.array(
            [(float(row["x"]), float(row["residual"])) for row in rows if row["series"] == misfit.series]
        ).T
        worst = np.argmax(np.abs(residual))
        assert misfit.deviation == pytest.approx(np.sqrt(np.mean(residual**2)), rel=1e-6)
        assert (misfit.largest, misfit.x) == pytest.approx((residual[worst], x[worst]), rel=1e-6)


def test_each_test_is_left_out_and_needs_sensitivities() -> None:
    document = curves(*scattered(1, 4)).document() | {"seed": 1, "stopping": {"max_evaluations": 100}}
    found = gs.calibrate(parse_problem(document)).jackknife(workers=2)
    assert (found.tests, found.names, found.pulling("b")) == (
        ("test_1", "test_2", "test_3", "test_4"),
        ("a", "b"),
        "test_2",
    )
    assert np.isfinite(found.intervals).all()
    blind = gs.calibrate(parse_problem(document | {"method": {"kind": "monte_carlo", "samples": 9}, "stopping": {}}))
    with pytest.raises(gs.SolverError, match="sensitivities"):
        blind.jackknife()
