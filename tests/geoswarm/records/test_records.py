"""Records cost nothing to import, are read by the client as the API writes them, and forget nothing."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import FrozenInstanceError, asdict, fields
from importlib import import_module
from typing import Any

import httpx
import numpy as np
import pytest
from pydantic import TypeAdapter

from geoswarm import Client
from geoswarm.client.calls import read_json
from geoswarm.records.fit import FitCurve, FitSeries
from geoswarm.records.job import Job
from geoswarm.records.statistics import ReweightAnswer, StatisticsAnswer
from geoswarm.records.uncertainty import PosteriorAnswer, SurfaceAnswer, UncertaintyAnswer
from geoswarm.solver.report.jsonable import jsonable
from geoswarm.workers.hosts.engine import Engine
from tests.api.conftest import API, App, live_server, wait_for_end
from tests.api.test_uncertainty import noisy
from tests.contracts.repository import ROOT

MODULES = (
    *("job", "evaluation", "fit", "remedy", "statistics", "uncertainty"),
    *("account", "problem", "progress", "record", "service"),
)


@pytest.fixture(scope="module")
def job(engine: Engine) -> str:
    """A job with its follow-ups."""
    app = App(engine.service)

    def submitted(path: str, body: dict[str, Any]) -> str:
        job_id: str = app.post(f"{API}/jobs{path}", json=body).json()["id"]
        assert wait_for_end(engine.service, job_id).state == "finished"
        return job_id

    calibration = submitted("", noisy())
    submitted(f"/{calibration}/sensitivity", {})
    submitted(f"/{calibration}/profile", {"noise": {"y": 0.05}})
    submitted(f"/{calibration}/global-sensitivity", {"kind": "morris", "samples": 8})
    return calibration


def test_importing_records_loads_nothing() -> None:
    modules = ", ".join(f"geoswarm.records.{name}" for name in (*MODULES, "states", "arrays"))
    heavy = "{'numpy', 'pydantic', 'pydantic_core', 'httpx', 'fastapi', 'sqlalchemy', 'click'}"
    program = f"import sys, {modules}; print(sorted({heavy} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_records_are_frozen_and_each_is_defined_once() -> None:
    homes: dict[str, str] = {}
    for module in map(import_module, (f"geoswarm.records.{name}" for name in MODULES)):
        for name in module.__all__:
            kind = getattr(module, name)
            if isinstance(kind, type):
                assert homes.setdefault(name, module.__name__) == kind.__module__
                made: Any = object.__new__(kind)
                with pytest.raises((FrozenInstanceError, AttributeError, TypeError)):
                    setattr(made, fields(kind)[0].name, 0)
    assert {"Job", "Generation", "Evaluation", "Attempt", "Fit", "StatisticsAnswer", "Worker", "Key"} <= set(homes)


def test_answers_hold_all_that_the_solver_tells(engine: Engine, job: str) -> None:
    app, statistics = App(engine.service), engine.service.statistics
    told = statistics.report(job).statistics
    assert told is not None
    assert app.get(f"{API}/jobs/{job}/statistics").json() == jsonable(told.to_json())
    uncertainty = app.get(f"{API}/jobs/{job}/uncertainty").json()
    assert [one["kind"] for one in uncertainty.pop("follow_ups")] == ["morris", "profile", "sensitivity"]
    assert uncertainty == jsonable(statistics.findings(job).to_json())
    assert app.get(f"{API}/jobs/{job}/posterior").json() == jsonable(statistics.posterior(job).to_json())
    reweighted = app.post(f"{API}/jobs/{job}/reweight", json={"weights": {"y": 2.0}}).json()
    assert reweighted == jsonable(statistics.reweighted(job, weights={"y": 2.0}))


def test_the_client_reads_statistics_as_records_with_all_that_is_answered(engine: Engine, job: str) -> None:
    app, path = App(engine.service), f"{API}/jobs/{job}"
    with live_server(engine.service) as server, Client(server.url) as client:
        found: list[tuple[Any, Any, Any]] = [
            (StatisticsAnswer, client.statistics(job), app.get(f"{path}/statistics").json()),
            (UncertaintyAnswer, client.uncertainty(job), app.get(f"{path}/uncertainty").json()),
            (PosteriorAnswer, client.posterior(job), app.get(f"{path}/posterior").json()),
            (SurfaceAnswer, client.surface(job, x="b"), app.get(f"{path}/surface", params={"x": "b"}).json()),
            (
                ReweightAnswer,
                client.reweight(job, weights={"y": 2.0}),
                app.post(f"{path}/reweight", json={"weights": {"y": 2.0}}).json(),
            ),
            (Job, client.get(job), app.get(path).json()),
        ]
    for kind, read, answered in found:
        assert type(read) is kind
        assert TypeAdapter(kind).dump_python(read, mode="json") == answered
        assert list(asdict(read)) == list(answered)


def test_fields_of_a_newer_service_are_ignored(engine: Engine, job: str) -> None:
    answer = App(engine.service).get(f"{API}/jobs/{job}/statistics")
    document = answer.json() | {"of_tomorrow": 1}
    document["samples"]["of_tomorrow"] = [2]
    later = httpx.Response(200, json=document)
    assert read_json(StatisticsAnswer, later.content, answer) == read_json(StatisticsAnswer, answer.content, answer)


def test_arrays_are_lists_in_json_and_what_is_not_finite_is_null() -> None:
    curve = FitCurve(
        role="best",
        generation=0,
        particle=1,
        objective=None,
        parameters={},
        shares=[],
        values={"y": np.array([1.0, np.nan, np.inf])},
        residuals={"y": np.zeros(3)},
    )
    adapter = TypeAdapter(FitCurve)
    text = adapter.dump_json(curve)
    assert b'"values":{"y":[1.0,null,null]}' in text
    assert adapter.dump_python(curve, mode="json")["values"] == {"y": [1.0, None, None]}
    again = adapter.validate_json(text)
    np.testing.assert_array_equal(again.values["y"], [1.0, np.nan, np.nan])
    assert not again.values["y"].flags.writeable
    schema = TypeAdapter(FitSeries).json_schema(mode="serialization")["properties"]["measured"]
    assert (schema["type"], schema["items"]) == ("array", {"type": "number"})
