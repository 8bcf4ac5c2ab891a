"""Builds geoswarm and installs it as a user has it: apart from the checkout."""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from tests.contracts.repository import ROOT

__all__ = ["Installation", "build", "install", "install_beside", "packages_in", "uv"]


@dataclass(frozen=True)
class Installation:
    """A virtual environment with geoswarm from a wheel."""

    folder: Path

    @property
    def python(self) -> Path:
        return self.folder / "bin" / "python"

    @property
    def script(self) -> Path:
        """The console script."""
        return self.folder / "bin" / "geoswarm"

    @property
    def packages(self) -> Path:
        """Its site-packages."""
        return Path(sysconfig.get_path("purelib", "venv", {"base": str(self.folder)}))

    def environment(self, **more: str) -> dict[str, str]:
        """A user's environment: nothing that leads to the checkout, and one numerical thread."""
        kept = {name: value for name, value in os.environ.items() if name in ("PATH", "HOME", "LANG", "TMPDIR")}
        one = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
        return kept | one | more

    def geoswarm(self, *arguments: str, folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
        """Call the command line in ``folder``."""
        return subprocess.run(
            [self.script, *arguments],
            cwd=folder,
            env=self.environment(**environment),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            check=False,
        )


def uv(*arguments: str | Path, variables: Mapping[str, str] | None = None) -> str:
    """Call uv in the repository; return what it printed."""
    command = [sys.executable, "-m", "uv", *map(str, arguments)]
    done = subprocess.run(command, cwd=ROOT, env=variables, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def build(target: Literal["wheel", "sdist"], source: Path, folder: Path) -> Path:
    """Build as pip would; return what was made. Raises CalledProcessError with the output as text."""
    command = [sys.executable, "-m", "hatchling", "build", "-t", target, "-d", str(folder)]
    # Without its own time stamps a build from the same files gives the same archive.
    environment = {**os.environ, "SOURCE_DATE_EPOCH": "1580601600"}
    subprocess.run(command, cwd=source, env=environment, check=True, capture_output=True, text=True)
    (made,) = folder.glob("*.whl" if target == "wheel" else "*.tar.gz")
    return made


def install(folder: Path, *extras: str) -> Installation:
    """Build the wheel, and install it with what it needs into the new environment ``folder / "venv"``."""
    installation = Installation(folder / "venv")
    wheel = build("wheel", ROOT, folder / "wheel")
    uv("venv", "--quiet", "--python", sys.executable, installation.folder)
    wanted = f"{wheel}[{','.join(extras)}]" if extras else str(wheel)
    uv("pip", "install", "--quiet", "--python", installation.python, wanted)
    return installation


def install_beside(folder: Path) -> Installation:
    """Build the wheel, and install it into a new environment that borrows the dependencies of the present one.

    A line with a folder in a .pth file takes in its packages, but not its .pth files, so the checkout, which is
    installed there in editable form, stays out of reach.
    """
    installation = Installation(folder / "venv")
    wheel = build("wheel", ROOT, folder / "wheel")
    uv("venv", "--quiet", "--python", sys.executable, installation.folder)
    uv("pip", "install", "--quiet", "--python", installation.python, "--no-deps", "--offline", wheel)
    borrowed = sysconfig.get_path("purelib")
    (installation.packages / "borrowed.pth").write_text(f"{borrowed}\n", encoding="utf-8")
    return installation


def packages_in(folder: Path, *requirements: str, dependencies: bool = True) -> Path:
    """Install packages into a folder of their own, for ``PYTHONPATH``; return it."""
    more = () if dependencies else ("--no-deps",)
    uv("pip", "install", "--quiet", "--python", sys.executable, "--target", folder, *more, *requirements)
    return folder
