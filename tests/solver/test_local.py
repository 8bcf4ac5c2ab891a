from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable
from pathlib import Path

import pytest

from geoswarm.solver.errors import WorkerLostError
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.progress.result import CalibrationResult, GenerationRecord
from geoswarm.solver.runs import evaluators
from geoswarm.solver.runs.local import calibrate
from geoswarm.solver.system.processes import descendants
from tests.solver.problems import decay_problem


def bits(result: CalibrationResult) -> list[tuple[int, int, bytes, bytes | None, str | None]]:
    """The history without its times."""
    return [
        (
            r.generation,
            r.particle,
            r.evaluation.parameters.tobytes(),
            r.evaluation.responses["y"].tobytes() if r.evaluation.responses else None,
            r.evaluation.reason,
        )
        for r in result.history
    ]


def test_finds_the_parameters_of_exact_data() -> None:
    records: list[GenerationRecord] = []
    result = calibrate(decay_problem(), on_generation=records.append)
    assert result.state == "finished"
    assert result.stop_reasons == ("target_objective",)
    assert result.parameters == {"amplitude": pytest.approx(3.0, abs=1e-3), "rate": pytest.approx(0.7, abs=1e-3)}
    assert result.objective is not None
    assert result.best is not None
    assert result.best.objective == result.objective <= 1e-8
    assert result.evaluations == len(result.history) == 8 * result.generations
    assert records == result.generation_records
    objectives = [r.objective for r in records if r.objective is not None]
    assert objectives == sorted(objectives, reverse=True)
    assert result.seed == 11


def test_the_same_seed_gives_the_same_history_and_another_one_another() -> None:
    problem = decay_problem(stopping={"max_evaluations": 60})
    assert bits(calibrate(problem)) == bits(calibrate(problem)) != bits(calibrate(problem, seed=12))


def test_a_run_without_one_success_fails_and_counts_the_reasons() -> None:
    problem = decay_problem(
        forward_model={"kind": "formula", "series": {"y": "ln(-amplitude) + rate * x"}},
        stopping={"stagnation_generations": 3},
    )
    result = calibrate(problem)
    assert (result.state, result.objective, result.parameters, result.best) == ("failed", None, None, None)
    assert result.stop_reasons == ("stagnation_generations",)
    assert result.error is not None
    assert result.error.startswith("all 24 evaluations failed (24 not finite); first message: series 'y' is nan")
    assert result.failed_evaluations == 24


def test_failed_evaluations_do_not_stop_the_search() -> None:
    problem = decay_problem(
        forward_model={"kind": "formula", "series": {"y": "amplitude * exp(-rate * x) + 0 * sqrt(rate - 0.2)"}}
    )
    result = calibrate(problem)
    assert result.stop_reasons == ("target_objective",)
    assert 0 < result.failed_evaluations < result.evaluations


@pytest.fixture
def below() -> Callable[[], list[int]]:
    """Gives the processes below this one that were not there when the test began: servers of other tests stay."""
    before = set(descendants(os.getpid()))
    return lambda: [pid for pid in descendants(os.getpid()) if pid not in before]


@pytest.fixture
def processes_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Processes are started for the first evaluation, however quick."""
    monkeypatch.setattr(evaluators, "_START_SECONDS", 0.0)


def test_quick_runs_need_no_processes(below: Callable[[], list[int]]) -> None:
    found: list[int] = []
    problem = decay_problem(stopping={"max_evaluations": 60})
    calibrate(problem, workers=2, on_generation=lambda _: found.extend(below()))
    assert not found


def test_processes_take_over_when_quick_runs_are_many(monkeypatch: pytest.MonkeyPatch) -> None:
    problem = decay_problem(stopping={"max_evaluations": 60})
    single = calibrate(problem)
    seconds = sum(record.evaluation.seconds for record in single.history)
    monkeypatch.setattr(evaluators, "_START_SECONDS", seconds / 3)
    assert bits(calibrate(problem, workers=2)) == bits(single)


@pytest.mark.usefixtures("processes_at_once")
def test_killed_worker_processes_change_nothing(below: Callable[[], list[int]]) -> None:
    problem = decay_problem(stopping={"max_evaluations": 24})
    killed = []

    def kill(_: GenerationRecord) -> None:
        if found := below():  # those that were killed last may not have been replaced yet
            killed.append(found[len(killed) % len(found)])
            os.kill(killed[-1], signal.SIGKILL)

    assert bits(calibrate(problem, workers=2, on_generation=kill)) == bits(calibrate(problem))
    assert killed
    assert not below()


@pytest.mark.usefixtures("misbehaving_models")
def test_a_run_that_ends_its_process_or_exceeds_a_limit_is_a_failed_evaluation() -> None:
    for behaviour, reason in (("crash", "worker_lost"), ("hang", "timeout")):
        document = {
            "forward_model": {"kind": "bad", "behaviour": behaviour},
            "parameters": {"slope": {"lower": -1, "upper": 1}},
            "observations": [{"series": "y", "points": {"x": [0, 1, 2], "y": [0, 1, 2]}}],
            "method": {"kind": "monte_carlo", "samples": 4},
            "limits": {"seconds_per_evaluation": 2},
        }
        result = calibrate(parse_problem(document), seed=3)
        for record in result.history:
            evaluation = record.evaluation
            assert evaluation.reason == (reason if evaluation.parameters[0] > 0.0 else None), evaluation.message


@pytest.mark.usefixtures("misbehaving_models")
@pytest.mark.parametrize("workers", [1, 2])
def test_failed_evaluations_get_their_further_tries(workers: int, tmp_path: Path) -> None:
    document = {
        "forward_model": {"kind": "misbehaving", "behaviour": "diverge_once", "cured": str(tmp_path / "cured")},
        "parameters": {"slope": {"lower": -1, "upper": 1}},
        "observations": [{"series": "y", "points": {"x": [0, 1, 2], "y": [0, 1, 2]}}],
        "method": {"kind": "monte_carlo", "samples": 4},
        "failures": {"retry": {"diverged": 1}},
    }
    result = calibrate(parse_problem(document), workers=workers, seed=3)
    assert (result.evaluations, result.failed_evaluations) == (4, 0)


@pytest.mark.usefixtures("processes_at_once")
def test_an_interrupt_ends_all_processes(below: Callable[[], list[int]]) -> None:
    def interrupt(_: GenerationRecord) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        calibrate(decay_problem(), workers=2, on_generation=interrupt)
    assert not below()


@pytest.mark.usefixtures("processes_at_once")
def test_where_processes_are_not_watched_a_pool_gives_the_same_history(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(evaluators, "WATCHED", False)
    problem = decay_problem(stopping={"max_evaluations": 24})
    assert bits(calibrate(problem, workers=2)) == bits(calibrate(problem))


@pytest.mark.usefixtures("processes_at_once")
def test_a_killed_process_of_a_pool_is_a_clear_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(evaluators, "WATCHED", False)

    def kill_one(_: GenerationRecord) -> None:
        for child in multiprocessing.active_children():
            if child.pid is not None:
                os.kill(child.pid, signal.SIGKILL)

    with pytest.raises(WorkerLostError, match="one of the 2 worker processes ended unexpectedly"):
        calibrate(decay_problem(), workers=2, on_generation=kill_one)


def test_no_worker_is_refused() -> None:
    with pytest.raises(ValueError, match="workers is 0, at least 1"):
        calibrate(decay_problem(), workers=0)
