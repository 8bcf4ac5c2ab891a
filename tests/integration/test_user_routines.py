"""User routines in a service: only in registered models, in evaluation processes, which may die of them."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from geoswarm.cli import main
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.errors import ProblemError
from geoswarm.solver.problem import Problem, load_problem, parse_problem
from geoswarm.solver.problem.text.writing import problem_yaml
from geoswarm.solver.runs.local import calibrate
from geoswarm.solver.warm import groups_of
from geoswarm.workers.hosts.engine import open_engine
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from tests.integration.engines import STEADY, wait_for, wait_until_ended
from tests.solver.user_laws.routines import MISBEHAVING, library, section
from tests.solver.user_laws.test_sections import document, written

CRASH, XIT, KEEPS = 13, 1, 20
SEARCH: dict[str, Any] = {
    "method": {"kind": "particle_swarm", "particles": 4},
    "stopping": {"max_evaluations": 12},
    "seed": 1,
}


@contextmanager
def embedded(tmp_path: Path) -> Iterator[JobService]:
    with open_engine(Settings(database_url=f"sqlite:///{tmp_path / 'jobs.db'}", workers=2, **STEADY)) as engine:
        yield engine.service


@pytest.fixture
def models(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A registered model for each way of misbehaving: ``routine`` and, with state of its own, ``stateful``."""
    folder = tmp_path / "models"
    for name in ("routine", "stateful"):
        (folder / name).mkdir(parents=True)
        shutil.copy(library("misbehaving.f"), folder / name / "libroutine.so")
        material = {**section(MISBEHAVING, stateful=name == "stateful"), "library": "libroutine.so"}
        model = {
            "title": "Oedometer with a routine",
            "forward_model": document(material)["forward_model"],
            "parameters": {"E": {"unit": "kPa"}, "nu": {}, "mode": {}, "stress": {"unit": "kPa"}},
        }
        (folder / name / "model.yaml").write_text(problem_yaml(model))
    monkeypatch.setenv("GEOSWARM_MODELS", str(folder))
    return folder


def registered(model: str, mode: int) -> Problem:
    """A problem as a user of the service sends it."""
    plain = document({}, {"mode": {"value": mode}, "stress": {"value": 100}})
    return parse_problem({**plain, "forward_model": {"kind": "registered", "model": model}, **SEARCH})


def found(service: JobService, problem: Problem) -> list[tuple[float, float | None, str | None, str]]:
    """Parameter, objective, reason and message of every evaluation of a job."""
    job = service.submit(problem)[0]
    wait_until_ended(service, job.id)
    views = service.iterate_evaluations(job.id)
    return [(view.parameters["E"], view.objective, view.reason, view.message or "") for view in views]


def test_the_kernels_of_a_registered_routine_are_compiled_before_its_first_evaluation(models: Path) -> None:
    problem = registered("routine", 0)
    assert groups_of(problem.forward_model) == ("element_test", "umat")
    shutil.rmtree(models / "routine")
    assert groups_of(problem.forward_model) == ()  # what is missing is told elsewhere


@pytest.mark.slow
def test_a_registered_routine_calibrates_as_in_process(models: Path, tmp_path: Path) -> None:
    here = load_problem(
        written(
            tmp_path,
            document(section(MISBEHAVING), {"mode": {"value": 0}, "stress": {"value": 100}}) | SEARCH,
        )
    )
    expected = [(r.evaluation.parameters[0], r.evaluation.objective, None, "") for r in calibrate(here).history]
    with embedded(tmp_path) as service:
        assert found(service, registered("routine", 0)) == expected
        changed = registered("routine", 0)
        model = models / "routine" / "libroutine.so"
        original = model.read_bytes()
        shutil.copy(library("elastic.f"), model)
        with pytest.raises(ProblemError, match="its files have changed"):
            service.submit(changed)
        model.write_bytes(original)
    with pytest.raises(ProblemError, match="library of the machine it runs on"):
        parse_problem(here.document())


@pytest.mark.slow
def test_crashes_and_exits_are_failed_evaluations(models: Path, tmp_path: Path) -> None:  # noqa: ARG001
    with embedded(tmp_path) as service:
        assert {reason for _, _, reason, _ in found(service, registered("routine", CRASH))} == {"worker_lost"}
        ended = found(service, registered("routine", XIT))
        assert {reason for _, _, reason, _ in ended} == {"diverged"}
        assert all("the routine ended itself (XIT, STOP)" in message for *_, message in ended)
        wait_for(lambda: service.workers() != [], "the workers, which live on")


@pytest.mark.slow
def test_a_routine_with_state_of_its_own_begins_anew_with_each_run(models: Path, tmp_path: Path) -> None:  # noqa: ARG001
    problem = registered("stateful", KEEPS)
    with embedded(tmp_path) as service:
        history = found(service, problem)
    alone = Calibration(registered("stateful", KEEPS), 1)
    for E, objective, reason, _ in history:
        assert reason is None
        assert objective == alone.evaluate_values({**problem.values([E])}).objective


# tests/geoswarm/cli/test_model.py checks a registered model, test_mfront.py one with a library
@pytest.mark.slow
def test_a_registered_routine_lies_in_the_folder_of_its_model(models: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert (
        main(
            [
                "models",
                "check",
                "routine",
                "--set",
                "E=5000",
                "--set",
                "nu=0.3",
                "--set",
                "mode=0",
                "--set",
                "stress=100",
            ]
        )
        == 0
    )
    assert "last" in capsys.readouterr().out
    assert main(["models", "show", "routine"]) == 0
    assert "stage_axial_strain" in capsys.readouterr().out
    model = models / "routine" / "model.yaml"
    for place in ("../stateful/libroutine.so", str(models / "stateful" / "libroutine.so")):
        model.write_text(model.read_text().replace("library: libroutine.so", f"library: {place}"))
        with pytest.raises(ProblemError, match="the library must lie in the folder of the model"):
            registered("routine", 0)
        model.write_text(model.read_text().replace(f"library: {place}", "library: libroutine.so"))
