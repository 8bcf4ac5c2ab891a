from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from geoswarm.workers.states.evaluation import (
    Claimed,
    Duplicated,
    EvaluationEvent,
    EvaluationStatus,
    LeaseExpired,
    LeaseReleased,
    Reopened,
    ResultArrived,
    settle,
)

WORKERS = st.sampled_from(["w1", "w2", "w3"])
EVENTS: st.SearchStrategy[EvaluationEvent] = st.one_of(
    st.builds(Claimed, WORKERS),
    st.builds(ResultArrived, WORKERS, st.integers(1, 4), st.booleans()),
    st.builds(Duplicated, WORKERS),
    st.builds(ResultArrived, WORKERS, st.integers(1, 4), st.just(True), st.booleans()),
    st.builds(LeaseExpired, st.booleans()),
    st.builds(LeaseReleased, WORKERS, st.integers(1, 4), st.booleans()),
)


@given(st.lists(EVENTS, max_size=30))
def test_whatever_happens_one_result_counts_and_it_is_the_first(events: list[EvaluationEvent]) -> None:
    status = EvaluationStatus()
    counted = 0
    for event in events:
        before = status
        status, verdict = settle(before, event)
        counted += verdict in ("counted", "given_up")
        assert counted <= 1
        assert status.attempts >= 0
        assert (status.state == "running") <= (status.worker is not None)
        if before.done:
            assert status == before
            assert verdict in ("late", "ignored")
        if verdict in ("retried", "redispatched", "released"):
            assert not status.done
    assert status.done == (counted == 1)


@given(st.lists(EVENTS, max_size=30), EVENTS)
def test_the_same_result_twice_changes_nothing(events: list[EvaluationEvent], last: EvaluationEvent) -> None:
    status = EvaluationStatus()
    for event in [*events, last]:
        status, _ = settle(status, event)
    if isinstance(last, ResultArrived):
        again, verdict = settle(status, last)
        assert again == status
        assert verdict in ("ignored", "late", "retried")
    assert status.attempts >= 0


def test_a_poisonous_evaluation_is_given_up_after_its_tries() -> None:
    status = EvaluationStatus()
    verdicts = []
    for worker in ("w1", "w2", "w3"):
        status, _ = settle(status, Claimed(worker))
        status, verdict = settle(status, LeaseExpired(worker != "w3"))
        verdicts.append(verdict)
    assert verdicts == ["redispatched", "redispatched", "given_up"]
    assert status.state == "failed"


def test_an_evaluation_given_back_has_used_no_try() -> None:
    claimed, _ = settle(EvaluationStatus(), Claimed("w1"))
    assert settle(claimed, LeaseReleased("w1", 1)) == (EvaluationStatus(), "released")


def test_a_claim_whose_answer_was_lost_can_be_repeated() -> None:
    claimed, _ = settle(EvaluationStatus(), Claimed("w1"))
    assert settle(claimed, Claimed("w1")) == (claimed, "claimed")
    assert settle(claimed, Claimed("w2")) == (claimed, "ignored")


def test_an_overdue_evaluation_in_two_hands_counts_once() -> None:
    claimed, _ = settle(EvaluationStatus(), Claimed("w1"))
    shared, verdict = settle(claimed, Duplicated("w2"))
    assert (shared, verdict) == (EvaluationStatus("running", 2, "w2"), "duplicated")
    assert settle(shared, Duplicated("w2")) == (shared, "ignored")
    first, verdict = settle(shared, ResultArrived("w1", 1, failed=False))
    assert (first, verdict) == (EvaluationStatus("finished", 2, "w1"), "counted")
    assert settle(first, ResultArrived("w2", 2, failed=False)) == (first, "late")


def test_a_failure_of_one_hand_leaves_the_other_at_work() -> None:
    shared = EvaluationStatus("running", 2, "w2")
    assert settle(shared, ResultArrived("w1", 1, failed=True)) == (shared, "retried")
    assert settle(shared, ResultArrived("w2", 2, failed=True)) == (EvaluationStatus("failed", 2, "w2"), "counted")


def test_a_further_try_is_granted_and_a_failed_one_can_be_reopened() -> None:
    claimed, _ = settle(EvaluationStatus(), Claimed("w1"))
    pending, verdict = settle(claimed, ResultArrived("w1", 1, failed=True, again=True))
    assert (pending, verdict) == (EvaluationStatus("pending", 1, None), "retried")
    failed, _ = settle(settle(pending, Claimed("w1"))[0], ResultArrived("w1", 2, failed=True))
    assert failed == EvaluationStatus("failed", 2, "w1")
    assert settle(failed, Reopened()) == (EvaluationStatus("pending", 2, None), "reopened")
    assert settle(pending, Reopened()) == (pending, "ignored")


def test_a_killed_evaluation_has_used_a_try_and_one_given_back_has_not() -> None:
    claimed, _ = settle(EvaluationStatus(), Claimed("w1"))
    assert settle(claimed, LeaseReleased("w1", 1, begun=True)) == (EvaluationStatus("pending", 1, None), "released")
