from __future__ import annotations

import json
from collections.abc import Mapping

import numpy as np
import pytest

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, choose_seed
from geoswarm.solver.course import Course
from geoswarm.solver.errors import DivergedError
from geoswarm.solver.methods.particle_swarm import ParticleSwarmMethod, swarm_settings
from geoswarm.solver.objective.outcome import Calculation
from geoswarm.solver.progress.state import Progress
from tests.solver.problems import decay_problem


def test_evaluate_gives_objective_misfits_and_responses() -> None:
    calibration = Calibration(decay_problem(), seed=1)
    evaluation = calibration.evaluate(np.array([3.0, 0.7]))
    assert evaluation.reason is None
    assert evaluation.objective == pytest.approx(0.0, abs=1e-28)
    assert evaluation.responses["y"] == pytest.approx(calibration.problem.observations[0].y)
    worse = calibration.evaluate_values({"amplitude": 4.0, "rate": 0.7})
    assert worse.parameters.tolist() == [4.0, 0.7]
    x = calibration.grids["y"]
    assert worse.objective == pytest.approx(np.mean(np.exp(-1.4 * x)), rel=1e-13)
    assert worse.misfits == {"y": worse.objective}


def test_a_response_that_is_not_finite_is_a_failed_evaluation() -> None:
    problem = decay_problem(forward_model={"kind": "formula", "series": {"y": "amplitude * ln(rate - 0.5) + 0 * x"}})
    evaluation = Calibration(problem, seed=1).evaluate(np.array([1.0, 0.1]))
    assert (evaluation.reason, evaluation.objective, evaluation.responses) == ("not_finite", None, {})
    assert evaluation.message is not None
    assert "series 'y' is nan at point 1 of 21" in evaluation.message


@pytest.mark.parametrize(
    ("raised", "reason", "message"),
    [
        (DivergedError("stage 3 has no solution"), "diverged", "stage 3 has no solution"),
        (ZeroDivisionError("division by zero"), "bad_output", "the forward model raised ZeroDivisionError: division"),
    ],
)
def test_whatever_a_forward_model_raises_is_a_failed_evaluation(
    raised: Exception, reason: str, message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    calibration = Calibration(decay_problem(), seed=1)

    def broken(_: Mapping[str, float]) -> dict[str, FloatArray]:
        raise raised

    calculation = Calculation(broken, calibration.objective.observed, keeps_parts=False)
    monkeypatch.setattr(calibration, "_calculation", calculation)
    evaluation = calibration.evaluate(np.array([1.0, 0.1]))
    assert evaluation.reason == reason
    assert evaluation.message is not None
    assert evaluation.message.startswith(message)


def test_progress_survives_json_bit_for_bit() -> None:
    course = Course(Calibration(decay_problem(), seed=3))
    progress = course.start()
    for _ in range(4):
        restored = Progress.from_json(json.loads(json.dumps(progress.to_json(), allow_nan=False)))
        assert restored.to_json() == progress.to_json()
        objectives = [course.calibration.evaluate(p).objective for p in progress.positions]
        step, again = (course.advance(p, objectives, 1.0) for p in (progress, restored))
        assert step.progress.to_json() == again.progress.to_json()
        progress = step.progress


def test_advance_counts_and_keeps_the_earliest_best() -> None:
    course = Course(Calibration(decay_problem(), seed=3))
    first = course.start()
    step = course.advance(first, [None, 2.0, 1.0, 1.0, 3.0, None, 9.0, 9.0], 1.0)
    best = step.progress.best
    assert best is not None
    assert (best.objective, best.generation, best.particle) == (1.0, 0, 2)
    assert best.parameters.tolist() == first.positions[2].tolist()
    assert (step.progress.evaluations, step.progress.failed, step.progress.stagnation) == (8, 2, 0)
    later = course.advance(step.progress, [1.0] * 8, 2.0)
    assert later.progress.best is not None
    assert (later.progress.best.generation, later.progress.stagnation) == (0, 1)


def test_stop_reasons_are_all_reported() -> None:
    problem = decay_problem(stopping={"max_evaluations": 8, "target_objective": 1.0, "max_seconds": 5.0})
    course = Course(Calibration(problem, seed=3))
    step = course.advance(course.start(), [0.5] * 8, 6.0)
    assert step.stop_reasons == ("target_objective", "max_evaluations", "max_seconds")
    assert course.advance(course.start(), [1.5] * 8, 4.0).stop_reasons == ("max_evaluations",)


def test_a_sampling_ends_with_its_samples() -> None:
    problem = decay_problem(method={"kind": "monte_carlo", "samples": 30, "batch": 20}, stopping=None)
    course = Course(Calibration(problem, seed=3))
    step = course.advance(course.start(), [1.0] * 20, 1.0)
    assert (step.stop_reasons, len(step.progress.positions)) == ((), 10)
    assert course.advance(step.progress, [1.0] * 10, 1.0).stop_reasons == ("samples_completed",)


@pytest.mark.parametrize("sampling", ["random", "latin_hypercube", "sobol"])
def test_a_sampling_ends_before_its_samples_when_fewer_evaluations_are_allowed(sampling: str) -> None:
    method = {"kind": "monte_carlo", "samples": 1_000_000, "batch": 20, "sampling": sampling}
    course = Course(Calibration(decay_problem(method=method, stopping={"max_evaluations": 30}), seed=3))
    step = course.advance(course.start(), [1.0] * 20, 1.0)
    assert (step.stop_reasons, len(step.progress.positions)) == ((), 10)
    assert course.advance(step.progress, [1.0] * 10, 1.0).stop_reasons == ("max_evaluations",)


def test_advance_is_pure() -> None:
    course = Course(Calibration(decay_problem(), seed=3))
    progress = course.start()
    before = json.dumps(progress.to_json())
    course.advance(progress, [1.0] * 8, 1.0)
    assert json.dumps(progress.to_json()) == before


def test_swarm_coefficients_take_the_default_of_their_form() -> None:
    constriction = swarm_settings(ParticleSwarmMethod(kind="particle_swarm"))
    inertia = swarm_settings(ParticleSwarmMethod(kind="particle_swarm", form="inertia_weight"))
    assert (constriction.cognitive_coefficient, constriction.social_coefficient) == (2.05, 2.05)
    assert inertia.weights == (0.7298, 1.49618, 1.49618)


def test_a_seed_is_kept_or_chosen() -> None:
    assert choose_seed(0) == 0
    chosen = {choose_seed(None) for _ in range(8)}
    assert len(chosen) > 1
    assert all(0 <= seed < 2**32 for seed in chosen)
