"""Claims under way: what is handed in early, and what is fetched ahead."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from geoswarm.solver.course import Course
from geoswarm.solver.runner.runner import Runner
from geoswarm.workers.coordinator.work import Claim, Submission
from geoswarm.workers.execution.claim_runner import ClaimRunner
from geoswarm.workers.settings import Settings
from tests.solver.runner.test_runner import misbehaving
from tests.workers.conftest import ON_SQLITE, MakeWorker

pytestmark = [pytest.mark.usefixtures("misbehaving_models"), ON_SQLITE]

SECONDS = 0.15
CLAIM = Claim("job", 3, (0, 1), (1, 1), np.array([[0.5], [1.0]]), now=100.0, run_seconds=0.0, job=None, typical=SECONDS)


@pytest.fixture
def settings(settings: Settings) -> Settings:
    """Nothing is handed in because it was long in the making."""
    return settings.model_copy(update={"chunk_seconds": 600.0})


@pytest.fixture
def runner(misbehaving_models: None) -> Iterator[Runner]:  # noqa: ARG001  forks with these models
    made = Runner()
    made.start()
    yield made
    made.close()


def run(
    claim: Claim, runner: Runner, worker: MakeWorker, settings: Settings, *answers: Claim | None
) -> list[Submission]:
    """Run a claim of sleeping evaluations; what was handed in early comes first, and what is left at the end last."""
    given = iter(answers)
    handed: list[Submission] = []

    def early(submission: Submission, want: bool) -> tuple[bool, Claim | None]:
        handed.append(submission)
        return True, next(given, None) if want else None

    model = Course(misbehaving(behaviour="sleep", seconds=SECONDS, above=-9.0))
    last = ClaimRunner(claim, runner, model, settings, worker().heartbeat, early).run()
    return [*handed, last]


def waiting(folder: Path) -> Course:
    """Evaluations that end when a file with the name of their value is there."""
    return Course(misbehaving(behaviour="wait", seconds=0.02, above=-9.0, notes=str(folder)))


def particles(submission: Submission) -> list[int]:
    return [result.particle for result in submission.results]


def test_the_next_claim_is_fetched_before_the_last_evaluation_ends(
    runner: Runner, make_worker: MakeWorker, settings: Settings, tmp_path: Path
) -> None:
    ahead = replace(CLAIM, particles=(4, 5), attempts=(1, 2), positions=np.array([[1.5], [2.0]]))
    asked: list[Submission] = []

    def early(submission: Submission, want: bool) -> tuple[bool, Claim | None]:
        assert want
        asked.append(submission)
        for name in (["1", "1.5"], ["2"])[len(asked) - 1]:  # the last evaluation of the claim may end now
            (tmp_path / name).touch()
        return True, ahead if len(asked) == 1 else None

    (tmp_path / "0.5").touch()
    last = ClaimRunner(CLAIM, runner, waiting(tmp_path), settings, make_worker().heartbeat, early).run()
    first, second = asked
    assert (particles(first), first.partial, first.under_way()) == ([0], True, {1})
    assert (particles(second), second.under_way()) == ([1, 4], {5})
    assert (particles(last), last.partial, last.under_way()) == ([5], False, frozenset())
    assert last.claim is not None
    assert (last.claim.particles, last.claim.attempts) == ((1, 4, 5), (1, 1, 2))
    seconds = [r.started_at for h in (*asked, last) for r in h.results]
    assert seconds == sorted(seconds)


def test_nothing_is_asked_for_ahead_where_nothing_was_left(
    runner: Runner, make_worker: MakeWorker, settings: Settings
) -> None:
    rest = replace(CLAIM, last=True)
    (only,) = run(rest, runner, make_worker, settings, CLAIM)
    assert particles(only) == [0, 1]


def test_without_a_typical_time_nothing_is_fetched_ahead(
    runner: Runner, make_worker: MakeWorker, settings: Settings
) -> None:
    unknown = replace(CLAIM, typical=None)
    (only,) = run(unknown, runner, make_worker, settings, CLAIM)
    assert particles(only) == [0, 1]


def test_what_was_fetched_ahead_goes_back_when_the_worker_is_to_end(
    runner: Runner, make_worker: MakeWorker, settings: Settings, tmp_path: Path
) -> None:
    ahead = replace(CLAIM, particles=(4,), attempts=(1,), positions=np.array([[0.5]]))
    worker = make_worker(grace_seconds=600.0)

    def early(_: Submission, want: bool) -> tuple[bool, Claim | None]:
        worker.stopping.set()
        (tmp_path / "1").touch()
        return True, ahead if want else None

    (tmp_path / "0.5").touch()
    last = ClaimRunner(CLAIM, runner, waiting(tmp_path), settings, worker.heartbeat, early).run()
    assert last.claim is not None
    assert last.claim.particles == (1, 4)
    assert particles(last) == [1]
