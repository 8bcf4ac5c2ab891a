"""A registered model is looked at once a version, and each change of its files is a version of its own."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.external.runs import fingerprints
from geoswarm.solver.registered import model as module
from geoswarm.solver.registered.declaration import Declared, read_declaration
from geoswarm.solver.registered.spec import RegisteredSpec
from tests.solver.external.runs.test_fingerprints import change
from tests.solver.external.zoo import register

SPEC = RegisteredSpec(kind="registered", model="good")


@pytest.fixture
def good(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of a registered model; its files are settled at once."""
    register(tmp_path)
    monkeypatch.setenv("GEOSWARM_MODELS", str(tmp_path))
    monkeypatch.setattr(fingerprints, "SETTLED_SECONDS", -3600.0)
    return tmp_path / "good"


@pytest.fixture
def built(monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """Folders of which a forward model was built to know its series."""
    found: list[Path] = []
    really = module.program_of

    def counted(folder: Path, *given: Any) -> Any:
        found.append(folder)
        return really(folder, *given)

    monkeypatch.setattr(module, "program_of", counted)
    return found


def completed() -> RegisteredSpec:
    """The section with version, parameters and series."""
    return SPEC.with_files(None, "forward_model")


def test_a_version_is_looked_at_once(good: Path, built: list[Path]) -> None:
    first = completed()
    assert [completed() for _ in range(5)] == [first] * 5
    assert first.with_files(None, "forward_model") == first
    assert built == [good]


def test_each_change_is_seen_at_once(good: Path, built: list[Path]) -> None:
    first = completed()
    change(good / "zoo.py", (good / "zoo.py").read_text() + "# changed\n")
    second = completed()
    assert second.version != first.version
    assert "its files have changed" in (first.unavailable() or "")

    description = (good / "model.yaml").read_text()
    change(good / "model.yaml", description.replace("upper: 10", "upper: 11"))
    assert completed().declared != first.declared
    change(good / "model.yaml", description)
    assert completed() == second

    change(good / "input.in", "{{slop}}\n")
    for _ in range(2):
        with pytest.raises(ProblemError, match=r"model.yaml: parameters.slop: is used, but not declared"):
            completed()
    change(good / "input.in", "{{slope}}\n")
    assert completed() == second
    assert len(built) == 5  # not for what was put back


def test_what_was_seen_while_files_change_is_not_kept(good: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def changed_meanwhile(folder: Path, declaration: Any) -> Declared:
        found = really(folder, declaration)
        change(good / "zoo.py", "another")
        return found

    really, program = module.declared_of, (good / "zoo.py").read_text()
    monkeypatch.setattr(module, "declared_of", changed_meanwhile)
    with pytest.raises(ProblemError, match="its files are being changed; try again when that is done"):
        completed()
    monkeypatch.setattr(module, "declared_of", really)
    change(good / "zoo.py", program)
    assert completed().declared is not None


@pytest.mark.parametrize("folder", ["/opt/deck", "../deck", "deck/../.."])
def test_files_outside_of_the_folder_belong_to_no_version(good: Path, folder: str) -> None:
    path = good / "model.yaml"
    change(path, path.read_text().replace("kind: command", f"kind: command\n  folder: {folder}"))
    with pytest.raises(ProblemError) as caught:
        read_declaration(good)
    assert caught.value.issues == (
        Issue(
            "",
            "forward_model.folder must lie in the folder of the model, whose files are its version: "
            f"put the files there, or a link, not '{folder}'",
        ),
    )
