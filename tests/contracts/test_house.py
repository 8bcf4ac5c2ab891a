"""Rules of the house that no linter checks (CONTRIBUTING.md)."""

from __future__ import annotations

import ast
import re
import subprocess
from collections import Counter
from importlib import import_module
from pathlib import Path

import pytest

from tests.conftest import LENGTHY, STARTING
from tests.contracts.repository import PACKAGES, ROOT, module_name, python_files

LONGEST_FILE = 420
MOST_MODULES = 16
FEW = 6
SOURCES = python_files(*PACKAGES)
TESTS = python_files("tests")


def label(path: Path) -> str:
    return str(path.relative_to(ROOT))


def test_files_are_short() -> None:
    lengths = {label(path): len(path.read_text(encoding="utf-8").splitlines()) for path in [*SOURCES, *TESTS]}
    assert {name: length for name, length in lengths.items() if length > LONGEST_FILE} == {}


def test_a_folder_holds_as_many_modules_as_a_reader_can_survey() -> None:
    """Inner rooms: docs/decisions/0021-inner-rooms.md."""
    held = Counter(
        label(path.parent) for path in SOURCES if path.name != "__init__.py" and "versions" not in path.parts
    )
    assert {folder: count for folder, count in held.items() if count > MOST_MODULES} == {}


def test_every_module_says_what_it_is_for() -> None:
    nameless = [label(path) for path in SOURCES if not ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")))]
    assert nameless == []


def test_the_table_of_a_package_names_its_modules() -> None:
    """Those of few modules need none; that of ``geoswarm`` teaches its use, and migrations are numbered."""
    for package in (path for path in SOURCES if path.name == "__init__.py"):
        folder, docstring = package.parent, ast.get_docstring(ast.parse(package.read_text(encoding="utf-8"))) or ""
        modules = [path.stem for path in SOURCES if path.parent == folder and path != package]
        modules += [path.parent.name for path in SOURCES if path.name == package.name and path.parent.parent == folder]
        named = re.findall(r"^``(\w+)``  ", docstring, re.MULTILINE)
        if named or (len(modules) > FEW and folder.name not in ("geoswarm", "versions")):
            assert sorted(named) == sorted(modules), label(folder)


def test_exported_names_exist_once() -> None:
    wrong = []
    for path in SOURCES:
        if "migrations" in path.parts or path.name == "__main__.py":
            continue
        module = import_module(module_name(path))
        names = list(getattr(module, "__all__", []))
        if len(names) != len(set(names)):
            wrong.append(f"{module.__name__}: a name twice")
        wrong += [f"{module.__name__}.{name}" for name in names if not hasattr(module, name)]
    assert wrong == []


def test_tests_are_packages_at_every_level() -> None:
    folders = {path.parent for path in TESTS}
    assert sorted(label(folder) for folder in folders if not (folder / "__init__.py").exists()) == []


def test_nothing_is_skipped_expected_to_fail_or_left_for_later() -> None:
    words = re.compile(
        r"pytest\.(skip|xfail|importorskip)|mark\.(skip|skipif|xfail)\b|raise NotImplementedError|\b(TODO|FIXME|XXX)\b"
    )
    files = [path for path in [*SOURCES, *TESTS] if path != Path(__file__)]
    assert [label(path) for path in files if words.search(path.read_text(encoding="utf-8"))] == []


def test_every_test_asserts() -> None:
    silent = []
    for path in TESTS:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and node.name.startswith("test_"):
                text = ast.unparse(node)
                if not re.search(
                    r"\bassert|\b(assert_|check_|expect|wait_for|wait_until)\w*\(|pytest\.(raises|warns|fail)", text
                ):
                    silent.append(f"{label(path)}::{node.name}")
    assert silent == []


@pytest.mark.parametrize("script", [*(ROOT / "scripts").glob("*.sh"), ROOT / ".ci" / "run"], ids=label)
def test_shell_scripts_are_executable_and_strict(script: Path) -> None:
    assert script.stat().st_mode & 0o111
    assert "set -euo pipefail" in script.read_text(encoding="utf-8")
    assert subprocess.run(["bash", "-n", str(script)], capture_output=True, check=False).returncode == 0


def test_make_help_lists_the_commands() -> None:
    done = subprocess.run(["make", "help"], cwd=ROOT, capture_output=True, text=True, check=True)
    listed = re.findall(r"^  make ([a-z-]+) ", done.stdout, flags=re.MULTILINE)
    whole = "help setup servers engines demo check docs format test test-fast test-all lock bench clean"
    assert listed == whole.split()


def test_make_demo_compiles_nothing_ahead() -> None:
    """The demo itself compiles what it needs; all kernels take some ten times as long."""

    def commands(target: str) -> str:
        asked = ["make", "--dry-run", "--what-if", "solver/warm.py", target]
        return subprocess.run(asked, cwd=ROOT, capture_output=True, text=True, check=True).stdout

    assert "geoswarm.solver.warm" in commands("setup")
    assert "geoswarm.solver.warm" not in commands("demo")
    assert "geoswarm demo" in commands("demo")


def test_files_that_are_left_out_of_the_fast_tests_exist() -> None:
    assert [name for name in sorted(STARTING | LENGTHY) if not (ROOT / "tests" / name).is_file()] == []
