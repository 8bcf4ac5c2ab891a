"""Models fetched from the service: only what was signed is kept, whatever the service sends."""

from __future__ import annotations

import logging
import os
from pathlib import Path

import httpx
import pytest

from geoswarm.agent.errors import KeyRefusedError
from geoswarm.agent.fetched import FetchedModels
from geoswarm.agent.server import Server
from geoswarm.solver.registered.folders import VARIABLE, version_of
from geoswarm.solver.registered.signed import SignedList, listed
from tests.integration.agents import line_model

SECRET = b"s" * 32


class Service:
    """A service whose answers a test chooses."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.document = SignedList.signed({"line": listed(folder / "line")}, 100, SECRET).document()
        self.files = {file.sha256: folder / "line" / file.path for file in listed(folder / "line").files}
        self.asked: list[str] = []
        self.spoiled: dict[str, bytes] = {}
        self.status = 200

    def sign(self, at: int, secret: bytes = SECRET) -> None:
        self.document = SignedList.signed({"line": listed(self.folder / "line")}, at, secret).document()
        self.files |= {file.sha256: self.folder / "line" / file.path for file in listed(self.folder / "line").files}

    def answer(self, request: httpx.Request) -> httpx.Response:
        path = request.url.path.removeprefix("/api/v1/agents/models")
        self.asked.append(path)
        if self.status != 200:
            return httpx.Response(self.status, json={"type": "urn:geoswarm:error:x", "detail": "told so"})
        if not path:
            return httpx.Response(200, stream=httpx.ByteStream(self.document))
        file = self.files[path.removeprefix("/files/")]
        return httpx.Response(200, stream=httpx.ByteStream(self.spoiled.get(file.name, file.read_bytes())))


@pytest.fixture
def service(tmp_path: Path) -> Service:
    return Service(line_model(tmp_path / "service"))


@pytest.fixture
def fetched(service: Service, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> FetchedModels:
    monkeypatch.delenv(VARIABLE, raising=False)
    server = Server("http://service", None, transport=httpx.MockTransport(service.answer))
    return FetchedModels(tmp_path / "kept", server, SECRET, lambda: False)


def test_what_is_listed_is_fetched_once(fetched: FetchedModels, service: Service, tmp_path: Path) -> None:
    (service.folder / "line" / "run.sh").chmod(0o755)
    service.sign(100)
    version = version_of(service.folder / "line")
    assert fetched.update() == str(tmp_path / "kept" / version)
    assert version_of(tmp_path / "kept" / version / "line") == version
    assert os.access(tmp_path / "kept" / version / "line" / "run.sh", os.X_OK)
    assert len(service.asked) == 4
    assert fetched.update() == str(tmp_path / "kept" / version)
    assert service.asked[4:] == [""]
    names = {path.name.partition("-")[0] for path in (tmp_path / "kept").iterdir()}
    assert names == {version, "seen"}


def test_the_machines_own_models_come_first(
    service: Service, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    own = line_model(tmp_path / "own", seconds=0.7)
    monkeypatch.setenv(VARIABLE, str(own))
    server = Server("http://service", None, transport=httpx.MockTransport(service.answer))
    found = FetchedModels(tmp_path / "kept", server, SECRET, lambda: False).update().split(os.pathsep)
    assert found == [str(own), str(tmp_path / "kept" / version_of(service.folder / "line"))]
    assert "line: this machine has another version of its own, which comes first" in caplog.text


def test_a_new_version_takes_the_place_of_the_old_one(fetched: FetchedModels, service: Service, tmp_path: Path) -> None:
    before = fetched.update()
    (service.folder / "line" / "run.sh").write_text("exit 1\n")
    service.sign(200)
    after = fetched.update()
    assert after == str(tmp_path / "kept" / version_of(service.folder / "line"))
    assert after != before
    assert Path(before).is_dir()  # what runs may need it


@pytest.mark.parametrize("sent", [b"rm -rf ~\n", b"", b"x" * 100_000])
def test_a_file_that_is_not_what_was_signed_is_refused(
    fetched: FetchedModels, service: Service, tmp_path: Path, caplog: pytest.LogCaptureFixture, sent: bytes
) -> None:
    service.spoiled["run.sh"] = sent
    assert fetched.update() == ""
    assert "line: run.sh is not what was signed: the service sent something else" in caplog.text
    assert [path.name for path in (tmp_path / "kept").iterdir() if not path.name.startswith("seen-")] == []
    caplog.clear()
    fetched.update()
    assert caplog.text == ""  # told once
    service.spoiled.clear()
    assert fetched.update() != ""


def test_a_list_of_another_secret_is_refused(
    fetched: FetchedModels, service: Service, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    service.sign(100, b"t" * 32)
    assert fetched.update() == ""
    assert "its signature is not that of this secret" in caplog.text
    assert list((tmp_path / "kept").iterdir()) == []
    assert service.asked == [""]


def test_an_older_list_is_refused_and_the_newest_known_stays(
    fetched: FetchedModels, service: Service, caplog: pytest.LogCaptureFixture
) -> None:
    old = service.document
    (service.folder / "line" / "run.sh").write_text("exit 1\n")
    service.sign(200)
    newest = fetched.update()
    service.document = old
    assert fetched.update() == newest
    assert "older than one that it has sent before" in caplog.text


def test_what_has_changed_on_the_machine_is_fetched_again(fetched: FetchedModels, service: Service) -> None:
    folder = Path(fetched.update()) / "line"
    (folder / "run.sh").write_text("exit 1\n")
    assert fetched.update() == str(folder.parent)
    assert (folder / "run.sh").read_bytes() == (service.folder / "line" / "run.sh").read_bytes()


def test_a_service_that_hands_out_nothing_is_told_of(
    fetched: FetchedModels, service: Service, caplog: pytest.LogCaptureFixture
) -> None:
    service.status = 404
    assert fetched.update() == ""
    assert "models of the service cannot be fetched: 404: told so" in caplog.text


def test_what_was_fetched_stays_when_the_service_does_not_answer(fetched: FetchedModels, service: Service) -> None:
    kept = fetched.update()
    service.status = 503
    assert fetched.update() == kept


def test_a_key_that_is_refused_ends_the_agent(fetched: FetchedModels, service: Service) -> None:
    service.status = 401
    with pytest.raises(KeyRefusedError):
        fetched.update()


def test_who_ends_fetches_nothing(
    service: Service, tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    caplog.set_level(logging.WARNING)
    server = Server("http://service", None, transport=httpx.MockTransport(service.answer))
    assert FetchedModels(tmp_path / "kept", server, SECRET, lambda: True).update() == ""
    assert service.asked == [""]
