"""What a result tells where a calibration, a folder or a question has gone wrong."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import geoswarm as gs
from geoswarm.solver.report.document.build import Report, report_of_result
from tests.geoswarm.python_models import OPTIONS

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
    assert before > 200  # some at the optimum
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
