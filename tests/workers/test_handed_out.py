"""Models that the service hands out: those of the list, and no other file of the machine."""

from __future__ import annotations

from pathlib import Path

import pytest

from geoswarm.solver.registered.signed import SignedList, listed
from geoswarm.workers.agents.handed_out import HandedOut
from geoswarm.workers.errors import ModelsUnavailableError, NotHandedOutError
from tests.integration.agents import line_model

SECRET = b"s" * 32


@pytest.fixture
def models(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = line_model(tmp_path / "models")
    monkeypatch.setenv("GEOSWARM_MODELS", str(folder))
    return folder


@pytest.fixture
def signed(models: Path, tmp_path: Path) -> Path:
    file = tmp_path / "list.json"
    file.write_bytes(SignedList.signed({"line": listed(models / "line")}, 1, SECRET).document())
    return file


def test_the_list_and_its_files(models: Path, signed: Path) -> None:
    handed_out = HandedOut(signed)
    assert handed_out.document() == signed.read_bytes()
    for file in listed(models / "line").files:
        path = handed_out.file(file.sha256)
        assert path == (models / "line" / file.path).resolve()
        assert file.size == path.stat().st_size


def test_without_a_list_nothing_is_handed_out() -> None:
    with pytest.raises(NotHandedOutError, match="names a signed list with GEOSWARM_SIGNED_MODELS"):
        HandedOut(None).document()
    with pytest.raises(NotHandedOutError):
        HandedOut(None).file("a" * 64)


def test_a_file_that_no_model_of_the_list_has(signed: Path) -> None:
    with pytest.raises(NotHandedOutError, match=f"no file {'a' * 64} belongs"):
        HandedOut(signed).file("a" * 64)


def test_a_file_that_has_changed_since_is_reported(models: Path, signed: Path) -> None:
    handed_out, file = HandedOut(signed), listed(models / "line").files[1]
    text = (models / "line" / file.path).read_text()
    (models / "line" / file.path).write_text("?" + text[1:])
    with pytest.raises(ModelsUnavailableError, match=r"'line': run\.sh has changed since; sign the list again"):
        handed_out.file(file.sha256)
    (models / "line" / file.path).unlink()
    with pytest.raises(ModelsUnavailableError, match=r"run\.sh cannot be read"):
        handed_out.file(file.sha256)


def test_a_new_list_is_taken_up(models: Path, signed: Path) -> None:
    handed_out = HandedOut(signed)
    handed_out.document()
    (models / "line" / "run.sh").write_text("exit 1\n")
    signed.write_bytes(SignedList.signed({"line": listed(models / "line")}, 2, SECRET).document() + b"\n")
    assert handed_out.file(listed(models / "line").files[1].sha256).read_text() == "exit 1\n"
    signed.write_bytes(b"half a li")
    with pytest.raises(ModelsUnavailableError, match="the list of models cannot be read"):
        handed_out.document()
    signed.unlink()
    with pytest.raises(ModelsUnavailableError, match="No such file"):
        handed_out.document()
