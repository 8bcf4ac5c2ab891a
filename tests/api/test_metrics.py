from __future__ import annotations

import logging

import pytest
from opentelemetry.sdk.trace import TracerProvider
from opentelemetry.sdk.trace.export import SimpleSpanProcessor
from opentelemetry.sdk.trace.export.in_memory_span_exporter import InMemorySpanExporter
from prometheus_client.parser import text_string_to_metric_families

from geoswarm.workers import tracing
from geoswarm.workers.execution.worker import Worker
from geoswarm.workers.identity import Identity
from geoswarm.workers.operations.counters import process_counters
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.waker import NoWaker
from tests.api.conftest import API, App, line_problem


def samples(app: App) -> dict[tuple[str, str], float]:
    """Every sample by name and its labels."""
    text = app.get("/metrics").text
    return {
        (sample.name, ",".join(sample.labels.values())): sample.value
        for family in text_string_to_metric_families(text)
        for sample in family.samples
    }


def work(service: JobService, settings: Settings, job_id: str) -> None:
    worker = Worker(service.store, NoWaker(), settings, Identity.new("embedded"))
    worker.start()
    worker.serve(job_id)
    worker.close()


@pytest.fixture(autouse=True)
def nothing_counted_before() -> None:
    process_counters.take()


def test_jobs_runs_and_seconds_are_counted_over_all_processes(
    app: App, service: JobService, settings: Settings
) -> None:
    before = samples(app)
    assert before["geoswarm_jobs", "queued"] == 0
    assert before["geoswarm_runs_total", "finished"] == 0
    job = app.post(f"{API}/jobs", json=line_problem()).json()["id"]
    assert samples(app)["geoswarm_jobs", "queued"] == 1
    assert samples(app)["geoswarm_oldest_queued_job_seconds", ""] >= 0
    work(service, settings, job)
    after = samples(app)
    assert after["geoswarm_jobs", "finished"] == 1
    assert after["geoswarm_runs_total", "finished"] == 60
    assert after["geoswarm_run_seconds_count", ""] == 60
    assert after["geoswarm_run_seconds_bucket", "+Inf"] == 60
    assert 0 < after["geoswarm_run_seconds_sum", ""] < 60
    assert after["geoswarm_queue_depth", ""] == 0
    assert after["geoswarm_http_requests_total", "GET,/metrics,200"] == 3
    assert after["geoswarm_http_requests_total", f"POST,{API}/jobs,201"] == 1


def test_what_waits_is_the_queue_depth(app: App, service: JobService, settings: Settings) -> None:
    job = app.post(f"{API}/jobs", json=line_problem()).json()["id"]
    worker = Worker(service.store, NoWaker(), settings, Identity.new("embedded"))
    course = worker._course(job)
    assert course is not None
    worker.runtime.start(job, course.start())
    assert samples(app)["geoswarm_queue_depth", ""] == 6


def test_failures_are_counted_by_reason_and_logged_with_their_place(
    app: App, service: JobService, settings: Settings, caplog: pytest.LogCaptureFixture
) -> None:
    failing = line_problem(
        forward_model={"kind": "formula", "series": {"y": {"expression": "sqrt(a - 10) + b * x"}}},
        stopping={"max_evaluations": 12},
    )
    job = app.post(f"{API}/jobs", json=failing).json()["id"]
    with caplog.at_level(logging.INFO, logger="geoswarm.workers.execution.claim_runner"):
        work(service, settings, job)
    counted = {label: value for (name, label), value in samples(app).items() if name == "geoswarm_runs_total"}
    assert sum(value for label, value in counted.items() if label != "finished") >= 6
    record = next(record for record in caplog.records if record.getMessage().startswith("run failed"))
    assert (record.job, record.generation, record.evaluation) == (job, 0, 0)  # type: ignore[attr-defined]


def test_labels_never_hold_what_a_client_wrote(app: App) -> None:
    for path in ("/nothing/<script>", f"{API}/jobs/unknown-id", "/static/none.css"):
        app.get(path)
    app("BREW", "/coffee")
    text = app.get("/metrics").text
    assert "script" not in text
    assert "unknown-id" not in text
    assert "BREW" not in text


def test_requests_are_logged_with_their_route(app: App, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO, logger="geoswarm.access"):
        app.get(f"{API}/jobs/abc", headers={"X-API-Key": "not-to-be-logged"})
    (record,) = [record for record in caplog.records if record.name == "geoswarm.access"]
    assert record.getMessage() == f"GET {API}/jobs/{{job_id}} 404"
    assert record.status == 404  # type: ignore[attr-defined]
    assert "not-to-be-logged" not in str(record.__dict__)


def test_requests_and_runs_leave_spans_when_traces_are_on(app: App, service: JobService, settings: Settings) -> None:
    exporter = InMemorySpanExporter()
    provider = TracerProvider()
    provider.add_span_processor(SimpleSpanProcessor(exporter))
    tracing.use(provider)
    try:
        job = app.post(f"{API}/jobs", json=line_problem()).json()["id"]
        work(service, settings, job)
    finally:
        tracing.use(None)
    spans = exporter.get_finished_spans()
    runs = [span for span in spans if span.name == "evaluation"]
    assert len(runs) == 60
    assert dict(runs[0].attributes or {}) == {
        "geoswarm.job": job,
        "geoswarm.generation": 0,
        "geoswarm.evaluation": 0,
    }
    assert any(span.name == "HTTP POST" for span in spans)
    app.get(f"{API}/jobs")
    assert len(exporter.get_finished_spans()) == len(spans)
