"""The examples of the documentation run, and its lists are complete."""

from __future__ import annotations

import json
import re
import runpy
from pathlib import Path

import pytest

from geoswarm.api.settings import VARIABLES
from geoswarm.client import errors
from geoswarm.workers.hosts.engine import Engine
from tests.api.conftest import App, LiveServer, line_problem

DOCS = Path(__file__).parents[3] / "docs"
CLIENT = (DOCS / "python-client.md").read_text(encoding="utf-8")
HTTP = (DOCS / "http-api.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```python\n(.*?)```", CLIENT, re.DOTALL)


@pytest.mark.parametrize("number", range(5))
def test_examples_of_the_client_run(
    server: LiveServer,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    number: int,
) -> None:
    assert len(BLOCKS) == 5
    (tmp_path / "problem.yaml").write_text(json.dumps(line_problem(name=f"documentation {number}")))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("GEOSWARM_URL", server.url)
    (tmp_path / "example.py").write_text(BLOCKS[number])
    runpy.run_path(str(tmp_path / "example.py"))
    expected = ["finished", "60 evaluations, about", "b undecided", "good fits", "finished"][number]
    assert expected in capsys.readouterr().out


def test_every_error_is_drawn() -> None:
    assert all(name in CLIENT for name in errors.__all__ if name != "Issue")


def test_every_route_job_field_and_variable_is_described(engine: Engine) -> None:
    document = App(engine.service).get("/openapi.json").json()
    for path, operations in document["paths"].items():
        for method in operations:
            assert re.search(rf"`{method.upper()} {re.escape(path)}[`?]", HTTP), f"{method} {path}"
    assert all(f"`{name}`" in HTTP for name in document["components"]["schemas"]["Job"]["properties"])
    assert all(f"`{variable}`" in HTTP for variable in VARIABLES.values())
