"""Real PostgreSQL and Redis servers for tests: on a free loopback port, in a temporary folder, ended with the test run.

A server ends when its context manager ends. When the test run itself is killed it ends too, because each child asks the
kernel for a signal at the death of the thread that started it (``setpriv --pdeathsig``); so start and restart servers
from the thread that runs the test. Only processes started here are ever signalled, each by its own handle.

::

    ServerError
    ├── MissingServerError      a program is not installed; names the Debian packages
    └── ServerStartError        the server ended early or did not answer; carries the end of its log
"""

from __future__ import annotations

import itertools
import os
import pwd
import random
import secrets
import shutil
import signal
import socket
import subprocess
import tempfile
import time
from abc import ABC, abstractmethod
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import ClassVar, Self

import psycopg
import redis
from psycopg import sql
from redis.backoff import NoBackoff
from redis.retry import Retry

__all__ = [
    "MissingServerError",
    "PostgresServer",
    "RedisServer",
    "Server",
    "ServerError",
    "ServerStartError",
    "find_program",
    "free_port",
]

START_SECONDS = 120.0
STOP_SECONDS = 60.0
POLL_SECONDS = 0.02
PACKAGES = "postgresql redis-server"
# Below the kernel's ephemeral range: a client that keeps dialling a stopped server could otherwise be given the
# server's own port as its source port, connect to itself, and keep the server from coming back.
PORTS = range(20_000, 32_000)


class ServerError(Exception):
    """Base of what goes wrong with a test server."""


class MissingServerError(ServerError):
    """A program that the tests need is not installed."""

    def __init__(self, program: str) -> None:
        super().__init__(
            f"the program {program!r} was not found; the tests start real servers from Debian's packages: "
            f"run `make servers`, or `sudo apt-get install --no-install-recommends {PACKAGES}`"
        )


class ServerStartError(ServerError):
    """The server ended early or did not answer in time."""


def free_port(count: int = 1) -> int:
    """Return a TCP port of 127.0.0.1 on which nothing listens now, outside the range of outgoing connections.

    The next ``count - 1`` ports are free, too.
    """
    for port in random.SystemRandom().sample(PORTS[: len(PORTS) - count + 1], 200):
        if all(map(_is_free, range(port, port + count))):
            return port
    raise ServerStartError(f"no free port of 127.0.0.1 between {PORTS.start} and {PORTS.stop - 1}")


def _is_free(port: int) -> bool:
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", port))
        except OSError:
            return False
    return True


def find_program(name: str, folders: Sequence[Path] = ()) -> Path:
    """Return the program from the first of ``folders`` that holds it, else from PATH; MissingServerError if nowhere."""
    search_path = os.pathsep.join([*map(str, folders), os.environ.get("PATH", os.defpath)])
    found = shutil.which(name, path=search_path)
    if found is None:
        raise MissingServerError(name)
    return Path(found)


class Server(ABC):
    """A server that a test may stop, kill and start again; port, address and data outlive its process."""

    name: ClassVar[str]
    death_signal: ClassVar[str]
    kill_signal: ClassVar[signal.Signals]

    def __init__(self) -> None:
        self.port = free_port()
        self.folder = Path(tempfile.mkdtemp(prefix=f"geoswarm-{self.name}-"))
        self._process: subprocess.Popen[bytes] | None = None

    @property
    @abstractmethod
    def url(self) -> str:
        """Address for clients; the same for the whole life of the object."""

    @abstractmethod
    def _prepare(self) -> None:
        """Make what the first start needs."""

    @abstractmethod
    def _command(self) -> list[str]:
        """Program and arguments of the server."""

    @abstractmethod
    def _answers(self) -> bool:
        """Whether the server accepts commands now."""

    @property
    def pid(self) -> int | None:
        """Process number while the server runs, else None."""
        return self._process.pid if self._process is not None and self._process.poll() is None else None

    @property
    def running(self) -> bool:
        """Whether the server process is alive."""
        return self.pid is not None

    def start(self) -> None:
        """Start the server and wait until it answers; nothing happens when it runs already."""
        if self.running:
            return
        self._prepare()
        with (self.folder / "server.log").open("ab") as log:
            process = subprocess.Popen(
                [str(find_program("setpriv")), "--pdeathsig", self.death_signal, *self._privileges(), *self._command()],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                cwd=self.folder,
                start_new_session=True,  # Ctrl-C in a terminal reaches pytest alone, which then stops the servers
            )
        self._process = process
        deadline = time.monotonic() + START_SECONDS
        while not self._answers():
            if process.poll() is not None:
                raise ServerStartError(f"{self.name} ended with code {process.returncode}:\n{self.log_tail()}")
            if time.monotonic() > deadline:
                self.kill()
                raise ServerStartError(f"{self.name} did not answer within {START_SECONDS:.0f} s:\n{self.log_tail()}")
            time.sleep(POLL_SECONDS)

    def stop(self) -> None:
        """End the server in an orderly way, keeping its data."""
        if self._process is None:
            return
        if self.running:
            self._request_stop()
        try:
            self._process.wait(STOP_SECONDS)
        except subprocess.TimeoutExpired:
            self.kill()
        self._process = None

    def kill(self) -> None:
        """End the server at once, as in a crash: nothing is written any more."""
        if self._process is None:
            return
        if self.running:
            self._process.send_signal(self.kill_signal)
        try:
            self._process.wait(STOP_SECONDS)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._process = None

    def restart(self) -> None:
        """Stop and start; the data stay."""
        self.stop()
        self.start()

    def close(self) -> None:
        """End the server and remove its folder."""
        self.kill()
        shutil.rmtree(self.folder, ignore_errors=True)

    def log_tail(self, lines: int = 20) -> str:
        """Return the last lines that the server wrote."""
        log = self.folder / "server.log"
        return "\n".join(log.read_text(errors="replace").splitlines()[-lines:]) if log.exists() else ""

    def _request_stop(self) -> None:
        if self._process is not None:
            self._process.terminate()

    def _privileges(self) -> list[str]:
        return []

    def __enter__(self) -> Self:
        try:
            self.start()
        except BaseException:
            self.close()
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


class RedisServer(Server):
    """Redis on 127.0.0.1 that writes to disk only at ``restart``, so that a test chooses what survives."""

    name = "redis"
    death_signal = "KILL"
    kill_signal = signal.SIGKILL
    databases: ClassVar[int] = 64

    def __init__(self) -> None:
        super().__init__()
        self._numbers = itertools.cycle(range(1, self.databases))

    @property
    def url(self) -> str:
        """Address of database 0."""
        return self.database_url(0)

    def database_url(self, number: int) -> str:
        """Address of one numbered database."""
        return f"redis://127.0.0.1:{self.port}/{number}"

    def create_database(self) -> str:
        """Empty the next numbered database and return its address."""
        url = self.database_url(next(self._numbers))
        with redis.Redis.from_url(url) as client:
            client.flushdb()
        return url

    def restart(self, *, empty: bool = False) -> None:
        """Stop and start; ``empty`` loses everything that was stored, as a Redis without persistence does."""
        if empty:
            self.kill()
            (self.folder / "dump.rdb").unlink(missing_ok=True)
        elif self.running:
            with redis.Redis.from_url(self.url) as client:
                client.save()
        super().restart()

    def _prepare(self) -> None:
        pass

    def _command(self) -> list[str]:
        options = {
            "--bind": "127.0.0.1",
            "--port": str(self.port),
            "--dir": str(self.folder),
            "--save": "",
            "--appendonly": "no",
            "--databases": str(self.databases),
            "--daemonize": "no",
        }
        return [str(find_program("redis-server")), *itertools.chain.from_iterable(options.items())]

    def _answers(self) -> bool:
        try:
            with redis.Redis(
                host="127.0.0.1", port=self.port, socket_timeout=2.0, retry=Retry(NoBackoff(), 0)
            ) as client:
                return bool(client.ping())
        except (redis.ConnectionError, redis.TimeoutError):
            return False


class PostgresServer(Server):
    """PostgreSQL on 127.0.0.1 with a password.

    The server refuses to run as root; then the unprivileged user of Debian's package, or ``nobody``, owns data and
    process. Without ``durable`` nothing is flushed to the disk: data survive ``kill``, but not a power cut.
    """

    name = "postgres"
    death_signal = "QUIT"  # immediate shutdown of the whole process family
    kill_signal = signal.SIGQUIT  # the same; the next start recovers from the write-ahead log, as after a crash
    user: ClassVar[str] = "geoswarm"

    def __init__(self, *, durable: bool = False) -> None:
        super().__init__()
        self.durable = durable
        self._password = secrets.token_urlsafe(12)
        self._counter = itertools.count(1)
        self._owner = _unprivileged_user() if os.geteuid() == 0 else None
        if self._owner is not None:
            os.chown(self.folder, self._owner.pw_uid, self._owner.pw_gid)

    @property
    def url(self) -> str:
        """SQLAlchemy address of the maintenance database ``postgres``."""
        return self.database_url("postgres")

    def database_url(self, name: str) -> str:
        """SQLAlchemy address of one database."""
        return f"postgresql+psycopg://{self.user}:{self._password}@127.0.0.1:{self.port}/{name}"

    def create_database(self) -> str:
        """Create an empty database and return its address."""
        name = f"test_{next(self._counter)}"
        self._execute(sql.SQL("CREATE DATABASE {}").format(sql.Identifier(name)))
        return self.database_url(name)

    def drop_database(self, url: str) -> None:
        """Drop a database made by ``create_database``, cutting the connections that are left."""
        name = url.rsplit("/", 1)[-1]
        self._execute(sql.SQL("DROP DATABASE IF EXISTS {} WITH (FORCE)").format(sql.Identifier(name)))

    def empty(self, url: str, tables: Sequence[str]) -> None:
        """Cut the connections that are left and delete all rows: a hundredth of the time of another database."""
        name = url.rsplit("/", 1)[-1]
        with psycopg.connect(self._dsn(name), autocommit=True) as connection:
            others = "FROM pg_stat_activity WHERE datname = current_database() AND pid <> pg_backend_pid()"
            connection.execute(f"SELECT pg_terminate_backend(pid) {others}")
            for table in tables[::-1]:
                connection.execute(sql.SQL("DELETE FROM {}").format(sql.Identifier(table)))

    def _execute(self, statement: sql.Composed) -> None:
        with psycopg.connect(self._dsn(), autocommit=True) as connection:
            connection.execute(statement)

    def _dsn(self, name: str = "postgres") -> str:
        return self.database_url(name).replace("+psycopg", "", 1)

    def _prepare(self) -> None:
        data = self.folder / "data"
        if data.exists():
            return
        password_file = self.folder / "password"
        password_file.write_text(self._password + "\n")
        if self._owner is not None:
            os.chown(password_file, self._owner.pw_uid, self._owner.pw_gid)
        initdb = [str(_postgres_program("initdb")), "--pgdata", str(data), "--username", self.user]
        initdb += ["--pwfile", str(password_file), "--auth", "scram-sha-256"]
        initdb += ["--encoding", "UTF8", "--no-locale", "--no-sync"]
        made = subprocess.run(
            [str(find_program("setpriv")), "--pdeathsig", "KILL", *self._privileges(), *initdb],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            cwd=self.folder,
            check=False,
        )
        password_file.unlink()
        if made.returncode != 0:
            shutil.rmtree(data, ignore_errors=True)
            raise ServerStartError(f"initdb ended with code {made.returncode}:\n{made.stdout}{made.stderr}")

    def _command(self) -> list[str]:
        flush = "on" if self.durable else "off"
        settings = {
            "listen_addresses": "127.0.0.1",
            "port": str(self.port),
            "unix_socket_directories": "",
            "max_connections": "200",
            "shared_buffers": "32MB",
            "fsync": flush,
            "synchronous_commit": "on",  # a commit reaches the kernel at least, so that it survives ``kill``
            "full_page_writes": flush,
        }
        options = [f"--{name}={value}" for name, value in settings.items()]
        return [str(_postgres_program("postgres")), "-D", str(self.folder / "data"), *options]

    def _answers(self) -> bool:
        try:
            psycopg.connect(self._dsn(), connect_timeout=2).close()
        except psycopg.OperationalError:
            return False
        return True

    def _request_stop(self) -> None:
        if self._process is not None:
            self._process.send_signal(signal.SIGINT)  # fast shutdown: does not wait for clients

    def _privileges(self) -> list[str]:
        if self._owner is None:
            return []
        return ["--reuid", str(self._owner.pw_uid), "--regid", str(self._owner.pw_gid), "--clear-groups"]


def _postgres_program(name: str) -> Path:
    """Debian keeps the server's programs out of PATH, one folder per major version; the newest comes first."""
    folders = Path("/usr/lib/postgresql").glob("*/bin")
    return find_program(name, sorted(folders, key=lambda folder: (len(folder.parent.name), folder.parent.name))[::-1])


def _unprivileged_user() -> pwd.struct_passwd:
    """Return the account for a server that must not run as root."""
    for name in ("postgres", "nobody"):
        try:
            return pwd.getpwnam(name)
        except KeyError:
            continue
    raise ServerStartError("PostgreSQL refuses to run as root, and there is no user 'postgres' or 'nobody'")
