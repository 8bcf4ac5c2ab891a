"""Metrics in the text format of Prometheus.

What concerns the whole installation is read from the database at every scrape, so that any process answers the same and
none has to be scraped. What concerns requests (``geoswarm_http_*``, ``geoswarm_event_streams``) is of this process.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING

from fastapi import APIRouter, Request
from fastapi.responses import PlainTextResponse
from prometheus_client import CollectorRegistry, generate_latest
from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, HistogramMetricFamily, Metric
from prometheus_client.registry import Collector

from geoswarm.api.dependencies import Feed, Service, problems_of
from geoswarm.records.states import JOB_STATES
from geoswarm.workers.operations.counters import BUCKETS
from geoswarm.workers.operations.measures import Measures

if TYPE_CHECKING:
    from geoswarm.api.compute.pool import ComputePool

__all__ = ["CONTENT_TYPE", "router"]

router = APIRouter(tags=["health"])

CONTENT_TYPE = "text/plain; version=0.0.4; charset=utf-8"


@router.get(
    "/metrics",
    response_class=PlainTextResponse,
    responses={200: {"content": {"text/plain": {"schema": {"type": "string"}}}}, **problems_of()},
)
def metrics(service: Service, feed: Feed, request: Request) -> PlainTextResponse:
    """Show the metrics of the installation and of this process, for Prometheus, without details of jobs."""
    registry = CollectorRegistry()
    pool: ComputePool | None = request.app.state.pool
    registry.register(_Installation(service.measures(), feed.listeners, 0 if pool is None else pool.busy))
    text = generate_latest(registry) + generate_latest(request.app.state.requests.registry)
    return PlainTextResponse(text, media_type=CONTENT_TYPE)


class _Installation(Collector):
    """The measures in the words of Prometheus."""

    def __init__(self, measures: Measures, streams: int, compute: int) -> None:
        self._measures = measures
        self._compute = compute
        self._streams = streams

    def collect(self) -> Iterator[Metric]:
        """Yield all families."""
        m = self._measures
        yield _gauge("geoswarm_jobs", "Jobs in each state.", "state", {s: m.jobs.get(s, 0) for s in JOB_STATES})
        yield GaugeMetricFamily(
            "geoswarm_queue_depth", "Evaluations of running jobs that wait for a worker.", value=m.waiting
        )
        yield GaugeMetricFamily("geoswarm_evaluations_running", "Evaluations that a worker has.", value=m.running)
        yield GaugeMetricFamily(
            "geoswarm_oldest_queued_job_seconds",
            "Age of the oldest job that no worker has started.",
            value=m.oldest_wait,
        )
        yield _gauge("geoswarm_workers", "Worker processes in each state.", "state", m.workers)
        yield GaugeMetricFamily("geoswarm_event_streams", "Open event streams of this process.", value=self._streams)
        yield GaugeMetricFamily(
            "geoswarm_compute_busy",
            "Processes at work on a request that calculates.",
            value=self._compute,
        )
        yield _counter("geoswarm_runs", "Forward runs by outcome.", "outcome", self._labels("runs", ["finished"]))
        yield self._seconds()
        yield _counter(
            "geoswarm_sweep_actions",
            "What sweeps did.",
            "action",
            self._labels("sweep_actions", ["worker_given_up", "job_rung"]),
        )
        yield GaugeMetricFamily(
            "geoswarm_notices_waiting", "Messages about ended jobs that wait to be delivered.", value=m.notices
        )
        yield _counter(
            "geoswarm_notices",
            "Delivery attempts of messages about ended jobs, by outcome.",
            "outcome",
            self._labels("notices", ["delivered", "retried", "given_up"]),
        )
        family = CounterMetricFamily("geoswarm_lease_expirations", "Evaluations that were taken from a lost worker.")
        family.add_metric([], m.counters.get(("lease_expirations", ""), 0.0))
        yield family

    def _labels(self, name: str, always: Iterable[str]) -> dict[str, float]:
        counted = {label: value for (counter, label), value in self._measures.counters.items() if counter == name}
        return dict.fromkeys(always, 0.0) | counted

    def _seconds(self) -> Metric:
        counted = self._labels("run_seconds", [])
        total, buckets = 0.0, []
        for label in [*(f"{limit:g}" for limit in BUCKETS), "+Inf"]:
            total += counted.get(label, 0.0)
            buckets.append((label, total))
        family = HistogramMetricFamily("geoswarm_run_seconds", "Wall time of forward runs.")
        family.add_metric([], buckets, sum_value=self._measures.counters.get(("run_seconds_sum", ""), 0.0))
        return family


def _gauge(name: str, text: str, label: str, values: Mapping[str, float]) -> Metric:
    family = GaugeMetricFamily(name, text, labels=[label])
    for key, value in values.items():
        family.add_metric([key], value)
    return family


def _counter(name: str, text: str, label: str, values: Mapping[str, float]) -> Metric:
    family = CounterMetricFamily(name, text, labels=[label])
    for key, value in values.items():
        family.add_metric([key], value)
    return family
