from __future__ import annotations

import itertools
from collections.abc import Sequence

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geoswarm.records.states import ENDED_STATES
from geoswarm.solver.errors import InfeasibleSpaceError
from geoswarm.solver.progress.result import alike_warning
from geoswarm.workers.errors import InvalidTransitionError
from geoswarm.workers.states.job import (
    CancelRequested,
    DispatchGeneration,
    FinishJob,
    GenerationJoined,
    JobBroken,
    JobEvent,
    JobStarted,
    JobStatus,
    Joined,
    PauseRequested,
    PublishEvent,
    RecordGeneration,
    ResumeRequested,
    Transition,
    WakeWorkers,
    apply,
)
from tests.workers.problems import course, line

# the textbook swarm: these tests make up objectives for which there are no responses
SWARM = {"kind": "particle_swarm", "particles": 6, "acceleration": "none"}
PROBLEM = line(method=SWARM, stopping={"max_evaluations": 24})
COURSE = course(PROBLEM)
START = COURSE.start()
SUCCESS = st.floats(0, 1e6)
RESULTS = st.lists(
    st.one_of(
        st.builds(Joined, SUCCESS), st.sampled_from([Joined(None, "diverged", "no"), Joined(None, "not_finite")])
    ),
    min_size=6,
    max_size=6,
)
EVENTS: st.SearchStrategy[JobEvent] = st.one_of(
    st.just(JobStarted(START)),
    st.builds(GenerationJoined, st.integers(0, 4), RESULTS, st.floats(0, 100)),
    st.sampled_from([CancelRequested(), PauseRequested(), ResumeRequested()]),
    st.just(JobBroken("gone")),
)


def run(events: Sequence[JobEvent]) -> list[Transition]:
    transitions = [Transition(JobStatus())]
    for event in events:
        try:
            transitions.append(apply(transitions[-1].job, event, COURSE))
        except InvalidTransitionError:
            continue
    return transitions


@settings(max_examples=200, deadline=None)
@given(st.lists(EVENTS, max_size=25))
def test_invariants_hold_whatever_the_order(events: list[JobEvent]) -> None:
    transitions = run(events)
    dispatched: list[int] = []
    recorded: list[int] = []
    for before, after in itertools.pairwise(transitions):
        job, instructions = after.job, after.instructions
        assert job.generations - before.job.generations in (0, 1)
        assert job.generation >= before.job.generation
        if before.job.state in ENDED_STATES:
            assert job == before.job
            assert instructions == ()
        dispatched += [i.generation for i in instructions if isinstance(i, DispatchGeneration)]
        recorded += [i.record.number for i in instructions if isinstance(i, RecordGeneration)]
        assert any(isinstance(i, FinishJob) for i in instructions) == (
            job.state in ENDED_STATES and before.job.state not in ENDED_STATES
        )
        if job.state != before.job.state:
            assert any(isinstance(i, PublishEvent) and i.kind == "state" for i in instructions)
        if job.progress is not None:
            assert job.progress.evaluations == 6 * job.generations
            assert job.progress.failed == sum(job.failures.values())
    assert dispatched == list(range(len(dispatched)))  # each once, in order
    assert recorded == list(range(len(recorded)))
    assert len(recorded) <= len(dispatched) <= len(recorded) + 1


def test_a_generation_that_joins_twice_counts_once() -> None:
    started = apply(JobStatus(), JobStarted(START)).job
    event = GenerationJoined(0, [Joined(float(i)) for i in range(6)], 1.0)
    once = apply(started, event, COURSE)
    twice = apply(once.job, event, COURSE)
    assert once.job.generations == 1
    assert twice == Transition(once.job)


def test_pause_keeps_the_state_of_the_search() -> None:
    started = apply(JobStatus(), JobStarted(START)).job
    paused = apply(started, PauseRequested()).job
    resumed = apply(paused, ResumeRequested())
    assert paused.state == "paused"
    assert resumed.job.progress is START
    assert any(isinstance(i, WakeWorkers) for i in resumed.instructions)


def test_a_job_paused_before_its_start_is_queued_again() -> None:
    paused = apply(JobStatus(), PauseRequested()).job
    assert apply(paused, JobStarted(START)) == Transition(paused)
    assert apply(paused, ResumeRequested()).job.state == "queued"


def test_without_one_success_the_job_fails_with_the_reasons_counted() -> None:
    job = apply(JobStatus(), JobStarted(START)).job
    results = [Joined(None, "diverged", "step 3")] * 4 + [Joined(None, "not_finite", "y")] * 2
    while job.state == "running":
        job = apply(job, GenerationJoined(job.generation, results, 1.0), COURSE).job
    assert job.state == "failed"
    assert job.error == "all 24 evaluations failed (16 diverged, 8 not finite); first message: step 3"


def test_a_program_that_always_fails_ends_the_job_after_its_first_generation() -> None:
    started = apply(JobStatus(), JobStarted(START)).job
    failed = [Joined(None, "program_failed", "no such file")] * 5
    job = apply(started, GenerationJoined(0, [*failed, Joined(None, "no_output", "b")], 1.0), COURSE).job
    assert (job.state, job.stop_reasons) == ("failed", ("all_failed",))
    assert job.error is not None
    assert job.error.startswith("all 6 evaluations failed (1 no output, 5 program failed), which ends the search")
    assert job.error.endswith("; first message: no such file")
    going = apply(started, GenerationJoined(0, [*failed, Joined(None, "diverged", "c")], 1.0), COURSE).job
    assert (going.state, going.generations) == ("running", 1)


def test_runs_with_one_objective_are_told_until_one_differs() -> None:
    started = apply(JobStatus(), JobStarted(START)).job
    alike = apply(started, GenerationJoined(0, [*[Joined(2.0)] * 5, Joined(None, "diverged")], 1.0), COURSE).job
    assert "all 5 runs so far gave the same objective" in str(alike_warning(alike.alike))
    more = apply(alike, GenerationJoined(1, [Joined(2.0)] * 6, 1.0), COURSE).job
    assert "all 11 runs so far" in str(alike_warning(more.alike))
    other = apply(alike, GenerationJoined(1, [*[Joined(2.0)] * 5, Joined(3.0)], 1.0), COURSE).job
    assert alike_warning(other.alike) is None


def test_an_infeasible_space_fails_the_job_with_its_message() -> None:
    ended = apply(JobStatus(), JobStarted(InfeasibleSpaceError("nothing satisfies a > b")))
    assert (ended.job.state, ended.job.error) == ("failed", "nothing satisfies a > b")


@pytest.mark.parametrize("event", [PauseRequested(), ResumeRequested(), CancelRequested()])
def test_an_ended_job_refuses_requests_and_says_what_is_accepted(event: JobEvent) -> None:
    with pytest.raises(InvalidTransitionError, match=r"cannot \w+ a job that is finished; accepted states: "):
        apply(JobStatus(state="finished"), event)


def test_joining_too_few_results_is_an_error_of_the_program() -> None:
    started = apply(JobStatus(), JobStarted(START)).job
    with pytest.raises(ValueError, match="joins 1 results of 6 particles"):
        apply(started, GenerationJoined(0, [Joined(1.0)], 1.0), COURSE)
