"""Where compiled kernels are kept: a folder that can be written to, and that no other user can write to."""

from __future__ import annotations

import ast
import logging
import os
import re
import shutil
import stat
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from geoswarm.solver.kernels import cache
from geoswarm.solver.kernels.cache import SOLVER, VARIABLE, alone, cache_folder, fingerprint, settle
from geoswarm.solver.laws.registry import BUILT_IN

LAW = re.compile(r"^ *from (geoswarm\.solver\.laws[.\w]*) import", re.MULTILINE)


@pytest.fixture
def places(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[dict[str, Path]]:
    """A package, a user's cache folder and a temporary folder of the test's own; ``settle`` begins anew."""
    found = {name: tmp_path / name for name in ("solver", "cache", "temporary")}
    for folder in found.values():
        folder.mkdir()
    monkeypatch.setattr(cache, "cache_folder", lambda: cache_folder(found["solver"]))
    monkeypatch.setattr(cache.tempfile, "tempdir", str(found["temporary"]))
    monkeypatch.setenv("XDG_CACHE_HOME", str(found["cache"]))
    monkeypatch.setenv(VARIABLE, "")
    settle.cache_clear()
    yield found
    settle.cache_clear()


def lock_up(folder: Path) -> None:
    """Make a folder unusable, for root, too: a file stands in its place."""
    if folder.is_dir():
        folder.rmdir()
    folder.write_text("", encoding="utf-8")


def test_a_change_moves_the_kernels_of_a_source_and_of_those_that_import_it(tmp_path: Path) -> None:
    def write(name: str, text: str) -> Path:
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True, parents=True)
        path.write_text(text, encoding="utf-8")
        return path

    law = write("laws/plastic/clay.py", "from geoswarm.solver.constitutive.plastic.flow import flow\n")
    other = write("laws/sand.py", "a = 1\n")
    body = write("fem/body.py", "from geoswarm.solver.constitutive.sums import add\n")
    flow = write("constitutive/plastic/flow.py", "from geoswarm.solver.constitutive.sums import add\n")
    write("constitutive/sums.py", "a = 1\n")
    before = [fingerprint(path, tmp_path) for path in (law, other, body)]
    assert len(set(before)) == 3
    flow.write_text(flow.read_text(encoding="utf-8") + "b = 2\n", encoding="utf-8")
    after = [fingerprint(path, tmp_path) for path in (law, other, body)]
    assert [one == two for one, two in zip(before, after, strict=True)] == [False, True, True]
    write("constitutive/sums.py", "a = 2\n")
    last = [fingerprint(path, tmp_path) for path in (law, other, body)]
    assert [one == two for one, two in zip(after, last, strict=True)] == [False, True, False]


def test_no_kernel_imports_a_law() -> None:
    allowed = {f"geoswarm.solver.laws.{name}" for name in ("base", "binary", "registry")}
    sources = [*(SOLVER / "fem").rglob("*.py"), *(SOLVER / "element_test").rglob("*.py")]
    imported = {name for path in sources for name in LAW.findall(path.read_text(encoding="utf-8"))}
    assert imported
    assert imported - allowed == set()


def test_every_import_of_a_kernel_names_the_file_that_it_is_in() -> None:
    """An import of a folder, of a module from it or by a relative name would hide a kernel from the fingerprints."""
    files = [path for folder in cache._KERNELS for path in (SOLVER / folder).rglob("*.py")]
    compiled = re.compile(r"^from geoswarm\.solver\.(kernels\.jit|laws\.binary) import", re.MULTILINE)
    sources = [path for path in files if compiled.search(path.read_text(encoding="utf-8"))]
    wrong = []
    for path in sources:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                wrong += [f"{path.name}: {name.name}" for name in node.names if name.name.startswith("geoswarm")]
            elif isinstance(node, ast.ImportFrom):
                module = f"{'.' * node.level}{node.module or ''}"
                file = SOLVER.joinpath(*module.split(".")[2:]).with_suffix(".py")
                if node.level or (module.split(".")[0] == "geoswarm" and not file.is_file()):
                    wrong.append(f"{path.name}: {module}")
    assert any(len(path.relative_to(SOLVER).parts) > 2 for path in sources)
    assert wrong == []


def test_the_fingerprint_of_a_law_knows_the_kernels_in_inner_folders(tmp_path: Path) -> None:
    solver = tmp_path / "solver"
    for folder in cache._KERNELS:
        shutil.copytree(SOLVER / folder, solver / folder, ignore=shutil.ignore_patterns("__pycache__"))
    laws = [solver.joinpath(*place.partition(":")[0].split(".")[2:]).with_suffix(".py") for place in BUILT_IN.values()]
    before = {path: fingerprint(path, solver) for path in laws}
    with (solver / "constitutive" / "hypoplasticity" / "intergranular_strain.py").open("a", encoding="utf-8") as file:
        file.write("changed = 1\n")
    changed = {path.relative_to(solver).as_posix() for path in laws if fingerprint(path, solver) != before[path]}
    assert changed == {"laws/hypoplasticity/clay.py", "laws/hypoplasticity/sand.py"}


def test_the_package_comes_first(places: dict[str, Path], caplog: pytest.LogCaptureFixture) -> None:
    assert settle() == cache_folder(places["solver"])
    assert caplog.records == []
    assert os.environ[VARIABLE] == ""


def test_the_folder_that_the_user_names_comes_before_all(
    places: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(VARIABLE, str(tmp_path / "named"))
    part = tmp_path / "named" / cache_folder(places["solver"]).name
    assert settle() == part
    assert not cache_folder(places["solver"]).exists()
    settle.cache_clear()
    monkeypatch.setenv(VARIABLE, str(part))  # as a process finds it that was started by one without a named folder
    assert settle() == part


def test_a_package_that_cannot_be_written_gives_way_to_the_users_cache(
    places: dict[str, Path], caplog: pytest.LogCaptureFixture
) -> None:
    lock_up(places["solver"] / "__pycache__")
    folder = places["cache"] / "geoswarm" / cache_folder(places["solver"]).name
    assert settle() == folder
    assert os.environ[VARIABLE] == str(folder)  # for the processes that are started
    assert caplog.records == []


def test_with_neither_a_temporary_folder_of_ones_own_is_told_in_one_line(
    places: dict[str, Path], caplog: pytest.LogCaptureFixture
) -> None:
    lock_up(places["solver"] / "__pycache__")
    lock_up(places["cache"])
    with caplog.at_level(logging.WARNING):
        folder = settle()
    assert folder is not None
    assert folder.is_relative_to(places["temporary"])
    assert stat.S_IMODE(folder.parent.stat().st_mode) == 0o700
    (record,) = caplog.records
    text = record.getMessage()
    assert "\n" not in text
    assert str(folder) in text
    assert "set NUMBA_CACHE_DIR" in text
    assert f"neither {cache_folder(places['solver'])} nor {places['cache']}" in text
    settle.cache_clear()  # as in a process that this one starts
    assert settle() == folder
    assert len(caplog.records) == 1


@pytest.mark.parametrize("how", ["open", "link"])
def test_a_temporary_folder_that_others_can_write_to_is_not_used(
    places: dict[str, Path], tmp_path: Path, how: str
) -> None:
    lock_up(places["solver"] / "__pycache__")
    lock_up(places["cache"])
    taken = places["temporary"] / f"geoswarm-{os.getuid()}"
    if how == "open":
        taken.mkdir()
        taken.chmod(0o777)
    else:
        (tmp_path / "elsewhere").mkdir()
        taken.symlink_to(tmp_path / "elsewhere")
    folder = settle()
    assert folder is not None
    assert folder.parent != taken
    assert stat.S_IMODE(folder.parent.stat().st_mode) == 0o700


def test_without_any_folder_it_goes_on_without(places: dict[str, Path], caplog: pytest.LogCaptureFixture) -> None:
    for folder in (places["solver"] / "__pycache__", places["cache"], places["temporary"]):
        lock_up(folder)
    assert settle() is None
    assert "every process recompiles the kernels" in caplog.text


def test_what_was_compiled_in_a_package_that_is_now_read_only_is_taken_over(
    places: dict[str, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    compiled = cache_folder(places["solver"])
    (compiled / "fem_1").mkdir(parents=True)
    (compiled / "fem_1" / "kernel.nbc").write_bytes(b"code")
    (compiled / "compiled-section").touch()
    writable = cache._writable
    monkeypatch.setattr(cache, "_writable", lambda folder: folder != compiled and writable(folder))
    folder = settle()
    assert folder is not None
    assert (folder / "fem_1" / "kernel.nbc").read_bytes() == b"code"
    assert (folder / "compiled-section").exists()
    assert [path.name for path in folder.parent.iterdir()] == [folder.name]


def test_one_compiles_while_others_wait(tmp_path: Path) -> None:
    program = (
        "import sys; from pathlib import Path; from geoswarm.solver.kernels.cache import alone\n"
        "with alone(Path(sys.argv[1])) as turn:\n"
        "    print('mine', flush=True); sys.stdin.read()\n"
    )
    command = [sys.executable, "-c", program, str(tmp_path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other:
        assert other.stdin is not None
        assert other.stdout is not None
        assert other.stdout.readline() == "mine\n"
        with alone(tmp_path, unwanted=lambda: True) as turn:
            assert not turn
        entered = threading.Event()

        def wait() -> None:
            with alone(tmp_path) as turn:
                assert turn
                entered.set()

        thread = threading.Thread(target=wait)
        thread.start()
        assert not entered.wait(0.3)
        other.stdin.close()
        assert entered.wait(60.0)
        thread.join()
