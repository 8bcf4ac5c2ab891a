"""What a user of the service sends about a registered model is data: hostile values are refused, and reach nothing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.api.conftest import API, App
from tests.solver.external.zoo import register, zoo_problem

SETTINGS = """\
settings:
  behaviour: {type: choice, choices: {calm: good}, default: calm}
  steps: {type: integer, default: 5, lower: 1, upper: 9}
  fine: {type: switch}
"""
HOSTILE: list[dict[str, Any]] = [
    {"model": "../good"},
    {"model": "/etc"},
    {"model": "good\x00"},
    {"model": "go" * 100},
    {"model": ["good"]},
    {"model": "godo"},
    {"settings": {"behaviour": "; touch hacked"}},
    {"settings": {"behaviour": "$(touch hacked)"}},
    {"settings": {"behaviour": "good"}},
    {"settings": {"behaviour": ["calm"]}},
    {"settings": {"steps": "5"}},
    {"settings": {"steps": 1e300}},
    {"settings": {"steps": 2.5}},
    {"settings": {"steps": True}},
    {"settings": {"fine": 1}},
    {"settings": {"../x": 1}},
    {"settings": {"__class__": 1}},
    {"settings": {f"s{n}": 1 for n in range(200)}},
    {"settings": {"steps": {"$ref": "x"}}},
    {"settings": "steps"},
    {"run": ["touch", "hacked"]},
    {"files": ["/etc/passwd"]},
    {"folder": "/"},
    {"kind": "command", "run": ["touch", "hacked"], "series": {"y": {"file": "a", "x": 1, "y": 2}}},
    {"kind": "python", "file": "/srv/x.py", "function": "f", "series": {"y": {}}},
    {"version": "0" * 64},
    {"version": "0" * 64, "declared": {"parameters": {"slope": {}}, "series": {"y": {}}}},
    {"declared": {"parameters": {"slope": {"unit": "x" * 1000}}, "series": {"y": {}}}},
]


@pytest.fixture
def document(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    folder = tmp_path / "models"
    register(folder)
    model = folder / "good" / "model.yaml"
    model.write_text(model.read_text().replace("good]", '"{behaviour}"]') + SETTINGS)
    monkeypatch.setenv("GEOSWARM_MODELS", str(folder))
    monkeypatch.chdir(tmp_path)
    found: dict[str, Any] = zoo_problem("good").document()
    return found


@pytest.mark.parametrize(
    ("route", "changes"),
    [*(("jobs", changes) for changes in HOSTILE), *(("problems/check", changes) for changes in HOSTILE[::7])],
    ids=str,
)
def test_hostile_sections_are_refused(
    route: str, changes: dict[str, Any], document: dict[str, Any], app: App, tmp_path: Path
) -> None:
    section = {"kind": "registered", "model": "good"} | changes
    answer = app.post(f"{API}/{route}", json=document | {"forward_model": section})
    assert answer.status_code == 422, answer.text
    assert answer.json()["issues"], answer.text
    assert not list(tmp_path.rglob("hacked"))


@pytest.mark.parametrize(
    "change",
    [
        lambda document: document["parameters"].update({"slope": {"expression": "__import__('os').system('touch x')"}}),
        lambda document: document["parameters"].update({"{{slope}}": {"value": 1}}),
        lambda document: document["parameters"].update({"slope": {"value": 1e308}}),
        lambda document: document["parameters"].update({"slope": {"lower": -100, "upper": 1}}),
        lambda document: document.update({"constraints": ["open('/etc/passwd')"]}),
        lambda document: document["observations"][0].update({"series": "../../y"}),
        lambda document: document["observations"][0].update({"file": "/etc/passwd"}),
    ],
)
def test_hostile_parameters_are_refused(
    change: Callable[[dict[str, Any]], object], document: dict[str, Any], app: App, tmp_path: Path
) -> None:
    change(document)
    answer = app.post(f"{API}/jobs", json=document)
    assert answer.status_code == 422, answer.text
    assert not list(tmp_path.rglob("hacked"))


def test_a_canonical_problem_is_accepted_again(document: dict[str, Any], app: App) -> None:
    first = app.post(f"{API}/jobs", json=document)
    assert first.status_code == 201, first.text
    stored = app.get(f"{API}/jobs/{first.json()['id']}/problem").json()
    assert len(stored["forward_model"]["version"]) == 64
    assert app.post(f"{API}/jobs", json=stored).status_code == 201


def test_what_fails_is_told_without_folders_and_given_values(
    document: dict[str, Any], app: App, tmp_path: Path
) -> None:
    model = tmp_path / "models" / "good"
    (model / "zoo.py").write_text("import os, sys; print(os.getcwd(), os.environ['ZOO_TRIES']); sys.exit(3)")
    answer = app.post(
        f"{API}/problems/check", json=document | {"forward_model": {"kind": "registered", "model": "good"}}
    )
    assert answer.status_code == 200, answer.text
    message = answer.json()["test_run"]["message"]
    assert "ended with exit status 3" in message
    assert "***" in message
    assert str(tmp_path) not in answer.text

    (model / "input.in").unlink()
    answer = app.post(
        f"{API}/problems/check", json=document | {"forward_model": {"kind": "registered", "model": "good"}}
    )
    assert answer.status_code == 422, answer.text
    assert "model good is broken" in answer.text
    assert str(tmp_path) not in answer.text
