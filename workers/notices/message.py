"""The notification of a job that has ended: as JSON for programs, in plain words for people."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Any

from geoswarm.records.job import Job
from geoswarm.solver.words import duration, number, reasons_in_words, visible
from geoswarm.workers.notices.verdicts import NOTHING, Found

__all__ = ["body_of", "mail_of", "trial_body"]

ENDINGS = {"finished": "has finished", "failed": "has failed", "cancelled": "was cancelled"}
LONGEST_NAME = 100


def body_of(
    job: Job, state: str, at: datetime, found: Found = NOTHING, public_url: str | None = None
) -> dict[str, Any]:
    """Return the notification of a job.

    Parameters
    ----------
    state
        In which it ended then; it may have gone on since.
    at
        When it ended.
    public_url
        Address of the dashboard.
    """
    return {
        "type": f"job.{state}",
        "timestamp": _iso(at),
        "data": {
            "id": job.id,
            "name": job.name,
            "state": state,
            "objective": job.objective,
            "objective_unit": found.unit,
            "parameters": job.parameters,
            "free_parameters": job.free_parameters,
            "verdicts": found.verdicts,
            "fit": found.fit,
            "evaluations": job.evaluations,
            "generations": job.generations,
            "failed_evaluations": job.failed_evaluations,
            "seconds": job.seconds,
            "stop_reasons": job.stop_reasons,
            "error": job.error,
            "url": None if public_url is None else f"{public_url}/jobs/{job.id}",
        },
    }


def trial_body(at: datetime) -> dict[str, Any]:
    """Return the notification of a test."""
    return {"type": "hook.test", "timestamp": _iso(at), "data": {"message": "This hook of geoswarm works."}}


def mail_of(body: dict[str, Any]) -> tuple[str, str]:
    """Return subject and text of the message that a body makes."""
    data = body["data"]
    if body["type"] == "hook.test":
        return "geoswarm: a test", f"{data['message']}\n"
    name, ending = _short(data["name"]), ENDINGS[data["state"]]
    count = f"{data['evaluations']} evaluations in {data['generations']} generations"
    if data["failed_evaluations"]:
        count += f", {data['failed_evaluations']} failed"
    after = "" if data["seconds"] is None else f" after {duration(data['seconds'], plain=True)}"
    lines = [f'The job "{name}" {ending}{after}: {count}.']
    if data["error"]:
        lines += ["", f"Why: {visible(data['error'])}"]
    if data["stop_reasons"]:
        lines.append(f"Ended because: {reasons_in_words(data['stop_reasons'], plain=True)}.")
    if data["objective"] is not None:
        unit = f" {data['objective_unit']}" if data["objective_unit"] else ""
        lines += ["", f"Best objective: {number(data['objective'], plain=True)}{unit}"]
    if data["fit"]:
        lines.append(data["fit"])
    if data["parameters"]:
        lines += ["", *(_parameter(data, name) for name in data["free_parameters"])]
    if data["url"]:
        lines += ["", data["url"]]
    return f"geoswarm: {name} {ending}", "\n".join(lines) + "\n"


def _parameter(data: dict[str, Any], name: str) -> str:
    verdict = data["verdicts"].get(name)
    return f"  {name} = {number(data['parameters'][name], 5, plain=True)}" + (f"  ({verdict})" if verdict else "")


def _short(name: str) -> str:
    shown = " ".join(visible(name).split())
    return shown if len(shown) <= LONGEST_NAME else f"{shown[: LONGEST_NAME - 3]}..."


def _iso(at: datetime) -> str:
    return at.astimezone(UTC).isoformat().replace("+00:00", "Z")
