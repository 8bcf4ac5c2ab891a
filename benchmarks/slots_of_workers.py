"""Share of the time of four Celery workers that runs of unequal length take: ``python -m benchmarks.slots_of_workers``.

A third of the runs take four times as long as the others. PostgreSQL and Redis are started for it.
"""

from __future__ import annotations

from pathlib import Path

import click
import pytest

from geoswarm.solver.forward import registry
from geoswarm.workers.hosts.engine import open_engine
from geoswarm.workers.settings import Settings
from tests.integration.engines import celery_workers, wait_for, wait_until_ended
from tests.integration.test_widths import share_used, uneven
from tests.servers import PostgresServer, RedisServer


@click.command()
@click.option("--seconds", default=0.5, show_default=True, help="of a short run")
@click.option("--runs", default=120, show_default=True)
@click.option("--slots", default=4, show_default=True)
def main(seconds: float, runs: int, slots: int) -> None:
    """Print the share with and without overlap, and with ``particles: auto``."""
    ways = {
        "waiting": {"particles": slots},
        "overlap": {"particles": slots, "overlap": True},
        "auto, overlap": {"particles": "auto", "overlap": True},
        "auto": {"particles": "auto"},
    }
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(Path("tests/models").resolve()))
        patch.setenv("PYTHONPATH", str(Path("tests/models").resolve()), prepend=":")
        registry.forget()
        with PostgresServer() as postgres, RedisServer() as redis:
            settings = Settings(database_url=postgres.create_database(), broker_url=redis.create_database())
            with open_engine(settings) as engine, celery_workers(settings, count=slots):
                wait_for(lambda: len(engine.service.workers()) == slots, "workers")
                for name, method in ways.items():
                    problem = uneven(
                        seconds,
                        method={"kind": "particle_swarm", **method},
                        stopping={"max_evaluations": runs},
                        answer={"max_evaluations": "off"},
                    )
                    job = engine.service.submit(problem)[0].id
                    wait_until_ended(engine.service, job, 3600.0)
                    print(f"{name:15s} {100 * share_used(engine.service, job, slots):5.1f} %", flush=True)


if __name__ == "__main__":
    main()
