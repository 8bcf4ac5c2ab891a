# Generated from geoswarm/client/_async/reports.py by scripts/generate_client.py; `make format` renews it.
"""Reports and figures of a job."""

from __future__ import annotations

from collections.abc import Collection
from typing import Literal
from urllib.parse import quote

from geoswarm.client._sync.connection import Connection
from geoswarm.client.calls import Call, Noise, OtherSet, job_path, reader, view_query
from geoswarm.client.models import Figure, Report

__all__ = ["figure", "figures", "report", "report_pdf"]


def report(
    self: Connection,
    job_id: str,
    *,
    threshold: float | None = None,
    noise: Noise = None,
    posterior: bool = False,
    compare: OtherSet = None,
    parts: Collection[str] = (),
) -> Report:
    """Show the report of a job, on request with a posterior sample; a notebook displays it.

    Parameters
    ----------
    compare
        Another set of parameters to show beside the result: values by name, and a ``name``; or the path of such a file.
    parts
        Show only these: verdicts, figures, classical, tables, provenance; all when not given. Summary and alarm are in
        every report.

    Examples
    --------
    >>> report = client.report(job.id, compare={"name": "a book", "a": 2.0, "b": 1.0})
    >>> "Compared with a book" in report.html
    True
    """
    query = view_query(threshold, noise, posterior, compare) | {"part": list(parts)}
    return self._send(Call("GET", f"{job_path(job_id)}/report.html", lambda response: Report(response.text), query))


def report_pdf(
    self: Connection,
    job_id: str,
    *,
    threshold: float | None = None,
    noise: Noise = None,
    posterior: bool = False,
    compare: OtherSet = None,
    parts: Collection[str] = (),
) -> bytes:
    """Show the report of a job as PDF, as :func:`report` does.

    Examples
    --------
    >>> pdf = client.report_pdf(job.id, parts=["verdicts", "tables"])
    >>> pdf[:5]
    b'%PDF-'
    """
    query = view_query(threshold, noise, posterior, compare) | {"part": list(parts)}
    return self._send(Call("GET", f"{job_path(job_id)}/report.pdf", lambda response: response.content, query))


def figures(
    self: Connection, job_id: str, *, noise: Noise = None, posterior: bool = False, compare: OtherSet = None
) -> tuple[str, ...]:
    """List the figures that can be drawn for a job.

    Examples
    --------
    >>> names = client.figures(job.id)
    >>> "fit" in names
    True
    """
    query = view_query(None, noise, posterior, compare)
    return self._send(Call("GET", f"{job_path(job_id)}/figures", reader(tuple[str, ...], "items"), query))


def figure(
    self: Connection,
    job_id: str,
    name: str,
    *,
    form: Literal["svg", "png", "csv"] = "svg",
    threshold: float | None = None,
    noise: Noise = None,
    posterior: bool = False,
    compare: OtherSet = None,
) -> Figure:
    """Show a figure of a job, or (csv) the numbers behind it; a notebook displays it.

    Examples
    --------
    >>> figure = client.figure(job.id, "fit", form="csv")
    >>> figure.name, figure.form
    ('fit', 'csv')
    """
    path = f"{job_path(job_id)}/figures/{quote(name, safe='')}.{form}"
    query = view_query(threshold, noise, posterior, compare)
    return self._send(Call("GET", path, lambda response: Figure(name, form, response.content), query))
