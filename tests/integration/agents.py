"""Installations whose runs agents make: real processes of the service, of agents, and of a registered program."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar

import pytest

from geoswarm import Client
from geoswarm.client.errors import GeoswarmError
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.workers.access.keys import ApiKeys
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.waker import NoWaker
from tests.chaos.fleet import MARK, Fleet
from tests.integration.engines import wait_for
from tests.servers import free_port
from tests.workers.problems import History, recorded_history

T = TypeVar("T")

__all__ = ["Installation", "assert_nothing_left", "ended", "line_model", "registered_line"]

RUN = """\
# what a program of somebody else does, with a process of its own that is to end with it
sleep {seconds} &
wait $!
read a b < values.txt
awk -v a="$a" -v b="$b" 'BEGIN {{ print "x,y"; for (x = 0; x < 4; x++) printf "%d,%.17g\\n", x, a * x + b }}' > out.csv
"""
MODEL = """\
description: A straight line, by a program.
forward_model:
  kind: command
  run: [sh, run.sh]
  files: [run.sh]
  templates: {values.txt: values.txt.in}
  series:
    y: {file: out.csv, x: x, y: y}
parameters:
  a: {lower: 0, upper: 5}
  b: {lower: -5, upper: 5}
"""


def line_model(folder: Path, seconds: float = 0.1) -> Path:
    """Make a folder with the registered model ``line``, whose runs take so long [s]; return the folder around it."""
    model = folder / "line"
    model.mkdir(parents=True)
    (model / "run.sh").write_text(RUN.format(seconds=seconds))
    (model / "values.txt.in").write_text("{{a}} {{b}}\n")
    (model / "model.yaml").write_text(MODEL)
    return folder


def registered_line(evaluations: int, particles: int = 6) -> Problem:
    """A problem for it; GEOSWARM_MODELS must name the folder."""
    return parse_problem(
        {
            "name": "registered line",
            "forward_model": {"kind": "registered", "model": "line"},
            "parameters": {"a": {"lower": 0, "upper": 5}, "b": {"lower": -5, "upper": 5}},
            "observations": [{"series": "y", "points": {"x": [0, 1, 2, 3], "y": [1, 3, 5, 7]}}],
            "method": {"kind": "particle_swarm", "particles": particles, "acceleration": "none"},
            "stopping": {"max_evaluations": evaluations},
            "answer": {"max_evaluations": "off"},
            "seed": 7,
            "failures": {"retry": {"worker_lost": 1000}},
        }
    )


class Installation:
    """A service on a port of its own, and agents, all as processes that are found again whatever happens to them.

    Parameters
    ----------
    database_url
        Of the service; keys are made in it.
    models
        Folder of registered models, of all.
    """

    @classmethod
    def with_line(
        cls, folder: Path, monkeypatch: pytest.MonkeyPatch, seconds: float = 0.1, database_url: str | None = None
    ) -> Installation:
        """An installation with the model ``line`` in ``models``, which this process knows, too; SQLite unless given."""
        models = line_model(folder / "models", seconds)
        monkeypatch.setenv("GEOSWARM_MODELS", str(models))
        return cls(folder, database_url or f"sqlite:///{folder / 'jobs.db'}", models)

    def __init__(self, folder: Path, database_url: str, models: Path | None = None) -> None:
        self.folder = folder
        self.database_url = database_url
        self.port = free_port()
        self.url = f"http://127.0.0.1:{self.port}"
        store = Store(Settings(database_url=database_url))
        self.admin, _ = ApiKeys(store).create("boss", "admin")
        self.key, view = ApiKeys(store).create("agents", "agent")
        self.key_id = view.id
        store.close()
        self.environment = {
            "GEOSWARM_KEY": self.key,
            "GEOSWARM_PASS_ENVIRONMENT": MARK,
            "XDG_STATE_HOME": str(folder / "state"),
            **({} if models is None else {"GEOSWARM_MODELS": str(models)}),
        }

    def serve(self, workers: int = 0) -> Sequence[str]:
        """Arguments of the service."""
        return ("serve", "--port", str(self.port), "--workers", str(workers), "--database", self.database_url)

    def agent(self, *more: str, url: str | None = None) -> Sequence[str]:
        """Arguments of an agent."""
        return ("agent", "--server", url or self.url, "--log-level", "info", *more)

    @contextmanager
    def running(self, commands: Mapping[str, Sequence[str]]) -> Iterator[tuple[Fleet, Client]]:
        """Run processes, restarted whenever they end by themselves; give them and a client of the administrator."""
        with (
            Fleet(commands, self.folder, self.environment) as fleet,
            Client(self.url, api_key=self.admin, timeout=180.0) as client,
        ):
            try:
                yield fleet, client
            except BaseException as error:
                error.add_note(fleet.logs(40))
                raise

    def slots(self, client: Client) -> list[str]:
        """Slots of agents that are there now."""
        try:
            return [worker.id for worker in client.workers() if worker.engine == "agent" and worker.state != "lost"]
        except GeoswarmError:
            return []

    def history(self, job_id: str) -> History:
        """What is stored of a job."""
        return self._with(lambda service: recorded_history(service, job_id))

    def tries(self, job_id: str) -> list[tuple[str, str | None]]:
        """Outcome and worker of every try at every evaluation of a job, after a look that one of each counts."""

        def look(service: JobService) -> list[tuple[str, str | None]]:
            found = []
            for view in service.iterate_evaluations(job_id):
                tries = service.attempts(job_id, view.generation, view.particle)
                assert sum(one.counted for one in tries) == 1, tries
                found += [(one.outcome, one.worker) for one in tries]
            return found

        return self._with(look)

    def _with(self, look: Callable[[JobService], T]) -> T:
        store = Store(Settings(database_url=self.database_url))
        try:
            return look(JobService(store, NoWaker()))
        finally:
            store.close()


def ended(client: Client, job_id: str) -> bool:
    """Whether a job has ended; False while the service does not answer."""
    try:
        return client.get(job_id).ended
    except GeoswarmError:
        return False


def assert_nothing_left(fleet: Fleet) -> None:
    """No process of the installation lives."""
    wait_for(lambda: not fleet.processes(), "the end of all processes")
