"""Traces for OpenTelemetry, when it is installed (``geoswarm[tracing]``) and an exporter is named; else nothing.

The usual variables of OpenTelemetry decide: OTEL_EXPORTER_OTLP_ENDPOINT turns traces on, OTEL_SERVICE_NAME names them.
"""

from __future__ import annotations

import os
import time
from contextlib import AbstractContextManager, nullcontext
from typing import Any

from geoswarm.solver.system.extras import needs_extra
from geoswarm.workers.errors import SettingsError

__all__ = ["enabled", "record_span", "span", "start_tracing"]

_tracer: Any = None

ENDPOINTS = ("OTEL_EXPORTER_OTLP_ENDPOINT", "OTEL_EXPORTER_OTLP_TRACES_ENDPOINT")


def start_tracing(part: str) -> None:
    """Send the traces of this process where the environment says; without an endpoint do nothing.

    Parameters
    ----------
    part
        serve, worker or sweep: added to the name of the service.

    Raises
    ------
    SettingsError
        When an endpoint is named but OpenTelemetry is not installed.
    """
    if not any(os.environ.get(name) for name in ENDPOINTS):
        return
    try:
        from opentelemetry.exporter.otlp.proto.http.trace_exporter import OTLPSpanExporter
        from opentelemetry.sdk.resources import Resource
        from opentelemetry.sdk.trace import TracerProvider
        from opentelemetry.sdk.trace.export import BatchSpanProcessor
    except ImportError:
        raise SettingsError(
            f"{' or '.join(ENDPOINTS)} asks for traces: {needs_extra('tracing', 'opentelemetry')}"
        ) from None
    name = os.environ.get("OTEL_SERVICE_NAME") or f"geoswarm-{part}"
    provider = TracerProvider(resource=Resource.create({"service.name": name}))
    provider.add_span_processor(BatchSpanProcessor(OTLPSpanExporter()))
    use(provider)


def use(provider: Any) -> None:
    """Make spans with this provider; None: none any more."""
    global _tracer
    _tracer = None if provider is None else provider.get_tracer("geoswarm")


def enabled() -> bool:
    """Whether spans are recorded."""
    return _tracer is not None


def span(name: str, **attributes: str | int | float) -> AbstractContextManager[Any]:
    """Record what happens in the body of a ``with`` statement; costs nothing to speak of without a tracer."""
    if _tracer is None:
        return nullcontext()
    named = {f"geoswarm.{key}": value for key, value in attributes.items()}
    recorded: AbstractContextManager[Any] = _tracer.start_as_current_span(name, attributes=named)
    return recorded


def record_span(name: str, seconds: float, **attributes: str | int | float) -> None:
    """Record what has happened elsewhere and ended just now, after so long [s]."""
    if _tracer is not None:
        named = {f"geoswarm.{key}": value for key, value in attributes.items()}
        end = time.time_ns()
        _tracer.start_span(name, attributes=named, start_time=end - round(seconds * 1e9)).end(end)
