"""Files are read once for their fingerprint, and each change of them is seen."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from geoswarm.solver.external.runs import fingerprints
from geoswarm.solver.external.runs.fingerprints import fingerprint, settled


@pytest.fixture
def read(monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """The files that were read; they are settled at once."""
    found: list[Path] = []
    really: Callable[[Path], str] = fingerprints._of_file

    def counted(path: Path) -> str:
        found.append(path)
        return really(path)

    monkeypatch.setattr(fingerprints, "_of_file", counted)
    monkeypatch.setattr(fingerprints, "SETTLED_SECONDS", -3600.0)
    return found


def change(path: Path, text: str) -> None:
    """Write another text until the system tells another time of change: that has some milliseconds."""
    before = path.stat().st_ctime_ns
    while path.stat().st_ctime_ns == before:
        path.write_text(text)


def test_a_file_that_has_not_changed_is_read_once(tmp_path: Path, read: list[Path]) -> None:
    mesh = tmp_path / "mesh.inc"
    mesh.write_text("1 2 3\n")
    (tmp_path / "link.inc").symlink_to(mesh)
    first = fingerprint(mesh)
    with ThreadPoolExecutor(4) as threads:
        assert set(threads.map(fingerprint, [mesh] * 40)) == {first}
    assert read == [mesh]
    assert fingerprint(tmp_path / "link.inc") == first


def test_a_change_is_seen_though_size_and_time_were_put_back(tmp_path: Path, read: list[Path]) -> None:
    mesh = tmp_path / "mesh.inc"
    mesh.write_text("1 2 3\n")
    before, found = mesh.stat(), fingerprint(mesh)
    change(mesh, "1 2 4\n")
    os.utime(mesh, ns=(before.st_atime_ns, before.st_mtime_ns))
    assert mesh.stat().st_mtime_ns == before.st_mtime_ns
    assert fingerprint(mesh) != found
    change(mesh, "1 2 3\n")
    assert fingerprint(mesh) == found
    other = tmp_path / "other.inc"
    other.write_text("1 2 5\n")
    other.replace(mesh)
    assert fingerprint(mesh) != found
    assert read == [mesh] * 4


def test_files_of_a_folder_are_read_when_they_are_new(tmp_path: Path, read: list[Path]) -> None:
    deck = tmp_path / "deck"
    (deck / "sub").mkdir(parents=True)
    (deck / "a").write_text("a")
    (deck / "sub" / "b").write_text("b")
    first = fingerprint(deck)
    change(deck / "a", "c")
    assert fingerprint(deck) != first
    change(deck / "a", "a")
    assert fingerprint(deck) == first
    assert [one.name for one in read] == ["a", "b", "a", "a"]


def test_a_file_of_just_now_is_read_each_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It could change again within the same tick of the file system's clock."""
    path = tmp_path / "a"
    path.write_text("a")
    assert settled(path) is None
    monkeypatch.setattr(fingerprints, "SETTLED_SECONDS", -3600.0)
    found = settled(path)
    assert found is not None
    assert (found.size, found.number) == (1, path.stat().st_ino)


def test_what_is_kept_is_bounded() -> None:
    most = fingerprints._kept.cache_parameters()["maxsize"]
    assert isinstance(most, int)
    assert most > fingerprints.MOST_FILES
