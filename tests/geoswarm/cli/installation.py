"""An installation of geoswarm as users have it: the wheel with nothing but what it asks for, away from the checkout."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

ROOT = Path(__file__).parents[3]
UV = (sys.executable, "-m", "uv")


@dataclass(frozen=True)
class Installation:
    """A virtual environment with the wheel and no extra."""

    folder: Path

    @cached_property
    def python(self) -> Path:
        return self.folder / "venv" / "bin" / "python"

    @cached_property
    def package(self) -> Path:
        """The folder ``geoswarm`` in site-packages."""
        (found,) = (self.folder / "venv" / "lib").glob("python*/site-packages/geoswarm")
        return found

    def environment(self, **more: str) -> dict[str, str]:
        """A user's environment: nothing that leads to the checkout, and one numerical thread."""
        kept = {name: value for name, value in os.environ.items() if name in ("PATH", "HOME", "LANG", "TMPDIR")}
        one = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
        return kept | one | more

    def geoswarm(self, *arguments: str, folder: Path, **environment: str) -> subprocess.CompletedProcess[str]:
        """Call the command line in ``folder``."""
        return subprocess.run(
            [self.python.with_name("geoswarm"), *arguments],
            cwd=folder,
            env=self.environment(**environment),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            check=False,
        )


def install(folder: Path, *extras: str) -> Installation:
    """Build the wheel and install it into a new virtual environment."""
    installation = Installation(folder)
    wheels = folder / "wheel"
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(wheels)]
    subprocess.run(build, cwd=ROOT, check=True, capture_output=True)
    (wheel,) = wheels.glob("*.whl")
    wanted = f"{wheel}[{','.join(extras)}]" if extras else str(wheel)
    for command in (
        ("venv", "--quiet", "--python", sys.executable, str(folder / "venv")),
        ("pip", "install", "--quiet", "--python", str(installation.python), wanted),
    ):
        done = subprocess.run([*UV, *command], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
    return installation
