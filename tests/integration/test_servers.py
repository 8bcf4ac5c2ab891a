"""The test servers themselves: they come up, survive what tests do to them, and never outlive their starter."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from pathlib import Path

import psycopg
import pytest
import redis

from tests.integration.engines import wait_for
from tests.servers import MissingServerError, PostgresServer, RedisServer, Server, ServerStartError, find_program

REPOSITORY = Path(__file__).parents[2]


def connect(url: str) -> psycopg.Connection[tuple[object, ...]]:
    return psycopg.connect(url.replace("+psycopg", ""), autocommit=True, connect_timeout=2)


def alive(pid: int) -> bool:
    """Whether a process runs; one that ended but was not yet reaped does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_free_port_can_be_bound_and_is_outside_the_range_of_outgoing_connections(free_port: int) -> None:
    lowest = int(Path("/proc/sys/net/ipv4/ip_local_port_range").read_text().split()[0])
    assert 1024 < free_port < lowest
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", free_port))
        assert listener.getsockname() == ("127.0.0.1", free_port)


def test_postgres_listens_on_loopback_with_a_password(postgres_server: PostgresServer, postgres_url: str) -> None:
    with connect(postgres_url) as connection:
        addresses = connection.execute("SHOW listen_addresses").fetchone()
        sockets = connection.execute("SHOW unix_socket_directories").fetchone()
    assert (addresses, sockets) == (("127.0.0.1",), ("",))
    with pytest.raises(psycopg.OperationalError, match="password authentication failed"):
        connect(postgres_url.replace(postgres_server._password, "wrong"))


def test_fresh_databases_are_separate_and_can_be_emptied(postgres_server: PostgresServer) -> None:
    first = postgres_server.create_database()
    with connect(first) as connection:
        connection.execute("CREATE TABLE note (text TEXT)")
        connection.execute("INSERT INTO note VALUES ('kept')")
    second = postgres_server.create_database()
    with connect(second) as connection:
        assert connection.execute("SELECT tablename FROM pg_tables WHERE schemaname = 'public'").fetchall() == []
    left = connect(first)  # a connection that is still open keeps no database from being emptied or dropped
    left.execute("BEGIN")
    left.execute("LOCK TABLE note")
    postgres_server.empty(first, ["note"])
    left.close()
    with connect(first) as connection:
        assert connection.execute("SELECT count(*) FROM note").fetchone() == (0,)
        for url in (first, second):
            postgres_server.drop_database(url)
    with pytest.raises(psycopg.OperationalError, match="does not exist"):
        connect(first)


@pytest.mark.parametrize("ending", ["restart", "kill"])
def test_postgres_keeps_its_data_and_address(
    fresh_postgres_url: str, postgres_server: PostgresServer, ending: str
) -> None:
    with connect(fresh_postgres_url) as connection:
        connection.execute("CREATE TABLE note AS SELECT 'kept' AS text")
    pid = postgres_server.pid
    if ending == "restart":
        postgres_server.restart()
    else:
        postgres_server.kill()
        assert not postgres_server.running
        with pytest.raises(psycopg.OperationalError):
            connect(fresh_postgres_url)
        postgres_server.start()
    assert postgres_server.pid != pid
    with connect(fresh_postgres_url) as connection:
        assert connection.execute("SELECT text FROM note").fetchall() == [("kept",)]


def test_durable_postgres_flushes() -> None:
    with PostgresServer(durable=True) as server, connect(server.url) as connection:
        assert connection.execute("SHOW fsync").fetchone() == ("on",)


def test_redis_databases_are_separate(redis_server: RedisServer, fresh_redis_url: str) -> None:
    other = redis_server.create_database()
    assert other != fresh_redis_url
    with redis.Redis.from_url(fresh_redis_url) as client, redis.Redis.from_url(other) as neighbour:
        client.set("word", "kept")
        assert neighbour.get("word") is None
        assert client.config_get("bind") == {b"bind": b"127.0.0.1"} or client.config_get("bind") == {
            "bind": "127.0.0.1"
        }


@pytest.mark.parametrize(("empty", "found"), [(False, b"kept"), (True, None)])
def test_redis_restart_keeps_or_loses_what_was_stored(
    fresh_redis_url: str, redis_server: RedisServer, empty: bool, found: bytes | None
) -> None:
    with redis.Redis.from_url(fresh_redis_url) as client:
        client.set("word", "kept")
    redis_server.restart(empty=empty)
    with redis.Redis.from_url(fresh_redis_url) as client:
        assert client.get("word") == found


def test_stopped_redis_refuses_and_comes_back(fresh_redis_url: str, redis_server: RedisServer) -> None:
    redis_server.stop()
    redis_server.stop()
    with redis.Redis.from_url(fresh_redis_url) as client:
        with pytest.raises(redis.ConnectionError):
            client.ping()
        redis_server.start()
        redis_server.start()
        assert client.ping()


@pytest.mark.parametrize("kind", [PostgresServer, RedisServer])
def test_closing_leaves_neither_process_nor_folder(kind: type[Server]) -> None:
    with kind() as server:
        pid, folder = server.pid, server.folder
        assert pid is not None
        assert folder.is_dir()
    assert not alive(pid)
    assert not folder.exists()


@pytest.mark.parametrize("kind", ["PostgresServer", "RedisServer"])
def test_server_ends_with_a_killed_test_run(kind: str) -> None:
    program = (
        f"import time; from tests.servers import {kind} as S; s = S(); s.start(); print(s.pid, s.folder, flush=True)"
    )
    with subprocess.Popen(
        [sys.executable, "-c", f"{program}; time.sleep(600)"], cwd=REPOSITORY, stdout=subprocess.PIPE, text=True
    ) as starter:
        assert starter.stdout is not None
        pid, folder = starter.stdout.readline().split()
        assert alive(int(pid))
        os.kill(starter.pid, signal.SIGKILL)
    wait_for(lambda: not alive(int(pid)), "the end of the server")
    subprocess.run(["rm", "-rf", folder], check=True)


def test_missing_program_names_the_packages(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(
        MissingServerError, match=r"'redis-server' was not found.*apt-get install .*postgresql redis-server"
    ):
        find_program("redis-server")


def test_early_end_shows_the_log(monkeypatch: pytest.MonkeyPatch) -> None:
    command = RedisServer._command
    monkeypatch.setattr(RedisServer, "_command", lambda server: [*command(server), "--no-such-option", "1"])
    with pytest.raises(ServerStartError, match=r"redis ended with code 1:[\s\S]*no-such-option"), RedisServer():
        pass
