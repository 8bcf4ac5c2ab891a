"""Blocks for which a service runs: HTTP, hooks, keys, retention, and what reads a job that has ended."""

from __future__ import annotations

import json
import re
import sqlite3
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest

from scripts.reader import Reader
from tests.api.conftest import wait_until
from tests.contracts.repository import ROOT
from tests.documentation.pages import block
from tests.documentation.service import USUAL, followed, serving, write_line_problem
from tests.workers.notices.conftest import LOOPBACK, receiving

pytestmark = pytest.mark.slow  # tests/api asks the same of the same routes

HTTP = "docs/http-api.md"
REPORT = "docs/report.md"


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Reader, str]]:
    folder = tmp_path_factory.mktemp("service")
    write_line_problem(folder)
    given = {"GEOSWARM_HOOK_NETWORKS": ",".join(LOOPBACK), "GEOSWARM_SMTP_HOST": "127.0.0.1"}
    with serving(folder, given | {"GEOSWARM_MAIL_FROM": "geoswarm@example.org"}) as running:
        yield running


@pytest.fixture(scope="module")
def job(service: tuple[Reader, str]) -> str:
    """A job that has ended."""
    printed = service[0].shell("geoswarm submit problem.yaml --watch --json")
    return str(json.loads(printed.splitlines()[-1])["id"]) if printed.startswith("{") else latest(service[1])


def latest(url: str) -> str:
    return str(httpx.get(f"{url}/api/v1/jobs").json()["items"][0]["id"])


def test_jobs_over_http(service: tuple[Reader, str], job: str) -> None:
    """What is answered has the members that are shown; of the objects, whose end is left open, at least those."""
    reader, url = service
    commands = re.findall(r"^\$ (.*)\n(.*)$", block(HTTP, "--data @problem.json").text, re.MULTILINE)
    assert len(commands) == 2
    for command, told in commands:
        answer = json.loads(reader.shell(command.replace(USUAL, url).replace("6f0c…", job)))
        shown = json.loads(re.sub(r"(, )?…(?=[},])", "", told).replace("…", ""))
        assert shown.keys() <= answer.keys()
        assert {name: type(answer[name]) for name in shown} == {name: type(value) for name, value in shown.items()}
    (inline,) = re.findall(r".*curl.*", block("docs/command-line.md", "geoswarm inline").text)
    assert json.loads(reader.shell(inline.replace(USUAL, url).replace("curl", "curl -s")))["state"] == "queued"


def test_a_file_is_attached_as_the_page_shows(service: tuple[Reader, str], job: str) -> None:
    reader, url = service
    (reader.folder / "specimen.jpg").write_bytes(b"\xff\xd8\xff\xe0 a photo")
    command, told = block(HTTP, "specimen.jpg").text.removeprefix("$ ").splitlines()
    answer = json.loads(reader.shell(command.replace(USUAL, url).replace("6f0c…", job)))
    assert answer.keys() == json.loads(told).keys()
    assert (answer["name"], answer["media_type"]) == ("specimen.jpg", "image/jpeg")


def test_points_are_read_as_the_page_does(service: tuple[Reader, str], job: str) -> None:
    body = httpx.get(f"{service[1]}/api/v1/jobs/{job}/points").content
    (service[0].folder / "points.bin").write_bytes(body)
    before = "import json, numpy\nbody = open('points.bin', 'rb').read()\n"
    after = "print(head['count'], values.size // head['count'], values.size % head['count'])"
    printed = service[0].python(before + block(HTTP, "numpy.frombuffer").text + after)
    assert printed == "60 6 0\n"  # generation, particle, objective, a, b, misfit.y


def test_events_have_the_form_and_members_of_the_page(service: tuple[Reader, str], job: str) -> None:
    form = re.compile(r"^id: \d+\nevent: (\w+)\ndata: (.*)$", re.MULTILINE)
    with httpx.stream("GET", f"{service[1]}/api/v1/jobs/{job}/events") as stream:
        sent = dict(form.findall(stream.read().decode()))
    told = dict(form.findall(block(HTTP, "event: generation").text.replace("{…}", "{}")))
    assert told.keys() == {"generation", "state"}
    for kind, data in told.items():
        assert json.loads(data).keys() <= json.loads(sent[kind]).keys()


def test_a_mistake_is_answered_as_the_page_shows(service: tuple[Reader, str]) -> None:
    document = json.loads((service[0].folder / "problem.json").read_text())
    document["parameters"]["a"]["lower"] = "low"
    answer = httpx.post(f"{service[1]}/api/v1/jobs", json=document)
    told, sent = json.loads(block(HTTP, "urn:geoswarm:error").text), answer.json()
    assert (sent["type"], sent["title"], sent["status"]) == (told["type"], told["title"], told["status"])
    assert answer.status_code == told["status"]
    assert sent.keys() == told.keys()
    assert sent["issues"][0].keys() == told["issues"][0].keys()
    assert sent["issues"][0]["path"] == told["issues"][0]["path"].replace(".c.", ".a.")


def test_hooks_are_made_tried_and_removed(service: tuple[Reader, str]) -> None:
    reader, _ = service
    page = block("docs/watching.md", "--notify https").text
    told, ending = page[: page.index("geoswarm hooks test")], page[page.index("geoswarm hooks test") :]
    with receiving() as receiver:
        printed = reader.shell(told.replace("https://example.org/hook", receiver.url))
        assert printed.count("signed with whsec_") == 2
        hook = json.loads(reader.shell("geoswarm hooks list --json"))["items"][0]["id"]
        assert re.search(rf"{hook}|{receiver.url}", printed)
        # The hook is that of the job: removed before the job has ended, it would never be notified.
        wait_until(lambda: any(sent["type"] == "job.finished" for sent in receiver.documents()))
        reader.shell(ending.replace("ID", hook))
        assert hook not in reader.shell("geoswarm hooks list")
    number = [sent["type"] for sent in receiver.documents()].index("job.finished")
    headers, _, body = block("docs/watching.md", "POST /hook").text.partition("\n\n")
    assert set(re.findall(r"^([a-z-]+): ", headers, re.MULTILINE)) <= receiver.headers[number].keys()
    told, sent = json.loads(body), receiver.documents()[number]
    assert told.keys() == sent.keys()
    assert told["data"].keys() == sent["data"].keys()
    assert told["type"] == sent["type"]


def test_jobs_that_ended_long_ago_are_pruned(service: tuple[Reader, str], job: str) -> None:
    reader, url = service
    with sqlite3.connect(reader.folder / "geoswarm.db") as database:
        database.execute("UPDATE jobs SET finished_at = finished_at - 1e8 WHERE id = ?", [job])
    printed = reader.shell(block("docs/operations.md", "geoswarm prune").text)
    assert re.findall(r"^(\d+) jobs?", printed, re.MULTILINE) == ["1", "1", "0"]
    assert httpx.get(f"{url}/api/v1/jobs/{job}").status_code == 404


@pytest.mark.parametrize("page", ["docs/security.md", "docs/agents.md"])
def test_keys_are_made_and_revoked(page: str, tmp_path: Path) -> None:
    """On a database of its own: the first key would close the service of the other tests."""
    with Reader(tmp_path, {"GEOSWARM_DATABASE_URL": f"sqlite:///{tmp_path}/geoswarm.db"}) as reader:
        text = block(page, "geoswarm keys create").text
        making, _, revoking = text.partition("geoswarm keys revoke ")
        printed = reader.shell(making)
        keys = re.findall(r"gsw_(\w+?)_[\w-]+", printed)
        assert len(keys) == text.count("keys create")
        if revoking:
            reader.shell(f"geoswarm keys revoke {keys[0]}")
            assert re.search(rf"{keys[0]} .*revoked", reader.shell("geoswarm keys list"))


def test_reports_and_follow_ups_of_a_job(tmp_path: Path) -> None:
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    with serving(tmp_path) as (reader, _):
        reader.shell("geoswarm submit examples/oedometer/problem.yaml --watch")
        followed(reader, block(REPORT, "geoswarm report latest"))
        assert (tmp_path / "output" / "oedometer" / "report.html").is_file()
        reader.python(
            "from geoswarm import Client\nwith Client() as client:\n    job = list(client.iterate_jobs())[-1]\n"
        )
        followed(reader, block(REPORT, "client.reweight"))
        followed(reader, block(REPORT, "client.posterior"))
        assert reader.python("print(job.state)") == "finished\n"
