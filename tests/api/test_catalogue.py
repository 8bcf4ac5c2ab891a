"""Forward models, workers, the check of a problem, and the OpenAPI document."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import jsonschema_rs
import pytest
from jsonschema_rs import meta
from pydantic import TypeAdapter

from geoswarm.api import create_app
from geoswarm.solver.forward.registry import find_spec, kinds, offered_kinds, parse_spec
from geoswarm.workers.service.job_service import JobService
from tests.api.conftest import API, App, line_problem
from tests.solver.external.zoo import ZOO, register


def test_forward_models_are_listed_with_a_description(app: App) -> None:
    items = app.get(f"{API}/forward-models").json()["items"]
    assert [item["kind"] for item in items] == [kind for kind in offered_kinds() if kind != "registered"]
    assert not {"command", "python", "umbridge"} & set(offered_kinds())
    assert all(item["description"] for item in items)


def test_oedometer_tells_schema_parameters_and_series_with_units(app: App) -> None:
    model = app.get(f"{API}/forward-models/oedometer").json()
    assert model["depends_on_section"] is False
    assert {"height", "stages", "initial_stress"} <= set(model["json_schema"]["properties"])
    series = {item["name"]: item for item in model["series"]}
    assert (series["settlement"]["x_unit"], series["settlement"]["y_unit"]) == ("day", "m")
    assert {"axial_strain", "stage_settlement", "stage_axial_strain", "stage_void_ratio"} <= set(series)
    parameters = {item["name"]: item for item in model["parameters"]}
    assert parameters["phi"]["unit"] == "degree"
    assert {"lambda_star", "kappa_star", "mu_star", "c", "phi", "psi"} <= set(parameters)


@pytest.mark.parametrize("kind", ["formula", "combined"])
def test_models_that_follow_from_their_section_say_so(app: App, kind: str) -> None:
    model = app.get(f"{API}/forward-models/{kind}").json()
    assert model["depends_on_section"] is True
    assert "example" in model["note"]
    assert model["series"]
    assert model["parameters"]


def test_a_kind_that_runs_code_of_the_machine_is_not_shown(app: App) -> None:
    answer = app.get(f"{API}/forward-models/python")
    assert answer.status_code == 404
    assert "accepted from problem files and Python only" in answer.json()["detail"]
    assert "forward_model_python" not in str(app.get(f"{API}/problems/schema").json())


def test_registered_models_are_listed_with_a_schema_of_their_settings(
    app: App, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    register(tmp_path)
    (tmp_path / "good" / "model.yaml").write_text(
        (tmp_path / "good" / "model.yaml").read_text()
        + "title: A line\nsettings: {steps: {type: integer, default: 5, lower: 1, upper: 9, unit: s}}\n"
    )
    (tmp_path / "exit_1" / "model.yaml").write_text("{")
    monkeypatch.setenv("GEOSWARM_MODELS", str(tmp_path))
    items = {item["model"]: item for item in app.get(f"{API}/forward-models").json()["items"] if item["model"]}
    assert set(items) == set(ZOO) - {"exit_1"}
    assert items["good"] == {"kind": "registered", "model": "good", "description": "A line"}
    section = app.get(f"{API}/problems/schema").json()["$defs"]["forward_model_registered_good"]
    assert section["properties"]["settings"]["properties"] == {
        "steps": {"type": "integer", "default": 5, "minimum": 1, "maximum": 9, "x-unit": "s"}
    }


@pytest.mark.parametrize("kind", [kind for kind in offered_kinds() if kind != "registered"])
def test_examples_are_sections_of_their_kind(kind: str) -> None:
    spec = parse_spec(find_spec(kind).example())
    assert spec.kind == kind
    assert spec.build().series


def test_an_unknown_kind_lists_the_known_ones(app: App) -> None:
    answer = app.get(f"{API}/forward-models/odometer")
    assert answer.status_code == 404
    assert all(kind in answer.json()["detail"] for kind in kinds())


def test_check_runs_once_and_estimates(app: App) -> None:
    result = app.post(f"{API}/problems/check", json=line_problem()).json()
    assert result["valid"] is True
    assert (result["name"], result["forward_model"], result["method"]) == ("line", "formula", "particle_swarm")
    assert (result["free_parameters"], result["data_points"], result["planned_evaluations"]) == (["a", "b"], 3, 60)
    run = result["test_run"]
    assert run["state"] == "finished"
    assert run["parameters"] == {"a": 0.0, "b": 2.0}  # the middle of the bounds
    assert run["objective"] == pytest.approx(1.0, rel=1e-12)  # every residual is 1
    assert run["responses"] == {"y": {"x": [0.0, 1.0, 2.0], "y": [0.0, 2.0, 4.0]}}
    assert (
        result["estimated_seconds"] > 60 * run["seconds"] > 0.0
    )  # the search that learns from its runs takes time, too
    assert app.get(f"{API}/jobs").json()["items"] == []


def test_the_textbook_swarm_costs_its_evaluations_alone(app: App) -> None:
    textbook = line_problem(method={"kind": "particle_swarm", "particles": 6, "acceleration": "none"})
    result = app.post(f"{API}/problems/check", json=textbook).json()
    assert result["estimated_seconds"] == pytest.approx(60 * result["test_run"]["seconds"], rel=1e-9)


def test_a_test_run_that_fails_is_reported_not_refused(app: App) -> None:
    broken = line_problem(forward_model={"kind": "formula", "series": {"y": {"expression": "a + b * x / 0"}}})
    answer = app.post(f"{API}/problems/check", json=broken)
    assert answer.status_code == 200
    run = answer.json()["test_run"]
    assert (run["state"], run["reason"], run["objective"], run["misfits"]) == ("failed", "not_finite", None, {})
    assert run["message"]


def test_check_refuses_a_bad_problem_with_its_issues(app: App) -> None:
    answer = app.post(f"{API}/problems/check", json=line_problem(observations=[{"series": "z"}]))
    assert answer.status_code == 422
    assert any(issue["path"].startswith("observations[0]") for issue in answer.json()["issues"])


def test_no_worker_no_entry(app: App) -> None:
    assert app.get(f"{API}/workers").json() == {"items": []}


@pytest.fixture(scope="module")
def document() -> dict[str, Any]:
    class NoService(JobService):
        def __init__(self) -> None:
            """The document needs no database."""

    return dict(App(NoService()).get("/openapi.json").json())


def test_every_schema_of_openapi_is_valid(document: dict[str, Any]) -> None:
    assert not _invalid_schemas(document)
    assert _invalid_schemas({"schema": {"type": "array", "items": [{"type": "number"}]}})  # the form of older drafts


def _invalid_schemas(document: dict[str, Any]) -> list[str]:
    """Schemas of components, parameters and bodies that JSON Schema 2020-12, and so OpenAPI 3.1, does not know."""
    found: list[str] = []

    def judge(schema: Any, path: str) -> None:
        validator = jsonschema_rs.Draft202012Validator({"$ref": "https://json-schema.org/draft/2020-12/schema"})
        found.extend(f"{path}: {error.message}" for error in validator.iter_errors(schema))

    def walk(value: Any, path: str) -> None:
        if isinstance(value, dict):
            for key, inner in value.items():
                if key == "schema":
                    judge(inner, path)
                else:
                    walk(inner, f"{path}/{key}")
        elif isinstance(value, list):
            for inner in value:
                walk(inner, path)

    for name, schema in document.get("components", {}).get("schemas", {}).items():
        judge(schema, f"components/schemas/{name}")
    walk({key: value for key, value in document.items() if key != "components"}, "")
    return found


def test_openapi_is_3_1_and_every_reference_resolves(document: dict[str, Any]) -> None:
    assert document["openapi"].startswith("3.1")

    def references(value: Any) -> list[str]:
        if isinstance(value, dict):
            own = [value["$ref"]] if isinstance(value.get("$ref"), str) else []
            return own + [found for inner in value.values() for found in references(inner)]
        return [found for inner in value for found in references(inner)] if isinstance(value, list) else []

    found = references(document)
    assert "#/components/schemas/Problem" in found
    for reference in found:
        place: Any = document
        for part in reference.removeprefix("#/").split("/"):
            place = place[part]
        assert isinstance(place, dict), reference


def test_openapi_schemas_are_json_schemas_of_3_1(document: dict[str, Any]) -> None:
    def schemas(value: Any) -> list[Any]:
        if isinstance(value, dict):
            own = [value["schema"]] if isinstance(value.get("schema"), dict) else []
            return own + [found for inner in value.values() for found in schemas(inner)]
        return [found for inner in value for found in schemas(inner)] if isinstance(value, list) else []

    found = [*document["components"]["schemas"].values(), *schemas(document["paths"])]
    assert len(found) > 100
    for schema in found:
        # refuses a list as items, for one
        meta.validate({"$schema": "https://json-schema.org/draft/2020-12/schema", **schema})


def test_openapi_describes_every_answer(document: dict[str, Any]) -> None:
    operations = [
        (path, method, operation)
        for path, methods in document["paths"].items()
        for method, operation in methods.items()
    ]
    assert len({operation["operationId"] for _, _, operation in operations}) == len(operations) >= 24
    for path, method, operation in operations:
        for status, answer in operation["responses"].items():
            if status not in ("204", "304"):
                assert answer["content"], (path, method, status)
        if path.startswith(API):
            assert operation["responses"]["401"]["content"].keys() == {"application/problem+json"}
            assert bool(operation["security"]) is not (path == f"{API}/session" and method == "post")  # signing in


def test_openapi_problem_is_the_schema_of_the_problem_file(document: dict[str, Any]) -> None:
    schema = document["components"]["schemas"]["Problem"]
    assert {"name", "forward_model", "parameters", "observations", "method"} <= set(schema["properties"])
    body = document["paths"][f"{API}/jobs"]["post"]["requestBody"]["content"]
    assert set(body) == {"application/json", "application/yaml"}


def test_no_page_loads_scripts_from_elsewhere(app: App) -> None:
    assert app.get("/docs").status_code == 404
    assert app.get("/redoc").status_code == 404


def test_the_application_states_its_version(service: JobService) -> None:
    assert TypeAdapter(str).validate_python(create_app(service).version)
