"""Every field of an evaluation is in JSON, CSV, Parquet, the schema and the client, and in all of them alike."""

from __future__ import annotations

import csv
import io
from dataclasses import fields
from datetime import datetime
from typing import get_type_hints

import pyarrow.parquet as pq
import pytest
from sqlalchemy import String, Text

from geoswarm import AsyncClient, Client
from geoswarm.api.parquet import parquet_pieces
from geoswarm.api.routes.results import csv_header, csv_lines, parquet_columns
from geoswarm.client import Evaluation as ClientEvaluation
from geoswarm.records.evaluation import COLUMNS, Evaluation
from geoswarm.workers.hosts.engine import Engine
from geoswarm.workers.store.tables import evaluations as table
from tests.api.conftest import API, App, line_problem, live_server, wait_for_end
from tests.geoswarm.records.made import evaluation

FIELDS = [field.name for field in fields(Evaluation)]
MAPPINGS = {"parameters", "misfits", "responses"}


@pytest.fixture(scope="module")
def job(engine: Engine) -> str:
    """A job with failed evaluations: the root of a negative number."""
    model = {"kind": "formula", "series": {"y": {"expression": "sqrt(a) + b * x"}}}
    job_id: str = App(engine.service).post(f"{API}/jobs", json=line_problem(forward_model=model)).json()["id"]
    assert wait_for_end(engine.service, job_id).failed_evaluations > 0
    return job_id


def as_csv(value: object) -> str:
    return "" if value is None else value.isoformat() if isinstance(value, datetime) else str(value)


def test_every_field_is_answered_as_json_csv_and_parquet_and_read_by_the_client(engine: Engine, job: str) -> None:
    app, path = App(engine.service), f"{API}/jobs/{job}/evaluations"
    items = app.get(path, params={"limit": 1000}).json()["items"]
    assert [list(item) for item in items] == [FIELDS] * len(items)
    rows = list(csv.DictReader(io.StringIO(app.get(path, params={"format": "csv"}).text)))
    parquet = pq.read_table(io.BytesIO(app.get(path, params={"format": "parquet"}).content)).to_pylist()
    with live_server(engine.service) as server, Client(server.url) as client:
        read = list(client.iterate_evaluations(job))
    assert read == list(engine.service.iterate_evaluations(job))
    for item, row, typed, record in zip(items, rows, parquet, read, strict=True):
        for name in set(FIELDS) - MAPPINGS:
            value = getattr(record, name)
            assert typed[name] == value
            assert row[name] == (
                "" if value is None else value.isoformat() if isinstance(value, datetime) else str(value)
            )
            assert item[name] == (value.isoformat().replace("+00:00", "Z") if isinstance(value, datetime) else value)
        for parameter, value in record.parameters.items():
            assert float(row[parameter]) == typed[parameter] == item["parameters"][parameter] == value
    assert {record.state for record in read} == {"finished", "failed"}


def test_every_field_that_is_no_mapping_is_a_column_of_its_kind() -> None:
    assert [column.name for column in COLUMNS] == [name for name in FIELDS if name not in MAPPINGS]
    header = csv_header(["a"], ["y"])
    assert set(header) == (set(FIELDS) - MAPPINGS) | {"a", "misfit.y"}
    assert [name for name, *_ in parquet_columns(["a"], ["y"])] == header
    texts = {column.name for column in COLUMNS if column.kind is str}
    assert texts == {c.name for c in table.columns if isinstance(c.type, String | Text)} - {"job_id", "misfits"}


def test_a_log_is_in_csv_and_parquet_too() -> None:
    failed = evaluation(reason="error", message="broke", log="first\nlast")
    line = dict(zip(csv_header(["a"], ["y"]), next(csv.reader(csv_lines([failed], ["a"], ["y"]))), strict=True))
    assert (line["message"], line["log"]) == ("broke", "first\\nlast")
    pieces = parquet_pieces([failed], parquet_columns(["a"], ["y"]), ["y"], responses=False)
    assert pq.read_table(io.BytesIO(b"".join(pieces)))["log"].to_pylist() == ["first\nlast"]


def test_the_schema_and_the_client_have_the_same_record(engine: Engine) -> None:
    schema = App(engine.service).app.openapi()["components"]["schemas"]["Evaluation"]
    assert list(schema["properties"]) == schema["required"] == FIELDS
    assert ClientEvaluation is Evaluation
    for client in (Client, AsyncClient):
        assert get_type_hints(client.evaluation)["return"] is Evaluation
