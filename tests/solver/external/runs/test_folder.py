"""Folders of runs: new, filled, kept as asked, and never a reason to fail."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from geoswarm.solver.external.errors import RunFailedError
from geoswarm.solver.external.runs.fingerprints import SAMPLED, fingerprint
from geoswarm.solver.external.runs.folder import MOST_FAILED, Keep, RunFolder, private_folder, tidy
from geoswarm.solver.external.runs.slots import slot
from geoswarm.solver.external.runs.sources import Sources


def names(folder: Path) -> list[str]:
    return sorted(one.name for one in folder.iterdir())


@pytest.mark.parametrize(
    ("keep", "failed", "left"),
    [
        ("none", True, None),
        ("none", False, None),
        ("failed", False, None),
        ("failed", True, "failed-"),
        ("all", False, "run-"),
        ("all", True, "failed-"),
    ],
)
def test_folders_are_kept_as_asked(keep: Keep, failed: bool, left: str | None, tmp_path: Path) -> None:
    folder = RunFolder(tmp_path)
    folder.write("sub/in.txt", "1\r\n")
    assert (folder.path / "sub" / "in.txt").read_bytes() == b"1\r\n"
    kept = folder.finish(keep, failed=failed)
    assert [one.startswith(left or "-") for one in names(tmp_path)] == ([True] if left else [])
    assert kept == (tmp_path / names(tmp_path)[0] if left else None)


def test_only_the_last_failed_folders_are_kept(tmp_path: Path) -> None:
    kept = [RunFolder(tmp_path).finish("failed", failed=True) for _ in range(MOST_FAILED + 5)]
    assert len(names(tmp_path)) == MOST_FAILED
    assert kept[-1] is not None
    assert kept[-1].exists()


def test_what_a_killed_process_has_left_is_a_failed_run(tmp_path: Path) -> None:
    code = "import os, sys; from pathlib import Path; from geoswarm.solver.external.runs.folder import RunFolder\n"
    code += "RunFolder(Path(sys.argv[1])); os._exit(9)"
    subprocess.run([sys.executable, "-c", code, str(tmp_path)], check=False)
    own = RunFolder(tmp_path)
    assert [one.split("-")[0] for one in names(tmp_path)] == ["running", "running"]
    tidy(tmp_path)
    assert [one.split("-")[0] for one in names(tmp_path)] == ["failed", "running"]
    assert own.path.exists()


def test_links_are_removed_and_not_what_they_lead_to(tmp_path: Path) -> None:
    (tmp_path / "mesh").mkdir()
    (tmp_path / "mesh" / "big.inc").write_text("nodes")
    runs = tmp_path / "runs"
    runs.mkdir()
    folder = RunFolder(runs)
    folder.place(tmp_path / "mesh", "mesh", link=True)
    folder.place(tmp_path / "mesh" / "big.inc", "copy.inc", link=False)
    assert (folder.path / "mesh").is_symlink()
    assert folder.finish("none", failed=False) is None
    assert (tmp_path / "mesh" / "big.inc").read_text() == "nodes"


AS_NOBODY = """
import os, sys
from pathlib import Path
from geoswarm.solver.external.runs import folder as module
module._DELETE_SECONDS = 0.0
parent = Path(sys.argv[1])
if os.getuid() == 0:  # rights of files stop other users only
    os.chown(parent, 65534, 65534)
    os.chdir(parent)
    os.setgid(65534)
    os.setuid(65534)
    parent = Path(".")
folder = module.RunFolder(parent)
(folder.path / "held").mkdir()
(folder.path / "held" / "file").touch()
(folder.path / "held").chmod(0)
assert folder.finish("none", failed=False) is None
print(folder.path.exists())
"""


def test_a_folder_that_cannot_be_deleted_is_left(tmp_path: Path) -> None:
    parent = tmp_path / "parent"
    parent.mkdir()
    done = subprocess.run([sys.executable, "-c", AS_NOBODY, str(parent)], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout.strip(), done.stderr) == (0, "True", "")


def test_the_folder_of_runs_is_private(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    assert private_folder("runs").stat().st_mode & 0o077 == 0
    base = private_folder("runs").parent
    (base / "runs").rmdir()
    base.rmdir()
    (tmp_path / "elsewhere").mkdir()
    base.symlink_to(tmp_path / "elsewhere")
    with pytest.raises(OSError, match="belongs to somebody else"):
        private_folder("runs")


def test_slots_are_shared_and_given_back(tmp_path: Path) -> None:
    with slot(tmp_path, 2) as first, slot(tmp_path, 2) as second:
        assert {first, second} == {0, 1}
    with slot(tmp_path, None) as first, slot(tmp_path, None) as second, slot(tmp_path, None) as third:
        assert [first, second, third] == [0, 1, 2]


def test_sources_are_read_once(tmp_path: Path) -> None:
    (tmp_path / "tool.py").write_text("one")
    (tmp_path / "tool.py").chmod(0o755)
    (tmp_path / "mesh.inc").write_text("mesh")
    versions = {name: fingerprint(tmp_path / name) for name in ("tool.py", "mesh.inc")}
    sources = Sources(tmp_path, ["tool.py"], ["mesh.inc"], versions)
    (tmp_path / "tool.py").write_text("two")
    (tmp_path / "runs").mkdir()
    folder = RunFolder(tmp_path / "runs")
    sources.place(folder)
    assert (folder.path / "tool.py").read_text() == "one"
    assert os.access(folder.path / "tool.py", os.X_OK)
    (tmp_path / "mesh.inc").write_text("another mesh")
    with pytest.raises(RunFailedError, match=r"mesh.inc in .* has changed since the calibration began"):
        sources.place(RunFolder(tmp_path / "runs"))
    with pytest.raises(ValueError, match=r"tool.py in .* has changed since the problem was read"):
        Sources(tmp_path, ["tool.py"], [], versions)


def test_fingerprints_of_large_files_are_of_samples(tmp_path: Path) -> None:
    path = tmp_path / "large"
    with path.open("wb") as file:
        file.truncate(SAMPLED + 1)
    first = fingerprint(path)
    with path.open("r+b") as file:
        file.seek(SAMPLED)
        file.write(b"x")
    assert fingerprint(path) != first
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "a").write_text("1")
    before = fingerprint(tmp_path / "folder")
    (tmp_path / "folder" / "a").rename(tmp_path / "folder" / "b")
    assert fingerprint(tmp_path / "folder") != before
