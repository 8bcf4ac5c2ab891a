"""The synchronous client is what scripts/generate_client.py makes of the asynchronous one."""

from __future__ import annotations

import inspect
import shutil
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

from geoswarm import AsyncClient
from tests.contracts.repository import ROOT
from tests.variants import variants

SCRIPT = Path("scripts/generate_client.py")
WRITTEN = Path("geoswarm/client/_async")
GENERATED = Path("geoswarm/client/_sync")


def generate(root: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    call = [sys.executable, SCRIPT, *arguments]
    return subprocess.run(call, cwd=root, capture_output=True, text=True, check=False)


def generated(root: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in (root / GENERATED).glob("*.py")}


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """What the script reads and writes, in a folder of its own."""
    for folder in (WRITTEN, GENERATED):
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / SCRIPT).parent.mkdir()
    shutil.copy(ROOT / SCRIPT, tmp_path / SCRIPT)
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    return tmp_path


def test_the_synchronous_client_is_up_to_date() -> None:
    done = generate(ROOT, "--check")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_every_generated_file_says_so_first() -> None:
    for path in (ROOT / GENERATED).glob("*.py"):
        first = path.read_text(encoding="utf-8").splitlines()[0]
        assert first.startswith(f"# Generated from {WRITTEN / path.name} by {SCRIPT};")


# test_changed_missing_and_foreign_files_are_told_and_put_right makes missing files
@pytest.mark.slow
def test_everything_is_made_anew_where_there_is_nothing(copy: Path) -> None:
    shutil.rmtree(copy / GENERATED)
    assert generate(copy).returncode == 0
    assert generated(copy) == generated(ROOT)


def test_changed_missing_and_foreign_files_are_told_and_put_right(copy: Path) -> None:
    (copy / GENERATED / "foreign.py").write_text('"""Made by nobody."""\n')
    (copy / GENERATED / "jobs.py").unlink()
    with (copy / GENERATED / "client.py").open("a") as file:
        file.write("# a change in the wrong place\n")
    before = generated(copy)
    done = generate(copy, "--check")
    assert done.returncode == 1
    assert done.stderr.splitlines() == [
        f"{GENERATED}/client.py: is not what {SCRIPT} makes of {WRITTEN}/client.py",
        f"{GENERATED}/jobs.py: is not what {SCRIPT} makes of {WRITTEN}/jobs.py",
        f"{GENERATED}/foreign.py: there is no {WRITTEN}/foreign.py that it could be made of",
        f"write changes into {WRITTEN} and run `make format`, which renews {GENERATED}",
    ]
    assert generated(copy) == before
    assert generate(copy).returncode == 0
    assert generated(copy) == generated(ROOT)


# test_changed_missing_and_foreign_files_are_told_and_put_right tells what is out of date
@pytest.mark.slow
def test_a_change_of_the_asynchronous_client_asks_for_a_renewal(copy: Path) -> None:
    with (copy / WRITTEN / "service.py").open("a") as file:
        file.write("\n\nasync def nap(self: AsyncConnection) -> None:\n    await self._send(await other(self))\n")
    assert generate(copy, "--check").returncode == 1
    assert generate(copy).returncode == 0
    text = (copy / GENERATED / "service.py").read_text()
    assert text.endswith("\n\ndef nap(self: Connection) -> None:\n    self._send(other(self))\n")


@pytest.mark.parametrize(
    ("line", "word"),
    variants([("await asyncio.gather(first, second)", "asyncio"), ("anext(pages)", "anext")], {"anext(pages)"}),
)
def test_what_no_rule_speaks_of_is_refused_with_its_place(copy: Path, line: str, word: str) -> None:
    path = copy / WRITTEN / "service.py"
    path.write_text(f"{path.read_text()}{line}\n")
    place = f"{WRITTEN}/service.py:{len(path.read_text().splitlines())}"
    for arguments in ((), ("--check",)):
        done = generate(copy, *arguments)
        assert done.returncode == 1
        assert done.stderr == f"{place}: no rule of {SCRIPT} says what becomes of {word!r}\n"


def test_an_unknown_argument_is_refused() -> None:
    done = generate(ROOT, "--chek")
    assert (done.returncode, done.stderr) == (2, "usage: generate_client.py [--check], not '--chek'\n")


def test_every_function_of_the_modules_is_a_method() -> None:
    methods = set(vars(AsyncClient).values())
    for name in ("analysis", "drafts", "following", "jobs", "reports", "results", "service"):
        module = import_module(f"geoswarm.client._async.{name}")
        functions = inspect.getmembers(module, lambda member: inspect.isfunction(member))
        own = {found for key, found in functions if found.__module__ == module.__name__ and not key.startswith("_")}
        assert own <= methods
        assert {found.__name__ for found in own} == set(module.__all__)
