"""Registered programs in real engines: reasons, histories that are the same everywhere, versions."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.problem.text.writing import problem_yaml
from geoswarm.solver.runs.local import calibrate
from geoswarm.workers.hosts.engine import open_engine
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from tests.integration.engines import STEADY, celery_workers, wait_for, wait_until_ended
from tests.solver.external.test_failures import sleepers
from tests.solver.external.zoo import ZOO, zoo_problem

SEARCH: dict[str, Any] = {
    "method": {"kind": "particle_swarm", "particles": 4},
    "stopping": {"max_evaluations": 24},
}


@contextmanager
def embedded(tmp_path: Path, workers: int = 2) -> Iterator[JobService]:
    with open_engine(Settings(database_url=f"sqlite:///{tmp_path / 'jobs.db'}", workers=workers, **STEADY)) as engine:
        yield engine.service


def found(service: JobService, job_id: str) -> list[tuple[float, float | None, str | None]]:
    return [(v.parameters["slope"], v.objective, v.reason) for v in service.iterate_evaluations(job_id)]


def assert_zoo(service: JobService, folder: Path) -> None:
    ids = {name: service.submit(zoo_problem(name))[0].id for name in ZOO}
    for name, behaviour in ZOO.items():
        wait_until_ended(service, ids[name])
        views = [view for view in service.iterate_evaluations(ids[name]) if view.parameters["slope"] > 0]
        assert [view.reason for view in views] == [behaviour.reason] * 2, name
        assert all(behaviour.words in (view.message or "") for view in views), name
    wait_for(lambda: not sleepers(folder), "the end of what programs have started")


@pytest.mark.slow
@pytest.mark.usefixtures("zoo_models")
def test_each_failure_has_its_reason_embedded(tmp_path: Path) -> None:
    with embedded(tmp_path) as service:
        assert_zoo(service, tmp_path)


@pytest.mark.slow
@pytest.mark.usefixtures("zoo_models")
def test_each_failure_has_its_reason_with_celery(tmp_path: Path, fresh_postgres_url: str, fresh_redis_url: str) -> None:
    settings = Settings(database_url=fresh_postgres_url, broker_url=fresh_redis_url, **STEADY)
    with open_engine(settings) as engine, celery_workers(settings, concurrency=2):
        assert_zoo(engine.service, tmp_path)


@pytest.mark.slow
@pytest.mark.timeout(1800)  # five searches, with programs
@pytest.mark.usefixtures("zoo_models")
@pytest.mark.parametrize("name", ["good", "exit_3"])
def test_histories_are_the_same_everywhere(
    name: str, tmp_path: Path, fresh_postgres_url: str, fresh_redis_url: str
) -> None:
    problem = zoo_problem(name, **SEARCH)
    history = [record.evaluation for record in calibrate(problem).history]
    told = [(one.parameters[0], one.objective, one.reason) for one in history]
    with embedded(tmp_path) as service:
        job = wait_until_ended(service, service.submit(problem)[0].id)
        assert found(service, job.id) == told
    settings = Settings(database_url=fresh_postgres_url, broker_url=fresh_redis_url, **STEADY)
    with open_engine(settings) as engine:
        for concurrency in (1, 2, 4):
            with celery_workers(settings, concurrency=concurrency):
                job = wait_until_ended(engine.service, engine.service.submit(problem)[0].id)
                assert found(engine.service, job.id) == told


@pytest.mark.slow
def test_what_a_function_prints_and_raises_is_told_without_folders(zoo_models: Path, tmp_path: Path) -> None:
    source = "import sys\ndef f(slope):\n    print(__file__, file=sys.stderr)\n    return open(__file__ + '.csv')\n"
    (zoo_models / "good" / "model.py").write_text(source)
    section = {"kind": "python", "file": "model.py", "function": "f", "series": {"y": {}}}
    declared = {"forward_model": section, "parameters": {"slope": {}}}
    (zoo_models / "good" / "model.yaml").write_text(problem_yaml(declared))
    with embedded(tmp_path) as service:
        job = wait_until_ended(service, service.submit(zoo_problem("good"))[0].id)
        found = service.evaluation(job.id, 0, 0)
        assert found.log == "good/model.py\n"
        assert "No such file or directory: 'good/model.py.csv'" in (found.message or "")
        assert str(tmp_path) not in f"{job} {found}"


@pytest.mark.slow
def test_a_model_that_has_changed_is_refused_until_it_is_put_back(zoo_models: Path, tmp_path: Path) -> None:
    problem = zoo_problem("good")
    program = zoo_models / "good" / "zoo.py"
    text = program.read_text()
    with embedded(tmp_path, workers=0) as service:
        job = service.submit(problem)[0].id
    program.write_text(text + "# changed\n")
    with embedded(tmp_path) as service:
        wait_for(lambda: service.get(job).state == "paused", "the refusal")
        assert "its files have changed; put them back" in (service.get(job).error or "")
        assert service.get(job).evaluations == 0
        with pytest.raises(ProblemError, match="its files have changed"):
            service.submit(problem)
        with pytest.raises(ProblemError, match="unknown setting"):
            zoo_problem("good", forward_model={"kind": "registered", "model": "good", "settings": {"steps": 3}})
        program.write_text(text)
        service.resume(job)
        ended = wait_until_ended(service, job)
        assert (ended.state, ended.error) == ("finished", None)
        program.unlink()
        (zoo_models / "good" / "model.yaml").unlink()
        assert service.get(job).evaluations == 4
        assert service.evaluation(job, 0, 0).responses  # still read where the model is no more
