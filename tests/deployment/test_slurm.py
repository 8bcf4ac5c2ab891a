"""The Slurm array of ``deploy/slurm`` with Debian's ``slurm-wlm``: one controller, one node, both on this machine."""

from __future__ import annotations

import os
import platform
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.contracts.repository import ROOT
from tests.integration.agents import Installation, assert_nothing_left, ended, registered_line
from tests.integration.engines import wait_for
from tests.servers import find_program, free_port
from tests.workers.problems import expected_history, line

BATCH = ROOT / "deploy" / "slurm" / "agents.sbatch"

CONFIGURATION = """\
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller}
SlurmdPort={node}
AuthType=auth/none
CredType=cred/none
SlurmUser=root
SlurmdUser=root
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/controller.pid
SlurmdPidFile={folder}/node.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
ReturnToService=2
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SlurmdParameters=config_overrides
KillWait=30
SlurmdTimeout=300
SchedulerParameters=sched_interval=2
NodeName={host} NodeAddr=127.0.0.1 CPUs=4 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


@contextmanager
def cluster(folder: Path) -> Iterator[dict[str, str]]:
    """Run a controller and a node; give the environment in which its commands find it."""
    for name in ("state", "spool"):
        (folder / name).mkdir(parents=True)
    file = folder / "slurm.conf"
    host = platform.node().partition(".")[0]
    file.write_text(CONFIGURATION.format(host=host, controller=free_port(), node=free_port(), folder=folder))
    environment = os.environ | {"SLURM_CONF": str(file)}
    processes = []
    try:
        for program in ("slurmctld", "slurmd"):
            with (folder / f"{program}.log").open("wb") as log:
                command = [str(find_program("setpriv")), "--pdeathsig", "KILL", str(find_program(program)), "-D"]
                processes.append(
                    subprocess.Popen([*command, "-f", file], stdout=log, stderr=subprocess.STDOUT, env=environment)
                )
        wait_for(lambda: "idle" in slurm(environment, "sinfo", "--noheader", "--format=%t"), "an idle node", 60.0)
        yield environment
    finally:
        subprocess.run(["scancel", "--user=root", "--full"], env=environment, check=False, capture_output=True)
        for process in reversed(processes):
            process.terminate()
        for process in processes:
            process.wait(60.0)


def slurm(environment: dict[str, str], *command: str) -> str:
    """Call a command of Slurm; return what it printed."""
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=False).stdout


def test_the_script_wants_what_it_needs() -> None:
    environment = {"PATH": os.environ["PATH"]}
    done = subprocess.run([BATCH], env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "GEOSWARM_SERVER: the address of the service" in done.stderr


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_an_array_of_four_does_a_job_though_two_are_ended_by_walltime(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    place = Installation.with_line(tmp_path, monkeypatch, seconds=1.5)
    key = tmp_path / "key"
    key.write_text(place.key + "\n")
    program = tmp_path / "geoswarm"
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m geoswarm "$@"\n')
    program.chmod(0o755)
    given = {name: value for name, value in place.environment.items() if name != "GEOSWARM_KEY"} | {
        "GEOSWARM": str(program),
        "GEOSWARM_SERVER": place.url,
        "GEOSWARM_KEY_FILE": str(key),
    }
    with cluster(tmp_path / "slurm") as environment, place.running({"api": place.serve()}) as (fleet, client):
        submit = ("sbatch", "--parsable", "--time=30", f"--chdir={tmp_path}", str(BATCH))
        batch = slurm(environment | given, *submit).strip()
        assert re.fullmatch(r"\d+", batch)
        wait_for(lambda: len(place.slots(client)) == 4, "four agents", 300.0)
        job_id = client.submit(registered_line(240).document()).id
        wait_for(lambda: client.get(job_id).evaluations >= 12, "the first generations", 300.0)
        for task in (1, 2):
            slurm(environment, "scontrol", "update", f"JobId={batch}_{task}", "TimeLimit=1")
        wait_for(lambda: len(place.slots(client)) == 2, "the walltime of two", 400.0)
        assert client.get(job_id).state == "running"
        wait_for(lambda: ended(client, job_id), "the end of the job", 1200.0)
        assert client.get(job_id).state == "finished"
        slurm(environment, "scancel", "--full", batch)
        wait_for(lambda: place.slots(client) == [], "the end of all agents", 120.0)
        assert fleet.stop() == {"api": 0}
        assert_nothing_left(fleet)
    time.sleep(0.1)
    logs = [path.read_text() for path in sorted(tmp_path.glob("geoswarm-agent-*.log"))]
    assert len(logs) == 4
    assert all("Ending: SIGTERM was received" in log for log in logs[:2]), logs
    method = {"kind": "particle_swarm", "particles": 6, "acceleration": "none"}
    assert place.history(job_id) == expected_history(line(method=method, stopping={"max_evaluations": 240}))
    tries = place.tries(job_id)
    assert len({worker for _, worker in tries}) == 4
    assert "worker_lost" not in {outcome for outcome, _ in tries}  # what two were at was handed back
