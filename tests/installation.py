"""Builds geoswarm and installs it as a user has it: apart from the checkout."""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
import venv
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

__all__ = ["Installation", "build", "install", "install_beside"]


@dataclass(frozen=True)
class Installation:
    """A virtual environment with geoswarm from a wheel."""

    folder: Path

    @property
    def python(self) -> Path:
        return self.folder / "bin" / "python"

    @property
    def geoswarm(self) -> Path:
        """The console script."""
        return self.folder / "bin" / "geoswarm"

    @property
    def packages(self) -> Path:
        """Its site-packages."""
        return Path(sysconfig.get_path("purelib", "venv", {"base": str(self.folder)}))


def build(target: Literal["wheel", "sdist"], source: Path, folder: Path) -> Path:
    """Build as pip would; return what was made. Raises CalledProcessError with the output as text."""
    command = [sys.executable, "-m", "hatchling", "build", "-t", target, "-d", str(folder)]
    # Without its own time stamps a build from the same files gives the same archive.
    environment = {**os.environ, "SOURCE_DATE_EPOCH": "1580601600"}
    subprocess.run(command, cwd=source, env=environment, check=True, capture_output=True, text=True)
    (made,) = folder.glob("*.whl" if target == "wheel" else "*.tar.gz")
    return made


def install(wheel: Path, folder: Path, *, extras: str = "", python: str = sys.executable) -> Installation:
    """Install a wheel and what it needs with pip into a new environment; ``extras`` as pip takes them."""
    subprocess.run([python, "-m", "venv", str(folder)], check=True)
    installation = Installation(folder)
    wanted = f"{wheel}[{extras}]" if extras else str(wheel)
    pip = [str(installation.python), "-m", "pip", "--disable-pip-version-check", "install", "--quiet", wanted]
    subprocess.run(pip, check=True, capture_output=True, text=True)
    return installation


def install_beside(wheel: Path, folder: Path) -> Installation:
    """Install a wheel into a new environment that borrows the dependencies of the present one.

    A line with a folder in a .pth file takes in its packages, but not its .pth files, so the checkout, which is
    installed there in editable form, stays out of reach.
    """
    venv.create(folder, with_pip=False)
    installation = Installation(folder)
    pip = [sys.executable, "-m", "pip", "--python", str(installation.python), "--disable-pip-version-check"]
    subprocess.run([*pip, "install", "--quiet", "--no-deps", "--no-index", str(wheel)], check=True, capture_output=True)
    borrowed = sysconfig.get_path("purelib")
    (installation.packages / "borrowed.pth").write_text(f"{borrowed}\n", encoding="utf-8")
    return installation
