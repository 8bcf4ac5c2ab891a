"""From a new environment with the base installation only, an agent serves CalculiX through a proxy with TLS."""

from __future__ import annotations

import json
import shutil
import ssl
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
import pytest

from geoswarm.solver.problem import Problem, load_problem
from geoswarm.solver.problem.text.reading import read_problem_file
from tests.api.operations import OPEN, operations
from tests.deployment.nginx import CERTIFICATE, nginx_configuration
from tests.examples.engines import copy_of, find_engine
from tests.installation import install
from tests.integration.agents import Installation, assert_nothing_left, ended
from tests.integration.engines import PATIENCE, wait_for
from tests.servers import find_program, free_port
from tests.workers.problems import expected_history


@contextmanager
def proxy(folder: Path, target: int) -> Iterator[tuple[str, Path]]:
    """Run nginx with a certificate of its own in front of a port; give its address, and the certificate."""
    folder.mkdir()
    port = free_port()
    (folder / "nginx.conf").write_text(nginx_configuration(folder, port, target))
    nginx = find_program("nginx", [Path("/usr/sbin")])
    command = [str(find_program("setpriv")), "--pdeathsig", "TERM", str(nginx), "-p", str(folder)]
    process = subprocess.Popen([*command, "-c", str(folder / "nginx.conf")])
    try:
        yield f"https://localhost:{port}", folder / CERTIFICATE
    finally:
        process.terminate()
        process.wait(60.0)


def registered_footing(example: Path, models: Path) -> Problem:
    """Register the example's program as the model ``footing``; return the problem with it."""
    document = read_problem_file(example / "problem.yaml")
    model = models / "footing"
    model.mkdir(parents=True)
    shutil.copy(example / "footing.inp.in", model)
    declared: dict[str, Any] = {
        "description": "A footing on two layers with CalculiX.",
        "forward_model": document["forward_model"],
        "parameters": {
            "E_upper": {"unit": "kPa", "lower": 1.0, "upper": 1e9},
            "E_lower": {"unit": "kPa", "lower": 1.0, "upper": 1e9},
            "nu": {"lower": 0.0, "upper": 0.499},
        },
    }
    (model / "model.yaml").write_text(json.dumps(declared), encoding="utf-8")
    document["forward_model"] = {"kind": "registered", "model": "footing"}
    document["method"] = {"kind": "particle_swarm", "particles": 4, "acceleration": "none"}
    document["stopping"] = {"max_evaluations": 12}
    (example / "registered.yaml").write_text(json.dumps(document), encoding="utf-8")
    return load_problem(example / "registered.yaml")


def assert_nothing_else_opens(asks: httpx.Client, job_id: str) -> None:
    """Every route is tried with the key of the agent, with a job that there is: those of agents answer, no other."""
    tried = [
        (method, path.replace("0" * 16, job_id) if "/jobs/" in path else path)
        for method, path in operations(asks.get("/openapi.json").json())
    ]
    own = [(method, path) for method, path in tried if path.startswith("/api/v1/agents/")]
    others = [pair for pair in tried if pair not in own and not pair[1].startswith(OPEN)]
    others.remove(("POST", "/api/v1/session"))
    assert len(own) >= 7
    assert len(others) > 50
    for method, path in [*others, ("GET", "/"), ("GET", "/workers"), ("GET", f"/jobs/{job_id}")]:
        answer = asks.request(method, path, json=None if method == "GET" else {})
        assert answer.status_code == 403, (method, path, answer.text)
        assert "This API key has the role 'agent'" in answer.text, (method, path)
    signed_in = asks.post("/api/v1/session", json={"key": asks.headers["Authorization"].removeprefix("Bearer ")})
    assert (signed_in.status_code, "set-cookie" in signed_in.headers) == (403, False)


@pytest.mark.slow  # fetches the packages of the base installation
@pytest.mark.timeout(1800)
def test_an_agent_of_the_base_installation_serves_calculix_through_tls(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    find_engine("ccx", "calculix-ccx")
    installed = install(tmp_path / "installed")
    lacking = "import importlib.util as u; print([n for n in ('sqlalchemy', 'fastapi', 'celery') if u.find_spec(n)])"
    done = subprocess.run([installed.python, "-c", lacking], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
    models = tmp_path / "models"
    example = copy_of("calculix", tmp_path / "example").parent
    monkeypatch.setenv("GEOSWARM_MODELS", str(models))
    problem = registered_footing(example, models)
    history = expected_history(problem)
    place = Installation(tmp_path, f"sqlite:///{tmp_path / 'jobs.db'}", models)
    key = tmp_path / "key"
    key.write_text(place.key + "\n")
    with place.running({"api": place.serve()}) as (fleet, client), proxy(tmp_path / "proxy", place.port) as (url, ca):
        environment = installed.environment(SSL_CERT_FILE=str(ca), XDG_STATE_HOME=str(tmp_path / "state"))
        command = [installed.script, "agent", "--server", url, "--key-file", key, "--models", models, "--slots", "2"]
        log = (tmp_path / "agent.log").open("wb")
        agent = subprocess.Popen(command, env=environment, cwd=tmp_path, stdout=log, stderr=log)
        try:
            wait_for(lambda: len(place.slots(client)) == 2, "an agent", 300.0)
            job_id = client.submit(problem.document()).id
            wait_for(lambda: ended(client, job_id), "the end of the job", 900.0)
            assert client.get(job_id).state == "finished"
            slot = client.workers()[0].agent
            assert slot is not None
            assert list(slot.models) == ["footing"]
            context = ssl.create_default_context(cafile=str(ca))
            head = {"Authorization": f"Bearer {place.key}"}
            with httpx.Client(base_url=url, headers=head, verify=context, timeout=PATIENCE) as asks:
                assert_nothing_else_opens(asks, job_id)
            agent.terminate()
            assert agent.wait(60.0) == 0, (tmp_path / "agent.log").read_text()
        finally:
            agent.kill()
            agent.wait()
            log.close()
        assert fleet.stop() == {"api": 0}
        assert_nothing_left(fleet)
    assert place.history(job_id) == history
