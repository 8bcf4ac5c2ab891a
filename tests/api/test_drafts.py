"""Problems in the making, files of measurements and examples, over HTTP and through both clients."""

from __future__ import annotations

import asyncio
import base64
import json
from collections.abc import MutableMapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geoswarm.client import AsyncClient, Client, HttpError
from tests.api.conftest import API, App, LiveServer, line_problem
from tests.solver.problem.test_blocks import IN_TURN, SIDE, X, Y
from tests.solver.problem.test_load_stages import ANEW
from tests.solver.problem.test_measurements import ROWS, STRINGS, workbook
from tests.solver.problem.test_selection import staged

YAML = {"Content-Type": "application/yaml"}


def test_a_document_is_judged_and_written_as_yaml(app: App) -> None:
    draft = app.post(f"{API}/problems/read", json=line_problem()).json()
    assert (draft["valid"], draft["issues"], draft["document"]) == (True, [], line_problem())
    assert draft["yaml"].startswith("name: line\nforward_model:\n  kind: formula\n")
    assert draft["free_parameters"] == ["a", "b"]
    assert draft["planned_evaluations"] == 60
    again = app.post(f"{API}/problems/read", content=draft["yaml"], headers=YAML).json()
    assert again == draft


def test_mistakes_are_an_answer_with_lines(app: App) -> None:
    answer = app.post(f"{API}/problems/read", content="name: a\nparameters:\n  c: {lower: 2, upper: 1}\n", headers=YAML)
    assert answer.status_code == 200
    draft = answer.json()
    assert (draft["valid"], draft["parameters"], draft["observations"]) == (False, None, [])
    lines = {issue["path"]: issue["line"] for issue in draft["issues"]}
    assert lines["parameters.c.lower"] == 3
    assert lines["forward_model"] is None
    broken = app.post(f"{API}/problems/read", content="name: [", headers=YAML).json()
    assert (broken["valid"], broken["document"], broken["yaml"]) == (False, None, "name: [")
    assert broken["issues"][0]["line"] is not None


def test_shares_and_factors_of_observations(app: App) -> None:
    series = {name: {"expression": "a * x", "x_unit": "day", "y_unit": "m"} for name in ("u", "v")}
    observed = [
        {"series": "u", "x_unit": "h", "y_unit": "mm", "weight": 3, "points": {"x": [1, 2], "y": [1, 2]}},
        {"series": "v", "points": {"x": [1], "y": [1]}},
    ]
    problem = line_problem(
        forward_model={"kind": "formula", "series": series},
        parameters={"a": {"lower": 0, "upper": 1}},
        observations=observed,
    )
    u, v = app.post(f"{API}/problems/read", json=problem).json()["observations"]
    assert (u["share"], v["share"]) == pytest.approx((3.0 / (1e6 + 3.0), 1e6 / (1e6 + 3.0)), rel=1e-9)  # 1 mm and 1 m
    assert u["points"] == 2
    assert (u["x_unit"], u["y_unit"], v["x_unit"], v["y_unit"]) == ("h", "mm", "day", "m")
    assert u["x_factor"] == pytest.approx(1 / 24, rel=1e-15)
    assert (u["y_factor"], v["x_factor"], v["y_factor"]) == (0.001, 1.0, 1.0)


def test_what_is_no_problem_at_all_is_refused(app: App) -> None:
    assert app.post(f"{API}/problems/read", json=[1]).status_code == 400
    assert (
        app.post(f"{API}/problems/read", content="{", headers={"Content-Type": "application/json"}).status_code == 400
    )
    assert app.post(f"{API}/problems/read", content="a: 1", headers={"Content-Type": "text/plain"}).status_code == 415
    assert app.post(f"{API}/problems/read", content="a" * 200_001, headers=YAML).status_code == 413


def test_the_schema_has_every_section(app: App) -> None:
    schema = app.get(f"{API}/problems/schema").json()
    assert {"forward_model", "parameters", "observations", "method", "stopping"} <= schema["properties"].keys()
    oedometer = schema["$defs"]["forward_model_oedometer"]["properties"]
    assert (oedometer["height"]["x-unit"], oedometer["initial_stress"]["x-unit"]) == ("m", "kPa")
    assert len(oedometer["height"]["x-typical"]) == 2


def test_files_of_both_kinds_are_read(app: App) -> None:
    found = app.post(f"{API}/measurements?name=a.csv", content=b"time [h],u [mm]\n1,2\n3,\n").json()
    assert (found["name"], found["rows"], found["sheets"], found["sheet"]) == ("a.csv", 2, [], None)
    assert [(c["label"], c["unit"], c["base"], c["values"]) for c in found["columns"]] == [
        ("time", "h", "day", [1.0, 3.0]),
        ("u", "mm", "m", [2.0, None]),
    ]
    sheet = app.post(f"{API}/measurements", content=workbook(("Readings", ROWS), strings=STRINGS)).json()
    assert (sheet["sheet"], sheet["columns"][1]["bad"]) == ("Readings", 1)


def test_blocks_and_loads_of_a_file_become_stages(app: App) -> None:
    query = {"name": "a.csv", "observation": '{"x_column": "Zeit"}', "load_column": "Spannung"}
    assert app.post(f"{API}/measurements/stages", params=query, content=ANEW.encode()).json() == {
        "stages": [{"stress": 12.5, "duration": 1.0, "load": 0.0125}, {"stress": 25.0, "duration": 2.0, "load": 0.025}],
        "initial_stress": None,
        "elapsed": True,
    }
    query["load_column"] = "Last"
    refused = app.post(f"{API}/measurements/stages", params=query, content=ANEW.encode())
    assert (refused.status_code, "there is no column 'Last'" in refused.text) == (422, True)
    observation = {"series": "settlement", "blocks": IN_TURN}
    query = {"observation": json.dumps(observation), "forward_model": json.dumps(staged().document()["forward_model"])}
    points = app.post(f"{API}/measurements/points", params=query, content=SIDE).json()
    assert (np.round(points["x"], 9).tolist(), points["y"]) == (X, Y)


OEDOMETER = b"sigma_v [kPa],e [-]\n10,1.0\n100,0.97\n400,0.94\n"
TESTS = b"test;file;type\nOE;data/oe.csv;oedometer\n"


def test_a_table_of_tests_with_its_files_becomes_parts(app: App) -> None:
    """It was refused over HTTP: files can only be read beside a problem file."""
    tests = {"table": "tests.csv", "material": "hypoplastic_sand"}
    sent = {"tests.csv": base64.b64encode(TESTS).decode(), "oe.csv": base64.b64encode(OEDOMETER).decode()}
    body = {"problem": {"name": "sand", "tests": tests}, "files": sent}
    made = app.post(f"{API}/problems/tests", json=body).json()["problem"]
    assert list(made["forward_model"]["parts"]) == ["OE"]
    (readings,) = made["observations"]
    assert (readings["series"], readings["points"]) == ("OE.stage_void_ratio", {"x": [1, 2], "y": [0.97, 0.94]})
    sent["oe.csv"] = base64.b64encode(OEDOMETER.replace(b"0.97", b"n/a")).decode()
    refused = app.post(f"{API}/problems/tests", json=body)
    assert refused.status_code == 422
    told = "tests.csv line 2, column 'file': data/oe.csv line 3, column e [-]: 'n/a' is not a finite number"
    assert told in refused.json()["issues"][0]["message"]
    del sent["oe.csv"]
    refused = app.post(f"{API}/problems/tests", json=body)
    assert refused.json()["detail"].endswith("column 'file': no such file: data/oe.csv; sent: tests.csv")
    for wrong in ({"problem": body["problem"]}, body | {"files": {"a.csv": "é"}}):
        assert app.post(f"{API}/problems/tests", json=wrong).status_code == 422


def test_a_file_that_cannot_be_read_is_explained(app: App) -> None:
    answer = app.post(f"{API}/measurements?name=photo.png", content=b"\x89PNG\r\n\0\0")
    assert answer.status_code == 422
    assert answer.json()["type"].endswith("unreadable-file")
    assert "photo.png is neither text (CSV) nor a workbook (XLSX, ODS)" in answer.json()["detail"]
    assert app.post(f"{API}/measurements", content=b"x" * (32 * 2**20 + 1)).status_code == 413
    query = {"observation": '{"series": "q"}'}
    (issue,) = app.post(f"{API}/measurements/points", params=query, content=b"x,y\n1,n/a\n").json()["issues"]
    key = {"path": "incomplete_rows", "text": "incomplete_rows: leave_out", "value": "leave_out"}
    assert issue["parts"][2:] == [key, " passes over such rows"]
    assert issue["message"].endswith("; incomplete_rows: leave_out passes over such rows")


def test_every_example_is_sound_and_carries_its_data(app: App) -> None:
    items = app.get(f"{API}/examples").json()["items"]
    assert {"oedometer", "isotropic_compression", "formula", "combined", "slope"} <= {item["name"] for item in items}
    for item in items:
        example = app.get(f"{API}/examples/{item['name']}").json()
        assert example["description"]
        assert "README" not in example["description"]
        draft = app.post(f"{API}/problems/read", json=example["problem"]).json()
        assert (draft["valid"], draft["issues"]) == (True, [])
        assert draft["document"]["name"] == example["title"]


def test_an_unknown_example_names_the_known_ones(app: App) -> None:
    answer = app.get(f"{API}/examples/nothing")
    assert answer.status_code == 404
    assert "oedometer" in answer.json()["detail"]


def test_both_clients_can_ask_for_all_of_it(server: LiveServer, tmp_path: Path) -> None:
    file = tmp_path / "readings.csv"
    file.write_text("time [min],u [mm]\n1,2\n")
    with Client(server.url) as client:
        assert client.read_problem("name: a")["valid"] is False
        assert client.read_measurements(file)["name"] == "readings.csv"
        assert client.example(client.examples()[0]["name"])["problem"]
        assert "properties" in client.problem_schema()
        (tmp_path / "a.xlsx").write_bytes(workbook(("Readings", ROWS), strings=STRINGS))
        with pytest.raises(HttpError, match="no sheet"):
            client.read_measurements(tmp_path / "a.xlsx", "Other")

    async def asked() -> bool:
        async with AsyncClient(server.url) as client:
            found = [await client.read_problem("name: a"), await client.read_measurements(file)]
            names = [item["name"] for item in await client.examples()]
            found += [await client.example(names[0]), await client.problem_schema()]
            return all(found)

    assert asyncio.run(asked())


def test_a_request_that_is_given_up_is_no_failure_of_the_service(app: App, caplog: pytest.LogCaptureFixture) -> None:
    statuses = []

    async def receive() -> dict[str, str]:
        return {"type": "http.disconnect"}

    async def send(message: MutableMapping[str, Any]) -> None:
        statuses.append(message.get("status"))

    headers = [(b"host", b"localhost"), (b"content-type", b"application/yaml")]
    scope = {"type": "http", "method": "POST", "path": f"{API}/problems/read", "headers": headers, "query_string": b""}
    asyncio.run(app.app(scope, receive, send))
    assert statuses[0] == 400
    assert [record for record in caplog.records if record.levelname == "ERROR"] == []


def test_a_draft_tells_what_index_properties_let_expect_before_it_is_sound(app: App) -> None:
    """I_P = 40 %: lambda* = I_P/500 by the manual of PLAXIS; what has mistakes is evaluated by its readings later."""
    model = app.get(f"{API}/forward-models/oedometer").json()["example"] | {"initial_void_ratio": 1.5}
    draft = {"forward_model": model, "index_properties": {"plasticity_index": 40}}
    found = app.post(f"{API}/problems/read", json=draft).json()
    assert found["valid"] is False
    values = {one["source"]: one for one in found["estimates"] if one["parameter"] == "lambda_star"}
    manual = values["Cc: 2.303 (1 + e_0) I_P/500, PLAXIS Material Models Manual"]
    assert manual["value"] == pytest.approx(0.08)
    assert manual["measured"] is False
    wrong = draft | {"index_properties": {"plasticity_index": 0.4}}
    answer = app.post(f"{API}/problems/read", json=wrong).json()
    assert answer["estimates"] == []
    assert any("in per cent this would be 40" in issue["message"] for issue in answer["issues"])


def test_parameters_of_a_forward_model_have_the_source_of_their_range(app: App) -> None:
    parameters = app.get(f"{API}/forward-models/oedometer").json()["parameters"]
    assert {one["name"]: one["source"] for one in parameters}["lambda_star"].startswith("PLAXIS Material Models Manual")


def test_readings_that_no_soil_can_have_are_refused_until_they_are_accepted(app: App) -> None:
    """Settlements in hundredths of a millimetre became metres, and the form called it complete."""
    problem = app.get(f"{API}/examples/oedometer").json()["problem"]
    problem["observations"][0]["y_unit"] = "m"
    judged = app.post(f"{API}/problems/read", json=problem).json()
    assert (judged["valid"], judged["to_be_accepted"]) == (False, ["settlement"])
    (issue,) = judged["issues"]
    assert issue["path"] == "observations[0].y_unit"
    assert issue["line"] is not None
    assert "is more than the height of the specimen, 0.02021 m; in mm it would be 0.18 of it" in issue["message"]
    for path in ("jobs", "problems/check"):
        refused = app.post(f"{API}/{path}", json=problem)
        assert refused.status_code == 422
        assert "accept: [settlement] runs the problem as it is" in refused.json()["issues"][0]["message"]
    problem["accept"] = ["settlement"]
    judged = app.post(f"{API}/problems/read", json=problem).json()
    assert (judged["valid"], judged["to_be_accepted"], judged["issues"]) == (True, [], [])
    job = app.post(f"{API}/jobs", json=problem)
    assert job.status_code == 201
    assert app.get(f"{API}/jobs/{job.json()['id']}/problem").json()["accept"] == ["settlement"]
    app.post(f"{API}/jobs/{job.json()['id']}/cancel")
