"""Fixtures for all tests: real servers, and an environment that does not depend on the user's."""

from __future__ import annotations

import gc
import os
import signal
from base64 import b64decode
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

from geoswarm.solver.system.environment import SWITCH, numerics

# A made-up case may take as long as the machine needs.
settings.register_profile("any machine", deadline=None)
settings.load_profile("any machine")
# Settings of the user's own installation must not reach the tests.
for _name in [name for name in os.environ if name.startswith("GEOSWARM_") and name != SWITCH]:
    del os.environ[_name]
# Before NumPy is loaded: one numerical thread a process, so that parallel workers do not fight for the cores.
os.environ.update(numerics())
# A shell ignores interrupts for what it starts in the background; the programs that tests start must not inherit that.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# The folders with browsers, servers and long calculations, in the order in which they begin; the others follow.
FIRST = (
    "dashboard",
    "integration",
    "examples",
    "documentation",
    "workers",
    "api",
    "deployment",
    "verification",
    "attacks",
    "contracts",
)

# What starts a server, a browser or geoswarm: a fixture, a name that the module of a test imports, a parameter.
STARTERS = {
    *("postgres_server", "redis_server", "postgresql", "browser", "engine", "server", "embedded", "full", "site"),
    *("receiver", "certificate", "misbehaving_models", "zoo_models", "subprocess", "multiprocessing", "open_engine"),
    *("live_server", "LiveServer", "serving", "Reader", "celery_workers", "chromium", "Installation", "receiving"),
    *("calibrated", "find_engine", "Controller"),
}
# Files that start processes of geoswarm through what they call.
STARTING = {
    "api/test_catalogue.py",
    "api/test_metrics.py",
    "api/test_registered_models.py",
    "api/test_schemathesis.py",
    "geoswarm/agent/test_runs.py",
    "solver/forward/programs/test_python_function.py",
    "solver/search/test_accelerated_swarm.py",
    "solver/test_answer.py",
}
# Files without such that took about 5 s of processor time or more, with compiled kernels.
LENGTHY = {
    "api/test_jobs.py",
    "attacks/test_text_growth.py",
    "examples/test_examples.py",
    "examples/test_one_set_of_residuals.py",
    "examples/test_reference_data.py",
    "examples/test_slope.py",
    "geoswarm/cli/test_model.py",
    "geoswarm/cli/test_run.py",
    "geoswarm/cli/test_statistics.py",
    "geoswarm/test_python_interface.py",
    "geoswarm/test_result.py",
    "solver/identifiability/test_basins.py",
    "solver/identifiability/test_posterior.py",
    "solver/report/test_extent.py",
    "solver/report/test_figures.py",
    "verification/fem/test_strength_change.py",
    "verification/test_cases.py",
    "workers/test_ending.py",
    "workers/test_runtime.py",
    "workers/test_worker.py",
}

BLANK_PNG = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGP4DwABAQEAsTj2FAAAAABJRU5ErkJggg=="

from tests import servers  # noqa: E402
from tests.servers import MissingServerError, PostgresServer, RedisServer  # noqa: E402


def is_fast(item: pytest.Function) -> bool:
    """Return whether a test is one of `make test-fast`: it starts nothing, and its file does not take long."""
    parameters = item.callspec.params.values() if hasattr(item, "callspec") else ()
    used = {*item.fixturenames, *vars(item.module), *(value for value in parameters if isinstance(value, str))}
    file = item.nodeid.partition("::")[0].partition("/")[2]
    return STARTERS.isdisjoint(used) and file not in STARTING | LENGTHY


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Function]) -> None:
    """Mark what is fast, and begin with the folders that take longest, so that these do not run last, alone."""
    for item in items:
        if is_fast(item):
            item.add_marker("fast")
    first = {name: number for number, name in enumerate(FIRST)}
    items.sort(key=lambda item: first.get(item.nodeid.split("/")[1], len(first)) if "/" in item.nodeid else -1)


def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Keep the files of a folder in one process where the others have something else to do."""
    from tests.scheduling import FolderScheduling

    return FolderScheduling(config, log)


@pytest.hookimpl(tryfirst=True)
def pytest_collection() -> None:
    """Look for no garbage while tests are collected, which leaves none: a third of the time of collecting."""
    gc.disable()


def pytest_collection_finish() -> None:
    """Look for garbage seldom, and not among thousands of tests: a tenth of the time of a run."""
    gc.enable()
    gc.freeze()
    gc.set_threshold(100_000, 20, 100)


@pytest.fixture
def zoo_models(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Registered models whose programs misbehave, in a folder of their own; run folders lie in tmp_path."""
    from tests.solver.external.zoo import register

    folder = tmp_path / "models"
    register(folder)
    monkeypatch.setenv("GEOSWARM_MODELS", str(folder))
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    return folder


@pytest.fixture
def blank_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each figure is drawn, but rendered as an empty one: for tests that read tables, pages and names of files."""
    forms = {"svg": b'<svg width="1pt" height="1pt"></svg>', "png": b64decode(BLANK_PNG)}
    monkeypatch.setattr("geoswarm.solver.report.figures.style._render", lambda _figure, form, **_options: forms[form])


@pytest.fixture(scope="session")
def sqlite_template(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A file with all tables; each test has a copy of it, as making the tables takes longer than most tests."""
    from geoswarm.workers.settings import Settings
    from geoswarm.workers.store import Store

    path = tmp_path_factory.mktemp("template") / "jobs.db"
    Store(Settings(database_url=f"sqlite:///{path}")).close()
    return path


@pytest.fixture(scope="session")
def postgres_server() -> Iterator[PostgresServer]:
    """PostgreSQL for the whole run (one for each xdist worker); a test that breaks it may leave it stopped."""
    try:
        with PostgresServer() as server:
            yield server
    except MissingServerError as error:
        pytest.fail(str(error), pytrace=False)


@pytest.fixture(scope="session")
def redis_server() -> Iterator[RedisServer]:
    """Redis for the whole run (one for each xdist worker); a test that breaks it may leave it stopped."""
    try:
        with RedisServer() as server:
            yield server
    except MissingServerError as error:
        pytest.fail(str(error), pytrace=False)


@pytest.fixture(scope="session")
def postgres_url(postgres_server: PostgresServer) -> str:
    """SQLAlchemy address of the maintenance database; tests that write want ``fresh_postgres_url``."""
    return postgres_server.url


@pytest.fixture(scope="session")
def redis_url(redis_server: RedisServer) -> str:
    """Address of database 0; tests that write want ``fresh_redis_url``."""
    return redis_server.url


@pytest.fixture
def fresh_postgres_url(postgres_server: PostgresServer) -> Iterator[str]:
    """SQLAlchemy address of a new, empty database on the running server."""
    postgres_server.start()
    url = postgres_server.create_database()
    yield url
    postgres_server.start()
    postgres_server.drop_database(url)


@pytest.fixture
def fresh_redis_url(redis_server: RedisServer) -> str:
    """Address of an empty numbered database on the running server."""
    redis_server.start()
    return redis_server.create_database()


@pytest.fixture
def free_port() -> int:
    """A TCP port of 127.0.0.1 on which nothing listens."""
    return servers.free_port()


@pytest.fixture
def misbehaving_models(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """What tests/models has is installed, here and in processes that are started meanwhile."""
    from geoswarm.solver.forward import registry as forward_models
    from geoswarm.solver.methods import registry as methods

    folder = str(Path(__file__).parent / "models")
    monkeypatch.syspath_prepend(folder)
    monkeypatch.setenv("PYTHONPATH", folder, prepend=os.pathsep)
    registries = (forward_models, methods)
    for registry in registries:
        registry.forget()
    yield
    monkeypatch.undo()
    for registry in registries:
        registry.forget()
