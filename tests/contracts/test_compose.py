"""docker-compose.yml, Dockerfile and the command line agree with each other."""

from __future__ import annotations

import re
import shlex
from typing import Any

import click
import pytest
from ruamel.yaml import YAML

from geoswarm.cli import cli
from tests.contracts.repository import PACKAGES, ROOT

VARIABLE = re.compile(r"\$\{(?P<name>\w+)(?P<kind>:-|:\?)?(?P<rest>[^}]*)\}")
OWN = ("api", "worker", "sweep")
FOREIGN = ("postgres", "redis")
SECRETS = {"POSTGRES_PASSWORD", "REDIS_PASSWORD", "GEOSWARM_API_KEY"}


def compose() -> dict[str, Any]:
    document: dict[str, Any] = YAML(typ="safe").load((ROOT / "docker-compose.yml").read_text(encoding="utf-8"))
    return document


def interpolated(value: str) -> str:
    """Put in what docker compose would: the default, or some word for a required variable."""
    return VARIABLE.sub(lambda match: match["rest"] if match["kind"] == ":-" else "given", value)


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


def test_services_are_the_parts_of_the_system() -> None:
    assert set(compose()["services"]) == {*OWN, *FOREIGN}


@pytest.mark.parametrize("service", OWN)
def test_command_and_its_options_exist(service: str) -> None:
    arguments = [interpolated(word) for word in compose()["services"][service]["command"]]
    context = parsed(arguments)
    assert context.info_name == arguments[0]


def test_the_check_of_commands_refuses_what_does_not_exist() -> None:
    for arguments in (["sweeep"], ["worker", "--no-such-option"], ["worker", "--concurrency", "many"]):
        with pytest.raises(click.UsageError):
            parsed(arguments)


@pytest.mark.parametrize("service", OWN)
def test_environment_is_what_the_commands_read(service: str) -> None:
    section = compose()["services"][service]
    context = parsed([interpolated(word) for word in section["command"]])
    read = {option.envvar for option in context.command.params if isinstance(option, click.Option) and option.envvar}
    assert set(section["environment"]) <= read
    assert {"GEOSWARM_DATABASE_URL", "GEOSWARM_BROKER_URL"} <= set(section["environment"])


def test_an_api_for_other_machines_has_a_key() -> None:
    section = compose()["services"]["api"]
    assert section["command"][section["command"].index("--host") + 1] == "0.0.0.0"
    assert section["environment"]["GEOSWARM_API_KEY"].startswith("${GEOSWARM_API_KEY:?")
    assert all(interpolated(port).startswith("127.0.0.1:") for port in section["ports"])


def test_own_services_wait_for_healthy_servers() -> None:
    services = compose()["services"]
    for name in OWN:
        assert services[name]["depends_on"] == {server: {"condition": "service_healthy"} for server in FOREIGN}
    for name, section in services.items():
        for needed, how in section.get("depends_on", {}).items():
            assert needed in services, name
            assert how["condition"] != "service_healthy" or "healthcheck" in services[needed], name


@pytest.mark.parametrize("service", [*OWN, *FOREIGN])
def test_health_checks_are_bounded(service: str) -> None:
    check = compose()["services"][service]["healthcheck"]
    assert check["test"][0] == "CMD"
    assert {"interval", "timeout", "retries"} <= set(check)


def test_the_api_health_check_is_a_program_that_asks_a_known_route() -> None:
    words = compose()["services"]["api"]["healthcheck"]["test"]
    assert words[1:3] == ["python", "-c"]
    compile(words[3], "healthcheck", "exec")
    port = compose()["services"]["api"]["command"][-1]
    assert f"http://127.0.0.1:{port}/health/ready" in words[3]


def test_the_addresses_name_services_of_the_file() -> None:
    environment = compose()["services"]["worker"]["environment"]
    assert re.search(r"@postgres:5432/", environment["GEOSWARM_DATABASE_URL"])
    assert re.search(r"@redis:6379/", environment["GEOSWARM_BROKER_URL"])


def test_no_secret_has_a_default_and_the_example_names_all_variables() -> None:
    used: dict[str, set[str]] = {}
    for text in texts(compose()["services"]):
        for match in VARIABLE.finditer(text):
            used.setdefault(match["name"], set()).add(match["kind"])
    assert {name for name, kinds in used.items() if kinds == {":?"}} == SECRETS
    assert all(kinds in ({":?"}, {":-"}) for kinds in used.values())
    example = (ROOT / ".env.example").read_text(encoding="utf-8")
    named = dict(re.findall(r"^#?([A-Z_]+)=(.*)$", example, flags=re.MULTILINE))
    assert set(named) == set(used)
    assert {name for name, value in named.items() if not value} == SECRETS


def test_foreign_images_are_pinned_to_a_major_version() -> None:
    for name in FOREIGN:
        assert re.fullmatch(r"[a-z]+:\d+(\.\d+)*(-\w+)?", compose()["services"][name]["image"]), name
    bases = re.findall(r"^FROM (\S+)", (ROOT / "Dockerfile").read_text(encoding="utf-8"), flags=re.MULTILINE)
    assert bases
    assert all(re.fullmatch(r"python:3\.1[123]-slim", base) for base in bases)


def test_the_image_copies_what_exists_and_what_the_build_may_see() -> None:
    dockerfile = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    copied = [
        source
        for line in re.findall(r"^COPY (?!--from)(.+)$", dockerfile, flags=re.MULTILINE)
        for source in shlex.split(line)[:-1]
    ]
    allowed = re.findall(r"^!(\S+)$", (ROOT / ".dockerignore").read_text(encoding="utf-8"), flags=re.MULTILINE)
    assert set(PACKAGES) < set(copied)
    assert [source for source in copied if not (ROOT / source).exists()] == []
    assert sorted(copied) == sorted(allowed)
    assert re.search(r"^USER geoswarm$", dockerfile, flags=re.MULTILINE)
