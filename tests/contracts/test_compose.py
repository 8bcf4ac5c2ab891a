"""docker-compose.yml is what the compose specification admits, and agrees with Dockerfile and command line.

The specification is checked by compose-spec (Python bindings of a strict parser that refuses unknown keys), with merged
anchors and filled-in variables, as docker compose does before it looks at the file.
"""

from __future__ import annotations

import copy
import json
import re
import shutil
import subprocess
import time
from pathlib import Path
from typing import Any

import click
import psycopg
import pytest
from compose_spec import PyCompose

from geoswarm.cli import cli
from geoswarm.workers.settings import Settings
from geoswarm.workers.store.database import _create_engine
from tests.contracts.repository import PACKAGES, ROOT, project
from tests.deployment.composition import FOREIGN, OWN, VARIABLE, compose, interpolated, service
from tests.deployment.dockerfile import read_dockerfile
from tests.servers import PostgresServer, find_program, free_port

SECRETS = {"database_url", "broker_url", "api_key", "postgres_password", "redis.conf"}
VARIABLES_WITH_FILE = {"GEOSWARM_DATABASE_URL_FILE", "GEOSWARM_BROKER_URL_FILE", "GEOSWARM_API_KEY_FILE"}
MAKE_SECRETS = ROOT / "deploy" / "make_secrets.sh"


def texts(node: Any) -> list[str]:
    """Return all texts below a node."""
    if isinstance(node, dict):
        return [text for value in node.values() for text in texts(value)]
    if isinstance(node, list):
        return [text for value in node for text in texts(value)]
    return [str(node)]


def parsed(arguments: list[str]) -> click.Context:
    """Let click parse a command with its options, without running it; raises UsageError for what does not exist."""
    context = cli.make_context("geoswarm", list(arguments))
    name, command, rest = cli.resolve_command(context, [*context._protected_args, *context.args])
    assert command is not None
    return command.make_context(name, rest, parent=context)


def specification(document: dict[str, Any]) -> list[str]:
    """Let the parser of the specification read a document; ValueError tells what is wrong."""
    names: list[str] = PyCompose.from_yaml(json.dumps(document)).service_names()
    return names


def test_the_file_is_what_the_compose_specification_admits() -> None:
    assert specification(interpolated(compose())) == [*OWN, *FOREIGN]


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("services.api.instructions", ["serve"]),
        ("services.api.read_only", "perhaps"),
        ("services.api.restart", "sometimes"),
        ("services.api.tmpfs", ["tmp"]),
        ("services.api.healthcheck.interval", "5 apples"),
        ("services.api.deploy.resources.limits.memori", "1g"),
        ("services.api.deploy.resources.limits.cpus", "some"),
        ("services.api.depends_on", {"redis": {"condition": "service_ok"}}),
        ("secrets.api_key", {"fil": "./secrets/api_key"}),
        ("nonsense", 1),
    ],
)
def test_the_check_of_the_specification_refuses_mistakes(path: str, value: Any) -> None:
    document = copy.deepcopy(interpolated(compose()))
    *above, last = path.split(".")
    node = document
    for name in above:
        node = node[name]
    node[last] = value
    with pytest.raises(ValueError, match=r"\w"):
        specification(document)


def test_services_are_the_parts_of_the_system() -> None:
    assert set(compose()["services"]) == {*OWN, *FOREIGN}


@pytest.mark.parametrize("name", OWN)
def test_command_and_its_options_exist(name: str) -> None:
    arguments = list(service(name).command)
    assert parsed(arguments).info_name == arguments[0]


def test_the_check_of_commands_refuses_what_does_not_exist() -> None:
    for arguments in (["sweeep"], ["worker", "--no-such-option"], ["worker", "--concurrency", "many"]):
        with pytest.raises(click.UsageError):
            parsed(arguments)


@pytest.mark.parametrize("name", OWN)
def test_environment_is_what_the_commands_read_and_secrets_are_files(name: str) -> None:
    section = service(name)
    context = parsed(list(section.command))
    read = {option.envvar for option in context.command.params if isinstance(option, click.Option) and option.envvar}
    assert {variable.removesuffix("_FILE") for variable in section.environment} <= read
    files = {variable: value for variable, value in section.environment.items() if variable.endswith("_FILE")}
    assert set(files) <= VARIABLES_WITH_FILE
    assert sorted(files.values()) == sorted(f"/run/secrets/{secret}" for secret in section.secrets)
    assert "GEOSWARM_DATABASE_URL_FILE" in files


def test_every_name_of_the_file_leads_somewhere() -> None:
    document = compose()
    assert {path["file"] for path in document["secrets"].values()} == {f"./secrets/{name}" for name in SECRETS}
    for name, section in document["services"].items():
        assert set(section.get("secrets", [])) <= set(document["secrets"]), name
        for text in texts([section["command"], section.get("environment", {}), section["healthcheck"]]):
            used = set(re.findall(r"/run/secrets/([\w.]+)", text))
            assert used <= set(section.get("secrets", [])), name
        for volume in section.get("volumes", []):
            assert volume.partition(":")[0] in document["volumes"], name
        for needed, how in section.get("depends_on", {}).items():
            assert needed in document["services"], name
            assert how["condition"] == "service_healthy", name
    for name in OWN:
        assert set(document["services"][name]["depends_on"]) == set(FOREIGN)


def test_an_api_for_other_machines_has_a_key() -> None:
    section = compose()["services"]["api"]
    assert section["command"][section["command"].index("--host") + 1] == "0.0.0.0"
    assert section["environment"]["GEOSWARM_API_KEY_FILE"] == "/run/secrets/api_key"
    assert all(interpolated(port).startswith("127.0.0.1:") for port in section["ports"])


@pytest.mark.parametrize("name", [*OWN, *FOREIGN])
def test_containers_are_bounded_and_watched(name: str) -> None:
    section = interpolated(compose())["services"][name]
    assert section["healthcheck"]["test"][0] in ("CMD", "CMD-SHELL")
    assert {"interval", "timeout", "retries"} <= set(section["healthcheck"])
    limits = section["deploy"]["resources"]["limits"]
    assert float(limits["cpus"]) > 0
    assert re.fullmatch(r"\d+[mg]", limits["memory"])
    assert limits["pids"] > 0
    assert section["read_only"] is True
    assert "no-new-privileges:true" in section["security_opt"]


@pytest.mark.parametrize("name", OWN)
def test_own_containers_may_write_to_tmp_only(name: str) -> None:
    section = compose()["services"][name]
    assert [entry.partition(":")[0] for entry in section["tmpfs"]] == ["/tmp"]
    assert "volumes" not in section
    assert section["cap_drop"] == ["ALL"]


def test_a_worker_container_has_a_processor_for_each_process() -> None:
    worker = compose()["services"]["worker"]
    assert worker["command"][-1] == worker["deploy"]["resources"]["limits"]["cpus"]


def test_the_api_health_check_is_a_program_that_asks_a_known_route() -> None:
    words = service("api").healthcheck
    assert words[:2] == ("python", "-c")
    compile(words[2], "healthcheck", "exec")
    assert f"http://127.0.0.1:{service('api').command[-1]}/health/ready" in words[2]


def test_the_prune_service_is_daily_like_the_timer() -> None:
    words = list(service("prune").command)
    unit = (ROOT / "deploy" / "systemd" / "geoswarm-prune.service").read_text(encoding="utf-8")
    assert words[words.index("--every") + 1] == "24h"
    assert f"prune --older-than {words[words.index('--older-than') + 1]}\n" in unit


def test_the_example_names_all_variables_and_no_secret() -> None:
    used = {match["name"]: match["rest"] for text in texts(compose()) for match in VARIABLE.finditer(text)}
    assert not [text for text in texts(compose()) if re.search(r"(?<!\$)\$(?!\$)(?!\{\w+:-)", text.replace("$$", ""))]
    example = (ROOT / ".env.example").read_text(encoding="utf-8")
    named = dict(re.findall(r"^#?([A-Z_]+)=(.*)$", example, flags=re.MULTILINE))
    assert named == used
    assert not [name for name in named if re.search(r"PASSWORD|KEY|SECRET|URL", name)]


def test_the_script_makes_the_secrets_that_fit_each_other(tmp_path: Path) -> None:
    folder = tmp_path / "secrets"
    subprocess.run([str(MAKE_SECRETS), str(folder)], check=True, capture_output=True)
    found = {path.name: path.read_text(encoding="utf-8").strip() for path in folder.iterdir()}
    assert set(found) == SECRETS
    assert folder.stat().st_mode & 0o777 == 0o700
    assert {path.stat().st_mode & 0o777 for path in folder.iterdir()} == {0o444}
    password = found["redis.conf"].removeprefix("requirepass ")
    assert found["broker_url"] == f"redis://:{password}@redis:6379/0"
    assert found["database_url"] == f"postgresql://geoswarm:{found['postgres_password']}@postgres:5432/geoswarm"
    assert len({password, found["api_key"], found["postgres_password"]}) == 3
    assert min(map(len, (password, found["api_key"], found["postgres_password"]))) == 48
    again = subprocess.run([str(MAKE_SECRETS), str(folder)], check=False, capture_output=True, text=True)
    assert again.returncode == 1
    assert "left as they are" in again.stderr
    assert {path.name: path.read_text(encoding="utf-8").strip() for path in folder.iterdir()} == found


def test_secrets_are_kept_from_git_and_from_the_image() -> None:
    for path in ("secrets/api_key", ".env", "deploy/.env"):
        done = subprocess.run(["git", "check-ignore", "--quiet", path], cwd=ROOT, check=False)
        assert done.returncode == 0, path
    assert "!secrets" not in (ROOT / ".dockerignore").read_text(encoding="utf-8")


def test_redis_starts_and_is_healthy_by_its_command(tmp_path: Path) -> None:
    """With this machine's Redis; the secret is where the compose file looks for it, but below a folder."""
    (tmp_path / "redis.conf").write_text("requirepass 8f3b1d0e52a94c7788\n")
    section, port = service("redis"), free_port()
    here = [word.replace("/run/secrets", str(tmp_path)) for word in section.command]
    check = [
        word.replace("/run/secrets", str(tmp_path)).replace("redis-cli", f"redis-cli -p {port}")
        for word in section.healthcheck
    ]
    command = [
        str(find_program("redis-server")),
        *here[1:],
        "--port",
        str(port),
        "--bind",
        "127.0.0.1",
        "--dir",
        str(tmp_path),
    ]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as process:
        try:
            deadline = time.monotonic() + 60
            while subprocess.run(check, capture_output=True, check=False).returncode != 0:
                assert process.poll() is None
                assert time.monotonic() < deadline
                time.sleep(0.1)
            (tmp_path / "redis.conf").write_text("requirepass another\n")
            assert subprocess.run(check, capture_output=True, check=False).returncode != 0
        finally:
            process.terminate()
    assert shutil.which("redis-cli")


def test_postgresql_knows_its_settings(postgres_server: PostgresServer) -> None:
    words = service("postgres").command
    settings = dict(word.split("=") for word in words if "=" in word)
    with psycopg.connect(postgres_server.url.replace("+psycopg", "")) as connection:
        for name, value in settings.items():
            row = connection.execute("SELECT min_val, max_val FROM pg_settings WHERE name = %s", [name]).fetchone()
            assert row is not None, name
            assert int(row[0]) <= int(value) <= int(row[1])


def test_the_database_admits_the_connections_of_the_workers_that_the_documentation_promises() -> None:
    """One service with its whole pool and listener, five for the rest, three for each worker process."""
    engine = _create_engine(Settings(database_url="postgresql://u:p@127.0.0.1/jobs"))
    service_takes = engine.pool.size() + engine.pool._max_overflow + 1  # type: ignore[attr-defined]  # QueuePool
    page = (ROOT / "docs" / "operations.md").read_text(encoding="utf-8")
    assert f"(connections - 3 - {service_takes} for each service - 5) / 3" in page
    ((first, connections, second, more),) = re.findall(
        r"(\d+) worker processes fit\s+into (\d+) connections, and (\d+)\s+into (\d+)", page
    )
    assert f"max_connections={connections}" in service("postgres").command
    for count, admitted in ((first, connections), (second, more)):
        assert int(count) == (int(admitted) - 3 - service_takes - 5) // 3


def test_images_are_pinned_to_a_minor_version_and_a_release_of_debian() -> None:
    services = compose()["services"]
    assert {services[name]["image"] for name in OWN} == {f"geoswarm:{project()['project']['version']}"}
    for name in FOREIGN:
        assert re.fullmatch(rf"{name}:\d+\.\d+(\.\d+)?-(bookworm|trixie)", services[name]["image"]), name
    bases = {stage.base for stage in read_dockerfile((ROOT / "Dockerfile").read_text(encoding="utf-8"))}
    (base,) = bases
    assert re.fullmatch(r"python:3\.1[123]\.\d+-slim-(bookworm|trixie)", base)


def test_the_image_installs_the_locked_versions_and_copies_what_exists() -> None:
    build, final = read_dockerfile((ROOT / "Dockerfile").read_text(encoding="utf-8"))
    pip = [line for line in build.runs if "pip install" in line]
    assert "--require-hashes -r requirements/image.txt" in pip[0]
    assert "--no-deps --no-build-isolation ." in pip[1]
    copied = [
        source
        for stage in (build, final)
        for instruction in stage.instructions
        if instruction.keyword == "COPY" and not instruction.text.startswith("--from")
        for source in instruction.words[:-1]
    ]
    assert {*PACKAGES, "examples", "hatch_build.py", "THIRD-PARTY-LICENSES.md"} < set(copied)
    assert [source for source in copied if not (ROOT / source).exists()] == []
    assert final.last("USER") == ["geoswarm"]
