"""The signed list of models: genuine or refused, and no path in it leaves the folder of its model."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from pydantic import ValidationError

from geoswarm.solver.errors import SignedListError
from geoswarm.solver.registered.folders import version_of
from geoswarm.solver.registered.signed import ListedModel, SignedList, listed, new_secret, read_secret
from tests.integration.agents import line_model

SECRET, OTHER = b"s" * 32, b"t" * 32
GOOD = {"path": "model.yaml", "size": 3, "sha256": "a" * 64, "executable": False}


def of(*files: dict[str, Any]) -> dict[str, Any]:
    return {"version": "b" * 64, "files": list(files)}


def test_a_list_tells_what_was_signed(tmp_path: Path) -> None:
    folder = line_model(tmp_path) / "line"
    (folder / "run.sh").chmod(0o755)
    (folder / "mesh").mkdir()
    (folder / "mesh" / "coarse.inc").write_text("1 2 3\n")
    model = listed(folder)
    made = SignedList.signed({"line": model}, 1764042000, SECRET)
    found = SignedList.read(made.document(), SECRET)
    assert found.models == {"line": model}
    assert found.signed_at == 1764042000
    assert found.document() == made.document()
    assert model.version == version_of(folder)
    assert [(file.path, file.executable) for file in model.files] == [
        ("mesh/coarse.inc", False),
        ("model.yaml", False),
        ("run.sh", True),
        ("values.txt.in", False),
    ]


def test_who_passes_it_on_needs_no_secret() -> None:
    made = SignedList.signed({}, 1, SECRET)
    assert SignedList.read(made.document(), None).models == {}


def test_another_secret_or_a_changed_letter_is_refused() -> None:
    document = SignedList.signed({"line": ListedModel.model_validate(of(GOOD))}, 1, SECRET).document()
    with pytest.raises(SignedListError, match="its signature is not that of this secret"):
        SignedList.read(document, OTHER)
    changed = json.loads(document)
    changed["content"] = changed["content"].replace('"signed_at": 1', '"signed_at": 2')
    with pytest.raises(SignedListError, match="changed since"):
        SignedList.read(json.dumps(changed).encode(), SECRET)


@pytest.mark.parametrize("text", [b"", b"[]", b"{}", b"\xff", b'{"content": "x", "signature": "' + b"0" * 64 + b'"}'])
def test_what_is_no_list_is_reported(text: bytes) -> None:
    with pytest.raises(SignedListError, match="it is not a list from 'geoswarm models sign'"):
        SignedList.read(text, None)


@pytest.mark.parametrize(
    "path",
    [
        *(
            "../model.py",
            "a/../../b",
            "/etc/passwd",
            "a//b",
            "",
            "a/",
            "./a",
            "a/.",
            "..",
            "C:/x",
            "c:x",
            "a\\b",
            "..\\b",
        ),
        *(
            "\\\\server\\share",
            "a\x00b",
            "a\nb",
            "NUL",
            "con.txt",
            "a/COM1",
            "lpt9.log",
            "end.",
            "end ",
            "a/.. /b",
            "a" * 201,
        ),
        *("file:stream", "what?", "a/" * 201 + "b"),
    ],
)
def test_no_path_leads_out_of_the_folder(path: str) -> None:
    with pytest.raises(ValidationError, match=r"accepted|at most 400"):
        ListedModel.model_validate(of(GOOD, GOOD | {"path": path}))


@pytest.mark.parametrize(
    ("files", "why"),
    [
        ([GOOD, GOOD | {"path": "Model.yaml"}], "one file"),
        ([GOOD, GOOD], "one file"),
        ([GOOD, GOOD | {"path": "model.yaml/x"}], "lies below a file"),
        ([GOOD | {"path": "run.sh"}], "no model.yaml"),
        ([], "at least 1"),
        ([GOOD | {"size": -1}], "greater than or equal to 0"),
        ([GOOD | {"sha256": "A" * 64}], "pattern"),
    ],
)
def test_files_that_collide_or_lack_are_refused(files: list[dict[str, Any]], why: str) -> None:
    with pytest.raises(ValidationError, match=why):
        ListedModel.model_validate(of(*files))


def test_a_file_name_that_windows_refuses_is_told_when_it_is_signed(tmp_path: Path) -> None:
    folder = line_model(tmp_path) / "line"
    (folder / "time:10.csv").write_text("1\n")
    with pytest.raises(SignedListError, match=r"model 'line' cannot be handed out: .*'time:10.csv' is not a path"):
        listed(folder)


def test_secrets_are_long(tmp_path: Path) -> None:
    file = tmp_path / "secret"
    file.write_text(new_secret() + "\n")
    assert len(read_secret(file)) == 64
    for text in ("short", "a" * 5000, "two words " * 5, ""):
        file.write_text(text)
        with pytest.raises(SignedListError, match="one word of 32 to 4096 ASCII characters"):
            read_secret(file)
