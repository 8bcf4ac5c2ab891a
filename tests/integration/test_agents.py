"""Real agents at a real service: disturbed in every way, and the history is that of the run in one process."""

from __future__ import annotations

import signal
import time
from pathlib import Path

import psutil
import pytest
from click.testing import CliRunner

from geoswarm import Client
from geoswarm.cli.commands import cli
from geoswarm.workers.access.keys import ApiKeys
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from tests.chaos.fleet import Fleet, send
from tests.integration.agents import Installation, assert_nothing_left, ended, registered_line
from tests.integration.clocks import an_hour_ahead
from tests.integration.cuttable import CuttableLine
from tests.integration.engines import wait_for
from tests.workers.problems import expected_history, line

METHOD = {"kind": "particle_swarm", "particles": 6, "acceleration": "none"}
FORMULA = line(method=METHOD)


@pytest.fixture(params=["sqlite", "postgresql"])
def database_url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    if request.param == "sqlite":
        return f"sqlite:///{tmp_path / 'jobs.db'}"
    url: str = request.getfixturevalue("fresh_postgres_url")
    return url


def run_to_the_end(fleet: Fleet, client: Client, job_id: str, seconds: float = 600.0) -> None:
    def done() -> bool:
        fleet.supervise()
        time.sleep(0.1)
        return ended(client, job_id)

    wait_for(done, f"the end of job {job_id}", seconds)


def supervised(fleet: Fleet, seconds: float) -> None:
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        fleet.supervise()
        time.sleep(0.1)


@pytest.mark.slow  # the next one has an agent that does a job alone, too
@pytest.mark.timeout(900)
def test_an_agent_does_a_job_alone_and_ends_without_work(tmp_path: Path) -> None:
    place = Installation(tmp_path, f"sqlite:///{tmp_path / 'jobs.db'}")
    with place.running({"api": place.serve(), "agent": place.agent("--slots", "2")}) as (fleet, client):
        wait_for(lambda: len(place.slots(client)) == 2, "an agent", 600.0)
        job_id = client.submit(FORMULA.document()).id
        run_to_the_end(fleet, client, job_id)
        assert client.get(job_id).state == "finished"
        assert all(code == 0 for code in fleet.stop().values())
        assert_nothing_left(fleet)
    assert place.history(job_id) == expected_history(FORMULA)
    assert list((tmp_path / "state").rglob("*.json")) == []


@pytest.mark.slow  # tests/geoswarm/agent fetches without a service's processes
@pytest.mark.timeout(900)
def test_a_model_that_only_the_service_has_is_fetched(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    place = Installation.with_line(tmp_path, monkeypatch)
    secret, signed = tmp_path / "secret", tmp_path / "list.json"
    command = ["models", "sign", "--secret-file", str(secret), "--output", str(signed)]
    done = CliRunner().invoke(cli, command)
    assert done.exit_code == 0, done.output
    assert secret.stat().st_mode & 0o777 == 0o600
    place.environment |= {"GEOSWARM_SIGNED_MODELS": str(signed)}
    with place.running({"api": place.serve()}) as (fleet, client):
        place.environment |= {"GEOSWARM_MODELS": ""}
        agents = {
            "without": place.agent("--kinds", "registered", "--state", str(tmp_path / "without")),
            "with": place.agent("--fetch-models", str(secret)),
        }
        with Fleet(agents, tmp_path, place.environment) as elsewhere:
            wait_for(lambda: len(place.slots(client)) == 2, "two agents", 600.0)
            job_id = client.submit(registered_line(12).document()).id
            run_to_the_end(elsewhere, client, job_id)
            offered = [worker.agent.models for worker in client.workers() if worker.agent is not None]
            assert sorted(len(one) for one in offered) == [0, 1]
            assert elsewhere.stop() == {"without": 0, "with": 0}
            assert_nothing_left(elsewhere)
        assert client.get(job_id).state == "finished"
        assert fleet.stop() == {"api": 0}
    assert place.history(job_id) == expected_history(line(method=METHOD, stopping={"max_evaluations": 12}))
    kept = list((tmp_path / "state" / "geoswarm" / "agent" / "models").glob("*/line/run.sh"))
    assert [path.read_bytes() for path in kept] == [(tmp_path / "models" / "line" / "run.sh").read_bytes()]


@pytest.mark.slow
@pytest.mark.timeout(1500)
def test_agents_and_workers_disturbed_in_every_way(
    tmp_path: Path, database_url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    place = Installation.with_line(tmp_path, monkeypatch, seconds=0.25, database_url=database_url)
    problem = registered_line(300)
    with CuttableLine(place.port) as cable:
        commands = {
            "api": place.serve(workers=1),
            "agent cut": place.agent("--slots", "2", url=f"http://127.0.0.1:{cable.port}"),
            "agent killed": place.agent(),
            "agent frozen": place.agent(),
        }
        with place.running(commands) as (fleet, client):
            wait_for(lambda: len(place.slots(client)) == 4, "three agents", 600.0)
            job_id = client.submit(problem.document()).id
            wait_for(lambda: client.get(job_id).evaluations >= 6, "the first generation", 300.0)
            frozen = fleet.members["agent frozen"].process
            assert frozen is not None
            assert send(frozen.pid, signal.SIGSTOP)
            cable.cut()
            supervised(fleet, 3.0)
            for _ in range(3):
                fleet.kill("agent killed")
                supervised(fleet, 4.0)
            send(frozen.pid, signal.SIGCONT)
            cable.mend()
            assert client.get(job_id).state == "running"
            fleet.kill("api")
            run_to_the_end(fleet, client, job_id)
            assert all(code == 0 for code in fleet.stop().values())
            assert_nothing_left(fleet)
    # The same numbers as from the formula that the program calculates, though each of its runs is another process.
    assert place.history(job_id) == expected_history(line(method=METHOD, stopping={"max_evaluations": 300}))
    tries = place.tries(job_id)
    by = {worker.partition("/")[0] for _, worker in tries if worker is not None and "/" in worker}
    assert len(by) >= 3
    assert any(worker is not None and "/" not in worker for _, worker in tries)
    # What was lost goes to others; who comes back with it after all is late.
    assert {"worker_lost", "late"} & {outcome for outcome, _ in tries}


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_an_agent_whose_clock_is_off_by_an_hour(tmp_path: Path) -> None:
    place = Installation(tmp_path, f"sqlite:///{tmp_path / 'jobs.db'}")
    with place.running({"api": place.serve()}) as (fleet, client):
        place.environment |= an_hour_ahead()
        with Fleet({"agent": place.agent("--until", "+1h")}, tmp_path, place.environment) as late:
            wait_for(lambda: len(place.slots(client)) == 1, "an agent", 600.0)
            job_id = client.submit(FORMULA.document()).id
            run_to_the_end(fleet, client, job_id)
            before = client.get(job_id)
            worker = client.workers()[0]
            assert late.stop() == {"agent": 0}
            assert_nothing_left(late)
        evaluation = client.evaluations(job_id, limit=1).items[0]
    assert place.history(job_id) == expected_history(FORMULA)
    assert before.seconds is not None
    assert before.seconds < 600.0  # the service's time only
    assert worker.seen_at.timestamp() < time.time() + 60.0
    assert evaluation.generation == 0


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_results_wait_on_disk_while_the_service_is_away(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    place = Installation.with_line(tmp_path, monkeypatch, seconds=3.0)
    with place.running({"api": place.serve(), "agent": place.agent()}) as (fleet, client):
        wait_for(lambda: len(place.slots(client)) == 1, "an agent", 600.0)
        job_id = client.submit(registered_line(6).document()).id
        wait_for(lambda: client.workers()[0].state == "busy", "a run", 300.0)
        fleet.kill("api")
        wait_for(lambda: bool(list((tmp_path / "state").rglob("*.json"))), "results on disk", 300.0)
        fleet.kill("agent")  # whoever starts next on this machine hands them in
        wait_for(lambda: [p for p in fleet.processes() if _is_run(p)] == [], "the end of what it ran", 60.0)
        kept = [path.stem for path in (tmp_path / "state").rglob("*.json")]
        assert len(kept) == 1
        run_to_the_end(fleet, client, job_id)
        wait_for(lambda: not list((tmp_path / "state").rglob("*.json")), "an agent that knows of it", 60.0)
        assert all(code == 0 for code in fleet.stop().values())
        assert_nothing_left(fleet)
    assert [bits[:2] for bits in place.history(job_id)] == [(0, particle) for particle in range(6)]
    assert len({worker for _, worker in place.tries(job_id)}) == 2


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_a_service_that_is_down_for_an_hour(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is down for some seconds, and an hour ahead when it is back: for its leases that is the same."""
    place = Installation.with_line(tmp_path, monkeypatch, seconds=3.0)
    with place.running({"api": place.serve(), "agent": place.agent("--slots", "2")}) as (fleet, client):
        wait_for(lambda: len(place.slots(client)) == 2, "an agent", 600.0)
        job_id = client.submit(registered_line(24).document()).id
        wait_for(lambda: all(worker.state == "busy" for worker in client.workers()), "two runs", 300.0)
        fleet.kill("api")
        wait_for(lambda: len(list((tmp_path / "state").rglob("*.json"))) == 2, "results on disk", 300.0)
        fleet.members["api"].environment = an_hour_ahead()
        run_to_the_end(fleet, client, job_id)
        assert client.get(job_id).state == "finished"
        assert fleet.stop() == {"api": 0, "agent": 0}
        assert_nothing_left(fleet)
    assert place.history(job_id) == expected_history(line(method=METHOD, stopping={"max_evaluations": 24}))
    # A slot that comes back earlier may repeat what another one still holds: the result that was kept counts.
    assert {outcome for outcome, _ in place.tries(job_id)} <= {"finished", "superseded"}


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_a_lease_that_comes_while_an_agent_ends_is_handed_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    place = Installation.with_line(tmp_path, monkeypatch, seconds=120.0)
    with CuttableLine(place.port) as cable:
        agent = place.agent(url=f"http://127.0.0.1:{cable.port}")
        with place.running({"api": place.serve(), "agent": agent}) as (fleet, client):
            wait_for(lambda: len(place.slots(client)) == 1, "an agent", 600.0)
            time.sleep(1.0)  # it waits for work now
            cable.hold()
            job_id = client.submit(registered_line(6).document()).id
            wait_for(lambda: client.workers()[0].state == "busy", "a lease", 300.0)
            process = fleet.members.pop("agent").process
            assert process is not None
            process.terminate()
            time.sleep(1.0)
            cable.mend()
            assert process.wait(60.0) == 0
            first = client.evaluations(job_id, limit=1).items[0]
            assert (first.state, first.attempts) == ("pending", 0)
            assert fleet.stop() == {"api": 0}
            assert_nothing_left(fleet)


def _is_run(pid: int) -> bool:
    try:
        return "geoswarm.agent" in " ".join(psutil.Process(pid).cmdline())
    except psutil.Error:
        return False


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_revoking_the_key_kills_what_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    place = Installation.with_line(tmp_path, monkeypatch, seconds=120.0)
    with place.running({"api": place.serve(), "agent": place.agent()}) as (fleet, client):
        wait_for(lambda: len(place.slots(client)) == 1, "an agent", 600.0)
        job_id = client.submit(registered_line(6).document()).id
        wait_for(lambda: client.workers()[0].state == "busy", "a run", 300.0)
        store = Store(Settings(database_url=place.database_url))
        ApiKeys(store).revoke(place.key_id)
        store.close()
        agent = fleet.members["agent"].process
        assert agent is not None
        assert agent.wait(200.0) == 2
        api = fleet.members["api"].process
        assert api is not None
        wait_for(lambda: not [pid for pid in fleet.processes() if _is_run(pid)], "the end of what it ran", 60.0)
        first = client.evaluations(job_id, limit=1).items[0]
        assert (first.state, first.attempts) == ("pending", 0)
        fleet.members.pop("agent")
        assert fleet.stop() == {"api": 0}
        assert_nothing_left(fleet)


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.parametrize("how", ["term", "until", "cancel"])
def test_what_runs_is_handed_back_or_killed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, how: str) -> None:
    place = Installation.with_line(tmp_path, monkeypatch, seconds=120.0)
    more = {"term": ("--grace", "1"), "until": ("--until", "+100s"), "cancel": ()}[how]
    with place.running({"api": place.serve(), "agent": place.agent(*more)}) as (fleet, client):
        wait_for(lambda: len(place.slots(client)) == 1, "an agent", 600.0)
        job_id = client.submit(registered_line(6).document()).id
        wait_for(lambda: client.workers()[0].state == "busy", "a run", 300.0)
        agent = fleet.members["agent"].process
        assert agent is not None
        if how == "cancel":
            client.cancel(job_id)
            wait_for(lambda: client.workers()[0].state == "idle", "an idle agent", 120.0)
            wait_for(lambda: not [p for p in fleet.processes() if _name(p) == "sleep"], "the end of the run", 60.0)
        else:
            if how == "term":
                agent.terminate()
            assert agent.wait(300.0) == 0
            first = client.evaluations(job_id, limit=1).items[0]
            assert first.state == "pending"
            assert client.workers() == ()
            fleet.members.pop("agent")
        assert all(code == 0 for code in fleet.stop().values())
        assert_nothing_left(fleet)
    assert list((tmp_path / "state").rglob("*.json")) == []


def _name(pid: int) -> str:
    try:
        return str(psutil.Process(pid).name())
    except psutil.Error:
        return ""
