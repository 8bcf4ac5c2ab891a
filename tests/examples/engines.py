"""Third-party programs that examples call: where they are, and calibrations with them through the command line.

``python -m tests.examples.engines`` installs those from PyPI beforehand.

::

    EngineError
    ├── MissingEngineError      a program is not installed; names the Debian package
    └── EngineInstallError      a program cannot be installed from PyPI; carries what uv said
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from examples.generate_reference_data import HERE
from geoswarm.cli import main

__all__ = [
    "KRATOS",
    "OPENGEOSYS",
    "EngineError",
    "EngineInstallError",
    "Identified",
    "MissingEngineError",
    "calibrated",
    "copy_of",
    "find_engine",
    "from_pypi",
    "install_from_pypi",
    "assert_identified",
    "assert_same_readings",
]

INSTALL_SECONDS = 240.0

OPENGEOSYS = ("ogs==6.5.9",)
KRATOS = tuple(
    f"{name}==10.4.4"
    for name in (
        "kratosgeomechanicsapplication",
        "kratosmultiphysics",
        "kratosstructuralmechanicsapplication",
        "kratoslinearsolversapplication",
    )
)


class EngineError(Exception):
    """Base of what goes wrong with a program of others."""


class MissingEngineError(EngineError):
    """A program that an example calls is not installed."""

    def __init__(self, program: str, package: str) -> None:
        super().__init__(
            f"the program {program!r} was not found; the tests of the examples run the real programs from Debian's "
            f"packages: run `make engines-all`, or `sudo apt-get install --no-install-recommends {package}`"
        )


class EngineInstallError(EngineError):
    """A program could not be installed from PyPI."""


@dataclass(frozen=True)
class Identified:
    """A parameter that was found: value and interval of 95 %."""

    value: float
    lower: float
    upper: float


def find_engine(program: str, package: str) -> Path:
    """Return a program of a Debian package; the test fails with words that say what to install where it is missing."""
    found = shutil.which(program)
    if found is None:
        pytest.fail(str(MissingEngineError(program, package)), pytrace=False)
    return Path(found)


def install_from_pypi(*requirements: str) -> Path:
    """Install packages into an environment of their own in the user's cache, once; return the folder of its programs.

    The environment has the name of the first of them.

    Raises
    ------
    EngineInstallError
        One cannot be installed.
    """
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "geoswarm-tests"
    environment = cache / requirements[0].replace("==", "-")
    ready = environment / "ready"
    if not ready.exists():
        uv = [sys.executable, "-m", "uv"]
        python = environment / "bin" / "python"
        for call in (
            ["venv", "--quiet", "--clear", "--python", sys.executable, str(environment)],
            ["pip", "install", "--quiet", "--python", str(python), *requirements],
        ):
            done = subprocess.run(
                [*uv, *call], capture_output=True, text=True, check=False, timeout=INSTALL_SECONDS, cwd=HERE
            )
            if done.returncode != 0:
                told = ", ".join(requirements)
                raise EngineInstallError(f"{told} could not be installed from PyPI into {environment}:\n{done.stderr}")
        ready.touch()
    return environment / "bin"


def from_pypi(*requirements: str) -> Path:
    """As :func:`install_from_pypi`; the test fails with words that say why where they cannot be had."""
    try:
        return install_from_pypi(*requirements)
    except EngineInstallError as error:
        pytest.fail(str(error), pytrace=False)


def copy_of(name: str, folder: Path) -> Path:
    """Copy an example; return its problem."""
    shutil.copytree(HERE / name, folder, ignore=shutil.ignore_patterns("__pycache__"))
    return folder / "problem.yaml"


def calibrated(problem: Path, output: Path, capsys: pytest.CaptureFixture[str]) -> dict[str, Identified]:
    """Run a problem, then its sensitivities at the optimum; return what was found by parameter."""
    capsys.readouterr()
    assert main(["run", str(problem), "--output", str(output)]) == 0, capsys.readouterr().err
    capsys.readouterr()
    assert main(["sensitivity", str(output), "--json"]) == 0, capsys.readouterr().err
    document = json.loads(capsys.readouterr().out)
    assert document["fit"]["kind"] == "describes", document["fit"]["sentence"]
    found = document["linearisation"]["parameters"]
    return {name: Identified(one["value"], *one["interval"]) for name, one in found.items()}


def assert_identified(
    problem: Path, output: Path, capsys: pytest.CaptureFixture[str], truth: Mapping[str, float], *, ratio: float
) -> None:
    """Assert that the values which made the readings lie in the intervals found, whose ends are this far apart."""
    found = calibrated(problem, output, capsys)
    assert found.keys() == truth.keys()
    for name, value in truth.items():
        assert found[name].lower < value < found[name].upper, name
        assert found[name].upper / found[name].lower < ratio, name


def assert_same_readings(name: str, made: Path, digit: float) -> None:
    """Assert that readings which were made again are those of the example, but for the last digit.

    They may differ there (``digit``, in the unit of the file) where the engine has another version or compiler.
    """
    there = sorted((HERE / name).glob("*.csv"))
    assert [path.name for path in there] == sorted(path.name for path in made.glob("*.csv"))
    for path in there:
        text = path.read_text(encoding="utf-8")
        assert text.startswith("# synthetic: not measured; ")
        given, again = (np.loadtxt(one, delimiter=",", skiprows=3) for one in (path, made / path.name))
        assert again[:, 0].tolist() == given[:, 0].tolist()
        assert again[:, 1] == pytest.approx(given[:, 1], abs=1.01 * digit)
    assert "synthetic" in (HERE / name / "README.md").read_text(encoding="utf-8").lower()


if __name__ == "__main__":
    for packages in (OPENGEOSYS, KRATOS):
        install_from_pypi(*packages)
