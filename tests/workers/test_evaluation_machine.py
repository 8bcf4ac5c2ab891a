from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from workers.coordinator.evaluation import (
    Claimed,
    EvaluationEvent,
    EvaluationStatus,
    LeaseExpired,
    LeaseReleased,
    ResultArrived,
    settle,
)

WORKERS = st.sampled_from(["w1", "w2", "w3"])
EVENTS: st.SearchStrategy[EvaluationEvent] = st.one_of(
    st.builds(Claimed, WORKERS),
    st.builds(ResultArrived, WORKERS, st.integers(1, 4), st.booleans()),
    st.just(LeaseExpired(3)),
    st.builds(LeaseReleased, WORKERS, st.integers(1, 4)),
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
        assert 0 <= status.attempts <= 3 or isinstance(event, Claimed)
        assert (status.state == "running") <= (status.worker is not None)
        if before.done:
            assert status == before
            assert verdict in ("late", "ignored")
    assert status.done == (counted == 1)


@given(st.lists(EVENTS, max_size=30), EVENTS)
def test_the_same_result_twice_changes_nothing(events: list[EvaluationEvent], last: EvaluationEvent) -> None:
    status = EvaluationStatus()
    for event in [*events, last]:
        status, _ = settle(status, event)
    if isinstance(last, ResultArrived):
        again, verdict = settle(status, last)
        assert again == status
        assert verdict in ("ignored", "late")
    assert status.attempts >= 0


def test_a_poisonous_evaluation_is_given_up_after_its_tries() -> None:
    status = EvaluationStatus()
    verdicts = []
    for worker in ("w1", "w2", "w3"):
        status, _ = settle(status, Claimed(worker))
        status, verdict = settle(status, LeaseExpired(3))
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
