"""Every public name has an example in its docstring, and the examples do what they say.

They are run in an empty folder, beside a service. In the examples of methods ``client`` is open, ``problem`` was
submitted as ``job``, which has finished, and ``slope`` is a job with a mesh. Those of :class:`AsyncClient` are the
same with ``await``.
"""

from __future__ import annotations

import ast
import doctest
import importlib
import inspect
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from pydantic import SecretStr

import geoswarm
from geoswarm.api import ApiSettings
from geoswarm.client import AsyncClient, Client
from geoswarm.workers.hosts.engine import open_engine
from geoswarm.workers.settings import Settings
from tests.api.conftest import line_problem, live_server
from tests.integration.engines import PATIENCE
from tests.solver.ags.synthetic import content

KEY = "a-key-of-the-administrator-for-these-examples"
METHODS = sorted(name for name in vars(Client) if not name.startswith("_"))


def docstring(name: str) -> str:
    """That of an exported name; of a constant or an alias the string below its assignment."""
    module = importlib.import_module(geoswarm._ELSEWHERE.get(name, "geoswarm.client"))
    item = getattr(geoswarm, name)
    if inspect.isclass(item) or inspect.isfunction(item):
        return inspect.getdoc(item) or ""
    source = module.__file__
    if name == "DEFAULT_STOPPING":
        source = importlib.import_module("geoswarm.calibration.problems").__file__
    assert source is not None
    body = ast.parse(Path(source).read_text(encoding="utf-8")).body
    for statement, below in pairwise(body):
        if (
            isinstance(statement, ast.AnnAssign)
            and isinstance(statement.target, ast.Name)
            and statement.target.id == name
            and isinstance(below, ast.Expr)
        ):
            return str(ast.literal_eval(below.value))
    return ""


def run(text: str, name: str, names: dict[str, Any]) -> tuple[int, str]:
    """Run the examples of a docstring; return how many there are, and what went wrong."""
    test = doctest.DocTestParser().get_doctest(text, dict(names), name, None, 0)
    said: list[str] = []
    doctest.DocTestRunner(verbose=False).run(test, out=said.append)
    return len(test.examples), "".join(said)


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Any]]:
    folder = tmp_path_factory.mktemp("service")
    settings = Settings(database_url=f"sqlite:///{folder}/jobs.db", workers=1)
    with (
        open_engine(settings) as engine,
        live_server(engine.service, ApiSettings(api_key=SecretStr(KEY))) as server,
        Client(server.url, api_key=KEY, timeout=PATIENCE) as client,
    ):
        job = client.wait(client.submit(line_problem()).id, timeout=120)
        section = client.example("slope")["problem"]
        section["forward_model"]["element_length"] = 50  # a coarse mesh is quick
        section["forward_model"]["layers"][1]["rows"] = 1
        once = {"method": {"kind": "monte_carlo", "samples": 1}, "stopping": {}}
        slope = client.wait(client.submit(section | once).id, timeout=PATIENCE)
        yield {"client": client, "job": job, "slope": slope, "problem": line_problem(), "url": server.url}


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, service: dict[str, Any]) -> None:
    monkeypatch.chdir(tmp_path)
    Path("laboratory.ags").write_bytes(content())
    Path("specimen.csv").write_text("height [mm];20.2", encoding="utf-8")
    monkeypatch.setenv("GEOSWARM_URL", service["url"])
    monkeypatch.setenv("GEOSWARM_API_KEY", KEY)


@pytest.mark.filterwarnings("ignore::geoswarm.InProcessWarning")
@pytest.mark.parametrize("name", [name for name in geoswarm.__all__ if name != "AsyncClient"])
def test_the_example_of_a_public_name(name: str) -> None:
    examples, said = run(docstring(name), name, {})
    assert examples >= 2
    assert said == ""


@pytest.mark.parametrize("name", METHODS)
def test_the_example_of_a_method_of_the_client(name: str, service: dict[str, Any]) -> None:
    names = {key: service[key] for key in ("client", "job", "slope", "problem")}
    examples, said = run(inspect.getdoc(getattr(Client, name)) or "", name, names)
    assert examples >= 1
    assert said == ""


def test_examples_of_the_asynchronous_client_wait() -> None:
    """That they say the same as those of the other client is tested in client/test_aio.py."""
    for name in METHODS:
        twin = inspect.getdoc(getattr(AsyncClient, name)) or ""
        assert "await " in twin or "async " in twin
    assert ">>> async with AsyncClient" in (AsyncClient.__doc__ or "")
